#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>

#include "geometry/base/atomic_file.h"
#include "geometry/base/hash.h"
#include "preprocess/bake/bake.h"
#include "preprocess/bake/bake_job.h"
#include "preprocess/bake/bake_sources.h"
#include "preprocess/bake/case_recipe.h"
#include "preprocess/volume/label_surface.h"
#include "preprocess/volume/label_volume.h"
#include "preprocess/voxelize/voxel_union.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using internal::BakeJob;

// The recipe's settings, unless the caller overrides them.
BakeOptions optionsOf(const CaseRecipe& recipe, const BakeOptions& asked) {
  BakeOptions options = asked;
  if (!asked.voxel_is_given && recipe.voxel_mm) options.voxelize.voxel_mm = *recipe.voxel_mm;
  if (options.unit.empty()) options.unit = recipe.unit;
  if (asked.close.drop_specks_mm3 == 0) options.close.drop_specks_mm3 = recipe.drop_specks_mm3;
  options.voxelize.material = recipe.fallback;
  if (!asked.region) options.region = recipe.region;
  return options;
}

Expected<void> refuseTrims(const fs::path& recipe_file, const CloseOptions& close) {
  if (close.trims.empty()) return {};
  return fail({.code = Error::Code::kBadValue,
               .file = recipe_file.string(),
               .place = "--trim",
               .found = "cuts for a recipe",
               .expected = "one scan: the parts of a recipe are solids",
               .hint = "kerf bake PART --trim FILE -o part.case, then kerf export part.case -o part.ply, and name that "
                       "in the recipe"});
}

Expected<void> refuseBase(const fs::path& recipe_file, const CloseOptions& close) {
  const bool asks_base = close.only.empty() ? close.mode == CloseMode::kBase : close.only.count(CloseStep::kBase) > 0;
  if (!asks_base) return {};
  return fail({.code = Error::Code::kBadValue,
               .file = recipe_file.string(),
               .place = "--close",
               .found = "a base for a recipe",
               .expected = "parts that are solids: a base under each would lie between them",
               .hint = "kerf bake PART -o part.case --close base for the part that is open, then kerf export part.case "
                       "-o part.ply, and name that in the recipe"});
}

// The meshes of a recipe, each once: as written, and where they are.
struct MeshFiles {
  std::vector<fs::path> names, paths;
};

MeshFiles meshFilesOf(const CaseRecipe& recipe) {
  MeshFiles files{recipe.meshes(), {}};
  for (const fs::path& name : files.names) files.paths.push_back(recipe.resolve(name));
  return files;
}

// Hashes of the meshes, in their order, then of the label volume.
Expected<std::vector<std::string>> hashInputs(const CaseRecipe& recipe, const MeshFiles& meshes) {
  std::vector<fs::path> all = meshes.paths;
  if (recipe.labels) all.push_back(recipe.resolve(recipe.labels->volume));

  std::vector<std::string> hashes;
  for (const fs::path& path : all) {
    auto hash = internal::sha256OfSource(path);
    if (!hash) {
      if (hash.error().code == Error::Code::kNotFound)
        hash.error().hint = fmt::format("{} names it; paths in a recipe are relative to it", recipe.file.string());
      return fail(hash.error());
    }
    hashes.push_back(*hash);
  }
  return hashes;
}

// The recipe itself, and the numbers of its materials in the grid.
Expected<std::string> textForId(const CaseRecipe& recipe) {
  KERF_TRY(hash, sha256OfFile(recipe.file));
  std::string text = hash + '\n';
  for (const RecipePart& p : recipe.parts)
    text += fmt::format("{} {}\n", p.material.id, static_cast<int>(p.material.material));
  return text;
}

Expected<void> storeRecipe(const fs::path& recipe_file, const fs::path& case_folder) {
  return copyFile(recipe_file, case_folder / kCaseRecipe);
}

// readMeshSources() treats every given unit as one from the command line.
void creditUnitToRecipe(CaseManifest& manifest) {
  constexpr std::string_view kAsked = "set with --unit";
  for (CaseSource& source : manifest.sources)
    if (source.unit_reason.starts_with(kAsked)) source.unit_reason.replace(0, kAsked.size(), "set in the recipe");
}

// Result of the label volume: the surface around all tissue, and the label of a place.
struct LabelObject {
  std::shared_ptr<const SmoothLabels> labels;
  Mesh surface;
  std::string cut;  // textOfCutLabels()
};

std::vector<std::uint16_t> labelsOf(const CaseRecipe& recipe) {
  std::vector<std::uint16_t> wanted;
  for (const RecipePart& p : recipe.parts)
    if (p.label && std::find(wanted.begin(), wanted.end(), *p.label) == wanted.end()) wanted.push_back(*p.label);
  return wanted;
}

Expected<SmoothLabels> smoothLabels(const CaseRecipe& recipe, const fs::path& path, const LabelVolume& volume,
                                    const Progress& progress) {
  SmoothLabelOptions options;
  if (recipe.labels->smoothing_voxels) options.smoothing_voxels = *recipe.labels->smoothing_voxels;
  auto smoothed = SmoothLabels::create(volume, labelsOf(recipe), options, progress);
  if (!smoothed && smoothed.error().file.empty()) smoothed.error().file = path.string();
  return smoothed;
}

std::vector<std::string> notesOn(const LabelVolume& volume, const SmoothLabels& labels) {
  std::vector<std::string> notes;
  if (volume.is_spacing_given)
    notes.push_back(fmt::format("spacing {} x {} x {} mm, from the recipe", volume.spacing[0], volume.spacing[1],
                                volume.spacing[2]));
  for (const LabelVolumeReport& r : labels.reports())
    if (r.pieces_now != r.pieces)
      notes.push_back(fmt::format("smoothing left label {} in {} pieces; it had {}", r.label, r.pieces_now, r.pieces));
  return notes;
}

// Reads the label volume, smooths its labels and stores it in the case.
Expected<LabelObject> readLabels(const CaseRecipe& recipe, const std::string& hash, const fs::path& case_folder,
                                 BakeReport& out, const Progress& progress) {
  const fs::path path = recipe.resolve(recipe.labels->volume);
  LabelReadOptions read;
  read.spacing_mm = recipe.labels->spacing_mm;
  read.threshold = recipe.labels->threshold;
  KERF_TRY(volume, readLabelVolume(path, read, partOf(progress, 0, 0.3)));
  KERF_TRY(smoothed, smoothLabels(recipe, path, volume, partOf(progress, 0.3, 0.8)));
  LabelObject object;
  object.labels = std::make_shared<const SmoothLabels>(std::move(smoothed));
  KERF_TRY(surface, object.labels->surface());
  object.surface = std::move(surface);
  object.cut = textOfCutLabels(volume, labelsOf(recipe));

  KERF_TRY(source, internal::storeSource(path, volume.format, hash, case_folder, out.manifest));
  source->unit = "mm";
  source->unit_reason = "as label volumes are";
  out.unit_is_doubtful.push_back(false);
  out.notes.push_back(notesOn(volume, *object.labels));
  return object;
}

// Error of closing for one part of a recipe.
Error errorOfPart(Error e, const fs::path& path, const fs::path& name) {
  if (e.file.empty()) e.file = path.string();
  if (e.hint.starts_with("--close") && e.hint.find("base") != e.hint.npos) {  // not for a recipe: see refuseBase()
    e.expected = "a solid, as every part of a recipe";
    e.hint = fmt::format(
        "kerf bake {0} -o {1}.case --close base, then kerf export {1}.case -o {1}.ply, and name that in the recipe",
        path.string(), name.stem().string() + "-closed");
  }
  return e;
}

// Each mesh as a separate solid, by its name, for the claims.
struct Solids {
  std::map<fs::path, Mesh> of;
  std::vector<std::string> changes, warnings;  // of closing them, after the name of the file
};

Expected<Solids> closeParts(const MeshFiles& files, const std::vector<Mesh>& meshes, const BakeJob& job) {
  CloseOptions close = job.options.close;
  if (close.mode == CloseMode::kAuto) close.mode = CloseMode::kRepair;  // a part has no missing underside
  close.drop_specks_mm3 = 0;                                            // only of the object
  Solids solids;
  for (std::size_t n = 0; n < files.names.size(); ++n) {
    auto solid = closeMesh(meshes[n], close, partOf(job.progress, 0.15, 0.2));
    if (!solid) return fail(errorOfPart(solid.error(), files.paths[n], files.names[n]));
    const std::string file = files.names[n].filename().string() + ": ";
    for (const std::string& change : solid->report.changes) solids.changes.push_back(file + change);
    for (const std::string& warning : solid->report.warnings) solids.warnings.push_back(file + warning);
    solids.of.emplace(files.names[n], std::move(solid->mesh));
  }
  return solids;
}

// The meshes whose union is the object.
std::vector<Mesh> outlineOf(const CaseRecipe& recipe, const MeshFiles& files, const Solids& solids,
                            const LabelObject& labels) {
  std::vector<Mesh> outline;
  for (const fs::path& name : recipe.outline.empty() ? files.names : recipe.outline)
    outline.push_back(solids.of.at(name));
  if (recipe.labels && recipe.outline.empty()) outline.push_back(labels.surface);
  return outline;
}

// The object's surface: an exact union of its parts, or one rebuilt from their distance fields.
Expected<Mesh> unite(const std::vector<Mesh>& parts, const BakeOptions& options, BakeReport& out,
                     const Progress& progress) {
  CloseOptions close = options.close;
  if (close.mode == CloseMode::kAuto) close.mode = CloseMode::kRepair;
  close.accept_doubtful = true;  // judged part by part; a union loses nested parts
  auto exact = closeMeshes(parts, close, partOf(progress, 0, 0.5));
  if (exact && exact->report.exact) {
    out.close = exact->report;
    return std::move(exact->mesh);
  }
  if (!exact && (exact.error().code == Error::Code::kCancelled || parts.size() < 2)) return fail(exact.error());

  // Finer than this the surface gains microns and the mesh millions of triangles.
  const double voxel = std::max(options.voxelize.voxel_mm, 0.1);
  KERF_TRY(rebuilt, voxelUnion(parts, voxel, partOf(progress, 0.5, 0.8)));
  const std::string changes = fmt::format(
      "no exact union of the {} parts could be made ({}): the surface was REBUILT from their distance fields at {} mm; "
      "it lies {:.4f} mm rms, {:.3f} mm at most from the parts', gaps between them up to {:.3g} mm are closed",
      parts.size(), exact ? "it would have been a shrink-wrap" : exact.error().found, voxel, rebuilt.rms_off_mm,
      rebuilt.largest_off_mm, 2 * voxel);

  KERF_TRY(solid, closeMesh(rebuilt.mesh, close, partOf(progress, 0.8, 1)));
  out.close = solid.report;
  out.close.exact = false;
  out.close.changes.insert(out.close.changes.begin(), changes);
  return std::move(solid.mesh);
}

// unite(), entered in the manifest after the changes of closing the parts.
Expected<Mesh> uniteParts(const std::vector<Mesh>& outline, const Solids& solids, BakeJob& job) {
  if (!report(job.progress, 0.2, "uniting parts")) return cancelledBeforeWriting();
  KERF_TRY(solid, unite(outline, job.options, job.report, partOf(job.progress, 0.2, 0.3)));
  std::vector<std::string>& changes = job.report.manifest.changes;
  changes = solids.changes;
  changes.insert(changes.end(), job.report.close.changes.begin(), job.report.close.changes.end());
  std::vector<std::string>& warnings = job.report.close.warnings;
  warnings.insert(warnings.begin(), solids.warnings.begin(), solids.warnings.end());
  job.report.manifest.exact = job.report.close.exact;
  return std::move(solid);
}

// Where each part is, in order of priority; the manifest gets a row for each. Points to the solids.
std::vector<MaterialClaim> claimsOf(const CaseRecipe& recipe, const Solids& solids, const LabelObject& labels,
                                    CaseManifest& manifest) {
  std::vector<MaterialClaim> claims;
  for (const RecipePart& p : recipe.parts) {
    MaterialClaim claim;
    claim.material = p.material.material;
    claim.replaces = p.replaces;
    claim.depth = p.depth;
    CasePart row{p.material.id, p.origin(), 0, 0};
    if (!p.mesh.empty()) {
      claim.solid = &solids.of.at(p.mesh);
      row.own_mm3 = signedVolume(*claim.solid);
    } else if (p.label) {
      claim.covers = [smooth = labels.labels, label = *p.label](const Vec3d& x) { return smooth->labelAt(x) == label; };
      for (const LabelVolumeReport& r : labels.labels->reports())
        if (r.label == *p.label) row.own_mm3 = r.counted_mm3;
    }
    claims.push_back(std::move(claim));
    manifest.parts.push_back(std::move(row));
  }
  return claims;
}

}  // namespace

Expected<BakeReport> bakeRecipe(const fs::path& recipe_file, const fs::path& case_folder, const BakeOptions& asked,
                                const Progress& progress) {
  BakeJob job{asked, progress};

  // Plan.
  KERF_TRY(materials, readDefaultMaterials());
  KERF_TRY(recipe, readCaseRecipe(recipe_file, materials));
  job.options = optionsOf(recipe, asked);
  KERF_CHECK(internal::settleSizes(job.options));
  KERF_CHECK(refuseBase(recipe_file, job.options.close));
  KERF_CHECK(refuseTrims(recipe_file, job.options.close));
  const MeshFiles files = meshFilesOf(recipe);
  KERF_TRY(hashes, hashInputs(recipe, files));
  KERF_TRY(more, textForId(recipe));

  KERF_TRY(staging, internal::openCase(case_folder, hashes, more, job));
  if (!staging) return std::move(job.report);
  KERF_CHECK(storeRecipe(recipe_file, staging->staging()));
  job.report.times.write += job.watch.lap();

  KERF_TRY(meshes, internal::readMeshSources(files.paths, hashes, job.options.unit, true, staging->staging(),
                                             job.report, partOf(progress, 0, 0.05)));
  if (asked.unit.empty() && !recipe.unit.empty()) creditUnitToRecipe(job.report.manifest);
  if (!recipe.labels) KERF_CHECK(internal::checkObjectSize(files.paths, meshes, false, job.options, job.report));
  auto checks = internal::checkAside(meshes);
  LabelObject labels;
  if (recipe.labels) {
    KERF_TRY(read, readLabels(recipe, hashes.back(), staging->staging(), job.report, partOf(progress, 0.05, 0.15)));
    labels = std::move(read);
  }
  job.report.times.read = job.watch.lap();

  KERF_TRY(solids, closeParts(files, meshes, job));
  if (!labels.cut.empty())
    solids.warnings.push_back("labels touch the faces of their volume, where they are cut off flat: " + labels.cut);
  KERF_TRY(solid, uniteParts(outlineOf(recipe, files, solids, labels), solids, job));
  internal::finishClosing(checks, job);

  const internal::BakeObject object{std::move(solid), claimsOf(recipe, solids, labels, job.report.manifest)};
  KERF_TRY(grids, internal::voxelizeObject(object, materials, job));
  KERF_CHECK(internal::writeCase(object, grids, materials, *staging, job));
  return std::move(job.report);
}

}  // namespace kerf
