#include "ui/app/view/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <system_error>
#include <utility>

#include "geometry/case/case_bundle.h"
#include "geometry/field/tissue_mesh.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/files/run_files.h"
#include "ui/app/view/mesh_in_mm.h"

namespace kerf {
namespace {

std::string inBrackets(const Vec3d& p) { return fmt::format("({:.2f}, {:.2f}, {:.2f})", p[0], p[1], p[2]); }

// The requested plane, and a note if it removes nothing.
Expected<Plane> placed(const SectionPlane& cut, const PostOpMesh& shown, const std::string& file, std::string& note) {
  using Through = SectionPlane::Through;
  const Mesh& mesh = shown.mesh;
  const Box3 box = bounds(mesh);
  Plane plane{cut.point, cut.normal};
  if (cut.through == Through::kCenter) plane.point = box.center();
  if (cut.through == Through::kCut) {
    Box3 walls;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int k = 0; k < 3 && shown.is_cut[t]; ++k) walls.add(mesh.corner(t, k));
    if (walls.isEmpty())
      return fail({.code = Error::Code::kUnsupported,
                   .file = file,
                   .place = "--section",
                   .found = "no cut",
                   .expected = "a run with cut faces",
                   .hint = "--section center,NX,NY,NZ"});
    plane.point = walls.center();
  }

  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (const Vec3d& p : mesh.vertices) {
    lowest = std::min(lowest, plane.height(p));
    highest = std::max(highest, plane.height(p));
  }

  const std::string where = fmt::format("the object lies in {}-{} mm", inBrackets(box.min), inBrackets(box.max));
  const Vec3d& n = cut.normal;
  if (lowest >= 0)
    return fail({.code = Error::Code::kEmpty,
                 .file = file,
                 .place = "--section",
                 .found = fmt::format("the plane removes the whole object; {}", where),
                 .expected = {},
                 .hint = fmt::format("--section center,{:.4g},{:.4g},{:.4g}", n[0], n[1], n[2])});
  if (highest <= 0) note = fmt::format("the plane of --section removes nothing; {}", where);
  return plane;
}

// The object of a case, or of a run of it, cut open by a plane.
Expected<Mesh> cutOpen(const std::filesystem::path& path, const std::filesystem::path& case_folder, bool is_run,
                       const PostOpMesh& shown, const MaterialField& materials, const MaterialTable& table,
                       const SectionPlane& cut, std::string& note) {
  KERF_TRY(plane, placed(cut, shown, path.string(), note));
  KERF_TRY(phi, readCaseField(case_folder));
  BrickField sweep, current = phi;
  bool has_sweep = false;
  if (is_run) {
    KERF_TRY(run, readRunManifest(path));
    has_sweep = run.hasSweep();
    if (has_sweep) {
      KERF_TRY(swept, readRunSweep(path));
      sweep = std::move(swept);
    } else {
      KERF_TRY(changed, readRunCutField(path));
      for (std::size_t b = 0; b < changed.brickCount(); ++b)
        current.brick(current.touch(changed.brickCoord(b))) = changed.brick(b);
    }
  }

  // The two may differ in voxels: a run within the case's fine region was cut separately.
  const auto distance = [&](const Vec3d& p) {
    return has_sweep ? std::max(phi.sample(p), -sweep.sample(p)) : current.sample(p);
  };
  const double voxel = has_sweep ? std::min(phi.voxel(), sweep.voxel()) : phi.voxel();
  return section(shown.mesh, distance, voxel, materials, table, plane);
}

// Scene of a case or a run: coloured by material where there are several, cut open on request.
Expected<Scene> sceneOfBundle(const std::filesystem::path& path, const std::optional<SectionPlane>& cut) {
  Scene scene;
  const bool is_run = isRun(path);
  std::filesystem::path case_folder = path;
  if (is_run) {
    KERF_TRY(found, caseOfRun(path));
    case_folder = found;
  }
  bool is_tissues = cut.has_value(), is_one_material = false;
  if (isCase(case_folder)) {
    KERF_TRY(manifest, readCaseManifest(case_folder));
    is_tissues |= manifest.materials.size() > 1;
    is_one_material = manifest.materials.size() == 1;
  }
  MaterialBricks added;
  if (is_run) {
    KERF_TRY(of_run, readRunMaterials(path));
    added = std::move(of_run);
    is_tissues |= !added.isEmpty();
    is_one_material &= added.isEmpty();
  }

  PostOpMesh shown;
  if (is_tissues && !is_run) {
    KERF_TRY(solid, readCaseSolid(case_folder));
    shown.is_cut.assign(solid.triangles.size(), 0);
    shown.mesh = std::move(solid);
  } else {
    KERF_TRY(exported, exportBundle(path));
    shown = std::move(exported.post_op);
  }

  if (is_tissues) {
    KERF_TRY(materials, readRunLabels(case_folder, added));
    KERF_TRY(table, readDefaultMaterials());
    const Rgba8 cut_color = PostOpOptions{}.cut_color;
    colorByMaterial(shown.mesh, materials, table);
    if (is_one_material)
      for (std::size_t t = 0; t < shown.mesh.triangles.size(); ++t)
        if (shown.is_cut[t]) shown.mesh.face_colors[t] = cut_color;
    if (cut) {
      KERF_TRY(open, cutOpen(path, case_folder, is_run, shown, materials, table, *cut, scene.note));
      shown.mesh = std::move(open);
    }
  }
  scene.mesh = std::move(shown.mesh);
  return scene;
}

}  // namespace

Expected<Scene> loadScene(const std::filesystem::path& path, const std::optional<SectionPlane>& cut,
                          const std::string& unit) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return sceneOfBundle(path, cut);
  if (cut)
    return fail({.code = Error::Code::kUnsupported,
                 .file = path.string(),
                 .place = "--section",
                 .found = "neither a case nor a run",
                 .expected = "a case or a run folder",
                 .hint = "run kerf bake first: only a case stores the inside"});

  KERF_TRY(read, readMeshInMm(path, unit));
  return Scene{.mesh = std::move(read.mesh), .note = std::move(read.note)};
}

}  // namespace kerf
