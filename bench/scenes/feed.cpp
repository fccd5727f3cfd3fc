#include "bench/scenes/feed.h"

#include <algorithm>

#include "bench/scenes/objects.h"
#include "bench/scenes/practice_block.h"

namespace kerf::scenes {

Feed feed(const Model& model, State& state, const Rigid3& frame, const Rigid3& from, const Vec3d& way, double speed,
          double steady_from) {
  Feed out;
  StepOutput tick;
  const int ticks = static_cast<int>(way.norm() / (speed * kTick));
  int steady = 0;
  Wrench last;
  const Vec3d along = frame.rotation * way.normalized();
  for (int n = 0; n <= ticks; ++n) {
    DeviceSample sample;
    sample.T_world_device = frame * Rigid3{from.rotation, from.translation + way * n / ticks};
    sample.pedal = 1;
    reserveForTicks(state.objects[0]);
    step(model, state, sample, tick);
    out.status |= tick.status;

    if (n >= steady_from * ticks) {
      ++steady;
      out.force += tick.contact.force.norm();
      out.normal += tick.normal_load;
      out.rate += tick.removed_mm3 / kTick;
      out.thrust -= tick.contact.force.dot(along);
      out.drag += tick.drive_load;
      if (steady > 1) {
        out.jump = std::max(out.jump, (tick.contact.force - last.force).norm());
        out.turn_jump = std::max(out.turn_jump, (tick.contact.torque - last.torque).norm());
      }
    }
    last = tick.contact;
  }

  out.force /= steady;
  out.normal /= steady;
  out.rate /= steady;
  out.thrust /= steady;
  out.drag /= steady;
  return out;
}

Expected<Feed> slot(double voxel, const Rigid3& frame, double energy) {
  Model model;
  model.tools = {practiceBall(0.8, 840)};
  model.tissues = oneTissue(200, 0.5, energy);
  model.settings.rendering = Rendering::kRigid;
  KERF_TRY(block, practiceBlock({8, 5, 3}, voxel, frame));
  State state;
  state.objects.emplace_back(block, 8192);
  return feed(model, state, frame, {Eigen::Quaterniond::Identity(), {-2, 0.01, -0.6}}, {2.2, 0, 0}, 2, 0.6);
}

}  // namespace kerf::scenes
