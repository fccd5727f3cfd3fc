// The temperature of a running session, for the haptic thread: one tool after the other heats one object.
//
// The data of a tool take tens of milliseconds to make: the window's thread makes them when the user takes the tool,
// and hands them over. Without them the temperature is unknown.
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

/// Uncut places are at body temperature.
struct HeatReport {
  bool is_known = false;          ///< of the tool in use
  double surface = kBodyCelsius;  ///< of the tissue under the tool, C
  double pulp_rise = 0;           ///< K above the body's, the warmest place near which the tool came
  double nerve_rise = 0;          ///< the same for nerve canals
  HeatAlarms alarms;
  /// From the cutting part of the tool to each of Structures::all(), mm. NaN: beyond the measured range.
  std::array<double, 2> kept_mm{kFarOff, kFarOff};
  static constexpr double kFarOff = std::numeric_limits<double>::quiet_NaN();
};

class LiveHeat {
 public:
  /// @param tools  of the model; kept by reference.
  explicit LiveHeat(std::span<const ToolModel> tools) : tools_(tools), ready_(tools.size()) {}

  // One thread, not the haptic one.

  /// Pulp and nerve canals of the first object, for temperature and distance. Before the first tick.
  void watch(std::shared_ptr<const Structures> structures) { structures_ = std::move(structures); }
  const Structures* structures() const noexcept { return structures_.get(); }
  /// From now on this tool heats. A second call for a tool, or a tool that is not in the model: no effect.   @cost some
  /// ms.
  void add(std::size_t tool, const ToolSamples& samples, const HeatSource& source);

  // The haptic thread.

  /// After step(). @rt   @cost  6 us, and as much for each structure.
  void tick(std::size_t tool, const DeviceSample& sample, const StepOutput& output,
            std::span<const CutObject> objects) noexcept;
  const HeatReport& report() const noexcept { return report_; }

  /// Thermal state: a replay that goes back restores it. A value; added tools stay.
  struct Memory {
    ToolHeat heat;
    HeatReport report;
    std::vector<std::size_t> turns;  ///< of the tools, in the order of add()
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
