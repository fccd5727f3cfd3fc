// Drives and drills: what a hand's force buys, what stalls, how fast a site for an implant is drilled. No times.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/tool/handpiece.h"
#include "sim/run/load_scene.h"
#include "sim/run/practice_block.h"
#include "ui/bench/bench.h"
#include "ui/bench/scenes/hold.h"

namespace kerf::cli {
namespace {

using namespace scenes;

constexpr double kVoxel = 0.1;

Expected<Model> modelOf(const char* id, const char* handpiece = nullptr) {
  KERF_TRY(tool, toolOfRack(id));
  if (handpiece) tool.drive.handpiece = findHandpiece(handpiece);
  KERF_TRY(model, makeModel(std::span(&tool, 1)));
  model.settings.coupling.force_limit = 200;  // an arm, not a device
  return model;
}

// Pressed onto a bar 2 mm wide: a bur that is long lies across it with its whole length, a short one goes straight in.
HoldScene pressed(const Model& model, std::shared_ptr<const BakedObject> bar, double force) {
  HoldScene scene;
  scene.object = std::move(bar);
  scene.force = force;
  const Box3 head = model.tools[0].cut.bounds();
  const double radius = head.max[0], length = head.max[2];
  if (length < 2.5) {
    scene.start = {Eigen::Quaterniond::Identity(), {0.011, 0.013, 0.02}};
    return scene;
  }
  // Tool z along x, the widest circle of a taper over the bar.
  scene.start = {Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), Vec3d::UnitX()),
                 {1.2 - length, 0.013, radius + 0.02}};
  return scene;
}

Expected<std::shared_ptr<const BakedObject>> bar(Material material) {
  return practiceBlock({2, 8, 5}, kVoxel, {}, material);
}

struct Sweep {
  double best_force = 0, best_rate = 0;  // N, mm^3/s
  double stall_force = 0;                // N: the least that stops it; 0: none
  double most_power = 0;                 // N mm/s
};

// By what force it takes most, and what stops it. In steps of a tenth; a stall shows within two seconds.
Sweep sweepForces(const Model& model, const std::shared_ptr<const BakedObject>& object, double least, double most) {
  Sweep out;
  for (double force = least; force < most; force *= 1.1) {
    HoldScene scene = pressed(model, object, force);
    const Hold held = hold(model, scene);
    out.most_power = std::max(out.most_power, held.power);
    if (held.rate > out.best_rate) {
      out.best_rate = held.rate;
      out.best_force = force;
    }
    if (held.last_speed < 0.02) {
      out.stall_force = force;
      break;
    }
  }
  return out;
}

// Friction grip, of each kind and size there is: head diameters of 1.0 to 2.1 mm.
constexpr const char* kTurbineBurs[] = {"856-016", "856-021", "837-012", "801-010", "801-014",
                                        "830-012", "us-1157", "us-57",   "us-701",  "us-331"};

// Macor, medium grit: 0.44, 1 and 1.83 N took 0.58 : 1 : 0.99 (facts of drills and drives).
Expected<void> pressTurbines(Result& r, const Bench& bench) {
  KERF_TRY(enamel, bar(Material::kEnamel));
  KERF_TRY(dentin, bar(Material::kDentin));
  double share = 0;
  for (const char* id : kTurbineBurs) {
    if (!report(bench.progress, share, "turbine")) return cancelled();
    share += 0.05;
    KERF_TRY(model, modelOf(id));
    const auto at = [&](const auto& object, double force) { return hold(model, pressed(model, object, force)); };
    const auto add = [&](const char* what, double value, const char* unit) {
      r.add(fmt::format("turbine, {}: {}", id, what), value, unit);
    };

    const Hold light = at(enamel, 0.44), at_one = at(enamel, 1), heavy = at(enamel, 1.83);
    add("enamel at 1 N", at_one.rate, "mm3/s");
    add("dentin at 1 N", at(dentin, 1).rate, "mm3/s");
    add("speed lost at 1 N", 100 * (1 - at_one.speed), "%");
    add("removal at 0.44 N over 1 N", light.rate / at_one.rate, "");
    add("removal at 1.83 N over 1 N", heavy.rate / at_one.rate, "");
    const Sweep sweep = sweepForces(model, enamel, 0.8, 12);
    add("best load", sweep.best_force, "N");
    add("stall", sweep.stall_force, "N");
    add("most power", sweep.most_power / 1000, "W");
  }
  return {};
}

Expected<void> compareHandpieces(Result& r, const Bench& bench) {
  if (!report(bench.progress, 0.5, "handpieces")) return cancelled();
  KERF_TRY(enamel, bar(Material::kEnamel));
  constexpr const char* kBur = "856-016";
  for (const char* name : {"turbine", "turbine-brake", "electric"}) {
    KERF_TRY(model, modelOf(kBur, name));
    HoldScene cutting = pressed(model, enamel, 1);
    if (name == std::string_view("electric")) {
      r.add(fmt::format("{}, {}: speed lost at 1 N", name, kBur), 100 * (1 - hold(model, cutting).speed), "%");
      r.add(fmt::format("{}, {}: stall", name, kBur), sweepForces(model, enamel, 4, 40).stall_force, "N");
    }

    cutting.pedal_up_at = 0.5;
    cutting.seconds = 3;
    r.add(fmt::format("{}, {}: stops in, cutting at 1 N", name, kBur), hold(model, cutting).stopped_at, "s");
    HoldScene in_air = cutting;
    in_air.start.translation[2] += 3;
    in_air.force = 0;
    in_air.seconds = 6;
    r.add(fmt::format("{}, {}: stops in, in air", name, kBur), hold(model, in_air).stopped_at, "s");
  }

  // A hand that was too heavy lets go: the turbine comes up again by itself.
  KERF_TRY(model, modelOf(kBur));
  HoldScene scene = pressed(model, enamel, 6);
  scene.relieved_at = 2;
  scene.relieved_force = 1;
  scene.seconds = 4;
  scene.settle = 3;
  r.add(fmt::format("turbine, {}: speed after a stall at 6 N, 1 s at 1 N", kBur), hold(model, scene).speed, "");
  return {};
}

// ---- Drills

HoldScene drilling(std::shared_ptr<const BakedObject> block, double force, double deepest) {
  HoldScene scene;
  scene.object = std::move(block);
  scene.start = {Eigen::Quaterniond::Identity(), {0.011, 0.013, 0.02}};
  scene.force = force;
  scene.seconds = 12;
  scene.deepest = deepest;
  return scene;
}

// Feed in mm/s once the whole point is in, over 1.5 mm.
Hold drilled(const Model& model, const std::shared_ptr<const BakedObject>& block, double force) {
  HoldScene scene = drilling(block, force, 0.1);
  const double point = model.tools[0].lips.height;
  scene.deepest = point + 0.7;
  const Hold entry = hold(model, scene);
  if (entry.depth < scene.deepest) return {};
  scene.settle = entry.seconds;
  scene.deepest = point + 2.2;
  return hold(model, scene);
}

// The force that gives this feed, by halving.
double thrustAt(const Model& model, const std::shared_ptr<const BakedObject>& block, double feed) {
  double low = 0.1, high = 150;
  for (int n = 0; n < 8; ++n) {
    const double force = std::sqrt(low * high);
    (drilled(model, block, force).feed < feed ? low : high) = force;
  }
  return std::sqrt(low * high);
}

Expected<void> drillBone(Result& r, const Bench& bench) {
  KERF_TRY(cortical, practiceBlock({6, 6, 9}, kVoxel, {}, Material::kCortical));
  KERF_TRY(cancellous, practiceBlock({6, 6, 9}, kVoxel, {}, Material::kCancellous));
  KERF_TRY(fine, practiceBlock({4, 4, 5}, 0.05, {}, Material::kCortical));
  KERF_TRY(pilot, modelOf("drill-20"));
  const auto at = [](Model model, double rpm) {
    model.tools[0].drive.speed = rpm * 2 * std::numbers::pi / 60;
    return model;
  };
  const Model slow = at(pilot, 800), fast = at(pilot, 1500);

  if (!report(bench.progress, 0.6, "drills")) return cancelled();
  const Hold ten = drilled(slow, cortical, 10), ten_fast = drilled(fast, cortical, 10);
  r.add("drill 2.0, cortical, 10 N, 800 rpm", ten.feed, "mm/s");
  r.add("drill 2.0, cortical, 10 N, 1500 rpm", ten_fast.feed, "mm/s");
  r.add("  1500 over 800 rpm", ten_fast.feed / ten.feed, "");
  r.add("drill 2.0, cortical, 20 N, 800 rpm", drilled(slow, cortical, 20).feed, "mm/s");
  r.add("drill 2.0, cancellous, 3 N, 800 rpm", drilled(slow, cancellous, 3).feed, "mm/s");
  r.add("drill 2.0, cortical, 10 N, 0.05 against 0.1 mm voxels", 100 * (drilled(slow, fine, 10).feed / ten.feed - 1),
        "%");
  r.add("drill 2.0, torque at a feed of 0.05 mm a turn, by 10 N", ten.torque, "N mm");
  r.add(
      "drill 2.0, cortical, 2.5 N: depth after 3 s",
      [&] {
        HoldScene scene = drilling(cortical, 2.5, 5);
        scene.seconds = 3;
        return hold(slow, scene).depth;
      }(),
      "mm");

  if (!report(bench.progress, 0.7, "drills: thrust")) return cancelled();
  std::vector<double> thrusts, diameters;
  for (const char* id : {"drill-20", "drill-28", "drill-35"}) {
    KERF_TRY(drill, modelOf(id));
    const double thrust = thrustAt(at(drill, 800), cortical, 1);
    thrusts.push_back(std::log(thrust));
    diameters.push_back(std::log(2 * drill.tools[0].cut.bounds().max[0]));
    r.add(fmt::format("{}, cortical: thrust at 1 mm/s, 800 rpm", id), thrust, "N");
  }
  r.add("drills: exponent of the diameter",
        (thrusts.back() - thrusts.front()) / (diameters.back() - diameters.front()));
  const double sparse = thrustAt(slow, cancellous, 1);
  r.add("drill 2.0, cancellous: thrust at 1 mm/s, 800 rpm", sparse, "N");
  r.add("drills: exponent of the density", (thrusts.front() - std::log(sparse)) / std::log(1.9 / 0.55));

  if (!report(bench.progress, 0.85, "drills: a site")) return cancelled();
  // 2 mm of cortical bone over cancellous, as a posterior mandible has it: by two blocks, one after the other.
  for (const double force : {8.0, 12.0, 20.0}) {
    const double point = pilot.tools[0].lips.height;
    HoldScene through = drilling(cortical, force, 2 + point);
    HoldScene below = drilling(cancellous, force, 8);
    r.add(fmt::format("drill 2.0: a site of 10 mm at {} N, 800 rpm", force),
          hold(slow, through).seconds + hold(slow, below).seconds, "s");
  }
  return {};
}

}  // namespace

Expected<Result> benchDrives(const Bench& bench) {
  Result r(SceneId::kDrives, "what force buys with a turbine, an electric drive and a drill: training defaults");
  KERF_CHECK(pressTurbines(r, bench));
  KERF_CHECK(compareHandpieces(r, bench));
  KERF_CHECK(drillBone(r, bench));
  return r;
}

}  // namespace kerf::cli
