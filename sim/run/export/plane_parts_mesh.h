// The exact mesh of an object that planes cut in a session.
#pragma once

#include <span>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/boolean/post_op_mesh.h"
#include "geometry/field/brick_field.h"
#include "sim/run/files/run_manifest.h"

namespace kerf {

/// True if a plane cut any of them.
bool areCutByPlanes(std::span<const RunManifest::Piece> pieces);
/// Pieces that share a cut face with another one: cut without a kerf, and both where they were loaded. One file of both
/// is no printable solid, though each piece is.
/// @param is_put_back  counts moved pieces as well.
std::size_t countTouching(std::span<const RunManifest::Piece> pieces, bool is_put_back = false);

/// The solid minus the strokes, cut by the planes of each piece with cutByPlanes(), in the order of the cuts. Pieces
/// with the same sides share one mesh; a part that left the scene is not in the result. Without strokes the result is
/// that of `kerf trim` with the same planes, bit for bit.
///
/// The field of a piece at a plane is max(phi, -height); strokes are the difference from max(phi0, -height). Beyond a
/// plane with another piece behind it, the strokes are mirrored at the plane: their walls pass it without a rim.
/// @param solid, phi0, changed  as for postOperativeMeshOf(): all pieces where they were loaded.
/// @param pieces  with `inside` and `sides`. Errors: as cutByPlanes(), and kGeometry if a piece vanished.
/// @cost  for each set of sides as postOperativeMeshOf(), and as cutByPlanes() for each cut.
Expected<PostOpMesh> planePartsMesh(const Mesh& solid, const BrickField& phi0, const BrickField& changed,
                                    std::span<const RunManifest::Piece> pieces, const PostOpOptions& options = {},
                                    const Progress& progress = {});

}  // namespace kerf
