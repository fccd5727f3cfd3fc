// The objects of a session by case: each in one piece or several, with their poses.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/hand/path.h"
#include "sim/pieces/joined_field.h"
#include "sim/run/files/run_manifest.h"
#include "sim/run/scene/cut_scene.h"
#include "sim/run/session/session_run.h"
#include "sim/session/session.h"

namespace kerf::internal {

/// Objects of one case: the object, or its pieces, the largest first.
using Objects = std::vector<const CutObject*>;
/// @param loaded  index into Session::loaded().
Objects objectsOf(const Session& session, std::size_t loaded);
/// True for several objects, or for one that is a piece.
bool isInPieces(const Objects& objects);
/// The complete field of each.
std::vector<BrickField> fieldsOf(const Objects& objects);
/// For a manifest. An unnamed piece is "piece N", with an unused number.
/// @param fields  of the objects, in their order.
std::vector<RunManifest::Piece> piecesOf(const Objects& objects, const std::vector<BrickField>& fields,
                                         const PieceLabels& labels);

/// Objects of the case for a cut along a path, each at its place: the case itself, or its pieces.
struct Bodies {
  struct Body {
    const BrickField* begin = nullptr;
    Rigid3 T_world_body;
  };
  std::vector<Body> all;
  std::vector<BrickField>
      fields;  ///< of pieces, in the order of `all`; empty: the case is one object, where it was loaded
  bool isInPieces() const { return !fields.empty(); }
};
/// In the current state. Refers to the session, which must outlive it.
Bodies bodiesOf(const Session& session);
/// Text for a path that cut none of them: throughBox(), or the boxes of the pieces at their places.
std::string throughBodies(const Bodies& bodies, const Box3& box_of_case);
/// Transforms a path from the world frame to a body's frame.
CutPath pathInFrame(const CutPath& path, const Rigid3& T_world_body);

/// Result of restoring a continued run's pieces, each at its place.
struct PiecesPutBack {
  std::vector<Command> done;         ///< commands to the session, in order
  PieceLabels labels;                ///< their names and colours
  std::vector<std::string> missing;  ///< names of pieces that were not found again, and thus are where they were loaded
};
/// Call before the first tick. @param session  of the run's case, in the run's final state.   @cost  seconds for a jaw.
PiecesPutBack putPiecesBack(Session& session, std::span<const RunManifest::Piece> before);

/// Pieces of the case after a cut along a path.
struct PiecesLeft {
  std::vector<RunManifest::Piece> pieces;  ///< each connected part is a piece; the largest first
  std::vector<std::string> cut_away;       ///< names of completely removed pieces
};
/// If a path cuts a piece in two, both parts become pieces at its place. A run that continues this one finds each by a
/// point inside. The largest part keeps the name.
/// @param changed  the field that the new run stores: run.vdb, grid phi.
/// @param pieces  as restored, or in their current state.   @param parts  their fields, in the same order.
/// Error kGeometry: added material would join separate pieces where they were loaded; no run can store that.   @cost
/// seconds for a jaw.
Expected<PiecesLeft> piecesLeft(const CutScene& scene, const BrickField& changed,
                                std::span<const RunManifest::Piece> pieces, std::span<const FieldPart> parts);

}  // namespace kerf::internal
