#include "sim/session.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace kerf {
namespace {

constexpr std::size_t kReserve = 4096;  // bricks

/// Numbers by name, for writing and for reading alike: one list, so that neither forgets one.
template <class Visit>
void visitNumbers(StepSettings& s, const Visit& visit) {
  CouplingSettings& c = s.coupling;
  visit("coupling.stiffness", c.stiffness), visit("coupling.damping", c.damping);
  visit("coupling.turn_stiffness", c.turn_stiffness), visit("coupling.turn_damping", c.turn_damping);
  visit("coupling.mass_kg", c.mass_kg), visit("coupling.gyration_mm", c.gyration_mm);
  visit("coupling.filter_hz", c.filter_hz), visit("coupling.force_limit", c.force_limit);
  visit("coupling.torque_limit", c.torque_limit), visit("coupling.force_rate", c.force_rate);
  visit("coupling.torque_rate", c.torque_rate), visit("ramp_s", s.ramp_s);
  double rendering = static_cast<double>(s.rendering), geometry = s.geometry_only, substeps = s.most_substeps;
  double response = static_cast<double>(s.response);
  visit("rendering", rendering), visit("geometry_only", geometry), visit("most_substeps", substeps);
  visit("response", response), visit("restitution", s.restitution);
  s.response = static_cast<Response>(static_cast<int>(response));
  s.rendering = static_cast<Rendering>(static_cast<int>(rendering));
  s.geometry_only = geometry != 0, s.most_substeps = static_cast<int>(substeps);
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

Session::Session(Model model, std::vector<std::shared_ptr<const BakedObject>> objects, const Rigid3& start,
                 SessionSink* sink)
    : model_(std::move(model)), history_(objects.size()), sink_(sink) {
  for (auto& object : objects) state_.objects.emplace_back(std::move(object), kReserve);
  state_.place(start);
}

bool Session::apply(std::string_view command) {
  constexpr std::string_view kSelect = "tool.select ";
  bool is_done = false;
  if (command == "undo") {
    bool is_possible = !history_.empty() && history_.front().undoable() > 0;
    for (std::size_t n = 0; n < history_.size(); ++n) is_possible |= history_[n].hasChanges(state_.objects[n]);
    if (is_possible) {
      if (is_stroke_) endStroke();
      markAll();
      is_done = true;
      for (std::size_t n = 0; n < history_.size(); ++n) is_done &= history_[n].undo(state_.objects[n]);
    }
  } else if (command == "redo") {
    // What was cut since the undo ends what could be redone.
    bool is_possible = !is_stroke_ && !history_.empty() && history_.front().redoable() > 0;
    for (std::size_t n = 0; n < history_.size(); ++n) is_possible &= !history_[n].hasChanges(state_.objects[n]);
    if (is_possible) {
      is_done = true;
      for (std::size_t n = 0; n < history_.size(); ++n) is_done &= history_[n].redo(state_.objects[n]);
    }
  } else if (command == "latch.clear") {
    state_.clearLatch();
    is_done = true;
  } else if (command.starts_with(kSelect)) {
    std::size_t index = 0;
    const std::string_view number = command.substr(kSelect.size());
    const auto [end, failed] = std::from_chars(number.data(), number.data() + number.size(), index);
    if (failed == std::errc{} && end == number.data() + number.size() && index < model_.tools.size()) {
      state_.selectTool(index);
      is_done = true;
    }
  }
  if (is_done && sink_) sink_->command(command, state_.tick);
  return is_done;
}

bool Session::markAll() {
  bool has_changes = false;
  for (std::size_t n = 0; n < history_.size(); ++n) has_changes |= history_[n].hasChanges(state_.objects[n]);
  if (has_changes)
    for (std::size_t n = 0; n < history_.size(); ++n) history_[n].mark(state_.objects[n]);
  return has_changes;
}

// The tool runs down after this and may still cut: that belongs to the stroke, so its step is made later, by markAll().
void Session::endStroke() {
  is_stroke_ = false;
  if (sink_) sink_->mark(StrokeMark::kEnd, state_.tick);
}

void Session::tick(const DeviceSample& sample, StepOutput& output) {
  const bool presses = sample.isUsable() && sample.pedal > 0;
  if (presses && !is_stroke_) {
    is_stroke_ = true;
    markAll();
    if (sink_) sink_->mark(StrokeMark::kBegin, state_.tick);
  } else if (!presses && is_stroke_) {
    endStroke();
  }
  const std::uint64_t tick = state_.tick;
  if (sink_) sink_->sample(sample, tick);
  step(model_, state_, sample, output);
  for (CutObject& object : state_.objects)
    if (object.freeBricks() < kReserve / 2) object.reserve(kReserve);
  if (sink_ && state_.tick % kCheckEvery == 0) sink_->check({state_.hash(), state_.last_force}, tick);
}

void Session::finish() {
  if (is_stroke_) endStroke();
  markAll();
  if (sink_ && state_.tick > 0) sink_->check({state_.hash(), state_.last_force}, state_.tick - 1);
}

SessionHeader describe(const Session& session) {
  SessionHeader out;
  StepSettings settings = session.model().settings;
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
  model.settings.response = Response::kPenalty, model.settings.restitution = 0;  // all there was before logs named it
  visitNumbers(model.settings, [&](const char* name, double& value) {
    const std::string_view key = name;
    if ((key != "response" && key != "restitution") || !log.value(key).empty()) read(name, std::span(&value, 1));
  });
  std::array<double, 7> s{};
  if (read("start", s)) {
    start.translation = Vec3d(s[0], s[1], s[2]);
    start.rotation.w() = s[3], start.rotation.x() = s[4], start.rotation.y() = s[5], start.rotation.z() = s[6];
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
