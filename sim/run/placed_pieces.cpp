#include "sim/run/placed_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <optional>
#include <utility>

#include "geometry/mesh/self_intersection.h"
#include "geometry/mesh/solids.h"

namespace kerf {
namespace {

using Piece = RunManifest::Piece;
constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

tl::unexpected<Error> hangTogether(const Piece& a, const Piece& b) {
  return fail({.code = Error::Code::kGeometry,
               .place = "pieces",
               .found = fmt::format("\"{}\" and \"{}\" hang together by less than a voxel", a.name, b.name),
               .expected = "pieces that are apart",
               .hint = "cut through between them once more, or put both back"});
}

// The nearest vertex decides.
std::uint32_t nearestOwner(const Mesh& mesh, const Solids& solids, const std::vector<std::uint32_t>& owner,
                           std::uint32_t solid) {
  const auto first = std::find(solids.label.begin(), solids.label.end(), solid) - solids.label.begin();
  const Vec3d here = mesh.corner(static_cast<std::size_t>(first), 0);
  double least = std::numeric_limits<double>::infinity();
  std::uint32_t out = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t whose = owner[solids.label[t]];
    const double far = whose == kNobody ? least : (mesh.corner(t, 0) - here).squaredNorm();
    if (far >= least) continue;
    least = far;
    out = whose;
  }
  return out;
}

// Of each solid, the number of its piece.
Expected<std::vector<std::uint32_t>> ownersOf(const Mesh& mesh, const Solids& solids, std::span<const Piece> pieces,
                                              bool is_put_back) {
  std::vector<std::uint32_t> owner(solids.count, kNobody);
  for (std::uint32_t n = 0; n < pieces.size(); ++n) {
    const auto solid = solidAt(mesh, solids, pieces[n].inside);
    if (!solid) continue;  // dropped as a crumb
    const std::uint32_t other = owner[*solid];
    const bool is_moved = !is_put_back && other != kNobody && (pieces[n].isMoved() || pieces[other].isMoved());
    if (is_moved) return hangTogether(pieces[other], pieces[n]);
    if (other == kNobody) owner[*solid] = n;
  }

  std::vector<std::uint32_t> out = owner;
  for (std::uint32_t solid = 0; solid < solids.count; ++solid)
    if (owner[solid] == kNobody) out[solid] = nearestOwner(mesh, solids, owner, solid);
  return out;
}

bool crossesItself(const Mesh& mesh) { return !selfIntersections(mesh.vertices, mesh.triangles, 1).empty(); }

Expected<Mesh> moved(const Mesh& mesh, const Piece& piece) {
  constexpr int kAttempts = 12;
  constexpr double kShift = 1e-5;  // mm
  Mesh out = mesh;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Vec3d shift = kShift * attempt * Vec3d(0.37, -0.61, 0.70);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      out.vertices[v] = roundedToFloat(piece.T_case_piece * mesh.vertices[v] + shift);
    if (!crossesItself(out)) return out;
  }
  return fail({.code = Error::Code::kGeometry,
               .place = fmt::format("piece \"{}\"", piece.name),
               .found = "its surface crosses itself where it was moved to, rounded to single precision",
               .expected = "a surface that can be printed",
               .hint = "turn it by a tenth of a degree more, or put it back"});
}

}  // namespace

Expected<std::vector<PlacedPiece>> placedPieces(const Mesh& mesh, std::span<const Piece> pieces, bool is_put_back) {
  std::vector<PlacedPiece> out;
  if (pieces.empty()) {
    out.push_back({0, "piece 1", false, mesh});
    return out;
  }
  const Solids solids = solidsOf(mesh);
  KERF_TRY(owner, ownersOf(mesh, solids, pieces, is_put_back));

  for (std::uint32_t n = 0; n < pieces.size(); ++n) {
    std::vector<char> is_kept(mesh.triangles.size());
    for (std::size_t t = 0; t < is_kept.size(); ++t) is_kept[t] = owner[solids.label[t]] == n;
    PlacedPiece placed{pieces[n].id, pieces[n].name, !is_put_back && pieces[n].isMoved(), subset(mesh, is_kept)};
    if (placed.mesh.triangles.empty()) continue;
    if (placed.is_moved) {
      KERF_TRY(there, moved(placed.mesh, pieces[n]));
      placed.mesh = std::move(there);
    }
    out.push_back(std::move(placed));
  }
  return out;
}

std::filesystem::path fileOfPiece(const std::filesystem::path& file, const std::string& piece) {
  std::string name = piece;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && static_cast<unsigned char>(c) < 128 && c != '_') c = '-';
  std::filesystem::path out = file;
  out.replace_filename(file.stem().string() + "-" + name + file.extension().string());
  return out;
}

Mesh together(std::span<const PlacedPiece> pieces) {
  Mesh out;
  for (const PlacedPiece& piece : pieces) append(out, piece.mesh);
  return out;
}

}  // namespace kerf
