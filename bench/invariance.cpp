// Whether force and removal are independent of voxels, attitude and speed. Machine-independent numbers, no times.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/bench.h"
#include "bench/scenes/feed.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "bench/spread.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

using namespace scenes;

Expected<void> overVoxels(Result& r, const Bench& bench) {
  Spread force, rate;
  double law = 0;
  for (const double h : {0.1, 0.05, 0.025}) {
    if (!report(bench.progress, 0.1 * (0.1 / h), "voxels")) return cancelled();
    KERF_TRY(f, slot(h, askew()));
    if (!(f.normal > 0)) return brokenScene("slot", "no contact", "a cut");
    force.add(f.force);
    rate.add(f.rate);
    law = std::max(law, std::abs(percentOff(f.rate, 0.5 * f.normal * 840 / 1000)));

    r.add(fmt::format("force at {} mm", h), f.force, "N");
    r.add(fmt::format("removal at {} mm", h), f.rate, "mm3/s");
    r.add(fmt::format("jump of force per ms, eroding, at {} mm", h), f.jump, "N");
    r.add(fmt::format("jump of torque about the tip per ms, eroding, at {} mm", h), f.turn_jump, "N mm");
  }
  r.add("force over three voxels", force.percent(), "%");
  r.add("removal over three voxels", rate.percent(), "%");
  r.add("removal against mu N v / u_s", law, "%");
  return {};
}

Expected<void> overAttitudes(Result& r, const Bench& bench) {
  Spread force, rate;
  for (int n = 0; n < 24; ++n) {
    if (!report(bench.progress, 0.5 + 0.02 * n, "attitudes")) return cancelled();
    const Rigid3 frame = turned(0.37 * n, {std::sin(2.0 * n), std::cos(3.0 * n), std::sin(5.0 * n) + 0.1},
                                0.013 * n * Vec3d(1, -2, 0.5));
    KERF_TRY(f, slot(0.1, frame));
    force.add(f.force);
    rate.add(f.rate);
  }
  r.add("force over 24 attitudes", force.percent(), "%");
  r.add("removal over 24 attitudes", rate.percent(), "%");
  return {};
}

// Sliding on an intact sphere of 5 mm, about 1 N.   @param speed  mm/s.
Expected<void> sliding(Result& r, double speed) {
  Model model;
  model.tools = {practiceBall(0.8, 840)};
  model.tools[0].drive.speed = 0;
  model.tissues = oneTissue(200, 0, 1000);
  model.settings.rendering = Rendering::kRigid;
  const Vec3d center(0.013, 0.027, -5);
  KERF_TRY(sphere, practiceSphere(center, 5, 0.05));
  State state;
  state.objects.emplace_back(sphere, 64);

  StepOutput tick;
  double jump = 0, turn_jump = 0, force = 0;
  Wrench last;
  const int ticks = static_cast<int>(2 / (speed * kTick));
  for (int n = 0; n <= ticks; ++n) {
    // The tip's ball rolls over the pole at a depth of 0.0475 mm.
    const double a = (-1 + 2.0 * n / ticks) / 5;
    DeviceSample sample;
    sample.T_world_device.translation =
        center + (5.8 - 0.0475) * Vec3d(std::sin(a), 0.1 * a, std::cos(a)).normalized() - Vec3d(0, 0, 0.8);
    step(model, state, sample, tick);
    if (n > 0) {
      jump = std::max(jump, (tick.contact.force - last.force).norm());
      turn_jump = std::max(turn_jump, (tick.contact.torque - last.torque).norm());
    }
    last = tick.contact;
    force = std::max(force, last.force.norm());
  }

  r.add(fmt::format("jump of force per ms, sliding {} mm/s at {:.1f} N", speed, force), jump, "N");
  r.add(fmt::format("jump of torque about the tip per ms, sliding {} mm/s", speed), turn_jump, "N mm");
  return {};
}

// One voxel above a block, rendered through the coupling: the hand's force and the distance between tool and hand.
Expected<void> inAir(Result& r) {
  constexpr double kVoxel = 0.05;
  KERF_TRY(bur, toolOfRack("round-014"));
  KERF_TRY(model, makeModel(std::span(&bur, 1)));
  KERF_TRY(block, practiceBlock({20, 4, 2}, kVoxel));
  const Eigen::Quaterniond turn = turned(0.4, {1, 2, 3}).rotation;
  // The tip's ball is 0.7 mm. Its lowest point, rotated, lies one voxel above z = 0.
  const Vec3d tip = Vec3d(0, 0, kVoxel + 0.7) - turn * Vec3d(0, 0, 0.7);

  const auto measure = [&](const char* name, const auto& place) {
    State state;
    state.objects.emplace_back(block, 64);
    state.place({turn, tip + place(0)});
    StepOutput tick;
    double force = 0, drift = 0;
    int touching = 0;
    for (int n = 0; n < 5000; ++n) {
      const DeviceSample sample = sampleAt({turn, tip + place(n)});
      step(model, state, sample, tick);
      touching += tick.touching > 0;
      if (n < 500) continue;  // until the motion is steady
      force = std::max(force, tick.force.force.norm());
      drift = std::max(drift, (tick.T_world_tool.translation - sample.T_world_device.translation).norm());
    }
    r.add(fmt::format("in air, {}: force", name), force, "N");
    r.add(fmt::format("  tool off the hand by ({})", name), 1000 * drift, "um");
    r.add(fmt::format("  ticks with contact ({})", name), touching);
  };

  constexpr double kPi = std::numbers::pi;
  measure("still, 5 s", [](int) { return Vec3d(Vec3d::Zero()); });
  measure("at 3 mm/s", [](int n) { return Vec3d(-7.5 + 0.003 * n, 0, 0); });
  // Encoder steps of 20 um at that speed, as a device sends them.
  measure("at 3 mm/s in steps of 0.02 mm", [](int n) { return Vec3d(-7.5 + 0.02 * std::floor(0.15 * n), 0, 0); });
  // A tool of 20 g, moved to and fro at 1 Hz wide and 5 Hz narrow, exerts its inertia on the hand: by F = m a, 0.004
  // and 0.02 N.
  measure("to and fro, 5 mm at 1 Hz", [](int n) { return Vec3d(5 * std::sin(2e-3 * kPi * n), 0, 0); });
  measure("to and fro, 1 mm at 5 Hz", [](int n) { return Vec3d(std::sin(1e-2 * kPi * n), 0, 0); });
  return {};
}

}  // namespace

Expected<Result> benchInvariance(const Bench& bench) {
  Result r(SceneId::kInvariance, "a ball of 1.6 mm draws a slot, 0.6 mm deep, 2 mm/s, through a block");
  KERF_CHECK(overVoxels(r, bench));
  KERF_CHECK(overAttitudes(r, bench));
  for (const double speed : {0.5, 5.0, 20.0}) KERF_CHECK(sliding(r, speed));
  KERF_CHECK(inAir(r));
  return r;
}

}  // namespace kerf::cli
