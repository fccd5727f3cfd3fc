#include "ui/app/view/live_surface.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

// Whether a ray passes a box before `farthest`.
bool passes(const Ray& ray, const Box3& box, double farthest) {
  double low = 0, high = farthest;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(ray.direction[axis]) < 1e-12) {
      if (ray.origin[axis] < box.min[axis] || ray.origin[axis] > box.max[axis]) return false;
      continue;
    }
    const double a = (box.min[axis] - ray.origin[axis]) / ray.direction[axis];
    const double b = (box.max[axis] - ray.origin[axis]) / ray.direction[axis];
    low = std::max(low, std::min(a, b));
    high = std::min(high, std::max(a, b));
  }
  return low <= high;
}

constexpr double kEdge = 1e-9;  // fraction of a side: no gap between triangles for a ray along an edge

// Moeller & Trumbore, J Graphics Tools 1997;2(1):21; front faces only.
std::optional<double> meet(const Ray& ray, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a, ac = c - a, p = ray.direction.cross(ac);
  const double det = ab.dot(p);
  if (!(det > 1e-15)) return {};
  const Vec3d t = ray.origin - a;
  const double slack = kEdge * det, u = t.dot(p);
  if (u < -slack || u > det + slack) return {};
  const Vec3d q = t.cross(ab);
  const double v = ray.direction.dot(q);
  if (v < -slack || u + v > det + slack) return {};
  const double way = ac.dot(q) / det;
  if (way < 0) return {};
  return way;
}

double volumeOf(const MeshChunk& chunk) {
  double out = 0;
  for (const auto& t : chunk.triangles) {
    const Vec3d a = chunk.vertices[t[0]].cast<double>(), b = chunk.vertices[t[1]].cast<double>(),
                c = chunk.vertices[t[2]].cast<double>();
    out += a.dot(b.cross(c)) / 6;
  }
  return out;
}

}  // namespace

void LiveSurface::update(std::span<const MeshChunkPtr> chunks) {
  for (const MeshChunkPtr& chunk : chunks) {
    const std::uint64_t key = coordKey(chunk->brick);
    if (const auto old = chunks_.find(key); old != chunks_.end()) {
      triangles_ -= old->second.chunk->triangles.size();
      volume_ -= old->second.volume;
      chunks_.erase(old);
    }
    if (chunk->isEmpty()) continue;

    Placed placed{chunk, {}, volumeOf(*chunk)};
    for (const Vec3f& v : chunk->vertices) placed.box.add(Vec3d(v.cast<double>()));
    triangles_ += chunk->triangles.size();
    volume_ += placed.volume;
    chunks_.emplace(key, std::move(placed));
  }
}

Box3 LiveSurface::bounds() const {
  Box3 out;
  for (const auto& [key, placed] : chunks_) out.add(placed.box);
  return out;
}

std::optional<SurfaceHit> LiveSurface::hit(const Ray& ray) const {
  SurfaceHit best;
  best.way = 1e9;
  bool has_hit = false;
  for (const auto& [key, placed] : chunks_) {
    if (!passes(ray, placed.box, best.way)) continue;
    const MeshChunk& chunk = *placed.chunk;
    for (const auto& t : chunk.triangles) {
      const Vec3d a = chunk.vertices[t[0]].cast<double>(), b = chunk.vertices[t[1]].cast<double>(),
                  c = chunk.vertices[t[2]].cast<double>();
      const auto way = meet(ray, a, b, c);
      if (!way || *way >= best.way) continue;
      best = {ray.at(*way), (b - a).cross(c - a).normalized(), *way};
      has_hit = true;
    }
  }
  if (!has_hit) return {};
  return best;
}

std::vector<std::array<Vec3d, 2>> LiveSurface::contour(const Plane& plane, const Box3& within) const {
  std::vector<std::array<Vec3d, 2>> out;
  for (const auto& [key, placed] : chunks_) {
    const Vec3d half = 0.5 * placed.box.size();
    if (std::abs(plane.height(placed.box.center())) > half.dot(plane.normal.cwiseAbs())) continue;
    if ((placed.box.min.array() > within.max.array()).any() || (placed.box.max.array() < within.min.array()).any())
      continue;
    for (const auto& t : placed.chunk->triangles) {
      std::array<Vec3d, 2> ends;
      std::size_t count = 0;
      for (std::size_t n = 0; n < 3 && count < 2; ++n) {
        const Vec3d a = placed.chunk->vertices[t[n]].cast<double>();
        const Vec3d b = placed.chunk->vertices[t[(n + 1) % 3]].cast<double>();
        const double low = plane.height(a), high = plane.height(b);
        if ((low < 0) == (high < 0)) continue;
        ends[count++] = a + low / (low - high) * (b - a);
      }
      if (count == 2 && within.contains(ends[0]) && within.contains(ends[1])) out.push_back(ends);
    }
  }
  return out;
}

std::optional<double> LiveSurface::exit(const Ray& ray, double from) const {
  constexpr double kFar = 1e9, kLeast = 1e-6;  // mm
  double best = kFar;
  for (const auto& [key, placed] : chunks_) {
    if (!passes(ray, placed.box, best)) continue;
    const MeshChunk& chunk = *placed.chunk;
    for (const auto& t : chunk.triangles) {
      const Vec3d a = chunk.vertices[t[0]].cast<double>(), b = chunk.vertices[t[1]].cast<double>(),
                  c = chunk.vertices[t[2]].cast<double>();
      const auto way = meet(ray, a, c, b);  // seen from behind
      if (way && *way > from + kLeast) best = std::min(best, *way);
    }
  }
  if (best == kFar) return {};
  return best;
}

std::optional<double> entry(const BrickField& field, const Ray& ray, double from, double to) {
  const double least = 0.25 * field.voxel();
  double way = from, before = field.sample(ray.at(way));
  if (before < 0) return {};
  while (way < to) {
    const double next = way + std::max(0.9 * before, least);
    const double value = field.sample(ray.at(next));
    if (value >= 0) {
      way = next;
      before = value;
      continue;
    }
    // Bisection.
    double outside = way, inside = next;
    for (int n = 0; n < 24; ++n) {
      const double middle = 0.5 * (outside + inside);
      (field.sample(ray.at(middle)) < 0 ? inside : outside) = middle;
    }
    return inside;
  }
  return {};
}

}  // namespace kerf
