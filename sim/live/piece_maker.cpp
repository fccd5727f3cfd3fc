#include "sim/live/piece_maker.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <new>

#include "sim/live/realtime.h"
#include "sim/pieces/plane_parts.h"

namespace kerf {
namespace {

using namespace std::chrono_literals;

// 2 KiB copied for each: at least as many as a bur changes in a tick.
constexpr int kPieceEditsATick = 128;
constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kLeastPause = 2 * kMs;    // between two searches
constexpr std::int64_t kCrumbPause = 500 * kMs;  // between two removals of crumbs
constexpr std::int64_t kPoolPause = 500 * kMs;   // after a lack of memory
constexpr std::size_t kSpare = 2;                // most objects fall in two

std::unique_ptr<PieceFinder> finderOf(const PieceOrigin& piece, const PieceOptions& options) {
  std::vector<Vec3i> bricks = piece.bricks;
  bricks.insert(bricks.end(), piece.interior.begin(), piece.interior.end());
  auto out = std::make_unique<PieceFinder>(piece.baked->phi0(), bricks, options);
  out->apply(piece.cut);
  out->apply(piece.near_others);
  return out;
}

double msBetween(std::int64_t begin_ns, std::int64_t end_ns) { return 1e-6 * static_cast<double>(end_ns - begin_ns); }

}  // namespace

// The maker's data of one object, in the scene or restorable by undo.
struct PieceMaker::Subscriber {
  std::uint32_t id = 0;
  std::shared_ptr<const BakedObject> baked;
  std::shared_ptr<const PieceOrigin> origin;  // for a piece, until it changes
  std::unique_ptr<PieceFinder> finder;
  BrickFeed feed{256};
  std::vector<BrickEdit> edits;
  std::shared_ptr<BrickFeed> for_others;  // for a piece: feed for on_piece()
  bool is_changed = false;                // since its last search
  bool wants_pool = false;                // for its pieces: changed since the last pool
  std::int64_t whole_at = 0;
  std::int64_t not_before = 0;  // ns: after a failed try
};

PieceMaker::PieceMaker(Session& session, const PieceMakerOptions& options) : options_(options) {
  fresh_.reserve(kMostObjects);
  for (std::size_t n = 0; n < session.state().objects.size(); ++n) {
    CutObject& object = session.object(n);
    if (!object.bricks().isPiece()) {
      Subscriber& s = subscribe(object.id, object, {});
      s.finder = std::make_unique<PieceFinder>(s.baked->phi0(), options_.pieces);
      continue;
    }
    const auto origin = std::make_shared<const PieceOrigin>(originOf(object));
    Subscriber& s = subscribe(object.id, object, origin);
    if (!options_.on_piece) continue;
    s.for_others = std::make_shared<BrickFeed>();
    object.changes(BrickSubscriber::kMesher).setFeed(s.for_others.get());
    fresh_.push_back(origin);
  }
}

PieceMaker::~PieceMaker() {
  stop();
  dropForgotten();
}

void PieceMaker::start() {
  thread_ = std::thread([this] { run(); });
}

void PieceMaker::stop() {
  is_stopping_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

// ---- The maker's thread

void PieceMaker::run() {
  while (!is_stopping_.load(std::memory_order_acquire)) {
    bool is_waiting = true;  // for the haptic thread's next tick
    switch (stage_.load(std::memory_order_acquire)) {
      case Stage::kWatching:
        is_waiting = watch();
        break;
      case Stage::kWantsFreeze:
        drainRequested();
        break;
      case Stage::kFrozen:
        makeRequested();
        break;
      case Stage::kReady:
        break;
      case Stage::kNotNow:
      case Stage::kDone:
        settle();
        break;
    }
    const auto pause = is_resting_.load(std::memory_order_relaxed) ? 10'000us : 1000us;
    std::this_thread::sleep_for(is_waiting ? 200us : pause);
  }

  // The haptic thread has ended. Announces its last pieces, too.
  const Stage last = stage_.load(std::memory_order_acquire);
  if (last == Stage::kDone || last == Stage::kNotNow) settle();
  announcePieces();
}

bool PieceMaker::watch() {
  dropForgotten();
  announcePieces();
  try {
    const std::uint64_t cuts = cuts_.load(std::memory_order_acquire);  // before their bricks are taken
    const std::int64_t taken_at = monotonicNow();
    collectBricks();
    if (is_ordered_.load(std::memory_order_acquire)) {
      requestOrdered();
      moveOn(Stage::kWantsFreeze);
      return true;
    }
    if (!isSearchDue(cuts)) return false;

    seen_cuts_ = cuts;
    const std::int64_t begin = monotonicNow();
    const bool is_apart = search(taken_at);
    const std::int64_t end = monotonicNow();
    next_search_ = end + std::max(kLeastPause, 3 * (end - begin));

    if (is_apart)
      moveOn(Stage::kWantsFreeze);
    else
      reservePools();
    return is_apart;
  } catch (const std::bad_alloc&) {  // no splits until there is memory again
    return false;
  }
}

void PieceMaker::collectBricks() {
  for (auto& s : subscribers_) {
    s->feed.drain(s->edits);
    if (s->edits.empty()) continue;
    if (!s->finder) {
      // At its first cut. Not on all cores: nothing waits for this.
      tbb::task_arena(1).execute([&] { s->finder = finderOf(*s->origin, options_.pieces); });
      s->origin.reset();
    }
    s->finder->apply(s->edits);
    s->edits.clear();
    s->is_changed = true;
    s->wants_pool = true;
  }
}

bool PieceMaker::isSearchDue(std::uint64_t cuts) const {
  const std::int64_t now = monotonicNow();
  const bool is_wanted = cuts != seen_cuts_ || must_scan_again_ || (has_crumbs_ && now >= crumbs_from_);
  return is_wanted && now >= next_search_;
}

// True: an object is in pieces, or has due crumbs, and the request is for it.
bool PieceMaker::search(std::int64_t taken_at) {
  const std::int64_t now = monotonicNow();
  has_crumbs_ = false;
  must_scan_again_ = false;
  bool is_apart = false;
  for (auto& s : subscribers_) {
    if (!s->is_changed) continue;
    const PieceList& list = s->finder->find();
    const bool has_crumbs = !list.crumbs.empty() && list.pieces.size() == 1;

    if (list.pieces.size() < 2 && !(has_crumbs && now >= crumbs_from_)) {
      s->is_changed = has_crumbs;  // postponed, not forgotten
      has_crumbs_ |= has_crumbs;
      s->whole_at = taken_at;
      continue;
    }

    if (is_apart || now < s->not_before) {  // after the other one, or after a while
      must_scan_again_ = true;
      continue;
    }

    s->is_changed = false;
    is_apart = true;
    requestSplit(*s);
  }
  return is_apart;
}

void PieceMaker::requestSplit(const Subscriber& subscriber) {
  request_ = {};
  request_.id = subscriber.id;
  request_.crumb_mm3 = options_.pieces.crumb_mm3;
  request_.whole_at_ns = subscriber.whole_at;
}

void PieceMaker::requestOrdered() {
  request_ = {};
  request_.id = ordered_id_;
  request_.is_order = true;
  request_.whole_at_ns = monotonicNow();
}

// Its last bricks may exceed the feed's size.
void PieceMaker::drainRequested() {
  try {
    if (Subscriber* const s = find(request_.id)) s->feed.drain(s->edits);
  } catch (const std::bad_alloc&) {  // the rest stays in the feed
  }
}

void PieceMaker::makeRequested() {
  Subscriber& whole = *find(request_.id);
  try {
    if (options_.on_apart && !request_.is_order) options_.on_apart(whole.id);
  } catch (...) {
  }

  // Without memory the object stays unchanged, and is tried again.
  try {
    whole.feed.drain(whole.edits);  // some may have been taken before
    if (!whole.finder) whole.finder = finderOf(*whole.origin, options_.pieces);
    whole.origin.reset();
    whole.finder->apply(whole.edits);
    whole.edits.clear();
    preparePieces(whole);
  } catch (const std::bad_alloc&) {
    const std::uint32_t first = request_.first_id;
    std::erase_if(subscribers_, [&](const auto& made) { return made->id >= first; });
    request_.made.reset();
    request_.is_apart = true;
  }
  moveOn(Stage::kReady);
}

void PieceMaker::preparePieces(Subscriber& whole) {
  if (request_.is_order) {
    request_.made = makePlaneParts(*request_.whole, order_.planes, static_cast<PlaneKeep>(order_.keep),
                                   request_.first_id, request_.first_id, options_.is_parallel);
  } else {
    request_.made = makePieces(*request_.whole, *whole.finder, request_.first_id, request_.most,
                               &pools_[whole.baked.get()], options_.is_parallel);
  }
  crumbs_from_ = monotonicNow() + kCrumbPause;
  request_.is_apart = !request_.made && !request_.is_order && whole.finder->find().pieces.size() > request_.most;
  if (!request_.made || !request_.made->parts) return;

  for (std::size_t n = 0; n < request_.made->origins.size(); ++n) {
    CutObject& part = request_.made->parts->out_of_scene[n].object;
    const std::size_t wanted = Session::reserveFor(part);  // a tick wants half of it
    if (part.freeBricks() < wanted / 2) part.reserve(wanted);

    Subscriber& made = subscribe(part.id, part, request_.made->origins[n]);
    if (!options_.on_piece) continue;
    if (spare_feeds_.empty()) spare_feeds_.push_back(std::make_shared<BrickFeed>());
    made.for_others = std::move(spare_feeds_.back());
    spare_feeds_.pop_back();
    part.changes(BrickSubscriber::kMesher).setFeed(made.for_others.get());
  }
}

void PieceMaker::settle() {
  const Answer answer = request_.answer;
  if (request_.made) settlePieces(answer == Answer::kDone);

  // A failed request returns with the next cut or by itself; a failed order does not.
  if (request_.is_order) {
    if (answer == Answer::kDone) searchOrdered();
    is_ordered_.store(false, std::memory_order_release);
  } else if (Subscriber* const s = find(request_.id); s && answer != Answer::kGone) {
    s->is_changed |= answer != Answer::kDone;
    must_scan_again_ |= answer == Answer::kInAMoment;
    if (answer == Answer::kInAMoment) s->not_before = monotonicNow() + kCrumbPause;
  }

  request_ = {};
  moveOn(Stage::kWatching);
}

// A part above a plane may hang together in several places.
void PieceMaker::searchOrdered() {
  for (auto& s : subscribers_) {
    if (s->id < request_.first_id || !s->origin) continue;
    s->finder = finderOf(*s->origin, options_.pieces);
    s->is_changed = true;
    must_scan_again_ = true;
  }
}

void PieceMaker::settlePieces(bool is_done) {
  for (const auto& origin : request_.made->origins) {
    Subscriber* const s = find(origin->id);
    if (!s) continue;
    if (!is_done && s->for_others && spare_feeds_.size() < kSpare)
      spare_feeds_.push_back(std::move(s->for_others));  // nothing was sent

    // No hurry now: shrinks them to the needed size.
    try {
      s->origin = pools_[origin->baked.get()].takeBack(*origin);
    } catch (const std::bad_alloc&) {  // unchanged
    }
    if (is_done && options_.on_piece) fresh_.push_back(s->origin);
  }

  if (!is_done)
    for (const auto& origin : request_.made->origins)
      std::erase_if(subscribers_, [&](const auto& s) { return s->id == origin->id; });
  std::reverse(fresh_.begin(), fresh_.end());
}

// Memory for the pieces of objects being cut. Without it pieces come later.
void PieceMaker::reservePools() noexcept {
  if (monotonicNow() < next_pools_) return;
  try {
    for (auto& s : subscribers_) {
      if (!s->wants_pool) continue;
      const std::size_t a_tick_wants = std::min(Session::kReserve, s->baked->slots().size() + 1024) / 2;
      pools_[s->baked.get()].reserve(s->baked, *s->finder, a_tick_wants);
      while (spare_subscribers_.size() < kSpare) spare_subscribers_.push_back(std::make_unique<Subscriber>());
      while (options_.on_piece && spare_feeds_.size() < kSpare) spare_feeds_.push_back(std::make_shared<BrickFeed>());
      s->wants_pool = false;
    }
  } catch (const std::bad_alloc&) {
    next_pools_ = monotonicNow() + kPoolPause;
  }
}

// Drops objects that no undo can restore, and their subscribers.
void PieceMaker::dropForgotten() {
  const std::unique_ptr<Split> splits(forgotten_.exchange(nullptr, std::memory_order_acq_rel));
  for (const Split* split = splits.get(); split; split = split->next.get())
    for (const auto& held : split->out_of_scene)
      std::erase_if(subscribers_, [&](const auto& s) { return s->id == held.object.id; });
}

// Announces pieces that are in the scene now.
void PieceMaker::announcePieces() {
  while (!fresh_.empty()) {
    const std::shared_ptr<const PieceOrigin> origin = std::move(fresh_.back());
    fresh_.pop_back();
    const Subscriber* const s = find(origin->id);
    if (!s) continue;
    try {
      options_.on_piece(origin, s->for_others);
    } catch (...) {  // then that piece is not drawn
    }
  }
}

PieceMaker::Subscriber& PieceMaker::subscribe(std::uint32_t id, CutObject& object,
                                              std::shared_ptr<const PieceOrigin> origin) {
  auto made = spare_subscribers_.empty() ? std::make_unique<Subscriber>() : std::move(spare_subscribers_.back());
  if (!spare_subscribers_.empty()) spare_subscribers_.pop_back();
  Subscriber& s = *subscribers_.emplace_back(std::move(made));
  s.id = id;
  s.baked = object.bricks().sharedBaked();
  s.origin = std::move(origin);
  s.whole_at = monotonicNow();
  object.changes(BrickSubscriber::kPieces).setFeed(&s.feed);
  return s;
}

PieceMaker::Subscriber* PieceMaker::find(std::uint32_t id) {
  const auto at = std::find_if(subscribers_.begin(), subscribers_.end(), [&](const auto& s) { return s->id == id; });
  return at == subscribers_.end() ? nullptr : at->get();
}

// ---- The haptic thread

bool PieceMaker::beforeTick(Session& session) noexcept {
  if (!forgotten_.load(std::memory_order_acquire))
    forgotten_.store(session.takeForgotten().release(), std::memory_order_release);

  const Stage stage = stage_.load(std::memory_order_acquire);
  if (stage == Stage::kWantsFreeze && !is_freezing_) freezeRequested(session);
  return stage == Stage::kReady && putInPlace(session);
}

void PieceMaker::freezeRequested(Session& session) noexcept {
  const auto& objects = session.state().objects;
  frozen_ = 0;
  while (frozen_ < objects.size() && objects[frozen_].id != request_.id) ++frozen_;

  if (frozen_ == objects.size()) return refuse(Answer::kGone);
  // Added material may not hang together yet; steps to redo would be lost, but a user may lose them by a cut.
  if (!request_.is_order && (session.state().adds != Material::kNone || session.wouldLoseRedo()))
    return refuse(Answer::kAfterACut);
  if (request_.is_order && objects.size() == kMostObjects) return refuse(Answer::kInAMoment);
  if (!session.applyWithin(FreezeObject{frozen_})) return refuse(Answer::kInAMoment);

  is_freezing_ = true;
  frozen_at_ns_ = monotonicNow();
  request_.whole = &objects[frozen_];
  request_.first_id = session.state().next_id;
  request_.most = kMostObjects + 1 - objects.size();
}

void PieceMaker::refuse(Answer answer) noexcept {
  request_.answer = answer;
  if (request_.is_order) answer_ = false;
  moveOn(Stage::kNotNow);
}

bool PieceMaker::putInPlace(Session& session) noexcept {
  const std::size_t before = session.state().objects.size();

  // Replaces it by the pieces, if any.
  if (request_.made) {
    const std::size_t crumbs = request_.made->crumbs;
    session.offer(frozen_, std::move(request_.made));
    order_.object = frozen_;
    const bool is_done =
        request_.is_order ? session.applyWithin(order_) : session.applyWithin(SplitObject{frozen_, request_.crumb_mm3});
    if (!is_done) request_.answer = Answer::kInAMoment;
    session.repair();  // at the crumbs: a few bricks, for which a tick has enough free ones
    if (request_.answer == Answer::kDone) counts_.crumbs += crumbs;
    request_.made = session.takeOffer();  // the maker destroys it
  } else if (request_.is_apart || request_.is_order) {
    request_.answer = Answer::kInAMoment;
  }
  if (request_.is_order) answer_ = request_.answer == Answer::kDone;
  if (frozen_ < before && session.state().objects[frozen_].isFrozen()) session.applyWithin(UnfreezeObject{frozen_});
  is_freezing_ = false;

  const std::size_t after = session.state().objects.size();
  const std::int64_t now = monotonicNow();
  counts_.longest_freeze_ms = std::max(counts_.longest_freeze_ms, msBetween(frozen_at_ns_, now));
  if (after > before) {
    ++counts_.splits;
    counts_.pieces += after - before + 1;
    counts_.longest_split_ms = std::max(counts_.longest_split_ms, msBetween(request_.whole_at_ns, now));
  }

  const bool is_changed = after != before || (request_.is_order && request_.answer == Answer::kDone);
  moveOn(Stage::kDone);
  return is_changed;
}

bool PieceMaker::order(const Session& session, const CutByPlanes& command) noexcept {
  if (is_ordered_.load(std::memory_order_acquire) || command.object >= session.state().objects.size()) return false;
  order_ = command;
  ordered_id_ = session.state().objects[command.object].id;
  is_ordered_.store(true, std::memory_order_release);
  return true;
}

void PieceMaker::abandon(Session& session) noexcept {
  if (!is_freezing_) return;
  session.applyWithin(UnfreezeObject{frozen_});
  is_freezing_ = false;
}

void PieceMaker::afterTick(Session& session, const StepOutput& output) noexcept {
  bool is_sent = true;
  for (std::size_t n = 0; n < session.state().objects.size(); ++n) {
    CutObject& object = session.object(n);
    const auto changes = object.changes(BrickSubscriber::kPieces);
    if (!changes.feed() || changes.isEmpty()) continue;
    int left_this_tick = kPieceEditsATick;
    changes.take([&](const CutObject::Slot& slot) {
      BrickValues values;
      std::copy_n(slot.phi, kBrickNodes, values.begin());
      return left_this_tick-- > 0 && changes.feed()->tryPush(slot.brick, values);
    });
    is_sent &= changes.isEmpty();
  }

  // A cut counts when all its bricks are sent: the maker reads the count first, then the bricks.
  has_cut_ |= output.bricks_cut > 0 && session.state().adds == Material::kNone;
  if (has_cut_ && is_sent) {
    has_cut_ = false;
    cuts_.fetch_add(1, std::memory_order_release);
  }

  if (is_freezing_ && stage_.load(std::memory_order_relaxed) == Stage::kWantsFreeze &&
      session.object(frozen_).changes(BrickSubscriber::kPieces).isEmpty())
    moveOn(Stage::kFrozen);
}

}  // namespace kerf
