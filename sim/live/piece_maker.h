// Detects that the cut object is in pieces, and makes objects of them, beside the 1 kHz thread.
//
// Detection takes milliseconds and making tens of them, so a thread of its own does both: the maker. It works on copies
// of the changed bricks. To make the pieces it needs the object itself at rest, so the object is frozen meanwhile: it
// is felt, but not cut. Freezing, splitting and unfreezing are commands of Session, done by the haptic thread and
// recorded. They depend on the state alone, so a replay does them in the same ticks and gets the same bits.
//
// The hand-over of one split, with the thread that moves it on:
//
//                 maker                    haptic              maker              haptic
//   ┌───────────┐         ┌──────────────┐         ┌─────────┐         ┌────────┐         ┌───────┐
//   │ kWatching │ ──────▶ │ kWantsFreeze │ ──────▶ │ kFrozen │ ──────▶ │ kReady │ ──────▶ │ kDone │
//   └───────────┘         └──────────────┘         └─────────┘         └────────┘         └───────┘
//     ▲     ▲                    │ haptic: not now                                           │
//     │     │               ┌────▼────┐                                                      │
//     │     └────────────── ┤ kNotNow │                                                      │
//     │       maker         └─────────┘                                                      │
//     └──────────────────────────────────────────────────────────────────────────────────────┘
//                              maker
//
//   stage          turn     what happens
//   kWatching      maker    takes changed bricks and searches them, until an object is in pieces or has crumbs
//   kWantsFreeze   haptic   FreezeObject; then ticks go on until the object's last bricks are sent. The maker takes
//                           these, and reads no more of the request than its id
//   kNotNow        maker    the object could not be frozen: it is searched again later
//   kFrozen        maker    reads the object, which does not change, and makes its pieces. Ticks go on
//   kReady         haptic   SplitObject puts the pieces in its place by a few pointers; without pieces UnfreezeObject
//                           (CutByPlanes for a cut that the user ordered)
//   kDone          maker    tells the subscriber of pieces, takes back memory that is left
//
// Only the thread whose turn it is touches the request and moves the stage on. Neither thread waits for the other.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "sim/pieces/split_object.h"
#include "sim/session/command.h"
#include "sim/session/session.h"

namespace kerf {

struct PieceMakerOptions {
  bool is_wanted = true;
  PieceOptions pieces;

  // The maker's thread calls both and waits for them: they must be quick. Exceptions are dropped. May be empty.

  /// An object is in pieces, or has crumbs, and is frozen: its pieces are made next. Called again after a failure.
  std::function<void(std::uint32_t id)> on_apart;
  /// Once for each piece in the scene, initial pieces included (an undo may have removed it again): its state when it
  /// came off, and a feed with every change since. To draw a piece, make its field (PieceOrigin::field()), mesh it and
  /// drain the feed, on a thread of its own. An undrained feed fills up; that does no harm until the end, when
  /// HapticThread::stop() waits for it. When no undo can restore the object, the consumer is the last to own its feed.
  std::function<void(std::shared_ptr<const PieceOrigin>, std::shared_ptr<BrickFeed>)> on_piece;

  /// All cores make the pieces; false: the maker's thread alone (see RemesherOptions::is_parallel).
  bool is_parallel = true;
};

/// One for a HapticThread, which calls the functions marked @rt.
///
/// The search for pieces runs during cutting, every 2 ms or a fourth of the time at most. The first cut of an object or
/// piece takes this thread up to 1.1 s for memory (a mandible of 148 000 bricks with all memory locked, on a virtual
/// machine; less else): splits in that time are found afterwards. Crumbs alone are removed twice a second at most. An
/// undo that makes pieces appear is no cut: they are split at the next cut. Nothing is split while material is added,
/// since it may not hang together yet.
class PieceMaker {
 public:
  /// @cost 2 µs a brick of the objects.
  PieceMaker(Session& session, const PieceMakerOptions& options);
  ~PieceMaker();  ///< as stop()
  PieceMaker(const PieceMaker&) = delete;
  PieceMaker& operator=(const PieceMaker&) = delete;

  void start();  ///< throws std::system_error without a thread
  void stop();   ///< may be called again

  // Haptic thread.

  /// Before a tick: freezes, splits or unfreezes. True: the objects of the scene changed. @rt
  bool beforeTick(Session& session) noexcept;
  /// After a tick: sends the changed bricks. @rt
  void afterTick(Session& session, const StepOutput& output) noexcept;
  /// After the last tick: unfreezes objects without splitting them. @rt
  void abandon(Session& session) noexcept;
  /// Orders a cut. It is done some ticks later; takeAnswer() reports it. False: the last order is still pending, or the
  /// object does not exist. @rt
  bool order(const Session& session, const CutByPlanes& command) noexcept;
  /// Once for each order: whether it was done. @rt
  std::optional<bool> takeAnswer() noexcept { return std::exchange(answer_, std::nullopt); }
  /// An object is frozen, or an order is pending: commands must wait. @rt
  bool isBusy() const noexcept { return is_freezing_ || is_ordered_.load(std::memory_order_relaxed); }
  /// An object is frozen: commands must wait. @rt
  bool hasFrozen() const noexcept { return is_freezing_; }
  /// A request waits for the next tick. @rt
  bool wantsTick() const noexcept {
    const Stage stage = stage_.load(std::memory_order_acquire);
    return stage == Stage::kWantsFreeze || stage == Stage::kReady;
  }
  /// Nothing is cut for now: the maker looks less often. @rt
  void rest(bool is_resting) noexcept { is_resting_.store(is_resting, std::memory_order_relaxed); }

  struct Counts {
    std::uint64_t splits = 0;
    std::uint64_t pieces = 0;
    std::uint64_t crumbs = 0;
    /// From the last search that found the object whole to its pieces in the scene: an upper bound for how long severed
    /// pieces were still one object.
    double longest_split_ms = 0;
    double longest_freeze_ms = 0;
  };
  const Counts& counts() const noexcept { return counts_; }  ///< of the haptic thread

 private:
  struct Subscriber;
  enum class Stage : int { kWatching, kWantsFreeze, kNotNow, kFrozen, kReady, kDone };
  enum class Answer {
    kDone,
    kGone,       // not in the scene: removed by undo
    kAfterACut,  // not during adding, nor while steps can be redone
    kInAMoment,  // lacks free bricks
  };
  struct Request {
    // Set by the maker, before the freeze.
    std::uint32_t id = 0;  // of the object
    double crumb_mm3 = 0;
    std::int64_t whole_at_ns = 0;  // when it was last found whole
    bool is_order = false;         // a cut by `order_`
    // Set by the haptic thread, when the object is frozen.
    const CutObject* whole = nullptr;
    std::uint32_t first_id = 0;
    std::size_t most = 0;
    // Set by the maker, when the pieces are ready.
    std::unique_ptr<ObjectPieces> made;  // null: none
    bool is_apart = false;               // though none are made: no memory, or too many objects
    // Set by the haptic thread, at the end.
    Answer answer = Answer::kDone;
  };

  // The maker: one function a stage, and their parts.
  void run();
  bool watch();           // kWatching. True: an object is to be split
  void drainRequested();  // kWantsFreeze
  void makeRequested();   // kFrozen
  void settle();          // kNotNow, kDone
  void collectBricks();
  bool isSearchDue(std::uint64_t cuts) const;
  bool search(std::int64_t taken_at);
  void requestSplit(const Subscriber& subscriber);
  void requestOrdered();
  void searchOrdered();
  void preparePieces(Subscriber& whole);
  void settlePieces(bool is_done);
  void reservePools() noexcept;
  void dropForgotten();
  void announcePieces();
  Subscriber& subscribe(std::uint32_t id, CutObject& object, std::shared_ptr<const PieceOrigin> origin);
  Subscriber* find(std::uint32_t id);

  // Haptic thread.
  void freezeRequested(Session& session) noexcept;  // kWantsFreeze
  bool putInPlace(Session& session) noexcept;       // kReady. True: the objects changed
  void refuse(Answer answer) noexcept;
  void moveOn(Stage to) noexcept { stage_.store(to, std::memory_order_release); }

  PieceMakerOptions options_;

  // Maker's thread.
  std::vector<std::unique_ptr<Subscriber>> subscribers_;
  std::map<const BakedObject*, PiecePool> pools_;  // for the next pieces of each loaded object being cut
  std::vector<std::unique_ptr<Subscriber>> spare_subscribers_;
  std::vector<std::shared_ptr<BrickFeed>> spare_feeds_;
  std::vector<std::shared_ptr<const PieceOrigin>> fresh_;  // pieces in the scene that are not announced yet
  std::uint64_t seen_cuts_ = 0;
  std::int64_t next_pools_ = 0;   // ns: next try after a lack of memory
  std::int64_t next_search_ = 0;  // ns
  std::int64_t crumbs_from_ = 0;  // ns: next removal of crumbs alone
  bool has_crumbs_ = false;       // crumbs wait for crumbs_from_
  bool must_scan_again_ = false;  // an object in pieces has to wait

  // Shared: see the table above.
  Request request_;
  std::atomic<Stage> stage_{Stage::kWatching};
  std::atomic<std::uint64_t> cuts_{0};      // ticks that cut and whose bricks were sent; haptic thread
  std::atomic<Split*> forgotten_{nullptr};  // from the haptic thread; the maker destroys it
  std::atomic<bool> is_stopping_{false};
  std::atomic<bool> is_resting_{false};
  CutByPlanes order_;                    // by the haptic thread, before it sets is_ordered_; then constant
  std::uint32_t ordered_id_ = 0;         // likewise: of the object
  std::atomic<bool> is_ordered_{false};  // until the request for it ends

  // Haptic thread.
  Counts counts_;
  bool is_freezing_ = false;
  bool has_cut_ = false;
  std::optional<bool> answer_;  // to the last order
  std::size_t frozen_ = 0;      // index of the object
  std::int64_t frozen_at_ns_ = 0;

  std::thread thread_;
};

}  // namespace kerf
