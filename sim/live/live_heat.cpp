#include "sim/live/live_heat.h"

#include "sim/object/cut_object.h"

namespace kerf {

void LiveHeat::add(std::size_t tool, const ToolSamples& samples, const HeatSource& source) {
  if (tool >= ready_.size() || samples.isEmpty() || ready_[tool].load(std::memory_order_relaxed)) return;
  made_.push_back(std::make_unique<Tool>(Tool{samples, HeatingTool(tools_[tool], samples, source)}));
  ready_[tool].store(made_.back().get(), std::memory_order_release);
}

LiveHeat::Memory LiveHeat::memory() const {
  Memory out{heat_, report_, {}};
  for (const auto& tool : made_) out.turns.push_back(tool->heating.close.turn());
  return out;
}

void LiveHeat::restore(const Memory& memory) {
  heat_ = memory.heat;
  report_ = memory.report;
  for (std::size_t n = 0; n < made_.size(); ++n)
    made_[n]->heating.close.setTurn(n < memory.turns.size() ? memory.turns[n] : 0);
}

void LiveHeat::tick(std::size_t tool, const DeviceSample& sample, const StepOutput& output,
                    std::span<const CutObject> objects) noexcept {
  Tool* const in_use = tool < ready_.size() ? ready_[tool].load(std::memory_order_acquire) : nullptr;
  report_.is_known = in_use != nullptr;
  report_.kept_mm.fill(HeatReport::kFarOff);
  if (!in_use) return;

  if (structures_) {
    // The pulp moves with its piece: the pose of the first object counts.
    const Rigid3 T_object_tool = objects.front().T_world_object.inverse() * output.T_world_tool;
    for (std::size_t n = 0; n < structures_->all().size(); ++n) {
      const Structures::Structure& structure = structures_->all()[n];
      const KeepOut::Reading nearest = structure.field->read(in_use->samples, T_object_tool);
      if (nearest.is_far) continue;
      report_.kept_mm[n] = nearest.distance;
      if (output.objects_touched & objectBit(0)) heat_.watch(structure.material, *structure.field, nearest);
    }
  }
  heat_.tick(in_use->heating, sample, output, objects);

  const Heat& heat = heat_.heat();
  report_.surface = heat_.temperature();
  report_.pulp_rise = heat.rise(Heat::kPulp);
  report_.nerve_rise = heat.rise(Heat::kNerve);
  report_.alarms = heat.alarms();
}

}  // namespace kerf
