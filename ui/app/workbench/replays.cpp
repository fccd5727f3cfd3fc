#include "ui/app/workbench/replays.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "geometry/case/case_bundle.h"
#include "sim/run/session/watched_run.h"
#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/file_history.h"
#include "ui/app/document/view_state.h"
#include "ui/app/view/upright.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

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

void Replays::open(const fs::path& run_folder) {
  if (bench_.jobs->isBusy()) return;
  const auto work = [run_folder](const Progress& progress) { return openToWatch(run_folder, progress); };
  const auto take = [this](Expected<Watched> loaded) {
    if (!loaded) return bench_.notices->complain(loaded.error());
    const auto next = std::make_shared<Watched>(std::move(*loaded));
    // Writes the previous session only once its replacement is loaded.
    bench_.sessions->afterClose([this, next] {
      bench_.imports->putAway();
      if (bench_.document->watched()) bench_.closing();
      bench_.document->watch(std::move(next->run), next->occlusal);
      bench_.opened(Opening::kNew);
      bench_.history->remember(bench_.document->source());
    });
  };
  bench_.jobs->start<Watched>(Jobs::Kind::kReads, phrase("opening {} for replay", run_folder.filename().string()), work,
                              take);
}

void Replays::opened(Opening /*how*/) { has_told_of_verdict_ = false; }

void Replays::update() {
  const WatchedRun* const run = bench_.document->watched();
  if (!run || !bench_.document->hasNews()) return;
  const auto& verdict = run->moment().verdict;
  if (verdict && !std::exchange(has_told_of_verdict_, true))
    bench_.notices->add({!verdict->is_same, "replayed: " + verdict->text});
}

bool Replays::isPlaying() const {
  const WatchedRun* const run = bench_.document->watched();
  return run && (run->moment().is_playing || run->moment().is_jumping);
}

void Replays::end() {
  if (!bench_.document->watched()) return;
  bench_.closing();
  bench_.document->endWatching();
  bench_.views->section.reset();
}

Expected<void> Replays::goOnCutting() {
  const WatchedRun* const run = bench_.document->watched();
  if (!run) return fail({.code = Error::Code::kEmpty, .found = "no replay is open", .hint = "replay.open"});
  const WatchMoment& now = run->moment();
  if (now.is_jumping)
    return fail({.code = Error::Code::kUnsupported,
                 .file = run->folder().string(),
                 .found = "the replay is jumping to another moment",
                 .expected = "a replay that is not jumping",
                 .hint = "wait for it"});
  if (now.is_at_end) {
    bench_.sessions->open(run->folder());
    return {};
  }
  const std::string at = fmt::format(" as at {:.1f} s", kTick * static_cast<double>(now.sample));
  bench_.sessions->openBranch({run->folder(), {.sample = now.sample}, run->folder().filename().string() + at});
  return {};
}

}  // namespace kerf
