// Where the tip of a tool comes out of an object on the side away from its shank: through the floor of a tooth, the far
// cortex of a jaw.
#pragma once

#include <optional>

#include "geometry/field/brick_field.h"

namespace kerf::internal {

/// Follows the tip through an object as it was loaded. It comes out on the far side where it was a voxel deep, leaves,
/// and the surface there looks away from the shank by less than 60 degrees from straight ahead. A tip that leaves a
/// slot sideways, goes back out of its hole, or enters a closed cavity does not.
class TipExit {
 public:
  /// @param loaded  the whole object's field, no region's; kept by reference.
  explicit TipExit(const BrickField& loaded) : loaded_(loaded) {}

  /// The tool is here now; between two poses the tip went straight. @cost 0.5 us per half voxel of the way; 2 ms
  /// where it leaves.
  void moveTo(const Rigid3& T_object_tool);
  /// The tool was lifted to elsewhere: the next pose does not follow on the last.
  void lift() {
    last_.reset();
    is_deep_ = false;
  }
  /// mm, the first place; nothing: it never did.
  const std::optional<Vec3d>& place() const { return place_; }

 private:
  void visit(const Vec3d& tip, const Vec3d& to_shank);

  const BrickField& loaded_;
  std::optional<Vec3d> last_, place_;
  bool is_deep_ = false;
};

}  // namespace kerf::internal
