#include "sim/run/report/log_player.h"

#include <fmt/format.h>

#include <optional>
#include <set>
#include <utility>

#include "geometry/base/hash.h"
#include "geometry/tool/tool_file.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_output.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

// Checks the inputs named in the log's header.
class HeaderCheck {
 public:
  HeaderCheck(const SessionLog& log, fs::path file) : log_(log), file_(std::move(file)) {}
  Expected<void> wants(const std::string& key, const std::string& expected) const {
    if (log_.value(key) == expected) return {};
    return refuse(key, std::string(log_.value(key)), expected);
  }
  tl::unexpected<Error> refuse(const std::string& key, std::string found, std::string expected) const {
    return fail({.code = Error::Code::kBadValue,
                 .file = file_.string(),
                 .place = "header, " + key,
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = "the log belongs to another run"});
  }

 private:
  const SessionLog& log_;
  fs::path file_;
};

// The tools of a log's strokes.
std::set<std::size_t> toolsOfStrokes(const SessionLog& log) {
  std::set<std::size_t> out;
  std::size_t in_hand = 0;
  bool is_in_stroke = false;
  for (const SessionEvent& event : log.events) {
    if (const auto* const mark = std::get_if<StrokeMark>(&event.what)) is_in_stroke = *mark == StrokeMark::kBegin;
    const auto* const text = std::get_if<SessionCommand>(&event.what);
    const auto command = text ? parseCommand(text->text) : fail({});
    if (const auto* const select = command ? std::get_if<SelectTool>(&*command) : nullptr) in_hand = select->tool;
    if (is_in_stroke) out.insert(in_hand);
  }
  return out;
}

Expected<Tool> readStoredTool(const fs::path& file, const std::string& sha256) {
  KERF_CHECK(requireSha256(file, sha256, "cut again"));
  return readTool(file);
}

// Reads the tools of a run from its copies and compares them with the log. Replaces a damaged tool that cut nothing by
// another one under its id.
Expected<void> readToolsOfLog(const fs::path& run_folder, const RunManifest& manifest, const HeaderCheck& header,
                              Recording& out) {
  const SessionLog& log = out.log;
  std::vector<RunManifest::ToolFile> files = manifest.tools;
  if (manifest.mode != kModeSession) files = {{manifest.tool_id, kRunToolCopy, manifest.tool_sha256}};

  std::vector<std::string> in_log;
  for (const auto& [key, value] : log.header)
    if (key == "tool_sha256") in_log.push_back(value);
  if (in_log.size() != files.size())
    return header.refuse("tool_sha256", fmt::format("{} tools", in_log.size()),
                         fmt::format("{} of them", files.size()));

  const std::set<std::size_t> used = toolsOfStrokes(log);
  std::optional<Error> damage;
  std::size_t whole = files.size();
  for (std::size_t n = 0; n < files.size(); ++n) {
    if (in_log[n] != files[n].sha256) return header.refuse("tool_sha256", in_log[n], files[n].sha256);
    auto tool = readStoredTool(run_folder / files[n].file, files[n].sha256);
    if (!tool && used.contains(n)) return fail(tool.error());
    if (tool) whole = n;
    if (!tool) damage = tool.error();
    if (!tool) out.damaged_tools.insert(n);
    out.tools.push_back(tool ? std::move(*tool) : Tool());
  }
  if (damage && whole == files.size()) return fail(*damage);
  for (const std::size_t n : out.damaged_tools) {
    out.tools[n] = out.tools[whole];
    out.tools[n].id = files[n].id;
  }
  return {};
}

}  // namespace

// ---- Recorded inputs

Expected<Recording> loadRecording(const fs::path& run_folder, const RunManifest& manifest, const Progress& progress) {
  if (manifest.mode == kModeGeometry)
    return fail({.code = Error::Code::kUnsupported,
                 .file = run_folder.string(),
                 .place = "mode " + manifest.mode,
                 .found = "no session to replay",
                 .expected = "a run cut against resistance",
                 .hint = "kerf cut --hand"});
  Recording out;
  out.manifest = manifest;
  KERF_TRY(case_folder, caseOfRun(run_folder));
  KERF_TRY(beside, casesBesideRun(run_folder));
  out.cases = std::move(beside);
  if (!report(progress, 0, "loading the case")) return fail({.code = Error::Code::kCancelled, .found = "cancelled"});

  // Reads the log and checks that it belongs to this run.
  out.log_file = run_folder / kRunLog;
  KERF_TRY(log, readSessionLog(out.log_file));
  out.log = std::move(log);
  const HeaderCheck header(out.log, out.log_file);
  KERF_CHECK(header.wants("case_id", manifest.case_id));
  for (std::size_t n = 1; n <= out.cases.size(); ++n)
    KERF_CHECK(header.wants(neighbourKey(n), manifest.beside[n - 1].case_id));
  KERF_CHECK(header.wants(neighbourKey(out.cases.size() + 1), ""));
  KERF_CHECK(readToolsOfLog(run_folder, manifest, header, out));

  // Loads the recorded cases and tools.
  out.cases.insert(out.cases.begin(), case_folder);
  KERF_TRY(added, readBeginMaterials(run_folder, manifest));
  for (std::size_t n = 0; n < out.cases.size(); ++n) {
    KERF_TRY(begin, readRunBegin(run_folder, manifest, n));
    KERF_TRY(object, loadObject(out.cases[n], begin ? &*begin : nullptr, n == 0 ? &added : nullptr));
    out.objects.push_back(std::move(object));
    if (n == 0) out.begin = std::move(begin);
  }
  KERF_TRY(model, makeModel(out.tools, {}, widestBand(out.objects)));
  out.model = std::move(model);
  return out;
}

void compareEnd(const SessionLog& log, const RunManifest& manifest, double until_s, Replay& out) {
  const double held_s = static_cast<double>(log.samples.size()) * kTick;
  const bool is_at_end = out.first_tick + out.ticks == log.samples.size() && held_s < until_s;
  if (!is_at_end || out.state_hash == manifest.state_hash) return;

  const std::string other = "the final state differs from the one in run.toml, " + manifest.state_hash;
  if (log.is_closed && !log.damage) {
    out.is_same = false;
    out.note = other;
    return;
  }
  out.is_whole = false;
  out.note += fmt::format("; it holds {:.3f} of {:.3f} s: {}", held_s, manifest.duration_s, other);
}

bool standsAtItsTick(const SessionLog& log, std::size_t event) {
  const std::size_t before = log.events[event].samples_before;
  return before > 0 && log.samples[before - 1].tick == log.events[event].tick;
}

// ---- Playing

LogPlayer::LogPlayer(const SessionLog& log, const std::string& file, const Model& model, const Rigid3& place,
                     const LoadedObjects& objects, Start start)
    : log_(log), file_(file), event_(start.event), sample_(start.sample) {
  if (start.state)
    session_.emplace(std::move(*start.state), model, objects, nullptr, start.rest);
  else
    session_.emplace(model, objects, place);
  out_.first_tick = sample_ > 0 ? log.samples[sample_ - 1].tick + 1 : 0;
  out_.checks = start.is_checked ? 1 : 0;
  noteHowTheLogEnds();
}

void LogPlayer::noteHowTheLogEnds() {
  if (log_.damage)
    out_.note = (log_.damage->kind == LogDamage::Kind::kCutShort ? "the log was cut off: " : "the log is damaged: ") +
                log_.damage->what;
  else if (!log_.is_closed)
    out_.note = "the log was cut off between two records: its session did not end cleanly";
}

Expected<void> LogPlayer::handleEvents() {
  for (; event_ < log_.events.size() && log_.events[event_].samples_before <= sample_; ++event_)
    KERF_CHECK(handle(log_.events[event_]));
  return {};
}

Expected<void> LogPlayer::tick(StepOutput& output) {
  KERF_CHECK(handleEvents());
  session_->tick(log_.samples[sample_].sample, output);
  ticks_without_bricks_ += (output.status & (kStepBricksRanOut | kStepNearRanOut)) != 0;
  ++out_.ticks;
  ++sample_;
  return {};
}

void LogPlayer::compareChecks() {
  for (std::size_t n = event_; n < log_.events.size() && log_.events[n].samples_before <= sample_; ++n)
    if (const auto* check = std::get_if<StateCheck>(&log_.events[n].what)) compare(*check, log_.events[n].tick);
}

Expected<void> LogPlayer::handle(const SessionEvent& e) {
  if (const auto* command = std::get_if<SessionCommand>(&e.what)) return apply(*command, e.tick);
  if (const auto* check = std::get_if<StateCheck>(&e.what))
    compare(*check, e.tick);
  else if (const auto* snapshot = std::get_if<SessionSnapshot>(&e.what))
    return compare(*snapshot, e.tick);
  else if (const auto* gap = std::get_if<SessionGap>(&e.what))
    out_.note = fmt::format("{} samples are missing at tick {}: the rest cannot be the same", gap->lost, e.tick);
  return {};
}

Expected<void> LogPlayer::apply(const SessionCommand& command, std::uint64_t tick) {
  const Expected<Command> parsed = parseCommand(command.text);
  if (!parsed)
    return fail({.code = parsed.error().code,
                 .file = file_,
                 .place = fmt::format("tick {}, command", tick),
                 .found = parsed.error().found,
                 .expected = parsed.error().expected,
                 .hint = "the log was written by another version of Kerf"});
  if (!session_->apply(*parsed))
    return fail({.code = Error::Code::kBadValue,
                 .file = file_,
                 .place = fmt::format("tick {}", tick),
                 .found = "command \"" + command.text + "\", not possible there",
                 .expected = "a command of the recorded session",
                 .hint = "the log fits another case or version"});
  ++out_.commands;
  return {};
}

void LogPlayer::compare(const StateCheck& check, std::uint64_t tick) {
  const Wrench& f = session_->state().last_force;
  require(check.state_hash == session_->hashNow() && check.force.force == f.force && check.force.torque == f.torque,
          tick);
}

Expected<void> LogPlayer::compare(const SessionSnapshot& snapshot, std::uint64_t tick) {
  if (!standsAtItsTick(log_, event_)) return {};
  KERF_TRY(bytes, unpackSnapshot(snapshot));
  const std::vector<std::byte> now = session_->snapshot();
  if (isStateOfThisVersion(bytes)) {
    require(now == bytes, tick);
    ++out_.snapshots;
  } else if (!std::exchange(has_other_snapshots_, true)) {
    note("snapshots of another version of Kerf were not compared");
  }
  return {};
}

void LogPlayer::require(bool is_same, std::uint64_t tick) {
  ++out_.checks;
  if (is_same || !out_.is_same) return;
  out_.is_same = false;
  out_.differs_at = tick;
}

Replay LogPlayer::found() const {
  Replay out = out_;
  const auto note = [&](const std::string& more) { out.note += (out.note.empty() ? "" : "; ") + more; };
  if (ticks_without_bricks_ > 0)
    note(fmt::format("{} ticks ran out of reserved bricks: they may have cut less than those recorded",
                     ticks_without_bricks_));
  out.state_hash = fmt::format("{:016x}", session_->hash());
  out.objects = session_->state().objects.size();
  for (const CutObject& object : session_->state().objects)
    for (std::size_t m = 0; m < object.removed_mm3.size(); ++m)
      out.removed_mm3 += object.removed_before_mm3[m] + object.removed_mm3[m];
  return out;
}

}  // namespace kerf::internal
