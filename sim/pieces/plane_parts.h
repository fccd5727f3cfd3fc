// The parts of an object cut by planes, at once.
#pragma once

#include <cstdint>
#include <memory>

#include "sim/object/plane_sides.h"
#include "sim/pieces/split_object.h"

namespace kerf {

/// Value of a part's field at a node: max(phi, -height), at most the background. @rt
inline float planePartValue(float phi, double height, float background) noexcept {
  return std::max(phi, std::min(static_cast<float>(-height), background));
}

/// Each part as an object: phi becomes max(phi, distance from the part's side), so its face lies on the plane to the
/// bit. A part may hang together in several places: SplitObject divides it. The first part takes over the removed
/// volume so far, and the volume that leaves the scene.
/// @param whole  with its shells repaired. Another thread may step it meanwhile if it is frozen.
/// @param cut  number for PlaneSide::cut.   @param first_id  of the parts: State::next_id.
/// Null: nothing would stay, or with kBoth all of it lies on one side. The same object gives the same parts, bit for
/// bit. @cost  3 us a brick at the planes, and 0.2 us for any other.
std::unique_ptr<ObjectPieces> makePlaneParts(const CutObject& whole, const CutPlanes& planes, PlaneKeep keep,
                                             std::uint32_t cut, std::uint32_t first_id, bool is_parallel = true);

}  // namespace kerf
