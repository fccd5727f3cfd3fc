#include "sim/run/session/watched_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "geometry/case/case_bundle.h"
#include "sim/monitor/heat.h"
#include "sim/pieces/piece_origin.h"
#include "sim/run/files/removed_volumes.h"
#include "sim/run/files/run_files.h"
#include "sim/run/scene/chunk_look.h"
#include "sim/session/state_bytes.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr auto kBatch = milliseconds(8);       // of ticks between two checks for requests
constexpr auto kMostLate = milliseconds(250);  // a longer delay is not caught up
constexpr std::size_t kJumpBatch = 64;         // ticks

std::size_t loadedIndex(const LoadedObjects& objects, const BakedObject* baked) {
  const auto at = std::find_if(objects.begin(), objects.end(), [&](const auto& o) { return o.get() == baked; });
  return at == objects.end() ? 0 : static_cast<std::size_t>(at - objects.begin());
}

// The current values of a brick, whether the object has it or not.
BrickValues valuesOf(const CutObject& object, const Vec3i& brick) {
  BrickValues out;
  const int slot = object.find(brick);
  const BrickField& phi0 = object.baked().phi0();
  if (slot >= 0)
    std::copy_n(object.slot(slot).phi, kBrickNodes, out.begin());
  else
    out.fill(object.bricks().isPiece() ? phi0.background() : phi0.constantAt(brick));
  return out;
}

}  // namespace

// ---- Loading

Expected<std::unique_ptr<WatchedRun>> WatchedRun::open(const fs::path& run_folder, WatchOptions options,
                                                       const Progress& progress) {
  std::unique_ptr<WatchedRun> out(new WatchedRun(run_folder, std::move(options)));
  KERF_CHECK(out->load(progress));
  WatchedRun& run = *out;
  run.thread_ = std::thread([&run] { run.run(); });
  return out;
}

Expected<void> WatchedRun::load(const Progress& progress) {
  KERF_TRY(manifest, readRunManifest(folder_));
  KERF_CHECK(requireEnded(folder_, manifest));
  KERF_TRY(recording, internal::loadRecording(folder_, manifest, progress));
  recording_ = std::move(recording);
  log_name_ = recording_.log_file.string();
  KERF_CHECK(restoreSettings(recording_.log, log_name_, recording_.model, place_));
  original_ = {recording_.objects.front(), &recording_.objects.front()->phi0()};
  if (recording_.begin) {
    KERF_TRY(original, readCaseField(caseFolder()));
    for (const double volume : internal::removedVolumes(original, *recording_.begin, internal::materialsOf(object())))
      removed_before_ += volume;
    original_ = std::make_shared<const BrickField>(std::move(original));
  }
  if (options_.is_looked_at) KERF_CHECK(chooseColours());
  if (!report(progress, 0.9, "reading the log")) return fail({.code = Error::Code::kCancelled, .found = "cancelled"});
  findSteps();
  if (options_.is_looked_at) KERF_CHECK(watchHeat(progress));
  player_.emplace(recording_.log, log_name_, recording_.model, place_, recording_.objects,
                  internal::LogPlayer::Start{});
  output_.T_world_tool = player_->session().state().body.pose;
  return {};
}

// For neighbours that were cut before, distance alone separates the floors of those cuts from their scans.
Expected<void> WatchedRun::chooseColours() {
  for (std::size_t n = 0; n < recording_.objects.size(); ++n) {
    const std::shared_ptr<const BakedObject>& object = recording_.objects[n];
    KERF_TRY(scan, internal::scanColoursOf(recording_.cases[n]));
    has_scan_colours_ |= scan != nullptr;
    if (n == 0) scan_colours_ = scan;
    const std::shared_ptr<const BrickField> loaded{object, &object->phi0()};
    KERF_TRY(
        look,
        internal::chunkLook(
            {.object = object, .scan = std::move(scan), .original = n == 0 ? original_ : loaded, .is_beside = n > 0}));
    looks_.push_back(std::move(look));
  }
  return {};
}

// Uses the laws of the live session: the log holds no temperature.
Expected<void> WatchedRun::watchHeat(const Progress& progress) {
  if (!report(progress, 0.93, "measuring distances to pulp and nerve")) return cancelled();
  const Progress rest = [&](double done, std::string_view step) { return report(progress, 0.93 + 0.07 * done, step); };
  KERF_TRY(structures, Structures::of(object(), rest));
  structures_ = std::move(structures);
  heat_ = std::make_unique<LiveHeat>(model().tools);
  heat_->watch(structures_);

  std::vector<bool> is_used(tools().size());
  for (const WatchedStep& step : steps_)
    if (step.tool < is_used.size()) is_used[step.tool] = true;
  for (std::size_t n = 0; n < is_used.size(); ++n)
    if (is_used[n]) heat_->add(n, ToolSamples(model().tools[n].cut, kToolSamples), heatSource(tools()[n]));
  cold_ = heat_->memory();
  return {};
}

// Strokes by their marks, the rest by the commands.
void WatchedRun::findSteps() {
  std::size_t tool = 0;
  std::optional<std::size_t> stroke;  // the current one
  for (const SessionEvent& event : recording_.log.events) {
    const std::size_t at = event.samples_before;
    if (const auto* mark = std::get_if<StrokeMark>(&event.what)) {
      if (*mark == StrokeMark::kBegin) {
        stroke = steps_.size();
        steps_.push_back({WatchedStep::Kind::kStroke, at, samples(), tool});
      } else if (stroke) {
        steps_[*std::exchange(stroke, std::nullopt)].end = at;
      }
      continue;
    }
    const auto* text = std::get_if<SessionCommand>(&event.what);
    const Expected<Command> command = text ? parseCommand(text->text) : Expected<Command>(fail({}));
    if (!command || at == 0) continue;  // before the first sample: start of the session
    if (const auto* select = std::get_if<SelectTool>(&*command)) tool = select->tool;
    const std::size_t end = std::min(at + 1, samples());  // the sample after a command executes it
    if (std::holds_alternative<MoveObject>(*command)) steps_.push_back({WatchedStep::Kind::kMove, at, end, tool});
    if (std::holds_alternative<CutByPlanes>(*command)) steps_.push_back({WatchedStep::Kind::kPlaneCut, at, end, tool});
    if (std::holds_alternative<DeleteObjects>(*command)) steps_.push_back({WatchedStep::Kind::kDelete, at, end, tool});
    if (std::holds_alternative<Undo>(*command)) steps_.push_back({WatchedStep::Kind::kUndo, at, end, tool});
    if (std::holds_alternative<Redo>(*command)) steps_.push_back({WatchedStep::Kind::kRedo, at, end, tool});
  }
}

WatchedRun::~WatchedRun() {
  {
    const std::lock_guard lock(mutex_);
    orders_.is_over = true;
    ++orders_.number;
  }
  ordered_.notify_one();
  if (thread_.joinable()) thread_.join();
  for (const Shown& object : shown_) object.mesher->stop();
}

PieceLabels WatchedRun::labels() const {
  if (manifest().pieces.empty()) return readPieceLabels(folder_);  // it stayed in one piece
  PieceLabels out;
  for (const RunManifest::Piece& piece : manifest().pieces) out[piece.id] = {piece.name, piece.colour};
  return out;
}

// ---- Requests

void WatchedRun::play() {
  const std::lock_guard lock(mutex_);
  orders_.is_playing = true;
  ++orders_.number;
  ordered_.notify_one();
}

void WatchedRun::pause() {
  const std::lock_guard lock(mutex_);
  orders_.is_playing = false;
  ++orders_.number;
  ordered_.notify_one();
}

void WatchedRun::setSpeed(double speed) {
  const std::lock_guard lock(mutex_);
  orders_.speed = speed == kFastest ? kFastest : std::clamp(speed, kLeastSpeed, kMostSpeed);
  ++orders_.number;
  ordered_.notify_one();
}

void WatchedRun::jumpTo(std::size_t sample) {
  const std::lock_guard lock(mutex_);
  orders_.jump = std::min(sample, samples());
  ++orders_.number;
  ordered_.notify_one();
}

// ---- Display

bool WatchedRun::update() {
  const std::lock_guard lock(mutex_);
  if (!std::exchange(is_fresh_, false)) return false;
  moment_ = newest_;
  return true;
}

bool WatchedRun::isSettled() const {
  {
    const std::lock_guard lock(mutex_);
    if (is_fresh_ || orders_done_ != orders_.number || !came_off_.empty()) return false;
  }
  const HapticCounts& counts = moment_.report.counts;
  return !moment_.is_jumping && counts.edits_waiting == 0 && editsDone() >= counts.edits_pushed;
}

std::vector<ObjectChunks> WatchedRun::takeChunks() {
  std::vector<CameOff> fresh;
  {
    const std::lock_guard lock(mutex_);
    fresh.swap(came_off_);
  }
  for (CameOff& object : fresh) {
    MesherThreadOptions options = options_.mesher;
    if (!looks_.empty()) options.remesher.finish = looks_[object.loaded];
    auto mesher = object.origin ? std::make_shared<MesherThread>(object.origin, object.feed, options)
                                : std::make_shared<MesherThread>(recording_.objects[object.loaded]->phi0(),
                                                                 *object.feed, options);
    shown_.push_back({object.id, std::move(object.feed), object.loaded, std::move(mesher)});
  }

  std::vector<ObjectChunks> out;
  for (const Shown& object : shown_) {
    std::vector<MeshChunkPtr> chunks = object.mesher->take();
    if (!chunks.empty()) out.push_back({object.id, std::move(chunks)});
  }
  return out;
}

std::optional<SceneView> WatchedRun::viewScene() const {
  const HapticReport& report = moment_.report;
  if (report.object_count == 0) return {};
  const PieceLabels known = labels();
  SceneView out;
  for (std::size_t n = 0; n < report.object_count; ++n) {
    const ObjectReport& object = report.objects[n];
    const auto shown = std::find_if(shown_.begin(), shown_.end(), [&](const Shown& s) { return s.id == object.id; });
    if (shown == shown_.end()) return {};  // pieces appear some ms before their meshers
    const auto name = known.find(object.id);
    out.objects.push_back({object.id,
                           object.loaded,
                           name == known.end() ? fmt::format("piece {}", n + 1) : name->second.name,
                           object.T_world_object,
                           shown->mesher,
                           {}});
  }
  return out;
}

std::uint64_t WatchedRun::editsDone() const noexcept {
  std::uint64_t out = 0;
  for (const Shown& object : shown_) out += object.mesher->editsDone();
  return out;
}

// ---- The thread

void WatchedRun::run() {
  Orders done;
  if (const auto begun = player_->handleEvents(); !begun) stopWith(begun.error());
  for (;;) {
    const Orders orders = takeOrders();
    if (orders.is_over) return;
    if (orders.number != done.number) follow(orders);
    done = orders;
    if (now_.is_playing) playOn();
    sendBricks();
    publish();

    std::unique_lock lock(mutex_);
    if (orders_.number == done.number) orders_done_ = done.number;
    const bool is_busy = now_.is_playing && now_.speed == kFastest;
    const bool is_waiting = now_.report.counts.edits_waiting > 0;
    const auto pause = is_busy ? milliseconds(0) : now_.is_playing || is_waiting ? milliseconds(2) : milliseconds(50);
    ordered_.wait_for(lock, pause, [&] { return orders_.number != done.number; });
  }
}

WatchedRun::Orders WatchedRun::takeOrders() {
  const std::lock_guard lock(mutex_);
  Orders out = orders_;
  orders_.jump.reset();
  return out;
}

bool WatchedRun::isOrdered() const {
  const std::lock_guard lock(mutex_);
  return orders_.is_over || orders_.jump.has_value();
}

void WatchedRun::follow(const Orders& orders) {
  now_.speed = orders.speed;
  now_.is_playing = orders.is_playing && !player_->isAtEnd();
  if (orders.jump) {
    jump(*orders.jump);
    now_.is_playing = orders.is_playing && !player_->isAtEnd() && !now_.verdict;
  }
  restartClock();
}

void WatchedRun::restartClock() {
  clock_from_ = Clock::now();
  sample_from_ = player_->nextSample();
}

// Plays as far as the clock requires, for some ms at most.
void WatchedRun::playOn() {
  const auto begin = Clock::now();
  std::size_t target = samples();
  if (now_.speed != kFastest) {
    const double seconds = std::chrono::duration<double>(begin - clock_from_).count() * now_.speed;
    target = std::min(target, sample_from_ + static_cast<std::size_t>(seconds / kTick));
  }
  while (player_->nextSample() < target && Clock::now() - begin < kBatch)
    if (!tick()) return;

  if (player_->isAtEnd()) return arrive();
  const double late = kTick * static_cast<double>(target - std::min(target, player_->nextSample()));
  if (late > std::chrono::duration<double>(kMostLate).count() * std::max(now_.speed, 1.0)) restartClock();
}

// Ticks one sample, and keeps the state before it when due. False: playback cannot continue from here.
bool WatchedRun::tick() {
  auto done = player_->handleEvents();
  if (done) {
    keepState();
    const std::size_t sample = player_->nextSample();
    done = player_->tick(output_);
    if (done && heat_) {
      const Session& session = player_->session();
      heat_->tick(session.state().tool, recording_.log.samples[sample].sample, output_, session.state().objects);
    }
  }
  if (done) return true;
  if (!began_with_) {
    stopWith(done.error());
    return false;
  }

  // An undo reaches back before the kept state: start again from an earlier one.
  const std::size_t here = player_->nextSample();
  startFrom(lastKept(*began_with_));
  while (player_->nextSample() < here) {
    if (player_->nextSample() % kJumpBatch == 0 && isOrdered()) return false;
    if (!tick()) return false;
  }
  return tick();
}

// The last state kept before a sample; null: the beginning.
const WatchedRun::Kept* WatchedRun::lastKept(std::size_t before) const {
  const auto at = std::partition_point(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.sample < before; });
  return at == kept_.begin() ? nullptr : &*(at - 1);
}

void WatchedRun::startFrom(const Kept* kept) {
  internal::LogPlayer::Start start;
  if (kept) {
    auto state = unpackState(kept->state, recording_.objects, log_name_);
    if (state)
      start = {kept->event, kept->sample, std::move(*state)};
    else
      kept = nullptr;
  }
  player_.emplace(recording_.log, log_name_, recording_.model, place_, recording_.objects, std::move(start));
  began_with_.reset();
  Session& session = player_->session();
  if (kept) {
    began_with_ = kept->sample;
    for (std::size_t n = 0; n < session.state().objects.size(); ++n)
      if (const auto before = kept->removed_before.find(session.object(n).id); before != kept->removed_before.end())
        session.object(n).removed_before_mm3 = before->second;
  }
  output_ = {};
  output_.T_world_tool = session.state().body.pose;
  now_.verdict.reset();
  if (heat_) heat_->restore(kept ? kept->heat : cold_);
  ++jumps_;

  // Meshers know a later or an earlier moment: sends all bricks again that may differ.
  for (const CutObject& object : session.state().objects)
    if (const auto told = told_.find(object.id); told != told_.end())
      for (int s = 0; s < object.slotCount(); ++s)
        if (object.slot(s).own) told->second.bricks.emplace(coordKey(object.slot(s).brick), object.slot(s).brick);
  for (auto& [id, told] : told_) {
    told.again.clear();
    for (const auto& [key, brick] : told.bricks) told.again.push_back(brick);
  }
}

// Keeps states at the beginning of a stroke, where a session closes the last undo step in any case.
void WatchedRun::keepState() {
  const std::size_t n = player_->nextSample();
  const auto presses = [&](std::size_t sample) {
    const DeviceSample& s = recording_.log.samples[sample].sample;
    return s.isUsable() && s.pedal != 0;
  };
  const auto every = static_cast<std::size_t>(options_.keep_every_s / kTick);
  const Kept* const last = lastKept(n + 1);
  if (n == 0 || n < (last ? last->sample : 0) + every || !presses(n) || presses(n - 1)) return;
  const auto& objects = player_->session().state().objects;
  if (std::any_of(objects.begin(), objects.end(), [](const CutObject& o) { return o.isFrozen(); })) return;

  Kept kept{.sample = n,
            .event = player_->nextEvent(),
            .state = player_->session().snapshot(),
            .removed_before = {},
            .heat = heat_ ? heat_->memory() : cold_};
  for (const CutObject& object : objects) kept.removed_before[object.id] = object.removed_before_mm3;
  const auto after = std::partition_point(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.sample < n; });
  kept_.insert(after, std::move(kept));

  std::size_t bytes = 0;
  for (const Kept& k : kept_) bytes += k.state.size();
  if (bytes <= options_.kept_bytes) return;
  std::size_t number = 0;
  std::erase_if(kept_, [&](const Kept&) { return number++ % 2 == 0; });
}

// Jumps to a sample without pictures, until another request arrives.
void WatchedRun::jump(std::size_t target) {
  const Kept* const kept = lastKept(target + 1);
  const bool is_back = target < player_->nextSample();
  if (is_back || (kept && kept->sample > player_->nextSample())) startFrom(kept);
  const std::size_t from = player_->nextSample();
  now_.is_jumping = true;
  now_.verdict.reset();

  auto next_news = Clock::now() + milliseconds(30);
  bool is_stopped = false;
  for (std::size_t n = 1; player_->nextSample() < target && !is_stopped; ++n) {
    is_stopped = !tick() || (n % kJumpBatch == 0 && isOrdered());
    if (Clock::now() < next_news) continue;
    next_news = Clock::now() + milliseconds(30);
    const std::size_t here = std::max(player_->nextSample(), from);
    now_.jump_share = static_cast<double>(here - from) / static_cast<double>(target - from);
    publish();
  }

  now_.is_jumping = false;
  if (is_stopped) return;
  if (player_->isAtEnd()) return arrive();
  // Events before the first sample set up the session's pieces.
  if (player_->nextSample() > 0) return;
  if (const auto begun = player_->handleEvents(); !begun) stopWith(begun.error());
}

// Compares the state at the end with the session's.
void WatchedRun::arrive() {
  stopPlaying();
  if (now_.verdict) return;
  if (const auto rest = player_->handleEvents(); !rest) return stopWith(rest.error());

  const Replay found = player_->found();
  const bool is_end_same = found.state_hash == manifest().state_hash;
  const bool is_log_whole = recording_.log.is_closed && !recording_.log.damage;
  WatchVerdict verdict;
  verdict.is_same = is_end_same && found.is_same;
  verdict.is_whole = is_log_whole || is_end_same;
  if (verdict.is_same)
    verdict.text = fmt::format("the same: {} checks, and the state at the end, {}", found.checks, found.state_hash);
  else if (!found.is_same)
    verdict.text = fmt::format("it differs from {:.3f} s onwards", kTick * static_cast<double>(found.differs_at));
  else
    verdict.text = fmt::format("the state at the end is {}; the run names {}", found.state_hash, manifest().state_hash);
  if (!verdict.is_whole)
    verdict.text = fmt::format("the log holds {:.3f} of {:.3f} s: {}", seconds(), manifest().duration_s, verdict.text);
  if (!found.note.empty()) verdict.text += "; " + found.note;
  now_.verdict = std::move(verdict);
}

// Stops: a later jump does not play on without a new request.
void WatchedRun::stopPlaying() {
  now_.is_playing = false;
  const std::lock_guard lock(mutex_);
  if (!orders_.jump) orders_.is_playing = false;
}

void WatchedRun::stopWith(const Error& error) {
  stopPlaying();
  now_.verdict = WatchVerdict{false, true, error.message()};
}

// ---- Messages to the meshers and the viewer

WatchedRun::Told& WatchedRun::toldOf(CutObject& object) {
  const auto [at, is_new] = told_.try_emplace(object.id);
  Told& told = at->second;
  if (!is_new) return told;

  told.feed = std::make_shared<BrickFeed>();
  CameOff fresh;
  fresh.loaded = loadedIndex(recording_.objects, &object.baked());
  fresh.id = object.id;
  fresh.feed = told.feed;
  if (object.bricks().isPiece()) {
    auto origin = std::make_shared<PieceOrigin>(originOf(object));
    for (const BrickEdit& edit : origin->cut) told.bricks.emplace(coordKey(edit.brick), edit.brick);
    fresh.origin = std::move(origin);
  }
  const std::lock_guard lock(mutex_);
  came_off_.push_back(std::move(fresh));
  return told;
}

// Sends as many bricks as the feeds take; the rest waits for the next call.
void WatchedRun::sendBricks() {
  Session& session = player_->session();
  HapticCounts& counts = now_.report.counts;
  counts.edits_waiting = 0;
  for (std::size_t n = 0; n < session.state().objects.size(); ++n) {
    CutObject& object = session.object(n);
    Told& told = toldOf(object);
    while (!told.again.empty() && told.feed->tryPush(told.again.back(), valuesOf(object, told.again.back()))) {
      told.again.pop_back();
      ++counts.edits_pushed;
    }

    const auto changes = object.changes(BrickSubscriber::kMesher);
    changes.take([&](const CutObject::Slot& slot) {
      BrickValues values;
      std::copy_n(slot.phi, kBrickNodes, values.begin());
      if (!told.feed->tryPush(slot.brick, values)) return false;
      told.bricks.emplace(coordKey(slot.brick), slot.brick);
      ++counts.edits_pushed;
      return true;
    });
    counts.edits_waiting += told.again.size() + changes.count();
  }
}

void WatchedRun::publish() {
  const Session& session = player_->session();
  const std::size_t sample = player_->nextSample();
  now_.report.output = output_;
  describeScene(session, now_.report);
  if (heat_) now_.report.heat = heat_->report();
  now_.report.counts.ticks = sample;
  now_.report.counts.pauses = jumps_;
  now_.sample = sample;
  now_.tool = session.state().tool;
  now_.is_at_end = player_->isAtEnd();
  now_.steps = 0;
  for (const WatchedStep& step : steps_) {
    if (step.end > sample) continue;
    ++now_.steps;
    now_.report.counts.pauses += step.kind == WatchedStep::Kind::kUndo || step.kind == WatchedStep::Kind::kRedo;
  }

  const std::lock_guard lock(mutex_);
  newest_ = now_;
  is_fresh_ = true;
}

}  // namespace kerf
