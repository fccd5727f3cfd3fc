// The case bundle: a folder that holds one patient object, as imported and as baked.
//
//   case.toml       manifest: sources, unit, changes, voxel size, hashes; read this first
//   source-N.EXT    every imported file, byte for byte (a folder of slices: a folder)
//   recipe.toml     the case recipe, byte for byte, if there was one
//   trim.toml       the parts of the scan cut away before closing, if any (preprocess/bake/trim_file.h)
//   solid.ply       the closed mesh in mm that export cuts: the source's vertices first, in their order (float32)
//   anatomy.vdb     grids phi (mm, negative inside), material, shell; phi_fine, material_fine, shell_fine of a region
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/field/brick_field.h"
#include "geometry/field/fine_region.h"
#include "geometry/field/material_field.h"
#include "geometry/mesh/mesh.h"

namespace kerf {

inline constexpr const char* kCaseManifest = "case.toml";
inline constexpr const char* kCaseRecipe = "recipe.toml";
inline constexpr const char* kCaseTrim = "trim.toml";
inline constexpr const char* kCaseSolid = "solid.ply";
inline constexpr const char* kCaseAnatomy = "anatomy.vdb";

struct CaseSource {
  std::string stored_as;    ///< "source-1.stl"
  std::string format;       ///< "binary STL"
  std::string sha256;       ///< hash of the file
  std::string unit;         ///< "mm", "inch", "m" ...
  std::string unit_reason;  ///< reason for that unit
  double scale_to_mm = 1;
  std::size_t vertices = 0, triangles = 0;
};

/// One material of the object's labels.
struct CaseMaterial {
  std::string id;  ///< as in materials.toml at the bake
  int number = 0;  ///< number in the material grid
  double volume_mm3 = 0;
};

/// One part of the recipe, with its own and its resulting volume.
struct CasePart {
  std::string material;
  std::string origin;     ///< "enamel.stl", "label 2", "depth < 1.5 mm"
  double own_mm3 = 0;     ///< volume of its mesh or label alone; 0 for a depth
  double volume_mm3 = 0;  ///< in the object: minus earlier parts, plus filled gaps
};

/// Two cases of one patient whose coordinates share a frame: an upper and a lower jaw that meet as scanned.
struct CasePair {
  std::string frame;    ///< the same 64 hexadecimal digits in both cases, and in no others
  std::string partner;  ///< name of the other case's folder, beside this one
};

/// Volume outside all parts of the recipe.
struct CaseGaps {
  double unclaimed_mm3 = 0;  ///< all of it, including places assigned to a near part
  double forgotten_mm3 = 0;  ///< share too far from every part: has the recipe's fallback material
};

/// The part of the object that has finer grids too.
struct CaseRegion {
  FineRegion where;
  std::uint64_t field_voxels = 0, shell_points = 0;
  double shell_area_mm2 = 0;
};

struct CaseManifest {
  std::string kerf_version;
  std::string id;  ///< sha256 over sources and settings: the same inputs give the same id
  std::vector<CaseSource> sources;
  std::optional<CasePair> pair;
  std::string close_mode;            ///< "auto", "base", "repair", "wrap"
  std::vector<std::string> changes;  ///< changes by closing, plain sentences
  /// Numbers of closing, by the keys of "closing" in kerf bake --json: "vertices_lost", "bridged_mm2". Empty for a case
  /// of a recipe, and for one from an older Kerf.
  std::map<std::string, double> closing;
  /// Warnings of baking, sentences; empty optional: from an older Kerf that did not store them.
  std::optional<std::vector<std::string>> warnings;
  bool exact = true;  ///< false: wrapped, the surface is an approximation of the scan
  double voxel_mm = 0;
  std::vector<CaseMaterial> materials;  ///< in the order of their numbers; one for an object of one material
  std::vector<CasePart> parts;          ///< empty for a case without a recipe
  std::optional<CaseGaps> gaps;         ///< only with a recipe
  std::size_t solid_vertices = 0, solid_triangles = 0;
  double solid_volume_mm3 = 0, solid_area_mm2 = 0;
  Box3 box;  ///< of the solid, mm
  std::uint64_t field_voxels = 0, shell_points = 0;
  double shell_area_mm2 = 0;
  std::optional<CaseRegion> region;
  std::string solid_sha256, field_sha256;  ///< hashes of solid.ply and anatomy.vdb: a damaged file is an error
};

/// The baked field and its labels.
struct CaseFields {
  BrickField phi0;
  MaterialField materials;
};

/// True if a key of CaseManifest::closing names a count, not a length, area, volume or share.
bool isCountOfClosing(std::string_view key);

/// True if the folder looks like a case (has a manifest).
bool isCase(const std::filesystem::path& folder);
Expected<void> writeCaseManifest(const std::filesystem::path& folder, const CaseManifest& manifest);
/// Strict: unknown or missing keys, a wrong format or a newer version are errors that name file, line and key.
Expected<CaseManifest> readCaseManifest(const std::filesystem::path& folder);
/// The solid in mm, double holding float32 values. A file that differs by a byte from the baked one is an error.
Expected<Mesh> readCaseSolid(const std::filesystem::path& folder);
/// The baked field phi0. The manifest's hash is checked before OpenVDB reads it, because some damaged files crash
/// OpenVDB.
Expected<BrickField> readCaseField(const std::filesystem::path& folder);
/// The finer field of the case's region: air everywhere outside it. Noise, and values of another object than `whole`
/// (the baked field phi0), are errors that name the grid. @pre the manifest has a region; else kNotFound.
Expected<BrickField> readCaseRegionField(const std::filesystem::path& folder, const BrickField& whole);
/// The labels beside it; checked the same way.
Expected<MaterialField> readCaseMaterials(const std::filesystem::path& folder);
/// Both, checked once. @param manifest  of that folder.
Expected<CaseFields> readCaseFields(const std::filesystem::path& folder, const CaseManifest& manifest);

}  // namespace kerf
