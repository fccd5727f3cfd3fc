#include "sim/monitor/monitor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace kerf {
namespace {

// A taper of 8 mm then has a sample every 0.18 mm. Between two of them it is nearer to something flat by 0.02 mm. It
// takes 6 us to read.
constexpr int kSamples = 1600;

// The default reach of a keep-out field, or the nearest that this voxel allows.
KeepOutOptions reachAt(double voxel) {
  KeepOutOptions out;
  out.most_distance = std::clamp(out.most_distance, 2 * voxel, KeepOut::kMostVoxels * voxel);
  out.most_depth = std::max(out.most_depth, 2 * voxel);
  return out;
}

}  // namespace

std::string neighbourId(std::size_t object) { return fmt::format("beside_{}", object); }

Expected<Monitor> Monitor::make(const LoadedObjects& objects, const ToolModel& tool) {
  Monitor out{ToolSamples(tool.cut, kSamples)};
  const auto add = [&out](Structure structure, std::shared_ptr<const KeepOut> field) {
    out.structures_.push_back(std::move(structure));
    out.fields_.push_back(std::move(field));
  };

  const BakedObject& object = *objects.front();
  for (const auto& [material, id] :
       {std::pair(Material::kPulp, "pulp"), std::pair(Material::kNerveCanal, "nerve_canal")}) {
    auto field = KeepOut::make(object, std::array{material}, reachAt(object.voxel()));
    if (!field && field.error().code == Error::Code::kNotFound) continue;
    if (!field) return fail(field.error());
    add({.material = material, .id = id}, std::move(*field));
  }

  for (std::size_t n = 1; n < objects.size(); ++n) {
    KERF_TRY(field, KeepOut::ofSolid(*objects[n], reachAt(objects[n]->voxel())));
    add({.id = neighbourId(n), .object = n}, std::move(field));
  }
  return out;
}

void Monitor::tick(const DeviceSample& sample, const StepOutput& output, std::span<const CutObject> objects) noexcept {
  double pulp_depth = -1;
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
    }
    if (s.material == Material::kPulp && !reading.is_far) pulp_depth = std::max(0.0, reading.distance);
  }

  HeatInput heat;
  heat.power = output.power;
  heat.area = output.area;
  heat.removed = output.removed_mm3;
  heat.irrigation = output.touching > 0 ? sample.irrigation : 0;
  heat.material = output.material;
  heat.pulp_depth = pulp_depth;
  heat_.step(heat);
  hottest_ = std::max(hottest_, temperature());
  most_pulp_rise_ = std::max(most_pulp_rise_, heat_.pulpRise());
}

}  // namespace kerf
