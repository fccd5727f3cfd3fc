// From files to what the step works on.
#pragma once

#include <filesystem>
#include <span>

#include "geometry/case/case_bundle.h"
#include "geometry/field/material_bricks.h"
#include "geometry/tool/tool.h"
#include "sim/step/step.h"

namespace kerf {

/// The object of a case with its labels; unlabelled nodes are of the case's first material. Checked against the
/// manifest's hashes. @cost seconds for a whole jaw.
/// @param begin  bricks in which it differs already: it goes on from an earlier session. Null: as the case is. Error
/// kBadValue if their voxels are others.
/// @param added  the materials of what was added in that session: readRunMaterials(). Null: all is as in the case.
/// Errors kBadValue and kUnsupported if they are not of this case, or of another table of materials.
Expected<std::shared_ptr<const BakedObject>> loadObject(const std::filesystem::path& case_folder,
                                                        const BrickField* begin = nullptr,
                                                        const MaterialBricks* added = nullptr);

/// Half-width of the widest of their bands, mm: what makeModel() asks for.
double widestBand(std::span<const std::shared_ptr<const BakedObject>> objects);

/// Tools, tissues by the program's own table, settings. @param band_mm  widestBand() of the objects the tools meet.
Expected<Model> makeModel(std::span<const Tool> tools, const StepSettings& settings = {}, double band_mm = 0.5);

}  // namespace kerf
