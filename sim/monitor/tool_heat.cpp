#include "sim/monitor/tool_heat.h"

#include <algorithm>

namespace kerf {
namespace {

// The tool's pose without its deepest overlap: pushed back along the force on it.
Rigid3 outOfTissue(const StepOutput& output) {
  Rigid3 out = output.T_world_tool;
  const double force = output.contact.force.norm();
  if (force > 0) out.translation += output.deepest / force * output.contact.force;
  return out;
}

}  // namespace

HeatingTool::HeatingTool(const ToolModel& tool, const ToolSamples& samples, const HeatSource& heat_source)
    : close(tool, samples, heat_source.flank),
      source(heat_source),
      middle(tool.cut.isEmpty() ? Vec3d(Vec3d::Zero()) : tool.cut.bounds().center()) {}

void ToolHeat::watch(Material structure, const KeepOut& field, const KeepOut::Reading& nearest) noexcept {
  Vec3d away;  // the field's gradient, over two voxels: below that it is one of steps
  const double step = 2 * field.spacing();
  for (int c = 0; c < 3; ++c) {
    const Vec3d beside = step * Vec3d::Unit(c);
    away[c] = static_cast<double>(field.distance((nearest.point + beside).cast<float>()) -
                                  field.distance((nearest.point - beside).cast<float>()));
  }
  const double length = away.norm();
  const Vec3d point = length > 0 ? Vec3d(nearest.point - nearest.distance / length * away) : nearest.point;
  heat_.watch(structure == Material::kPulp ? Heat::kPulp : Heat::kNerve, point);
}

void ToolHeat::tick(HeatingTool& tool, const DeviceSample& sample, const StepOutput& output,
                    std::span<const CutObject> objects) noexcept {
  if (tool_ != &tool) {  // another one: it has been nowhere yet
    tool_ = &tool;
    heat_.heatBy(tool.source);
    middle_ = tool.middle;
    touched_s_ = 0;
    has_before_ = false;
  }

  const Rigid3 T_object_tool = objects.front().T_world_object.inverse() * output.T_world_tool;
  HeatInput heat;
  heat.is_touching = output.touching > 0;
  if (heat.is_touching) {
    // This tick reads a few of all samples: they count by their share.
    touched_s_ = std::min(touched_s_ + kTick, Heat::kMean);
    const ContactArea::Reading close = tool.close.read(objects, output.objects_touched, outOfTissue(output));
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
}

}  // namespace kerf
