#include "geometry/boolean/plane_cut.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "geometry/boolean/boolean.h"
#include "geometry/mesh/solids.h"

namespace kerf {
namespace {

constexpr double kCleanupLength = 1e-3;  // mm, as of an export at voxels of 0.1 mm
constexpr double kCrumb = 0.01;          // mm^3, the same

// ---- The room above all planes, as a closed mesh

// A convex solid by its faces, each a polygon of vertex indices, seen from outside counter-clockwise.
struct Convex {
  std::vector<Vec3d> vertices;
  std::vector<std::vector<std::uint32_t>> faces;
};

Convex boxAround(const Box3& box) {
  Convex out;
  for (int n = 0; n < 8; ++n) out.vertices.push_back(box.corner(n));
  out.faces = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  return out;
}

// Removes the part below a plane. Vertices on it, to within rounding, count as above.
Convex clipped(const Convex& solid, const Plane& plane) {
  constexpr double kOnPlane = 1e-12;  // of the largest coordinate
  double largest = 1;
  for (const Vec3d& p : solid.vertices) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  std::vector<double> height;
  for (const Vec3d& p : solid.vertices) height.push_back(plane.height(p));
  const auto isAbove = [&](std::uint32_t v) { return height[v] >= -kOnPlane * largest; };

  Convex out;
  std::map<std::uint32_t, std::uint32_t> kept;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> cut;  // by the edge that is cut
  const auto keep = [&](std::uint32_t v) {
    const auto [it, is_new] = kept.try_emplace(v, static_cast<std::uint32_t>(out.vertices.size()));
    if (is_new) out.vertices.push_back(solid.vertices[v]);
    return it->second;
  };
  const auto cutEdge = [&](std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto [it, is_new] = cut.try_emplace({a, b}, static_cast<std::uint32_t>(out.vertices.size()));
    if (is_new) {
      const double share = height[a] / (height[a] - height[b]);
      out.vertices.push_back(solid.vertices[a] + share * (solid.vertices[b] - solid.vertices[a]));
    }
    return it->second;
  };

  std::map<std::uint32_t, std::uint32_t> rim;  // of the new face: from vertex to vertex
  for (const std::vector<std::uint32_t>& face : solid.faces) {
    std::vector<std::uint32_t> left;
    std::optional<std::uint32_t> goes_down, comes_up;
    for (std::size_t n = 0; n < face.size(); ++n) {
      const std::uint32_t a = face[n], b = face[(n + 1) % face.size()];
      if (isAbove(a)) left.push_back(keep(a));
      if (isAbove(a) == isAbove(b)) continue;
      const std::uint32_t at = isAbove(a) && height[a] <= 0   ? keep(a)
                               : isAbove(b) && height[b] <= 0 ? keep(b)
                                                              : cutEdge(a, b);
      (isAbove(a) ? goes_down : comes_up) = at;
      if (left.empty() || left.back() != at) left.push_back(at);
    }
    while (left.size() > 1 && left.front() == left.back()) left.pop_back();
    if (left.size() >= 3) out.faces.push_back(left);
    if (goes_down && comes_up && *goes_down != *comes_up) rim[*comes_up] = *goes_down;
  }
  if (rim.empty()) return out;

  // A face runs along its cut from its downward crossing to its upward one; the new face runs the other way.
  std::vector<std::uint32_t> face{rim.begin()->first};
  while (face.size() <= rim.size()) {
    const auto next = rim.find(face.back());
    if (next == rim.end() || next->second == face.front()) break;
    face.push_back(next->second);
  }
  if (face.size() >= 3) out.faces.push_back(std::move(face));
  return out;
}

Mesh meshOf(const Convex& solid) {
  Mesh out;
  out.vertices = solid.vertices;
  for (const std::vector<std::uint32_t>& face : solid.faces)
    for (std::size_t n = 1; n + 1 < face.size(); ++n) out.triangles.push_back({face[0], face[n], face[n + 1]});
  return out;
}

// ---- Refusals

Error notMet(const Mesh& source, std::span<const Plane> planes, bool nothing_above) {
  std::string where;
  for (std::size_t n = 0; n < planes.size(); ++n) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Vec3d& p : source.vertices) {
      low = std::min(low, planes[n].height(p));
      high = std::max(high, planes[n].height(p));
    }
    where += fmt::format("{}the object lies from {:.3f} to {:.3f} mm above plane {}", n ? "; " : "", low, high, n + 1);
  }
  return {.code = Error::Code::kEmpty,
          .place = "plane cut",
          .found = nothing_above
                       ? "nothing of the object lies above" + std::string(planes.size() > 1 ? " all planes" : "")
                       : "the whole object lies above: nothing to cut",
          .expected = "planes that pass through it: " + where,
          .hint = "move the plane, or flip its normal"};
}

Error noRoom() {
  return {.code = Error::Code::kGeometry,
          .place = "plane cut",
          .found = "planes without a common space above them",
          .expected = "normals that point to the side to cut off",
          .hint = "flip a normal"};
}

// ---- The piece that is wanted

struct PieceBoxes {
  std::vector<Box3> boxes;
  std::uint32_t wanted = 0;
};

// A piece with its cavities is one.
PieceBoxes piecesNear(const Mesh& mesh, const Vec3d& point) {
  const Solids pieces = solidsOf(mesh);
  PieceBoxes out;
  out.boxes.resize(pieces.count);
  std::vector<double> nearest(pieces.count, std::numeric_limits<double>::infinity());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Vec3d p = mesh.corner(t, k);
      out.boxes[pieces.label[t]].add(p);
      nearest[pieces.label[t]] = std::min(nearest[pieces.label[t]], (p - point).norm());
    }
  for (std::uint32_t n = 0; n < pieces.count; ++n)
    if (nearest[n] < nearest[out.wanted]) out.wanted = n;
  return out;
}

// Planes around the wanted piece that exclude the other pieces; none for a single piece.
Expected<std::vector<Plane>> planesAround(const Mesh& above, const Vec3d& point) {
  constexpr double kMargin = 0.05;  // mm
  const PieceBoxes found = piecesNear(above, point);
  std::vector<Plane> out;
  if (found.boxes.size() < 2) return out;

  Box3 wanted = found.boxes[found.wanted];
  wanted.grow(kMargin);
  for (std::uint32_t n = 0; n < found.boxes.size(); ++n) {
    const Box3& other = found.boxes[n];
    if (n == found.wanted) continue;
    const bool is_apart =
        (other.min.array() > wanted.max.array()).any() || (other.max.array() < wanted.min.array()).any();
    if (is_apart) continue;
    return fail({.code = Error::Code::kGeometry,
                 .place = "plane cut",
                 .found = "another piece above the planes, too close to the wanted one",
                 .expected = "pieces whose boxes do not meet",
                 .hint = "add a plane between them"});
  }
  for (int axis = 0; axis < 3; ++axis) {
    out.push_back({wanted.min, Vec3d::Unit(axis)});
    out.push_back({wanted.max, -Vec3d::Unit(axis)});
  }
  return out;
}

// ---- The cut

// The space above all planes, within a box larger than the object.
Expected<Mesh> roomAbove(const Box3& box, std::span<const Plane> planes) {
  Convex room = boxAround(box);
  for (const Plane& plane : planes) room = clipped(room, plane);
  if (room.faces.size() < 4) return fail(noRoom());
  return meshOf(room);
}

struct Attempt {
  PlaneCut cut;
  std::string why_not;
};

// Half of the kerf is on either side of a plane: above on the side of the normal.
std::vector<Plane> movedBy(std::span<const Plane> planes, double mm) {
  std::vector<Plane> out(planes.begin(), planes.end());
  for (Plane& plane : out) plane.point += mm * plane.normal;
  return out;
}

double flatnessOf(const PostOpMesh& part, std::span<const Plane> planes) {
  double worst = 0;
  for (std::size_t t = 0; t < part.mesh.triangles.size(); ++t) {
    if (!part.is_cut[t]) continue;
    // A face lies wholly in one of the planes.
    double off = std::numeric_limits<double>::infinity();
    for (const Plane& plane : planes) {
      double here = 0;
      for (int k = 0; k < 3; ++k) here = std::max(here, std::abs(plane.height(part.mesh.corner(t, k))));
      off = std::min(off, here);
    }
    worst = std::max(worst, off);
  }
  return worst;
}

// A run's mesh has cut faces already: faces of the source keep their colours; faces of this cut are known by their
// origin.
// @param around  further planes of the room, without a kerf.
Expected<Attempt> attemptCut(const Mesh& source, const Box3& box, std::span<const Plane> planes,
                             std::span<const Plane> around, double kerf_mm, const PostOpOptions& options) {
  const auto roomOf = [&](std::span<const Plane> faces) {
    std::vector<Plane> all(faces.begin(), faces.end());
    all.insert(all.end(), around.begin(), around.end());
    return roomAbove(box, all);
  };
  const std::vector<Plane> above_faces = movedBy(planes, kerf_mm / 2), rest_faces = movedBy(planes, -kerf_mm / 2);
  KERF_TRY(room, roomOf(above_faces));
  KERF_TRY(inside, intersect(source, room));
  if (kerf_mm > 0) {
    KERF_TRY(wider, roomOf(rest_faces));
    room = std::move(wider);
  }
  KERF_TRY(outside, subtract(source, room, Reach::kWhole));  // without a kerf the same points as of the inside
  if (inside.mesh.triangles.empty()) return fail(notMet(source, planes, true));
  if (outside.mesh.triangles.empty()) return fail(notMet(source, planes, false));

  const double crumb = std::min(kCrumb, options.crumb_fraction * signedVolume(source));
  KERF_TRY(above, internal::finishCut(source, std::move(inside), kCleanupLength, crumb, options));
  KERF_TRY(rest, internal::finishCut(source, std::move(outside), kCleanupLength, crumb, options));
  Attempt out;
  out.why_not = !above.why_not.empty() ? above.why_not : rest.why_not;
  out.cut.above = std::move(above.result);
  out.cut.rest = std::move(rest.result);
  out.cut.flatness_mm = std::max(flatnessOf(out.cut.above, above_faces), flatnessOf(out.cut.rest, rest_faces));
  return out;
}

Expected<std::vector<Plane>> normalized(std::span<const Plane> planes) {
  std::vector<Plane> out;
  for (const Plane& plane : planes) {
    const double length = plane.normal.norm();
    if (!(length > 0) || !std::isfinite(length) || !plane.point.allFinite())
      return fail({.code = Error::Code::kBadValue,
                   .place = fmt::format("plane {}", out.size() + 1),
                   .found = "a normal of length 0, or a number that is not finite",
                   .expected = "a direction and a point, mm"});
    out.push_back({plane.point, plane.normal / length});
  }
  if (out.empty() || out.size() > kMostCutPlanes)
    return fail({.code = Error::Code::kBadValue,
                 .place = "planes",
                 .found = fmt::format("{} of them", out.size()),
                 .expected = fmt::format("1 to {}", kMostCutPlanes)});
  return out;
}

// The hole as a closed prism; both ends are fans. `turn` of a side sets its edges off.
Mesh prismOf(const RoundHole& hole, double turn, double longer_mm) {
  constexpr std::uint32_t kSides = 64;
  const Vec3d u = hole.axis.unitOrthogonal(), v = hole.axis.cross(u);
  Mesh out;
  for (const double along : {-longer_mm, hole.depth + longer_mm}) {
    for (std::uint32_t n = 0; n < kSides; ++n) {
      const double angle = 2 * std::numbers::pi * (n + turn) / kSides;
      out.vertices.push_back(hole.mouth + along * hole.axis +
                             0.5 * hole.diameter * (std::cos(angle) * u + std::sin(angle) * v));
    }
    out.vertices.push_back(hole.mouth + along * hole.axis);
  }
  constexpr std::uint32_t kTop = kSides + 1;
  for (std::uint32_t n = 0; n < kSides; ++n) {
    const std::uint32_t next = (n + 1) % kSides;
    out.triangles.push_back({kSides, next, n});
    out.triangles.push_back({kTop + kSides, kTop + n, kTop + next});
    out.triangles.push_back({n, next, kTop + next});
    out.triangles.push_back({n, kTop + next, kTop + n});
  }
  return out;
}

Error notPrintable(std::string why, const char* what) {
  return {.code = Error::Code::kGeometry,
          .place = what,
          .found = std::move(why),
          .expected = "a printable mesh",
          .hint = "move it by some hundredths of a millimetre, or kerf check on the source"};
}

// A plane through vertices of the object, or float32, may spoil a cut: then it is tried some 0.1 um farther.
constexpr int kAttempts = 8;
constexpr double kShift = 0.00013;  // mm

}  // namespace

Expected<std::optional<PostOpMesh>> withHole(const Mesh& source, const RoundHole& hole, const PostOpOptions& options) {
  const double crumb = std::min(kCrumb, options.crumb_fraction * signedVolume(source));
  Error last;
  for (int n = 0; n < kAttempts; ++n) {
    auto cut = subtract(source, prismOf(hole, 0.137 * n, n * kShift));
    if (!cut) {
      last = cut.error();
      continue;
    }
    if (cut->mesh.triangles.empty()) return fail(notPrintable("nothing of the object is left", "round hole"));
    const bool is_same =
        cut->mesh.triangles.size() == source.triangles.size() &&
        std::find(cut->from_triangle.begin(), cut->from_triangle.end(), kNoSource) == cut->from_triangle.end();
    if (is_same) return std::optional<PostOpMesh>{};
    KERF_TRY(done, internal::finishCut(source, std::move(*cut), kCleanupLength, crumb, options));
    if (done.why_not.empty()) return std::optional(std::move(done.result));
    last = notPrintable(done.why_not, "round hole");
  }
  return fail(last);
}

Expected<PlaneCut> cutByPlanes(const Mesh& source, std::span<const Plane> asked, const PlaneCutOptions& options,
                               const Progress& progress) {
  KERF_TRY(planes, normalized(asked));
  if (!(options.kerf_mm >= 0) || !std::isfinite(options.kerf_mm))
    return fail({.code = Error::Code::kBadValue,
                 .place = "kerf",
                 .found = fmt::format("{} mm", options.kerf_mm),
                 .expected = "0 mm or more"});
  Box3 box = bounds(source);
  // Sides that are no multiple of anything: a face of the box and one of the object must not lie in one plane.
  box.grow(0.1 * box.size().norm() + 1.0123);

  // Heights decide simple cases without a boolean.
  bool all_above = true;
  for (const Plane& plane : planes) {
    bool any_above = false;
    for (const Vec3d& p : source.vertices) {
      const bool is_above = plane.height(p) > 0;
      any_above |= is_above;
      all_above &= plane.height(p) >= 0;
    }
    if (!any_above) return fail(notMet(source, planes, true));
  }
  if (all_above) return fail(notMet(source, planes, false));

  std::vector<Plane> around;
  if (options.piece_at) {
    KERF_TRY(room, roomAbove(box, planes));
    KERF_TRY(inside, intersect(source, room));
    if (inside.mesh.triangles.empty()) return fail(notMet(source, planes, true));
    KERF_TRY(found, planesAround(inside.mesh, *options.piece_at));
    around = std::move(found);
  }

  Error last;
  for (int n = 1; n <= kAttempts; ++n) {
    if (!report(progress, (n - 1) / double{kAttempts}, "cutting")) return cancelled();
    const double shift = (n % 2 ? 1 : -1) * (n / 2) * kShift;
    auto tried = attemptCut(source, box, movedBy(planes, shift), around, options.kerf_mm, options.post_op);
    if (tried && tried->why_not.empty()) {
      tried->cut.attempts = n;
      tried->cut.shift_mm = std::abs(shift);
      return std::move(tried->cut);
    }
    last = tried ? notPrintable(tried->why_not, "plane cut") : tried.error();
    if (last.code == Error::Code::kEmpty) break;
  }
  return fail(last);
}

}  // namespace kerf
