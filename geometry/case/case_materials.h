// Compares a case with the table of materials of a cut.
#pragma once

#include <filesystem>

#include "geometry/base/error.h"
#include "geometry/case/case_bundle.h"
#include "geometry/field/material.h"
#include "geometry/field/material_bricks.h"

namespace kerf {

/// The voxels of a case hold numbers, and the table defines their meaning: with another table Kerf would cut gum as
/// resin. Error kUnsupported, naming number and both ids: a number of the case has another id in the table, or none.
Expected<void> requireSameMaterials(const std::filesystem::path& case_folder, const CaseManifest& manifest,
                                    const MaterialTable& table);

/// Material of unlabelled nodes of a case: its first material.
Material fallbackOf(const CaseManifest& manifest);

/// As requireSameMaterials(), for material added to a case, as stored in a run.
Expected<void> requireSameMaterials(const MaterialBricks& added, const MaterialTable& table);

}  // namespace kerf
