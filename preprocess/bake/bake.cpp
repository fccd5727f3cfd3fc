#include "preprocess/bake/bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <map>
#include <memory>
#include <set>
#include <span>

#include "geometry/base/atomic_file.h"
#include "geometry/base/hash.h"
#include "geometry/base/version.h"
#include "geometry/formats/mesh_writer.h"
#include "preprocess/bake/bake_sources.h"
#include "preprocess/bake/case_recipe.h"
#include "preprocess/volume/label_surface.h"
#include "preprocess/volume/label_volume.h"
#include "preprocess/voxelize/voxel_union.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

const char* nameOf(CloseMode mode) {
  switch (mode) {
    case CloseMode::kAuto:
      return "auto";
    case CloseMode::kBase:
      return "base";
    case CloseMode::kRepair:
      return "repair";
    case CloseMode::kWrap:
      return "wrap";
  }
  return "?";
}

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double s = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return s;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// A part of the whole job's progress.
Progress part(const Progress& whole, double from, double to) {
  if (!whole) return {};
  return [whole, from, to](double f, std::string_view what) { return whole(from + f * (to - from), what); };
}

tl::unexpected<Error> cancelError() {
  return fail({Error::Code::kCancelled, "", "", "cancelled; nothing was written", "", ""});
}

// Raised by every change of what a bake makes of the same inputs.
constexpr int kBakeRevision = 3;

// Everything the result depends on: the same id, the same case.
std::string caseId(std::span<const std::string> hashes, const BakeOptions& o, const std::string& more) {
  std::string text = fmt::format("kerf-case {} {}\n", kBakeRevision, kVersion);
  for (const std::string& hash : hashes) text += hash + '\n';
  text += more;
  text += fmt::format("{} {} {}\n", o.unit, nameOf(o.close.mode), canonicalText(o.close));
  text += fmt::format("{} {} {} {} {}\n", o.voxelize.voxel_mm, o.voxelize.exterior_voxels, o.voxelize.interior_voxels,
                      o.voxelize.interior_mm, static_cast<int>(o.voxelize.material));
  if (o.region) {
    text += fmt::format("region {} {}", o.region->radius_mm, o.region->voxel_mm);
    for (const Vec3d& p : o.region->line) text += fmt::format(" {} {} {}", p[0], p[1], p[2]);
    text += '\n';
  }
  if (o.pair) text += fmt::format("{} {}\n", o.pair->frame, o.pair->partner);
  return sha256(std::as_bytes(std::span(text.data(), text.size())));
}

// Fills in the sizes that are left to the program, and refuses what can not be.
Expected<void> settleSizes(BakeOptions& o) {
  KERF_CHECK(checkVoxelSize(o.voxelize.voxel_mm));
  o.close.cleanup_length_mm = std::min(0.01 * o.voxelize.voxel_mm, 0.1);
  if (!o.region) return {};
  if (o.region->voxel_mm == 0) o.region->voxel_mm = o.voxelize.voxel_mm / 2;
  KERF_CHECK(checkVoxelSize(o.region->voxel_mm));
  if (o.region->voxel_mm < o.voxelize.voxel_mm) return {};
  return fail({Error::Code::kBadValue, "", "voxel size of the fine region", fmt::format("{} mm", o.region->voxel_mm),
               fmt::format("less than the object's, {} mm", o.voxelize.voxel_mm),
               fmt::format("{}", o.voxelize.voxel_mm / 2)});
}

// A voxel larger than the object holds nothing of it; most often the unit is wrong. Asked before closing, not after.
Expected<void> checkObjectSize(const std::vector<Mesh>& meshes, double voxel_mm, const BakeReport& report) {
  Box3 box;
  for (const Mesh& mesh : meshes) box.add(bounds(mesh));
  const Vec3d size = box.size();
  if (meshes.empty() || !(voxel_mm > size.maxCoeff())) return {};
  const CaseSource& first = report.manifest.sources[0];
  return fail({Error::Code::kBadValue, "", "voxel size",
               fmt::format("{} mm for an object of {:.3g} x {:.3g} x {:.3g} mm (unit {}: {})", voxel_mm, size[0],
                           size[1], size[2], first.unit, first.unit_reason),
               "an object larger than a voxel", "another --unit, or none; or a finer --voxel"});
}

// The case that is there already, if it is this very one and undamaged.
std::optional<CaseManifest> existing(const fs::path& case_folder, const std::string& id) {
  if (!isCase(case_folder)) return {};
  auto manifest = readCaseManifest(case_folder);
  if (!manifest || manifest->id != id || !requireSha256(case_folder / kCaseSolid, manifest->solid_sha256, "") ||
      !requireSha256(case_folder / kCaseAnatomy, manifest->field_sha256, ""))
    return {};
  return std::move(*manifest);
}

// Checks the sources in a thread of its own. The future's destructor waits, so the meshes must outlive it.
std::future<std::vector<MeshReport>> checkAside(const std::vector<Mesh>& sources) {
  return std::async(std::launch::async, [&sources] {
    std::vector<MeshReport> reports;
    for (const Mesh& mesh : sources) reports.push_back(checkMesh(mesh));
    return reports;
  });
}

// What a bake works on, whatever it came from.
struct Object {
  Mesh solid;
  std::vector<MaterialClaim> claims;
};

// Voxelizes and writes; the last steps of every bake.
Expected<void> finish(const Object& object, const BakeOptions& options, const MaterialTable& materials,
                      AtomicFolder& staging, BakeReport& out, Stopwatch& watch, const Progress& progress) {
  const fs::path& folder = staging.staging();
  VoxelizeOptions voxelize_options = options.voxelize;
  for (const MaterialProperties& m : materials.rows())
    voxelize_options.material_names +=
        fmt::format("{}{} {}", voxelize_options.material_names.empty() ? "" : ", ", static_cast<int>(m.material), m.id);
  const double coarse_done = options.region ? 0.6 : 0.85;
  KERF_TRY(anatomy, voxelize(object.solid, voxelize_options, part(progress, 0.3, coarse_done), object.claims));
  std::optional<Anatomy> fine;
  if (options.region) {
    KERF_TRY(made, voxelizeRegion(object.solid, *options.region, voxelize_options, part(progress, coarse_done, 0.85),
                                  object.claims));
    fine = std::move(made);
    out.manifest.region = CaseRegion{*options.region, fine->stats().active_voxels, fine->stats().shell_points,
                                     fine->stats().shell_area_mm2};
  }
  out.times.voxelize = watch.lap();

  CaseManifest& m = out.manifest;
  const AnatomyStats& stats = anatomy.stats();
  m.kerf_version = kVersion;
  m.close_mode = options.close.only.empty() ? nameOf(options.close.mode) : namesOf(options.close.only);
  m.pair = options.pair;
  m.voxel_mm = options.voxelize.voxel_mm;
  std::map<Material, double> volumes;
  for (std::size_t n = 0; n < object.claims.size(); ++n) {
    volumes[object.claims[n].material] += stats.materials.claimed_mm3[n];
    m.parts[n].volume_mm3 = stats.materials.claimed_mm3[n];
  }
  if (object.claims.empty()) volumes[options.voxelize.material] = stats.volume_mm3;
  if (!object.claims.empty()) m.gaps = CaseGaps{stats.materials.unclaimed_mm3, stats.materials.forgotten_mm3};
  if (stats.materials.forgotten_mm3 > 0) volumes[options.voxelize.material] += stats.materials.forgotten_mm3;
  for (const auto& [material, volume] : volumes) {
    const MaterialProperties* row = materials.find(material);
    m.materials.push_back({row ? row->id : "?", static_cast<int>(material), volume});
  }
  m.solid_vertices = object.solid.vertices.size();
  m.solid_triangles = object.solid.triangles.size();
  m.solid_volume_mm3 = signedVolume(object.solid);
  m.solid_area_mm2 = surfaceArea(object.solid);
  m.box = bounds(object.solid);
  m.field_voxels = stats.active_voxels;
  m.shell_points = stats.shell_points;
  m.shell_area_mm2 = stats.shell_area_mm2;
  if (!report(progress, 0.85, "writing")) return cancelError();
  KERF_CHECK(writeMesh(folder / kCaseSolid, object.solid));
  KERF_CHECK(anatomy.write(folder / kCaseAnatomy, fine ? &*fine : nullptr));
  KERF_TRY(solid_hash, sha256OfFile(folder / kCaseSolid));
  KERF_TRY(field_hash, sha256OfFile(folder / kCaseAnatomy));
  m.solid_sha256 = solid_hash;
  m.field_sha256 = field_hash;
  KERF_CHECK(writeCaseManifest(folder, m));
  if (!report(progress, 0.95, "syncing")) return cancelError();
  KERF_CHECK(staging.commit());
  out.times.write += watch.lap();
  report(progress, 1.0, "done");
  return {};
}

// The labels' surface as a mesh; fills what the parts bring and the sampler that tells them apart.
struct LabelObject {
  std::shared_ptr<const SmoothLabels> labels;
  Mesh surface;
};

Expected<LabelObject> readLabels(const CaseRecipe& recipe, const std::string& hash, const fs::path& case_folder,
                                 BakeReport& out, const Progress& progress) {
  const fs::path path = recipe.resolve(recipe.labels->volume);
  LabelReadOptions read;
  read.spacing_mm = recipe.labels->spacing_mm;
  read.threshold = recipe.labels->threshold;
  KERF_TRY(volume, readLabelVolume(path, read, part(progress, 0, 0.3)));
  std::vector<std::uint16_t> wanted;
  for (const RecipePart& p : recipe.parts)
    if (p.label && std::find(wanted.begin(), wanted.end(), *p.label) == wanted.end()) wanted.push_back(*p.label);
  SmoothLabelOptions smooth;
  if (recipe.labels->smoothing_voxels) smooth.smoothing_voxels = *recipe.labels->smoothing_voxels;
  auto smoothed = SmoothLabels::create(volume, wanted, smooth, part(progress, 0.3, 0.8));
  if (!smoothed) {
    if (smoothed.error().file.empty()) smoothed.error().file = path.string();
    return fail(smoothed.error());
  }
  LabelObject object;
  object.labels = std::make_shared<const SmoothLabels>(std::move(*smoothed));
  KERF_TRY(surface, object.labels->surface());
  object.surface = std::move(surface);
  KERF_TRY(source, internal::storeSource(path, volume.format, hash, case_folder, out.manifest));
  source->unit = "mm";
  source->unit_reason = "as label volumes are";
  out.unit_is_doubtful.push_back(false);
  std::vector<std::string> notes;
  if (volume.is_spacing_given)
    notes.push_back(fmt::format("the spacing, {} x {} x {} mm, is the recipe's", volume.spacing[0], volume.spacing[1],
                                volume.spacing[2]));
  for (const LabelVolumeReport& r : object.labels->reports())
    if (r.pieces_now != r.pieces)
      notes.push_back(fmt::format("smoothing left label {} in {} pieces; it had {}", r.label, r.pieces_now, r.pieces));
  out.notes.push_back(std::move(notes));
  return object;
}

// The object's surface: an exact union of its parts, or one rebuilt from their distance fields.
Expected<Mesh> unite(const std::vector<Mesh>& parts, const BakeOptions& options, BakeReport& out,
                     const Progress& progress) {
  CloseOptions close = options.close;
  if (close.mode == CloseMode::kAuto) close.mode = CloseMode::kRepair;
  auto exact = closeMeshes(parts, close, part(progress, 0, 0.5));
  if (exact && exact->report.exact) {
    out.close = exact->report;
    return std::move(exact->mesh);
  }
  if (!exact && (exact.error().code == Error::Code::kCancelled || parts.size() < 2)) return fail(exact.error());
  // Finer than this the surface gains microns and the mesh millions of triangles.
  const double voxel = std::max(options.voxelize.voxel_mm, 0.1);
  KERF_TRY(rebuilt, voxelUnion(parts, voxel, part(progress, 0.5, 0.8)));
  const std::string changes = fmt::format(
      "no exact union of the {} parts could be made ({}): the surface was REBUILT from their distance fields at {} mm; "
      "it lies {:.4f} mm rms, {:.3f} mm at most from the parts', gaps between them up to {:.3g} mm are closed",
      parts.size(), exact ? "it would have been a shrink-wrap" : exact.error().found, voxel, rebuilt.rms_off_mm,
      rebuilt.largest_off_mm, 2 * voxel);
  KERF_TRY(solid, closeMesh(rebuilt.mesh, close, part(progress, 0.8, 1)));
  out.close = solid.report;
  out.close.exact = false;
  out.close.changes.insert(out.close.changes.begin(), changes);
  return std::move(solid.mesh);
}

// Folders that are something, though no mesh.
Expected<void> requireMeshNotFolder(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) return {};
  if (isCase(path)) {
    std::string sources;
    if (const auto manifest = readCaseManifest(path))
      for (const CaseSource& source : manifest->sources)
        sources += (sources.empty() ? ", baked from " : ", ") + source.stored_as;
    return fail({Error::Code::kUnsupported, path.string(), "", "a case already" + sources, "a mesh file or a recipe",
                 sources.empty() ? "kerf info " + path.string()
                                 : "kerf cut takes it as it is; with other settings bake the original file again"});
  }
  if (isLabelVolume(path))
    return fail({Error::Code::kUnsupported, path.string(), "", "a folder of slices: a label volume, no mesh",
                 "a mesh file or a recipe",
                 "a recipe that makes tissues of its labels (docs/reference/recipes.md); kerf info lists them"});
  return {};
}

}  // namespace

Expected<BakeReport> bake(const std::vector<fs::path>& meshes, const fs::path& case_folder, const BakeOptions& asked,
                          const Progress& progress) {
  BakeReport out;
  Stopwatch watch;
  BakeOptions options = asked;
  KERF_CHECK(settleSizes(options));  // before the minutes of closing, not after
  KERF_TRY(materials, readDefaultMaterials());
  std::vector<std::string> hashes;
  for (const fs::path& path : meshes) {
    KERF_CHECK(requireMeshNotFolder(path));
    std::error_code ignored;
    const bool is_volume = fs::is_regular_file(path, ignored) && isLabelVolume(path);  // refused when it is read
    KERF_TRY(hash, is_volume ? sha256OfFile(path) : internal::sha256OfSource(path));
    hashes.push_back(hash);
  }
  out.manifest.id = caseId(hashes, options, "");
  if (!options.overwrite)
    if (auto manifest = existing(case_folder, out.manifest.id)) {
      out.manifest = std::move(*manifest);
      out.was_up_to_date = true;
      return out;
    }
  KERF_TRY(staging, AtomicFolder::create(case_folder, options.overwrite, kCaseManifest));
  out.times.write += watch.lap();
  KERF_TRY(sources, internal::readMeshSources(meshes, hashes, options.unit, true, staging.staging(), out,
                                              part(progress, 0, 0.05)));
  if (auto sized = checkObjectSize(sources, options.voxelize.voxel_mm, out); !sized) {
    if (meshes.size() == 1) sized.error().file = meshes[0].string();
    return fail(sized.error());
  }
  out.times.read = watch.lap();
  // What was wrong with the sources is only for the report: looked at while closing mends it.
  auto checks = checkAside(sources);
  if (!report(progress, 0.05, "closing")) return cancelError();
  auto solid = closeMeshes(sources, options.close, part(progress, 0.05, 0.3));
  if (!solid) {
    if (solid.error().file.empty())
      solid.error().file =
          meshes[0].string() + (meshes.size() > 1 ? fmt::format(" and {} more, as one object", meshes.size() - 1) : "");
    return fail(solid.error());
  }
  out.close = solid->report;
  out.manifest.changes = out.close.changes;
  out.manifest.exact = out.close.exact;
  out.times.close = watch.lap();
  out.source_checks = checks.get();
  out.times.check = watch.lap();
  KERF_CHECK(finish({std::move(solid->mesh), {}}, options, materials, staging, out, watch, progress));
  return out;
}

Expected<BakeReport> bakeRecipe(const fs::path& recipe_file, const fs::path& case_folder, const BakeOptions& asked,
                                const Progress& progress) {
  BakeReport out;
  Stopwatch watch;
  KERF_TRY(materials, readDefaultMaterials());
  KERF_TRY(recipe, readCaseRecipe(recipe_file, materials));
  BakeOptions options = asked;
  if (!asked.voxel_is_given && recipe.voxel_mm) options.voxelize.voxel_mm = *recipe.voxel_mm;
  if (options.unit.empty()) options.unit = recipe.unit;
  options.voxelize.material = recipe.fallback;
  if (!asked.region) options.region = recipe.region;
  KERF_CHECK(settleSizes(options));
  const std::set<CloseStep>& only = options.close.only;
  if (only.empty() ? options.close.mode == CloseMode::kBase : only.count(CloseStep::kBase) > 0)
    return fail({Error::Code::kBadValue, recipe_file.string(), "--close", "a base for a recipe",
                 "parts that are solids: a base under each would lie between them",
                 "kerf bake PART -o part.case --close base for the part that is open, then kerf export part.case -o "
                 "part.ply, and name that in the recipe"});

  const std::vector<fs::path> names = recipe.meshes();
  std::vector<fs::path> paths;
  for (const fs::path& name : names) paths.push_back(recipe.resolve(name));
  std::vector<std::string> hashes;
  std::vector<fs::path> all = paths;
  if (recipe.labels) all.push_back(recipe.resolve(recipe.labels->volume));
  for (const fs::path& path : all) {
    auto hash = internal::sha256OfSource(path);
    if (!hash) {
      if (hash.error().code == Error::Code::kNotFound)
        hash.error().hint = fmt::format("{} names it; paths in a recipe are relative to it", recipe_file.string());
      return fail(hash.error());
    }
    hashes.push_back(*hash);
  }
  KERF_TRY(recipe_hash, sha256OfFile(recipe_file));
  std::string numbers = recipe_hash + '\n';  // what the ids of the recipe are in the grid
  for (const RecipePart& p : recipe.parts)
    numbers += fmt::format("{} {}\n", p.material.id, static_cast<int>(p.material.material));
  out.manifest.id = caseId(hashes, options, numbers);
  if (!options.overwrite)
    if (auto manifest = existing(case_folder, out.manifest.id)) {
      out.manifest = std::move(*manifest);
      out.was_up_to_date = true;
      return out;
    }
  KERF_TRY(staging, AtomicFolder::create(case_folder, options.overwrite, kCaseManifest));
  std::error_code failed;
  fs::copy_file(recipe_file, staging.staging() / kCaseRecipe, failed);
  if (failed)
    return fail({Error::Code::kWriteFailed, (staging.staging() / kCaseRecipe).string(), "", failed.message(), "",
                 "free some space"});
  out.times.write += watch.lap();

  KERF_TRY(meshes, internal::readMeshSources(paths, hashes, options.unit, true, staging.staging(), out,
                                             part(progress, 0, 0.05)));
  constexpr std::string_view kAsked = "as asked with --unit";
  if (asked.unit.empty() && !recipe.unit.empty())
    for (CaseSource& source : out.manifest.sources)
      if (source.unit_reason.starts_with(kAsked)) source.unit_reason.replace(0, kAsked.size(), "as the recipe says");
  auto checks = checkAside(meshes);
  LabelObject labels;
  if (recipe.labels) {
    KERF_TRY(read, readLabels(recipe, hashes.back(), staging.staging(), out, part(progress, 0.05, 0.15)));
    labels = std::move(read);
  }
  out.times.read = watch.lap();

  // Each mesh as a solid of its own: it is asked what it covers.
  std::map<fs::path, Mesh> solids;
  std::vector<std::string> changes;
  for (std::size_t n = 0; n < names.size(); ++n) {
    CloseOptions close = options.close;
    if (close.mode == CloseMode::kAuto) close.mode = CloseMode::kRepair;  // a part has no missing underside
    auto solid = closeMesh(meshes[n], close, part(progress, 0.15, 0.2));
    if (!solid) {
      Error e = solid.error();
      if (e.file.empty()) e.file = paths[n].string();
      if (e.hint.starts_with("--close") && e.hint.find("base") != e.hint.npos) {  // not for a recipe: see above
        e.expected = "a solid, as every part of a recipe";
        e.hint = fmt::format(
            "kerf bake {0} -o {1}.case --close base, then kerf export {1}.case -o {1}.ply, and name that in the recipe",
            paths[n].string(), names[n].stem().string() + "-closed");
      }
      return fail(std::move(e));
    }
    for (const std::string& change : solid->report.changes)
      changes.push_back(names[n].filename().string() + ": " + change);
    solids.emplace(names[n], std::move(solid->mesh));
  }
  std::vector<Mesh> outline;
  for (const fs::path& name : recipe.outline.empty() ? names : recipe.outline) outline.push_back(solids.at(name));
  if (recipe.labels && recipe.outline.empty()) outline.push_back(labels.surface);
  if (!report(progress, 0.2, "uniting parts")) return cancelError();
  Object object;
  KERF_TRY(solid, unite(outline, options, out, part(progress, 0.2, 0.3)));
  object.solid = std::move(solid);
  changes.insert(changes.end(), out.close.changes.begin(), out.close.changes.end());
  out.manifest.changes = changes;
  out.manifest.exact = out.close.exact;
  out.times.close = watch.lap();
  out.source_checks = checks.get();
  out.times.check = watch.lap();

  for (const RecipePart& p : recipe.parts) {
    MaterialClaim claim;
    claim.material = p.material.material;
    claim.replaces = p.replaces;
    claim.depth = p.depth;
    CasePart row{p.material.id, p.origin(), 0, 0};
    if (!p.mesh.empty()) {
      claim.solid = &solids.at(p.mesh);
      row.own_mm3 = signedVolume(*claim.solid);
    } else if (p.label) {
      claim.covers = [smooth = labels.labels, label = *p.label](const Vec3d& x) { return smooth->labelAt(x) == label; };
      for (const LabelVolumeReport& r : labels.labels->reports())
        if (r.label == *p.label) row.own_mm3 = r.counted_mm3;
    }
    object.claims.push_back(std::move(claim));
    out.manifest.parts.push_back(std::move(row));
  }
  KERF_CHECK(finish(object, options, materials, staging, out, watch, progress));
  return out;
}

}  // namespace kerf
