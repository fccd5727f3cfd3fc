#include "preprocess/close/boundary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/mesh/float32_cleanup.h"
#include "preprocess/close/base.h"
#include "preprocess/close/hole.h"
#include "preprocess/close/poll.h"

namespace kerf::internal {
namespace {

double length(const Mesh& mesh, const Loop& loop) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    sum += (mesh.vertices[loop[i]] - mesh.vertices[loop[(i + 1) % loop.size()]]).norm();
  return sum;
}

/// Twice the area vector of whatever would close the loop.
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

/// Where a scan is open, as its rim tells. A scan is a bowl upside down: its rim lies on the side it opens to. A ribbon
/// of gum, whose rim also runs around the teeth, tells nothing.
struct Opening {
  Vec3d direction;  ///< unit: what the triangles' orientation says
  double rim_side;  ///< how far the rim lies that way from the centroid, along the nearest axis, by the extent there
  static constexpr double kClear = 0.15;  ///< 0.2 to 0.6 on scans, with either sign
  bool isClear() const { return std::abs(rim_side) > kClear; }
  /// Where it is really open: if the rim lies behind, the triangles are inside out.
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

/// Whether all triangles must be turned. Where neither the rim nor the rim and the file together tell, the base
/// direction is believed. Errors: kGeometry for a base direction that leads away from the opening: walls would run
/// through the teeth.
Expected<bool> isInsideOut(const Opening& opening, const CloseOptions& options) {
  if (!options.base_direction) return opening.rim_side < -Opening::kClear;
  const Vec3d asked = nearestAxis(*options.base_direction).vector();
  constexpr double kAgrees = 0.02;  // a ragged rim, but on the side the file says: 0.09 on a lower jaw
  if (!opening.isClear() && opening.rim_side < kAgrees) return opening.direction.dot(asked) < 0;
  const double least = opening.isClear() ? 0.25 : -0.25;  // 75 degrees off, or 105: a ragged rim is 40 off itself
  const Vec3d open = opening.trueDirection();
  if (open.dot(asked) >= least) return opening.rim_side < 0;
  const Direction found = nearestAxis(open);
  Error e = ungrounded(fmt::format("a base towards {}, but the scan is open towards {}: ({:.2f}, {:.2f}, {:.2f})",
                                   nameOf(nearestAxis(asked)), nameOf(found), open.x(), open.y(), open.z()),
                       fmt::format("--base-direction {}, or leave it out", nameOf(found)));
  e.expected = "a base on the open side";
  return fail(std::move(e));
}

/// Where the base goes. @param down  roughly: a coordinate axis.  @param open  where the scan is open.
Expected<BaseFrame> placeBase(const Chain& chain, const Vec3d& down, const Vec3d& open, const CloseOptions& options,
                              CloseReport& report) {
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
  BaseFrame frame = baseFrame(w);
  const double lowest = reach(chain.mesh, frame.w);
  frame.level = lowest + options.base_margin_mm;
  if (options.base_height_mm) {
    constexpr double kLeastMargin = 0.5;
    const double top = occlusal.value_or(-reach(chain.mesh, -frame.w));
    frame.level = top + *options.base_height_mm;
    if (frame.level < lowest + kLeastMargin) {
      const double least = std::ceil(10 * (lowest + kLeastMargin - top)) / 10;
      Error e = ungrounded(
          fmt::format("a base {} mm below {}, but the scan reaches {:.2f} mm below it", *options.base_height_mm,
                      occlusal ? "the occlusal plane" : "the highest point", lowest - top),
          fmt::format("--base-height {:.1f}", least));
      e.expected = fmt::format("a base height of at least {:.1f} mm", least);
      return fail(std::move(e));
    }
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

}  // namespace

Expected<void> closeBoundary(Chain& chain, const CloseOptions& options, CloseReport& report, const Progress& progress) {
  std::vector<Loop> loops = boundaryLoops(chain.mesh.triangles);
  if (loops.empty()) {
    if (options.only.empty() && options.mode == CloseMode::kBase)
      return fail(ungrounded("a closed mesh, which needs no base", "the same without --close base"));
    if (isBaseAsked(options)) report.changes.push_back("no base was made: the mesh is closed");
    return {};
  }
  const double diagonal = bounds(chain.mesh).size().norm();
  std::vector<double> lengths;
  for (const Loop& loop : loops) lengths.push_back(length(chain.mesh, loop));
  const auto longest = static_cast<std::size_t>(std::max_element(lengths.begin(), lengths.end()) - lengths.begin());
  const bool steps = !options.only.empty();
  const bool long_one = options.fill_up_to_mm ? lengths[longest] > *options.fill_up_to_mm
                                              : lengths[longest] > options.rim_to_diagonal * diagonal;
  const bool may_base = steps ? options.only.count(CloseStep::kBase) > 0 : options.mode != CloseMode::kRepair;
  const bool has_rim = long_one || (!steps && options.mode == CloseMode::kBase);
  if (has_rim && !may_base) {
    const std::string found =
        fmt::format("an open boundary of {:.0f} mm around a mesh of {:.0f} mm{}", lengths[longest], diagonal,
                    options.fill_up_to_mm ? "" : ": its underside is missing");
    if (steps) return fail(missingStep(found, CloseStep::kBase, options));
    return fail(
        ungrounded(found, options.fill_up_to_mm ? "--close base, or a larger --fill-holes-up-to" : "--close base"));
  }
  if (!has_rim && isBaseAsked(options))
    report.changes.push_back(fmt::format(
        "no base was made: no underside is missing, the longest opening is {:.1f} mm around", lengths[longest]));
  std::vector<char> is_rim(loops.size(), 0);
  if (has_rim) {
    Opening opening = measureOpening(chain.mesh, loops[longest]);
    KERF_TRY(turn, isInsideOut(opening, options));
    Direction base = options.base_direction ? nearestAxis(*options.base_direction) : nearestAxis(opening.direction);
    if (turn) {
      turnAll(chain, loops);
      opening.direction = -opening.direction;
      if (!options.base_direction) base.sign = -base.sign;
      report.triangles_flipped += chain.mesh.triangles.size();
      report.changes.push_back("the scan was inside out: all triangles were turned");
    }
    const Pieces pieces = edgeConnectedPieces(chain.mesh);
    std::vector<Box3> box(pieces.count);
    std::vector<std::uint32_t> piece_of(chain.mesh.vertices.size(), 0);
    for (std::size_t t = 0; t < chain.mesh.triangles.size(); ++t)
      for (const std::uint32_t v : chain.mesh.triangles[t]) {
        box[pieces.label[t]].add(chain.mesh.vertices[v]);
        piece_of[v] = pieces.label[t];
      }
    std::vector<Loop> rims;
    for (std::size_t i = 0; i < loops.size(); ++i) {
      const double own = box[piece_of[loops[i][0]]].size().norm();
      is_rim[i] = i == longest ||
                  (lengths[i] > (options.fill_up_to_mm ? *options.fill_up_to_mm : options.rim_to_diagonal * own) &&
                   areaVector(chain.mesh, loops[i]).dot(base.vector()) > 0);
      if (is_rim[i]) rims.push_back(loops[i]);
    }
    KERF_TRY(frame, placeBase(chain, base.vector(), opening.direction, options, report));
    KERF_CHECK(extrudeToBase(chain, rims, frame, options.base_style == BaseStyle::kFull, progress));
    report.rims_extruded = rims.size();
    report.base_direction = frame.w;
    report.base_level_mm = frame.level;
    report.changes.push_back(fmt::format(
        "{} {:.0f} mm around, {} extruded to {}{}",
        rims.size() == 1 ? std::string("a rim") : fmt::format("{} rims, the longest", rims.size()), lengths[longest],
        rims.size() == 1 ? "was" : "were", describePlace(frame),
        options.base_style == BaseStyle::kFull ? fmt::format(", a plate {:.2f} mm thick", frame.level - frame.ceiling)
                                               : std::string()));
  }
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (is_rim[i]) continue;
    if (steps && !options.only.count(CloseStep::kFill))
      return fail(missingStep(fmt::format("a hole {:.1f} mm around", lengths[i]), CloseStep::kFill, options));
    if (options.fill_up_to_mm && lengths[i] > *options.fill_up_to_mm) {
      const Vec3d& p = chain.mesh.vertices[loops[i][0]];
      Error e = ungrounded(fmt::format("a hole {:.1f} mm around", lengths[i]), "a larger --fill-holes-up-to");
      e.place = fmt::format("at ({:.2f}, {:.2f}, {:.2f}) mm", p.x(), p.y(), p.z());
      e.expected = fmt::format("holes of at most {} mm", *options.fill_up_to_mm);
      return fail(std::move(e));
    }
  }
  std::size_t fans = 0;
  double widest = 0;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (is_rim[i]) continue;
    if (!kerf::report(progress, 0.2, "filling holes")) return cancelledError();
    fans += !fillHole(chain, loops[i]);
    ++report.holes_filled;
    widest = std::max(widest, lengths[i]);
  }
  if (report.holes_filled)
    report.changes.push_back(fmt::format("{} filled (the largest {:.1f} mm around)",
                                         counted(report.holes_filled, "hole was", "holes were"), widest));
  if (fans) report.changes.push_back(counted(fans, "of them was", "of them were") + " closed by a plain fan");
  return {};
}

Expected<OcclusalPlane> findPlaneOfScan(const Chain& chain, const CloseOptions& options) {
  const std::vector<Loop> loops = boundaryLoops(chain.mesh.triangles);
  if (loops.empty()) return fail(ungrounded("a closed mesh: it does not tell which way its teeth point", ""));
  if (options.base_direction) return findOcclusalPlane(chain.mesh, -nearestAxis(*options.base_direction).vector());
  const auto longest = std::max_element(loops.begin(), loops.end(), [&](const Loop& a, const Loop& b) {
    return length(chain.mesh, a) < length(chain.mesh, b);
  });
  const Opening opening = measureOpening(chain.mesh, *longest);
  return findOcclusalPlane(chain.mesh, opening.isClear() ? -opening.trueDirection() : -opening.direction);
}

}  // namespace kerf::internal
