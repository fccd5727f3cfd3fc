#include "ui/app/workbench/results.h"

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

#include "geometry/formats/mesh_formats.h"
#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

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

void Results::opened(Opening /*how*/) {
  exported_.reset();
  has_unexported_before_ = false;
}

bool Results::mayExportTo(const fs::path& file) {
  const Document& document = *bench_.document;
  const auto refuse = [&](const Error& error) {
    bench_.notices->complain(error);
    return false;
  };
  if (!document.isOpen())
    return refuse({.code = Error::Code::kEmpty, .found = "nothing is open", .hint = "open a scan first"});
  if (const auto possible = canWriteMesh(file); !possible) return refuse(possible.error());

  std::error_code ignored;
  const auto isSource = [&](const fs::path& source) { return fs::equivalent(file, source, ignored); };
  const std::vector<fs::path>& beside = document.sourcesBeside();
  if (isSource(document.source()) || std::any_of(beside.begin(), beside.end(), isSource))
    return refuse({.code = Error::Code::kBadValue,
                   .file = file.string(),
                   .found = "the opened file",
                   .expected = "another file: Kerf never overwrites a scan",
                   .hint = "another name"});
  return true;
}

std::shared_ptr<std::future<SceneView>> Results::orderScene() {
  bench_.strokes->release();
  bench_.pieces->passNames();
  handed_over_.reset();
  handover_.emplace();
  handover_->sent = bench_.document->sent();
  return std::make_shared<std::future<SceneView>>(handover_->scene.get_future());
}

void Results::exportTo(const fs::path& file, const ExportChoice& choice) {
  if (bench_.jobs->isBusy() || !mayExportTo(file) || bench_.saw->isBusy()) return;
  const auto scene = orderScene();
  const LiveRun* const run = bench_.document->run();
  const auto work = [run, scene, file, choice](const Progress& progress) {
    return exportWhenGiven(*run, *scene, file, choice, progress);
  };
  const auto take = [this, choice](Expected<WrittenExport> written) {
    if (!written) return bench_.notices->complain(written.error());
    if (choice.isWhole()) exported_ = handed_over_;
    bench_.notices->say(std::move(written->text));
  };
  bench_.jobs->start<WrittenExport>(Jobs::Kind::kWrites, phrase("exporting {}", file.filename().string()), work, take);
}

std::optional<CutStamp> Results::stampNow() const {
  const Document& document = *bench_.document;
  if (!document.isOpen() || bench_.strokes->isPressed() || bench_.steps->isMoving() || !document.isAnswered())
    return {};
  return cutStampOf(document.generation(), document.report(), document.scene());
}

bool Results::hasUnexportedCut() const {
  if (!bench_.document->isOpen() || bench_.jobs->isWriting()) return false;
  const Steps& steps = *bench_.steps;
  const bool is_cut =
      has_unexported_before_ || bench_.strokes->isPressed() || steps.timeline().older() + steps.done() > 0;
  return is_cut && !(exported_ && exported_ == stampNow());
}

// All commands are done and counted, and the meshers have their edits.
bool Results::isSettled() {
  constexpr std::uint64_t kTicks = 3;  // after a command: the next tick counts its change
  const Document& document = *bench_.document;
  const HapticReport& report = document.report();
  const bool is_done = bench_.steps->undosLeft() == 0 && document.isAnswered() && report.output.touching == 0;
  if (is_done && !handover_->done_at) handover_->done_at = report.tick;
  const bool is_counted = handover_->done_at && report.tick >= *handover_->done_at + kTicks;
  return is_counted && report.counts.edits_waiting == 0 && document.run()->editsDone() >= report.counts.edits_pushed;
}

void Results::update() {
  constexpr auto kMost = std::chrono::seconds(1);
  if (!handover_) return;
  Document& document = *bench_.document;
  if (!document.isOpen() || !bench_.jobs->running()) return handover_.reset();
  if (bench_.steps->isMoving()) handover_->sent = document.sent();
  if (bench_.steps->isMoving() || document.answered() < handover_->sent) {
    handover_->began = std::chrono::steady_clock::now();
    return;
  }
  if (!isSettled() && std::chrono::steady_clock::now() < handover_->began + kMost) return;
  auto view = document.run()->viewScene();
  if (!view) return;
  const HapticCounts& c = document.report().counts;
  const bool is_meshed = c.edits_waiting == 0 && document.run()->editsDone() >= c.edits_pushed;
  handed_over_ = is_meshed ? stampNow() : std::nullopt;
  handover_->scene.set_value(std::move(*view));
  handover_.reset();
}

}  // namespace kerf
