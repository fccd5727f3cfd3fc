#include "sim/monitor/monitor.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "sim/monitor/structures.h"

namespace kerf {
std::string neighbourId(std::size_t object) { return fmt::format("beside_{}", object); }

Monitor::Monitor(const ToolModel& tool, const HeatSource& source, const HeatSettings& settings)
    : samples_(tool.cut, kToolSamples), tool_(tool, samples_, source), heat_(settings) {}

Expected<Monitor> Monitor::make(const LoadedObjects& objects, const ToolModel& tool, const HeatSource& source,
                                const HeatSettings& settings) {
  Monitor out(tool, source, settings);
  const auto add = [&out](Structure structure, std::shared_ptr<const KeepOut> field) {
    out.structures_.push_back(std::move(structure));
    out.fields_.push_back(std::move(field));
  };

  KERF_TRY(structures, Structures::of(*objects.front()));
  for (const Structures::Structure& s : structures->all()) add({.material = s.material, .id = s.id}, s.field);

  for (std::size_t n = 1; n < objects.size(); ++n) {
    KERF_TRY(field, KeepOut::ofSolid(*objects[n], keepOutReach(objects[n]->voxel())));
    add({.id = neighbourId(n), .object = n}, std::move(field));
  }
  return out;
}

void Monitor::tick(const DeviceSample& sample, const StepOutput& output, std::span<const CutObject> objects) noexcept {
  for (std::size_t n = 0; n < structures_.size(); ++n) {
    Structure& s = structures_[n];
    const CutObject& object = objects[s.object];
    const KeepOut::Reading reading = fields_[n]->read(samples_, object.T_world_object.inverse() * output.T_world_tool);
    s.distance = reading.distance;
    s.is_far = reading.is_far;
    if (!reading.is_far) s.least = std::min(s.least, reading.distance);
    if (reading.distance < 0 && output.removed_mm3 > 0) ++s.ticks_in;
    if (s.object > 0) {
      s.removed_mm3 = std::accumulate(object.removed_mm3.begin(), object.removed_mm3.end(), 0.0);
      s.ticks_touched += (output.objects_touched & objectBit(s.object)) != 0;
    } else if (!reading.is_far && output.touching > 0) {
      heat_.watch(s.material, *fields_[n], reading);
    }
  }
  heat_.tick(tool_, sample, output, objects);

  hottest_ = std::max(hottest_, temperature());
  most_pulp_rise_ = std::max(most_pulp_rise_, heat().rise(Heat::kPulp));
  most_nerve_rise_ = std::max(most_nerve_rise_, heat().rise(Heat::kNerve));
}

}  // namespace kerf
