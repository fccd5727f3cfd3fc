#include "sim/run/files/run_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <variant>

#include "geometry/base/hash.h"
#include "geometry/base/text.h"
#include "geometry/case/case_bundle.h"
#include "geometry/case/case_materials.h"
#include "geometry/field/distance_check.h"
#include "geometry/field/vdb_io.h"
#include "sim/monitor/monitor.h"
#include "sim/run/files/run_output.h"
#include "sim/session/command.h"
#include "sim/session/session_log.h"

namespace kerf {
namespace fs = std::filesystem;

namespace {

std::vector<fs::path>& placesOfCases() {
  static std::vector<fs::path> places;
  return places;
}

// Searches the given places. None: no place was given, or none holds the neighbour.
Expected<std::optional<fs::path>> findGivenCase(const fs::path& run_folder, const std::string& id, bool is_main) {
  std::string found;
  for (const fs::path& place : placesOfCases()) {
    KERF_TRY(manifest, readCaseManifest(place));
    if (manifest.id == id) return std::optional(place);
    found += fmt::format("{}{} is case {}", found.empty() ? "" : ", ", place.string(), manifest.id.substr(0, 12));
  }
  if (!is_main || placesOfCases().empty()) return std::optional<fs::path>{};
  return fail({.code = Error::Code::kBadValue,
               .file = run_folder.string(),
               .place = "--case",
               .found = found,
               .expected = "case " + id.substr(0, 12) + ", from which this run was cut",
               .hint = "the same case as when the run was cut; a rebaked case differs"});
}

// Adds the file of a run's grid to an error.
Expected<void> ofRun(Expected<void> checked, const fs::path& file) {
  if (checked) return checked;
  checked.error().file = file.string();
  checked.error().hint = "runs must not be edited: restore it from a copy, or cut again";
  return checked;
}

Expected<void> requireField(const fs::path& run_folder, const RunManifest& manifest) {
  const bool has_log = manifest.mode == kModeSession;
  return requireSha256(run_folder / internal::kRunField, manifest.field_sha256,
                       has_log ? "rebuild it from the log: kerf recover " + run_folder.string() : "cut again");
}

// Reads a grid of a run and checks that its numbers can be distances.
Expected<BrickField> readGrid(const fs::path& file, const std::string& grid) {
  KERF_TRY(field, readVdb(file, grid));
  KERF_CHECK(ofRun(requireDistancesOfCut(field, grid), file));
  return std::move(field);
}

// Whether a run along a path reports added material.
bool saysThatItAdded(const fs::path& run_folder, const RunManifest& manifest) {
  if (manifest.mode != kModeHaptic) return false;
  const auto text = readSmallFile(run_folder / internal::kRunSummary, internal::kMostSummaryBytes);
  const nlohmann::json summary = nlohmann::json::parse(text.value_or(""), nullptr, false);
  if (!summary.is_object()) return false;
  const auto added = summary.find("added_mm3");
  return added != summary.end() && added->is_number() && added->get<double>() > 0;
}

// Whether a run's log has a command to add material: a branch of such a run is a session without a summary.
bool addedByItsLog(const fs::path& run_folder, const RunManifest& manifest) {
  if (manifest.mode == kModeGeometry) return false;
  const auto log = readSessionLog(run_folder / internal::kRunLog);
  if (!log) return false;

  const auto isOfCase = [&](const auto& entry) { return entry.first == "case_id" && entry.second == manifest.case_id; };
  const auto adds = [](const SessionEvent& event) {
    const auto* const text = std::get_if<SessionCommand>(&event.what);
    const auto command = text ? parseCommand(text->text) : fail({});
    return command && std::holds_alternative<AddMaterial>(*command);
  };
  return std::any_of(log->header.begin(), log->header.end(), isOfCase) &&
         std::any_of(log->events.begin(), log->events.end(), adds);
}

}  // namespace

void setPlacesOfCases(std::vector<fs::path> folders) { placesOfCases() = std::move(folders); }

namespace internal {

Expected<void> requireBeside(const fs::path& run_folder, const RunManifest& m, std::size_t beside) {
  if (beside <= m.beside.size()) return {};
  const bool has_none = m.beside.empty();
  return fail({.code = Error::Code::kNotFound,
               .file = run_folder.string(),
               .place = neighbourId(beside),
               .found = "there is none",
               .expected = has_none ? "a run with neighbours" : fmt::format("1 to {}", m.beside.size()),
               .hint = has_none ? "use kerf cut CASE --hand ... --beside OTHER.case, or open both in the window"
                                : "list them with kerf info"});
}

Expected<fs::path> locateCase(const fs::path& run_folder, const RunManifest& m, std::size_t beside) {
  const std::string& path = beside == 0 ? m.case_path : m.beside[beside - 1].case_path;
  const std::string& id = beside == 0 ? m.case_id : m.beside[beside - 1].case_id;
  const std::string keys = beside == 0 ? "" : neighbourId(beside) + ", ";

  KERF_TRY(given, findGivenCase(run_folder, id, beside == 0));
  if (given) return *given;

  // First the path as given, then with symbolic links resolved: a run may be reached through one.
  std::error_code ignored;
  fs::path wanted = (fs::absolute(run_folder, ignored) / path).lexically_normal();
  if (!isCase(wanted)) wanted = (fs::weakly_canonical(run_folder, ignored) / path).lexically_normal();
  if (!isCase(wanted))
    return fail({.code = Error::Code::kNotFound,
                 .file = run_folder.string(),
                 .place = keys + "key case_path",
                 .found = "no case at " + path,
                 .expected = beside == 0 ? "the case this run was cut from" : "the case of the neighbour",
                 .hint = "give its folder with --case FOLDER; or move it back, or cut again"});

  KERF_TRY(manifest, readCaseManifest(wanted));
  if (manifest.id != id)
    return fail({.code = Error::Code::kBadValue,
                 .file = run_folder.string(),
                 .place = keys + "key case_id",
                 .found = "the case was baked again after this run",
                 .expected = "case " + id.substr(0, 12),
                 .hint = "cut again"});
  return wanted;
}

}  // namespace internal

Expected<fs::path> caseOfRun(const fs::path& run_folder) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  return internal::locateCase(run_folder, manifest, 0);
}

Expected<std::vector<fs::path>> casesBesideRun(const fs::path& run_folder) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  std::vector<fs::path> out;
  for (std::size_t n = 1; n <= manifest.beside.size(); ++n) {
    KERF_TRY(folder, internal::locateCase(run_folder, manifest, n));
    out.push_back(std::move(folder));
  }
  return out;
}

Expected<BrickField> readRunSweep(const fs::path& run_folder) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  KERF_CHECK(requireField(run_folder, manifest));
  if (!manifest.hasSweep())
    return fail({.code = Error::Code::kUnsupported,
                 .file = run_folder.string(),
                 .place = "mode " + manifest.mode,
                 .found = "no sweep",
                 .expected = "a run cut geometry-only"});
  return readGrid(run_folder / internal::kRunField, "sweep");
}

Expected<BrickField> readRunCutField(const fs::path& run_folder, std::size_t beside) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  KERF_CHECK(requireEnded(run_folder, manifest));
  KERF_CHECK(internal::requireBeside(run_folder, manifest, beside));
  KERF_CHECK(requireField(run_folder, manifest));
  return readGrid(run_folder / internal::kRunField, beside == 0 ? "phi" : neighbourId(beside));
}

Expected<void> requireOnlyTaken(const fs::path& run_folder, const RunManifest& manifest, const BrickField& cut,
                                const BrickField& phi0, std::size_t beside) {
  if (beside == 0 && saysThatItAdded(run_folder, manifest)) return {};
  KERF_TRY(begin, readRunBegin(run_folder, manifest, beside));
  const std::string grid = beside == 0 ? "phi" : neighbourId(beside);
  auto checked = requireOnlyTaken(cut, phi0, begin ? &*begin : nullptr, grid);
  if (!checked && beside == 0 && addedByItsLog(run_folder, manifest)) return {};
  return ofRun(std::move(checked), run_folder / internal::kRunField);
}

Expected<MaterialBricks> readRunMaterials(const fs::path& run_folder) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  KERF_CHECK(requireEnded(run_folder, manifest));
  const fs::path file = run_folder / internal::kRunField;
  KERF_CHECK(requireField(run_folder, manifest));
  KERF_TRY(out, readMaterialBricks(file));
  if (out.isEmpty()) return out;

  KERF_TRY(begin, readBeginMaterials(run_folder, manifest));
  if (!begin.isEmpty() || saysThatItAdded(run_folder, manifest) || addedByItsLog(run_folder, manifest)) return out;
  return fail({.code = Error::Code::kBadValue,
               .file = file.string(),
               .place = std::string("grid ") + kMaterialGrid,
               .found = "added materials in a run without filling",
               .expected = "a run with filling, or one that continues such a run",
               .hint = "runs must not be edited: restore it from a copy, or cut again"});
}

Expected<MaterialBricks> readBeginMaterials(const fs::path& run_folder, const RunManifest& manifest) {
  if (manifest.begin_sha256.empty()) return MaterialBricks{};
  const fs::path file = run_folder / internal::kRunBegin;
  KERF_CHECK(requireSha256(file, manifest.begin_sha256, "runs must not be edited: restore it from a copy"));
  return readMaterialBricks(file);
}

Expected<MaterialField> readRunLabels(const fs::path& case_folder, const MaterialBricks& added) {
  KERF_TRY(manifest, readCaseManifest(case_folder));
  KERF_TRY(in_case, readCaseMaterials(case_folder));
  if (added.isEmpty()) return in_case;

  KERF_TRY(table, readDefaultMaterials());
  KERF_CHECK(requireSameMaterials(added, table));
  KERF_CHECK(requireOnlyAdded(added, in_case, fallbackOf(manifest)));
  return laidOver(std::move(in_case), added);
}

Expected<std::optional<BrickField>> readRunBegin(const fs::path& run_folder, const RunManifest& manifest,
                                                 std::size_t beside) {
  KERF_CHECK(internal::requireBeside(run_folder, manifest, beside));
  if (manifest.begin_sha256.empty()) return std::optional<BrickField>{};
  if (beside > 0 && !manifest.beside[beside - 1].has_begin) return std::optional<BrickField>{};
  const fs::path file = run_folder / internal::kRunBegin;
  KERF_CHECK(requireSha256(file, manifest.begin_sha256, "runs must not be edited: restore it from a copy"));
  KERF_TRY(field, readGrid(file, beside == 0 ? "phi" : neighbourId(beside)));
  return std::optional(std::move(field));
}

}  // namespace kerf
