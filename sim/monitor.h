// What a trainer asks of a cut beside force: how warm it got, how near to pulp and nerve. Beside the step, never in it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim/heat.h"
#include "sim/keep_out.h"
#include "sim/step.h"

namespace kerf {

/// Follows one tool in one object. Belongs to the thread that ticks it.
class Monitor {
 public:
  /// Keep-out structures are those of pulp and nerve canal that the object has. @cost seconds for a mandible.
  static Expected<Monitor> make(const BakedObject& object, const ToolModel& tool);

  struct Structure {
    Material material;
    std::string id;              ///< "pulp"
    double distance = 0;         ///< of the tool now, mm; negative: in it. The tissue left while the tool touches
    bool is_far = true;          ///< farther than the field reaches; then `distance` is that
    double least = 1e9;          ///< ever, mm
    std::uint64_t ticks_in = 0;  ///< ticks the tool was in it while something was cut
  };
  /// After step(). @rt
  void tick(const DeviceSample& sample, const StepOutput& output, const Rigid3& T_world_object) noexcept;

  double temperature() const noexcept { return kBodyCelsius + heat_.surfaceRise(); }  ///< under the tool, C
  double pulpRise() const noexcept { return heat_.pulpRise(); }                       ///< K
  double hottest() const noexcept { return hottest_; }                                ///< C, ever
  double mostPulpRise() const noexcept { return most_pulp_rise_; }
  const HeatAlarms& alarms() const noexcept { return heat_.alarms(); }
  const std::vector<Structure>& structures() const noexcept { return structures_; }

 private:
  Monitor(ToolSamples samples) : samples_(std::move(samples)) {}
  ToolSamples samples_;
  Heat heat_;
  std::vector<Structure> structures_;
  std::vector<std::shared_ptr<const KeepOut>> fields_;  // of the structures
  double hottest_ = kBodyCelsius, most_pulp_rise_ = 0;
};

}  // namespace kerf
