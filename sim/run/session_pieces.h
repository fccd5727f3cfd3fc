// The objects of a session as what they are of: a case in one piece or in several, each where it is.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/hand/path.h"
#include "sim/pieces/joined_field.h"
#include "sim/run/cut_scene.h"
#include "sim/run/run_manifest.h"
#include "sim/run/session_run.h"
#include "sim/session/session.h"

namespace kerf::internal {

/// What the session has of one case: the object, or its pieces, the largest first.
using Objects = std::vector<const CutObject*>;
/// @param loaded  index into Session::loaded().
Objects objectsOf(const Session& session, std::size_t loaded);
/// Several, or one that came off.
bool isInPieces(const Objects& objects);
/// All that each of them has.
std::vector<BrickField> fieldsOf(const Objects& objects);
/// For a manifest. One without a name is "piece N", by a number that no other has.
/// @param fields  of the objects, in their order.
std::vector<RunManifest::Piece> piecesOf(const Objects& objects, const std::vector<BrickField>& fields,
                                         const PieceLabels& labels);

/// What of the case can be cut by a path, each where it is: the case itself, or its pieces.
struct Bodies {
  struct Body {
    const BrickField* begin = nullptr;
    Rigid3 T_world_body;
  };
  std::vector<Body> all;
  std::vector<BrickField>
      fields;  ///< of pieces, in the order of all; none: the case is one object, where it was loaded
  bool isInPieces() const { return !fields.empty(); }
};
/// As they are now. Refers to the session, which stays.
Bodies bodiesOf(const Session& session);
/// What was expected of a path that cut nothing of them: throughBox(), or the boxes of the pieces where they are.
std::string throughBodies(const Bodies& bodies, const Box3& box_of_case);
/// A path in the world as seen from a body.
CutPath pathInFrame(const CutPath& path, const Rigid3& T_world_body);

/// Of a run that is gone on from: its pieces apart again, and each where it was put.
struct PiecesPutBack {
  std::vector<Command> done;         ///< to the session, in this order
  PieceLabels labels;                ///< their names and colours
  std::vector<std::string> missing;  ///< names of those that were not found again, and so are where they were loaded
};
/// Before the first tick. @param session  of the run's case, as the run left it.   @cost  seconds for a jaw.
PiecesPutBack putPiecesBack(Session& session, std::span<const RunManifest::Piece> before);

/// Of the case after a cut along a path.
struct PiecesLeft {
  std::vector<RunManifest::Piece> pieces;  ///< all that is apart is a piece of its own; the largest first
  std::vector<std::string> cut_away;       ///< names of those of which nothing is left
};
/// What a path cut in two is two pieces from here on, both where the one was: a run that goes on from this one finds
/// each of them again, by a point inside of its own. The largest part keeps the name.
/// @param changed  what the new run keeps of the case: run.vdb, grid phi.
/// @param pieces  as they were put back, or as they are now.   @param parts  their fields, in the same order.
/// Error kGeometry: material that was added joins pieces that are apart now, where they were loaded: no run can keep
/// that.   @cost  seconds for a jaw.
Expected<PiecesLeft> piecesLeft(const CutScene& scene, const BrickField& changed,
                                std::span<const RunManifest::Piece> pieces, std::span<const FieldPart> parts);

}  // namespace kerf::internal
