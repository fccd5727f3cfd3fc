// Where the tip of a tool comes out of an object on the side away from its shank: through the floor of a tooth, the far
// cortex of a jaw.
#pragma once

#include <optional>

#include "geometry/field/brick_field.h"

namespace kerf::internal {

/// Follows the tip through an object as loaded. The tip comes out on the far side if it was a voxel deep, leaves, and
/// the surface there looks away from the shank by less than 60 degrees from straight ahead. Leaving a slot sideways,
/// going back out of the hole, or entering a closed cavity does not count.
class TipExit {
 public:
  /// @param loaded  the whole object's field, not a region's; kept by reference.
  explicit TipExit(const BrickField& loaded) : loaded_(loaded) {}

  /// The tool is here now; between two poses the tip went straight. @cost 0.5 us per half voxel of the way; 2 ms at an
  /// exit.
  void moveTo(const Rigid3& T_object_tool);
  /// The tool was lifted elsewhere: the next pose does not continue the last.
  void lift() {
    last_.reset();
    is_deep_ = false;
  }
  /// mm, the first exit; empty: none.
  const std::optional<Vec3d>& place() const { return place_; }

 private:
  void visit(const Vec3d& tip, const Vec3d& to_shank);

  const BrickField& loaded_;
  std::optional<Vec3d> last_, place_;
  bool is_deep_ = false;
};

}  // namespace kerf::internal
