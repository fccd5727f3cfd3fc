// The temperature of a running session, for the haptic thread: one tool after the other heats one object.
//
// What a tick needs of a tool takes tens of milliseconds to make: the window's thread makes it when the tool is taken,
// and hands it over. Until then, and without it, nothing is known.
#pragma once

#include <array>
#include <atomic>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "sim/monitor/structures.h"
#include "sim/monitor/tool_heat.h"

namespace kerf {

/// Where nothing has been cut, all is as warm as the body.
struct HeatReport {
  bool is_known = false;          ///< of the tool in use
  double surface = kBodyCelsius;  ///< of the tissue under the tool, C
  double pulp_rise = 0;           ///< K above the body's, the warmest of it that the tool came near
  double nerve_rise = 0;          ///< the same of nerve canals
  HeatAlarms alarms;
  /// From the cutting part of the tool to each of Structures::all(), mm. Not a number: farther than is measured.
  std::array<double, 2> kept_mm{kFarOff, kFarOff};
  static constexpr double kFarOff = std::numeric_limits<double>::quiet_NaN();
};

class LiveHeat {
 public:
  /// @param tools  of the model; kept by reference.
  explicit LiveHeat(std::span<const ToolModel> tools) : tools_(tools), ready_(tools.size()) {}

  // One thread, not the haptic one.

  /// Pulp and nerve canals of the first object, whose temperature and distance are followed. Before the first tick.
  void watch(std::shared_ptr<const Structures> structures) { structures_ = std::move(structures); }
  const Structures* structures() const noexcept { return structures_.get(); }
  /// From now on this tool heats. A second time, or no tool of the model: nothing.   @cost  some ms.
  void add(std::size_t tool, const ToolSamples& samples, const HeatSource& source);

  // The haptic thread.

  /// After step(). @rt   @cost  6 us, and as much for each structure.
  void tick(std::size_t tool, const DeviceSample& sample, const StepOutput& output,
            std::span<const CutObject> objects) noexcept;
  const HeatReport& report() const noexcept { return report_; }

  /// How warm everything is now: a replay that goes back begins with it again. A value; tools that were added stay.
  struct Memory {
    ToolHeat heat;
    HeatReport report;
    std::vector<std::size_t> turns;  ///< of the tools, in the order in which they were added
  };
  Memory memory() const;
  void restore(const Memory& memory);

 private:
  struct Tool {
    ToolSamples samples;
    HeatingTool heating;
  };

  std::span<const ToolModel> tools_;
  std::vector<std::unique_ptr<Tool>> made_;  // by add(), for good
  std::vector<std::atomic<Tool*>> ready_;    // one a tool; null: not made yet
  std::shared_ptr<const Structures> structures_;
  ToolHeat heat_;
  HeatReport report_;
};

}  // namespace kerf
