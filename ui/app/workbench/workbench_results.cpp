// Exports and the moment of their snapshot. The rest of the workbench: workbench.cpp.
#include <algorithm>
#include <chrono>
#include <future>
#include <memory>
#include <utility>

#include "geometry/formats/mesh_formats.h"
#include "ui/app/base/language.h"
#include "ui/app/session/exporting.h"
#include "ui/app/workbench/export_plan.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

namespace fs = std::filesystem;

namespace {

Expected<WrittenExport> exportWhenGiven(const LiveRun& run, std::future<SceneView>& given, const fs::path& file,
                                        const ExportChoice& choice, const Progress& progress) {
  KERF_TRY(scene, waitForScene(given, progress));
  KERF_TRY(prepared, prepareExport(run, scene, choice, progress));
  return writeExport(prepared, run, file);
}

}  // namespace

Expected<SceneCopy> waitForScene(std::future<SceneView>& given, const Progress& progress) {
  constexpr auto kPoll = std::chrono::milliseconds(5);
  while (given.wait_for(kPoll) != std::future_status::ready)
    if (!report(progress, 0, "waiting for the last stroke")) return cancelledBeforeWriting();
  return LiveRun::copyOf(given.get());
}

bool Workbench::mayExportTo(const fs::path& file) {
  const auto refuse = [&](const Error& error) {
    complain(error);
    return false;
  };
  if (!run_) return refuse({.code = Error::Code::kEmpty, .found = "nothing is open", .hint = "open a scan first"});
  if (const auto possible = canWriteMesh(file); !possible) return refuse(possible.error());

  std::error_code ignored;
  const auto isSource = [&](const fs::path& source) { return fs::equivalent(file, source, ignored); };
  if (isSource(source_) || std::any_of(sources_beside_.begin(), sources_beside_.end(), isSource))
    return refuse({.code = Error::Code::kBadValue,
                   .file = file.string(),
                   .found = "the file that was opened",
                   .expected = "another one: a scan is never written over",
                   .hint = "another name"});
  return true;
}

// For a job on a copy: cutting may go on. The caller starts the job in the same frame.
std::shared_ptr<std::future<SceneView>> Workbench::orderScene() {
  release();
  namePieces();
  handed_over_.reset();
  handover_.emplace();
  handover_->sent = sent_;
  return std::make_shared<std::future<SceneView>>(handover_->scene.get_future());
}

void Workbench::exportTo(const fs::path& file, const ExportChoice& choice) {
  if (isBusy() || !mayExportTo(file) || isSawing()) return;
  job_writes_ = true;
  const auto scene = orderScene();
  const LiveRun* const run = run_.get();
  auto job = std::make_unique<Job<WrittenExport>>(phrase("exporting {}", file.filename().string()),
                                                  [run, scene, file, choice](const Progress& progress) {
                                                    return exportWhenGiven(*run, *scene, file, choice, progress);
                                                  });
  when_over_ = [this, job = job.get(), choice] {
    auto written = job->take();
    if (!written) return complain(written.error());
    if (choice.isWhole()) exported_ = handed_over_;
    say(std::move(written->text));
  };
  job_ = std::move(job);
}

// None: commands are still under way.
std::optional<CutStamp> Workbench::stampNow() const {
  if (!run_ || stroke_ || undos_left_ != 0 || wish_ || answered() < sent_) return {};
  return cutStampOf(generation_, report_, scene_);
}

bool Workbench::hasUnexportedCut() const {
  if (!run_ || isWriting()) return false;
  const bool is_cut = has_unexported_before_ || stroke_ || timeline_.older() + stepsDone() > 0;
  return is_cut && !(exported_ && exported_ == stampNow());
}

// All commands are done and counted, and the meshers have their edits.
bool Workbench::isSettled() {
  constexpr std::uint64_t kTicks = 3;  // after a command: the next tick counts its change
  const HapticCounts& c = report_.counts;
  const bool is_done = undos_left_ == 0 && answered() >= sent_ && report_.output.touching == 0;
  if (is_done && !handover_->done_at) handover_->done_at = report_.tick;
  const bool is_counted = handover_->done_at && report_.tick >= *handover_->done_at + kTicks;
  return is_counted && c.edits_waiting == 0 && run_->editsDone() >= c.edits_pushed;
}

// Hands the scene to the export job once the last stroke is meshed, or after a second if cutting goes on.
void Workbench::handOverScene() {
  constexpr auto kMost = std::chrono::seconds(1);
  if (!handover_) return;
  if (!run_ || !job_) return handover_.reset();
  if (undos_left_ != 0 || wish_) handover_->sent = sent_;
  if (undos_left_ != 0 || wish_ || answered() < handover_->sent) {
    handover_->began = std::chrono::steady_clock::now();
    return;
  }
  if (!isSettled() && std::chrono::steady_clock::now() < handover_->began + kMost) return;
  auto view = run_->viewScene();
  if (!view) return;
  const HapticCounts& c = report_.counts;
  const bool is_meshed = c.edits_waiting == 0 && run_->editsDone() >= c.edits_pushed;
  handed_over_ = is_meshed ? stampNow() : std::nullopt;
  handover_->scene.set_value(std::move(*view));
  handover_.reset();
}

}  // namespace kerf
