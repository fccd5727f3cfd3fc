// Looks whether what is being cut has come apart, and makes the pieces, beside the 1 kHz thread.
//
//   haptic thread ──bricks──▶ looks for pieces ── "it is in two" ──▶ object.hold: felt, but no longer cut
//   haptic thread ──last bricks──▶ makes them from the object at rest ──▶ pieces.split: puts them in its place
//
// Both are commands of Session, in its log, and depend on nothing but the state: a replay holds and splits in the same
// ticks and gets the same bits. Neither side waits for the other; what the haptic thread does is a few pointers.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "sim/pieces/object_pieces.h"
#include "sim/session/command.h"
#include "sim/session/session.h"

namespace kerf {

struct PieceMakerOptions {
  bool is_wanted = true;
  PieceOptions pieces;
  // Both are called by the maker's thread, which neither looks nor takes bricks meanwhile, so they must be quick; what
  // they throw is dropped. May be empty.

  /// An object has come apart, or has crumbs, and is at rest: its pieces are made next. Again when that failed.
  std::function<void(std::uint32_t id)> on_apart;
  /// Once for each piece, when it is in the scene (an undo may have taken it out again): what it was when it came off,
  /// and a feed that has every change since. Whoever draws makes the field (PieceOrigin::field()), meshes it and drains
  /// the feed, on a thread of its own; without a consumer the feed is full one day, which nobody minds until the end:
  /// HapticThread::stop() waits for it. Nobody but the consumer holds a feed whose object no undo brings back.
  std::function<void(std::shared_ptr<const PieceOrigin>, std::shared_ptr<BrickFeed>)> on_piece;
  /// Pieces are made by all cores; false: by the maker's thread alone (see RemesherOptions::is_parallel).
  bool is_parallel = true;
};

/// One for a HapticThread, which calls what is marked @rt.
///
/// Severed pieces are looked for while something is being cut, every 2 ms or a fourth of the time at most. The first
/// cut of an object or piece takes this thread up to 1.1 s for memory (a mandible of 148 000 bricks with all memory
/// locked, on a virtual machine; less else): what comes apart meanwhile is seen after that. Crumbs alone are taken away
/// twice a second at most. An undo that makes pieces appear is no cut: nothing is split until the next one, nor while
/// something is added, which may not hang together yet.
class PieceMaker {
 public:
  /// @cost 2 us a brick of the objects.
  PieceMaker(Session& session, const PieceMakerOptions& options);
  ~PieceMaker();  ///< as stop()
  PieceMaker(const PieceMaker&) = delete;
  PieceMaker& operator=(const PieceMaker&) = delete;

  void start();  ///< throws std::system_error without a thread
  void stop();   ///< may be called again

  // Haptic thread.

  /// Before a tick: holds, splits or releases. True: the objects of the scene are others now. @rt
  bool beforeTick(Session& session) noexcept;
  /// After a tick: sends what changed. @rt
  void afterTick(Session& session, const StepOutput& output) noexcept;
  /// After the last tick: what is held is released, and stays as it is. @rt
  void abandon(Session& session) noexcept;
  /// An object is held: no command may be done. @rt
  bool hasFrozen() const noexcept { return is_freezing_; }

  struct Counts {
    std::uint64_t splits = 0, pieces = 0, crumbs = 0;
    /// From the last look that found the object whole to its pieces in the scene: a bound for how long they were one
    /// object when they were severed already.
    double longest_split_ms = 0, longest_freeze_ms = 0;
  };
  const Counts& counts() const noexcept { return counts_; }  ///< haptic thread's

 private:
  struct Subscriber;
  // Who may touch the request: the maker in the stages it waits in, else the haptic thread.
  enum class Stage : int { kWatching, kWantsFreeze, kNotNow, kFrozen, kReady, kDone };
  enum class Answer {
    kDone,
    kGone,       // it is not in the scene: undo took it away
    kAfterACut,  // not while something is added, or could be redone
    kInAMoment,  // it lacks room
  };
  struct Request {
    std::uint32_t id = 0;  // of the object
    double crumb_mm3 = 0;
    std::int64_t whole_at_ns = 0;  // when it was last found whole
    const CutObject* whole = nullptr;
    std::uint32_t first_id = 0;
    std::size_t most = 0;
    std::unique_ptr<ObjectPieces> made;  // null: none
    bool is_apart = false;               // though there are none: no memory, or more than there may be objects
    Answer answer = Answer::kDone;
  };

  void run();
  bool look();
  void make();
  void prepare(Subscriber& whole);
  void finish();
  void dropTrash();
  void announce();
  Subscriber& follow(std::uint32_t id, CutObject& object, std::shared_ptr<const PieceOrigin> origin);
  void stockUp() noexcept;
  Subscriber* find(std::uint32_t id);

  PieceMakerOptions options_;
  std::vector<std::unique_ptr<Subscriber>> subscribers_;
  std::map<const BakedObject*, PiecePool> pools_;  // for the next pieces of each object as loaded that is being cut
  std::vector<std::unique_ptr<Subscriber>> spare_subscribers_;
  std::vector<std::shared_ptr<BrickFeed>> spare_feeds_;
  std::int64_t next_stock_ = 0;
  std::vector<std::shared_ptr<const PieceOrigin>> fresh_;  // pieces in the scene that nobody was told of yet
  std::uint64_t seen_cuts_ = 0;
  std::int64_t next_search_ = 0, crumbs_from_ = 0;
  bool has_crumbs_ = false;       // that wait for crumbs_from_
  bool must_scan_again_ = false;  // something has come apart that has to wait

  Request request_;
  std::atomic<Stage> stage_{Stage::kWatching};
  std::atomic<std::uint64_t> cuts_{0};  // ticks that cut something and whose bricks were sent
  std::atomic<Split*> trash_{nullptr};  // to be destroyed by the maker
  std::atomic<bool> is_stopping_{false};

  // Haptic thread.
  Counts counts_;
  bool is_freezing_ = false, has_cut_ = false;
  std::size_t held_ = 0;  // index of the object
  std::int64_t frozen_at_ns_ = 0;

  std::thread thread_;
};

}  // namespace kerf
