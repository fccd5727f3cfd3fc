#include "ui/app/workbench/export_plan.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <future>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "geometry/formats/mesh_formats.h"
#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/results.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

bool takesFiles(const fs::path& folder) {
  std::error_code failed;
  return fs::is_directory(folder, failed) && ::access(folder.c_str(), W_OK) == 0;
}

bool isWithin(const fs::path& file, const fs::path& folder) {
  std::error_code failed;
  const fs::path way = fs::relative(file, folder, failed);
  return !failed && !way.empty() && *way.begin() != "..";
}

std::string usualEnding(const MeshFormatRow& format) {
  return std::string(format.extensions.substr(0, format.extensions.find(' ')));
}

std::string lowered(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

const MeshFormatRow* writtenFormatOf(const fs::path& file) {
  const MeshFormatRow* const row = formatOfExtension(file.extension().string());
  return row && row->write ? row : nullptr;
}

tl::unexpected<Error> wrongEnding(const fs::path& file) {
  return fail({.code = Error::Code::kBadValue,
               .file = file.string(),
               .found = "the ending \"" + file.extension().string() + "\"",
               .expected = "one of " + writableExtensions()});
}

void addLines(std::vector<ExportFinding>& out, const std::string& text, bool is_warning) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) out.push_back({is_warning, line});
}

// The first existing file that is not in `told`.
std::optional<fs::path> untoldOf(const std::vector<fs::path>& files, const std::vector<fs::path>& told) {
  std::error_code ignored;
  const auto at = std::find_if(files.begin(), files.end(), [&](const fs::path& file) {
    return fs::exists(file, ignored) && std::find(told.begin(), told.end(), file) == told.end();
  });
  return at == files.end() ? std::nullopt : std::optional(*at);
}

}  // namespace

// ---- Panel

void ExportPlan::show(const fs::path& folder) {
  if (!bench_.document->isOpen()) return;
  const bool is_other = generation_ != bench_.document->generation();
  generation_ = bench_.document->generation();
  is_shown_ = true;
  written_.reset();
  error_.clear();
  const std::vector<ExportOffer> all = offers();
  const auto is_there = [&](const ExportOffer& offer) { return offer.choice == choice_; };
  if (is_other || std::none_of(all.begin(), all.end(), is_there)) {
    choice_ = all.front().choice;
    is_chosen_ = false;
    forgetCheck();
  }
  if (named_for_ != bench_.document->source()) is_named_ = false;
  if (!is_named_) suggestFile(suggestedFolder(folder));
  lookForReplaced();
  wants_check_ = !isCurrent();
}

void ExportPlan::hide() {
  is_shown_ = wants_check_ = false;
  wants_write_.reset();
  if (work_ == Work::kCheck) bench_.jobs->cancel();
}

void ExportPlan::update() {
  if (auto shown = showing_.poll(); shown && !*shown) bench_.notices->complain(shown->error());
  if (prepared_ && generation_ != bench_.document->generation()) forgetCheck();  // its meshes are large
  if (!is_shown_) return;
  if (!bench_.document->isOpen() || bench_.imports->isImporting() || generation_ != bench_.document->generation())
    return hide();
  if (bench_.jobs->running() || !std::exchange(wants_check_, false)) return;
  start(Work::kCheck, {});
}

// ---- Choices

std::vector<ExportOffer> ExportPlan::offers() const {
  std::vector<ExportOffer> out;
  if (!bench_.document->isOpen()) return out;
  const LiveScene& scene = bench_.document->scene();
  const bool are_several = scene.pieceCount() > 1;
  const auto isWorkedOn = [](const SceneObject* object) { return !object->isBeside(); };
  const bool is_moved = std::any_of(scene.shown().begin(), scene.shown().end(),
                                    [&](const SceneObject* object) { return isWorkedOn(object) && object->isMoved(); });

  out.push_back({are_several ? "All pieces in one file" : "Cut object in one file", {}});
  if (is_moved) out.push_back({"All pieces at their scan positions", {.is_put_back = true}});
  if (are_several) {
    out.push_back({"One file per piece", {.is_each = true}});
    for (const SceneObject* object : scene.shown())
      if (isWorkedOn(object)) out.push_back({phrase("Only {}", object->name), {.only = {object->id}}});
    ExportChoice chosen;
    for (const SceneObject* object : bench_.pieces->selected())
      if (isWorkedOn(object)) chosen.only.push_back(object->id);
    if (chosen.only.size() > 1) out.push_back({phrase("Only the {} chosen pieces", chosen.only.size()), chosen});
  }
  for (const Neighbour& other : bench_.neighbours->list())
    if (const SceneObject* const object = bench_.neighbours->find(other.name))
      out.push_back({phrase("Neighbour: {}", other.name), {.beside = object->loaded}});
  return out;
}

void ExportPlan::choose(const ExportChoice& choice) {
  is_chosen_ = true;
  if (choice == choice_) return;
  choice_ = choice;
  forgetCheck();
  if (!is_named_) suggestFile(file_.parent_path());
  lookForReplaced();
  if (work_ == Work::kCheck) bench_.jobs->cancel();  // the check of the previous choice
  wants_check_ = is_shown_;
}

std::vector<const MeshFormatRow*> ExportPlan::formats() {
  std::vector<const MeshFormatRow*> out;
  for (const MeshFormatRow& row : meshFormats())
    if (row.write) out.push_back(&row);
  return out;
}

const MeshFormatRow* ExportPlan::format() const { return writtenFormatOf(file_); }

Expected<void> ExportPlan::setFormat(const std::string& name) {
  std::string names;
  for (const MeshFormatRow* row : formats()) {
    names += (names.empty() ? "" : ", ") + lowered(std::string(row->name));
    if (lowered(name) != lowered(std::string(row->name))) continue;
    if (row != format()) file_.replace_extension(usualEnding(*row));
    written_.reset();
    lookForReplaced();
    return {};
  }
  return fail({.code = Error::Code::kBadValue, .found = "\"" + name + "\"", .expected = "one of " + names});
}

Expected<void> ExportPlan::setFile(const fs::path& file) {
  if (!file.has_filename())
    return fail({.code = Error::Code::kBadValue, .file = file.string(), .found = "no name", .expected = "a file"});
  fs::path next = file;
  if (!next.has_extension()) next.replace_extension(file_.has_extension() ? file_.extension() : fs::path(".stl"));
  if (!writtenFormatOf(next)) return wrongEnding(next);
  std::error_code failed;
  file_ = fs::absolute(next, failed);
  if (failed) file_ = next;
  is_named_ = true;
  named_for_ = bench_.document->source();
  written_.reset();
  error_.clear();
  lookForReplaced();
  return {};
}

void ExportPlan::setName(const std::string& name, const fs::path& before) {
  const fs::path ending = writtenFormatOf(before) ? before.extension() : fs::path(".stl");
  const char* const home = std::getenv("HOME");
  fs::path typed = home && name.starts_with("~/") ? fs::path(home) / name.substr(2) : fs::path(name);
  if (!typed.has_filename()) typed /= bench_.document->name() + "-cut";
  if (!writtenFormatOf(typed)) typed += ending;
  file_ = (before.parent_path() / typed).lexically_normal();
  is_named_ = true;
  named_for_ = bench_.document->source();
  written_.reset();
  error_.clear();
  lookForReplaced();
}

// Beside the user's scan, but never in the program's own data folder.
fs::path ExportPlan::suggestedFolder(const fs::path& otherwise) const {
  std::error_code failed;
  const fs::path source = fs::absolute(bench_.document->source(), failed);
  const bool is_users =
      !bench_.document->source().empty() && !failed && !isWithin(source, bench_.options().data_folder);
  if (is_users && takesFiles(source.parent_path())) return source.parent_path();
  if (takesFiles(otherwise)) return otherwise;
  return fs::current_path(failed);
}

void ExportPlan::suggestFile(const fs::path& folder) {
  const std::string ending = format() ? file_.extension().string() : ".stl";
  std::string name = bench_.document->name() + "-cut";
  if (!choice_.only.empty()) {
    if (const SceneObject* const piece = bench_.document->scene().find(choice_.only.front()))
      name = bench_.document->name() + "-" + piece->name;
  } else if (choice_.beside > 0) {
    for (const SceneObject* object : bench_.document->scene().shown())
      if (object->loaded == choice_.beside) name = object->name + "-cut";
  }
  std::replace(name.begin(), name.end(), '/', '-');
  file_ = folder / (name + ending);
}

// Before a check, the scene's object names stand in for the piece names.
void ExportPlan::lookForReplaced() {
  asks_to_replace_ = false;
  replaced_.clear();
  std::vector<fs::path> files{file_};
  if (choice_.is_each) {
    PreparedExport names{.is_each = true};
    for (const SceneObject* object : bench_.document->scene().shown())
      if (!object->isBeside()) names.parts.push_back({.piece = object->name});
    files = prepared_ ? prepared_->filesFor(file_) : names.filesFor(file_);
  }
  std::error_code ignored;
  for (const fs::path& file : files)
    if (fs::exists(file, ignored)) replaced_.push_back(file);
}

// ---- Check result

bool ExportPlan::isCurrent() const { return prepared_ && stamp_ && stamp_ == bench_.results->stampNow(); }

bool ExportPlan::isOutdated() const { return prepared_ && !isCurrent(); }

void ExportPlan::forgetCheck() {
  prepared_.reset();
  stamp_.reset();
  written_.reset();
  wants_write_.reset();
  error_.clear();
}

ExportPlan::Stage ExportPlan::stage() const {
  if (work_ == Work::kCheck || wants_check_) return Stage::kChecking;
  if (work_ == Work::kWrite) return Stage::kWriting;
  if (!prepared_) return error_.empty() ? Stage::kUnchecked : Stage::kRefused;
  if (written_) return Stage::kWritten;
  return prepared_->isReady() ? Stage::kReady : Stage::kDoubtful;
}

std::vector<ExportFinding> ExportPlan::findings() const {
  std::vector<ExportFinding> out;
  if (!prepared_) return out;
  for (const ExportPart& part : prepared_->parts) {
    if (prepared_->parts.size() > 1) out.push_back({false, part.piece + ":"});
    addLines(out, describe(part.report), !part.report.print_ready);
    if (part.is_met) addLines(out, part.verdict(), true);
    if (part.report.print_ready) {
      constexpr double kResin = 1.1;  // g/ml: printing resins have 1.05 to 1.2
      const double ml = 1e-3 * part.report.volume;
      out.push_back({false, phrase("Volume {:.2f} ml, about {:.1f} g of resin", ml, kResin * ml)});
    }
  }
  if (!written_) addLines(out, prepared_->summary(), false);  // the text of the written export has it too
  return out;
}

void ExportPlan::check() {
  wants_write_.reset();
  wants_check_ = true;
}

// ---- The job

// Writes checked meshes as they are; else waits for a copy of the scene, makes meshes and checks them.
void ExportPlan::start(Work work, Permission permission) {
  if (bench_.jobs->isBusy() || bench_.saw->isBusy()) return;
  if (work == Work::kWrite && !bench_.results->mayExportTo(file_)) return;
  const LiveRun* const run = bench_.document->run();
  const bool is_new = work == Work::kCheck || !isCurrent();
  const auto given = is_new ? bench_.results->orderScene() : nullptr;
  const auto kept = is_new ? nullptr : prepared_;
  const bool writes = work == Work::kWrite;

  const auto job_of = [run, given, kept, writes, permission, choice = choice_, file = file_, told = replaced_,
                       stamp = stamp_](const Progress& progress) -> Expected<Outcome> {
    Outcome out{.choice = choice, .file = file, .prepared = kept, .stamp = stamp};
    if (!out.prepared) {
      KERF_TRY(scene, waitForScene(*given, progress));
      KERF_TRY(prepared, prepareExport(*run, scene, choice, progress));
      out.prepared = std::make_shared<const PreparedExport>(std::move(prepared));
      if (!out.prepared->isReady() && !permission.may_be_doubtful) return out;
    }
    if (!writes) return out;
    if (!permission.may_replace) out.untold = untoldOf(out.prepared->filesFor(file), told);
    if (out.untold) return out;
    KERF_TRY(written, writeExport(*out.prepared, *run, file));
    out.written = std::move(written);
    return out;
  };
  const auto take_it = [this, is_new, writes](Expected<Outcome> outcome) { take(std::move(outcome), is_new, writes); };
  bench_.jobs->start<Outcome>(writes ? Jobs::Kind::kWrites : Jobs::Kind::kReads,
                              writes ? phrase("exporting {}", file_.filename().string()) : "checking the export",
                              job_of, take_it);
  work_ = work;
}

void ExportPlan::take(Expected<Outcome> outcome, bool is_new, bool was_written) {
  work_ = Work::kNone;
  if (outcome && outcome->choice == choice_) splitTouching(*outcome, was_written);
  // If another check follows, the pending write waits for it.
  const auto wanted = wants_check_ ? std::nullopt : std::exchange(wants_write_, std::nullopt);
  if (!outcome) {
    const bool is_cancelled = outcome.error().code == Error::Code::kCancelled;
    if (is_new) prepared_.reset();
    error_ = is_cancelled ? "" : outcome.error().message();
    if (was_written || !is_cancelled) bench_.notices->complain(outcome.error());
    return;
  }
  const std::optional<CutStamp> stamp = is_new ? bench_.results->handedOver() : outcome->stamp;
  const bool is_still_chosen = outcome->choice == choice_;
  if (is_still_chosen) {
    prepared_ = outcome->prepared;
    stamp_ = stamp;
    written_.reset();
  }

  if (outcome->written) {
    if (outcome->choice.isWhole()) bench_.results->markExported(stamp);
    // The panel reports it, unless a choice changed meanwhile.
    const bool is_as_decided = is_still_chosen && outcome->file == file_;
    if (!is_shown_ || !is_as_decided) bench_.notices->say(outcome->written->text);
    if (is_as_decided) written_ = std::move(outcome->written);
    return lookForReplaced();
  }
  if (!is_still_chosen) return;  // outdated
  if (outcome->untold) return askToReplace(*outcome->untold);
  if (wanted && (prepared_->isReady() || wanted->may_be_doubtful)) return write(*wanted);
  if (!was_written && !wanted) return;
  const Error doubtful{.code = Error::Code::kGeometry,
                       .file = file_.string(),
                       .found = "not written: the mesh is not ready to print",
                       .expected = "a printable mesh",
                       .hint = "read the print check, then export again to write the mesh anyway"};
  error_ = doubtful.message();
  bench_.notices->complain(doubtful);
}

// One file of pieces that touch is no printable solid: unless the user chose it, each gets its own.
void ExportPlan::splitTouching(const Outcome& outcome, bool was_written) {
  const auto touches = [](const ExportPart& part) { return part.touching > 0; };
  const auto& parts = outcome.prepared->parts;
  if (is_chosen_ || outcome.written || std::none_of(parts.begin(), parts.end(), touches)) return;
  const auto waiting = was_written ? std::optional(Permission{}) : wants_write_;
  choice_.is_each = true;
  forgetCheck();
  lookForReplaced();
  wants_write_ = waiting;
  wants_check_ = true;
  bench_.notices->say(shownText("Pieces touch along a cut without kerf: one file per piece"));
}

void ExportPlan::write(Permission permission) {
  error_.clear();
  if (work_ == Work::kCheck || wants_check_) {
    wants_write_ = permission;
    return;
  }
  if (!format()) {
    const Error wrong = wrongEnding(file_).value();
    error_ = wrong.message();
    return bench_.notices->complain(wrong);
  }
  const std::vector<fs::path> told = asks_to_replace_ ? replaced_ : std::vector<fs::path>{};
  lookForReplaced();
  if (!permission.may_replace && untoldOf(replaced_, told)) {
    asks_to_replace_ = true;
    return;
  }
  // Writes doubtful meshes if the user has seen the warning and repeats the request.
  permission.may_be_doubtful |= stage() == Stage::kDoubtful && !isOutdated();
  start(Work::kWrite, permission);
}

// A piece that came off meanwhile has a file of its own.
void ExportPlan::askToReplace(const fs::path& untold) {
  lookForReplaced();
  asks_to_replace_ = true;
  const Error there{.code = Error::Code::kBadValue,
                    .file = untold.string(),
                    .found = "not written: this file exists and was not in the list to replace",
                    .expected = "another name",
                    .hint = "export again to replace this file too"};
  error_ = there.message();
  bench_.notices->complain(there);
}

Expected<void> ExportPlan::showInFolder() {
  if (!written_) return fail({.code = Error::Code::kEmpty, .found = "no exported file", .hint = "export.write first"});
  return showing_.begin(written_->files);
}

// ---- For scripts

std::string exportState(const ExportPlan& plan) {
  static constexpr const char* kStages[] = {"unchecked", "checking", "refused", "ready",
                                            "doubtful",  "writing",  "written"};
  nlohmann::json j{{"file", plan.file().string()},
                   {"stage", kStages[static_cast<std::size_t>(plan.stage())]},
                   {"is_outdated", plan.isOutdated()},
                   {"asks_to_replace", plan.asksToReplace()}};
  if (const MeshFormatRow* const format = plan.format()) j["format"] = format->name;
  for (const ExportOffer& offer : plan.offers()) {
    j["offers"].push_back(offer.label);
    if (offer.choice == plan.choice()) j["chosen"] = offer.label;
  }
  for (const ExportFinding& finding : plan.findings()) j["findings"].push_back(finding.text);
  if (!plan.error().empty()) j["error"] = plan.error();
  if (plan.written())
    for (const fs::path& file : plan.written()->files) j["written"].push_back(file.string());
  return j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace kerf
