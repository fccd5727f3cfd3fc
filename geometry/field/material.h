// The tissues an object is made of: the number a voxel stores, and the table of what each is like.
//
// The table is a text file, assets/materials.toml; a material of your own is one more [[material]] in it, or in a copy
// that KERF_ASSETS points to. Every physical number in it carries its unit and where it comes from.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"

namespace kerf {

/// Tissue of a voxel. The number is what the material grid stores, 0 to 255, and never changes its meaning; numbers
/// from 32 on are for tables of your own.
enum class Material : int {
  kNone = 0,
  kEnamel,
  kDentin,
  kPulp,
  kCaries,
  kCortical,
  kCancellous,
  kNerveCanal,
  kGingiva,
  kGeneric,
  kPdl,
  kComposite
};

/// A number with where it comes from.
struct SourcedNumber {
  double value = 0;
  std::string source;  ///< a publication, or a word on how it was chosen
};

/// What one material is like. Training defaults, not properties of anybody's teeth: all are meant to be edited.
struct MaterialProperties {
  Material material = Material::kNone;
  std::string id;                         ///< as in recipes: "nerve_canal"
  std::string name;                       ///< for people: "nerve canal"
  Rgba8 color{200, 200, 200, 255};        ///< for the eye
  SourcedNumber density;                  ///< g/cm^3
  SourcedNumber hardness;                 ///< Vickers, HV
  SourcedNumber specific_cutting_energy;  ///< J/mm^3: work a tool spends on a mm^3 of it
  SourcedNumber contact_stiffness;        ///< N/mm^3: pressure per penetration
  SourcedNumber friction;                 ///< coefficient of the cutting drag, no unit
};

class MaterialTable {
 public:
  explicit MaterialTable(std::vector<MaterialProperties> rows) : rows_(std::move(rows)) {}

  std::span<const MaterialProperties> rows() const { return rows_; }
  /// Null when the table has no such material.
  const MaterialProperties* find(std::string_view id) const;
  const MaterialProperties* find(Material material) const;
  /// The row, or an error that lists the ids there are.
  Expected<MaterialProperties> require(std::string_view id) const;
  std::string ids() const;  ///< "enamel, dentin, ...", in the table's order

 private:
  std::vector<MaterialProperties> rows_;
};

/// Reads a table. Strict: unknown keys, a unit other than the one the number is kept in, a number without source or out
/// of range, and repeated ids or numbers are errors that name file, line and key.
Expected<MaterialTable> readMaterials(const std::filesystem::path& file);

/// The program's own table: materials.toml in KERF_ASSETS, beside the program, or in the source tree, in this order.
Expected<std::filesystem::path> findMaterialsFile();
Expected<MaterialTable> readDefaultMaterials();

}  // namespace kerf
