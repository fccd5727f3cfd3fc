#include "sim/session/session.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "sim/pieces/plane_parts.h"

namespace kerf {
namespace {

// A state check hashes no more bricks than this in a tick: about 100 µs.
constexpr std::size_t kMostAtOnce = 128;
// In the ticks before a check: bricks hashed per tick, of those unchanged for kLeftAlone contact evaluations.
constexpr std::size_t kHashesATick = 16;
constexpr std::uint32_t kLeftAlone = 32;

State stateOf(const LoadedObjects& objects, const Rigid3& start) {
  State out;
  out.objects.reserve(kMostObjects);
  for (const auto& object : objects) out.objects.emplace_back(object, Session::kReserve).id = out.next_id++;
  out.place(start);
  return out;
}

bool needsBricks(const CutObject& object) {
  return object.freeBricks() < Session::reserveFor(object) / 2 || object.memory().freeRecords() < 4;
}

// Material may have appeared around the tool: the force has to fade in again, or it would strike the hand.
bool mayMeetTool(const Command& command) noexcept {
  return std::holds_alternative<Undo>(command) || std::holds_alternative<Redo>(command) ||
         std::holds_alternative<StopAdding>(command) || std::holds_alternative<MoveObject>(command);
}

// For MoveObject and PlaceTool.
template <class Placing>
Rigid3 poseOf(const Placing& command) noexcept {
  const auto& [x, y, z] = command.translation;
  const auto& [qw, qx, qy, qz] = command.rotation;
  Rigid3 pose;
  pose.translation = Vec3d(x, y, z);
  pose.rotation = Eigen::Quaterniond(qw, qx, qy, qz);
  return pose;
}

}  // namespace

// Finds the pieces of one object.
struct Session::Watch {
  PieceOptions options;
  std::unique_ptr<PieceFinder> finder;
  std::vector<BrickEdit> edits;
};

Session::Session(Model model, LoadedObjects objects, const Rigid3& start, SessionSink* sink)
    : model_(std::move(model)),
      state_(stateOf(objects, start)),
      history_(state_.objects),
      loaded_(std::move(objects)),
      sink_(sink) {}

std::size_t Session::loadedIndexOf(const CutObject& object) const noexcept {
  for (std::size_t n = 0; n < loaded_.size(); ++n)
    if (loaded_[n].get() == &object.baked()) return n;
  return 0;
}

Session::Session(State state, Model model, LoadedObjects loaded, SessionSink* sink, const SessionRest& rest)
    : model_(std::move(model)),
      state_(std::move(state)),
      history_(state_.objects),
      loaded_(std::move(loaded)),
      sink_(sink),
      rest_(rest),
      is_rest_(true),
      is_stroke_(rest.is_in_stroke),
      last_snapshot_(state_.tick) {
  reserveBricks();
}

Session::~Session() = default;

// ---- Commands ------------------------------------------------------------------------------------------------------

bool Session::apply(const Command& command) {
  if (!applyWithin(command)) return false;
  reserveBricks();
  return true;
}

bool Session::applyWithin(const Command& command) {
  const std::size_t count = state_.objects.size();
  const std::uint32_t adds_to = state_.adds_to < count ? state_.objects[state_.adds_to].id : state_.next_id;
  if (!std::visit([this](const auto& c) { return perform(c); }, command)) return false;

  // The object for added material may have another number now, or be gone: rather none than another one.
  bool is_gone = state_.adds_to >= state_.objects.size();
  const bool is_undo = std::holds_alternative<Undo>(command);
  if (is_undo || std::holds_alternative<Redo>(command) || std::holds_alternative<DeleteObjects>(command)) {
    const auto& all = state_.objects;
    const auto at = std::find_if(all.begin(), all.end(), [&](const CutObject& object) { return object.id == adds_to; });
    if (at != all.end()) state_.adds_to = static_cast<std::size_t>(at - all.begin());
    is_gone = at == all.end() && (is_gone || (!is_undo && all.size() < count));
  }
  if (is_gone) {
    state_.adds = Material::kNone;
    state_.adds_to = 0;
  }
  if (mayMeetTool(command)) state_.ramp = 0;

  if (sink_) sink_->command(command, state_.tick);
  return true;
}

bool Session::perform(const SelectTool& command) noexcept {
  if (command.tool >= model_.tools.size()) return false;
  state_.selectTool(command.tool);
  return true;
}

bool Session::perform(const Undo&) noexcept {
  if (!canUndo()) return false;
  if (is_stroke_) endStroke();
  markAll();
  watches_.clear();
  state_.forgetTurns();
  return history_.undo(state_.objects);
}

bool Session::perform(const Redo&) noexcept {
  if (!canRedo()) return false;
  watches_.clear();
  state_.forgetTurns();
  return history_.redo(state_.objects);
}

bool Session::perform(const ClearLatch&) noexcept {
  state_.clearLatch();
  return true;
}

bool Session::perform(const AddMaterial& command) noexcept {
  const bool is_there = command.object < state_.objects.size();
  if (!is_there || command.material == 0 || !model_.tissues[command.material].is_in_table) return false;
  state_.adds = static_cast<Material>(command.material);
  state_.adds_to = command.object;
  return true;
}

bool Session::perform(const StopAdding&) noexcept {
  state_.adds = Material::kNone;
  return true;
}

bool Session::perform(const MoveObject& command) noexcept {
  if (command.object >= state_.objects.size() || hasFrozen()) return false;
  const Rigid3 pose = poseOf(command);
  if (!pose.isUsable()) return false;
  if (!is_stroke_) closeStep();  // a step of undo of its own
  state_.objects[command.object].moveTo(pose);
  return true;
}

bool Session::perform(const FreezeObject& command) noexcept {
  if (command.object >= state_.objects.size() || hasFrozen()) return false;
  CutObject& object = state_.objects[command.object];
  if (object.dirtyCount() > 0 && !object.repair()) return false;  // pieces take over its shells
  object.freeze();
  return true;
}

bool Session::perform(const UnfreezeObject& command) noexcept {
  if (command.object >= state_.objects.size() || !state_.objects[command.object].isFrozen()) return false;
  state_.objects[command.object].unfreeze();
  return true;
}

bool Session::perform(const SplitObject& command) {
  const double crumb_mm3 = command.crumb_mm3.value_or(PieceOptions{}.crumb_mm3);
  if (command.object >= state_.objects.size() || !(crumb_mm3 >= 0 && crumb_mm3 < 1e9)) return false;
  return split(command.object, crumb_mm3);
}

bool Session::perform(const PlaceTool& command) noexcept {
  const Rigid3 pose = poseOf(command);
  if (!pose.isUsable()) return false;
  if (is_stroke_) endStroke();
  state_.moveTool(pose);
  return true;
}

bool Session::perform(const CutByPlanes& command) {
  const bool is_good = command.object < state_.objects.size() && state_.objects.size() < kMostObjects &&
                       command.keep <= static_cast<std::uint8_t>(PlaneKeep::kBelow) && command.planes.isUsable();
  if (!is_good) return false;
  CutObject& whole = state_.objects[command.object];
  const auto put = [&](ObjectPieces& made) {  // an undo step of its own
    closeStep();
    return putInPlace(command.object, made);
  };
  if (offered_ && offered_to_ == command.object) return put(*offered_);
  if (hasFrozen() && !whole.isFrozen()) return false;
  while (whole.dirtyCount() > 0 && !whole.repair())
    if (!whole.reserve(reserveFor(whole))) return false;
  const auto made =
      makePlaneParts(whole, command.planes, static_cast<PlaneKeep>(command.keep), state_.next_id, state_.next_id);
  return made && put(*made);
}

bool Session::canDelete(const DeleteObjects& command) const noexcept {
  const std::vector<CutObject>& objects = state_.objects;
  const std::uint64_t which = command.objects.bits;
  if (hasFrozen() || which == 0 || static_cast<std::size_t>(std::bit_width(which)) > objects.size()) return false;
  const BakedObject& loaded = objects[static_cast<std::size_t>(std::countr_zero(which))].baked();
  bool stays = false;
  for (std::size_t n = 0; n < objects.size(); ++n) {
    const bool is_same = &objects[n].baked() == &loaded;
    if (command.objects.has(n) && !is_same) return false;
    stays |= !command.objects.has(n) && is_same;
  }
  return stays;
}

bool Session::perform(const DeleteObjects& command) {
  static_assert(kMostObjects <= ObjectSet::kMost);
  if (!canDelete(command)) return false;
  if (is_stroke_) endStroke();
  closeStep();  // an undo step of its own
  watches_.clear();
  history_.erase(state_.objects, command.objects.bits, room_ ? std::move(room_) : prepareDeletion());
  state_.forgetTurns();
  return true;
}

bool Session::canUndo() const noexcept {
  return !hasFrozen() && !is_rest_ && (history_.undoable() > 0 || history_.hasChanges(state_.objects));
}

// A cut since the undo drops the steps to redo.
bool Session::canRedo() const noexcept {
  return !hasFrozen() && !is_stroke_ && history_.redoable() > 0 && !history_.hasChanges(state_.objects);
}

bool Session::hasSteps() const noexcept {
  return rest_.has_steps || history_.undoable() > 0 || history_.hasChanges(state_.objects);
}

bool Session::hasFrozen() const noexcept {
  return std::any_of(state_.objects.begin(), state_.objects.end(), [](const CutObject& o) { return o.isFrozen(); });
}

void Session::keepForGood() noexcept {
  closeStep();
  history_.keepForGood();
}

// ---- Memory

// Without memory the shells stay unchanged: the step reports kStepBricksRanOut.
void Session::reserveBricks() {
  static_cast<void>(takeForgotten());
  for (CutObject& object : state_.objects)
    if (needsBricks(object)) object.reserve(reserveFor(object));
  for (CutObject& object : state_.objects)
    while (object.dirtyCount() > 0 && !object.repair())
      if (!object.reserve(reserveFor(object))) break;
}

bool Session::repair() noexcept {
  bool is_done = true;
  for (CutObject& object : state_.objects) is_done &= object.dirtyCount() == 0 || object.repair();
  return is_done;
}

// ---- Pieces

void Session::splitWhenApart(int every_ticks, const PieceOptions& options) {
  split_every_ = every_ticks;
  piece_options_ = options;
  watches_.clear();
}

// Finder of the current object, updated with the bricks changed since the last call.
PieceFinder& Session::finderOf(std::size_t index, double crumb_mm3) {
  CutObject& object = state_.objects[index];
  if (watches_.size() <= index) watches_.resize(index + 1);
  std::unique_ptr<Watch>& watch = watches_[index];
  const auto collect = [&](const CutObject::Slot& slot) {
    BrickEdit& edit = watch->edits.emplace_back();
    edit.brick = slot.brick;
    std::copy_n(slot.phi, kBrickNodes, edit.phi.begin());
    return true;
  };

  if (watch && watch->options.crumb_mm3 == crumb_mm3) {
    object.changes(BrickSubscriber::kPieces).take(collect);
  } else {
    watch = std::make_unique<Watch>();
    watch->options.crumb_mm3 = crumb_mm3;
    object.changes(BrickSubscriber::kPieces).take([](const CutObject::Slot&) { return true; });
    const BrickField& phi0 = object.baked().phi0();
    if (object.bricks().isPiece()) {
      std::vector<Vec3i> bricks;
      for (int s = 0; s < object.bricks().firstSlotCount(); ++s)
        if (object.bricks().has(s)) bricks.push_back(object.slot(s).brick);
      watch->finder = std::make_unique<PieceFinder>(phi0, bricks, watch->options);
    } else {
      watch->finder = std::make_unique<PieceFinder>(phi0, watch->options);
    }
    for (int s = 0; s < object.slotCount(); ++s)
      if (object.slot(s).own) collect(object.slot(s));
  }

  watch->finder->apply(watch->edits);
  watch->edits.clear();
  return *watch->finder;
}

bool Session::split(std::size_t index, double crumb_mm3) {
  CutObject& whole = state_.objects[index];
  if (offered_ && offered_to_ == index) return putInPlace(index, *offered_);
  if (hasFrozen() && !whole.isFrozen()) return false;
  // A piece takes over its shells: they must match its values.
  while (whole.dirtyCount() > 0 && !whole.repair())
    if (!whole.reserve(reserveFor(whole))) return false;

  const std::size_t most = kMostObjects + 1 - state_.objects.size();
  const auto made = makePieces(whole, finderOf(index, crumb_mm3), state_.next_id, most);
  if (!made) return false;
  if (whole.freeBricks() < made->without_crumbs.size() && !whole.reserve(made->without_crumbs.size())) return false;
  return putInPlace(index, *made);
}

void Session::offer(std::size_t object, std::unique_ptr<ObjectPieces> made) noexcept {
  offered_to_ = object;
  offered_ = std::move(made);
}

// The part that must not allocate.
bool Session::putInPlace(std::size_t index, ObjectPieces& made) noexcept {
  CutObject& whole = state_.objects[index];
  if (!made.parts && whole.freeBricks() < made.without_crumbs.size()) return false;
  whole.unfreeze();
  if (made.parts) {
    markAll();
    if (index < watches_.size()) watches_[index].reset();
    state_.next_id += static_cast<std::uint32_t>(made.parts->parts);
    history_.split(state_.objects, index, std::move(made.parts));
    state_.forgetTurns();
  } else {  // part of the running stroke
    double removed = 0;
    for (const BrickEdit& edit : made.without_crumbs)
      whole.carve(whole.find(edit.brick), edit.phi.data(), *std::min_element(edit.phi.begin(), edit.phi.end()),
                  removed);
  }
  crumbs_.count += made.crumbs;
  crumbs_.measure.add(made.crumb_measure);
  return true;
}

void Session::splitWhatIsApart() {
  for (std::size_t n = state_.objects.size(); n-- > 0;) {
    // Skips objects without changes.
    if (n < watches_.size() && watches_[n] && state_.objects[n].changes(BrickSubscriber::kPieces).isEmpty()) continue;
    const PieceList& list = finderOf(n, piece_options_.crumb_mm3).find();
    if (list.pieces.size() + list.crumbs.size() > 1) apply(SplitObject{n, piece_options_.crumb_mm3});
  }
}

// ---- Strokes and ticks

void Session::markAll() noexcept {
  if (history_.hasChanges(state_.objects)) history_.mark(state_.objects);
}

// Ends the step so far. The next change begins another one.
void Session::closeStep() noexcept {
  markAll();
  if (std::exchange(is_rest_, false)) {
    rest_.has_steps = hasSteps();
    history_.keepForGood();
  }
  history_.close(now());
}

// The tool runs down after this and may still cut: that belongs to the stroke, so markAll() makes its step later.
void Session::endStroke() noexcept {
  is_stroke_ = false;
  if (sink_) sink_->mark(StrokeMark::kEnd, state_.tick);
}

void Session::advance(const DeviceSample& sample, StepOutput& output) noexcept {
  const bool presses = sample.isUsable() && sample.pedal != 0;
  if (presses && !is_stroke_) {
    is_stroke_ = true;
    closeStep();
    if (sink_) sink_->mark(StrokeMark::kBegin, state_.tick);
  } else if (!presses && is_stroke_) {
    endStroke();
  }
  if (sink_) sink_->sample(sample, state_.tick);
  kerf::step(model_, state_, sample, output);
}

void Session::recordCheck(std::uint64_t tick) noexcept {
  sink_->check({state_.hashNow(), state_.last_force}, tick);
  is_check_due_ = false;
}

// Hashing all bricks of a state takes much longer than a tick. So each tick hashes a few bricks at rest. A check with
// too many left waits for the next tick.
void Session::checkState(std::uint64_t tick) noexcept {
  if (!sink_) return;
  is_check_due_ |= state_.tick % kCheckEvery == 0;
  std::size_t stale = 0;
  for (const CutObject& object : state_.objects) stale += object.staleHashes();
  if (is_check_due_ && stale <= kMostAtOnce) {
    recordCheck(tick);
    return;
  }

  std::size_t left = is_check_due_ ? kMostAtOnce : kHashesATick;  // for all objects together
  for (CutObject& object : state_.objects) {
    const std::size_t before = object.staleHashes();
    object.prepareHash(left, is_check_due_ ? 0 : kLeftAlone);
    left -= before - object.staleHashes();
    if (left == 0) break;
  }
}

void Session::step(const DeviceSample& sample, StepOutput& output) noexcept {
  const std::uint64_t tick = state_.tick;
  advance(sample, output);
  checkState(tick);
}

std::vector<std::byte> Session::snapshot() {
  closeStep();
  last_snapshot_ = state_.tick;
  return packState(state_, loaded_);
}

void Session::tick(const DeviceSample& sample, StepOutput& output) {
  const std::uint64_t tick = state_.tick;
  const bool begins_stroke = !is_stroke_ && sample.isUsable() && sample.pedal != 0;
  if (sink_ && snapshot_every_ > 0 && tick > 0 && tick - last_snapshot_ >= snapshot_every_ && begins_stroke)
    sink_->snapshot(snapshot(), tick - 1);

  advance(sample, output);

  for (CutObject& object : state_.objects)
    if (needsBricks(object)) object.reserve(reserveFor(object));

  // Added material may not hang together yet.
  const bool has_cut = state_.adds == Material::kNone && output.bricks_cut > 0;
  if (split_every_ > 0 && has_cut && ++ticks_cut_ >= split_every_) {
    ticks_cut_ = 0;
    splitWhatIsApart();
  }

  // Lockstep has no deadline: does a check at any cost if a long cut keeps delaying it.
  if (is_check_due_ && sink_ && state_.tick % kCheckEvery == kCheckEvery / 2) recordCheck(tick);
  checkState(tick);
}

void Session::finish() noexcept {
  if (is_stroke_) endStroke();
  markAll();
  if (sink_ && state_.tick > 0) sink_->check({state_.hashNow(), state_.last_force}, state_.tick - 1);
}

}  // namespace kerf
