// Measures of a cut besides force, for training: temperature, and distance to pulp, nerve and neighbouring teeth. It
// reads the step's output and never changes it.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/monitor/keep_out.h"
#include "sim/monitor/tool_heat.h"
#include "sim/step/step.h"

namespace kerf {

/// The name of a neighbour in reports, tables and messages: "beside_1" is the second object of a session.
std::string neighbourId(std::size_t object);

/// Follows one tool in one object and its neighbours. For the thread that ticks it.
///
/// The distance to a neighbour is that to its shape as loaded, at its current pose. Volume removed from it is counted
/// and does not increase the distance: a tool that goes back through a nick is in the neighbour again. Added material
/// does not decrease the distance.
class Monitor {
 public:
  /// Keep-out structures are pulp and nerve canal of the first object, if present, then every other object as a whole.
  /// @param objects  at least one, in the order of the session's: the first is the object to cut.
  /// @param source  heatSource() of the tool.
  /// @cost seconds for a mandible's canals, or a neighbouring tooth; at most 200 MB for each structure, see KeepOut.
  static Expected<Monitor> make(const LoadedObjects& objects, const ToolModel& tool, const HeatSource& source = {},
                                const HeatSettings& settings = {});

  struct Structure {
    Material material = Material::kNone;  ///< kNone for a neighbour
    std::string id;                       ///< "pulp", "nerve_canal", "beside_1" of the second object, "beside_2", ...
    std::size_t object = 0;               ///< object that it belongs to, or is
    /// Distance of the cutting part now, mm; negative: in the structure. In contact it is the thickness of tissue left.
    double distance = 0;
    bool is_far = true;          ///< farther than the field reaches; then `distance` is that reach
    double least = 1e9;          ///< ever, mm
    std::uint64_t ticks_in = 0;  ///< ticks in which the tool was in the structure and cut
    /// For a neighbour: ticks in which any part of the tool touched it, neck and shank included.
    std::uint64_t ticks_touched = 0;
    /// For a neighbour: removed volume; for a piece, since it came off.
    double removed_mm3 = 0;
  };
  /// After step(). @param objects  current objects of the session: pieces may follow those it began with.
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
  /// Spacing of the tool's sample points, mm: ToolSamples::spacing().
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
