// A tool's distance as the 1 kHz step reads it: tabled once, single precision, a few nanoseconds a point.
//
// A box, such as a saw's blade, is a formula. A solid of revolution is a table over (radius, z), another plate one over
// (x, z) beside its thickness, anything else one over (x, y, z). Two dimensions can be sampled ten times finer than
// three: a ball's table is good to 0.05 um.
#pragma once

#include <array>
#include <vector>

#include "geometry/field/field_lookup.h"
#include "geometry/tool/tool_shape.h"

namespace kerf {

struct ToolFieldOptions {
  double margin_mm = 0.5;       ///< distances are right up to here; at least the band of the objects it will meet
  double spacing_mm = 0.01;     ///< of a table in two dimensions
  double spacing_3d_mm = 0.03;  ///< in three
  std::size_t most_samples = 4'000'000;  ///< float32 each; where a table would take more, it is coarser
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
  /// box; farther out a lower bound that is at least the margin. Of a box they are exact anywhere. Same bits whatever n
  /// and the processor.
  /// @param n  a multiple of 8.   @cost 2 to 6 ns a point; of a box 1 ns.
  void distances(const float* x, const float* y, const float* z, float* out, int n) const noexcept;
  /// Of one point. Ten times as dear.
  float distance(const Vec3f& p) const noexcept;

  /// Distances are 1-Lipschitz up to this, mm: what interpolation may err by at an edge, or rounding of a box.
  double slack() const { return slack_; }
  /// An overlap that is no deeper than this is none, mm. A flat side slides in its own plane along the wall that it has
  /// cut: there rounding alone would make contact, and something to cut, without end. So it is 1 nm of boxes and
  /// plates. Of anything else 0.
  float leastOverlap() const { return least_overlap_; }
  /// Of the solid, tool frame, mm; empty without one.
  const Box3& bounds() const { return bounds_; }
  /// Distance of its farthest point from the tip, mm.
  double reach() const { return reach_; }

 private:
  Box3 bounds_;
  double reach_ = 0, slack_ = 0;
  float least_overlap_ = 0;
  internal::FieldTable lookup_;  // but for its pointer, which is table_'s
  std::vector<float> table_;
};

}  // namespace kerf
