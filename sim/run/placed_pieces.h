// The pieces of a post-operative mesh, each where a person put it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/case/case_bundle.h"
#include "geometry/case/object_names.h"
#include "geometry/mesh/mesh.h"
#include "sim/run/run_manifest.h"

namespace kerf {

struct PlacedPiece {
  std::uint32_t id = 0;  ///< RunManifest::Piece::id
  std::string name;
  bool is_moved = false;
  Mesh mesh;  ///< closed; of one that is not moved every vertex is that of the whole, bit for bit
  /// For a file that holds names: the name that the user gave, or the names of its solids in the source. Empty: none.
  std::vector<NamedPart> objects{};
};

/// True if the user named the piece: a session calls it "piece 2".
bool isNamedByUser(const RunManifest::Piece& piece);

/// Takes a mesh apart into the pieces of a run.
///
/// A solid of the mesh belongs to the piece whose inner point it holds. One without, as of teeth that touch and so are
/// one piece, or too small for a voxel, goes with what it is nearest to, the nearest first. A piece that was moved is
/// turned and shifted in double precision and rounded to float32; should it then cross itself it is shifted by some
/// hundred-thousandths of a millimetre until it does not.
/// @param mesh  of postOperativeMesh(): all pieces where they were loaded.
/// @param is_put_back  leaves all where they were loaded.
/// @param names  of the case, for PlacedPiece::objects. Solids of several names in a piece stand one name after the
///   other.
/// @return  in the order of `pieces`; without those that were dropped as crumbs.
/// Error kGeometry: two pieces hang together in the mesh, and one was moved; or a piece crosses itself wherever it is.
/// @cost  30 ns a triangle and piece, and the search for crossings of what was moved.
Expected<std::vector<PlacedPiece>> placedPieces(const Mesh& mesh, std::span<const RunManifest::Piece> pieces,
                                                bool is_put_back = false, const ObjectNames& names = {});

/// The solids of a mesh as pieces, the largest first. Of a cut that no session has divided. A piece has the name of its
/// object in the source, a further one of that object "tooth 36 2"; without one it is "piece 2" by its place.
/// @cost  as solidsOf().
std::vector<PlacedPiece> solidPieces(const Mesh& mesh, const ObjectNames& names = {});

/// A file for each: NAME-PIECE.stl of NAME.stl. Letters of any script, digits and "_" stay, all else becomes "-". A
/// long name is cut. A second file of the same name, also where capitals do not count, gets a number.
std::vector<std::filesystem::path> filesOfPieces(const std::filesystem::path& file,
                                                 std::span<const PlacedPiece> pieces);

/// Refuses to write over a file that the case was made of, by whatever name: its bytes are compared.
/// Error kBadValue.   @cost  reads the file, if there is one.
Expected<void> requireNoSource(const std::filesystem::path& file, const CaseManifest& manifest);

/// All in one mesh. Without a moved piece that is the mesh they were taken from, but for the order of its parts.
Mesh together(std::span<const PlacedPiece> pieces);
/// The named objects of that mesh; empty if none has a name.
std::vector<NamedPart> objectsOf(std::span<const PlacedPiece> pieces);

}  // namespace kerf
