// Drives: removal by hand force, stall force, run-down time. No times of the machine.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "bench/bench.h"
#include "bench/scenes/hold.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "geometry/tool/handpiece.h"
#include "sim/run/scene/load_scene.h"

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

// Pressed onto a bar 2 mm wide. A long bur lies across it with its whole length, a short one enters straight.
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
  double stall_force = 0;                // N: lowest force that stops the drive; 0: none
  double most_power = 0;                 // N mm/s
};

// Force of the highest removal, and stall force, in steps of a tenth. A stall shows within two seconds.
using HoldAt = std::function<Hold(double force)>;
Sweep sweepForces(const HoldAt& at, double least, double most) {
  Sweep out;
  for (double force = least; force < most; force *= 1.1) {
    const Hold held = at(force);
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

// Friction grip of each kind and size: head diameters of 1.0 to 2.1 mm.
constexpr const char* kTurbineBurs[] = {"856-016", "856-021", "837-012", "801-014", "us-1157"};

// Macor, medium grit: 0.44, 1 and 1.83 N took 0.58 : 1 : 0.99 (facts of drills and drives).
Expected<void> pressTurbines(Result& r, const Bench& bench) {
  KERF_TRY(enamel, bar(Material::kEnamel));
  KERF_TRY(dentin, bar(Material::kDentin));
  double share = 0;
  for (const char* id : kTurbineBurs) {
    if (!report(bench.progress, share, "turbine")) return cancelled();
    share += 0.05;
    KERF_TRY(model, modelOf(id, "turbine"));
    const auto at = [&](const auto& object, double force) { return hold(model, pressed(model, object, force)); };
    const auto add = [&](const char* what, double value, const char* unit) {
      r.add(fmt::format("turbine, {}: {}", id, what), value, unit);
    };

    const Hold light = at(enamel, 0.44), at_one = at(enamel, 1), heavy = at(enamel, 1.83);
    const auto addWithin = [&](const char* what, double value, double low, double high, const char* unit) {
      r.addWithin(fmt::format("turbine, {}: {}", id, what), value, low, high, unit);
    };
    addWithin("enamel at 1 N", at_one.rate, 0.06, 0.11, "mm3/s");
    add("dentin at 1 N", at(dentin, 1).rate, "mm3/s");
    add("speed lost at 1 N", 100 * (1 - at_one.speed), "%");
    add("removal at 0.44 N over 1 N", light.rate / at_one.rate, "");
    add("removal at 1.83 N over 1 N", heavy.rate / at_one.rate, "");
    const Sweep sweep = sweepForces([&](double force) { return at(enamel, force); }, 0.8, 12);
    addWithin("best load", sweep.best_force, 1.5, 2.5, "N");
    addWithin("stall", sweep.stall_force, 3, 5, "N");
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
    if (name == std::string_view("electric"))
      r.add(fmt::format("{}, {}: speed lost at 1 N", name, kBur), 100 * (1 - hold(model, cutting).speed), "%");

    cutting.pedal_up_at = 0.5;
    cutting.seconds = 3;
    r.add(fmt::format("{}, {}: stops in, cutting at 1 N", name, kBur), hold(model, cutting).stopped_at, "s");
    HoldScene in_air = cutting;
    in_air.start.translation[2] += 3;
    in_air.force = 0;
    in_air.seconds = 6;
    const std::string in_air_text = fmt::format("{}, {}: stops in, in air", name, kBur);
    const double stopped_at = hold(model, in_air).stopped_at;
    if (name == std::string_view("turbine"))
      r.addWithin(in_air_text, stopped_at, 2, 5, "s");
    else
      r.add(in_air_text, stopped_at, "s");
  }
  return {};
}

// A piezo tip with its edge down on bone. Pressing damps it.
Expected<void> pressPiezo(Result& r, const Bench& bench) {
  if (!report(bench.progress, 0.9, "piezo")) return cancelled();
  KERF_TRY(model, modelOf("saw-piezo-050"));
  KERF_TRY(bone, practiceBlock({10, 4, 5}, kVoxel, {}, Material::kCortical));
  const auto at = [&](double force) {
    HoldScene scene;
    scene.object = bone;
    scene.start = {teethDown(), {-4, 0.013, 0.02}};
    scene.force = force;
    return hold(model, scene);
  };
  const Sweep sweep = sweepForces(at, 2, 12);
  r.addWithin("piezo, saw-piezo-050: cortical bone at 2 N", at(2).rate, 0.1, 0.4, "mm3/s");
  r.addWithin("piezo, saw-piezo-050: best load", sweep.best_force, 3, 4, "N");
  r.addWithin("piezo, saw-piezo-050: stall", sweep.stall_force, 7, 8, "N");
  return {};
}

}  // namespace

Expected<Result> benchDrives(const Bench& bench) {
  Result r(SceneId::kDrives, "effect of the hand's force with a turbine and an electric drive");
  KERF_CHECK(pressTurbines(r, bench));
  KERF_CHECK(compareHandpieces(r, bench));
  KERF_CHECK(pressPiezo(r, bench));
  return r;
}

}  // namespace kerf::cli
