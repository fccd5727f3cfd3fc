#include "bench/scenes/sink.h"

#include <algorithm>
#include <cmath>

#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"

namespace kerf::scenes {
namespace {

constexpr double kAir = 0.2;  // mm above the surface at the start

double distanceTo(const ToolModel& tool, const Vec3d& p) {
  const Vec3f at = p.cast<float>();
  double tau = static_cast<double>(tool.cut.distance(at));
  if (!tool.body.isEmpty()) tau = std::min(tau, static_cast<double>(tool.body.distance(at)));
  return tau;
}

// Tool axes in those of the surface: the foremost direction points down, then the tool leans.
Eigen::Quaterniond attitudeIn(const SinkScene& scene) {
  return Eigen::AngleAxisd(scene.lean, Vec3d(0.8, 0.6, 0).normalized()) *
         Eigen::Quaterniond::FromTwoVectors(scene.first, -Vec3d::UnitZ());
}

}  // namespace

Vec3d foremost(const ToolModel& tool, const Vec3d& direction) {
  // direction . p - tau(p) peaks at the foremost point and stays at that value from there to the medial axis. Farther
  // out, distances are lower bounds and would count too much.
  constexpr double kExact = 0.4;  // mm
  const auto reach = [&](const Vec3d& p) {
    const double tau = distanceTo(tool, p);
    return tau < kExact ? direction.dot(p) - tau : -1e9;
  };
  Box3 box = tool.cut.bounds();
  if (!tool.body.isEmpty()) box.add(tool.body.bounds());

  Vec3d best = Vec3d::Zero();
  double most = -1e9;
  const auto lookAround = [&](const Box3& where, double spacing) {
    const Eigen::Array3i count = (where.size() / spacing).array().ceil().cast<int>() + 1;
    for (int x = 0; x < count[0]; ++x)
      for (int y = 0; y < count[1]; ++y)
        for (int z = 0; z < count[2]; ++z) {
          const Vec3d p = (where.min + spacing * Vec3d(x, y, z)).cwiseMin(where.max);
          if (const double r = reach(p); r > most) {
            most = r;
            best = p;
          }
        }
  };
  lookAround(box, 0.4);
  for (double spacing = 0.1; spacing > 0.004; spacing *= 0.5) {
    const Vec3d around = best;
    Box3 near;
    near.add(Vec3d(around.array() - 4 * spacing));
    near.add(Vec3d(around.array() + 4 * spacing));
    lookAround({near.min.cwiseMax(box.min), near.max.cwiseMin(box.max)}, spacing);
  }
  return best - direction * distanceTo(tool, best);
}

double widthBehind(const ToolModel& tool, const Vec3d& direction, double behind_mm) {
  const Vec3d middle = foremost(tool, direction) - behind_mm * direction;
  const Eigen::Matrix3d axes = Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), direction).toRotationMatrix();
  double deepest = 0;
  for (int x = -40; x <= 40; ++x)
    for (int y = -40; y <= 40; ++y)
      deepest = std::min(deepest, distanceTo(tool, middle + 0.02 * (x * axes.col(0) + y * axes.col(1))));
  return -2 * deepest;
}

Dig dig(const Model& model, std::size_t tool, const SinkScene& scene, double force, double seconds) {
  const Eigen::Quaterniond turn = attitudeIn(scene);
  const Vec3d tip = foremost(model.tools[tool], turn.conjugate() * -Vec3d::UnitZ());
  const Vec3d down = scene.frame.rotation * -Vec3d::UnitZ();
  const Rigid3 start = scene.frame * Rigid3{turn, Vec3d(0.02, -0.03, 0.02) - turn * tip};

  State state;
  state.objects.emplace_back(scene.object, 4096);
  state.tool = tool;
  state.place(start);
  state.speed = model.tools[tool].drive.speed;

  Dig out;
  StepOutput tick;
  const Rigid3 to_surface = scene.frame.inverse();
  const double lead = force / model.settings.coupling.stiffness;
  Rigid3 at = start;
  for (int n = 0; n < 2000 && out.seconds < seconds && out.depth < 3; ++n) {
    // Held sideways on its line, as by a guided hand, and pushed along it.
    const double along = (at.translation - start.translation).dot(down);
    step(model, state, sampleAt({start.rotation, start.translation + (along + lead) * down}), tick);
    reserveForTicks(state.objects[0]);
    at = tick.T_world_tool;

    if (out.removed > 0 || tick.removed_mm3 > 0) out.seconds += kTick;
    out.removed += tick.removed_mm3;
    out.work += tick.power * kTick;
    out.depth = -(to_surface * (at * tip))[2];
  }
  return out;
}

Sink sink(const Model& model, std::size_t tool, const SinkScene& scene) {
  const Eigen::Quaterniond turn = attitudeIn(scene);
  const Vec3d tip = foremost(model.tools[tool], turn.conjugate() * -Vec3d::UnitZ());
  const auto handAt = [&](double height) {
    return scene.frame * Rigid3{turn, Vec3d(0.02, -0.03, height) - turn * tip};
  };

  State state;
  state.objects.emplace_back(scene.object, 16);
  state.tool = tool;
  state.place(handAt(kAir));
  state.speed = scene.turns * model.tools[tool].drive.speed;

  Sink out;
  StepOutput tick;
  double most = 0;
  bool has_touched = false;
  const int moving = static_cast<int>(std::ceil((scene.hand_mm + kAir) / (scene.speed * kTick)));
  const int ticks = moving + static_cast<int>(std::lround(scene.rest_s / kTick));
  const Vec3d up = scene.frame.rotation * Vec3d::UnitZ();
  const Rigid3 to_surface = scene.frame.inverse();
  for (int n = 0; n < ticks; ++n) {
    const double height = std::max(kAir - scene.speed * kTick * n, -scene.hand_mm);
    step(model, state, sampleAt(handAt(height), 0), tick);

    out.deepest = std::max(out.deepest, -(to_surface * (tick.T_world_tool * tip))[2]);
    out.force = tick.force.force.dot(up);
    // In air the hand feels the inertia of the tool.
    has_touched |= tick.objects_touched != 0;
    out.untold += tick.contact.force.norm() > 0.1 && (tick.objects_touched == 0 || tick.touching == 0);
    if (n >= moving || !has_touched) continue;
    most = std::max(most, out.force);
    out.fall = std::max(out.fall, most - out.force);
  }
  out.state = state.hash();
  return out;
}

}  // namespace kerf::scenes
