// The case recipe: meshes, depths and labels of an object, and the material of each part.
//
//   format = "kerf-recipe"
//   version = 1
//   name = "Molar with enamel"
//   unit = "mm"                        # of the meshes; default: as declared, or by the size of all together
//   voxel = 0.05                       # mm; --voxel overrides it
//   drop_specks_mm3 = 1                # drops smaller pieces of the object; optional
//
//   [[part]]                           # in order of priority: where parts overlap, the first wins
//   material = "pulp"                  # an id of materials.toml
//   mesh = "pulp.stl"                  # inside this mesh; paths are relative to the recipe
//
//   [[part]]
//   material = "enamel"
//   depth = 1.5                        # less deep than this under the object's surface, mm
//   above = { point = [0, 0, 5], normal = [0, 0, 1] }   # and above this plane; optional
//   replaces = ["dentin"]              # and only over dentin of a later part; optional
//
//   [[part]]
//   material = "dentin"
//   mesh = "tooth.stl"
//
//   [outline]                          # meshes whose union is the object; default: all meshes and labels
//   meshes = ["tooth.stl"]
//
//   [region]                           # smaller voxels near a line, as along an osteotomy
//   line = [[0, 0, 5], [10, 0, 5]]     # mm; one point alone: a ball
//   radius = 3                         # mm
//   voxel = 0.05                       # mm, smaller than the object's
//
//   [labels]                           # a label volume, for parts with `label = 2` instead of a mesh
//   volume = "cbct.nii.gz"             # NRRD, NIfTI, MetaImage, a folder of DICOM or of slice images
//   spacing = [0.2, 0.2, 0.5]          # mm; only for volumes that do not state it
//   threshold = 120                    # intensities from here on are label 1; only for volumes without labels
//   smoothing = 0.8                    # label voxels
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/field/material.h"
#include "preprocess/voxelize/voxelize.h"

namespace kerf {

/// One [[part]]: exactly one of mesh, depth and label.
struct RecipePart {
  MaterialProperties material;
  std::filesystem::path mesh;  ///< as written: relative to the recipe
  std::optional<DepthRule> depth{};
  std::optional<std::uint16_t> label{};
  std::vector<Material> replaces{};
  std::string origin() const;  ///< "enamel.stl", "label 2", "depth < 1.5 mm"
};

struct RecipeLabels {
  std::filesystem::path volume;  ///< as written
  std::optional<Vec3d> spacing_mm{};
  std::optional<double> threshold{};
  std::optional<double> smoothing_voxels{};
};

struct CaseRecipe {
  std::filesystem::path file;
  std::string name;
  std::string unit;  ///< empty: chooseUnit()
  std::optional<double> voxel_mm{};
  double drop_specks_mm3 = 0;
  Material fallback = Material::kGeneric;      ///< material of places far from all parts
  std::vector<RecipePart> parts;               ///< first wins
  std::vector<std::filesystem::path> outline;  ///< empty: all meshes and labels
  std::optional<RecipeLabels> labels{};
  std::optional<FineRegion> region{};

  std::filesystem::path resolve(const std::filesystem::path& written) const { return file.parent_path() / written; }
  /// Every mesh once, in the order of first mention: parts, then outline.
  std::vector<std::filesystem::path> meshes() const;
};

/// True for a recipe: a file with a TOML extension.
bool looksLikeRecipe(const std::filesystem::path& path);

/// Strict, as all of Kerf's TOML files: errors name file, line, key, found value and expected value.
Expected<CaseRecipe> readCaseRecipe(const std::filesystem::path& file, const MaterialTable& materials);

}  // namespace kerf
