#include "sim/monitor/monitor.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "sim/monitor/structures.h"

namespace kerf {
std::string neighbourId(std::size_t object) { return fmt::format("beside_{}", object); }

Monitor::Monitor(const ToolModel& tool, const HeatSource& source, const HeatSettings& settings)
    : samples_(tool.cut, kToolSamples),
      close_(tool, samples_, source.flank),
      heat_(source, settings),
      middle_(tool.cut.isEmpty() ? Vec3d(Vec3d::Zero()) : tool.cut.bounds().center()) {}

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
      watch(s, *fields_[n], reading.point);
    }
  }
  warm(sample, output, objects);
}

// Follows the temperature of a structure where the tool is nearest to it.
void Monitor::watch(const Structure& structure, const KeepOut& field, const Vec3d& point) noexcept {
  Vec3d away;  // the field's gradient, over two voxels: below that it is one of steps
  const double step = 2 * field.spacing();
  for (int c = 0; c < 3; ++c) {
    const Vec3d beside = step * Vec3d::Unit(c);
    away[c] = static_cast<double>(field.distance((point + beside).cast<float>()) -
                                  field.distance((point - beside).cast<float>()));
  }
  const double length = away.norm();
  const Vec3d nearest = length > 0 ? Vec3d(point - structure.distance / length * away) : point;
  heat_.watch(structure.material == Material::kPulp ? Heat::kPulp : Heat::kNerve, nearest);
}

void Monitor::warm(const DeviceSample& sample, const StepOutput& output, std::span<const CutObject> objects) noexcept {
  const Rigid3 T_object_tool = objects.front().T_world_object.inverse() * output.T_world_tool;
  HeatInput heat;
  heat.is_touching = output.touching > 0;
  if (heat.is_touching) {
    // This tick's samples are a few of all: what they say is worth as much as they are.
    touched_s_ = std::min(touched_s_ + kTick, Heat::kMean);
    const ContactArea::Reading close = close_.read(objects, output.objects_touched, output.T_world_tool);
    area_ = close.area;
    if (close.isClose()) middle_ += kTick / touched_s_ * (close.middle - middle_);
  } else {
    area_ = touched_s_ = 0;
  }
  heat.area = area_;
  heat.power = output.power;
  heat.removed = output.removed_mm3;
  heat.irrigation = heat.is_touching ? sample.irrigation : 0;
  heat.material = output.material;
  heat.place = T_object_tool * middle_;
  if (has_before_) heat.velocity = (heat.place - T_object_before_ * middle_) / kTick;
  heat.is_elsewhere = !(output.objects_touched & objectBit(0));
  heat_.step(heat);
  T_object_before_ = T_object_tool;
  has_before_ = true;

  hottest_ = std::max(hottest_, temperature());
  most_pulp_rise_ = std::max(most_pulp_rise_, heat_.rise(Heat::kPulp));
  most_nerve_rise_ = std::max(most_nerve_rise_, heat_.rise(Heat::kNerve));
}

}  // namespace kerf
