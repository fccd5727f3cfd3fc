// A trainer's report of a run: removed volume by tissue, comparison with the plan, forces, distances, temperature and
// times.
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
#include "sim/run/files/cut_settings.h"
#include "sim/run/files/run_manifest.h"
#include "sim/run/report/run_series.h"

namespace kerf {

/// Values without content are unknown, and `missing` says why; `never` is a value of its own.
struct RunReport {
  RunManifest manifest;
  /// Whether summary.json, the main source, was edited after the run. Nothing: an older run does not say, or there is
  /// no summary.
  std::optional<bool> is_summary_edited;

  /// A value and its time; some runs lack the time.
  struct Peak {
    double value = 0;
    std::optional<double> at_s;
  };
  /// When something first happened, s; empty inside: never.
  using FirstTime = std::optional<double>;

  // Volumes of the case, mm^3, by material id. If the run continues another one: since then.
  std::optional<double> loaded_mm3, removed_mm3, added_mm3;
  std::map<std::string, double> loaded_by_material, removed_by_material, added_by_material;

  // Comparison with the plan of the path.
  std::optional<double> planned_mm3, reached_mm3;
  std::map<std::string, double> planned_by_material;
  std::optional<double> farthest_off_mm;  ///< of the tip from its path
  std::optional<Vec3d> farthest_off_at;   ///< mm, position of the tip then

  // Strokes that remain; `taken_back` holds the undone ones.
  std::optional<double> mean_contact_force;                   ///< N, over the time in contact
  std::optional<Peak> contact_force;                          ///< largest on the tool, N
  std::map<std::string, std::optional<Peak>> least_distance;  ///< mm by structure; empty inside: it never came near
  std::optional<Peak> hottest;                                ///< C, under the tool
  std::optional<FirstTime> bone_limit, pulp_limit;            ///< 47 C in bone, 5.5 K in the pulp
  /// Peaks of undone strokes, if they are worse.
  struct TakenBack {
    std::optional<Peak> contact_force, hottest;
    std::map<std::string, Peak> least_distance;
  } taken_back;

  std::optional<CutSettings> settings;  ///< settings of a path cut against resistance; older runs do not say

  std::optional<double> stalled_s;  ///< time the drive stood still while meant to cut; approximate for a session
  std::optional<double> seconds;    ///< of the run; geometry-only cuts have none
  std::optional<double> path_s;     ///< nominal duration of its path
  std::optional<std::size_t> strokes, pieces, crumbs;
  std::vector<std::string> tools;    ///< ids of those used
  std::optional<std::string> ended;  ///< why a run along a path ended

  std::vector<std::string> missing;  ///< sentences: each unknown value, why, and a remedy
};

/// Reads the contents of a run. Counts volumes that no file states from its field and its case.
/// @param replays  replays the log of a session for values that no file keeps: force, temperature, distances.
/// Errors: those of the manifest and of a damaged summary.json. A missing case is no error: `missing` says so.
/// @cost  milliseconds; a second or two if it reads fields; with `replays` that of readRunSeries().
Expected<RunReport> readRunReport(const std::filesystem::path& run_folder, bool replays = false,
                                  const Progress& progress = {});

/// The peaks of a report in the format of summary.json; null: unknown, or never.
nlohmann::json peaksJson(const RunReport& report);

/// A report from manifest and summary.json alone: counts and replays nothing, and leaves `missing` empty.
/// @cost  milliseconds.
Expected<RunReport> readRunSummary(const std::filesystem::path& run_folder);

namespace internal {

/// Largest force, highest temperature and least distances of a series, with their times.
void addPeaks(const RunSeries& series, RunReport& report);
void addPeaks(const SessionPeaks& peaks, RunReport& report);

/// Writes the peaks of a session to summary.json.   @return its hash. Error kWriteFailed.
Expected<std::string> writeSessionSummary(const std::filesystem::path& run_folder, const SessionPeaks& peaks);

}  // namespace internal
}  // namespace kerf
