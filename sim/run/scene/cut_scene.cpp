#include "sim/run/scene/cut_scene.h"

#include <fmt/format.h>

#include <optional>
#include <span>
#include <utility>

#include "geometry/tool/tool_file.h"
#include "sim/hand/virtual_hand.h"
#include "sim/run/files/removed_volumes.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_output.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

Expected<void> addCase(CutInputs& inputs, const fs::path& folder, const fs::path& run_folder) {
  KERF_TRY(manifest, readCaseManifest(folder));
  for (std::size_t n = 0; n < inputs.manifests.size(); ++n)
    if (inputs.manifests[n].id == manifest.id)
      return fail({.code = Error::Code::kBadValue,
                   .file = folder.string(),
                   .place = "--beside",
                   .found = "the same case as " + inputs.folders[n].string() + ": two solids in one place",
                   .expected = "another tooth or jaw of the same scan frame",
                   .hint = "give each case only once"});
  KERF_TRY(path, relativeCasePath(folder, run_folder));
  inputs.folders.push_back(folder);
  inputs.manifests.push_back(std::move(manifest));
  inputs.paths.push_back(std::move(path));
  return {};
}

// Inputs of a continued run: its case, and its neighbours.
Expected<void> addRun(CutInputs& inputs, const fs::path& run, const fs::path& run_folder) {
  KERF_CHECK(requireAnother(run, run_folder));
  KERF_TRY(before, readRunManifest(run));
  KERF_CHECK(requireEnded(run, before));
  KERF_TRY(of_run, caseOfRun(run));
  KERF_CHECK(addCase(inputs, of_run, run_folder));
  KERF_TRY(beside, casesBesideRun(run));
  for (const fs::path& folder : beside) KERF_CHECK(addCase(inputs, folder, run_folder));
  inputs.from = run;
  inputs.before = std::move(before);
  return {};
}

Expected<void> requireTissues(const CutScene& scene) {
  for (std::size_t n = 0; n < scene.objects.size(); ++n)
    for (std::size_t m = 0; m < scene.model.tissues.size(); ++m)
      if (scene.objects[n]->volumes()[m] > 0 && !scene.model.tissues[m].is_in_table)
        return fail({.code = Error::Code::kNotFound,
                     .file = scene.inputs.folders[n].string(),
                     .place = fmt::format("material {}", m),
                     .found = "not in the table of materials",
                     .expected = "a row with its cutting properties; there are " + scene.materials.ids(),
                     .hint = "KERF_ASSETS, or bake the case again"});
  return {};
}

}  // namespace

Expected<CutInputs> readInputs(const fs::path& case_folder, const std::vector<fs::path>& beside,
                               const fs::path& tool_file, const fs::path& path_file, const fs::path& run_folder) {
  CutInputs inputs;
  if (isRun(case_folder))
    KERF_CHECK(addRun(inputs, case_folder, run_folder));
  else
    KERF_CHECK(addCase(inputs, case_folder, run_folder));
  if (inputs.folders.size() + beside.size() > kMostObjects)
    return fail({.code = Error::Code::kBadValue,
                 .place = "--beside",
                 .found = fmt::format("{} cases", inputs.folders.size() - 1 + beside.size()),
                 .expected = fmt::format("at most {}", kMostObjects - 1),
                 .hint = "the nearest ones"});
  for (const fs::path& folder : beside) KERF_CHECK(addCase(inputs, folder, run_folder));
  KERF_TRY(tool, readTool(tool_file));
  KERF_TRY(path, readPath(path_file));
  inputs.tool_file = tool_file;
  inputs.path_file = path_file;
  inputs.tool = std::move(tool);
  inputs.path = std::move(path);
  return inputs;
}

Rigid3 CutScene::start() const { return poseAt(inputs.path, 0); }

Expected<CutScene> loadScene(CutInputs inputs, const StepSettings& settings) {
  LoadedObjects objects;
  std::vector<BrickField> originals;
  MaterialBricks added;
  double added_before = 0;
  for (std::size_t n = 0; n < inputs.folders.size(); ++n) {
    const bool was_cut = !inputs.from.empty() && n <= inputs.before.beside.size();
    std::optional<BrickField> begin;
    if (was_cut) {
      KERF_TRY(cut_before, readRunCutField(inputs.from, n));
      KERF_TRY(of_case, readCaseField(inputs.folders[n]));
      begin = std::move(cut_before);
      if (n == 0) {
        KERF_TRY(materials, readRunMaterials(inputs.from));
        added = std::move(materials);
      }
      originals.push_back(std::move(of_case));
    }
    KERF_TRY(object, loadObject(inputs.folders[n], begin ? &*begin : nullptr, n == 0 ? &added : nullptr));
    objects.push_back(std::move(object));
    if (!was_cut) continue;

    // On the same voxels: loadObject() checked it.
    KERF_CHECK(requireOnlyTaken(inputs.from, inputs.before, *begin, originals.back(), n));
    if (n == 0) added_before = addedVolume(originals.back(), *begin, added);
  }
  KERF_TRY(materials, readDefaultMaterials());
  KERF_TRY(model, makeModel(std::span(&inputs.tool, 1), settings, widestBand(objects)));
  CutScene scene{std::move(inputs),    std::move(objects), std::move(materials), std::move(model),
                 std::move(originals), std::move(added),   added_before};
  KERF_CHECK(requireTissues(scene));
  return scene;
}

}  // namespace kerf::internal
