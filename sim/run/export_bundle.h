// The post-operative mesh of a run: the scan minus what was cut off it, with how exact the cut walls are.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/boolean/post_op_mesh.h"
#include "geometry/case/object_names.h"
#include "geometry/field/brick_field.h"
#include "sim/run/run_manifest.h"

namespace kerf {

/// How far the cut walls of an exported mesh lie from the exact sweep of the tool, at the vertices.
struct WallAccuracy {
  std::size_t vertices = 0;
  double rms_mm = 0, max_mm = 0;
};

struct Export {
  PostOpMesh post_op;                      ///< pieces where they were loaded: placedPieces() puts them where they are
  std::vector<RunManifest::Piece> pieces;  ///< of a session whose object is in pieces, or was moved; else none
  ObjectNames names;                       ///< of the case
  WallAccuracy accuracy;                   ///< vertices = 0 for a case without a cut
  std::string accuracy_missing;  ///< why the walls could not be measured; empty if they were, or there is no cut
};

/// The solid of a case with what was removed taken away and, if there is such, what was added united with it.
/// @param changed  the cut field phi in the bricks where it differs from phi0, on the same grid. A brick that is as it
/// was loaded counts for nothing.
Expected<PostOpMesh> postOperativeMeshOf(const Mesh& solid, const BrickField& phi0, const BrickField& changed,
                                         const PostOpOptions& options = {}, const Progress& progress = {});

/// The post-operative mesh of a run, or the solid of a case.
/// @param beside  0: the case that was cut; n: the n-th case that stood beside it, with what was cut off that.
Expected<Export> exportBundle(const std::filesystem::path& run_or_case, const PostOpOptions& options = {},
                              const Progress& progress = {}, std::size_t beside = 0);

}  // namespace kerf
