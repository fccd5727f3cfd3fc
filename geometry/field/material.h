// Tissues of an object: the number stored in a voxel, and the table of material properties.
//
// The table is a text file, assets/materials.toml; a material of your own is one more [[material]] in it, or in a copy
// that KERF_ASSETS points to. Every physical number in it has its unit and its source.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"

namespace kerf {

/// Tissue of a voxel. The material grid stores the number, 0 to 255, whose meaning never changes. Numbers from 32 on
/// are for custom tables.
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

/// A number with its source.
struct SourcedNumber {
  double value = 0;
  std::string source;  ///< a publication, or a note on the choice
};

/// Properties of one material. Training defaults, to be edited, not measurements of a patient.
struct MaterialProperties {
  Material material = Material::kNone;
  std::string id;                         ///< as in recipes: "nerve_canal"
  std::string name;                       ///< display name: "nerve canal"
  Rgba8 color{200, 200, 200, 255};        ///< for display
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
  /// Null if the table has no such material.
  const MaterialProperties* find(std::string_view id) const;
  const MaterialProperties* find(Material material) const;
  /// The row, or an error that lists the known ids.
  Expected<MaterialProperties> require(std::string_view id) const;
  std::string ids() const;  ///< "enamel, dentin, ...", in the table's order

 private:
  std::vector<MaterialProperties> rows_;
};

/// Reads a table. Strict: unknown keys, a unit other than the number's own, a number without source or out of range,
/// and repeated ids or numbers are errors that name file, line and key.
Expected<MaterialTable> readMaterials(const std::filesystem::path& file);

/// The program's own table: materials.toml in KERF_ASSETS, beside the program, or in the source tree, in this order.
Expected<std::filesystem::path> findMaterialsFile();
Expected<MaterialTable> readDefaultMaterials();

}  // namespace kerf
