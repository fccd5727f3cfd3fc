#include "sim/run/export/plane_parts_mesh.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "geometry/boolean/plane_cut.h"
#include "geometry/mesh/solids.h"
#include "sim/pieces/pieces.h"
#include "sim/pieces/plane_parts.h"
#include "sim/pieces/split_field.h"
#include "sim/run/export/export_bundle.h"

namespace kerf {
namespace {

using Sides = std::vector<PlaneSide>;

// Height above all sides, mm: negative outside the piece.
double heightOf(const Sides& sides, const Vec3d& p) {
  double out = sides.front().planes.height(p, sides.front().is_above);
  for (const PlaneSide& side : sides) out = std::min(out, side.planes.height(p, side.is_above));
  return out;
}

// The point on the other side of the plane, or of the wall of the hole, that is nearest.
Vec3d mirrored(const Sides& sides, const Vec3d& p, double height) {
  const PlaneSide* lowest = &sides.front();
  for (const PlaneSide& side : sides)
    if (side.planes.height(p, side.is_above) < lowest->planes.height(p, lowest->is_above)) lowest = &side;
  return p - 2 * height * lowest->planes.upwards(p, lowest->is_above);
}

// The value as cut where it is known, else as loaded.
float valueAt(const BrickField& changed, const BrickField& phi0, const Vec3i& node) {
  const BrickValues* const known = changed.valuesAt(brickOf(node));
  return known ? (*known)[static_cast<std::size_t>(nodeOffset(node[0], node[1], node[2]))] : phi0.at(node);
}

// The value at a point of the piece if a stroke changed a node of it around there, else none: not the air beside the
// object, which lies elsewhere on the other side of a plane.
std::optional<double> strokeAt(const Sides& sides, const BrickField& changed, const BrickField& phi0, const Vec3d& p) {
  const Vec3d nodes = p / phi0.voxel();
  const Vec3i base = nodes.array().floor().cast<int>();
  const Vec3d part = nodes - base.cast<double>();
  double out = 0;
  bool is_stroke = false;
  for (int n = 0; n < 8; ++n) {
    const Vec3i step(n & 1, n >> 1 & 1, n >> 2), node = base + step;
    double weight = 1;
    for (int c = 0; c < 3; ++c) weight *= step[c] ? part[c] : 1 - part[c];
    if (!(weight > 0)) continue;
    const float value = valueAt(changed, phi0, node);
    out += weight * static_cast<double>(value);
    const double height = heightOf(sides, phi0.position(node));
    is_stroke |= height >= 0 && value > planePartValue(phi0.at(node), height, phi0.background());
  }
  if (!is_stroke) return {};
  return out;
}

// Fields of the pieces with these sides: as the planes alone leave it, and its bricks changed by strokes.
struct SideFields {
  BrickField begin, changed;
};

// The field without crumbs of the planes alone: a session drops them after the cut. Those bricks where it differs.
class WithoutCrumbs {
 public:
  /// @param edits  phi0 as the planes alone leave it.   @cost  as PieceFinder, and nothing more without crumbs.
  WithoutCrumbs(const BrickField& phi0, std::span<const BrickEdit> edits) : field_(phi0.voxel(), phi0.background()) {
    PieceFinder finder(phi0);
    finder.apply(edits);
    const PieceList& list = finder.find();
    if (list.crumbs.empty()) return;

    const std::vector<PieceBricks> pieces = bricksOfPieces(finder, list.pieces.size());
    for (const PieceBricks& piece : pieces)
      for (const BrickEdit& edit : piece.changed) {
        if (field_.valuesAt(edit.brick)) continue;
        BrickValues values = edit.phi;
        for (const PieceBricks& other : pieces) addPiece(other, edit.brick, finder, values);
        field_.add(edit.brick, values);
      }
  }

  /// A value after the crumbs are dropped.
  float valueAt(const Vec3i& brick, std::size_t node, float value) const {
    const BrickValues* const known = field_.valuesAt(brick);
    return known ? std::max(value, (*known)[node]) : value;
  }

 private:
  // The union with another piece in a brick.
  static void addPiece(const PieceBricks& piece, const Vec3i& brick, const PieceFinder& finder, BrickValues& values) {
    const auto isBefore = [](const Vec3i& a, const Vec3i& b) { return coordKey(a) < coordKey(b); };
    if (!std::binary_search(piece.bricks.begin(), piece.bricks.end(), brick, isBefore)) return;
    const auto edit = std::find_if(piece.changed.begin(), piece.changed.end(),
                                   [&](const BrickEdit& other) { return other.brick == brick; });
    const BrickValues* const whole = finder.field().changed().valuesAt(brick);
    const BrickValues* const own = edit != piece.changed.end() ? &edit->phi : whole;
    if (!own) return;
    for (std::size_t n = 0; n < values.size(); ++n) values[n] = std::min(values[n], (*own)[n]);
  }

  BrickField field_;
};

SideFields fieldsOn(const Sides& sides, const BrickField& phi0, const BrickField& changed) {
  const float background = phi0.background();
  SideFields out{phi0, BrickField(phi0.voxel(), background, phi0.interior())};
  std::vector<BrickEdit> edits(changed.brickCount());
  for (std::size_t b = 0; b < edits.size(); ++b) {
    edits[b].brick = changed.brickCoord(b);
    for (int n = 0; n < kBrickNodes; ++n) {
      const Vec3i node = edits[b].brick * kBrickSide + Vec3i{n >> 6, n >> 3 & 7, n & 7};
      edits[b].phi[static_cast<std::size_t>(n)] =
          planePartValue(phi0.at(node), heightOf(sides, phi0.position(node)), background);
    }
  }
  const WithoutCrumbs without_crumbs(phi0, edits);

  for (std::size_t b = 0; b < changed.brickCount(); ++b) {
    const Vec3i coord = changed.brickCoord(b), base = coord * kBrickSide;
    const double half = 0.5 * (kBrickSide - 1) * phi0.voxel();
    const double middle = heightOf(sides, phi0.position(base) + Vec3d::Constant(half));
    if (middle + std::sqrt(3.0) * half < -static_cast<double>(background)) continue;  // beyond: cut away

    const BrickValues& begin = edits[b].phi;
    BrickValues now;
    for (int n = 0; n < kBrickNodes; ++n) {
      const auto i = static_cast<std::size_t>(n);
      const Vec3i node = base + Vec3i{n >> 6, n >> 3 & 7, n & 7};
      const Vec3d p = phi0.position(node);
      const double height = heightOf(sides, p);
      now[i] = changed.brick(b)[i];
      if (now[i] == without_crumbs.valueAt(coord, i, begin[i])) now[i] = begin[i];  // no stroke
      if (height >= 0 || now[i] >= std::min(static_cast<float>(-height), background)) continue;
      // Another piece lies there.
      const Vec3d inside = mirrored(sides, p, height);
      const auto cut = strokeAt(sides, changed, phi0, inside);
      now[i] = cut ? std::max(begin[i], std::min(static_cast<float>(*cut), background)) : begin[i];
    }
    out.begin.brick(out.begin.touch(coord)) = begin;
    if (now != begin) out.changed.add(coord, now);
  }
  return out;
}

// The piece of each solid: the one whose inner point it holds, else that of the nearest box.
std::vector<std::size_t> piecesOfSolids(const Mesh& mesh, const Solids& solids,
                                        std::span<const RunManifest::Piece> pieces) {
  constexpr auto kNone = static_cast<std::size_t>(-1);
  std::vector<std::size_t> out(solids.count, kNone);
  for (std::size_t n = 0; n < pieces.size(); ++n)
    if (const auto solid = solidAt(mesh, solids, pieces[n].inside); solid && out[*solid] == kNone) out[*solid] = n;
  std::vector<Box3> boxes(solids.count);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) boxes[solids.label[t]].add(mesh.corner(t, k));
  const std::vector<std::size_t> known = out;
  for (std::size_t s = 0; s < out.size(); ++s) {
    double nearest = 0;
    for (std::size_t k = 0; known[s] == kNone && k < out.size(); ++k) {
      if (known[k] == kNone) continue;
      const Vec3d apart = (boxes[k].min - boxes[s].max).cwiseMax(boxes[s].min - boxes[k].max).cwiseMax(Vec3d::Zero());
      if (out[s] != kNone && apart.norm() >= nearest) continue;
      nearest = apart.norm();
      out[s] = known[k];
    }
    if (out[s] == kNone) out[s] = 0;
  }
  return out;
}

// Keeps the solids of some pieces; all of them: the mesh stays as it is, to the bit.
template <class Wanted>
void keepSolids(PostOpMesh& part, std::span<const RunManifest::Piece> pieces, const Wanted& wanted) {
  if (std::all_of(pieces.begin(), pieces.end(), wanted)) return;
  const Solids solids = solidsOf(part.mesh);
  const std::vector<std::size_t> piece_of = piecesOfSolids(part.mesh, solids, pieces);
  std::vector<char> keeps(part.mesh.triangles.size(), 0), is_used(part.mesh.vertices.size(), 0);
  for (std::size_t t = 0; t < keeps.size(); ++t) {
    keeps[t] = wanted(pieces[piece_of[solids.label[t]]]);
    if (keeps[t])
      for (const std::uint32_t v : part.mesh.triangles[t]) is_used[v] = 1;
  }
  if (std::find(keeps.begin(), keeps.end(), 0) == keeps.end()) return;

  PostOpMesh out;
  out.report = part.report;
  out.mesh = subset(part.mesh, keeps);
  for (std::size_t t = 0; t < keeps.size(); ++t)
    if (keeps[t]) out.is_cut.push_back(part.is_cut[t]);
  for (std::size_t v = 0; v < is_used.size(); ++v)
    if (is_used[v]) out.is_source.push_back(part.is_source[v]);
  part = std::move(out);
}

// A further cut of a part: the report keeps what happened before.
Expected<void> cutOnce(PostOpMesh& part, const PlaneSide& side, const PostOpOptions& options,
                       const Progress& progress) {
  if (side.planes.count > 0) {
    PlaneCutOptions by;
    by.kerf_mm = side.planes.kerf_mm;
    by.post_op = options;
    auto cut = cutByPlanes(part.mesh, side.planes.planes(), by, progress);
    if (!cut) return fail(std::move(cut).error());
    part = std::move(side.is_above ? cut->above : cut->rest);
  }
  if (!side.planes.hasHole()) return {};
  auto drilled = withHole(part.mesh, side.planes.hole(), options);
  if (!drilled) return fail(std::move(drilled).error());
  if (*drilled) part = std::move(**drilled);
  return {};
}

void appendPart(PostOpMesh& to, PostOpMesh part) {
  if (to.mesh.vertices.empty()) {
    to = std::move(part);
    return;
  }
  kerf::append(to.mesh, part.mesh);
  to.is_cut.insert(to.is_cut.end(), part.is_cut.begin(), part.is_cut.end());
  to.is_source.insert(to.is_source.end(), part.is_source.begin(), part.is_source.end());
  to.report.largest_move_mm = std::max(to.report.largest_move_mm, part.report.largest_move_mm);
  to.report.crumbs_dropped += part.report.crumbs_dropped;
  to.report.crumbs_volume_mm3 += part.report.crumbs_volume_mm3;
}

bool beginsWith(const Sides& sides, const Sides& begin, std::size_t count) {
  return sides.size() >= count &&
         std::equal(begin.begin(), begin.begin() + static_cast<std::ptrdiff_t>(count), sides.begin());
}

// Counts what the parts together hold.
void countTogether(PostOpMesh& all, const Mesh& solid) {
  // Each cut took the walls of the strokes for its source: a source vertex has the coordinates of one in the solid.
  const auto isBefore = [](const Vec3d& a, const Vec3d& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::vector<Vec3d> known = solid.vertices;
  std::sort(known.begin(), known.end(), isBefore);
  for (std::size_t v = 0; v < all.is_source.size(); ++v)
    all.is_source[v] =
        all.is_source[v] && std::binary_search(known.begin(), known.end(), all.mesh.vertices[v], isBefore);

  PostOpReport& r = all.report;
  r.source_volume_mm3 = signedVolume(solid);
  r.result_volume_mm3 = signedVolume(all.mesh);
  r.removed_volume_mm3 = r.source_volume_mm3 - r.result_volume_mm3;
  const auto count = countPieces(all.mesh);
  r.pieces = count.pieces;
  r.cavities = count.cavities;
  r.cut_triangles = static_cast<std::size_t>(std::count(all.is_cut.begin(), all.is_cut.end(), 1));
  r.source_vertices_kept = static_cast<std::size_t>(std::count(all.is_source.begin(), all.is_source.end(), 1));
  r.source_vertices_removed = solid.vertices.size() - std::min(solid.vertices.size(), r.source_vertices_kept);
}

}  // namespace

bool areCutByPlanes(std::span<const RunManifest::Piece> pieces) {
  return std::any_of(pieces.begin(), pieces.end(), [](const auto& piece) { return !piece.sides.empty(); });
}

std::size_t countTouching(std::span<const RunManifest::Piece> pieces, bool is_put_back) {
  const auto isAcross = [](const PlaneSide& a, const PlaneSide& b) {
    return a.cut == b.cut && a.is_above != b.is_above && a.planes.kerf_mm == 0;
  };
  const auto isMoved = [&](const RunManifest::Piece& piece) { return piece.isMoved() && !is_put_back; };
  const auto touches = [&](const RunManifest::Piece& piece) {
    for (const RunManifest::Piece& other : pieces)
      for (const PlaneSide& a : piece.sides)
        for (const PlaneSide& b : other.sides)
          if (isAcross(a, b) && !isMoved(piece) && !isMoved(other)) return true;
    return false;
  };
  return static_cast<std::size_t>(std::count_if(pieces.begin(), pieces.end(), touches));
}

Expected<PostOpMesh> planePartsMesh(const Mesh& solid, const BrickField& phi0, const BrickField& changed,
                                    std::span<const RunManifest::Piece> pieces, const PostOpOptions& options,
                                    const Progress& progress) {
  std::vector<Sides> groups;
  for (const RunManifest::Piece& piece : pieces)
    if (std::find(groups.begin(), groups.end(), piece.sides) == groups.end()) groups.push_back(piece.sides);

  PostOpMesh out;
  for (const Sides& group : groups) {
    std::optional<SideFields> fields;
    if (!group.empty()) fields = fieldsOn(group, phi0, changed);
    KERF_TRY(part, postOperativeMeshOf(solid, fields ? fields->begin : phi0, fields ? fields->changed : changed,
                                       options, progress));
    for (std::size_t n = 0; n < group.size(); ++n) {
      keepSolids(part, pieces, [&](const RunManifest::Piece& piece) {
        return beginsWith(piece.sides, group, n) && piece.sides.size() > n && piece.sides[n].cut == group[n].cut;
      });
      KERF_CHECK(cutOnce(part, group[n], options, progress));
    }
    keepSolids(part, pieces, [&](const RunManifest::Piece& piece) { return piece.sides == group; });
    appendPart(out, std::move(part));
  }
  countTogether(out, solid);
  return out;
}

}  // namespace kerf
