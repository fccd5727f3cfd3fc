// What is decided before a scan is cut: what was found in it, what will be done about it, and what that will give.
//
// The model of the import panel, without OpenGL: scripts and tests drive it by the commands import.*. One thread, the
// window's, calls everything; the closed solid is computed by a job of its own, which the workbench's job does not wait
// for.
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
#include "ui/app/opening.h"
#include "ui/app/previewed_plan.h"

namespace kerf {

/// A scan as it was read: nothing is scaled or changed yet.
struct ScanFound {
  std::filesystem::path file;
  std::string format;                ///< "binary STL"
  std::shared_ptr<const Mesh> mesh;  ///< in the file's unit
  std::string declared_unit;         ///< "mm", "inch", ... if the file says so; else empty
  MeshReport check;                  ///< lengths in the file's unit
  std::vector<std::string> notes;    ///< of the reader: what was skipped, ignored or odd
  Vec3d up = Vec3d::UnitZ();         ///< unit, out of the teeth: by the occlusal plane, else away from the opening
  bool has_occlusal_plane = false;   ///< a base can be made parallel to it
  double seconds = 0;                ///< that reading and checking took
};
/// Reads and judges a mesh file.   Errors: as readMesh(); kCancelled.
/// @cost  a jaw of 100k triangles 0.3 s. For a job.
Expected<ScanFound> readScan(const std::filesystem::path& file, const Progress& progress = {});

/// A unit the file may be in, and what size that makes.
struct UnitOption {
  std::string unit;  ///< "mm", "cm", "m", "um", "inch"
  double scale_to_mm = 1;
  Vec3d size_mm = Vec3d::Zero();
  bool is_plausible = false;  ///< a dental object, from a crown to a skull, is 3 to 300 mm across
};

/// A sentence about the scan, in the words of a dental technician.
struct Finding {
  enum class Weight {
    kFine,     ///< nothing has to be done
    kMended,   ///< preparing takes care of it
    kDoubtful  ///< the user should look
  };
  Weight weight = Weight::kFine;
  std::string about;  ///< one or two words: "Surface"
  std::string text;
};

/// A line through measurements of eight real scans at three voxel sizes each, on two cores: memory within 10 %, seconds
/// from a quarter too few to twice too many, as the machine was busy or idle.
/// @param area_mm2       of the closed solid.   @param closing_s  what closing took or will take.
Prediction predict(double area_mm2, double voxel_mm, double closing_s);
class ImportPlan final : public PreviewedPlan {
 public:
  /// @param defaults  where the choices begin; an empty unit: as the file says, or by its size.
  ImportPlan(ScanFound found, PrepareOptions defaults);

  const ScanFound& found() const { return found_; }
  /// What was found, with the unit as it is chosen now.
  std::vector<Finding> findings() const;

  // ---- Choices. Each is checked when it is made: kBadValue says what is possible, and nothing changes then.

  const PrepareOptions& choice() const { return choice_; }
  const ClosingChoice& closing() const { return choice_.closing; }
  /// All that a file may be in, with the size each makes.
  std::span<const UnitOption> units() const { return units_; }
  const UnitOption& unit() const { return units_[unit_]; }
  /// Neither the file nor the user says it: it is taken from the size.
  bool isUnitGuessed() const { return choice_.unit.empty() && found_.declared_unit.empty(); }
  Expected<void> setUnit(const std::string& name);
  Expected<void> setClosing(const ClosingChoice& choice);
  /// mm; 0: as suggestedVoxel().
  Expected<void> setVoxel(double mm);
  double suggestedVoxel() const;
  double voxel() const { return choice_.voxel_mm > 0 ? choice_.voxel_mm : suggestedVoxel(); }
  static constexpr double kFinestVoxel = 0.02, kCoarsestVoxel = 0.5;  ///< mm
  static constexpr double kThinnestBase = 0.5, kThickestBase = 30;    ///< mm
  static constexpr double kSmoothest = 20;                            ///< mm
  static constexpr double kFinestWrap = 0.1, kCoarsestWrap = 5;       ///< mm

  // ---- What comes of them

  Box3 boxMm() const;
  /// Length of the longest boundary, mm.
  double rimMm() const;
  /// Boundaries that are rims of a missing underside, no holes: by their length, or because one is asked for. Closing
  /// goes by its own welded mesh and may count others as well.
  std::size_t rimCount() const;
  bool isWithoutUnderside() const { return rimCount() > 0; }
  Prediction prediction() const override;
  /// Options for openToCut(): an untouched unit and voxel size stay open, so that the same case is found again.
  PrepareOptions result() const { return choice_; }

  /// Not a wrap, nor a million triangles.
  bool startsByItself() const override;

 private:
  std::unique_ptr<Job<ClosedPreview>> makePreview() const override;
  std::string reasonOfUnit() const;

  ScanFound found_;
  PrepareOptions choice_;
  std::vector<UnitOption> units_;
  bool unit_is_doubtful_ = false;
  std::size_t unit_ = 0;
};

}  // namespace kerf
