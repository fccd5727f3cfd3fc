#include "sim/run/placed_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "geometry/base/hash.h"
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

std::vector<std::filesystem::path> filesOfPieces(const std::filesystem::path& file,
                                                 std::span<const PlacedPiece> pieces) {
  constexpr std::size_t kMostLetters = 60;
  std::vector<std::filesystem::path> out;
  std::set<std::string> taken;
  for (const PlacedPiece& piece : pieces) {
    std::string name, small;
    for (const char letter : piece.name.substr(0, kMostLetters))
      name += std::isalnum(static_cast<unsigned char>(letter)) || letter == '_' ? letter : '-';
    for (int n = 1;; ++n) {
      const std::string numbered = n == 1 ? name : fmt::format("{}-{}", name, n);
      small = numbered;
      for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      if (!taken.insert(small).second) continue;
      out.push_back(file);
      out.back().replace_filename(fmt::format("{}-{}{}", file.stem().string(), numbered, file.extension().string()));
      break;
    }
  }
  return out;
}

Expected<void> requireNoSource(const std::filesystem::path& file, const CaseManifest& manifest) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return {};
  const auto hash = sha256OfFile(file);
  if (!hash) return {};  // what cannot be read is no scan that was read
  for (const CaseSource& source : manifest.sources)
    if (source.sha256 == *hash)
      return fail({.code = Error::Code::kBadValue,
                   .file = file.string(),
                   .found = "a file that the case was made of",
                   .expected = "another name: a scan is never written over",
                   .hint = "another name or folder"});
  return {};
}

Mesh together(std::span<const PlacedPiece> pieces) {
  Mesh out;
  for (const PlacedPiece& piece : pieces) append(out, piece.mesh);
  return out;
}

}  // namespace kerf
