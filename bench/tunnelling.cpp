// Whether a fast hand passes a thin wall.
#include <fmt/format.h>

#include <cmath>

#include "bench/bench.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

using namespace scenes;

constexpr double kWall = 0.3;    // mm
constexpr double kBehind = 40;   // mm: end of the hand's path
constexpr double kBefore = 4.9;  // mm: approximate start

struct Pass {
  bool is_missed = false;  // no tick reported a contact
  bool is_behind = false;  // the tool came out on the other side
  double deepest = 0;      // mm below the wall's near side
  double removed = 0;      // mm^3
  std::vector<double> ms;  // of the ticks in contact
  std::uint64_t state = 0;
};

// A hand goes straight through a wall at `speed` and ends 40 mm behind it. `turn`: the tool in the wall's frame, z out
// of the wall; `tip`: place of its foremost point.
Expected<Pass> pass(const Model& model, double voxel, const Rigid3& attitude, const Eigen::Quaterniond& turn,
                    const Vec3d& tip, double speed, double offset, double pedal) {
  KERF_TRY(wall, practiceBlock({8, 8, kWall}, voxel, attitude));
  State state;
  state.objects.emplace_back(wall, 4096);
  const auto at = [&](double height) { return attitude * Rigid3{turn, turn * -tip + Vec3d(0.02, -0.03, height)}; };
  state.place(at(kBefore + offset));

  Pass out;
  StepOutput tick;
  const int ticks = static_cast<int>(std::ceil((kBefore + kBehind) / (speed * kTick))) + 200;
  const Rigid3 to_wall = attitude.inverse();
  for (int n = 0; n < ticks; ++n) {
    DeviceSample sample;
    sample.T_world_device = at(std::max(kBefore + offset - speed * kTick * n, -kBehind));
    sample.pedal = pedal;
    const double start = now();
    step(model, state, sample, tick);
    if (tick.touching > 0 || tick.removed_mm3 > 0) out.ms.push_back(now() - start);
    out.removed += tick.removed_mm3;

    const double height = (to_wall * (tick.T_world_tool * tip))[2];
    out.deepest = std::max(out.deepest, -height);
  }

  out.is_missed = out.ms.empty();
  // Beyond the far side, out of reach of a tool held by the wall.
  out.is_behind = out.deepest > kWall + 0.5;
  out.state = state.hash();
  return out;
}

struct Approach {
  const char* name;
  ToolModel tool;
  Eigen::Quaterniond turn;
  Vec3d tip;  // tool frame
};

// Results of four attitudes and two voxels at one speed.
struct Tally {
  int places = 0, runs = 0;
  int passed = 0, missed_coupled = 0, missed_rigid = 0, uncut = 0;
  double deepest = 0;

  void addTo(Result& r, const std::string& what) const {
    r.add(what + ": passed, of " + std::to_string(places), passed);
    r.add(what + ": contacts missed", missed_coupled + missed_rigid);
    r.add(what + ": driven through without a hole", uncut);
    r.add(what + ": deepest below the wall's near side", deepest, "mm");
  }
};

// One approach to one wall, three times: by hand, driven, driven and cutting.
Expected<void> tryWall(const Approach& approach, double speed, int n, double voxel, Tally& tally, Result& r,
                       std::uint64_t& hash) {
  const Rigid3 attitude =
      turned(0.53 * n, {std::sin(2.0 * n + 1), std::cos(3.0 * n), 0.4}, 0.017 * n * Vec3d(1, -2, 0.5));
  const double offset = 0.23 * n;  // position of the wall between two samples
  Model model;
  model.tools = {approach.tool};
  model.tissues = oneTissue(200, 0.5, 1000);
  // Guided by hand, at rest: the wall has to stop it.
  KERF_TRY(guided, pass(model, voxel, attitude, approach.turn, approach.tip, speed, offset, 0));
  tally.passed += guided.is_behind;
  tally.missed_coupled += guided.is_missed;
  tally.deepest = std::max(tally.deepest, guided.deepest);

  // Driven by a machine: nothing stops it, and it has to notice the wall.
  model.settings.rendering = Rendering::kRigid;
  KERF_TRY(driven, pass(model, voxel, attitude, approach.turn, approach.tip, speed, offset, 0));
  tally.missed_rigid += driven.is_missed;

  // The same, cutting: the wall must have a hole.
  model.settings.geometry_only = true;
  KERF_TRY(cutting, pass(model, voxel, attitude, approach.turn, approach.tip, speed, offset, 1));
  tally.uncut += cutting.removed <= 0;

  for (const Pass* p : {&guided, &driven, &cutting}) {
    r.ms.insert(r.ms.end(), p->ms.begin(), p->ms.end());
    hash = hash * 0x100000001b3ull ^ p->state;
  }
  tally.runs += 3;
  tally.places += 1;
  return {};
}

}  // namespace

Expected<Result> benchTunnelling(const Bench& bench) {
  Result r(SceneId::kTunnelling, "a wall of 0.3 mm, the hand through it and 40 mm beyond; tick times in contact");
  KERF_TRY(saw, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(blades, makeModel(std::span(&saw, 1)));
  const double half = 0.5 * saw.thickness_mm;
  const Approach approaches[] = {
      {"ball of 1 mm", practiceBall(0.5, 840), Eigen::Quaterniond::Identity(), Vec3d::Zero()},
      {"blade, teeth first", blades.tools[0], teethDown(), {0, 0, 12.5}},
      {"blade, flank first", blades.tools[0], flankDown(), {2.5, -half, 12.5}}};

  constexpr int kAttitudes = 4;
  std::uint64_t hash = 0;
  int runs = 0, done = 0;
  for (const Approach& approach : approaches)
    for (const double speed : {100.0, 250.0, 500.0, 1000.0}) {
      Tally tally;
      for (int n = 0; n < kAttitudes; ++n)
        for (const double voxel : {0.1, 0.05}) {
          if (!report(bench.progress, done++ / 96.0, "walls")) return cancelled();
          KERF_CHECK(tryWall(approach, speed, n, voxel, tally, r, hash));
        }
      tally.addTo(r, fmt::format("{}, {} m/s", approach.name, speed / 1000));
      runs += tally.runs;
    }
  r.add("runs", runs);
  r.state_hash = fmt::format("{:016x}", hash);
  return r;
}

}  // namespace kerf::cli
