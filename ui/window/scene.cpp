#include "ui/window/scene.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "geometry/mesh_io.h"

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

Expected<Scene> loadScene(const std::filesystem::path& path) {
  Scene scene;
  scene.mesh_file = path;
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(path, ignored);
  if (is_folder) {
    const auto has = [&](const char* name) { return std::filesystem::exists(path / name, ignored); };
    const bool run = has("run.toml");
    if (!run && !has("case.toml"))
      return fail({.code = Error::Code::kNotFound,
                   .file = path.string(),
                   .place = {},
                   .found = "a folder without case.toml or run.toml",
                   .expected = "a case folder, a run folder or a mesh file",
                   .hint = "the folder that kerf bake or kerf cut wrote, or a mesh file inside this one"});
    const char* mesh_name = run ? "result.ply" : "solid.ply";
    scene.mesh_file = path / mesh_name;
    if (!has(mesh_name))
      return fail({.code = Error::Code::kNotFound,
                   .file = scene.mesh_file.string(),
                   .place = {},
                   .found = fmt::format("a {} folder without its mesh", run ? "run" : "case"),
                   .expected = mesh_name,
                   .hint = run ? "kerf cut, to make the run again" : "kerf bake, to make the case again"});
  }
  KERF_TRY(file, readMesh(scene.mesh_file));
  scene.mesh = std::move(file.mesh);
  scene.unit = "mm";
  if (is_folder || file.declared_unit == "mm") return scene;
  if (const double factor = millimetres(file.declared_unit); factor > 0) {
    for (Vec3d& p : scene.mesh.vertices) p *= factor;
    scene.unit = file.declared_unit + ", shown in mm";
  } else {
    scene.unit = "mm (the file names none)";
  }
  return scene;
}

}  // namespace kerf
