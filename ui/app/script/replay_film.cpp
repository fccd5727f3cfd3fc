#include "ui/app/script/replay_film.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "sim/run/session/watched_run.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/script/app_script.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

Expected<void> makeEmptyFolder(const fs::path& folder) {
  std::error_code failed, ignored;
  fs::create_directories(folder, failed);
  if (!failed && fs::is_empty(folder, failed) && !failed) return {};
  return fail({.code = Error::Code::kWriteFailed,
               .file = folder.string(),
               .place = "--film",
               .found = failed ? failed.message() : "a folder that is not empty",
               .expected = "a new folder, or an empty one",
               .hint = "another name"});
}

// Moments of the pictures, in ticked samples.
Expected<std::vector<std::size_t>> momentsOf(const FilmOptions& o, const WatchedRun& run) {
  const double last = std::min(o.until_s, run.seconds());
  const bool is_in_range = o.fps > 0 && o.fps <= FilmOptions::kMostFps && o.from_s >= 0 && o.from_s < last;
  const double count = is_in_range ? std::floor((last - o.from_s) * o.fps + 1e-9) + 1 : 0;
  if (!is_in_range || count > static_cast<double>(FilmOptions::kMostPictures))
    return fail({.code = Error::Code::kBadValue,
                 .place = "--fps, --from, --until",
                 .found = fmt::format("{:g} pictures a second, from {:g} to {:g} s", o.fps, o.from_s, o.until_s),
                 .expected = fmt::format("at most {:g} a second and {} in all, within 0 to {:.3f} s",
                                         FilmOptions::kMostFps, FilmOptions::kMostPictures, run.seconds()),
                 .hint = "--fps 10"});
  std::vector<std::size_t> out;
  for (std::size_t n = 0; n < static_cast<std::size_t>(count); ++n) {
    const double at_s = o.from_s + static_cast<double>(n) / o.fps;
    out.push_back(std::min(static_cast<std::size_t>(at_s / kTick + 0.5), run.samples()));
  }
  return out;
}

}  // namespace

Expected<std::size_t> filmReplay(AppContext& context, const FilmOptions& options, const std::function<void()>& frame) {
  KERF_CHECK(waitUntilSettled(context, frame));
  WatchedRun* const run = context.bench.document->watched();
  if (!run) {
    for (const Notice& notice : context.bench.notices->list())
      if (notice.is_error) return fail({.code = Error::Code::kUnsupported, .found = notice.text});
    return fail({.code = Error::Code::kUnsupported, .found = "no replay is open", .hint = "--replay RUN"});
  }
  KERF_TRY(moments, momentsOf(options, *run));
  KERF_CHECK(makeEmptyFolder(options.folder));

  for (std::size_t n = 0; n < moments.size(); ++n) {
    run->jumpTo(moments[n]);
    KERF_CHECK(waitUntilSettled(context, frame));
    KERF_CHECK(context.screenshot(options.folder / fmt::format("frame-{:05}.png", n + 1)));
  }
  return moments.size();
}

}  // namespace kerf
