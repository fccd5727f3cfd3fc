// The 1 kHz thread on the clock: what the system grants, how punctual it is, and whether its log, its bricks and its
// mesh are all of the same cut.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <map>
#include <thread>

#include "geometry/tool/tool_file.h"
#include "preprocess/demo/demo_anatomy.h"
#include "sim/hand/simulated_device.h"
#include "sim/live/haptic_thread.h"
#include "sim/live/mesher_thread.h"
#include "sim/object/overlay_field.h"
#include "sim/run/load_scene.h"
#include "sim/run/replay.h"
#include "ui/bench/bench.h"

namespace kerf::cli {
namespace {

// Strokes of 2 s that wander over the occlusal surface and go deeper, the bur lifted for 0.5 s in between.
CutPath drilling(double seconds, double top) {
  constexpr double kStep = 0.02, kStroke = 2, kRest = 0.5, kDeepest = 2.5;
  CutPath path;
  for (double t = 0; t < seconds; t += kStep) {
    const bool cuts = std::fmod(t, kStroke + kRest) < kStroke;
    const double lift = cuts ? 0 : std::sin(M_PI * (std::fmod(t, kStroke + kRest) - kStroke) / kRest);
    const Vec3d at(1.3 * std::sin(1.9 * t), 1.1 * std::sin(1.3 * t), top - kDeepest * t / seconds + 1.5 * lift);
    if (!path.poses.empty()) path.cuts.push_back(cuts);
    path.poses.push_back({t, {Eigen::Quaterniond::Identity(), at}});
  }
  return path;
}

void addTimes(Result& r, const std::string& what, const TimeHistogram& times) {
  for (const auto& [name, p] : {std::pair("p50", 0.5), {"p99", 0.99}, {"p99.9", 0.999}})
    r.measured.push_back({fmt::format("{}, {}", what, name), times.percentileMs(p), "ms", 0, false});
  r.measured.push_back({fmt::format("{}, max", what), times.maxMs(), "ms", 0, false});
}

// Chunks that differ from those of a mesh made anew from the field as it is at the end.
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

}  // namespace

Expected<Result> benchRealtime(double seconds, const Scratch& scratch, const Progress& progress) {
  Result r{"realtime",
           fmt::format("{:g} s on the clock: round-014 in the demo molar at 0.05 mm, mesher and recorder beside it, "
                       "strokes taken back and brought back",
                       seconds),
           {},
           "",
           0,
           ""};
  KERF_TRY(anatomy, demoMolarAnatomy(1, progress));
  KERF_TRY(folder, bakedDemo(anatomy, 0.05, scratch, progress));
  KERF_TRY(object, loadObject(folder));
  KERF_TRY(tool, toolOfRack("round-014"));
  KERF_TRY(model, makeModel(std::span(&tool, 1), {}, -static_cast<double>(object->phi0().interior())));
  const CutPath path = drilling(seconds, topAt(object->phi0(), 0, 0, object->phi0().bounds()) + 0.3);
  DeviceHand::Options firm;
  firm.hand_stiffness = 1;
  DeviceHand hand(path, firm);
  SimulatedDevice device(hand);
  HapticThread haptic(model, {object}, poseAt(path, 0));
  const std::filesystem::path file = scratch.path() / "realtime.kerflog";
  KERF_TRY(recorder, SessionRecorder::start(file, describe(haptic.session())));
  BrickFeed feed;
  MesherThread mesher(object->phi0(), feed);
  std::map<std::uint64_t, MeshChunkPtr> mesh;
  const auto follow = [&] {
    for (const MeshChunkPtr& chunk : mesher.take()) mesh[coordKey(chunk->brick)] = chunk;
  };
  while (mesh.empty()) {
    follow();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  BrickFeed* const feeds[] = {&feed};
  const StoppedAtTheEnd stopped{haptic};  // before what it writes to, should this be cancelled
  KERF_CHECK(haptic.start(device, feeds, &recorder));
  r.notes.push_back("granted: " + haptic.grant().summary());
  for (const RealTimeRefusal& refusal : haptic.grant().refusals) r.notes.push_back(refusal.message());

  int sent = 0;
  while (!device.isOver()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
    follow();
    haptic.update();
    const double done = 1e-3 * static_cast<double>(haptic.report().tick) / seconds;
    // Right after each other: what is cut since an undo ends what could be redone.
    if (sent == 0 && done > 0.5) sent += haptic.send(Undo{}) && haptic.send(Redo{});
    if (sent == 1 && done > 0.75) sent += haptic.send(Undo{});
    if (!report(progress, std::min(done, 1.0), "drilling in real time"))
      return fail({Error::Code::kCancelled, "", "", "cancelled", "", ""});
  }
  haptic.stop();
  mesher.stop();
  follow();
  KERF_CHECK(recorder.close());
  haptic.update();
  haptic.updateTimes();
  const HapticCounts& counts = haptic.report().counts;
  const HapticTimes& times = haptic.times();
  const auto add = [&](const char* name, double value, const char* unit = "") {
    r.measured.push_back({name, value, unit, 0, false});
  };
  const auto none = [&](const char* name, std::uint64_t value) {
    r.measured.push_back({name, static_cast<double>(value), "", 0});
  };
  add("ticks", static_cast<double>(counts.ticks));
  addTimes(r, "tick", times.cost);
  addTimes(r, "wake-up late", times.lateness);
  addTimes(r, "period off 1 ms", times.jitter);
  add("overruns", static_cast<double>(counts.overruns));
  add("periods missed", static_cast<double>(counts.missed_periods));
  add("stalls", static_cast<double>(counts.stalls));
  add("commands done", static_cast<double>(counts.commands_done));
  add("pauses for undo, redo, room", static_cast<double>(counts.pauses));
  add("longest pause", counts.longest_pause_ms, "ms");
  add("rooms taken", static_cast<double>(counts.pools_taken));
  none("ticks that lacked room", counts.out_of_bricks);
  none("records lost", counts.records_lost + recorder.status().lost);
  add("bricks pushed to the mesher", static_cast<double>(counts.edits_pushed));
  none("of them not meshed", counts.edits_pushed - mesher.editsDone() + haptic.unsentBricks());
  none("chunks unlike those of the final field", chunksThatDiffer(haptic.session().state().objects[0], mesh));

  KERF_TRY(log, readSessionLog(file));
  KERF_TRY(again, replay(log, file.string(), model, {object}, progress));
  add("removed", again.removed_mm3, "mm3");
  add("state checks in the log", static_cast<double>(again.checks));
  r.state_hash = fmt::format("{:016x}", haptic.session().hash());
  none("replay differs", !again.is_same || again.state_hash != r.state_hash);
  for (const Measured& m : r.measured)
    if (!m.passed())
      return fail({Error::Code::kBadValue, file.string(), m.name, fmt::format("{:g}", m.value), "0",
                   again.note.empty() ? "report this, with the machine" : again.note});
  return r;
}

}  // namespace kerf::cli
