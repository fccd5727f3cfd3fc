#include "sim/monitor.h"

#include <algorithm>
#include <array>

namespace kerf {

Expected<Monitor> Monitor::make(const BakedObject& object, const ToolModel& tool) {
  Monitor out{ToolSamples(tool.cut)};
  for (const auto& [material, id] :
       {std::pair(Material::kPulp, "pulp"), std::pair(Material::kNerveCanal, "nerve_canal")}) {
    auto field = KeepOut::make(object, std::array{material});
    if (!field && field.error().code == Error::Code::kNotFound) continue;
    if (!field) return fail(field.error());
    Structure structure;
    structure.material = material, structure.id = id;
    out.structures_.push_back(structure);
    out.fields_.push_back(*field);
  }
  return out;
}

void Monitor::tick(const DeviceSample& sample, const StepOutput& output, const Rigid3& T_world_object) noexcept {
  double pulp_depth = -1;
  const Rigid3 T_object_tool = T_world_object.inverse() * output.T_world_tool;
  for (std::size_t n = 0; n < structures_.size(); ++n) {
    Structure& s = structures_[n];
    const KeepOut::Reading reading = fields_[n]->read(samples_, T_object_tool);
    s.distance = reading.distance, s.is_far = reading.is_far;
    if (!reading.is_far) s.least = std::min(s.least, reading.distance);
    if (reading.distance < 0 && output.removed_mm3 > 0) ++s.ticks_in;
    if (s.material == Material::kPulp && !reading.is_far) pulp_depth = std::max(0.0, reading.distance);
  }
  HeatInput heat;
  heat.power = output.power, heat.area = output.area, heat.removed = output.removed_mm3;
  heat.irrigation = output.touching > 0 ? sample.irrigation : 0;
  heat.material = output.material, heat.pulp_depth = pulp_depth;
  heat_.step(heat);
  hottest_ = std::max(hottest_, temperature());
  most_pulp_rise_ = std::max(most_pulp_rise_, heat_.pulpRise());
}

}  // namespace kerf
