// Preparation of a scan before cutting: findings, choices and predicted result.
//
// The model of the import panel, without OpenGL: scripts and tests drive it by the commands import.*. Window thread
// only. A separate job computes the closed solid; the workbench's job does not wait for it.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"
#include "geometry/mesh/mesh_check.h"
#include "ui/app/import/opening.h"
#include "ui/app/import/previewed_plan.h"

namespace kerf {

/// A scan as read, not yet scaled or changed.
struct ScanFound {
  std::filesystem::path file;
  std::string format;                ///< "binary STL"
  std::shared_ptr<const Mesh> mesh;  ///< in the file's unit
  std::string declared_unit;         ///< "mm", "inch", ... if the file declares it; else empty
  MeshReport check;                  ///< lengths in the file's unit
  std::vector<std::string> notes;    ///< notes of the reader: skipped, ignored or odd content
  Vec3d up = Vec3d::UnitZ();         ///< unit, out of the teeth: by the occlusal plane, else away from the opening
  bool has_occlusal_plane = false;   ///< a base can be made parallel to it
  double seconds = 0;                ///< time for reading and checking
};
/// Reads and checks a mesh file.   Errors: as readMesh(); kCancelled.
/// @cost  a jaw of 100k triangles 0.3 s. For a job.
Expected<ScanFound> readScan(const std::filesystem::path& file, const Progress& progress = {});

/// A possible unit of the file, with the resulting size.
struct UnitOption {
  std::string unit;  ///< "mm", "cm", "m", "um", "inch"
  double scale_to_mm = 1;
  Vec3d size_mm = Vec3d::Zero();
  bool is_plausible = false;  ///< a dental object, from a crown to a skull, is 3 to 300 mm across
};

/// A sentence about the scan, in the terms of a dental technician.
struct Finding {
  enum class Weight {
    kFine,     ///< no action needed
    kMended,   ///< preparing repairs it
    kDoubtful  ///< the user should look
  };
  Weight weight = Weight::kFine;
  std::string about;  ///< one or two words: "Surface"
  std::string text;
};

/// Linear fit to eight real scans at three voxel sizes each, on two cores: memory within 10 %, seconds from a quarter
/// too few to twice too many, by the load of the machine.
/// @param area_mm2       of the closed solid.   @param closing_s  measured or predicted closing time.
Prediction predict(double area_mm2, double voxel_mm, double closing_s);
/// Seconds to close a scan, on one of two cores of a laptop.
double closingSeconds(std::size_t triangles, bool is_closed);
class ImportPlan final : public PreviewedPlan {
 public:
  /// @param defaults  initial choices; an empty unit: as the file declares, or by its size.
  ImportPlan(ScanFound found, PrepareOptions defaults);

  const ScanFound& found() const { return found_; }
  /// The scan after the trims, in the file's unit, and its check. Crossings are those of the scan as read.
  const std::shared_ptr<const Mesh>& mesh() const { return mesh_; }
  const MeshReport& check() const { return check_; }
  /// Findings at the chosen unit.
  std::vector<Finding> findings() const;

  // ---- Choices. A setter rejects a bad value with kBadValue, which lists the valid range, and changes nothing.

  const PrepareOptions& choice() const { return choice_; }
  const ClosingChoice& closing() const { return choice_.closing; }
  /// All possible units, with the resulting sizes.
  std::span<const UnitOption> units() const { return units_; }
  const UnitOption& unit() const { return units_[unit_]; }
  /// The unit comes from the size: neither the file nor the user gives it.
  bool isUnitGuessed() const { return choice_.unit.empty() && found_.declared_unit.empty(); }
  Expected<void> setUnit(const std::string& name);
  Expected<void> setClosing(const ClosingChoice& choice);
  /// Adds a trim to the closing choice, or takes the last ones back. Errors: those of trimScan(), which change nothing;
  /// kEmpty for a trim that removes nothing.
  Expected<void> trim(const ScanTrim& trim);
  /// The plane with the normal turned so that it removes the smaller area.
  ScanTrim removingLess(const PlaneTrim& plane) const;
  /// @return false: there is none.
  bool undoTrim();
  Expected<void> flipTrim();
  /// Replaces all; empty: the scan as read.   @param least  triangles that must go.
  Expected<void> setTrims(std::vector<ScanTrim> trims, std::size_t least = 0);
  /// Result of all trims, without its mesh: mesh(). Null: none.
  const TrimmedScan* trimmed() const { return trimmed_ ? &*trimmed_ : nullptr; }
  /// mm; 0: as suggestedVoxel().
  Expected<void> setVoxel(double mm);
  double suggestedVoxel() const;
  double voxel() const { return choice_.voxel_mm > 0 ? choice_.voxel_mm : suggestedVoxel(); }
  static constexpr double kFinestVoxel = 0.02, kCoarsestVoxel = 0.5;  ///< mm
  static constexpr double kThinnestBase = 0.5, kThickestBase = 30;    ///< mm
  static constexpr double kSmoothest = 20;                            ///< mm
  static constexpr double kWidestRimTrim = 10;                        ///< mm
  static constexpr double kFinestWrap = 0.1, kCoarsestWrap = 5;       ///< mm

  // ---- Results

  Box3 boxMm() const;
  /// Length of the longest boundary, mm.
  double rimMm() const;
  /// Boundaries that are rims of a missing underside, not holes: by length, or by the choice of a base. Closing uses
  /// its own welded mesh and may count differently.
  std::size_t rimCount() const;
  bool isWithoutUnderside() const { return rimCount() > 0; }
  Prediction prediction() const override;
  /// Options for openToCut(). An untouched unit or voxel size stays unset, so that it finds the same case again.
  PrepareOptions result() const { return choice_; }

  /// False for a wrap or more than a million triangles.
  bool startsByItself() const override;

 private:
  std::unique_ptr<Job<ClosedPreview>> makePreview() const override;
  std::string reasonOfUnit() const;

  ScanFound found_;
  std::optional<TrimmedScan> trimmed_;  // its mesh is mesh_
  std::shared_ptr<const Mesh> mesh_;
  MeshReport check_;
  PrepareOptions choice_;
  std::vector<UnitOption> units_;
  bool unit_is_doubtful_ = false;
  std::size_t unit_ = 0;
};

}  // namespace kerf
