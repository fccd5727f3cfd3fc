// Smooth surfaces from labels: walls between tissues, to a fraction of a voxel, without staircases.
//
// A Gaussian blur of a label's indicator (1 in its voxels, 0 elsewhere) is its membership. A point belongs to the label
// with the largest membership, with trilinear interpolation between nodes. This moves walls between voxels to match
// their neighbourhood, but shrinks convex parts and loses thin ones.
// Hence two corrections:
// - where a label is one voxel thick, its own voxels get a lead that keeps them (thin walls, canals);
// - every label's membership gets a weight, such that it keeps the volume of its voxels.
// After the partition of unity by smoothed indicators that multi-material surface extraction uses; the volume-keeping
// weights in the spirit of volume-constrained threshold dynamics (Ruuth & Wetton, J. Sci. Comput. 2003).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "geometry/mesh/mesh.h"
#include "preprocess/volume/label_volume.h"

namespace kerf {

struct SmoothLabelOptions {
  /// Standard deviation of the blur in voxels of the grid, along each of its axes: 0 to 4. Below 0.5 the staircase
  /// shows; above 1.5 corners, thin walls and contacts between teeth vanish.
  double smoothing_voxels = 0.8;
  /// The same in mm, equal in all directions at any spacing; replaces smoothing_voxels. At most 4 voxels.
  std::optional<double> smoothing_mm{};
  double volume_tolerance = 0.002;       ///< relative, per label; the fit stops there, or after 12 rounds
  std::uint64_t max_bytes = 2ull << 30;  ///< limit for the memberships, else an error
};

/// Effect of smoothing on one label.
struct LabelVolumeReport {
  std::uint16_t label = 0;
  std::uint64_t voxels = 0;      ///< in the volume read
  double counted_mm3 = 0;        ///< voxels times voxel volume
  double smoothed_mm3 = 0;       ///< volume of the smoothed label
  std::uint32_t pieces = 0;      ///< pieces of its voxels, joined through faces
  std::uint32_t pieces_now = 0;  ///< pieces of the smoothed voxel centres. Fewer: specks vanished or parts merged
};

/// The smoothed labels. Const functions may be called from any thread.
class SmoothLabels {
 public:
  /// @param tissue_labels  at least 1, at most 250, different, none 0, each present in the volume (else kEmpty, naming
  /// those that are). All other labels together are the rest, no tissue.
  /// Errors: kBadValue (labels, options), kEmpty, kUnsupported (more memory than max_bytes), kCancelled.
  /// @cost  360 x 360 x 330 with five labels: some seconds and about 0.6 GB on two cores; keeps only the box of the
  /// tissue labels, and memberships only near walls. Deterministic on any number of threads.
  static Expected<SmoothLabels> create(const LabelVolume& volume, std::span<const std::uint16_t> tissue_labels,
                                       const SmoothLabelOptions& options = {}, const Progress& progress = {});

  SmoothLabels(SmoothLabels&&) noexcept;
  SmoothLabels& operator=(SmoothLabels&&) noexcept;
  ~SmoothLabels();

  /// Wall between the union of all tissue labels and the rest: closed, outward, 2-manifold, mm, world frame, float32
  /// coordinates. Closed flat where tissue touches the border of the volume. Marching cubes on the volume's own grid.
  /// Moved out by at most a fifth of a voxel if chords would remove more than 0.2 % of the labels' volume.
  /// Errors: kEmpty (smoothing left nothing), kCancelled.
  Expected<Mesh> surface(const Progress& progress = {}) const;

  /// The tissue label with the largest weighted membership at a point, 0 where the rest has it; the smallest label on a
  /// tie. O(1), about 100 ns.
  std::uint16_t labelAt(const Vec3d& world_mm) const;

  /// One entry per tissue label, in the order of create().
  const std::vector<LabelVolumeReport>& reports() const;

 private:
  struct Data;
  explicit SmoothLabels(std::unique_ptr<const Data> data);
  std::unique_ptr<const Data> data_;
};

}  // namespace kerf
