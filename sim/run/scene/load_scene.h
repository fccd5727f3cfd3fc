// Loads the step's inputs from files.
#pragma once

#include <filesystem>
#include <span>

#include "geometry/case/case_bundle.h"
#include "geometry/field/material_bricks.h"
#include "geometry/tool/tool.h"
#include "sim/step/step.h"

namespace kerf {

/// The object of a case with its labels; unlabelled nodes get the case's first material. Checked against the manifest's
/// hashes. @cost seconds for a whole jaw.
/// @param begin  bricks changed by an earlier session that this one continues. Null: as the case. Error kBadValue for
///   another voxel size.
/// @param added  materials added in that session: readRunMaterials(). Null: none. Errors kBadValue and kUnsupported for
///   materials of another case, or of another table of materials.
Expected<std::shared_ptr<const BakedObject>> loadObject(const std::filesystem::path& case_folder,
                                                        const BrickField* begin = nullptr,
                                                        const MaterialBricks* added = nullptr);

/// Half-width of the widest band of the objects, mm: for makeModel().
double widestBand(std::span<const std::shared_ptr<const BakedObject>> objects);

/// Tools, tissues by the program's own table, settings. @param band_mm  widestBand() of the objects the tools meet.
Expected<Model> makeModel(std::span<const Tool> tools, const StepSettings& settings = {}, double band_mm = 0.5);

}  // namespace kerf
