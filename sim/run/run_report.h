// What a trainer asks of a run: what was removed of which tissue, how that compares with the plan, how hard, how near,
// how warm, how long.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/base/types.h"
#include "sim/run/cut_settings.h"
#include "sim/run/run_manifest.h"
#include "sim/run/run_series.h"

namespace kerf {

/// Whatever has no value is not known, and `missing` says why; `never` is a value of its own.
struct RunReport {
  RunManifest manifest;
  /// summary.json, from which most of this comes, is not what the run was written with. Nothing: an older run does not
  /// say, or there is no summary.
  std::optional<bool> is_summary_edited;

  /// A value and when it was reached; not every run knows when.
  struct Peak {
    double value = 0;
    std::optional<double> at_s;
  };
  /// When something first happened, s; nothing inside: it never did.
  using FirstTime = std::optional<double>;

  // Volumes of the case, mm^3. By a material's id. Of a run that went on from another one: since then.
  std::optional<double> loaded_mm3, removed_mm3, added_mm3;
  std::map<std::string, double> loaded_by_material, removed_by_material, added_by_material;

  // Against what the path asks for.
  std::optional<double> planned_mm3, reached_mm3;
  std::map<std::string, double> planned_by_material;
  std::optional<double> farthest_off_mm;  ///< of the tip from its path
  std::optional<Vec3d> farthest_off_at;   ///< mm, where the tip was then

  // Of strokes that stand: those that were taken back are in `taken_back`.
  std::optional<double> mean_contact_force;                   ///< N, over the time in contact
  std::optional<Peak> contact_force;                          ///< largest on the tool, N
  std::map<std::string, std::optional<Peak>> least_distance;  ///< mm by structure; nothing inside: it never came near
  std::optional<Peak> hottest;                                ///< C, under the tool
  std::optional<FirstTime> bone_limit, pulp_limit;            ///< 47 C in bone, 5.5 K in the pulp
  /// Peaks of strokes that were taken back, if they are worse.
  struct TakenBack {
    std::optional<Peak> contact_force, hottest;
    std::map<std::string, Peak> least_distance;
  } taken_back;

  std::optional<CutSettings> settings;  ///< with what a path was cut against resistance; older runs do not say

  std::optional<double> stalled_s;  ///< how long the drive stood still while it was to cut; of a session: roughly
  std::optional<double> seconds;    ///< of the run; a cut by geometry alone takes none
  std::optional<double> path_s;     ///< what its path would take
  std::optional<std::size_t> strokes, pieces, crumbs;
  std::vector<std::string> tools;    ///< ids of those that were in hand
  std::optional<std::string> ended;  ///< why a run along a path ended

  std::vector<std::string> missing;  ///< sentences: what is not known, why, and what to try
};

/// Reads what a run holds. Volumes that no file states are counted from its field and its case.
/// @param replays  the log of a session is replayed for what no file keeps: force, temperature, distances.
/// Errors: those of the manifest and of a damaged summary.json. A case that is not there is no error: `missing` says
/// so.
/// @cost  milliseconds; a second or two where fields are read; with `replays` that of readRunSeries().
Expected<RunReport> readRunReport(const std::filesystem::path& run_folder, bool replays = false,
                                  const Progress& progress = {});

/// The peaks of a report, as summary.json has them; null: not known, or never.
nlohmann::json peaksJson(const RunReport& report);

/// Of that only what manifest and summary.json state; nothing is counted or replayed, and `missing` says nothing.
/// @cost  milliseconds.
Expected<RunReport> readRunSummary(const std::filesystem::path& run_folder);

namespace internal {

/// Largest force, highest temperature and least distances of a series, with their times.
void addPeaks(const RunSeries& series, RunReport& report);
void addPeaks(const SessionPeaks& peaks, RunReport& report);

/// Writes summary.json of a session: its peaks.   @return its hash. Error kWriteFailed.
Expected<std::string> writeSessionSummary(const std::filesystem::path& run_folder, const SessionPeaks& peaks);

}  // namespace internal
}  // namespace kerf
