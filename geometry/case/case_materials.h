// A case against the table of materials it is cut with.
#pragma once

#include <filesystem>

#include "geometry/base/error.h"
#include "geometry/case/case_bundle.h"
#include "geometry/field/material.h"
#include "geometry/field/material_bricks.h"

namespace kerf {

/// The voxels of a case hold numbers, and what a number means is the table's word: with another table gum would be cut
/// as resin. Error kUnsupported, naming number and both ids: a number of the case has another id in the table, or none.
Expected<void> requireSameMaterials(const std::filesystem::path& case_folder, const CaseManifest& manifest,
                                    const MaterialTable& table);

/// What a node of a case without a label is of: its first material.
Material fallbackOf(const CaseManifest& manifest);

/// As requireSameMaterials(), of what was added to a case, as a run keeps it.
Expected<void> requireSameMaterials(const MaterialBricks& added, const MaterialTable& table);

}  // namespace kerf
