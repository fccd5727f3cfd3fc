// A tool's distance for the 1 kHz step: tabled once, single precision, a few nanoseconds a point.
//
// A box, such as a saw's blade, is a formula. A solid of revolution is a table over (radius, z), another plate one over
// (x, z) beside its thickness, anything else one over (x, y, z). Two dimensions allow ten times finer samples than
// three: a ball's table is accurate to 0.05 um.
#pragma once

#include <array>
#include <vector>

#include "geometry/field/field_lookup.h"
#include "geometry/tool/tool_shape.h"

namespace kerf {

struct ToolFieldOptions {
  double margin_mm = 0.5;                ///< range of exact distances; at least the band of the objects to cut
  double spacing_mm = 0.01;              ///< spacing of a table in two dimensions
  double spacing_3d_mm = 0.03;           ///< in three
  std::size_t most_samples = 4'000'000;  ///< float32 each; a larger table becomes coarser
};

/// A value; reading is safe from any thread, allocation-free and bounded.
class ToolField {
 public:
  /// No solid: every distance is kFar.
  ToolField() = default;
  /// Parallel inside; milliseconds for tools of known symmetry, seconds for a mesh.
  explicit ToolField(const ToolShape& shape, const ToolFieldOptions& options = {});

  static constexpr float kFar = 1e6f;
  bool isEmpty() const { return bounds_.isEmpty(); }

  /// Distances of n points of the tool's frame, mm, negative inside: interpolated within `margin_mm` of the solid's
  /// box; farther out a lower bound that is at least the margin. For a box they are exact anywhere. Same bits for any n
  /// and processor.
  /// @param n  a multiple of 8.   @cost 2 to 6 ns a point; 1 ns for a box.
  void distances(const float* x, const float* y, const float* z, float* out, int n) const noexcept;
  /// Distance of one point. Ten times as expensive.
  float distance(const Vec3f& p) const noexcept;

  /// Distances are 1-Lipschitz up to this, mm: the interpolation error at an edge, or the rounding of a box.
  double slack() const { return slack_; }
  /// Overlaps up to this depth do not count, mm. A flat side slides in its own plane along its cut wall, where rounding
  /// alone would cause endless contact and cutting. So it is 1 nm for boxes and plates, else 0.
  float leastOverlap() const { return least_overlap_; }
  /// Box of the solid, tool frame, mm; empty without a solid.
  const Box3& bounds() const { return bounds_; }
  /// Distance of its farthest point from the tip, mm.
  double reach() const { return reach_; }

 private:
  Box3 bounds_;
  double reach_ = 0, slack_ = 0;
  float least_overlap_ = 0;
  internal::FieldTable lookup_;  // except its pointer, which points into table_
  std::vector<float> table_;
};

}  // namespace kerf
