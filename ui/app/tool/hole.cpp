#include "ui/app/tool/hole.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr double kOutlineTolerance = 0.002;  // mm
constexpr double kUnderSurface = 0.3;        // mm below the entry, where the edge is measured
constexpr int kAroundHole = 16;

struct HoleFrame {
  explicit HoleFrame(const Vec3d& axis) : across(axis.unitOrthogonal()), along(axis.cross(across)) {}
  Vec3d around(int n) const {
    const double angle = 2 * std::numbers::pi * n / kAroundHole;
    return std::cos(angle) * across + std::sin(angle) * along;
  }
  Vec3d across, along;
};

// Where a ray that begins in the material leaves it.
std::optional<double> leavesAt(const SceneObject& object, const Vec3d& from, const Vec3d& direction) {
  return object.surface.exit(inFrame(object.pose(), {from, direction}), 0);
}

}  // namespace

Expected<DrillShape> DrillShape::of(const Tool& tool) {
  if (tool.kind != ToolKind::kBur || !tool.cutting || !tool.cuts_end ||
      !tool.plunge_direction.isApprox(-Vec3d::UnitZ()))
    return fail({.code = Error::Code::kUnsupported,
                 .found = tool.id + ", which does not cut with its end",
                 .expected = "a drill, or a bur with a cutting end",
                 .hint = "choose drill-20, or another drill of the rack"});
  DrillShape out;
  out.outline = tool.cutting->polyline(kOutlineTolerance);
  out.radius = tool.cutting->largestRadius();
  for (const RevolvedProfile& body : tool.body_outlines) {
    const auto more = body.polyline(kOutlineTolerance);
    out.outline.insert(out.outline.end(), more.begin(), more.end());
  }
  for (const RevolvedProfile::Point& p : out.outline) {
    out.widest = std::max(out.widest, p[0]);
    out.top = std::max(out.top, p[1]);
  }
  out.point = out.lowestAt(out.radius - kOutlineTolerance);
  return out;
}

double DrillShape::lowestAt(double r) const {
  double out = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < outline.size(); ++n) {
    const RevolvedProfile::Point& p = outline[n];
    if (p[0] >= r) out = std::min(out, p[1]);
    if (n == 0) continue;
    const RevolvedProfile::Point& before = outline[n - 1];
    if (before[0] < r && p[0] >= r && p[0] > before[0])
      out = std::min(out, before[1] + (p[1] - before[1]) * (r - before[0]) / (p[0] - before[0]));
  }
  return out;
}

HoleRoom roomFor(const Hole& hole, const DrillShape& shape, const LiveScene& scene) {
  constexpr double kBeside = 0.1, kRing = 0.3;  // mm
  constexpr double kAir = 1;                    // mm under the tip at the start
  const HoleFrame frame(hole.axis);
  const double above = shape.top + 40;
  HoleRoom out{.start = kAir};
  const auto ring = [&](double r) {
    const double lowest = shape.lowestAt(r);
    for (int n = 0; n < kAroundHole; ++n) {
      const auto hit = scene.hit({hole.entry + above * hole.axis + r * frame.around(n), -hole.axis});
      if (!hit) continue;
      const double height = above - hit->on_surface.way;
      out.start = std::max(out.start, height - lowest + kAir);
      if (r > shape.radius) out.most_depth = std::min(out.most_depth, lowest - height);
    }
  };
  for (const double part : {0.1, 0.5, 1.0}) ring(part * shape.radius);
  for (double r = shape.radius + kBeside; r < shape.widest; r += kRing) ring(r);
  if (shape.widest > shape.radius) ring(shape.widest);
  return out;
}

std::optional<double> depthThrough(const Hole& hole, const DrillShape& shape, const LiveScene& scene) {
  constexpr double kBeyond = 0.3;  // mm
  const SceneObject* const object = scene.find(hole.object);
  if (!object) return {};
  const auto middle = leavesAt(*object, hole.entry, -hole.axis);
  if (!middle) return {};
  const HoleFrame frame(hole.axis);
  double farthest = *middle;
  for (int n = 0; n < kAroundHole; ++n) {
    // From within, so that a sloping entry does not count.
    const Vec3d from = hole.entry - 0.5 * *middle * hole.axis + shape.radius * frame.around(n);
    const auto way = leavesAt(*object, from, -hole.axis);
    if (way && 0.5 * *middle + *way < *middle + 4 * shape.radius) farthest = std::max(farthest, 0.5 * *middle + *way);
  }
  return farthest + shape.point + kBeyond;
}

HoleWalls wallsOf(const Hole& hole, const DrillShape& shape, const LiveScene& scene) {
  constexpr double kStep = 1;  // mm
  const SceneObject* const object = scene.find(hole.object);
  HoleWalls out;
  if (!object) return out;
  const auto through = leavesAt(*object, hole.entry, -hole.axis);
  if (through) out.beneath = *through - hole.depth;

  const HoleFrame frame(hole.axis);
  const double deepest = std::min(hole.depth, through.value_or(hole.depth)) - kUnderSurface;
  // From below the whole rim: on a slope its lower side is open, and no wall.
  double rim = 0;
  for (int n = 0; n < kAroundHole; ++n) {
    const Vec3d above = hole.entry + 2 * shape.radius * hole.axis + shape.radius * frame.around(n);
    if (const auto hit = scene.hit({above, -hole.axis})) rim = std::max(rim, hit->on_surface.way - 2 * shape.radius);
  }
  const double first = std::max(std::min(std::min(rim, 2 * shape.radius) + kUnderSurface, deepest), kUnderSurface);
  for (double down = first; down <= std::max(deepest, first); down += kStep)
    for (int n = 0; n < kAroundHole; ++n) {
      const auto way = leavesAt(*object, hole.entry - down * hole.axis, frame.around(n));
      if (!way) continue;
      out.beside = std::min(out.beside.value_or(*way - shape.radius), *way - shape.radius);
      if (down == first) out.edge = std::min(out.edge.value_or(*way), *way);
    }
  return out;
}

}  // namespace kerf
