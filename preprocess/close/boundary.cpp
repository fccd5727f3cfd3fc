#include "preprocess/close/boundary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/mesh/crossing_pairs.h"
#include "geometry/mesh/float32_cleanup.h"
#include "preprocess/close/base.h"
#include "preprocess/close/hole.h"
#include "preprocess/close/openness.h"
#include "preprocess/close/poll.h"
#include "preprocess/close/smooth_base.h"
#include "preprocess/close/trim.h"

namespace kerf::internal {
namespace {

double length(const Mesh& mesh, const Loop& loop) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    sum += (mesh.vertices[loop[i]] - mesh.vertices[loop[(i + 1) % loop.size()]]).norm();
  return sum;
}

/// Twice the area vector of any surface that closes the loop.
Vec3d areaVector(const Mesh& mesh, const Loop& loop) {
  const Vec3d c = mesh.vertices[loop[0]];
  Vec3d sum = Vec3d::Zero();
  for (std::size_t i = 1; i + 1 < loop.size(); ++i)
    sum += (mesh.vertices[loop[i]] - c).cross(mesh.vertices[loop[i + 1]] - c);
  return sum;
}

struct Direction {
  int axis;
  int sign;
  Vec3d vector() const { return sign * Vec3d::Unit(axis); }
};
std::string nameOf(const Direction& d) { return fmt::format("{}{}", d.sign < 0 ? '-' : '+', "xyz"[d.axis]); }
Direction nearestAxis(const Vec3d& v) {
  int axis = 0;
  v.cwiseAbs().maxCoeff(&axis);
  return {axis, v[axis] < 0 ? -1 : 1};
}

Error ungrounded(std::string found, std::string hint) {
  Error e;
  e.code = Error::Code::kGeometry;
  e.found = std::move(found);
  e.hint = std::move(hint);
  return e;
}

void turnAll(Chain& chain, std::vector<Loop>& loops) {
  for (Triangle& f : chain.mesh.triangles) std::swap(f[1], f[2]);
  for (Loop& loop : loops) std::reverse(loop.begin(), loop.end());
}

/// Farthest vertex along `w`.
double reach(const Mesh& mesh, const Vec3d& w) {
  double far = -std::numeric_limits<double>::infinity();
  for (const Vec3d& p : mesh.vertices) far = std::max(far, p.dot(w));
  return far;
}

double degreesToNearestAxis(const Vec3d& w) {
  return std::acos(std::clamp(w.cwiseAbs().maxCoeff() / w.norm(), 0.0, 1.0)) * 180 / std::numbers::pi;
}

/// Opening of a scan, from its rim. A scan is a bowl upside down: its rim lies on the open side. A ribbon of gum, whose
/// rim also runs around the teeth, gives no answer.
struct Opening {
  Vec3d direction;  ///< unit: by the triangles' orientation
  double rim_side;  ///< offset of the rim that way from the centroid, along the nearest axis, relative to the extent
                    ///< there
  static constexpr double kClear = 0.15;  ///< 0.2 to 0.6 on scans, with either sign
  bool isClear() const { return std::abs(rim_side) > kClear; }
  /// The true opening: if the rim lies behind, the triangles are inside out.
  Vec3d trueDirection() const { return rim_side < 0 ? Vec3d(-direction) : direction; }
};

Opening measureOpening(const Mesh& mesh, const Loop& loop) {
  Vec3d rim = Vec3d::Zero(), centroid = Vec3d::Zero();
  double area = 0;
  const double around = length(mesh, loop);
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec3d &p = mesh.vertices[loop[i]], &q = mesh.vertices[loop[(i + 1) % loop.size()]];
    rim += (p - q).norm() / around * 0.5 * (p + q);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double a = doubleAreaVector(mesh, t).norm();
    area += a;
    centroid += a / 3 * (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2));
  }
  centroid /= area;
  const Vec3d open = areaVector(mesh, loop);
  const Direction axis = nearestAxis(open);
  const double extent = bounds(mesh).size()[axis.axis];
  return {open.normalized(), extent > 0 ? (rim - centroid).dot(axis.vector()) / extent : 0};
}

/// True if all triangles must be turned. If neither the rim nor the rim and the file together decide, the base
/// direction decides. Errors: kGeometry for a base direction that leads away from the opening: walls would run through
/// the teeth.
Expected<bool> isInsideOut(const Opening& opening, const CloseOptions& options) {
  if (!options.base_direction) return opening.rim_side < -Opening::kClear;
  const Vec3d asked = nearestAxis(*options.base_direction).vector();
  constexpr double kAgrees = 0.02;  // a ragged rim, but on the side of the file's orientation: 0.09 on a lower jaw
  if (!opening.isClear() && opening.rim_side < kAgrees) return opening.direction.dot(asked) < 0;
  const double least = opening.isClear() ? 0.25 : -0.25;  // 75 degrees off, or 105: a ragged rim is 40 off itself
  const Vec3d open = opening.trueDirection();
  if (open.dot(asked) >= least) return opening.rim_side < 0;
  const Direction found = nearestAxis(open);
  Error e = ungrounded(fmt::format("a base towards {}, but the scan is open towards {}: ({:.2f}, {:.2f}, {:.2f})",
                                   nameOf(nearestAxis(asked)), nameOf(found), open.x(), open.y(), open.z()),
                       fmt::format("use --base-direction {}, or omit it", nameOf(found)));
  e.expected = "a base on the open side";
  return fail(std::move(e));
}

/// The base below the occlusal plane, or below the highest point.
/// @param lowest  the lowest vertex, mm along w.   @param occlusal  the plane's height along w, if any.
Expected<double> levelByHeight(const Chain& chain, const Vec3d& w, double lowest, std::optional<double> occlusal,
                               double height_mm) {
  constexpr double kLeastMargin = 0.5;
  const double top = occlusal.value_or(-reach(chain.mesh, -w));
  const double level = top + height_mm;
  if (!(level < lowest + kLeastMargin)) return level;
  const double least = std::ceil(10 * (lowest + kLeastMargin - top)) / 10;
  Error e = ungrounded(fmt::format("a base {} mm below {}, but the scan reaches {:.2f} mm below it", height_mm,
                                   occlusal ? "the occlusal plane" : "the highest point", lowest - top),
                       fmt::format("--base-height {:.1f}", least));
  e.expected = fmt::format("a base height of at least {:.1f} mm", least);
  return fail(std::move(e));
}

/// Plane of the base. @param down  roughly: a coordinate axis.  @param open  opening of the scan.
Expected<BaseFrame> placeBase(const Chain& chain, const Vec3d& down, const Vec3d& open, const CloseOptions& options,
                              CloseReport& report) {
  // Which way it faces.
  Vec3d w = down;
  std::optional<double> occlusal;  // the plane's height, along w
  if (options.occlusal_plane) {
    w = options.occlusal_plane->normal.normalized();
    if (w.dot(down) < 0) w = -w;
    constexpr double kCosMostTilt = 0.5;  // 60 degrees
    if (w.dot(down) < kCosMostTilt) {
      Error e = ungrounded(fmt::format("an occlusal plane that stands {:.0f} degrees to the underside",
                                       std::acos(w.dot(down)) * 180 / std::numbers::pi),
                           "its normal, not a direction in it; or --base-direction");
      e.expected = "at most 60 degrees";
      return fail(std::move(e));
    }
    if (options.occlusal_plane->point) occlusal = options.occlusal_plane->point->dot(w);
  } else if (options.find_occlusal_plane) {
    KERF_TRY(plane, findOcclusalPlane(chain.mesh, options.base_direction ? Vec3d(-down) : Vec3d(-open)));
    w = -plane.normal;
    occlusal = plane.point.dot(w);
    report.occlusal_plane = plane;
    report.changes.push_back(fmt::format(
        "the occlusal plane was found: normal ({:.4f}, {:.4f}, {:.4f}), {:.1f} degrees from the nearest axis, through "
        "{} cusp tips (rms {:.2f} mm)",
        plane.normal.x(), plane.normal.y(), plane.normal.z(), degreesToNearestAxis(w), plane.tips, plane.rms_mm));
  }

  // Level of the base.
  BaseFrame frame = baseFrame(w);
  const double lowest = reach(chain.mesh, frame.w);
  frame.level = lowest + options.base_margin_mm;
  if (options.base_height_mm) {
    KERF_TRY(level, levelByHeight(chain, frame.w, lowest, occlusal, *options.base_height_mm));
    frame.level = level;
  }

  frame.level = roundedToFloat(frame.level);
  frame.ceiling = roundedToFloat(lowest + std::min(0.25, 0.1 * (frame.level - lowest)));
  return frame;
}

bool isBaseAsked(const CloseOptions& o) {
  return o.base_is_asked || o.base_style != BaseStyle::kHorseshoe || o.base_height_mm || o.base_direction ||
         o.find_occlusal_plane || o.occlusal_plane;
}

/// "y = -29.787 mm", "12.3 mm below the occlusal plane ...".
std::string describePlace(const BaseFrame& frame) {
  int axis = 0;
  frame.w.cwiseAbs().maxCoeff(&axis);
  if (std::abs(frame.w[axis]) == 1)
    return fmt::format("a flat base at {} = {:.3f} mm", "xyz"[axis], frame.level * frame.w[axis]);
  return fmt::format("a flat base facing ({:.4f}, {:.4f}, {:.4f}), {:.1f} degrees from the nearest axis", frame.w.x(),
                     frame.w.y(), frame.w.z(), degreesToNearestAxis(frame.w));
}

/// The boundary of a chain, one entry per loop.
struct Boundary {
  std::vector<Loop> loops;
  std::vector<double> lengths;  ///< mm
  std::size_t longest = 0;      ///< among possible rims, if any
  std::vector<char> is_hole;    ///< by its shape, at any length
  std::vector<char> is_rim;     ///< of a missing underside; the others are holes
  std::vector<char> is_inner;   ///< of a loose piece that crosses the arch: a hole, closed by a fan
  double longestLength() const { return lengths[longest]; }
};

std::vector<std::uint32_t> pieceOfVertices(const Mesh& mesh, const Pieces& pieces) {
  std::vector<std::uint32_t> out(mesh.vertices.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) out[v] = pieces.label[t];
  return out;
}

/// Finds loops where a part of a coarse solid is missing. Blocks and trays have few edges around, rims of scans 150 and
/// more.
class MissingFaces {
 public:
  explicit MissingFaces(const Mesh& mesh) : mesh_(mesh) {}

  /// A triangle, or a corner of four edges: no underside has so few edges.
  bool isCorner(const Loop& loop) { return loop.size() <= 4 && (loop.size() == 3 || !isFlat(loop)) && encloses(loop); }
  /// The loop bounds a whole missing flat face. It may be an underside too; the mode decides.
  bool isFace(const Loop& loop) {
    constexpr std::size_t kMostEdges = 32;
    return loop.size() <= kMostEdges && isFlat(loop) && encloses(loop);
  }

 private:
  // The volume between a piece and a point p is volume - (p - origin) . area: that of the piece, closed by a fan.
  struct Piece {
    double volume = 0;
    Vec3d area = Vec3d::Zero();
    Box3 box;
    double across() const { return box.size().norm(); }
  };

  Vec3d middleOf(const Loop& loop) const {
    Vec3d middle = Vec3d::Zero();
    for (const std::uint32_t v : loop) middle += mesh_.vertices[v] / static_cast<double>(loop.size());
    return middle;
  }
  const Piece& pieceOf(const Loop& loop) {
    if (pieces_.empty()) measure();
    return pieces_[piece_of_[loop[0]]];
  }
  bool isFlat(const Loop& loop) {
    constexpr double kFlat = 1e-4;  // of the diagonal
    const double most = kFlat * pieceOf(loop).across();
    const Vec3d middle = middleOf(loop), normal = areaVector(mesh_, loop).normalized();
    return std::all_of(loop.begin(), loop.end(),
                       [&](std::uint32_t v) { return std::abs((mesh_.vertices[v] - middle).dot(normal)) <= most; });
  }
  bool encloses(const Loop& loop) {
    constexpr double kThinnest = 1e-3;  // of the cube of the diagonal: a thinner mesh is a sheet
    const Piece& piece = pieceOf(loop);
    const double volume = piece.volume - (middleOf(loop) - origin_).dot(piece.area);
    return std::abs(volume) > kThinnest * std::pow(piece.across(), 3);
  }

  void measure() {
    const Pieces pieces = edgeConnectedPieces(mesh_);
    piece_of_ = pieceOfVertices(mesh_, pieces);
    origin_ = bounds(mesh_).center();
    pieces_.resize(pieces.count);
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      Piece& piece = pieces_[pieces.label[t]];
      const Vec3d a = mesh_.corner(t, 0) - origin_, b = mesh_.corner(t, 1) - origin_, c = mesh_.corner(t, 2) - origin_;
      piece.volume += a.dot(b.cross(c)) / 6;
      piece.area += doubleAreaVector(mesh_, t) / 6;
      for (int k = 0; k < 3; ++k) piece.box.add(mesh_.corner(t, k));
    }
  }

  const Mesh& mesh_;
  Vec3d origin_ = Vec3d::Zero();
  std::vector<Piece> pieces_;
  std::vector<std::uint32_t> piece_of_;
};

/// Whether the longest loop is the rim of a missing underside. Errors: kGeometry if it is, and no base may be made.
Expected<bool> needsBase(const Mesh& mesh, const Boundary& boundary, const CloseOptions& options) {
  const double diagonal = bounds(mesh).size().norm();
  const bool steps = !options.only.empty();
  const bool long_one = options.fill_up_to_mm ? boundary.longestLength() > *options.fill_up_to_mm
                                              : !boundary.is_hole[boundary.longest] &&
                                                    boundary.longestLength() > options.rim_to_diagonal * diagonal;
  const bool may_base = steps ? options.only.count(CloseStep::kBase) > 0 : options.mode != CloseMode::kRepair;
  const bool has_rim = long_one || (!steps && options.mode == CloseMode::kBase);
  if (!has_rim || may_base) return has_rim;

  const std::string found =
      fmt::format("an open boundary of {:.0f} mm around a mesh of {:.0f} mm{}", boundary.longestLength(), diagonal,
                  options.fill_up_to_mm ? "" : ": its underside is missing");
  if (steps) return fail(missingStep(found, CloseStep::kBase, options));
  return fail(
      ungrounded(found, options.fill_up_to_mm ? "--close base, or a larger --fill-holes-up-to" : "--close base"));
}

/// Marks the longest loop, and those that are long for their piece and open to the same side.
void markRims(const Mesh& mesh, const Vec3d& down, const CloseOptions& options, Boundary& boundary) {
  const Pieces pieces = edgeConnectedPieces(mesh);
  std::vector<Box3> box(pieces.count);
  const std::vector<std::uint32_t> piece_of = pieceOfVertices(mesh, pieces);
  for (const Triangle& f : mesh.triangles)
    for (const std::uint32_t v : f) box[piece_of[v]].add(mesh.vertices[v]);
  for (std::size_t i = 0; i < boundary.loops.size(); ++i) {
    const double own = box[piece_of[boundary.loops[i][0]]].size().norm();
    const double most = options.fill_up_to_mm ? *options.fill_up_to_mm : options.rim_to_diagonal * own;
    boundary.is_rim[i] = i == boundary.longest || (!boundary.is_hole[i] && boundary.lengths[i] > most &&
                                                   areaVector(mesh, boundary.loops[i]).dot(down) > 0);
  }
}

/// A point along an axis, as its shadow.
Eigen::Vector2d loopShadow(const Vec3d& p, int axis) { return {p[(axis + 1) % 3], p[(axis + 2) % 3]}; }

bool isInside(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& outline) {
  int winding = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    if ((a.y() <= p.y()) == (b.y() <= p.y())) continue;
    const double side = (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
    if (a.y() <= p.y() && side > 0) ++winding;
    if (b.y() <= p.y() && side < 0) --winding;
  }
  return winding != 0;
}

double distanceTo(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& outline) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d a = outline[i], d = outline[(i + 1) % outline.size()] - a;
    const double length = d.squaredNorm(), s = length > 0 ? std::clamp((p - a).dot(d) / length, 0.0, 1.0) : 0;
    nearest = std::min(nearest, (p - a - s * d).norm());
  }
  return nearest;
}

/// True if the shadow of `inner` along the axis lies within that of `outer`: a third of it inside, and no vertex
/// farther out than `overhang` mm. Tests at most 200 vertices of `inner`.
bool liesInShadow(const Mesh& mesh, const Loop& inner, const Loop& outer, int axis, double overhang) {
  std::vector<Eigen::Vector2d> outline;
  for (const std::uint32_t v : outer) outline.push_back(loopShadow(mesh.vertices[v], axis));
  constexpr std::size_t kMostAsked = 200;
  const std::size_t stride = (inner.size() + kMostAsked - 1) / kMostAsked;
  std::size_t asked = 0, inside = 0;
  for (std::size_t k = 0; k < inner.size(); k += stride) {
    const Eigen::Vector2d p = loopShadow(mesh.vertices[inner[k]], axis);
    const bool is_inside = isInside(p, outline);
    if (!is_inside && distanceTo(p, outline) > overhang) return false;
    ++asked;
    inside += is_inside;
  }
  return 3 * inside >= asked;
}

bool mayFill(const CloseOptions& o) {
  return !o.fill_up_to_mm && (o.only.empty() || o.only.count(CloseStep::kFill) > 0);
}

/// A loose piece that crosses the piece with the longest rim, above or at the edge of its base, gets no walls: they
/// would bury the neighbouring surface. Its rim is a hole.
void leaveInnerRims(const Mesh& mesh, const Direction& down, const CloseOptions& options, Boundary& boundary) {
  if (!mayFill(options)) return;
  constexpr double kOverhang = 2, kSmallestDental = 3;  // mm
  const double overhang = kOverhang * std::min(1.0, bounds(mesh).size().norm() / kSmallestDental);
  std::vector<std::size_t> inner;
  for (std::size_t i = 0; i < boundary.loops.size(); ++i)
    if (boundary.is_rim[i] && i != boundary.longest &&
        liesInShadow(mesh, boundary.loops[i], boundary.loops[boundary.longest], down.axis, overhang))
      inner.push_back(i);
  if (inner.empty()) return;

  const Pieces pieces = edgeConnectedPieces(mesh);
  const std::vector<std::uint32_t> piece_of = pieceOfVertices(mesh, pieces);
  const std::uint32_t main = piece_of[boundary.loops[boundary.longest][0]];
  constexpr std::size_t kMostPairs = 500'000;
  std::vector<char> touches(pieces.count, 0);
  for (const auto& [s, t] : crossingPairs(mesh, kMostPairs)) {
    if (pieces.label[s] == main) touches[pieces.label[t]] = 1;
    if (pieces.label[t] == main) touches[pieces.label[s]] = 1;
  }
  for (const std::size_t i : inner) {
    const std::uint32_t piece = piece_of[boundary.loops[i][0]];
    if (piece == main || !touches[piece]) continue;
    boundary.is_rim[i] = 0;
    boundary.is_inner[i] = 1;
  }
}

/// Several open shells, none larger than a tooth: crowns. Walls down to one base would be stilts.
bool areCrowns(const Mesh& mesh, const Boundary& boundary, const CloseOptions& options) {
  constexpr double kLargestTooth = 25;  // mm, the diagonal of its box; a crown has 15
  if (!mayFill(options) || isBaseAsked(options) || options.mode == CloseMode::kBase) return false;
  const Pieces pieces = edgeConnectedPieces(mesh);
  if (pieces.count < 2) return false;

  const std::vector<std::uint32_t> piece_of = pieceOfVertices(mesh, pieces);
  std::vector<Box3> box(pieces.count);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) box[piece_of[v]].add(mesh.vertices[v]);
  for (const Box3& b : box)
    if (!(b.size().norm() <= kLargestTooth)) return false;
  std::vector<char> has_rim(pieces.count, 0);
  for (std::size_t i = 0; i < boundary.loops.size(); ++i) {
    const std::uint32_t piece = piece_of[boundary.loops[i][0]];
    if (!boundary.is_hole[i] && boundary.lengths[i] > options.rim_to_diagonal * box[piece].size().norm())
      has_rim[piece] = 1;
  }
  return std::count(has_rim.begin(), has_rim.end(), 1) > 1;
}

/// The widest of them, and others that are not beside a wider one.
std::vector<WideSpan> apart(std::vector<WideSpan> spans, double least_mm) {
  std::stable_sort(spans.begin(), spans.end(), [](const WideSpan& x, const WideSpan& y) { return x.mm > y.mm; });
  std::vector<WideSpan> out;
  for (const WideSpan& span : spans) {
    const auto isBeside = [&](const WideSpan& wider) { return (wider.middle - span.middle).norm() < least_mm; };
    if (std::none_of(out.begin(), out.end(), isBeside)) out.push_back(span);
  }
  return out;
}

/// "10.5 mm near (17.5, 0.5, -20.1), 8.2 mm near ...", ten at most.
std::string listOf(const std::vector<WideSpan>& spans) {
  constexpr std::size_t kMostSaid = 10;
  std::string text;
  for (std::size_t n = 0; n < std::min(kMostSaid, spans.size()); ++n) {
    const Vec3d& p = spans[n].middle;
    text +=
        fmt::format("{}{:.1f} mm near ({:.1f}, {:.1f}, {:.1f})", n > 0 ? ", " : "", spans[n].mm, p.x(), p.y(), p.z());
  }
  if (spans.size() > kMostSaid) text += fmt::format(", and {} more", spans.size() - kMostSaid);
  return text;
}

/// Reports the bridges over gaps of the rim, and warns of large ones: tooth sockets with narrow mouths count as gaps
/// too.
void reportBridges(BridgedGaps gaps, double scan_mm2, double scale, CloseReport& report) {
  std::stable_sort(gaps.places.begin(), gaps.places.end(),
                   [](const BridgedPlace& x, const BridgedPlace& y) { return x.area_mm2 > y.area_mm2; });
  report.gaps_bridged = gaps.places.size();
  report.rim_bridged_mm = gaps.rim_mm;
  report.widest_gap_mm = gaps.widest_mm;
  report.bridged_mm2 = 0;
  report.widest_span_mm = 0;
  for (const BridgedPlace& place : gaps.places) {
    report.bridged_mm2 += place.area_mm2;
    report.widest_span_mm = std::max(report.widest_span_mm, place.span_mm);
  }
  report.bridged_share = scan_mm2 > 0 ? report.bridged_mm2 / scan_mm2 : 0;
  constexpr double kApart = 6;  // mm: less than between two teeth
  report.wide_spans = apart(std::move(gaps.spans), kApart * scale);

  const BridgedPlace& largest = gaps.places.front();
  report.changes.push_back(fmt::format(
      "{} in the rim {} bridged ({:.0f} mm of rim, mouths up to {:.1f} mm wide): {:.1f} mm2 of surface were added on "
      "the scan's side, {:.2g} % of its area, spans up to {:.1f} mm; {}{:.1f} mm2 near ({:.1f}, {:.1f}, {:.1f})",
      counted(report.gaps_bridged, "gap", "gaps"), report.gaps_bridged == 1 ? "was" : "were", report.rim_bridged_mm,
      report.widest_gap_mm, report.bridged_mm2, 100 * report.bridged_share, report.widest_span_mm,
      report.gaps_bridged > 1 ? "the largest: " : "", largest.area_mm2, largest.middle.x(), largest.middle.y(),
      largest.middle.z()));
  report.bridged_at = std::move(gaps.places);

  if (report.bridged_share <= kMostBridged && report.widest_span_mm <= kWidestSpan * scale) return;
  const std::string warning = fmt::format(
      "{:.0f} mm2 of added surface, {:.2g} % of the scan's area, lie flat over gaps of its rim{}{}. They may cover "
      "tooth sockets. Check these places before cutting; try --base-smoothing 0, which leaves the gaps open through "
      "the base, or fill them in the scanner software",
      report.bridged_mm2, 100 * report.bridged_share, report.wide_spans.empty() ? "" : ", the widest ",
      listOf(report.wide_spans));
  report.warnings.push_back(warning);
  report.changes.push_back(warning);
}

/// From the rims down to calmer outlines, as the options ask; without smoothing the rims as they are.
Expected<std::vector<Loop>> smoothRims(Chain& chain, const std::vector<Loop>& rims, const BaseFrame& frame,
                                       const CloseOptions& options, CloseReport& report, const Progress& progress) {
  // A plate hides most of the walls, and leaves no depth for others.
  if (!(options.base_smoothing_mm > 0) || options.base_style == BaseStyle::kFull) return rims;
  constexpr double kSmallestDental = 3;  // mm: smaller objects get smaller bridges and lips
  const double scale = std::min(1.0, bounds(chain.mesh).size().norm() / kSmallestDental);

  const double scan_mm2 = surfaceArea(chain.mesh);
  BridgedGaps gaps;
  KERF_TRY(bridged, bridgeFjords(chain, rims, scale, gaps, progress));
  if (!gaps.places.empty()) reportBridges(std::move(gaps), scan_mm2, scale, report);

  const SmoothWalls walls{options.base_smoothing_mm, options.base_lip_mm, scale};
  return addSmoothWalls(chain, bridged, frame, walls, progress);
}

/// Turns a scan that is inside out, and puts a base under its rims.
Expected<void> extrudeRims(Chain& chain, Boundary& boundary, const CloseOptions& options, CloseReport& report,
                           const Progress& progress) {
  Opening opening = measureOpening(chain.mesh, boundary.loops[boundary.longest]);
  KERF_TRY(turn, isInsideOut(opening, options));
  Direction base = options.base_direction ? nearestAxis(*options.base_direction) : nearestAxis(opening.direction);
  if (turn) {
    turnAll(chain, boundary.loops);
    opening.direction = -opening.direction;
    if (!options.base_direction) base.sign = -base.sign;
    report.triangles_flipped += chain.mesh.triangles.size();
    report.changes.emplace_back("the scan was inside out: all triangles were turned");
  }

  markRims(chain.mesh, base.vector(), options, boundary);
  leaveInnerRims(chain.mesh, base, options, boundary);
  std::vector<Loop> rims;
  for (std::size_t i = 0; i < boundary.loops.size(); ++i)
    if (boundary.is_rim[i]) rims.push_back(boundary.loops[i]);
  KERF_TRY(frame, placeBase(chain, base.vector(), opening.direction, options, report));
  for (const Loop& loop : boundary.loops)
    for (const std::uint32_t v : loop) report.rim_points.push_back(chain.mesh.vertices[v]);
  report.rims_extruded = rims.size();
  KERF_TRY(outlines, smoothRims(chain, rims, frame, options, report, progress));
  KERF_CHECK(extrudeToBase(chain, outlines, frame, options.base_style == BaseStyle::kFull, progress));

  report.base_direction = frame.w;
  report.base_level_mm = frame.level;
  report.changes.push_back(fmt::format(
      "{} {} extruded to {}{}",
      rims.size() == 1 ? fmt::format("a rim {:.0f} mm around", boundary.longestLength())
                       : fmt::format("{} rims, the longest {:.0f} mm around,", rims.size(), boundary.longestLength()),
      rims.size() == 1 ? "was" : "were", describePlace(frame),
      options.base_style == BaseStyle::kFull ? fmt::format(", a plate {:.2f} mm thick", frame.level - frame.ceiling)
                                             : std::string()));
  return {};
}

Boundary boundaryOf(const Mesh& mesh, const CloseOptions& options) {
  const bool is_repair = options.only.empty() && options.mode == CloseMode::kRepair;
  Boundary out{boundaryLoops(mesh.triangles), {}, 0, {}, {}, {}};
  MissingFaces missing(mesh);
  for (const Loop& loop : out.loops) {
    out.lengths.push_back(length(mesh, loop));
    out.is_hole.push_back(missing.isCorner(loop) || (is_repair && missing.isFace(loop)));
  }
  const auto isBefore = [&out](std::size_t i, std::size_t j) {
    return out.is_hole[i] != out.is_hole[j] ? out.is_hole[j] == 0 : out.lengths[i] < out.lengths[j];
  };
  for (std::size_t i = 1; i < out.loops.size(); ++i)
    if (isBefore(out.longest, i)) out.longest = i;
  out.is_rim.assign(out.loops.size(), 0);
  out.is_inner.assign(out.loops.size(), 0);
  return out;
}

/// A nearly closed mesh with inconsistent triangles can have a boundary as long as a rim, without a missing underside:
/// a base would be wrong. So this drops sheets that enclose nothing.
/// Errors: kGeometry if a boundary as long as a rim remains.
Expected<void> dropWhatLooksOpen(Chain& chain, const CloseOptions& options, Boundary& boundary, CloseReport& report) {
  const double across = bounds(chain.mesh).size().norm();
  const bool is_asked = !options.only.empty() || options.mode == CloseMode::kBase || options.fill_up_to_mm;
  if (is_asked || chain.open_mm > kHardlyOpen * across) return {};

  dropSheets(chain, report);
  boundary = boundaryOf(chain.mesh, options);
  if (boundary.loops.empty() || boundary.is_hole[boundary.longest] ||
      !(boundary.longestLength() > options.rim_to_diagonal * across))
    return {};
  Error e = ungrounded(fmt::format("a boundary of {:.0f} mm along edges that three or more triangles share; the mesh "
                                   "is open along {:.1f} mm only: no underside is missing",
                                   boundary.longestLength(), chain.open_mm),
                       "--close wrap, or repair the mesh in another program; --close base for a scan");
  e.expected = "a surface";
  return fail(std::move(e));
}

/// Trims narrow parts of the rims, if the options request it.
void trimBoundary(Chain& chain, const CloseOptions& options, Boundary& boundary, CloseReport& report) {
  const double across = bounds(chain.mesh).size().norm();
  std::vector<Loop> rims;
  for (std::size_t i = 0; i < boundary.loops.size(); ++i)
    if (i == boundary.longest || (!boundary.is_hole[i] && boundary.lengths[i] > options.rim_to_diagonal * across))
      rims.push_back(boundary.loops[i]);

  const Trimmed taken = trimRims(chain, rims, options.trim_rim_mm);
  report.rim_places_trimmed = taken.places;
  report.vertices_trimmed = taken.vertices;
  report.triangles_trimmed = taken.triangles;
  report.trimmed_mm2 = taken.area_mm2;
  if (taken.triangles == 0) {
    report.changes.push_back(
        fmt::format("nothing was trimmed: parts of the rim narrower than {} mm stick out no farther than a corner; use "
                    "a smaller --trim-rim for short tongues",
                    options.trim_rim_mm));
    return;
  }
  report.changes.push_back(fmt::format(
      "the rim was trimmed, as asked, in {} narrower than {} mm: {}, {} and {:.1f} mm2 of the scan were taken",
      counted(taken.places, "place", "places"), options.trim_rim_mm, counted(taken.vertices, "vertex", "vertices"),
      counted(taken.triangles, "triangle", "triangles"), taken.area_mm2));
  boundary = boundaryOf(chain.mesh, options);
}

/// Rejects holes that the options exclude.
Expected<void> checkHoles(const Mesh& mesh, const Boundary& boundary, const CloseOptions& options) {
  for (std::size_t i = 0; i < boundary.loops.size(); ++i) {
    if (boundary.is_rim[i]) continue;
    const std::string found = fmt::format("a hole {:.1f} mm around", boundary.lengths[i]);
    if (!options.only.empty() && !options.only.count(CloseStep::kFill))
      return fail(missingStep(found, CloseStep::kFill, options));
    if (options.fill_up_to_mm && boundary.lengths[i] > *options.fill_up_to_mm) {
      const Vec3d& p = mesh.vertices[boundary.loops[i][0]];
      Error e = ungrounded(found, "a larger --fill-holes-up-to");
      e.place = fmt::format("at ({:.2f}, {:.2f}, {:.2f}) mm", p.x(), p.y(), p.z());
      e.expected = fmt::format("holes of at most {} mm", *options.fill_up_to_mm);
      return fail(std::move(e));
    }
  }
  return {};
}

Expected<void> fillHoles(Chain& chain, const Boundary& boundary, CloseReport& report, const Progress& progress) {
  std::size_t fans = 0;
  double widest = 0;
  for (std::size_t i = 0; i < boundary.loops.size(); ++i) {
    if (boundary.is_rim[i]) continue;
    if (!kerf::report(progress, 0.2, "filling holes")) return cancelled();
    // A smooth patch would follow the rim of a loose piece, and bury more of the arch than a straight fan.
    if (boundary.is_inner[i])
      fanHole(chain, boundary.loops[i]);
    else
      fans += !fillHole(chain, boundary.loops[i]);
    ++report.holes_filled;
    widest = std::max(widest, boundary.lengths[i]);
  }
  if (report.holes_filled)
    report.changes.push_back(fmt::format("{} filled (the largest {:.1f} mm around)",
                                         counted(report.holes_filled, "hole was", "holes were"), widest));
  if (fans) report.changes.push_back(counted(fans, "of them was", "of them were") + " closed by a plain fan");
  return {};
}

}  // namespace

Expected<void> closeBoundary(Chain& chain, const CloseOptions& options, CloseReport& report, const Progress& progress) {
  Boundary boundary = boundaryOf(chain.mesh, options);
  if (boundary.loops.empty()) {
    if (options.only.empty() && options.mode == CloseMode::kBase)
      return fail(ungrounded("a closed mesh, which needs no base", "the same without --close base"));
    if (isBaseAsked(options)) report.changes.emplace_back("no base was made: the mesh is closed");
    return {};
  }
  if (boundary.longestLength() > options.rim_to_diagonal * bounds(chain.mesh).size().norm()) {
    KERF_CHECK(dropWhatLooksOpen(chain, options, boundary, report));
    if (boundary.loops.empty()) return {};
  }

  KERF_TRY(has_rim, needsBase(chain.mesh, boundary, options));
  const bool are_crowns = has_rim && areCrowns(chain.mesh, boundary, options);
  if (has_rim && !are_crowns && options.trim_rim_mm > 0) trimBoundary(chain, options, boundary, report);
  const bool is_face = has_rim && !are_crowns && MissingFaces(chain.mesh).isFace(boundary.loops[boundary.longest]);
  if (are_crowns)
    report.changes.emplace_back("several open shells no larger than a tooth: each was capped, none got a base");
  else if (has_rim)
    KERF_CHECK(extrudeRims(chain, boundary, options, report, progress));
  else if (isBaseAsked(options))
    report.changes.push_back(
        fmt::format("no base was made: no underside is missing, the longest opening is {:.1f} mm around",
                    boundary.longestLength()));
  if (is_face && options.only.empty() && options.mode == CloseMode::kAuto)
    report.changes.emplace_back(
        "the rim is flat and has few edges: if a face of a solid is missing, --close repair fills it");
  KERF_CHECK(checkHoles(chain.mesh, boundary, options));
  return fillHoles(chain, boundary, report, progress);
}

Expected<OcclusalPlane> findPlaneOfScan(const Chain& chain, const CloseOptions& options) {
  const std::vector<Loop> loops = boundaryLoops(chain.mesh.triangles);
  if (loops.empty()) return fail(ungrounded("a closed mesh: it does not show the direction of its teeth", ""));
  if (options.base_direction) return findOcclusalPlane(chain.mesh, -nearestAxis(*options.base_direction).vector());
  const auto longest = std::max_element(loops.begin(), loops.end(), [&](const Loop& a, const Loop& b) {
    return length(chain.mesh, a) < length(chain.mesh, b);
  });
  const Opening opening = measureOpening(chain.mesh, *longest);
  return findOcclusalPlane(chain.mesh, opening.isClear() ? -opening.trueDirection() : -opening.direction);
}

}  // namespace kerf::internal
