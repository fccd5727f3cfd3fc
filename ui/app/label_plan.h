// What is decided before a label volume of a CT is cut: which labels are there, what tissue each is, how fine the
// voxels are. The import panel shows it beside ImportPlan, which does the same for scans.
//
// Preparing writes a recipe (docs/reference/recipes.md) and bakes that. One thread, the window's, calls everything.
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
#include "ui/app/import_plan.h"
#include "ui/app/job.h"

namespace kerf {

struct LabelVolume;

/// One label of a volume, never 0.
struct LabelFound {
  std::uint16_t label = 0;
  std::string name;  ///< as the file has it; empty: it has none
  std::uint64_t voxels = 0;
  double volume_mm3 = 0;
  std::string called() const { return name.empty() ? "label " + std::to_string(label) : name; }
};

/// A volume as it was read.
struct LabelsFound {
  std::filesystem::path file;
  std::string format;  ///< "NIfTI"
  std::shared_ptr<const LabelVolume> volume;
  std::vector<LabelFound> labels;  ///< rising
  Box3 box;                        ///< of all that is labelled, mm
  /// mm^2 of voxel faces between two labels, the smaller first; 0 is nothing. What the border of the volume cuts off
  /// counts as a face to 0.
  std::map<std::pair<std::uint16_t, std::uint16_t>, double> walls_mm2;
  double seconds = 0;  ///< that reading took
};
/// Errors: those of readLabelVolume(); kEmpty for a volume without labels; kCancelled.
/// @cost  360 x 360 x 330 about 1 s.   For a job.
Expected<LabelsFound> readLabels(const std::filesystem::path& file, const Progress& progress = {});

/// What tissue a name stands for, by its words: "Left mandibular canal" is the nerve canal. None: air, sinus and the
/// like are nothing to cut. A name that says nothing is generic.
std::optional<Material> tissueByName(const std::string& name);

class LabelPlan final : public PreviewedPlan {
 public:
  LabelPlan(LabelsFound found, MaterialTable materials, double voxel_mm = 0);

  const LabelsFound& found() const { return found_; }
  const MaterialTable& materials() const { return materials_; }
  std::vector<Finding> findings() const;

  // ---- Choices. Each is checked when it is made, and changes nothing when it is refused.

  /// None: the label is left out, as if nothing were there.
  std::optional<Material> tissue(std::uint16_t label) const;
  /// @param tissue  an id of materials.toml, or "none".   Errors: kBadValue for a label or a tissue that there is not.
  Expected<void> setTissue(std::uint16_t label, const std::string& tissue);
  /// mm; 0: as suggestedVoxel().   Errors: kBadValue out of ImportPlan's range.
  Expected<void> setVoxel(double mm);
  double suggestedVoxel() const;
  double voxel() const { return voxel_mm_ > 0 ? voxel_mm_ : suggestedVoxel(); }
  bool hasOwnVoxel() const { return voxel_mm_ > 0; }

  // ---- What comes of them

  bool isEmpty() const { return tissues_.empty(); }
  /// Of the surface around all that is not left out; until the preview knows, from the faces of voxels.
  double areaMm2() const;
  double volumeMm3() const;
  Prediction prediction() const override;
  /// The text of a recipe that bakes it.   @pre !isEmpty()
  std::string recipe() const;

  /// Not a large volume: smoothing takes long.
  bool startsByItself() const override;

 private:
  /// The surface, in the colours of its tissues.
  std::unique_ptr<Job<ClosedPreview>> makePreview() const override;

  LabelsFound found_;
  MaterialTable materials_;
  std::map<std::uint16_t, Material> tissues_;  // of labels that are not left out
  double voxel_mm_ = 0;
};

}  // namespace kerf
