// Ambient occlusion of a chunk's vertices: crevices, fissures and cavities are darker.
//
// From the distance field alone, without a pass over the picture: two samples in each of about seven directions above a
// vertex tell how much of the expected air is tissue. After Evans, "Fast approximations for global illumination on
// dynamic scenes", SIGGRAPH 2006 course notes. It takes several directions because a baked field knows distances near
// the surface only: straight above the floor of a cavity it does not see the walls.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/field/brick_field.h"
#include "sim/live/remesher.h"

namespace kerf {

/// Tissue farther than this from a vertex does not change its occlusion, mm. After an edit, the occlusion can change
/// only in chunks whose box comes this near to a changed brick.
inline constexpr double kOcclusionReach = 2;

/// One byte per vertex of the chunk: 255 all the light, 0 none. A flat wall has 255 everywhere.
/// Pure: the same field and chunk, the same bytes. Any thread that may read the field; about 1 µs per vertex.
/// @param field  the field behind the chunk: negative inside, mm.
std::vector<std::uint8_t> occlusionOf(const MeshChunk& chunk, const BrickField& field);
std::vector<std::uint8_t> occlusionOf(const MeshChunk& chunk, const OverlayField& field);

}  // namespace kerf
