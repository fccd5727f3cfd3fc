#include "sim/session/session.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <charconv>
#include <cmath>
#include <optional>

namespace kerf {
namespace {

// A state check looks at no more bricks than this at a time: some 100 us.
constexpr std::size_t kMostAtOnce = 128;
// In the ticks before it, this many a tick that were left alone for so many looks at contact.
constexpr std::size_t kHashesATick = 16;
constexpr std::uint32_t kLeftAlone = 32;

/// Numbers by name, for writing and for reading alike: one list, so that neither forgets one.
template <class Visit>
void visitNumbers(StepSettings& s, const Visit& visit) {
  CouplingSettings& c = s.coupling;
  visit("coupling.stiffness", c.stiffness);
  visit("coupling.damping", c.damping);
  visit("coupling.turn_stiffness", c.turn_stiffness);
  visit("coupling.turn_damping", c.turn_damping);
  visit("coupling.mass_kg", c.mass_kg);
  visit("coupling.gyration_mm", c.gyration_mm);
  visit("coupling.filter_hz", c.filter_hz);
  visit("coupling.force_limit", c.force_limit);
  visit("coupling.torque_limit", c.torque_limit);
  visit("coupling.force_rate", c.force_rate);
  visit("coupling.torque_rate", c.torque_rate);
  visit("ramp_s", s.ramp_s);
  double rendering = static_cast<double>(s.rendering), geometry = s.geometry_only, substeps = s.most_substeps;
  double response = static_cast<double>(s.response);
  visit("rendering", rendering);
  visit("geometry_only", geometry);
  visit("most_substeps", substeps);
  visit("response", response);
  visit("restitution", s.restitution);
  s.response = static_cast<Response>(static_cast<int>(response));
  s.rendering = static_cast<Rendering>(static_cast<int>(rendering));
  s.geometry_only = geometry != 0;
  s.most_substeps = static_cast<int>(substeps);
}

std::string numbers(std::initializer_list<double> values) {
  std::string out;
  for (const double v : values) out += fmt::format("{}{}", out.empty() ? "" : " ", v);  // shortest that reads back
  return out;
}

bool parse(std::string_view text, std::span<double> out) {
  const char *at = text.data(), *end = at + text.size();
  for (double& value : out) {
    while (at < end && *at == ' ') ++at;
    const auto [next, failed] = std::from_chars(at, end, value);
    if (failed != std::errc{} || next == at || !(std::abs(value) < 1e9)) return false;
    at = next;
  }
  return at == end;
}

}  // namespace

// Follows one object.
struct Session::Watch {
  PieceOptions options;
  std::unique_ptr<PieceFinder> finder;
  std::vector<BrickEdit> edits;
};

namespace {

State stateOf(const LoadedObjects& objects, const Rigid3& start) {
  State out;
  out.objects.reserve(kMostObjects);
  for (const auto& object : objects) out.objects.emplace_back(object, Session::kReserve).id = out.next_id++;
  out.place(start);
  return out;
}

}  // namespace

Session::Session(Model model, LoadedObjects objects, const Rigid3& start, SessionSink* sink)
    : model_(std::move(model)),
      state_(stateOf(objects, start)),
      history_(state_.objects),
      loaded_(std::move(objects)),
      sink_(sink) {}

Session::Session(State state, Model model, LoadedObjects loaded, SessionSink* sink)
    : model_(std::move(model)),
      state_(std::move(state)),
      history_(state_.objects),
      loaded_(std::move(loaded)),
      last_snapshot_(state_.tick),
      sink_(sink) {
  reserveBricks();
}

Session::~Session() = default;

bool Session::apply(std::string_view command) {
  if (!applyWithin(command)) return false;
  reserveBricks();
  return true;
}

// Without memory shells stay as they are until there is some: the step says kStepBricksRanOut.
void Session::reserveBricks() {
  static_cast<void>(takeForgotten());
  for (CutObject& object : state_.objects)
    if (object.freeBricks() < reserveFor(object) / 2 || object.memory().freeRecords() < 4)
      object.reserve(reserveFor(object));
  for (CutObject& object : state_.objects)
    while (object.dirtyCount() > 0 && !object.repair())
      if (!object.reserve(reserveFor(object))) break;
}

bool Session::repair() noexcept {
  bool is_done = true;
  for (CutObject& object : state_.objects) is_done &= object.dirtyCount() == 0 || object.repair();
  return is_done;
}

bool Session::applyWithin(std::string_view command) {
  std::string_view rest = command;
  const auto word = [&rest]() -> std::string_view {
    const std::size_t end = rest.find(' ');
    const std::string_view out = rest.substr(0, end);
    rest = end == rest.npos ? std::string_view{} : rest.substr(end + 1);
    return out;
  };
  const auto number = [](std::string_view text, std::size_t below) -> std::optional<std::size_t> {
    std::size_t value = 0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failed != std::errc{} || end != text.data() + text.size() || value >= below) return std::nullopt;
    return value;
  };
  bool is_done = false;
  const std::string_view verb = word();
  if (command == "undo") {
    if (canUndo()) {
      if (is_stroke_) endStroke();
      markAll();
      watches_.clear();
      is_done = history_.undo(state_.objects);
    }
  } else if (command == "redo") {
    if (canRedo()) {
      watches_.clear();
      is_done = history_.redo(state_.objects);
    }
  } else if (command == "latch.clear") {
    state_.clearLatch();
    is_done = true;
  } else if (verb == "tool.select") {
    if (const auto index = number(rest, model_.tools.size())) {
      state_.selectTool(*index);
      is_done = true;
    }
  } else if (command == "add off") {
    state_.adds = Material::kNone;
    is_done = true;
  } else if (verb == "add") {
    const auto material = number(word(), 256), object = number(rest, state_.objects.size());
    if (material && object && *material > 0 && model_.tissues[*material].is_in_table) {
      state_.adds = static_cast<Material>(*material);
      state_.adds_to = *object;
      is_done = true;
    }
  } else if (verb == "object.move") {
    const auto object = number(word(), state_.objects.size());
    std::array<double, 7> v{};
    Rigid3 pose;
    if (object && !hasFrozen() && parse(rest, v)) {
      pose.translation = Vec3d(v[0], v[1], v[2]);
      pose.rotation = Eigen::Quaterniond(v[3], v[4], v[5], v[6]);
      if (std::abs(pose.rotation.norm() - 1) < 1e-6 && pose.translation.norm() < 1e5) {
        state_.objects[*object].moveTo(pose);
        is_done = true;
      }
    }
  } else if (verb == "pieces.split") {
    const auto object = number(word(), state_.objects.size());
    double crumb = PieceOptions{}.crumb_mm3;
    if (object && (rest.empty() || (parse(rest, std::span(&crumb, 1)) && crumb >= 0))) is_done = split(*object, crumb);
  } else if (verb == "object.hold") {
    const auto object = number(rest, state_.objects.size());
    is_done = object && !hasFrozen() && state_.objects[*object].dirtyCount() == 0;
    if (is_done) state_.objects[*object].freeze();
  } else if (verb == "object.release") {
    const auto object = number(rest, state_.objects.size());
    is_done = object && state_.objects[*object].isFrozen();
    if (is_done) state_.objects[*object].unfreeze();
  }
  // What it went to may be gone: better nothing than something else.
  if (is_done && state_.adds_to >= state_.objects.size()) {
    state_.adds = Material::kNone;
    state_.adds_to = 0;
  }
  // Material may have appeared around the tool: a hand must not be struck.
  if (is_done && (command == "undo" || command == "redo" || command == "add off" || verb == "object.move"))
    state_.ramp = 0;
  if (is_done && sink_) sink_->command(command, state_.tick);
  return is_done;
}

void Session::splitWhenApart(int every_ticks, const PieceOptions& options) {
  split_every_ = every_ticks;
  piece_options_ = options;
  watches_.clear();
}

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
  if (!watch || watch->options.crumb_mm3 != crumb_mm3) {
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
  } else {
    object.changes(BrickSubscriber::kPieces).take(collect);
  }
  watch->finder->apply(watch->edits);
  watch->edits.clear();
  return *watch->finder;
}

bool Session::split(std::size_t index, double crumb_mm3) {
  CutObject& whole = state_.objects[index];
  if (offered_ && offered_to_ == index) return putInPlace(index, *offered_);
  if (hasFrozen() && !whole.isFrozen()) return false;
  // A piece takes its shells over: they must be those of its values.
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

bool Session::hasFrozen() const noexcept {
  return std::any_of(state_.objects.begin(), state_.objects.end(), [](const CutObject& o) { return o.isFrozen(); });
}

// The part that may not allocate.
bool Session::putInPlace(std::size_t index, ObjectPieces& made) noexcept {
  CutObject& whole = state_.objects[index];
  if (!made.parts && whole.freeBricks() < made.without_crumbs.size()) return false;
  whole.unfreeze();
  if (made.parts) {
    markAll();
    if (index < watches_.size()) watches_[index].reset();
    state_.next_id += static_cast<std::uint32_t>(made.parts->parts);
    history_.split(state_.objects, index, std::move(made.parts));
  } else {  // the stroke under way has done that, too
    double removed = 0;
    for (const BrickEdit& edit : made.without_crumbs)
      whole.carve(whole.find(edit.brick), edit.phi.data(), *std::min_element(edit.phi.begin(), edit.phi.end()),
                  removed);
  }
  crumbs_.count += made.crumbs;
  crumbs_.measure.add(made.crumb_measure);
  return true;
}

void Session::markAll() noexcept {
  if (history_.hasChanges(state_.objects)) history_.mark(state_.objects);
}

// The tool runs down after this and may still cut: that belongs to the stroke, so its step is made later, by markAll().
void Session::endStroke() noexcept {
  is_stroke_ = false;
  if (sink_) sink_->mark(StrokeMark::kEnd, state_.tick);
}

void Session::advance(const DeviceSample& sample, StepOutput& output) noexcept {
  const bool presses = sample.isUsable() && sample.pedal > 0;
  if (presses && !is_stroke_) {
    is_stroke_ = true;
    markAll();
    history_.close();
    if (sink_) sink_->mark(StrokeMark::kBegin, state_.tick);
  } else if (!presses && is_stroke_) {
    endStroke();
  }
  if (sink_) sink_->sample(sample, state_.tick);
  kerf::step(model_, state_, sample, output);
}

// All of a state's bricks take much longer than a tick. So those at rest are looked at a few a tick, and a check that
// finds more left than it can do waits for the next tick.
void Session::checkState(std::uint64_t tick) noexcept {
  if (!sink_) return;
  is_check_due_ |= state_.tick % kCheckEvery == 0;
  std::size_t stale = 0;
  for (const CutObject& object : state_.objects) stale += object.staleHashes();
  if (is_check_due_ && stale <= kMostAtOnce) {
    sink_->check({state_.hashNow(), state_.last_force}, tick);
    is_check_due_ = false;
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
  markAll();
  history_.close();
  last_snapshot_ = state_.tick;
  return packState(state_, loaded_);
}

void Session::tick(const DeviceSample& sample, StepOutput& output) {
  const std::uint64_t tick = state_.tick;
  if (sink_ && snapshot_every_ > 0 && tick > 0 && tick - last_snapshot_ >= snapshot_every_ && !is_stroke_ &&
      sample.isUsable() && sample.pedal > 0)
    sink_->snapshot(snapshot(), tick - 1);
  advance(sample, output);
  for (CutObject& object : state_.objects)
    if (object.freeBricks() < reserveFor(object) / 2 || object.memory().freeRecords() < 4)
      object.reserve(reserveFor(object));
  // What is being added may not hang together yet.
  if (split_every_ > 0 && state_.adds == Material::kNone && output.bricks_cut > 0 && ++ticks_cut_ >= split_every_) {
    ticks_cut_ = 0;
    for (std::size_t n = state_.objects.size(); n-- > 0;) {
      // Without a change there is nothing new to find.
      if (n < watches_.size() && watches_[n] && state_.objects[n].changes(BrickSubscriber::kPieces).isEmpty()) continue;
      const PieceList& list = finderOf(n, piece_options_.crumb_mm3).find();
      if (list.pieces.size() + list.crumbs.size() > 1)
        apply(fmt::format("pieces.split {} {}", n, piece_options_.crumb_mm3));
    }
  }
  // Nobody waits here: a check that a long cut keeps putting off is paid for.
  if (is_check_due_ && sink_ && state_.tick % kCheckEvery == kCheckEvery / 2) {
    sink_->check({state_.hashNow(), state_.last_force}, tick);
    is_check_due_ = false;
  }
  checkState(tick);
}

void Session::finish() noexcept {
  if (is_stroke_) endStroke();
  markAll();
  if (sink_ && state_.tick > 0) sink_->check({state_.hashNow(), state_.last_force}, state_.tick - 1);
}

SessionHeader describe(const Session& session) {
  SessionHeader out;
  StepSettings settings = session.model().settings;
  if (settings.rendering == Rendering::kRigid) settings.response = Response::kPenalty;  // it has no effect there
  visitNumbers(settings, [&](const char* name, double& value) { out.emplace_back(name, fmt::format("{}", value)); });
  const Rigid3& start = session.state().body.pose;
  const Eigen::Quaterniond& q = start.rotation;
  out.emplace_back(
      "start", numbers({start.translation[0], start.translation[1], start.translation[2], q.w(), q.x(), q.y(), q.z()}));
  for (std::size_t n = 0; n < 256; ++n) {
    const Tissue& t = session.model().tissues[n];
    if (n == 0 || t.is_in_table)
      out.emplace_back(fmt::format("tissue.{}", n),
                       numbers({static_cast<double>(t.stiffness), static_cast<double>(t.friction),
                                static_cast<double>(t.inverse_energy)}));
  }
  for (std::size_t n = 0; n < session.model().tools.size(); ++n) {
    const ToolDrive& d = session.model().tools[n].drive;
    out.emplace_back(fmt::format("drive.{}", n),
                     numbers({d.speed, d.stall_load, d.time_constant, d.energy_factor, d.drag_factor}));
  }
  return out;
}

Expected<void> restoreSettings(const SessionLog& log, const std::string& file, Model& model, Rigid3& start) {
  std::string wrong;
  const auto read = [&](const std::string& key, std::span<double> values) {
    if (parse(log.value(key), values)) return true;
    if (wrong.empty()) wrong = key;
    return false;
  };
  model.settings.response = Response::kPenalty;
  model.settings.restitution = 0;  // all there was before logs named it
  visitNumbers(model.settings, [&](const char* name, double& value) {
    const std::string_view key = name;
    if ((key != "response" && key != "restitution") || !log.value(key).empty()) read(name, std::span(&value, 1));
  });
  std::array<double, 7> s{};
  if (read("start", s)) {
    start.translation = Vec3d(s[0], s[1], s[2]);
    start.rotation.w() = s[3];
    start.rotation.x() = s[4];
    start.rotation.y() = s[5];
    start.rotation.z() = s[6];
  }
  std::array<double, 3> rest{};
  read("tissue.0", rest);
  for (std::size_t n = 0; n < 256; ++n) {
    std::array<double, 3> t = rest;
    const std::string key = fmt::format("tissue.{}", n);
    const bool is_in_table = n > 0 && !log.value(key).empty();
    if (is_in_table) read(key, t);
    model.tissues[n] = {static_cast<float>(t[0]), static_cast<float>(t[1]), static_cast<float>(t[2]), is_in_table};
  }
  for (std::size_t n = 0; n < model.tools.size(); ++n) {
    std::array<double, 5> d{};
    if (read(fmt::format("drive.{}", n), d)) model.tools[n].drive = {d[0], d[1], d[2], d[3], d[4]};
  }
  // In range, too: a number that came from a file is a claim.
  const auto require = [&](bool holds, const char* key) {
    if (!holds && wrong.empty()) wrong = key;
  };
  const StepSettings& t = model.settings;
  require(t.most_substeps >= 1 && t.most_substeps <= 1000, "most_substeps");
  require(t.rendering == Rendering::kCoupled || t.rendering == Rendering::kDirect || t.rendering == Rendering::kRigid,
          "rendering");
  require(
      t.response == Response::kPenalty || (t.rendering != Rendering::kRigid &&
                                           (t.response == Response::kConstraint || t.response == Response::kImpulse)),
      "response");
  require(t.restitution >= 0 && t.restitution <= 1, "restitution");
  require(t.coupling.mass_kg > 0 && t.coupling.gyration_mm > 0, "coupling.mass_kg");
  require(t.coupling.stiffness > 0 && t.coupling.turn_stiffness > 0, "coupling.stiffness");
  require(start.translation.allFinite() && std::abs(start.rotation.norm() - 1) < 1e-6, "start");
  if (wrong.empty()) return {};
  return fail({Error::Code::kBadValue, file, "header, " + wrong, fmt::format("\"{}\"", log.value(wrong)), "numbers",
               "the log was written by another version of Kerf"});
}

}  // namespace kerf
