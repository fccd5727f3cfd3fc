// Kerf's own demo anatomy: a tooth with its tissues, a mandible, a scan of an arch; implicit solids made from textbook
// dimensions. No scan, no patient. For training and tests.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

/// Meshes and their materials. Tissues are solids with priority: where two overlap, the earlier part wins. So no two
/// surfaces need to coincide: enamel reaches a little out of the tooth, the tooth is one solid of dentin.
struct DemoAnatomy {
  struct File {
    std::string name;  ///< name of the mesh file, without folder
    Mesh mesh;         ///< mm; closed, 2-manifold, outward, not crossing itself as float32; vertex colours
  };
  struct Part {
    std::string material;  ///< caries, enamel, dentin, pulp, pdl, nerve_canal, cancellous, cortical
    std::string file;      ///< one of `files`
  };
  std::string name;     ///< recipe name, without extension: "molar"
  std::string title;    ///< for display
  double voxel_mm = 0;  ///< resolves the finest tissue
  std::vector<File> files;
  std::vector<Part> parts;           ///< in order of priority
  std::vector<std::string> outline;  ///< files whose union is the surface of the object

  const Mesh& mesh(const std::string& file) const;  ///< @pre there is one of this name
  std::string manifest() const { return name + (parts.empty() ? ".ply" : ".toml"); }  ///< marks a demo folder
};

/// Lower left first molar (FDI 36): caries, enamel, pulp, dentin; frame of demo_molar.h. Cancelled: kCancelled.
/// @param detail  factor on the default edge length: 1 gives about 150 000 triangles in 3 s of one core.
Expected<DemoAnatomy> demoMolarAnatomy(double detail = 1, const Progress& progress = {});

/// Mandible with teeth 31 to 37 and 41 to 47: pulp, enamel, dentin, ligament (PDL), nerve canals, spongy and compact
/// bone; frame of demo_jaw.h: x to the patient's left, y backwards, z up from the occlusal plane.
/// 900 000 triangles, 15 s of one core; parallel.
Expected<DemoAnatomy> demoMandible(double detail = 1, const Progress& progress = {});

/// Writes the meshes (binary PLY) and, if there are parts, the recipe NAME.toml into a folder, which appears complete
/// or not at all.
/// @param overwrite  replace a folder that holds such a model.
Expected<void> writeDemoAnatomy(const DemoAnatomy& anatomy, const std::filesystem::path& folder, bool overwrite);

}  // namespace kerf
