// A mandible sawn through on the clock: how soon after the last bridge its pieces are objects of their own, and whether
// who follows them has their fields.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <map>
#include <mutex>
#include <thread>

#include "preprocess/demo/demo_anatomy.h"
#include "sim/hand/simulated_device.h"
#include "sim/live/haptic_thread.h"
#include "sim/live/mesher_thread.h"
#include "sim/run/load_scene.h"
#include "sim/run/replay.h"
#include "ui/bench/bench.h"

namespace kerf::cli {
namespace {

// Behind the last molars, the blade across the bone, teeth down: through on one side, then on the other.
CutPath throughBothSides(const BrickField& phi, double y, double half_blade) {
  Eigen::Matrix3d axes;
  axes.col(0) = Vec3d::UnitZ();
  axes.col(1) = -Vec3d::UnitY();
  axes.col(2) = Vec3d::UnitX();
  const Eigen::Quaterniond teeth_down(axes);
  const Box3 box = phi.bounds();
  constexpr double kSpeed = 15;  // mm/s
  CutPath path;
  for (const double side : {1.0, -1.0}) {
    double from = 0, to = 0, top = -1e9;
    for (double x = 5; x < box.max[0]; x += 0.5) {
      const double z = topAt(phi, side * x, y, box);
      if (std::isnan(z)) continue;
      if (from == 0) from = x;
      to = x;
      top = std::max(top, z);
    }
    const auto add = [&](double z, bool cuts) {
      const Vec3d at(0.5 * side * (from + to) - half_blade, y, z);
      double t = 0.5;
      if (!path.poses.empty()) {
        t = path.poses.back().t + (at - path.poses.back().T_object_tool.translation).norm() / kSpeed;
        path.cuts.push_back(cuts);
      }
      path.poses.push_back({t, {teeth_down, at}});
    };
    add(top + 1, false);
    add(box.min[2] - 0.5, true);
    add(top + 1, false);
  }
  return path;
}

// By the log: ticks from the first after which the object of a split was in pieces to the split.
Expected<std::vector<double>> ticksToSplit(const SessionLog& log, Model model,
                                           const std::shared_ptr<const BakedObject>& object, const Progress& progress) {
  constexpr std::uint64_t kBefore = 150;
  Rigid3 start;
  KERF_CHECK(restoreSettings(log, "log", model, start));
  struct Split {
    std::uint64_t tick;
    std::size_t object;
    std::uint64_t severed;
    std::size_t known;
  };
  std::vector<Split> splits;
  for (const SessionEvent& event : log.events)
    if (const auto* text = std::get_if<SessionCommand>(&event.what)) {
      KERF_TRY(command, parseCommand(text->text));
      if (const auto* of = std::get_if<SplitObject>(&command)) splits.push_back({event.tick, of->object, 0, 0});
    }
  Session session(std::move(model), {object}, start);
  StepOutput out;
  std::size_t event = 0, next = 0;
  std::unique_ptr<PieceFinder> finder;
  for (std::size_t n = 0; n < log.samples.size() && next < splits.size(); ++n) {
    if (!report(progress, static_cast<double>(n) / static_cast<double>(log.samples.size()),
                "looking for the last bridge"))
      return cancelled();
    for (; event < log.events.size() && log.events[event].samples_before <= n; ++event)
      if (const auto* text = std::get_if<SessionCommand>(&log.events[event].what)) {
        KERF_TRY(command, parseCommand(text->text));
        session.apply(command);
        if (std::holds_alternative<SplitObject>(command)) {
          ++next;
          finder.reset();
        }
      }
    session.tick(log.samples[n].sample, out);
    if (next == splits.size()) break;
    Split& split = splits[next];
    if (log.samples[n].tick + kBefore < split.tick || split.severed > 0) continue;
    CutObject& cut = session.object(split.object);
    std::vector<BrickEdit> edits;
    const auto collect = [&](const CutObject::Slot& slot) {
      BrickEdit& edit = edits.emplace_back();
      edit.brick = slot.brick;
      std::copy_n(slot.phi, kBrickNodes, edit.phi.begin());
      return true;
    };
    cut.changes(BrickSubscriber::kPieces).take(collect);
    if (!finder) {
      edits.clear();
      std::vector<Vec3i> bricks;
      for (int s = 0; s < cut.bricks().firstSlotCount(); ++s)
        if (cut.bricks().has(s)) bricks.push_back(cut.slot(s).brick);
      finder = std::make_unique<PieceFinder>(object->phi0(), bricks);
      for (int s = 0; s < cut.slotCount(); ++s)
        if (cut.slot(s).own) collect(cut.slot(s));
    }
    finder->apply(edits);
    if (finder->find().pieces.size() > 1) split.severed = log.samples[n].tick;
  }
  std::vector<double> ticks;
  for (const Split& split : splits)
    if (split.severed > 0) ticks.push_back(static_cast<double>(split.tick - split.severed));
  return ticks;
}

struct Piece {
  std::shared_ptr<const PieceOrigin> origin;
  std::shared_ptr<BrickFeed> feed;
  BrickField field;
  std::unique_ptr<MesherThread> mesher;
};

}  // namespace

Expected<Result> benchSever(const Scratch& scratch, const Progress& progress) {
  Result r{"sever", "the demo mandible at 0.1 mm, sawn through twice on the clock, mesher and recorder beside it",
           {},      "",
           0,       ""};
  KERF_TRY(anatomy, demoMandible(1, progress));
  KERF_TRY(folder, bakedDemo(anatomy, 0.1, scratch, progress));
  KERF_TRY(object, loadObject(folder));
  KERF_TRY(tool, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(model, makeModel(std::span(&tool, 1), {}, -static_cast<double>(object->phi0().interior())));
  model.settings.rendering = Rendering::kRigid;
  model.settings.geometry_only = true;
  const CutPath path = throughBothSides(object->phi0(), 58, 12.5);
  FeedHand hand(path);
  SimulatedDevice device(hand);
  std::mutex mutex;
  std::map<std::uint32_t, Piece> pieces;
  HapticOptions options;
  options.pieces.on_piece = [&](std::shared_ptr<const PieceOrigin> origin, std::shared_ptr<BrickFeed> its_feed) {
    const std::lock_guard lock(mutex);
    Piece& piece = pieces[origin->id];
    piece.origin = std::move(origin);
    piece.feed = std::move(its_feed);
  };
  HapticThread haptic(model, {object}, poseAt(path, 0), options);
  const std::filesystem::path file = scratch.path() / "sever.kerflog";
  KERF_TRY(recorder, SessionRecorder::start(file, describe(haptic.session())));
  BrickFeed feed;
  MesherThread mesher(object->phi0(), feed);
  while (mesher.take().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  BrickFeed* const feeds[] = {&feed};
  const StoppedAtTheEnd stopped{haptic};  // before what it writes to, should this be cancelled
  KERF_CHECK(haptic.start(device, feeds, &recorder));
  r.notes.push_back("granted: " + haptic.grant().summary());
  for (const RealTimeRefusal& refusal : haptic.grant().refusals) r.notes.push_back(refusal.message());

  double slowest_mesh = 0;
  while (!device.isOver()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
    static_cast<void>(mesher.take());
    haptic.update();
    // Not under the lock: the maker of pieces must not wait for a mesh.
    std::vector<Piece*> fresh;
    {
      const std::lock_guard lock(mutex);
      for (auto& [id, piece] : pieces)
        if (!piece.mesher) fresh.push_back(&piece);
    }
    for (Piece* const piece : fresh) {
      const double begin = now();
      piece->field = piece->origin->field();
      piece->mesher = std::make_unique<MesherThread>(piece->field, *piece->feed);
      while (piece->mesher->take().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      slowest_mesh = std::max(slowest_mesh, now() - begin);
    }
    const double done = 1e-3 * static_cast<double>(haptic.report().tick) / path.poses.back().t;
    if (!report(progress, std::min(done, 1.0), "sawing in real time")) return cancelled();
  }
  haptic.stop();
  KERF_CHECK(recorder.close());
  haptic.update();
  haptic.updateTimes();
  const HapticCounts& counts = haptic.report().counts;
  const HapticTimes& times = haptic.times();
  KERF_TRY(log, readSessionLog(file));
  KERF_TRY(ticks, ticksToSplit(log, model, object, progress));
  KERF_TRY(again, replay(log, file.string(), model, {object}, progress));
  r.state_hash = fmt::format("{:016x}", haptic.session().hash());
  const auto add = [&](const std::string& name, double value, const char* unit = "") {
    r.measured.push_back({name, value, unit, 0, false});
  };
  const auto none = [&](const char* name, double value) { r.measured.push_back({name, value, "", 0}); };
  add("bricks", static_cast<double>(object->slots().size()));
  add("voxel", object->voxel(), "mm");
  none("splits that are missing or too many", std::abs(static_cast<double>(counts.pieces.splits) - 2));
  add("crumbs", static_cast<double>(counts.pieces.crumbs));
  double most = 0;
  for (const double t : ticks) most = std::max(most, t);
  for (std::size_t n = 0; n < ticks.size(); ++n)
    add(fmt::format("split {}, ticks from the last bridge to objects of their own", n + 1), ticks[n]);
  r.measured.push_back({"most of them", ticks.size() == 2 ? most : 1e9, "ticks", 50});
  add("from the last look that found it whole to objects of their own, longest", counts.pieces.longest_split_ms, "ms");
  add("held, longest", counts.pieces.longest_freeze_ms, "ms");
  add("mesh of a piece made anew, slowest", slowest_mesh, "ms");
  for (const auto& [name, p] : {std::pair("p50", 0.5), {"p99", 0.99}, {"p99.9", 0.999}})
    add(fmt::format("tick, {}", name), times.cost.percentileMs(p), "ms");
  add("tick, max", times.cost.maxMs(), "ms");
  add("overruns", static_cast<double>(counts.overruns));
  add("ticks", static_cast<double>(counts.ticks));
  none("ticks that lacked room", static_cast<double>(counts.out_of_bricks));
  none("records lost", static_cast<double>(counts.records_lost + recorder.status().lost));
  if (!again.is_same)
    r.notes.push_back(fmt::format("the replay differs from tick {} on: {}", again.differs_at, again.note));
  none("replay differs", !again.is_same || again.state_hash != r.state_hash);
  return r;
}

}  // namespace kerf::cli
