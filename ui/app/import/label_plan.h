// Preparation of a CT label volume before cutting: its labels, their tissues and the voxel size. ImportPlan does the
// same for scans; the import panel shows both.
//
// Preparing writes a recipe (docs/reference/recipes.md) and bakes it. Window thread only.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/field/material.h"
#include "ui/app/base/job.h"
#include "ui/app/import/import_plan.h"

namespace kerf {

struct LabelVolume;

/// One label of a volume, never 0.
struct LabelFound {
  std::uint16_t label = 0;
  std::string name;  ///< name in the file; empty: none
  std::uint64_t voxels = 0;
  double volume_mm3 = 0;
  std::string called() const { return name.empty() ? "label " + std::to_string(label) : name; }
};

/// A volume as read.
struct LabelsFound {
  std::filesystem::path file;
  std::string format;  ///< "NIfTI"
  std::shared_ptr<const LabelVolume> volume;
  std::vector<LabelFound> labels;  ///< ascending
  Box3 box;                        ///< box of all labelled voxels, mm
  /// mm^2 of voxel faces between two labels, smaller label first; 0 is the background. Faces on the border of the
  /// volume count as faces to 0.
  std::map<std::pair<std::uint16_t, std::uint16_t>, double> walls_mm2;
  double seconds = 0;  ///< reading time
};
/// Errors: those of readLabelVolume(); kEmpty for a volume without labels; kCancelled.
/// @cost  360 x 360 x 330 about 1 s.   For a job.
Expected<LabelsFound> readLabels(const std::filesystem::path& file, const Progress& progress = {});

/// Tissue of a label name, by its words: "Left mandibular canal" is the nerve canal. None for air, sinus and the like.
/// Generic for an unknown name.
std::optional<Material> tissueByName(const std::string& name);

class LabelPlan final : public PreviewedPlan {
 public:
  LabelPlan(LabelsFound found, MaterialTable materials, double voxel_mm = 0);

  const LabelsFound& found() const { return found_; }
  const MaterialTable& materials() const { return materials_; }
  std::vector<Finding> findings() const;

  // ---- Choices. A setter that rejects a value changes nothing.

  /// None: the label is omitted and counts as background.
  std::optional<Material> tissue(std::uint16_t label) const;
  /// @param tissue  an id of materials.toml, or "none".   Errors: kBadValue for an unknown label or tissue.
  Expected<void> setTissue(std::uint16_t label, const std::string& tissue);
  /// mm; 0: as suggestedVoxel().   Errors: kBadValue outside ImportPlan's range.
  Expected<void> setVoxel(double mm);
  double suggestedVoxel() const;
  double voxel() const { return voxel_mm_ > 0 ? voxel_mm_ : suggestedVoxel(); }
  bool hasOwnVoxel() const { return voxel_mm_ > 0; }

  // ---- Results

  bool isEmpty() const { return tissues_.empty(); }
  /// Area of the surface around all tissues; before the preview, estimated from voxel faces.
  double areaMm2() const;
  double volumeMm3() const;
  Prediction prediction() const override;
  /// Text of the recipe for baking.   @pre !isEmpty()
  std::string recipe() const;

  /// False for a large volume, because smoothing takes long.
  bool startsByItself() const override;

 private:
  /// The surface, in the colours of its tissues.
  std::unique_ptr<Job<ClosedPreview>> makePreview() const override;

  LabelsFound found_;
  MaterialTable materials_;
  std::map<std::uint16_t, Material> tissues_;  // labels in use
  double voxel_mm_ = 0;
};

}  // namespace kerf
