// Watching an ended session. The rest of the workbench: workbench.cpp.
#include <fmt/format.h>

#include <memory>
#include <utility>

#include "geometry/case/case_bundle.h"
#include "sim/run/session/watched_run.h"
#include "ui/app/base/language.h"
#include "ui/app/import/import_set.h"
#include "ui/app/view/tissue_display.h"
#include "ui/app/view/upright.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

namespace fs = std::filesystem;

namespace {

struct Watched {
  std::unique_ptr<WatchedRun> run;
  OcclusalSide occlusal;
};

Expected<Watched> openToWatch(const fs::path& run_folder, const Progress& progress) {
  WatchOptions options;
  options.is_looked_at = true;
  Watched out;
  KERF_TRY(run, WatchedRun::open(run_folder, std::move(options), progress));
  out.run = std::move(run);
  KERF_TRY(solid, readCaseSolid(out.run->caseFolder()));
  out.occlusal = occlusalSideOf(solid);
  return out;
}

}  // namespace

std::size_t Workbench::toolCount() const {
  if (watched_) return watched_->tools().size();
  return run_ ? run_->tools().size() : 0;
}

const Tool& Workbench::tool(std::size_t n) const { return watched_ ? watched_->tools()[n] : run_->tools()[n].tool; }

void Workbench::watch(const fs::path& run_folder) {
  if (isBusy()) return;
  asked_run_.reset();
  auto job = std::make_unique<Job<Watched>>(
      phrase("opening {} to watch", run_folder.filename().string()),
      [run_folder](const Progress& progress) { return openToWatch(run_folder, progress); });
  job_writes_ = false;
  when_over_ = [this, job = job.get()] {
    auto loaded = job->take();
    if (!loaded) return complain(loaded.error());
    if (!run_) return showWatched(std::move(loaded->run), loaded->occlusal);

    // Writes the previous session only once its replacement is loaded.
    const auto next = std::make_shared<Watched>(std::move(*loaded));
    close();
    const auto closing = std::exchange(when_over_, {});
    when_over_ = [this, closing, next] {
      closing();
      showWatched(std::move(next->run), next->occlusal);
    };
  };
  job_ = std::move(job);
}

void Workbench::showWatched(std::unique_ptr<WatchedRun> run, const OcclusalSide& occlusal) {
  putImportAway();
  tissues_->closing();
  watched_ = std::move(run);
  structures_ = watched_->structures();
  tissues_->opened(tissueSourceOf(*watched_), materials_);
  name_ = fs::path(watched_->manifest().case_path).stem().string();
  source_ = watched_->folder();
  occlusal_ = occlusal;
  told_sides.reset();
  report_ = {};
  times_ = {};
  timeline_.clear();
  trace_.clear();
  fresh_.clear();
  scene_.clear();
  scene_.setLabels(watched_->labels());
  chosen_.reset();
  moving_.clear();
  section.reset();
  measure.clear();
  tool_ = 0;
  removed_mm3_ = 0;
  has_told_of_verdict_ = has_told_of_pulp_ = has_told_of_bone_ = has_told_of_dead_bone_ = false;
  keeps_view_ = false;
  ++generation_;
  remember(source_);
}

void Workbench::takeWatched() {
  if (watched_->update()) {
    const WatchMoment& now = watched_->moment();
    report_ = now.report;
    tool_ = now.tool;
    removed_mm3_ = watched_->removedBefore();
    for (std::size_t n = 0; n < report_.object_count; ++n) removed_mm3_ += report_.objects[n].removed_mm3;
    addToTrace();
    warnOfHeat();
    if (now.verdict && !std::exchange(has_told_of_verdict_, true))
      notices_.push_back({!now.verdict->is_same, "replayed: " + now.verdict->text});
  }
  const auto chunks = watched_->takeChunks();
  scene_.update(chunks, report_);
  fresh_.insert(fresh_.end(), chunks.begin(), chunks.end());
}

bool Workbench::isPlaying() const {
  return watched_ && (watched_->moment().is_playing || watched_->moment().is_jumping);
}

void Workbench::endWatching() {
  if (!watched_) return;
  tissues_->closing();
  watched_.reset();
  scene_.clear();
  fresh_.clear();
  report_ = {};
  removed_mm3_ = 0;
  section.reset();
  structures_.reset();
  ++generation_;
}

Expected<void> Workbench::goOnCutting() {
  if (!watched_) return fail({.code = Error::Code::kEmpty, .found = "nothing is watched", .hint = "replay.open"});
  const WatchMoment& now = watched_->moment();
  if (now.is_jumping)
    return fail({.code = Error::Code::kUnsupported,
                 .file = watched_->folder().string(),
                 .found = "it is on its way to another moment",
                 .expected = "the moment from which to go on",
                 .hint = "wait for it"});
  if (now.is_at_end) {
    open(watched_->folder());
    return {};
  }
  const std::string at = fmt::format(" as at {:.1f} s", kTick * static_cast<double>(now.sample));
  openBranch({watched_->folder(), {.sample = now.sample}, watched_->folder().filename().string() + at});
  return {};
}

}  // namespace kerf
