// What a trainer asks of a cut besides force: how warm it got, how near to pulp, nerve and neighbouring teeth. It
// reads what the step puts out and never changes it.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/monitor/keep_out.h"
#include "sim/monitor/tool_heat.h"
#include "sim/step/step.h"

namespace kerf {

/// The name of an object beside the first in reports, tables and messages: "beside_1" is the second of a session.
std::string neighbourId(std::size_t object);

/// Follows one tool in one object, and beside others. Belongs to the thread that ticks it.
///
/// The distance to a neighbour is that to its shape as loaded, where it stands now. What was cut off it is counted and
/// does not make the distance larger: a tool that goes back through a nick is in the neighbour again. Material put onto
/// it does not make the distance smaller.
class Monitor {
 public:
  /// Keep-out structures are those of pulp and nerve canal that the first object has, then every other object as a
  /// whole.
  /// @param objects  at least one, in the order of those of the session: the first is the one to be cut.
  /// @param source  heatSource() of the tool.
  /// @cost seconds for a mandible's canals, or a neighbouring tooth; at most 200 MB for each structure, see KeepOut.
  static Expected<Monitor> make(const LoadedObjects& objects, const ToolModel& tool, const HeatSource& source = {},
                                const HeatSettings& settings = {});

  struct Structure {
    Material material = Material::kNone;  ///< of a neighbour kNone
    std::string id;                       ///< "pulp", "nerve_canal", "beside_1" of the second object, "beside_2", ...
    std::size_t object = 0;               ///< which it belongs to, or is
    /// Of the cutting part now, mm; negative: in the structure. While the tool touches, the tissue left.
    double distance = 0;
    bool is_far = true;          ///< farther than the field reaches; then `distance` is that reach
    double least = 1e9;          ///< ever, mm
    std::uint64_t ticks_in = 0;  ///< ticks in which the tool was in it and something was cut
    /// Of a neighbour: ticks in which any part of the tool touched it, neck and shank too.
    std::uint64_t ticks_touched = 0;
    /// Of a neighbour: what was cut off it; of a piece, since the piece came off.
    double removed_mm3 = 0;
  };
  /// After step(). @param objects  those of the session now: pieces may have come behind those it began with.
  /// @pre no fewer than make() had.   @rt safe. @cost about 6 us a structure, and as much for the heat.
  void tick(const DeviceSample& sample, const StepOutput& output, std::span<const CutObject> objects) noexcept;

  double temperature() const noexcept { return heat_.temperature(); }    ///< under the tool, C
  double pulpRise() const noexcept { return heat().rise(Heat::kPulp); }  ///< K, where it is warmest
  double hottest() const noexcept { return hottest_; }                   ///< C, ever
  double mostPulpRise() const noexcept { return most_pulp_rise_; }       ///< K, ever
  double mostNerveRise() const noexcept { return most_nerve_rise_; }     ///< K, ever, of nerve canals
  const Heat& heat() const noexcept { return heat_.heat(); }
  double area() const noexcept {
    return heat_.area();
  }  ///< of the cutting surface close to tissue, mm^2, in the last tick
  const HeatAlarms& alarms() const noexcept { return heat().alarms(); }
  const std::vector<Structure>& structures() const noexcept { return structures_; }
  /// Between the points of the tool whose distance is read, mm: ToolSamples::spacing().
  double spacing() const noexcept { return samples_.spacing(); }

 private:
  Monitor(const ToolModel& tool, const HeatSource& source, const HeatSettings& settings);

  ToolSamples samples_;
  HeatingTool tool_;
  ToolHeat heat_;
  std::vector<Structure> structures_;
  std::vector<std::shared_ptr<const KeepOut>> fields_;  // of the structures
  double hottest_ = kBodyCelsius, most_pulp_rise_ = 0, most_nerve_rise_ = 0;
};

}  // namespace kerf
