#include "bench/scene_table.h"

#include <fmt/format.h>

#include "bench/goals.h"

namespace kerf::cli {
namespace {

using namespace goals;
constexpr auto kTimesOnly = Scene::kTimesOnly;

constexpr Scene kScenes[] = {
    {SceneId::kBake, "bake", "mesh to case, against the bare library call; --mesh selects the mesh", benchBake,
     kTimesOnly},
    {SceneId::kMandible, "mandible", "the same, the demo mandible: time and memory", benchMandible, kTimesOnly},
    {SceneId::kOpen, "open",
     "a case from its files to an object to cut: processor time and memory; --case selects the case", benchOpen,
     kOpenGoals},
    {SceneId::kCutBur, "cut-bur", "motions of a round bur, and of a fluted mesh of it, in a block at 0.05 mm",
     benchCutBur, kCutBurGoals},
    {SceneId::kExport, "export", "run to printable STL; --mesh selects the mesh", benchExport, kExportGoals},
    {SceneId::kPoints, "points", "shell nodes against a tool's fields: 50 000 and 200 000 of them", benchPoints,
     kPointsGoals},
    {SceneId::kTickBur, "tick-bur", "whole ticks: taper 016 in the demo molar at 0.05 mm", benchTickBur, kTickBurGoals},
    {SceneId::kTickSaw, "tick-saw", "whole ticks: a 25 mm blade in the demo mandible at 0.1 mm", benchTickSaw,
     kTickSawGoals},
    {SceneId::kTickFine, "tick-fine", "whole ticks: 10 mm of a blade, and a ball of 6 mm, sunk in bone at 0.05 mm",
     benchTickFine, kTickFineGoals},
    {SceneId::kTickSizes, "tick-sizes", "the same contact in three sizes of object", benchTickSizes, kTickSizesGoals},
    {SceneId::kRealtime, "realtime",
     "the same on the clock, on its thread, with mesher and recorder; --seconds sets the duration", benchRealtime,
     kRealtimeGoals},
    {SceneId::kInvariance, "invariance", "force and removal over voxels, attitudes, time: no times, the same anywhere",
     benchInvariance, kInvarianceGoals},
    {SceneId::kSharp, "sharp", "the same for twelve tools with edges and points: a table, no times", benchSharp,
     kSharpGoals},
    {SceneId::kSharpRack, "sharp-rack",
     "force and removal of every tool of the rack over voxels and attitudes; only runs by name", benchSharpRack,
     kSharpRackGoals, Scene::When::kOnlyByName},
    {SceneId::kForces, "forces", "constant force and constant feed per material: no times", benchForces, kForcesGoals},
    {SceneId::kDrives, "drives", "turbine and electric drive under a hand's force: no times", benchDrives,
     kDrivesGoals},
    {SceneId::kDrillSites, "drill-sites", "implant drills: feed, seconds a site, powers of thrust: no times",
     benchDrillSites, kDrillSitesGoals},
    {SceneId::kSaw, "saw", "kerf, plane and side force over attitudes: no times", benchSaw, kSawGoals},
    {SceneId::kHeat, "heat", "temperatures of tissue, pulp and bone against measurements: no times", benchHeat,
     kHeatGoals},
    {SceneId::kResponse, "response", "penalty, constraint and impulse, coupled and direct: a table", benchResponse,
     kResponseGoals},
    {SceneId::kSink, "sink", "every tool, its drive off, pushed and tapped into enamel: no times", benchSink,
     kSinkGoals},
    {SceneId::kTunnelling, "tunnelling", "a wall of 0.3 mm at 0.1 to 1 m/s: tunnelling", benchTunnelling,
     kTunnellingGoals},
    {SceneId::kEdges, "edges", "every tool, its drive off, slid off edges, thin walls, over a groove: no times",
     benchEdges, kEdgesGoals},
    {SceneId::kLedger, "ledger", "volumes by the ledger against those of the mesh, 10 000 strokes: no times",
     benchLedger, kLedgerGoals},
    {SceneId::kPieces, "pieces", "planes, rings, bridges, crumbs: how many pieces, how soon known", benchPieces,
     kPiecesGoals},
    {SceneId::kSplit, "sever", "a mandible sawn through on the clock: how soon its pieces are objects of their own",
     benchSplit, kSplitGoals},
    {SceneId::kPassivity, "passivity", "energy given to a simulated device, over hands and stiffnesses: no times",
     benchPassivity, kPassivityGoals},
    {SceneId::kPassivityLarge, "passivity-large", "the same over 11 664 devices and hands: minutes; only runs by name",
     benchPassivityLarge, kPassivityLargeGoals, Scene::When::kOnlyByName},
    {SceneId::kDevices, "devices",
     "random devices in random hands, the coupling of their profile; a simulated arm on the clock", benchDevices,
     kDevicesGoals},
    {SceneId::kWindowSession, "window-session",
     "a scan opened, drilled and exported by kerf-sim, its frames on the clock; only runs by name", benchWindowSession,
     kWindowSessionGoals, Scene::When::kOnlyByName},
    {SceneId::kWindowMemory, "window-memory",
     "memory of kerf-sim over many strokes, by growing part; --minutes sets the duration; only runs by name",
     benchWindowMemory, kWindowMemoryGoals, Scene::When::kOnlyByName},
};

#ifndef __SANITIZE_ADDRESS__  // GCC 12 then takes no address of a function for a constant
// Every id has its row, in order, and every row is complete.
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
               .found = fmt::format("\"{}\"", name),
               .expected = fmt::format("one of {}", known)});
}

}  // namespace kerf::cli
