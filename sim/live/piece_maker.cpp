#include "sim/live/piece_maker.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <new>

#include "sim/live/realtime.h"

namespace kerf {
namespace {

using namespace std::chrono_literals;

// 2 KiB are copied for each: as many as a bur changes in a tick, and more.
constexpr int kEditsATick = 128;
constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kLeastPause = 2 * kMs;    // between two looks
constexpr std::int64_t kCrumbPause = 500 * kMs;  // between two times crumbs are taken away
constexpr std::int64_t kStockPause = 500 * kMs;  // after there was no memory
constexpr std::size_t kSpare = 2;                // most objects fall in two

std::unique_ptr<PieceFinder> finderOf(const PieceOrigin& piece, const PieceOptions& options) {
  std::vector<Vec3i> bricks = piece.bricks;
  bricks.insert(bricks.end(), piece.interior.begin(), piece.interior.end());
  auto out = std::make_unique<PieceFinder>(piece.baked->phi0(), bricks, options);
  out->apply(piece.cut);
  out->apply(piece.near_others);
  return out;
}

}  // namespace

// One object, whether it is in the scene or what undo may bring back.
struct PieceMaker::Subscriber {
  std::uint32_t id = 0;
  std::shared_ptr<const BakedObject> baked;
  std::shared_ptr<const PieceOrigin> origin;  // of a piece, until something of it changes
  std::unique_ptr<PieceFinder> finder;
  BrickFeed feed{256};
  std::vector<BrickEdit> edits;
  std::shared_ptr<BrickFeed> for_others;  // of a piece: what follow() hands out
  bool is_changed = false;                // since it was looked at
  bool wants_pool = false;                // for its pieces: changed since that was made
  std::int64_t whole_at = 0;
  std::int64_t not_before = 0;  // ns: it was tried in vain
};

PieceMaker::PieceMaker(Session& session, const PieceMakerOptions& options) : options_(options) {
  fresh_.reserve(kMostObjects);
  for (std::size_t n = 0; n < session.state().objects.size(); ++n) follow(session.object(n).id, session.object(n), {});
  for (auto& f : subscribers_) f->finder = std::make_unique<PieceFinder>(f->baked->phi0(), options_.pieces);
}

PieceMaker::~PieceMaker() {
  stop();
  dropTrash();
}

void PieceMaker::start() {
  thread_ = std::thread([this] { run(); });
}

void PieceMaker::stop() {
  is_stopping_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

PieceMaker::Subscriber& PieceMaker::follow(std::uint32_t id, CutObject& object,
                                           std::shared_ptr<const PieceOrigin> origin) {
  auto made = spare_subscribers_.empty() ? std::make_unique<Subscriber>() : std::move(spare_subscribers_.back());
  if (!spare_subscribers_.empty()) spare_subscribers_.pop_back();
  Subscriber& f = *subscribers_.emplace_back(std::move(made));
  f.id = id;
  f.baked = object.bricks().sharedBaked();
  f.origin = std::move(origin);
  f.whole_at = monotonicNow();
  object.changes(BrickSubscriber::kPieces).setFeed(&f.feed);
  return f;
}

PieceMaker::Subscriber* PieceMaker::find(std::uint32_t id) {
  const auto at = std::find_if(subscribers_.begin(), subscribers_.end(), [&](const auto& f) { return f->id == id; });
  return at == subscribers_.end() ? nullptr : at->get();
}

// Objects that no undo brings back, and who followed them.
void PieceMaker::dropTrash() {
  const std::unique_ptr<Split> splits(trash_.exchange(nullptr, std::memory_order_acq_rel));
  for (const Split* split = splits.get(); split; split = split->next.get())
    for (const auto& held : split->out_of_scene)
      std::erase_if(subscribers_, [&](const auto& f) { return f->id == held.object.id; });
}

// Memory for the pieces of what is being cut. Without it they come later, but they come.
void PieceMaker::stockUp() noexcept {
  if (monotonicNow() < next_stock_) return;
  try {
    for (auto& f : subscribers_) {
      if (!f->wants_pool) continue;
      const std::size_t a_tick_wants = std::min(Session::kReserve, f->baked->slots().size() + 1024) / 2;
      pools_[f->baked.get()].reserve(f->baked, *f->finder, a_tick_wants);
      while (spare_subscribers_.size() < kSpare) spare_subscribers_.push_back(std::make_unique<Subscriber>());
      while (options_.follow && spare_feeds_.size() < kSpare) spare_feeds_.push_back(std::make_shared<BrickFeed>());
      f->wants_pool = false;
    }
  } catch (const std::bad_alloc&) {
    next_stock_ = monotonicNow() + kStockPause;
  }
}

// Tells of the pieces that are in the scene now.
void PieceMaker::announce() {
  while (!fresh_.empty()) {
    const std::shared_ptr<const PieceOrigin> origin = std::move(fresh_.back());
    fresh_.pop_back();
    const Subscriber* const f = find(origin->id);
    if (!f) continue;
    try {
      options_.follow(origin, f->for_others);
    } catch (...) {  // whoever cannot follow does not
    }
  }
}

// Takes what has come; true: an object has come apart, and is asked for.
bool PieceMaker::look() {
  const std::uint64_t cuts = cuts_.load(std::memory_order_acquire);  // before their bricks are taken
  const std::int64_t taken_at = monotonicNow();
  for (auto& f : subscribers_) {
    f->feed.drain(f->edits);
    if (f->edits.empty()) continue;
    if (!f->finder) {
      // The first time it is cut. Not by all cores: nobody waits for this.
      tbb::task_arena(1).execute([&] { f->finder = finderOf(*f->origin, options_.pieces); });
      f->origin.reset();
    }
    f->finder->apply(f->edits);
    f->edits.clear();
    f->is_changed = f->wants_pool = true;
  }
  const std::int64_t begin = monotonicNow();
  const bool is_due = cuts != seen_cuts_ || must_scan_again_ || (has_crumbs_ && begin >= crumbs_from_);
  if (begin < next_search_ || !is_due) return false;
  seen_cuts_ = cuts;
  has_crumbs_ = must_scan_again_ = false;
  bool is_apart = false;
  for (auto& f : subscribers_) {
    if (!f->is_changed) continue;
    const PieceList& list = f->finder->find();
    const bool has_crumbs = !list.crumbs.empty() && list.pieces.size() == 1;
    if (list.pieces.size() < 2 && !(has_crumbs && begin >= crumbs_from_)) {
      f->is_changed = has_crumbs;  // they can wait, but are not forgotten
      has_crumbs_ |= has_crumbs;
      f->whole_at = taken_at;
      continue;
    }
    if (is_apart || begin < f->not_before) {  // after the other one, or after a while
      must_scan_again_ = true;
      continue;
    }
    f->is_changed = false;
    is_apart = true;
    request_ = {};
    request_.id = f->id;
    request_.crumb_mm3 = options_.pieces.crumb_mm3;
    request_.whole_at_ns = f->whole_at;
  }
  const std::int64_t end = monotonicNow();
  next_search_ = end + std::max(kLeastPause, 3 * (end - begin));
  if (is_apart)
    stage_.store(Stage::kWantsFreeze, std::memory_order_release);
  else
    stockUp();
  return is_apart;
}

void PieceMaker::make() {
  Subscriber& f = *find(request_.id);
  try {
    if (options_.severed) options_.severed(f.id);
  } catch (...) {
  }
  // Without memory it stays as it is, and is tried again.
  try {
    f.feed.drain(f.edits);  // some may have been taken before
    f.finder->apply(f.edits);
    f.edits.clear();
    prepare(f);
  } catch (const std::bad_alloc&) {
    const std::uint32_t first = request_.first_id;
    std::erase_if(subscribers_, [&](const auto& made) { return made->id >= first; });
    request_.made.reset();
    request_.is_apart = true;
  }
  stage_.store(Stage::kReady, std::memory_order_release);
}

void PieceMaker::prepare(Subscriber& f) {
  request_.made = makePieces(*request_.whole, *f.finder, request_.first_id, request_.most, &pools_[f.baked.get()],
                             options_.is_parallel);
  crumbs_from_ = monotonicNow() + kCrumbPause;
  request_.is_apart = !request_.made && f.finder->find().pieces.size() > request_.most;
  if (request_.made && request_.made->parts)
    for (std::size_t n = 0; n < request_.made->origins.size(); ++n) {
      CutObject& part = request_.made->parts->out_of_scene[n].object;
      const auto& origin = request_.made->origins[n];
      const std::size_t room = Session::reserveFor(part);  // a tick wants half of it
      if (part.freeBricks() < room / 2) part.reserve(room);
      Subscriber& made = follow(part.id, part, origin);
      if (!options_.follow) continue;  // nobody draws
      if (spare_feeds_.empty()) spare_feeds_.push_back(std::make_shared<BrickFeed>());
      made.for_others = std::move(spare_feeds_.back());
      spare_feeds_.pop_back();
      part.changes(BrickSubscriber::kMesher).setFeed(made.for_others.get());
    }
}

void PieceMaker::finish() {
  if (request_.made) {
    const bool is_done = request_.answer == Answer::kDone;
    for (const auto& origin : request_.made->origins) {
      Subscriber* const f = find(origin->id);
      if (!f) continue;
      if (!is_done && f->for_others && spare_feeds_.size() < kSpare)
        spare_feeds_.push_back(std::move(f->for_others));  // nothing was sent
      // Nobody waits now: only as large as they must be.
      try {
        f->origin = pools_[origin->baked.get()].takeBack(*origin);
      } catch (const std::bad_alloc&) {  // as it is
      }
      if (is_done && options_.follow) fresh_.push_back(f->origin);
    }
    if (!is_done)
      for (const auto& origin : request_.made->origins)
        std::erase_if(subscribers_, [&](const auto& f) { return f->id == origin->id; });
    std::reverse(fresh_.begin(), fresh_.end());
  }
  if (Subscriber* const f = find(request_.id); f && request_.answer != Answer::kGone) {
    // What could not be done comes up again, with the next cut or by itself.
    f->is_changed |= request_.answer != Answer::kDone;
    must_scan_again_ |= request_.answer == Answer::kInAMoment;
    if (request_.answer == Answer::kInAMoment) f->not_before = monotonicNow() + kCrumbPause;
  }
  request_ = {};
  stage_.store(Stage::kWatching, std::memory_order_release);
}

void PieceMaker::run() {
  while (!is_stopping_.load(std::memory_order_acquire)) {
    bool is_waiting = true;  // for the haptic thread's next tick
    switch (stage_.load(std::memory_order_acquire)) {
      case Stage::kWatching:
        dropTrash();
        announce();
        try {
          is_waiting = look();
        } catch (const std::bad_alloc&) {  // nothing is split until there is memory again
          is_waiting = false;
        }
        break;
      case Stage::kFrozen:
        make();
        break;
      case Stage::kNotNow:
      case Stage::kDone:
        finish();
        break;
      case Stage::kWantsFreeze:  // its last bricks may be more than fit at a time
        try {
          if (Subscriber* const f = find(request_.id)) f->feed.drain(f->edits);
        } catch (const std::bad_alloc&) {  // what was not taken is still there
        }
        break;
      case Stage::kReady:
        break;
    }
    std::this_thread::sleep_for(is_waiting ? 200us : 1000us);
  }
  // The haptic thread has ended. What it put into the scene last is told, too.
  const Stage last = stage_.load(std::memory_order_acquire);
  if (last == Stage::kDone || last == Stage::kNotNow) finish();
  announce();
}

bool PieceMaker::beforeTick(Session& session) noexcept {
  if (!trash_.load(std::memory_order_acquire))
    trash_.store(session.takeForgotten().release(), std::memory_order_release);
  const Stage stage = stage_.load(std::memory_order_acquire);
  char text[64];
  const auto command = [&](const char* verb, bool with_crumb) {
    const auto end = with_crumb ? fmt::format_to_n(text, sizeof text, "{} {} {}", verb, held_, request_.crumb_mm3)
                                : fmt::format_to_n(text, sizeof text, "{} {}", verb, held_);
    return session.applyWithin(std::string_view(text, std::min(end.size, sizeof text)));
  };
  if (stage == Stage::kWantsFreeze && !is_freezing_) {
    const auto& objects = session.state().objects;
    held_ = 0;
    while (held_ < objects.size() && objects[held_].id != request_.id) ++held_;
    const auto refuse = [&](Answer answer) {
      request_.answer = answer;
      stage_.store(Stage::kNotNow, std::memory_order_release);
      return false;
    };
    if (held_ == objects.size()) return refuse(Answer::kGone);
    // What is being added may not hang together yet; what could be redone would be lost.
    if (session.state().adds != Material::kNone || session.wouldLoseRedo()) return refuse(Answer::kAfterACut);
    if (!command("object.hold", false)) return refuse(Answer::kInAMoment);
    is_freezing_ = true;
    frozen_at_ns_ = monotonicNow();
    request_.whole = &objects[held_];
    request_.first_id = session.state().next_id;
    request_.most = kMostObjects + 1 - objects.size();
    return false;
  }
  if (stage != Stage::kReady) return false;
  const std::size_t before = session.state().objects.size();
  if (request_.made) {
    const std::size_t crumbs = request_.made->crumbs;
    session.offer(held_, std::move(request_.made));
    if (!command("pieces.split", true)) request_.answer = Answer::kInAMoment;
    session.repair();  // where crumbs were: a few bricks, for which a tick has room
    if (request_.answer == Answer::kDone) counts_.crumbs += crumbs;
    request_.made = session.takeOffer();  // to be destroyed over there
  } else if (request_.is_apart) {
    request_.answer = Answer::kInAMoment;
  }
  if (held_ < before && session.state().objects[held_].isFrozen()) command("object.release", false);
  is_freezing_ = false;
  const std::size_t after = session.state().objects.size();
  const std::int64_t now = monotonicNow();
  counts_.longest_freeze_ms = std::max(counts_.longest_freeze_ms, 1e-6 * static_cast<double>(now - frozen_at_ns_));
  if (after > before) {
    ++counts_.splits;
    counts_.pieces += after - before + 1;
    counts_.longest_split_ms =
        std::max(counts_.longest_split_ms, 1e-6 * static_cast<double>(now - request_.whole_at_ns));
  }
  stage_.store(Stage::kDone, std::memory_order_release);
  return after != before;
}

void PieceMaker::abandon(Session& session) noexcept {
  if (!is_freezing_) return;
  char text[32];
  const auto end = fmt::format_to_n(text, sizeof text, "object.release {}", held_);
  session.applyWithin(std::string_view(text, std::min(end.size, sizeof text)));
  is_freezing_ = false;
}

void PieceMaker::afterTick(Session& session, const StepOutput& output) noexcept {
  bool is_sent = true;
  for (std::size_t n = 0; n < session.state().objects.size(); ++n) {
    CutObject& object = session.object(n);
    const auto changes = object.changes(BrickSubscriber::kPieces);
    if (!changes.feed() || changes.isEmpty()) continue;
    int room = kEditsATick;
    changes.take([&](const CutObject::Slot& slot) {
      BrickValues values;
      std::copy_n(slot.phi, kBrickNodes, values.begin());
      return room-- > 0 && changes.feed()->tryPush(slot.brick, values);
    });
    is_sent &= changes.isEmpty();
  }
  has_cut_ |= output.bricks_cut > 0 && session.state().adds == Material::kNone;
  if (has_cut_ && is_sent) {
    has_cut_ = false;
    cuts_.fetch_add(1, std::memory_order_release);
  }
  if (is_freezing_ && stage_.load(std::memory_order_relaxed) == Stage::kWantsFreeze &&
      session.object(held_).changes(BrickSubscriber::kPieces).isEmpty())
    stage_.store(Stage::kFrozen, std::memory_order_release);
}

}  // namespace kerf
