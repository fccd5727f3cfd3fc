// A session: the step, named commands between ticks, undo, and somebody who writes it all down.
//
// Everything a session does comes through apply() and tick(); whoever calls both with what a log holds gets the same
// session again, bit for bit.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "sim/pieces/object_pieces.h"
#include "sim/session/session_history.h"
#include "sim/session/session_log.h"
#include "sim/session/state_bytes.h"
#include "sim/step/step.h"

namespace kerf {

/// Who is told of everything, in the order in which it happens.
class SessionSink {
 public:
  virtual ~SessionSink() = default;
  virtual void sample(const DeviceSample& sample, std::uint64_t tick) noexcept = 0;
  virtual void command(std::string_view text, std::uint64_t tick) noexcept = 0;
  virtual void mark(StrokeMark mark, std::uint64_t tick) noexcept = 0;
  virtual void check(const StateCheck& check, std::uint64_t tick) noexcept = 0;
  /// The state after the sample of that tick: packState(). Never from Session::step().
  virtual void snapshot(std::span<const std::byte>, std::uint64_t /*tick*/) noexcept {}
};

class Session {
 public:
  /// @param sink  kept by reference, may be null.
  Session(Model model, LoadedObjects objects, const Rigid3& start, SessionSink* sink = nullptr);
  /// Goes on from a snapshot. Undo leads back to it and no further. @param loaded  what its objects were made of.
  Session(State state, Model model, LoadedObjects loaded, SessionSink* sink = nullptr);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Commands, between ticks:
  ///   tool.select N        another of the model's tools, by its index
  ///   undo, redo           the last stroke, with what the tool cut while it ran down; no redo during a stroke
  ///   latch.clear          after a fault of the device
  ///   add M N, add off     the pedal puts material number M on object N, instead of cutting
  ///   object.move N x y z qw qx qy qz   pose of object N in the world, mm; undone with the stroke before it
  ///   pieces.split N [V]   if object N is in pieces: each becomes an object of its own, the largest stays N, the
  ///                        others come last, by size; crumbs, smaller than V mm^3 (0.1), are dropped and counted, and
  ///                        removed if there is but one piece
  ///   object.hold N, object.release N   CutObject::freeze(); pieces.split releases, too. Meanwhile nothing is taken
  ///   back
  ///                        or moved
  /// False, and nothing is changed or written down: no such command, or there is nothing to do it to.
  bool apply(std::string_view command);
  /// One tick. A stroke begins when the pedal goes down and ends when it comes up. Makes room for the tick after it:
  /// allocates, so not @rt.
  void tick(const DeviceSample& sample, StepOutput& output);
  /// Ends a stroke that is under way, and writes the last check down. No allocation.
  void finish() noexcept;

  // The same for a thread that must not allocate, and is given room by another one: CutObject::take().

  /// tick() within the room there is, and without looking for pieces. @rt  as step(), and some 20 us for the checks.
  void step(const DeviceSample& sample, StepOutput& output) noexcept;
  /// apply() within the room there is: call repair() afterwards. @rt, but undo and redo take some us a brick, and
  /// pieces.split allocates if its pieces were not offered.
  bool applyWithin(std::string_view command);
  /// What the next pieces.split of this object is to put in its place: made while it was held, since when nothing was
  /// done to it. @rt
  void offer(std::size_t object, std::unique_ptr<ObjectPieces> made) noexcept;
  /// The same back, used or not. @rt
  std::unique_ptr<ObjectPieces> takeOffer() noexcept { return std::move(offered_); }
  /// What can not be brought back any more, to be destroyed where there is time. @rt
  std::unique_ptr<Split> takeForgotten() noexcept { return history_.takeForgotten(); }
  bool hasFrozen() const noexcept;
  /// Whether undo, redo would be done now. @rt
  bool canUndo() const noexcept {
    return !hasFrozen() && (history_.undoable() > 0 || history_.hasChanges(state_.objects));
  }
  bool canRedo() const noexcept {  // what was cut since the undo ends what could be redone
    return !hasFrozen() && !is_stroke_ && history_.redoable() > 0 && !history_.hasChanges(state_.objects);
  }
  /// Whether something could be redone that a split would end. @rt
  bool wouldLoseRedo() const noexcept { return history_.redoable() > 0 && !history_.hasChanges(state_.objects); }
  /// Brings the shells up to date after undo or redo. False: an object needs room first; then again. No allocation.
  bool repair() noexcept;
  CutObject& object(std::size_t n) noexcept { return state_.objects[n]; }  ///< for taking room and exporting bricks

  /// Gives the sink a snapshot when a stroke begins, if so many ticks have gone by since the last one; 0: never. In
  /// lockstep: a changed brick takes some us.
  void snapshotEvery(std::uint64_t ticks) { snapshot_every_ = ticks; }
  /// Between two strokes. @pre the pedal is up: what was cut so far is a step of undo of its own.
  std::vector<std::byte> snapshot();

  /// Looks for pieces every so many ticks in which something was cut, and splits what has come apart; 0: never. For
  /// sessions in lockstep: it takes milliseconds. A replay does not ask: it follows the commands.
  void splitWhenApart(int every_ticks, const PieceOptions& options = {});
  /// What was dropped as crumbs so far, for good: an undo counts it no less.
  struct Crumbs {
    std::size_t count = 0;
    SolidMeasure measure;
  };
  const Crumbs& crumbs() const { return crumbs_; }

  const Model& model() const { return model_; }
  const State& state() const { return state_; }
  std::uint64_t hash() const { return state_.hash(); }
  /// Ticks between two state checks in the log. In step() one waits until few enough bricks changed right before it,
  /// if need be to the end of the cut; in tick() for half as long again at most.
  static constexpr std::uint64_t kCheckEvery = 1000;
  /// Bricks an object is given room for at a time: kReserve, less for a small one. Every tick begins with half of it at
  /// least, live and replayed: what needs no more finds room in both.
  static std::size_t reserveFor(const CutObject& object) noexcept {
    return std::min(kReserve, object.bricks().brickCount() + 1024);
  }
  static constexpr std::size_t kReserve = 4096;

 private:
  struct Watch;  // the pieces of one object
  void advance(const DeviceSample& sample, StepOutput& output) noexcept;
  void reserveBricks();
  void checkState(std::uint64_t tick) noexcept;
  void endStroke() noexcept;
  void markAll() noexcept;
  bool split(std::size_t index, double crumb_mm3);
  bool putInPlace(std::size_t index, ObjectPieces& made) noexcept;
  PieceFinder& finderOf(std::size_t index, double crumb_mm3);

  Model model_;
  State state_;
  SessionHistory history_;
  LoadedObjects loaded_;
  std::uint64_t snapshot_every_ = 0, last_snapshot_ = 0;
  std::vector<std::unique_ptr<Watch>> watches_;  // one an object, made when asked for
  PieceOptions piece_options_;
  int split_every_ = 0, ticks_cut_ = 0;
  std::size_t offered_to_ = 0;
  std::unique_ptr<ObjectPieces> offered_;
  Crumbs crumbs_;
  SessionSink* sink_;
  bool is_stroke_ = false, is_check_due_ = false;
};

/// What a replay needs to know beside case and tool: settings, tissues, drives, all numbers as they were.
SessionHeader describe(const Session& session);
/// Puts the numbers of a header into a model whose tools are made already. Error: a value is missing or no number.
Expected<void> restoreSettings(const SessionLog& log, const std::string& file, Model& model, Rigid3& start);

}  // namespace kerf
