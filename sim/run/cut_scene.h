// What a cut against resistance starts from: the cases, the tool and the path, read and checked.
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
#include "sim/run/run_manifest.h"
#include "sim/step/step.h"

namespace kerf::internal {

/// What is read before anything is written: cheap, so that a wrong name is told at once.
struct CutInputs {
  std::vector<std::filesystem::path> folders;  ///< of the cases: the one to be cut first, then those beside it
  std::vector<CaseManifest> manifests;         ///< of the same
  std::vector<std::string> paths;              ///< the same as seen from the run
  std::filesystem::path from;                  ///< the run that is gone on from; empty: none
  RunManifest before;                          ///< of that run: its neighbours are the first that stand beside
  std::filesystem::path tool_file, path_file;
  Tool tool;
  CutPath path;
};

/// @param case_folder  or a run that has ended, from which it goes on.
/// @param beside  further cases, behind those that stood in that run.
/// Errors: kUnsupported for a run that is open; kBadValue for too many cases, and for one that is given twice; those of
/// the readers.
Expected<CutInputs> readInputs(const std::filesystem::path& case_folder,
                               const std::vector<std::filesystem::path>& beside, const std::filesystem::path& tool_file,
                               const std::filesystem::path& path_file, const std::filesystem::path& run_folder);

/// The same with the fields of the cases in memory, and what the step needs to know.
struct CutScene {
  CutInputs inputs;
  LoadedObjects objects;  ///< of inputs.folders, in their order
  MaterialTable materials;
  Model model;
  /// Of a cut that goes on: the fields of the cases that the run before had cut, as they were before that. The others,
  /// and all without such a run: objects has it.
  std::vector<BrickField> originals;
  MaterialBricks added;         ///< of a cut that goes on: readRunMaterials() of the run before
  double added_before_mm3 = 0;  ///< RunManifest::added_before_mm3

  bool goesOn() const { return !inputs.from.empty(); }
  const BakedObject& object() const { return *objects.front(); }  ///< the one to be cut
  Rigid3 start() const;                                           ///< of the tool, on its path
};

/// Error kNotFound: a material of a case that the table of materials no longer has.   @cost seconds for a whole jaw.
Expected<CutScene> loadScene(CutInputs inputs, const StepSettings& settings);

}  // namespace kerf::internal
