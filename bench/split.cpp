// A mandible is sawn through in real time: delay from the last bridge to separate objects, and whether subscribers have
// their fields.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <map>
#include <mutex>
#include <thread>

#include "bench/bench.h"
#include "bench/live.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/simulated_device.h"
#include "preprocess/demo/demo_anatomy.h"
#include "sim/live/haptic_thread.h"
#include "sim/live/mesher_thread.h"
#include "sim/run/report/replay.h"
#include "sim/run/scene/load_scene.h"
#include "sim/session/command.h"

namespace kerf::cli {
namespace {

using namespace scenes;

// Behind the last molars, the blade across the bone, teeth down: through one side, then the other.
CutPath throughBothSides(const BrickField& phi, double y, double half_blade) {
  constexpr double kSpeed = 15;  // mm/s
  const double bottom = phi.bounds().min[2];
  CutPath path;
  for (const double side : {1.0, -1.0}) {
    const BoneAcross bone = boneAcross(phi, y, side);
    const auto add = [&](double z, bool cuts) {
      const Vec3d at(0.5 * side * (bone.from + bone.to) - half_blade, y, z);
      double t = 0.5;
      if (!path.poses.empty()) {
        t = path.poses.back().t + (at - path.poses.back().T_object_tool.translation).norm() / kSpeed;
        path.cuts.push_back(cuts);
      }
      path.poses.push_back({t, {teethDown(), at}});
    };
    add(bone.top + 1, false);
    add(bottom - 0.5, true);
    add(bone.top + 1, false);
  }
  return path;
}

// A split in the log: the tick at which the session made the pieces separate objects.
struct LoggedSplit {
  std::uint64_t tick;
  std::size_t object;
  std::uint64_t in_pieces = 0;  // the first tick with the object in pieces; 0: not found
};

Expected<std::vector<LoggedSplit>> splitsOf(const SessionLog& log) {
  std::vector<LoggedSplit> splits;
  for (const SessionEvent& event : log.events)
    if (const auto* text = std::get_if<SessionCommand>(&event.what)) {
      KERF_TRY(command, parseCommand(text->text));
      if (const auto* of = std::get_if<SplitObject>(&command)) splits.push_back({event.tick, of->object});
    }
  return splits;
}

// Finds the pieces of an object during a replay, from a given moment on.
class PieceWatch {
 public:
  // Whether the object is in pieces now.
  bool isInPieces(CutObject& cut, const BrickField& phi0) {
    std::vector<BrickEdit> edits;
    const auto collect = [&](const CutObject::Slot& slot) {
      appendEdit(edits, slot);
      return true;
    };
    cut.changes(BrickSubscriber::kPieces).take(collect);
    if (!finder_) {
      edits.clear();
      std::vector<Vec3i> bricks;
      for (int s = 0; s < cut.bricks().firstSlotCount(); ++s)
        if (cut.bricks().has(s)) bricks.push_back(cut.slot(s).brick);
      finder_ = std::make_unique<PieceFinder>(phi0, bricks);
      for (int s = 0; s < cut.slotCount(); ++s)
        if (cut.slot(s).own) collect(cut.slot(s));
    }
    finder_->apply(edits);
    return finder_->find().pieces.size() > 1;
  }
  void reset() { finder_.reset(); }

 private:
  std::unique_ptr<PieceFinder> finder_;
};

// From the log: ticks between the separation of an object and its split.
Expected<std::vector<double>> ticksToSplit(const SessionLog& log, Model model,
                                           const std::shared_ptr<const BakedObject>& object, const Bench& bench) {
  constexpr std::uint64_t kBefore = 150;  // ticks before a split at which the search for pieces starts
  Rigid3 start;
  KERF_CHECK(restoreSettings(log, "log", model, start));
  KERF_TRY(splits, splitsOf(log));
  Session session(std::move(model), {object}, start);
  PieceWatch watch;
  StepOutput out;
  std::size_t event = 0, next = 0;
  for (std::size_t n = 0; n < log.samples.size() && next < splits.size(); ++n) {
    if (!report(bench.progress, static_cast<double>(n) / static_cast<double>(log.samples.size()),
                "looking for the last bridge"))
      return cancelled();
    for (; event < log.events.size() && log.events[event].samples_before <= n; ++event)
      if (const auto* text = std::get_if<SessionCommand>(&log.events[event].what)) {
        KERF_TRY(command, parseCommand(text->text));
        session.apply(command);
        if (std::holds_alternative<SplitObject>(command)) {
          ++next;
          watch.reset();
        }
      }

    session.tick(log.samples[n].sample, out);
    if (next == splits.size()) break;

    LoggedSplit& split = splits[next];
    if (log.samples[n].tick + kBefore < split.tick || split.in_pieces > 0) continue;
    if (watch.isInPieces(session.object(split.object), object->phi0())) split.in_pieces = log.samples[n].tick;
  }

  std::vector<double> ticks;
  for (const LoggedSplit& split : splits)
    if (split.in_pieces > 0) ticks.push_back(static_cast<double>(split.tick - split.in_pieces));
  return ticks;
}

// A subscriber of the pieces: each has its own field and a mesher that starts from it.
class ShownPieces {
 public:
  // Called by the maker of pieces, on its thread.
  void add(std::shared_ptr<const PieceOrigin> origin, std::shared_ptr<BrickFeed> feed) {
    const std::lock_guard lock(mutex_);
    Piece& piece = pieces_[origin->id];
    piece.origin = std::move(origin);
    piece.feed = std::move(feed);
  }

  // Makes the meshes of new pieces and notes the slowest.
  void meshNewPieces() {
    // Not under the lock: the maker of pieces must not wait for a mesh.
    std::vector<Piece*> fresh;
    {
      const std::lock_guard lock(mutex_);
      for (auto& [id, piece] : pieces_)
        if (!piece.mesher) fresh.push_back(&piece);
    }
    for (Piece* const piece : fresh) {
      const double begin = now();
      piece->field = piece->origin->field();
      piece->mesher = std::make_unique<MesherThread>(piece->field, *piece->feed);
      while (piece->mesher->take().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      slowest_ms_ = std::max(slowest_ms_, now() - begin);
    }
  }

  double slowestMesh() const { return slowest_ms_; }

 private:
  struct Piece {
    std::shared_ptr<const PieceOrigin> origin;
    std::shared_ptr<BrickFeed> feed;
    BrickField field;
    std::unique_ptr<MesherThread> mesher;
  };
  std::mutex mutex_;
  std::map<std::uint32_t, Piece> pieces_;
  double slowest_ms_ = 0;
};

// @param ticks  from the last bridge to separate objects, per split.
void addSplits(Result& r, const HapticThread& haptic, const SessionRecorder& recorder, const std::vector<double>& ticks,
               double slowest_mesh) {
  const HapticCounts& counts = haptic.report().counts;
  const HapticTimes& times = haptic.times();
  r.add("splits that are missing or too many", std::abs(static_cast<double>(counts.pieces.splits) - 2));
  r.add("crumbs", static_cast<double>(counts.pieces.crumbs));

  double most = 0;
  for (const double t : ticks) most = std::max(most, t);
  for (std::size_t n = 0; n < ticks.size(); ++n)
    r.add(fmt::format("split {}, ticks from the last bridge to objects of their own", n + 1), ticks[n]);
  r.add("most of them", ticks.size() == 2 ? most : 1e9, "ticks");
  r.add("from the last look that found it whole to objects of their own, longest", counts.pieces.longest_split_ms,
        "ms");
  r.add("held, longest", counts.pieces.longest_freeze_ms, "ms");
  r.add("mesh of a piece made anew, slowest", slowest_mesh, "ms");

  for (const auto& [name, p] : {std::pair("p50", 0.5), {"p99", 0.99}, {"p99.9", 0.999}})
    r.add(fmt::format("tick, {}", name), times.cost.percentileMs(p), "ms");
  r.add("tick, max", times.cost.maxMs(), "ms");
  r.add("overruns", static_cast<double>(counts.overruns));
  r.add("ticks", static_cast<double>(counts.ticks));
  r.add("ticks that lacked room", static_cast<double>(counts.out_of_bricks));
  r.add("records lost", static_cast<double>(counts.records_lost + recorder.status().lost));
}

}  // namespace

Expected<Result> benchSplit(const Bench& bench) {
  Result r(SceneId::kSplit,
           "the demo mandible at 0.1 mm, sawn through twice on the clock, mesher and recorder beside it");
  KERF_TRY(anatomy, demoMandible(1, bench.progress));
  KERF_TRY(folder, bakedDemo(anatomy, 0.1, bench));
  KERF_TRY(object, loadObject(folder));
  KERF_TRY(tool, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(model, makeModel(std::span(&tool, 1), {}, -static_cast<double>(object->phi0().interior())));
  model.settings.rendering = Rendering::kRigid;
  model.settings.geometry_only = true;

  const CutPath path = throughBothSides(object->phi0(), 58, 12.5);
  FeedHand hand(path);
  SimulatedDevice device(hand);

  ShownPieces pieces;
  HapticOptions options;
  options.pieces.on_piece = [&](std::shared_ptr<const PieceOrigin> origin, std::shared_ptr<BrickFeed> its_feed) {
    pieces.add(std::move(origin), std::move(its_feed));
  };
  HapticThread haptic(model, {object}, poseAt(path, 0), options);

  const std::filesystem::path file = bench.scratch.path() / "split.kerflog";
  KERF_TRY(recorder, SessionRecorder::start(file, describe(haptic.session())));
  BrickFeed feed;
  MesherThread mesher(object->phi0(), feed);
  while (mesher.take().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(5));

  BrickFeed* const feeds[] = {&feed};
  const StoppedAtTheEnd stopped{haptic};  // before its output, should this be cancelled
  KERF_CHECK(haptic.start(device, feeds, &recorder));
  addGrant(r, haptic);
  while (!device.isOver()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
    static_cast<void>(mesher.take());
    haptic.update();
    pieces.meshNewPieces();
    const double done = 1e-3 * static_cast<double>(haptic.report().tick) / path.poses.back().t;
    if (!report(bench.progress, std::min(done, 1.0), "sawing in real time")) return cancelled();
  }
  haptic.stop();
  KERF_CHECK(recorder.close());
  haptic.update();
  haptic.updateTimes();

  KERF_TRY(log, readSessionLog(file));
  KERF_TRY(ticks, ticksToSplit(log, model, object, bench));
  KERF_TRY(again, replay(log, file.string(), model, {object}, bench.progress));
  r.add("bricks", static_cast<double>(object->slots().size()));
  r.add("voxel", object->voxel(), "mm");
  addSplits(r, haptic, recorder, ticks, pieces.slowestMesh());
  addReplay(r, haptic, again);
  return r;
}

}  // namespace kerf::cli
