// The post-operative mesh of a run: the scan minus the removed volume, with the accuracy of the cut walls.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/boolean/post_op_mesh.h"
#include "geometry/case/object_names.h"
#include "geometry/field/brick_field.h"
#include "sim/run/files/run_manifest.h"

namespace kerf {

/// Distance of an exported mesh's cut walls from the exact sweep of the tool, at the vertices.
struct WallAccuracy {
  std::size_t vertices = 0;
  double rms_mm = 0, max_mm = 0;
};

struct Export {
  PostOpMesh post_op;                      ///< pieces where they were loaded: placedPieces() moves them to their places
  std::vector<RunManifest::Piece> pieces;  ///< of a session whose object is in pieces or was moved; else none
  ObjectNames names;                       ///< of the case
  WallAccuracy accuracy;                   ///< vertices = 0 for a case without a cut
  std::string accuracy_missing;            ///< why the walls were not measured; empty if they were, or without a cut
};

/// The solid of a case minus the removed volume, united with the added volume, if any.
/// @param changed  the cut field phi in the bricks where it differs from phi0, on the same grid. Unchanged bricks have
///   no effect.
Expected<PostOpMesh> postOperativeMeshOf(const Mesh& solid, const BrickField& phi0, const BrickField& changed,
                                         const PostOpOptions& options = {}, const Progress& progress = {});

/// The post-operative mesh of a run, or the solid of a case.
/// @param beside  0: the case that was cut; n: its n-th neighbour, minus the volume cut off that.
Expected<Export> exportBundle(const std::filesystem::path& run_or_case, const PostOpOptions& options = {},
                              const Progress& progress = {}, std::size_t beside = 0);

}  // namespace kerf
