// The pieces of a post-operative mesh, each where the user put it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/case/case_bundle.h"
#include "geometry/case/object_names.h"
#include "geometry/mesh/mesh.h"
#include "sim/run/files/run_manifest.h"

namespace kerf {

struct PlacedPiece {
  std::uint32_t id = 0;  ///< RunManifest::Piece::id
  std::string name;
  bool is_moved = false;
  Mesh mesh{};  ///< closed; an unmoved piece has the vertices of the whole, bit for bit
  /// For a file with names: the user's name, or the names of its solids in the source. Empty: none.
  std::vector<NamedPart> objects{};
};

/// False of a name that a session gives: "piece 2".
bool isNamedByUser(std::string_view piece);

/// Divides a mesh into the pieces of a run.
///
/// A solid of the mesh belongs to the piece whose inner point it holds. A solid without an inner point (touching teeth
/// in one piece, or a solid too small for a voxel) joins the nearest one, nearest first. A moved piece is transformed
/// in double precision and rounded to float32. If it then crosses itself, it is shifted by some hundred-thousandths of
/// a millimetre until it does not.
/// @param mesh  of postOperativeMesh(): all pieces where they were loaded.
/// @param is_put_back  leaves all where they were loaded.
/// @param names  of the case, for PlacedPiece::objects. Solids of several names in a piece are grouped by name.
/// @return  in the order of `pieces`, without dropped crumbs.
/// Error kGeometry: two pieces hang together in the mesh and one was moved; or a piece crosses itself at any shift.
/// @cost  30 ns a triangle and piece, and the search for self-crossings of moved pieces.
Expected<std::vector<PlacedPiece>> placedPieces(const Mesh& mesh, std::span<const RunManifest::Piece> pieces,
                                                bool is_put_back = false, const ObjectNames& names = {});

/// The solids of a mesh as pieces, the largest first, for a cut that no session divided. A piece gets the name of its
/// object in the source, a further one of that object "tooth 36 2"; without a name it is "piece 2" by its place.
/// @cost  as solidsOf().
std::vector<PlacedPiece> solidPieces(const Mesh& mesh, const ObjectNames& names = {});

/// A file for each: NAME-PIECE.stl of NAME.stl. Letters of any script, digits and "_" stay; "-" replaces all else. Long
/// names are shortened. A second file of the same name, ignoring case, gets a number.
std::vector<std::filesystem::path> filesOfPieces(const std::filesystem::path& file,
                                                 std::span<const PlacedPiece> pieces);

/// Rejects overwriting a source file of the case under any name: compares its bytes.
/// Error kBadValue.   @cost  reads the file, if there is one.
Expected<void> requireNoSource(const std::filesystem::path& file, const CaseManifest& manifest);

/// All pieces in one mesh. Without a moved piece it equals the original mesh, except for the order of its parts.
Mesh together(std::span<const PlacedPiece> pieces);
/// The named objects of that mesh; empty if none has a name.
std::vector<NamedPart> objectsOf(std::span<const PlacedPiece> pieces);

}  // namespace kerf
