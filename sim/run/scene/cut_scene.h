// Inputs of a cut against resistance: the cases, the tool and the path, read and checked.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/case/case_bundle.h"
#include "geometry/field/material.h"
#include "geometry/field/material_bricks.h"
#include "geometry/tool/tool.h"
#include "sim/hand/path.h"
#include "sim/object/baked_object.h"
#include "sim/run/files/run_manifest.h"
#include "sim/step/step.h"

namespace kerf::internal {

/// Inputs read before anything is written: cheap, so that a wrong name fails at once.
struct CutInputs {
  std::vector<std::filesystem::path> folders;  ///< of the cases: the one to be cut first, then its neighbours
  std::vector<CaseManifest> manifests;         ///< of these cases
  std::vector<std::string> paths;              ///< of these cases, as seen from the run
  std::filesystem::path from;                  ///< the run to continue; empty: none
  RunManifest before;                          ///< of that run: its neighbours come first
  std::filesystem::path tool_file, path_file;
  Tool tool;
  CutPath path;
};

/// @param case_folder  or an ended run to continue.
/// @param beside  further neighbours, after those of that run.
/// Errors: kUnsupported for an open run; kBadValue for too many cases, and for a case given twice; those of the
/// readers.
Expected<CutInputs> readInputs(const std::filesystem::path& case_folder,
                               const std::vector<std::filesystem::path>& beside, const std::filesystem::path& tool_file,
                               const std::filesystem::path& path_file, const std::filesystem::path& run_folder);

/// The same with the fields of the cases in memory, and the step's model.
struct CutScene {
  CutInputs inputs;
  LoadedObjects objects;  ///< of inputs.folders, in their order
  MaterialTable materials;
  Model model;
  /// For a cut that continues a run: the fields, before that run, of the cases that it had cut. Other cases: see
  /// objects.
  std::vector<BrickField> originals;
  MaterialBricks added;         ///< for a cut that continues a run: readRunMaterials() of that run
  double added_before_mm3 = 0;  ///< RunManifest::added_before_mm3

  bool goesOn() const { return !inputs.from.empty(); }
  const BakedObject& object() const { return *objects.front(); }  ///< the case to be cut
  Rigid3 start() const;                                           ///< pose of the tool at the start of its path
};

/// Error kNotFound: a material of a case that the table of materials no longer has.   @cost seconds for a whole jaw.
Expected<CutScene> loadScene(CutInputs inputs, const StepSettings& settings);

}  // namespace kerf::internal
