#include "sim/run/report/run_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "geometry/base/atomic_file.h"
#include "geometry/base/hash.h"
#include "geometry/base/text.h"
#include "geometry/case/case_bundle.h"
#include "geometry/case/case_materials.h"
#include "geometry/field/material.h"
#include "sim/hand/path.h"
#include "sim/run/files/haptic_summary.h"
#include "sim/run/files/removed_volumes.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_output.h"
#include "sim/session/session_log.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// ---- summary.json

// Valid range of a value in summary.json. The limits are far from any run: kerf cut wrote no values beyond them.
struct Range {
  double least, most;
  const char* unit;
};
constexpr double kMostMm3 = 1e12;  // as in case.toml
constexpr Range kVolume{0, kMostMm3, "mm^3"};
constexpr Range kAdded{-kMostMm3, kMostMm3, "mm^3"};  // of a covered surface < 0: see HapticSummary
constexpr Range kForce{0, 1e9, "N"};
constexpr Range kTemperature{-273.15, 1e6, "C"};
constexpr Range kLength{0, 1e6, "mm"};
constexpr Range kDistance{-1e6, 1e6, "mm"};  // < 0: inside
constexpr Range kCoordinate{-1e9, 1e9, "mm"};
constexpr Range kTime{0, 1e9, "s"};
constexpr Range kTimeOrNever{-1, 1e9, "s"};  // -1: never, as in older versions
constexpr Range kCount{0, 1e12, "parts"};

// The removed volume of all tissues, or of one. Added material takes over a node's share of its cell; older versions
// also moved it where tissues meet. So the value of one tissue may be slightly negative.
Range removedRange(double removed_mm3) {
  constexpr double kSubVoxel = 0.1, kOfAll = 0.1;  // mm^3; fraction of the total
  return {-kSubVoxel - kOfAll * std::max(0.0, removed_mm3), kMostMm3, "mm^3"};
}

Error damagedSummary(const fs::path& file, std::string place, std::string found, std::string expected) {
  return {.code = Error::Code::kBadFormat,
          .file = file.string(),
          .place = std::move(place),
          .found = std::move(found),
          .expected = std::move(expected),
          .hint = "cut again: runs must not be edited"};
}

// Values by their keys; a key that an older version did not write has none. Keeps the first error for finish().
class Summary {
 public:
  Summary(const json& j, const fs::path& file) : j_(j), file_(file) {}

  std::optional<double> number(const char* key, const Range& range) {
    const json* value = find(key);
    if (!value) return {};
    return checked(*value, fmt::format("key {}", key), range);
  }

  std::optional<std::size_t> count(const char* key) {
    const auto value = number(key, kCount);
    if (!value) return {};
    if (*value != std::floor(*value)) wrong(fmt::format("key {}", key), fmt::format("{:g}", *value), "a whole number");
    return static_cast<std::size_t>(*value);
  }

  std::map<std::string, double> numbers(const char* key, const Range& range) {
    std::map<std::string, double> out;
    const json* table = find(key);
    if (!table) return out;
    if (!table->is_object()) {
      wrong(fmt::format("key {}", key), "no table", "a table of numbers");
      return out;
    }
    for (const auto& [id, value] : table->items())
      if (value.is_null())
        continue;
      else if (const auto number = checked(value, fmt::format("key {}, {}", key, id), range))
        out[id] = *number;
    return out;
  }

  std::optional<std::string> text(const char* key) {
    const auto it = j_.find(key);
    if (it == j_.end() || !it->is_string()) return {};
    return it->get<std::string>();
  }

  std::optional<Vec3d> point(const char* key) {
    const json* value = find(key);
    if (!value) return {};
    const std::string place = fmt::format("key {}", key);
    if (!value->is_array() || value->size() != 3) {
      wrong(place, "no point", "a point of three numbers, mm");
      return {};
    }
    Vec3d out = Vec3d::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis)
      out[static_cast<Eigen::Index>(axis)] = checked((*value)[axis], place, kCoordinate).value_or(0);
    return out;
  }

  Expected<void> finish() const {
    if (!error_) return {};
    return fail(*error_);
  }

 private:
  // Null: missing, or without a value.
  const json* find(const char* key) const {
    const auto it = j_.find(key);
    return it == j_.end() || it->is_null() ? nullptr : &*it;
  }

  std::optional<double> checked(const json& value, const std::string& place, const Range& range) {
    const std::string expected = fmt::format("a number from {:g} to {:g} {}", range.least, range.most, range.unit);
    if (!value.is_number()) {
      wrong(place, "no number", expected);
      return {};
    }
    const double number = value.get<double>();
    if (number >= range.least && number <= range.most) return number;  // NaN fails both comparisons
    wrong(place, fmt::format("{:g}", number), expected);
    return {};
  }

  void wrong(std::string place, std::string found, std::string expected) {
    if (!error_) error_ = damagedSummary(file_, std::move(place), std::move(found), std::move(expected));
  }

  const json& j_;
  const fs::path& file_;
  std::optional<Error> error_;
};

// A peak and its time, by their keys.
std::optional<RunReport::Peak> peakIn(Summary& s, const char* key, const Range& range, const char* at) {
  const auto value = s.number(key, range);
  if (!value) return {};
  return RunReport::Peak{*value, s.number(at, kTime)};
}

std::map<std::string, RunReport::Peak> distancesIn(Summary& s) {
  std::map<std::string, RunReport::Peak> out;
  const auto times = s.numbers("least_distance_at_s", kTime);
  for (const auto& [id, mm] : s.numbers("least_distance_mm", kDistance)) {
    const auto at = times.find(id);
    out[id] = {mm, at == times.end() ? std::nullopt : std::optional(at->second)};
  }
  return out;
}

// A negative time means never.
RunReport::FirstTime firstTime(double at_s) { return at_s < 0 ? RunReport::FirstTime{} : RunReport::FirstTime{at_s}; }

Expected<void> takeSummary(const fs::path& file, RunReport& out) {
  KERF_TRY(text, readSmallFile(file, internal::kMostSummaryBytes));
  const json j = json::parse(text, nullptr, false);
  if (!j.is_object()) return fail(damagedSummary(file, "", "no JSON object", "the summary of kerf cut"));
  Summary s(j, file);

  out.loaded_mm3 = s.number("initial_mm3", kVolume);
  out.loaded_by_material = s.numbers("initial_by_material_mm3", kVolume);
  out.removed_mm3 = s.number("removed_mm3", removedRange(0));
  out.removed_by_material = s.numbers("removed_by_material_mm3", removedRange(out.removed_mm3.value_or(0)));
  if (const auto added = s.number("added_mm3", kAdded); added && *added != 0) out.added_mm3 = added;
  out.added_by_material = s.numbers("added_by_material_mm3", kAdded);

  if (const auto planned = s.number("planned_mm3", removedRange(0)); planned && *planned > 0) {
    out.planned_mm3 = planned;
    out.reached_mm3 = s.number("reached_mm3", removedRange(*planned));
    out.planned_by_material = s.numbers("planned_by_material_mm3", removedRange(*planned));
    out.farthest_off_mm = s.number("farthest_off_mm", kLength);
    out.farthest_off_at = s.point("farthest_off_at");
  }

  out.mean_contact_force = s.number("mean_contact_force_N", kForce);
  out.contact_force = peakIn(s, "peak_contact_force_N", kForce, "peak_contact_force_at_s");
  out.stalled_s = s.number("stalled_s", kTime);
  out.hottest = peakIn(s, "hottest_C", kTemperature, "hottest_at_s");
  if (const auto kept = j.find("least_distance_mm"); kept != j.end() && kept->is_object())
    for (const auto& [id, value] : kept->items()) out.least_distance[id];  // null: it never came near
  for (const auto& [id, peak] : distancesIn(s)) out.least_distance[id] = peak;
  if (const auto back = j.find("taken_back"); back != j.end() && back->is_object()) {
    Summary of(*back, file);
    out.taken_back.contact_force = peakIn(of, "peak_contact_force_N", kForce, "peak_contact_force_at_s");
    out.taken_back.hottest = peakIn(of, "hottest_C", kTemperature, "hottest_at_s");
    out.taken_back.least_distance = distancesIn(of);
    KERF_CHECK(of.finish());
  }
  if (out.hottest) {
    out.bone_limit = firstTime(s.number("bone_limit_at_s", kTimeOrNever).value_or(-1));
    out.pulp_limit = firstTime(s.number("pulp_limit_at_s", kTimeOrNever).value_or(-1));
  }
  out.pieces = s.count("pieces");
  out.crumbs = s.count("crumbs");
  out.ended = s.text("ended");
  if (const auto settings = j.find("settings"); settings != j.end()) {
    out.settings = settingsFromJson(*settings);
    if (!out.settings) return fail(damagedSummary(file, "key settings", "other values", "the values of kerf cut"));
  }
  return s.finish();
}

// Whether summary.json is unchanged since the run.
Expected<void> compareSummary(const fs::path& file, RunReport& out) {
  if (out.manifest.summary_sha256.empty()) return {};
  KERF_TRY(hash, sha256OfFile(file));
  out.is_summary_edited = hash != out.manifest.summary_sha256;
  return {};
}

// ---- Values that no file states

// Stretches in which the tool was meant to cut without a break.
std::optional<std::size_t> strokesOfPath(const fs::path& file) {
  const auto path = readPath(file);
  if (!path) return {};
  std::size_t strokes = 0;
  for (std::size_t n = 0; n < path->cuts.size(); ++n) strokes += path->cuts[n] && (n == 0 || !path->cuts[n - 1]);
  return strokes;
}

void missVolumes(const Error& error, RunReport& out) {
  out.missing.push_back("removed volume by tissue: " + error.message());
}

// Counts volumes from the nodes of run and case.
Expected<void> countVolumes(const fs::path& run_folder, RunReport& out) {
  KERF_TRY(case_folder, caseOfRun(run_folder));
  KERF_TRY(in_case, readCaseManifest(case_folder));
  if (out.manifest.voxel_mm != in_case.voxel_mm)
    return fail(
        {.code = Error::Code::kUnsupported,
         .file = run_folder.string(),
         .found = fmt::format("cut in the case's fine region, at {} mm, by an older Kerf", out.manifest.voxel_mm),
         .expected = "the volumes counted during the cut",
         .hint = "cut again"});
  KERF_TRY(table, readDefaultMaterials());
  KERF_CHECK(requireSameMaterials(case_folder, in_case, table));
  KERF_TRY(fields, readCaseFields(case_folder, in_case));
  KERF_TRY(cut, readRunCutField(run_folder));
  KERF_CHECK(requireOnlyTaken(run_folder, out.manifest, cut, fields.phi0));
  KERF_TRY(known, readRunMaterials(run_folder));
  KERF_TRY(labels, readRunLabels(case_folder, known));
  const Material fallback = fallbackOf(in_case);
  const BrickField whole = internal::withoutPlaneFaces(std::move(cut), fields.phi0, out.manifest.pieces);
  internal::VolumeByNumber removed = internal::removedVolumes(
      fields.phi0, whole, internal::materialsOf(fields.materials, fallback), internal::materialsOf(labels, fallback));
  internal::VolumeByNumber added{};
  for (std::size_t m = 0; m < removed.size() && !known.isEmpty(); ++m) {
    if (removed[m] >= 0) continue;
    added[m] = -removed[m];
    removed[m] = 0;
  }
  out.removed_by_material = internal::byMaterial(removed, table);
  out.removed_mm3 = internal::sumOf(removed);
  if (known.isEmpty()) return {};
  out.added_by_material = internal::byMaterial(added, table);
  out.added_mm3 = internal::sumOf(added);
  return {};
}

// Loaded volumes of the case, unless the summary has them.
void takeLoaded(const fs::path& run_folder, RunReport& out) {
  if (!out.loaded_by_material.empty()) return;
  const auto folder = caseOfRun(run_folder);
  const auto in_case = folder ? readCaseManifest(*folder) : Expected<CaseManifest>(fail(folder.error()));
  if (!in_case) {
    out.missing.push_back("share of each tissue: " + in_case.error().message());
    return;
  }
  double sum = 0;
  for (const CaseMaterial& material : in_case->materials) {
    out.loaded_by_material[material.id] += material.volume_mm3;
    sum += material.volume_mm3;
  }
  if (!out.loaded_mm3) out.loaded_mm3 = sum;
}

// Without resistance a tool follows its path exactly.
void takePlanOfGeometry(RunReport& out) {
  out.planned_mm3 = out.removed_mm3;
  out.reached_mm3 = out.removed_mm3;
  out.planned_by_material = out.removed_by_material;
  out.farthest_off_mm = 0;
}

void takeSession(const fs::path& run_folder, RunReport& out) {
  if (const auto log = readSessionLog(run_folder / internal::kRunLog))
    out.strokes = strokesOf(*log).size();
  else
    out.missing.push_back("strokes: " + log.error().message());
  out.missing.push_back("planned and removed volume: a session by hand has no path to compare with");
}

void takePath(const fs::path& run_folder, RunReport& out) {
  out.strokes = strokesOfPath(run_folder / out.manifest.path_file);
  if (!out.strokes) out.missing.push_back("strokes: the copy of the path in the run cannot be read");
}

// Whether a peak lacks its time: the summary of an older version has sizes only.
bool lacksTimes(const RunReport& r) {
  const auto lacks = [](const std::optional<RunReport::Peak>& peak) { return peak && !peak->at_s; };
  return lacks(r.contact_force) || lacks(r.hottest) ||
         std::any_of(r.least_distance.begin(), r.least_distance.end(), [&](const auto& d) { return lacks(d.second); });
}

Expected<void> takeSeries(const fs::path& run_folder, bool replays, const Progress& progress, RunReport& out) {
  const std::string& mode = out.manifest.mode;
  if (mode == kModeGeometry) {
    out.missing.push_back(
        "force, temperature, distances: a geometry run has no resistance and no time; kerf cut --hand cuts against "
        "resistance");
    return {};
  }
  const bool has_table = fs::is_regular_file(run_folder / internal::kRunForces);
  if (mode == kModeSession && !replays && out.contact_force && out.hottest) {
    if (!out.manifest.beside.empty())
      out.missing.push_back("distances to neighbours: kerf info --replay " + run_folder.string());
    return {};
  }
  if (mode == kModeSession && !has_table && !replays) {
    out.missing.push_back(
        fmt::format("force, temperature, distances: this session has no summary, only its log; kerf info "
                    "--replay {} replays its {:.0f} s for them, in about a quarter of that time",
                    run_folder.string(), out.manifest.duration_s));
    return {};
  }
  if (has_table && out.contact_force && !lacksTimes(out) && !out.least_distance.empty()) return {};

  auto series = readRunSeries(run_folder, progress);
  if (series)
    internal::addPeaks(*series, out);
  else if (series.error().code == Error::Code::kCancelled)
    return fail(series.error());
  else
    out.missing.push_back("times of force, temperature, distances: " + series.error().message());
  return {};
}

}  // namespace

// Considers strokes from one second after their beginning: until then a drive may still come up.
static double secondsStalled(const RunSeries& series) {
  constexpr double kComesUp = 1, kStill = 0.02;  // s; of the highest speed
  const float most = *std::max_element(series.speed.begin(), series.speed.end());
  double stalled = 0;
  std::size_t stroke = 0;
  for (std::size_t n = 1; n < series.size() && most > 0; ++n) {
    while (stroke < series.strokes.size() && series.strokes[stroke].to_s < series.t_s[n]) ++stroke;
    if (stroke == series.strokes.size()) break;
    if (series.t_s[n] < series.strokes[stroke].from_s + kComesUp) continue;
    if (std::abs(series.speed[n]) < kStill * most) stalled += series.t_s[n] - series.t_s[n - 1];
  }
  return stalled;
}

namespace {

std::optional<RunReport::Peak> reportedPeak(const CutPeaks::Peak& peak) {
  if (!peak.isKnown()) return {};
  return RunReport::Peak{peak.value, peak.at_s};
}

}  // namespace

// An undone peak counts if there is no other, or it is worse.
void internal::addPeaks(const SessionPeaks& peaks, RunReport& out) {
  const CutPeaks &now = peaks.standing, &back = peaks.taken_back;
  const auto isMore = [](const CutPeaks::Peak& a, const CutPeaks::Peak& b) {
    return a.isKnown() && (!b.isKnown() || a.value > b.value);
  };
  out.mean_contact_force = now.meanContact();
  out.contact_force = reportedPeak(now.contact_N);
  out.hottest = reportedPeak(now.celsius);
  if (isMore(back.contact_N, now.contact_N)) out.taken_back.contact_force = reportedPeak(back.contact_N);
  if (isMore(back.celsius, now.celsius)) out.taken_back.hottest = reportedPeak(back.celsius);
  const auto limit = [](double at_s) { return at_s < 0 ? RunReport::FirstTime{} : RunReport::FirstTime{at_s}; };
  out.bone_limit = limit(peaks.alarms.bone_warm);
  out.pulp_limit = limit(peaks.alarms.pulp);
  for (std::size_t n = 0; n < peaks.kept.size(); ++n) {
    const CutPeaks::Peak &stands = now.nearest_mm[n], &undone = back.nearest_mm[n];
    out.least_distance[peaks.kept[n]] = reportedPeak(stands);
    if (undone.isKnown() && (!stands.isKnown() || undone.value < stands.value))
      out.taken_back.least_distance[peaks.kept[n]] = *reportedPeak(undone);
  }
}

json peaksJson(const RunReport& r) {
  const auto valueOf = [](const std::optional<RunReport::Peak>& p) { return p ? json(p->value) : json(); };
  const auto timeOf = [](const std::optional<RunReport::Peak>& p) { return p && p->at_s ? json(*p->at_s) : json(); };
  const auto limit = [](const std::optional<RunReport::FirstTime>& t) { return t && *t ? json(**t) : json(); };
  const auto table = [&](const auto& force, const auto& hottest, const auto& distances) {
    json out{{"peak_contact_force_N", valueOf(force)}, {"peak_contact_force_at_s", timeOf(force)},
             {"hottest_C", valueOf(hottest)},          {"hottest_at_s", timeOf(hottest)},
             {"least_distance_mm", json::object()},    {"least_distance_at_s", json::object()}};
    for (const auto& [id, least] : distances) {
      out["least_distance_mm"][id] = valueOf(least);
      out["least_distance_at_s"][id] = timeOf(least);
    }
    return out;
  };
  json out = table(r.contact_force, r.hottest, r.least_distance);
  out["mean_contact_force_N"] = r.mean_contact_force ? json(*r.mean_contact_force) : json();
  out["bone_limit_at_s"] = limit(r.bone_limit);
  out["pulp_limit_at_s"] = limit(r.pulp_limit);
  out["taken_back"] = table(r.taken_back.contact_force, r.taken_back.hottest, r.taken_back.least_distance);
  return out;
}

Expected<std::string> internal::writeSessionSummary(const fs::path& run_folder, const SessionPeaks& peaks) {
  RunReport report;
  addPeaks(peaks, report);
  const fs::path path = run_folder / kRunSummary;
  KERF_TRY(file, AtomicFile::create(path));
  file.stream() << peaksJson(report).dump(2) << "\n";
  KERF_CHECK(file.commit());
  return sha256OfFile(path);
}

void internal::addPeaks(const RunSeries& series, RunReport& out) {
  if (series.size() == 0) return;
  if (!out.stalled_s && series.speed.size() == series.size()) out.stalled_s = secondsStalled(series);
  const auto peakOf = [&](const std::vector<float>& values, std::vector<float>::const_iterator at) {
    const auto n = static_cast<std::size_t>(at - values.begin());
    return RunReport::Peak{values[n], series.t_s[n]};
  };
  // Keeps a size that is known to more digits.
  const auto take = [](std::optional<RunReport::Peak>& known, const RunReport::Peak& found) {
    if (known)
      known->at_s = found.at_s;
    else
      known = found;
  };

  if (series.peaks) return addPeaks(*series.peaks, out);
  take(out.contact_force, peakOf(series.contact_N, std::max_element(series.contact_N.begin(), series.contact_N.end())));
  take(out.hottest,
       peakOf(series.temperature_C, std::max_element(series.temperature_C.begin(), series.temperature_C.end())));

  for (const RunSeries::Distance& distance : series.distances) {
    std::optional<RunReport::Peak>& least = out.least_distance[distance.id];
    std::optional<std::size_t> nearest;
    for (std::size_t n = 0; n < distance.mm.size(); ++n)
      if (!std::isnan(distance.mm[n]) && (!nearest || distance.mm[n] < distance.mm[*nearest])) nearest = n;
    if (nearest) take(least, {distance.mm[*nearest], series.t_s[*nearest]});
  }
}

Expected<RunReport> readRunSummary(const fs::path& run_folder) {
  RunReport out;
  KERF_TRY(manifest, readRunManifest(run_folder));
  out.manifest = std::move(manifest);
  const fs::path summary = run_folder / internal::kRunSummary;
  std::error_code ignored;
  if (fs::is_regular_file(summary, ignored)) KERF_CHECK(takeSummary(summary, out));
  return out;
}

Expected<RunReport> readRunReport(const fs::path& run_folder, bool replays, const Progress& progress) {
  RunReport out;
  KERF_TRY(manifest, readRunManifest(run_folder));
  out.manifest = std::move(manifest);
  const std::string& mode = out.manifest.mode;
  if (mode != kModeGeometry) out.seconds = out.manifest.duration_s;
  if (mode != kModeSession) out.path_s = out.manifest.duration_s;
  if (mode == kModeHaptic) out.path_s.reset();
  for (std::size_t from = 0; from < out.manifest.tool_id.size();) {
    const std::size_t comma = std::min(out.manifest.tool_id.find(", ", from), out.manifest.tool_id.size());
    out.tools.push_back(out.manifest.tool_id.substr(from, comma - from));
    from = comma + 2;
  }
  if (out.manifest.is_open) {
    out.missing.push_back("the result: the session has not ended; after a crash: kerf recover " + run_folder.string());
    return out;
  }

  const fs::path summary = run_folder / internal::kRunSummary;
  std::error_code ignored;
  if (fs::is_regular_file(summary, ignored)) {
    KERF_CHECK(takeSummary(summary, out));
    KERF_CHECK(compareSummary(summary, out));
  }
  if (!out.removed_mm3)
    if (const auto counted = countVolumes(run_folder, out); !counted) missVolumes(counted.error(), out);
  takeLoaded(run_folder, out);

  if (mode == kModeGeometry) takePlanOfGeometry(out);
  if (mode == kModeSession)
    takeSession(run_folder, out);
  else
    takePath(run_folder, out);
  // A session lists its pieces when there are several, or one was moved.
  if (mode == kModeSession) out.pieces = std::max<std::size_t>(1, out.manifest.pieces.size());
  KERF_CHECK(takeSeries(run_folder, replays, progress, out));
  return out;
}

}  // namespace kerf
