// Reads what lies in a run folder beside its manifest: the way to its cases, the sweep, the cut fields.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/field/brick_field.h"
#include "geometry/field/material_bricks.h"
#include "sim/run/run_manifest.h"

namespace kerf {

/// Where else to look for the cases of runs, before the places that the runs name: those that the user of a program
/// gave it (kerf export RUN --case FOLDER). One counts if its id is the one in the run. Called once, before runs are
/// read, by a program; not by libraries.
void setPlacesOfCases(std::vector<std::filesystem::path> folders);

/// The folder of the case a run was cut from. An error if it is not there, or was baked anew since.
Expected<std::filesystem::path> caseOfRun(const std::filesystem::path& run_folder);
/// The same of the cases that stood beside it, in their order; none in most runs.
Expected<std::vector<std::filesystem::path>> casesBesideRun(const std::filesystem::path& run_folder);

// Of all grids that follow: noise, which is no distance, is refused by the grid's name (requireDistancesOfCut()).

/// The union of the tool's sweeps, mm, negative where the tool has been; cut out of the case's field it is the cut
/// object. Checked against the manifest. At the voxel size the run was cut at: the case's, or its region's finer one.
/// Only of a run cut geometry-only.
Expected<BrickField> readRunSweep(const std::filesystem::path& run_folder);
/// The cut field phi, mm, in the bricks where it differs from the baked one; of either kind of run.
/// @param beside  0: of the case; n: of the n-th case beside it, which may have no such bricks.
Expected<BrickField> readRunCutField(const std::filesystem::path& run_folder, std::size_t beside = 0);

/// Refuses a cut field with material where the case has none: nothing comes back that was cut, so that such a grid is
/// of another case, or made up. Let through: a run that says that it added some (kerf cut --add; added_mm3 in
/// summary.json, or the command in its log, which a branch of such a run has), and what the run before had where this
/// one went on (begin.vdb).
/// @param cut  of readRunCutField().   @param phi0  of its case, or of the one beside it.
/// Error kBadValue by the grid's name, with a place.   @cost  1 us a brick of the cut, and reading begin.vdb; before
/// material is refused, reading the log.
Expected<void> requireOnlyTaken(const std::filesystem::path& run_folder, const RunManifest& manifest,
                                const BrickField& cut, const BrickField& phi0, std::size_t beside = 0);

/// What a session began with: the bricks of begin.vdb, checked against the manifest. None: it began with the case.
/// @param beside  as of readRunCutField().
Expected<std::optional<BrickField>> readRunBegin(const std::filesystem::path& run_folder, const RunManifest& manifest,
                                                 std::size_t beside = 0);

/// The materials of the case where something was added to it, in this run or in one before it: grid `material` of
/// run.vdb. Empty: nothing was, or an older Kerf cut it, which kept none. Checked against the manifest, and not against
/// the case: loadObject() does that.
/// Error kBadValue, by the grid's name: the run never added anything, nor did the one that it goes on from.
/// @cost  of a session that was not told to add, as far as begin.vdb tells: reading its log.
Expected<MaterialBricks> readRunMaterials(const std::filesystem::path& run_folder);
/// The same of what a session began with: of begin.vdb.
Expected<MaterialBricks> readBeginMaterials(const std::filesystem::path& run_folder, const RunManifest& manifest);

/// The labels of a run's case as the run left them: its own, and those of what was added.
/// @param case_folder  caseOfRun().   @param added  readRunMaterials().
/// Errors: kBadValue and kUnsupported as of loadObject().
Expected<MaterialField> readRunLabels(const std::filesystem::path& case_folder, const MaterialBricks& added);

namespace internal {

/// Error kNotFound: the run has no n-th case beside the one that was cut. 0 is always there.
Expected<void> requireBeside(const std::filesystem::path& run_folder, const RunManifest& manifest, std::size_t beside);

/// The folder of a run's case, or of the n-th one beside it.   @pre requireBeside().
Expected<std::filesystem::path> locateCase(const std::filesystem::path& run_folder, const RunManifest& manifest,
                                           std::size_t beside);

}  // namespace internal
}  // namespace kerf
