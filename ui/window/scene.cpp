#include "ui/window/scene.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "geometry/case_bundle.h"
#include "geometry/mesh_io.h"
#include "sim/run_bundle.h"
#include "ui/window/tissue_view.h"

namespace kerf {
namespace {

/// mm per unit, 0 if unknown.
double millimetres(const std::string& unit) {
  for (const auto& [name, factor] : {std::pair("mm", 1.0), std::pair("cm", 10.0), std::pair("m", 1000.0),
                                     std::pair("um", 0.001), std::pair("inch", 25.4)})
    if (unit == name) return factor;
  return 0;
}

}  // namespace

Expected<Scene> loadScene(const std::filesystem::path& path, const std::optional<Plane>& cut) {
  Scene scene;
  scene.mesh_file = path;
  scene.unit = "mm";
  std::error_code ignored;
  if (isCase(path)) {
    KERF_TRY(manifest, readCaseManifest(path));
    if (cut || manifest.materials.size() > 1) {
      KERF_TRY(solid, readCaseSolid(path));
      KERF_TRY(materials, readCaseMaterials(path));
      KERF_TRY(table, readDefaultMaterials());
      scene.mesh = std::move(solid);
      if (!cut) {
        colorByMaterial(scene.mesh, materials, table);
        return scene;
      }
      KERF_TRY(phi, readCaseField(path));
      scene.mesh = section(scene.mesh, phi, materials, table, *cut);
      return scene;
    }
  } else if (cut) {
    return fail({Error::Code::kUnsupported, path.string(), "--section", "no case", "a case folder",
                 "kerf bake it first: only a case knows its inside"});
  }
  if (std::filesystem::is_directory(path, ignored)) {
    KERF_TRY(result, exportBundle(path));
    scene.mesh = std::move(result.post_op.mesh);
    return scene;
  }
  KERF_TRY(file, readMesh(scene.mesh_file));
  scene.mesh = std::move(file.mesh);
  if (file.declared_unit == "mm") return scene;
  if (const double factor = millimetres(file.declared_unit); factor > 0) {
    for (Vec3d& p : scene.mesh.vertices) p *= factor;
    scene.unit = file.declared_unit + ", shown in mm";
  } else {
    scene.unit = "mm (the file names none)";
  }
  return scene;
}

}  // namespace kerf
