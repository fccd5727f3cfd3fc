#include "bench/scenes/hold.h"

#include <algorithm>
#include <cmath>

#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"

namespace kerf::scenes {

Hold hold(const Model& model, const HoldScene& scene) {
  State state;
  state.objects.emplace_back(scene.object, 4096);
  state.place(scene.start);
  const double free_speed = model.tools[0].drive.speed;
  state.speed = scene.pedal * free_speed;

  Hold out;
  StepOutput tick;
  const double lead = scene.force / model.settings.coupling.stiffness;
  double along = 0, settled_at = 0;
  int counted = 0;
  const int ticks = static_cast<int>(scene.seconds / kTick);

  for (int n = 0; n < ticks; ++n) {
    const double t = n * kTick;
    const double pedal = t < scene.pedal_up_at ? scene.pedal : 0;
    step(model, state, sampleAt({scene.start.rotation, scene.start.translation + (along + lead) * scene.way}, pedal),
         tick);
    reserveForTicks(state.objects[0]);
    along = (tick.T_world_tool.translation - scene.start.translation).dot(scene.way);
    out.seconds = t + kTick;

    const double speed = free_speed > 0 ? tick.speed / free_speed : 0;
    out.last_speed = speed;
    if (pedal == 0 && std::isnan(out.stopped_at) && speed < 0.01) out.stopped_at = t - scene.pedal_up_at;
    if (t < scene.settle) {
      settled_at = along;
      continue;
    }
    ++counted;
    out.rate += tick.removed_mm3;
    out.speed += speed;
    out.power += tick.power;
    out.torque += tick.drive_load;
    out.aside += tick.contact.force - tick.contact.force.dot(scene.way) * scene.way;
  }

  out.depth = along;
  if (counted == 0) return out;
  const double seconds = counted * kTick;
  out.rate /= seconds;
  out.feed = (along - settled_at) / seconds;
  out.speed /= counted;
  out.power /= counted;
  out.torque /= counted;
  out.aside /= counted;
  return out;
}

}  // namespace kerf::scenes
