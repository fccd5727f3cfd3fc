// The 1 kHz thread in real time: grants of the system, punctuality, and agreement of log, bricks and mesh.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <map>
#include <numbers>
#include <thread>

#include "bench/bench.h"
#include "bench/live.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/simulated_device.h"
#include "preprocess/demo/demo_anatomy.h"
#include "sim/live/haptic_thread.h"
#include "sim/live/mesher_thread.h"
#include "sim/object/overlay_field.h"
#include "sim/run/report/replay.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

using namespace scenes;

// Strokes of 2 s that wander over the occlusal surface and go deeper. The bur is lifted for 0.5 s in between.
CutPath drilling(double seconds, double top) {
  constexpr double kStep = 0.02, kStroke = 2, kRest = 0.5, kDeepest = 2.5;
  CutPath path;
  for (double t = 0; t < seconds; t += kStep) {
    const bool cuts = std::fmod(t, kStroke + kRest) < kStroke;
    const double lift = cuts ? 0 : std::sin(std::numbers::pi * (std::fmod(t, kStroke + kRest) - kStroke) / kRest);
    const Vec3d at(1.3 * std::sin(1.9 * t), 1.1 * std::sin(1.3 * t), top - kDeepest * t / seconds + 1.5 * lift);
    if (!path.poses.empty()) path.cuts.push_back(cuts);
    path.poses.push_back({t, {Eigen::Quaterniond::Identity(), at}});
  }
  return path;
}

void addTimes(Result& r, const std::string& what, const TimeHistogram& times) {
  for (const auto& [name, p] : {std::pair("p50", 0.5), {"p99", 0.99}, {"p99.9", 0.999}})
    r.add(fmt::format("{}, {}", what, name), times.percentileMs(p), "ms");
  r.add(fmt::format("{}, max", what), times.maxMs(), "ms");
}

// Number of chunks that differ from a fresh mesh of the final field.
std::size_t chunksThatDiffer(const CutObject& object, const std::map<std::uint64_t, MeshChunkPtr>& mesh) {
  OverlayField field(object.baked().phi0());
  const BrickField changed = object.bricks().changedField();
  for (std::size_t b = 0; b < changed.brickCount(); ++b) field.set({changed.brickCoord(b), changed.brick(b)});
  const BrickField whole = field.flattened();
  const Remesher anew(whole);
  std::size_t differ = 0, known = 0;
  for (const auto& [key, chunk] : mesh) known += !chunk->isEmpty();
  const auto wanted = anew.changedSince(0);
  for (const MeshChunkPtr& chunk : wanted) {
    const auto mine = mesh.find(coordKey(chunk->brick));
    differ +=
        mine == mesh.end() || mine->second->vertices != chunk->vertices || mine->second->triangles != chunk->triangles;
  }
  return differ + (known > wanted.size() ? known - wanted.size() : 0);
}

// All chunks of the mesher so far.
struct ShownMesh {
  std::map<std::uint64_t, MeshChunkPtr> chunks;
  void take(MesherThread& mesher) {
    for (const MeshChunkPtr& chunk : mesher.take()) chunks[coordKey(chunk->brick)] = chunk;
  }
};

// Waits for the end of the hand's path. Undoes and redoes a stroke after half of it, undoes another after three
// quarters.
Expected<void> drillOnTheClock(HapticThread& haptic, const SimulatedDevice& device, MesherThread& mesher,
                               ShownMesh& mesh, const Bench& bench) {
  int sent = 0;
  while (!device.isOver()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
    mesh.take(mesher);
    haptic.update();
    const double done = 1e-3 * static_cast<double>(haptic.report().tick) / bench.seconds;
    // In immediate succession: a cut after an undo would clear the redo list.
    if (sent == 0 && done > 0.5) sent += haptic.send(Undo{}) && haptic.send(Redo{});
    if (sent == 1 && done > 0.75) sent += haptic.send(Undo{});
    if (!report(bench.progress, std::min(done, 1.0), "drilling in real time")) return cancelled();
  }
  return {};
}

void addThread(Result& r, const HapticThread& haptic, const SessionRecorder& recorder, const MesherThread& mesher,
               const ShownMesh& mesh) {
  const HapticCounts& counts = haptic.report().counts;
  const HapticTimes& times = haptic.times();
  r.add("ticks", static_cast<double>(counts.ticks));
  addTimes(r, "tick", times.cost);
  addTimes(r, "wake-up late", times.lateness);
  addTimes(r, "period off 1 ms", times.jitter);
  r.add("overruns", static_cast<double>(counts.overruns));
  r.add("periods missed", static_cast<double>(counts.missed_periods));
  r.add("stalls", static_cast<double>(counts.stalls));
  r.add("commands done", static_cast<double>(counts.commands_done));
  r.add("pauses for undo, redo, room", static_cast<double>(counts.pauses));
  r.add("longest pause", counts.longest_pause_ms, "ms");
  r.add("rooms taken", static_cast<double>(counts.pools_taken));
  r.add("ticks that lacked room", static_cast<double>(counts.out_of_bricks));
  r.add("records lost", static_cast<double>(counts.records_lost + recorder.status().lost));
  r.add("bricks pushed to the mesher", static_cast<double>(counts.edits_pushed));
  r.add("of them not meshed", static_cast<double>(counts.edits_pushed - mesher.editsDone() + haptic.unsentBricks()));
  r.add("chunks unlike those of the final field",
        static_cast<double>(chunksThatDiffer(haptic.session().state().objects[0], mesh.chunks)));
}

}  // namespace

Expected<Result> benchRealtime(const Bench& bench) {
  Result r(SceneId::kRealtime,
           fmt::format("{:g} s on the clock: round-014 in the demo molar at 0.05 mm, mesher and recorder beside it, "
                       "strokes taken back and brought back",
                       bench.seconds));
  KERF_TRY(anatomy, demoMolarAnatomy(1, bench.progress));
  KERF_TRY(folder, bakedDemo(anatomy, 0.05, bench));
  KERF_TRY(object, loadObject(folder));
  KERF_TRY(tool, toolOfRack("round-014"));
  KERF_TRY(model, makeModel(std::span(&tool, 1), {}, -static_cast<double>(object->phi0().interior())));
  const CutPath path = drilling(bench.seconds, topAt(object->phi0(), 0, 0, object->phi0().bounds()) + 0.3);
  DeviceHand::Options firm;
  firm.hand_stiffness = 1;
  DeviceHand hand(path, firm);
  SimulatedDevice device(hand);

  HapticThread haptic(model, {object}, poseAt(path, 0));
  const std::filesystem::path file = bench.scratch.path() / "realtime.kerflog";
  KERF_TRY(recorder, SessionRecorder::start(file, describe(haptic.session())));
  BrickFeed feed;
  MesherThread mesher(object->phi0(), feed);
  ShownMesh mesh;
  while (mesh.chunks.empty()) {
    mesh.take(mesher);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }

  BrickFeed* const feeds[] = {&feed};
  const StoppedAtTheEnd stopped{haptic};  // before its output, should this be cancelled
  KERF_CHECK(haptic.start(device, feeds, &recorder));
  addGrant(r, haptic);
  KERF_CHECK(drillOnTheClock(haptic, device, mesher, mesh, bench));
  haptic.stop();
  mesher.stop();
  mesh.take(mesher);
  KERF_CHECK(recorder.close());
  haptic.update();
  haptic.updateTimes();

  addThread(r, haptic, recorder, mesher, mesh);
  KERF_TRY(log, readSessionLog(file));
  KERF_TRY(again, replay(log, file.string(), model, {object}, bench.progress));
  r.add("removed", again.removed_mm3, "mm3");
  // Idle ticks would meet every other goal: a thread that stalled and latched measured nothing.
  r.add("removed a second", again.removed_mm3 / bench.seconds, "mm3/s");
  if (const auto stalls = haptic.report().counts.stalls; stalls > 0)
    r.notes.push_back(
        fmt::format("the thread stalled {} times and released the hand: no cuts after the last stall", stalls));
  r.add("state checks in the log", static_cast<double>(again.checks));
  addReplay(r, haptic, again);
  return r;
}

}  // namespace kerf::cli
