// Reads the other contents of a run folder: the way to its cases, the sweep, the cut fields.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/field/brick_field.h"
#include "geometry/field/material_bricks.h"
#include "sim/run/files/run_manifest.h"

namespace kerf {

/// Extra places to look for the cases of runs, before the places named in the runs: those that the user gave (kerf
/// export RUN --case FOLDER). A folder counts if its id is the one in the run. Programs, not libraries, call this once
/// before reading runs.
void setPlacesOfCases(std::vector<std::filesystem::path> folders);

/// The folder of the case a run was cut from. Error if it is missing, or was baked anew since.
Expected<std::filesystem::path> caseOfRun(const std::filesystem::path& run_folder);
/// The same for its neighbours, in their order; none in most runs.
Expected<std::vector<std::filesystem::path>> casesBesideRun(const std::filesystem::path& run_folder);

// All grids below: noise that is no distance gives an error with the grid's name (requireDistancesOfCut()).

/// The union of the tool's sweeps, mm, negative where the tool has been. Subtracting it from the case's field gives the
/// cut object. Checked against the manifest. At the voxel size of the cut: the case's, or its region's finer one.
/// Geometry-only runs only.
Expected<BrickField> readRunSweep(const std::filesystem::path& run_folder);
/// The cut field phi, mm, in the bricks where it differs from the baked one; for either kind of run.
/// @param beside  0: of the case; n: of its n-th neighbour, which may have no such bricks.
Expected<BrickField> readRunCutField(const std::filesystem::path& run_folder, std::size_t beside = 0);

/// Rejects a cut field with material where the case has none: a cut never adds material, so such a grid belongs to
/// another case or is made up. Accepted: material that the run says it added (kerf cut --add; added_mm3 in
/// summary.json, or the command in its log, for a branch of such a run), and material at the start of a continued run
/// (begin.vdb).
/// @param cut  of readRunCutField().   @param phi0  of its case, or of the neighbour.
/// Error kBadValue with the grid's name and a place.   @cost  1 us a brick of the cut, and reading begin.vdb; also
/// reading the log before it rejects.
Expected<void> requireOnlyTaken(const std::filesystem::path& run_folder, const RunManifest& manifest,
                                const BrickField& cut, const BrickField& phi0, std::size_t beside = 0);

/// The field at the start of a session: the bricks of begin.vdb, checked against the manifest. None: the session began
/// with the case.
/// @param beside  as in readRunCutField().
Expected<std::optional<BrickField>> readRunBegin(const std::filesystem::path& run_folder, const RunManifest& manifest,
                                                 std::size_t beside = 0);

/// The materials of the case in bricks with added material, from this run or an earlier one: grid `material` of
/// run.vdb. Empty: nothing was added, or an older Kerf, which stored none, cut the run. Checked against the manifest,
/// but not against the case: loadObject() does that.
/// Error kBadValue with the grid's name: neither this run nor the run before it added anything.
/// @cost  reads the log of a session if begin.vdb shows no command to add.
Expected<MaterialBricks> readRunMaterials(const std::filesystem::path& run_folder);
/// The same for the start of a session: from begin.vdb.
Expected<MaterialBricks> readBeginMaterials(const std::filesystem::path& run_folder, const RunManifest& manifest);

/// The labels of a run's case at the end of the run: its own, and those of added material.
/// @param case_folder  caseOfRun().   @param added  readRunMaterials().
/// Errors: kBadValue and kUnsupported as in loadObject().
Expected<MaterialField> readRunLabels(const std::filesystem::path& case_folder, const MaterialBricks& added);

namespace internal {

/// Error kNotFound: the run has no n-th neighbour. 0, the case, always exists.
Expected<void> requireBeside(const std::filesystem::path& run_folder, const RunManifest& manifest, std::size_t beside);

/// The folder of a run's case, or of its n-th neighbour.   @pre requireBeside().
Expected<std::filesystem::path> locateCase(const std::filesystem::path& run_folder, const RunManifest& manifest,
                                           std::size_t beside);

}  // namespace internal
}  // namespace kerf
