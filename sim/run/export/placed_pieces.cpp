#include "sim/run/export/placed_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "geometry/base/hash.h"
#include "geometry/base/text.h"
#include "geometry/field/brick_field.h"
#include "geometry/mesh/rigid_move.h"
#include "geometry/mesh/solids.h"

namespace kerf {
namespace {

constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

tl::unexpected<Error> hangTogether(const RunManifest::Piece& a, const RunManifest::Piece& b) {
  return fail({.code = Error::Code::kGeometry,
               .place = "pieces",
               .found = fmt::format("\"{}\" and \"{}\" are connected by less than a voxel", a.name, b.name),
               .expected = "pieces that are apart",
               .hint = "cut through between them once more, or put both back"});
}

// Whether both are where they were loaded, or moved alike: parts of one former piece, whose joint does not tear.
bool standTogether(const RunManifest::Piece& a, const RunManifest::Piece& b) {
  if (!a.isMoved() && !b.isMoved()) return true;
  const Rigid3 &one = a.T_case_piece, &other = b.T_case_piece;
  return one.translation == other.translation && one.rotation.coeffs() == other.rotation.coeffs();
}

// ---- Solids without a piece's inner point: they touch others of their piece, or are too small for a voxel

using Cell = std::uint64_t;
using SolidPair = std::pair<std::uint32_t, std::uint32_t>;

Cell cellOf(const Vec3d& p, double side) {
  return coordKey(static_cast<int>(std::floor(p[0] / side)), static_cast<int>(std::floor(p[1] / side)),
                  static_cast<int>(std::floor(p[2] / side)));
}

// Vertices of the solids, one of each solid in a cell: bounds the number within reach of one another.
std::vector<std::uint32_t> thinned(const Mesh& mesh, const std::vector<std::uint32_t>& solid_of, double side) {
  std::vector<std::uint32_t> out;
  std::set<std::pair<Cell, std::uint32_t>> taken;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
    if (solid_of[v] != kNobody && taken.insert({cellOf(mesh.vertices[v], side), solid_of[v]}).second) out.push_back(v);
  return out;
}

// Least distances between vertices of different solids, mm, of those nearer than `reach`, accurate to a quarter of it.
std::map<SolidPair, double> nearPairs(const Mesh& mesh, const std::vector<std::uint32_t>& solid_of, double reach) {
  const std::vector<std::uint32_t> vertices = thinned(mesh, solid_of, 0.25 * reach);
  std::unordered_map<Cell, std::vector<std::uint32_t>> cells;
  for (const std::uint32_t v : vertices) cells[cellOf(mesh.vertices[v], reach)].push_back(v);

  std::map<SolidPair, double> out;
  const auto compare = [&](std::uint32_t v, std::uint32_t w) {
    const std::uint32_t one = solid_of[v], other = solid_of[w];
    if (one >= other) return;
    const double far = (mesh.vertices[v] - mesh.vertices[w]).norm();
    if (far > reach) return;
    const auto known = out.try_emplace({one, other}, far).first;
    known->second = std::min(known->second, far);
  };
  for (const std::uint32_t v : vertices)
    for (int n = 0; n < 27; ++n) {
      const Vec3d beside = mesh.vertices[v] + reach * Vec3d(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      const auto cell = cells.find(cellOf(beside, reach));
      if (cell == cells.end()) continue;
      for (const std::uint32_t w : cell->second) compare(v, w);
    }
  return out;
}

// Joins the nearest solids first, step by step outwards; never two that belong to different pieces.
void claimByNearness(const Mesh& mesh, const Solids& solids, std::vector<std::uint32_t>& owner) {
  constexpr double kBegin = 0.05, kMost = 1000;  // mm
  std::vector<std::uint32_t> solid_of(mesh.vertices.size(), kNobody);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) solid_of[v] = solids.label[t];

  std::vector<std::uint32_t> group(solids.count);
  std::iota(group.begin(), group.end(), 0u);
  const auto isLeft = [&] { return std::find(owner.begin(), owner.end(), kNobody) != owner.end(); };
  for (double reach = kBegin; reach < kMost && isLeft(); reach *= 2) {
    std::vector<std::pair<double, SolidPair>> pairs;
    for (const auto& [pair, far] : nearPairs(mesh, solid_of, reach)) pairs.emplace_back(far, pair);
    std::sort(pairs.begin(), pairs.end());
    for (const auto& [far, pair] : pairs) {
      const std::uint32_t one = group[pair.first], other = group[pair.second];
      const std::uint32_t a = owner[pair.first], b = owner[pair.second];
      if (one == other || (a != kNobody && b != kNobody)) continue;
      for (std::uint32_t solid = 0; solid < solids.count; ++solid) {
        if (group[solid] != one && group[solid] != other) continue;
        group[solid] = one;
        owner[solid] = a != kNobody ? a : b;
      }
    }
  }
}

// The number of each solid's piece.
Expected<std::vector<std::uint32_t>> ownersOf(const Mesh& mesh, const Solids& solids,
                                              std::span<const RunManifest::Piece> pieces, bool is_put_back) {
  std::vector<std::uint32_t> owner(solids.count, kNobody);
  for (std::uint32_t n = 0; n < pieces.size(); ++n) {
    const auto solid = solidAt(mesh, solids, pieces[n].inside);
    if (!solid) continue;  // dropped as a crumb
    const std::uint32_t other = owner[*solid];
    if (!is_put_back && other != kNobody && !standTogether(pieces[other], pieces[n]))
      return hangTogether(pieces[other], pieces[n]);
    if (other == kNobody) owner[*solid] = n;
  }

  claimByNearness(mesh, solids, owner);
  for (std::uint32_t& whose : owner)
    if (whose == kNobody) whose = 0;
  return owner;
}

Expected<Mesh> moved(const Mesh& mesh, const RunManifest::Piece& piece) {
  auto out = rigidlyMoved(mesh, piece.T_case_piece);
  if (!out) {
    out.error().place = fmt::format("piece \"{}\"", piece.name);
    out.error().hint += ", or put it back";
  }
  return out;
}

// Adds its triangles to the piece, under their names.
void setMesh(PlacedPiece& piece, NamedMesh named) {
  piece.mesh = std::move(named.mesh);
  piece.objects = std::move(named.objects);
}

// Makes names unique: the second "tooth" is "tooth 2".
class UnusedNames {
 public:
  std::string take(const std::string& name, std::string_view between = " ") {
    std::string out = name;
    for (int& n = next_.try_emplace(name, 2).first->second; !taken_.insert(out).second; ++n)
      out = fmt::format("{}{}{}", name, between, n);
    return out;
  }

 private:
  std::set<std::string> taken_;
  std::map<std::string, int> next_;
};

std::string lowered(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

bool isNamedByUser(std::string_view piece) {
  constexpr std::string_view kGiven = "piece ";
  if (!piece.starts_with(kGiven)) return !piece.empty();
  return piece.find_first_not_of("0123456789", kGiven.size()) != piece.npos;
}

Expected<std::vector<PlacedPiece>> placedPieces(const Mesh& mesh, std::span<const RunManifest::Piece> pieces,
                                                bool is_put_back, const ObjectNames& names) {
  std::vector<PlacedPiece> out;
  if (pieces.empty()) {
    setMesh(out.emplace_back(PlacedPiece{.name = "piece 1"}), names.grouped(mesh));
    return out;
  }
  const Solids solids = solidsOf(mesh);
  KERF_TRY(owner, ownersOf(mesh, solids, pieces, is_put_back));

  for (std::uint32_t n = 0; n < pieces.size(); ++n) {
    std::vector<char> is_kept(mesh.triangles.size());
    for (std::size_t t = 0; t < is_kept.size(); ++t) is_kept[t] = owner[solids.label[t]] == n;
    PlacedPiece placed{pieces[n].id, pieces[n].name, !is_put_back && pieces[n].isMoved(), subset(mesh, is_kept), {}};
    if (placed.mesh.triangles.empty()) continue;
    if (isNamedByUser(pieces[n].name))
      placed.objects.push_back({pieces[n].name, 0});
    else
      setMesh(placed, names.grouped(placed.mesh));
    if (placed.is_moved) {
      KERF_TRY(there, moved(placed.mesh, pieces[n]));
      placed.mesh = std::move(there);
    }
    out.push_back(std::move(placed));
  }
  return out;
}

std::vector<PlacedPiece> solidPieces(const Mesh& mesh, const ObjectNames& names) {
  std::vector<PlacedPiece> out;
  for (Mesh& part : separated(mesh, solidsOf(mesh))) {
    std::string name = names.nameOf(part);
    out.push_back({0, std::move(name), false, std::move(part), {}});
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return signedVolume(a.mesh) > signedVolume(b.mesh); });
  UnusedNames unused;
  for (std::size_t n = 0; n < out.size(); ++n) {
    PlacedPiece& piece = out[n];
    if (!piece.name.empty()) piece.objects.push_back({piece.name, 0});
    piece.name = unused.take(piece.name.empty() ? fmt::format("piece {}", n + 1) : piece.name);
  }
  return out;
}

std::vector<std::filesystem::path> filesOfPieces(const std::filesystem::path& file,
                                                 std::span<const PlacedPiece> pieces) {
  constexpr std::size_t kMostBytes = 60;
  // Excludes the marks of U+2000 to U+206F, which turn the direction of text or have no width.
  const auto isLetter = [](std::string_view letter) {
    const auto byte = [&](std::size_t n) { return static_cast<unsigned char>(letter[n]); };
    if (letter.size() > 1) return byte(0) != 0xe2 || byte(1) > 0x81;
    return std::isalnum(byte(0)) || letter[0] == '_';
  };
  const auto fileName = [&](const std::string& piece) {
    const std::string utf8 = printable(piece);
    std::string name;
    for (std::size_t at = 0; at < utf8.size();) {
      const std::string letter = utf8.substr(at, utf8Length(utf8, at));
      if (name.size() + letter.size() > kMostBytes) break;
      name += isLetter(letter) ? letter : "-";
      at += letter.size();
    }
    return name;
  };
  std::vector<std::filesystem::path> out;
  UnusedNames unused;
  for (const PlacedPiece& piece : pieces) {
    const std::string name = fileName(piece.name);
    const std::string numbered = name + unused.take(lowered(name), "-").substr(name.size());
    out.push_back(file);
    out.back().replace_filename(fmt::format("{}-{}{}", file.stem().string(), numbered, file.extension().string()));
  }
  return out;
}

Expected<void> requireNoSource(const std::filesystem::path& file, const CaseManifest& manifest) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return {};
  const auto hash = sha256OfFile(file);
  if (!hash) return {};  // an unreadable file is not the source
  for (const CaseSource& source : manifest.sources)
    if (source.sha256 == *hash)
      return fail({.code = Error::Code::kBadValue,
                   .file = file.string(),
                   .found = "a source file of the case, or a copy of it, such as an export without cuts",
                   .expected = "another name: Kerf never overwrites a scan",
                   .hint = "another name or folder"});
  return {};
}

Mesh together(std::span<const PlacedPiece> pieces) {
  Mesh out;
  for (const PlacedPiece& piece : pieces) append(out, piece.mesh);
  return out;
}

std::vector<NamedPart> objectsOf(std::span<const PlacedPiece> pieces) {
  std::vector<NamedPart> out;
  std::size_t first = 0;
  for (const PlacedPiece& piece : pieces) {
    if (piece.objects.empty()) out.push_back({"", first});
    for (const NamedPart& object : piece.objects) out.push_back({object.name, first + object.first_triangle});
    first += piece.mesh.triangles.size();
  }
  const auto is_named = [](const NamedPart& part) { return !part.name.empty(); };
  if (std::none_of(out.begin(), out.end(), is_named)) out.clear();
  return out;
}

}  // namespace kerf
