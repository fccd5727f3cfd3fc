// A session: the step, commands between ticks, undo, and a sink for all events.
//
// All changes of a session come through apply() and tick(). The same calls, read from a log, give the same session
// again, bit for bit.
#pragma once

#include <algorithm>
#include <memory>
#include <span>

#include "sim/pieces/split_object.h"
#include "sim/session/command.h"
#include "sim/session/session_history.h"
#include "sim/session/session_log.h"
#include "sim/session/state_bytes.h"
#include "sim/step/step.h"

namespace kerf {

/// Receives all events in order. Session::step() and applyWithin() call it on the 1 kHz thread: such a sink must be
/// @rt.
class SessionSink {
 public:
  virtual ~SessionSink() = default;
  virtual void sample(const DeviceSample& sample, std::uint64_t tick) noexcept = 0;
  /// A completed command. Only a sink in lockstep may print it here.
  virtual void command(const Command& command, std::uint64_t tick) noexcept = 0;
  virtual void mark(StrokeMark mark, std::uint64_t tick) noexcept = 0;
  virtual void check(const StateCheck& check, std::uint64_t tick) noexcept = 0;
  /// The state after the sample of that tick: packState(). Never from Session::step().
  virtual void snapshot(std::span<const std::byte>, std::uint64_t /*tick*/) noexcept {}
};

/// Beside a State: the undo steps that it stands in.
struct SessionRest {
  bool is_in_stroke = false;
  bool has_steps = false;  ///< Session::hasSteps()
};

class Session {
 public:
  /// @param sink  kept by reference, may be null.
  Session(Model model, LoadedObjects objects, const Rigid3& start, SessionSink* sink = nullptr);
  /// Starts from a state, at any tick. Undo leads back to the first step that begins after it: not to the rest of a
  /// step that began before. @param loaded  the sources of its objects.
  Session(State state, Model model, LoadedObjects loaded, SessionSink* sink = nullptr, const SessionRest& rest = {});
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  // In lockstep: the calling thread reserves memory here.

  /// Does a command, between ticks; see command.h. False: no target, nothing changed or recorded. Allocates, so not
  /// @rt.
  bool apply(const Command& command);
  /// One tick. A stroke begins when the pedal goes down and ends when it comes up. Then reserves memory for the next
  /// tick and, if enabled, searches for pieces: allocates, so not @rt.
  void tick(const DeviceSample& sample, StepOutput& output);
  /// Undo leads back to here and no further. In a replay it may: it repeats the undos of the live session only.
  void keepForGood() noexcept;
  /// Ends a running stroke, and records the last check. No allocation.
  void finish() noexcept;

  // The same for a thread that must not allocate: another one reserves bricks for it (CutObject::take()).

  /// tick() within the bricks that are free, and without searching for pieces.
  /// @rt  as kerf::step(), and about 20 µs for the checks.
  void step(const DeviceSample& sample, StepOutput& output) noexcept;
  /// apply() within the bricks that are free; call repair() afterwards. Neither allocates nor prints.
  /// @rt  but Undo, Redo and DeleteObjects take some µs a brick; SplitObject and CutByPlanes allocate unless their
  /// pieces were offered, DeleteObjects unless its room was.
  bool applyWithin(const Command& command);
  /// Updates the shells after undo or redo. False: an object needs free bricks first; then call again. No allocation.
  bool repair() noexcept;
  /// Memory for the next DeleteObjects, of prepareDeletion(); kept until one takes it. @rt
  void offerRoom(std::unique_ptr<Split> room) noexcept { room_ = std::move(room); }
  bool hasRoom() const noexcept { return room_ != nullptr; }
  /// Whether the command has a target now. @rt
  bool canDelete(const DeleteObjects& command) const noexcept;
  /// Pieces for the next SplitObject or CutByPlanes of this object. They were made while the object was frozen, and the
  /// object has not changed since. @rt
  void offer(std::size_t object, std::unique_ptr<ObjectPieces> made) noexcept;
  /// Returns the offer, used or not. @rt
  std::unique_ptr<ObjectPieces> takeOffer() noexcept { return std::move(offered_); }
  /// Splits beyond undo and redo, for destruction by another thread. @rt
  std::unique_ptr<Split> takeForgotten() noexcept { return history_.takeForgotten(); }
  /// Whether Undo, Redo would have an effect now. @rt
  bool canUndo() const noexcept;
  bool canRedo() const noexcept;
  /// Whether undo steps stand, those before the state that this session starts from included.
  bool hasSteps() const noexcept;
  SessionRest rest() const noexcept { return {is_stroke_, hasSteps()}; }
  /// The steps that Undo and Redo take, and the last of them. @rt  @cost below 1 µs.
  UndoList undoList() const noexcept { return history_.list(state_.objects); }
  /// Whether a split would lose steps to redo. @rt
  bool wouldLoseRedo() const noexcept { return history_.redoable() > 0 && !history_.hasChanges(state_.objects); }
  /// For reserving bricks and exporting changed ones.
  CutObject& object(std::size_t n) noexcept { return state_.objects[n]; }

  // Snapshots and pieces, in lockstep.

  /// Gives the sink a snapshot at the start of a stroke, if so many ticks have gone by since the last one; 0: never. In
  /// lockstep only: a changed brick takes some µs.
  void snapshotEvery(std::uint64_t ticks) { snapshot_every_ = ticks; }
  /// Between two strokes. @pre the pedal is up. The cut so far becomes an undo step of its own.
  std::vector<std::byte> snapshot();
  /// Searches for pieces every so many cutting ticks, and splits an object in pieces; 0: never. In lockstep only: it
  /// takes milliseconds. A replay does not need it: it follows the recorded commands.
  void splitWhenApart(int every_ticks, const PieceOptions& options = {});
  /// Crumbs dropped so far. Undo does not reduce this count.
  struct Crumbs {
    std::size_t count = 0;
    SolidMeasure measure;
  };
  const Crumbs& crumbs() const { return crumbs_; }

  const Model& model() const { return model_; }
  const State& state() const { return state_; }
  /// The loaded objects, in the order of the beginning: `state().objects` are pieces of these.
  const LoadedObjects& loaded() const { return loaded_; }
  /// Index in loaded() of the object that this one is or is a piece of, also after several splits. @rt
  std::size_t loadedIndexOf(const CutObject& object) const noexcept;
  /// SessionHistory::bytes().
  std::size_t historyBytes() const noexcept { return history_.bytes(); }
  std::uint64_t hash() const { return state_.hash(); }
  /// The same number, faster: State::hashNow().
  std::uint64_t hashNow() noexcept { return state_.hashNow(); }

  /// Ticks between two state checks in the log. In step() a check waits until few enough bricks changed right before
  /// it, if need be to the end of the cut; in tick() for half as long again at most.
  static constexpr std::uint64_t kCheckEvery = 1000;
  /// Bricks to reserve for an object at a time: kReserve, less for a small one. Every tick begins with at least half of
  /// that free, live and replayed: a tick that needs no more changes the same bricks in both.
  static std::size_t reserveFor(const CutObject& object) noexcept {
    return std::min(kReserve, object.bricks().brickCount() + 1024);
  }
  static constexpr std::size_t kReserve = 4096;

 private:
  struct Watch;  // the pieces of one object

  // One for each alternative of Command; false: no target.
  bool perform(const SelectTool& command) noexcept;
  bool perform(const Undo& command) noexcept;
  bool perform(const Redo& command) noexcept;
  bool perform(const ClearLatch& command) noexcept;
  bool perform(const AddMaterial& command) noexcept;
  bool perform(const StopAdding& command) noexcept;
  bool perform(const MoveObject& command) noexcept;
  bool perform(const FreezeObject& command) noexcept;
  bool perform(const UnfreezeObject& command) noexcept;
  bool perform(const SplitObject& command);
  bool perform(const PlaceTool& command) noexcept;
  bool perform(const CutByPlanes& command);
  bool perform(const DeleteObjects& command);

  bool hasFrozen() const noexcept;
  StepOrigin now() const noexcept { return {state_.tick, state_.tool}; }
  void advance(const DeviceSample& sample, StepOutput& output) noexcept;
  void reserveBricks();
  void checkState(std::uint64_t tick) noexcept;
  void recordCheck(std::uint64_t tick) noexcept;
  void endStroke() noexcept;
  void markAll() noexcept;
  void closeStep() noexcept;
  void splitWhatIsApart();
  bool split(std::size_t index, double crumb_mm3);
  bool putInPlace(std::size_t index, ObjectPieces& made) noexcept;
  PieceFinder& finderOf(std::size_t index, double crumb_mm3);

  Model model_;
  State state_;
  SessionHistory history_;
  LoadedObjects loaded_;
  SessionSink* sink_;

  SessionRest rest_;
  bool is_rest_ = false;  // no step has begun since the state that this starts from
  bool is_stroke_ = false;
  bool is_check_due_ = false;
  std::uint64_t snapshot_every_ = 0;
  std::uint64_t last_snapshot_ = 0;

  // Pieces.
  std::vector<std::unique_ptr<Watch>> watches_;  // one an object, made on demand
  PieceOptions piece_options_;
  int split_every_ = 0;
  int ticks_cut_ = 0;
  std::size_t offered_to_ = 0;
  std::unique_ptr<ObjectPieces> offered_;
  std::unique_ptr<Split> room_;
  Crumbs crumbs_;
};

/// Data that a replay needs beside case and tool: settings, tissues, drives, all numbers unchanged.
SessionHeader describe(const Session& session);
/// Puts the numbers of a header into a model whose tools exist. Error kBadValue: a value is missing, no number, or out
/// of range.
Expected<void> restoreSettings(const SessionLog& log, const std::string& file, Model& model, Rigid3& start);

}  // namespace kerf
