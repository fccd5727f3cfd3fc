#include "ui/bench/scene_table.h"

#include <cmath>

namespace kerf::cli {
namespace {

using enum Sense;

// Goals, scene by scene: name (each {} stands for any text), unit, at most / at least / exactly, limit. Of two rows
// about the same number the first counts.

constexpr Goal kPointsGoals[] = {
    {"50k nodes, p99", "ms", kAtMost, 0.5},
    {"200k nodes, p99", "ms", kAtMost, 0.5},
};
constexpr Goal kTickBurGoals[] = {
    {"ticks that lacked room", "", kAtMost, 0},
    {"p99.9", "ms", kAtMost, 0.8},
    {"carve to mesh ready, p95", "ms", kAtMost, 15},
    {"carve to mesh ready, max", "ms", kAtMost, 33},
};
constexpr Goal kTickSawGoals[] = {
    {"ticks that lacked room", "", kAtMost, 0},
    {"p99.9", "ms", kAtMost, 0.8},
};
constexpr Goal kTickSizesGoals[] = {
    {"{} bricks: over the smallest", "", kAtMost, 1.25},
};
constexpr Goal kRealtimeGoals[] = {
    {"ticks that lacked room", "", kAtMost, 0}, {"records lost", "", kAtMost, 0},
    {"of them not meshed", "", kAtMost, 0},     {"chunks unlike those of the final field", "", kAtMost, 0},
    {"replay differs", "", kAtMost, 0},
};

constexpr Goal kInvarianceGoals[] = {
    {"jump of force per ms, eroding, at {} mm", "N", kAtMost, 0.05},
    {"jump of torque about the tip per ms, eroding, at {} mm", "N mm", kAtMost, 1},
    {"force over three voxels", "%", kAtMost, 5},
    {"removal over three voxels", "%", kAtMost, 5},
    {"removal against mu N v / u_s", "%", kAtMost, 5},
    {"force over 24 attitudes", "%", kAtMost, 3},
    {"removal over 24 attitudes", "%", kAtMost, 3},
    {"jump of force per ms, sliding {} mm/s at {} N", "N", kAtMost, 0.02},
    {"jump of torque about the tip per ms, sliding {} mm/s", "N mm", kAtMost, 1},
    {"in air, still, 5 s: force", "N", kAtMost, 0.01},
    {"in air, at 3 mm/s: force", "N", kAtMost, 0.01},
    {"in air, to and fro, 5 mm at 1 Hz: force", "N", kAtMost, 0.01},
    {"  ticks with contact ({})", "", kAtMost, 0},
};
constexpr Goal kForcesGoals[] = {
    {"  spread of the rate in {}", "%", kAtMost, 3},
    {"  against {} as configured", "%", kAtMost, 10},
    {"  against mu v / u_s", "%", kAtMost, 5},
    {"  1 - R^2", "", kAtMost, 0.02},
    {"saw: pairs of 54 where force does not grow with density and feed, fall with strokes", "", kAtMost, 0},
    {"saw: jump of force per ms", "N", kAtMost, 0.05},
    {"saw: jump of torque about the tip per ms", "N mm", kAtMost, 1},
    {"saw: thrust against the law's reference, 27 runs, mean error", "%", kAtMost, 10},
    {"  out of 1.4 to 1.8 by", "", kAtMost, 0},
};
constexpr Goal kSawGoals[] = {
    {"  pushes the wrong way ({} mm)", "", kAtMost, 0},
    {"  kerf widened by the flanks ({} mm)", "um", kAtMost, 1},
    // Half a voxel, but not below 25 um.
    {"kerf width, worst of 12 attitudes, 0.1 mm voxels", "um", kAtMost, 50},
    {"kerf width, worst of 12 attitudes, 0.05 mm voxels", "um", kAtMost, 25},
    {"plane of the wall, worst of 12 ({} mm)", "degrees", kAtMost, 0.1},
};
// Only the default has goals.
constexpr Goal kResponseGoals[] = {
    {"penalty coupled: jump of force per ms, flat", "N", kAtMost, 0.02},
    {"penalty coupled: jump of force per ms, ball", "N", kAtMost, 0.02},
    {"penalty coupled: 1 N/mm: devices given energy, of {}", "", kAtMost, 0},
    {"penalty coupled: 2 N/mm: devices given energy, of {}", "", kAtMost, 0},
    {"penalty coupled: 1 N/mm: devices that tremble by 5 um", "", kAtMost, 0},
    {"penalty coupled: 1 N/mm, no friction: energy given, most", "mJ", kAtMost, 0.1},
    {"penalty coupled: jump of force per ms, cutting", "N", kAtMost, 0.05},
    {"penalty coupled: removal less mu N v / u_s", "%", kAtMost, 5},
};

constexpr Goal kTunnellingGoals[] = {
    // A ball at 1 m/s passes 4 of 8 walls: docs/results/README.md says why.
    {"{}, 1 m/s: passed, of {}", "", kAtMost, 0, Weight::kAim},
    {"{}: passed, of {}", "", kAtMost, 0},
    {"{}: contacts missed", "", kAtMost, 0},
    {"{}: driven through without a hole", "", kAtMost, 0},
};
constexpr Goal kPiecesGoals[] = {
    {"cases counted wrong", "", kAtMost, 0},
    {"lists whose volumes do not sum to the whole, to the bit", "", kAtMost, 0},
    {"removed + left against before", "", kAtMost, 1e-6},
    {"last bridge to list, {}, max", "ms", kAtMost, 50},
};
constexpr Goal kSplitGoals[] = {
    {"splits that are missing or too many", "", kAtMost, 0},
    {"most of them", "ticks", kAtMost, 50},
    {"ticks that lacked room", "", kAtMost, 0},
    {"records lost", "", kAtMost, 0},
    {"replay differs", "", kAtMost, 0},
};

constexpr Goal kPassivityGoals[] = {
    {"K 0.33 N/mm, friction 0.05 N: energy given away, worst of 60 hands", "mJ", kAtMost, 0},
    {"K 0.7 N/mm, friction 0.05 N: energy given away, worst of 60 hands", "mJ", kAtMost, 0},
    {"K 1 N/mm, friction 0.05 N: energy given away, worst of 60 hands", "mJ", kAtMost, 0},
    {"K 0.33 N/mm, friction 0.05 N: trembling", "um", kAtMost, 5},
    {"K 0.7 N/mm, friction 0.05 N: trembling", "um", kAtMost, 5},
    {"K 1 N/mm, friction 0.05 N: trembling", "um", kAtMost, 5},
    // A device without friction trembles by the steps of its encoder, whatever the coupling.
    {"K 0.33 N/mm, friction 0 N: energy given away, worst of 60 hands", "mJ", kAtMost, 0.1},
    {"K 0.7 N/mm, friction 0 N: energy given away, worst of 60 hands", "mJ", kAtMost, 0.1},
    {"K 1 N/mm, friction 0 N: energy given away, worst of 60 hands", "mJ", kAtMost, 0.1},
};
constexpr Goal kPassivityLargeGoals[] = {
    {"K within the bounds of the literature: given energy", "", kAtMost, 0},
    {"K within the bounds of the literature: trembling, most", "um", kAtMost, 5},
    {"K up to twice these bounds: most energy", "mJ", kAtMost, 0.1},
};

constexpr auto kTimesOnly = Scene::kTimesOnly;

constexpr Scene kScenes[] = {
    {SceneId::kBake, "bake", "mesh to case, against the bare library call", benchBake, kTimesOnly},
    {SceneId::kBake200k, "bake-200k", "the same, the demo molar in 200 000 triangles", benchBake200k, kTimesOnly},
    {SceneId::kMandible, "mandible", "the same, the demo mandible: time and memory", benchMandible, kTimesOnly},
    {SceneId::kCutBur, "cut-bur", "motions of a round bur in a block at 0.05 mm", benchCutBur, kTimesOnly},
    {SceneId::kCutBlade, "cut-blade", "motions of a reciprocating blade in a block at 0.1 mm", benchCutBlade,
     kTimesOnly},
    {SceneId::kExport, "export", "run to printable STL", benchExport, kTimesOnly},
    {SceneId::kPoints, "points", "shell nodes against a tool's fields: 50 000 and 200 000 of them", benchPoints,
     kPointsGoals},
    {SceneId::kTickBur, "tick-bur", "whole ticks: taper 016 in the demo molar at 0.05 mm", benchTickBur, kTickBurGoals},
    {SceneId::kTickSaw, "tick-saw", "whole ticks: a 25 mm blade in the demo mandible at 0.1 mm", benchTickSaw,
     kTickSawGoals},
    {SceneId::kTickSizes, "tick-sizes", "the same contact in three sizes of object", benchTickSizes, kTickSizesGoals},
    {SceneId::kRealtime, "realtime",
     "the same on the clock, on its thread, with mesher and recorder; --seconds says how long", benchRealtime,
     kRealtimeGoals},
    {SceneId::kInvariance, "invariance", "force and removal over voxels, attitudes, time: no times, the same anywhere",
     benchInvariance, kInvarianceGoals},
    {SceneId::kForces, "forces", "constant force and constant feed per material: no times", benchForces, kForcesGoals},
    {SceneId::kSaw, "saw", "kerf, plane and side force over attitudes: no times", benchSaw, kSawGoals},
    {SceneId::kResponse, "response", "penalty, constraint and impulse, coupled and direct: a table", benchResponse,
     kResponseGoals},
    {SceneId::kTunnelling, "tunnelling", "a wall of 0.3 mm at 0.1 to 1 m/s: whether anything passes", benchTunnelling,
     kTunnellingGoals},
    {SceneId::kPieces, "pieces", "planes, rings, bridges, crumbs: how many pieces, how soon known", benchPieces,
     kPiecesGoals},
    {SceneId::kSplit, "sever", "a mandible sawn through on the clock: how soon its pieces are objects of their own",
     benchSplit, kSplitGoals},
    {SceneId::kPassivity, "passivity", "energy a simulated device is given, over hands and stiffnesses: no times",
     benchPassivity, kPassivityGoals},
    {SceneId::kPassivityLarge, "passivity-large",
     "the same over 11 664 devices and hands: minutes; only when asked for by name", benchPassivityLarge,
     kPassivityLargeGoals, Scene::When::kOnlyByName},
};

#ifndef __SANITIZE_ADDRESS__  // GCC 12 then takes no address of a function for a constant
// Every id has its row, in order, and every row says all it has to.
consteval bool isComplete(std::span<const Scene> rows) {
  if (rows.size() != static_cast<std::size_t>(SceneId::kCount)) return false;
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const Scene& row = rows[n];
    if (static_cast<std::size_t>(row.id) != n || row.name.empty() || row.what.empty() || !row.run) return false;
    for (std::size_t other = 0; other < n; ++other)
      if (rows[other].name == row.name) return false;
    for (std::size_t g = 0; g < row.goals.size(); ++g) {
      const Goal& goal = row.goals[g];
      if (goal.name.empty() || goal.limit != goal.limit) return false;
      for (std::size_t other = 0; other < g; ++other)
        if (row.goals[other].name == goal.name && row.goals[other].unit == goal.unit) return false;
    }
  }
  return true;
}
static_assert(isComplete(kScenes), "an id without a row, a row out of order, or one that leaves something out");
#endif

}  // namespace

std::span<const Scene> scenes() { return kScenes; }

const Scene& sceneOf(SceneId id) { return kScenes[static_cast<std::size_t>(id)]; }

Expected<const Scene*> findScene(std::string_view name) {
  std::string known;
  for (const Scene& scene : kScenes) {
    if (scene.name == name) return &scene;
    known += (known.empty() ? "" : ", ") + std::string(scene.name);
  }
  return fail({.code = Error::Code::kBadValue,
               .place = "SCENE",
               .found = "\"" + std::string(name) + "\"",
               .expected = "one of " + known});
}

}  // namespace kerf::cli
