#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/monitor/keep_out.h"

namespace kerf {
namespace {

constexpr float kOnSurface = 0.005f;  // mm

// Down the gradient onto the surface; false where that leads nowhere.
bool project(const ToolField& field, Vec3f& p) {
  constexpr float kStep = 0.01f;
  for (int n = 0; n < 6; ++n) {
    const float d = field.distance(p);
    if (std::abs(d) < 0.2f * kOnSurface) return true;
    float x[8], y[8], z[8], near[8];
    std::fill_n(x, 8, p[0]);
    std::fill_n(y, 8, p[1]);
    std::fill_n(z, 8, p[2]);
    x[0] += kStep;
    x[1] -= kStep;
    y[2] += kStep;
    y[3] -= kStep;
    z[4] += kStep;
    z[5] -= kStep;
    field.distances(x, y, z, near, 8);
    const Vec3f gradient(near[0] - near[1], near[2] - near[3], near[4] - near[5]);
    const float length = gradient.norm();
    if (!(length > 0.2f * kStep)) return false;  // on the axis, or a ridge
    p -= d / length * gradient;
  }
  return std::abs(field.distance(p)) < kOnSurface;
}

// Points of a surface, and how much of it each stands for.
struct SurfacePoints {
  std::vector<Vec3f> at;
  std::vector<float> area;  // mm^2
};

// The points of a lattice moved onto the surface. A node's area is h^3 of a hat over the distance, h wide on either
// side: along any axis of the lattice these sum to the surface.
SurfacePoints surfacePoints(const ToolField& field, double spacing) {
  SurfacePoints out;
  Box3 box = field.bounds();
  box.grow(spacing);
  const Vec3i size = (box.size() / spacing).array().ceil().cast<int>() + 1;
  const auto near = static_cast<float>(spacing);
  float x[8], y[8], z[8], d[8];
  for (int i = 0; i < size[0]; ++i)
    for (int j = 0; j < size[1]; ++j)
      for (int k = 0; k < size[2]; k += 8) {
        for (int n = 0; n < 8; ++n) {
          const Vec3d p = box.min + spacing * Vec3d(i, j, k + n);
          x[n] = static_cast<float>(p[0]);
          y[n] = static_cast<float>(p[1]);
          z[n] = static_cast<float>(p[2]);
        }
        field.distances(x, y, z, d, 8);
        for (int n = 0; n < 8 && k + n < size[2]; ++n)
          if (Vec3f p(x[n], y[n], z[n]); std::abs(d[n]) <= near && project(field, p)) {
            out.at.push_back(p);
            out.area.push_back(near * (near - std::abs(d[n])));
          }
      }
  return out;
}

// Candidates to choose `wanted` samples from: fine enough for a choice, no finer than some millions of lattice points.
// @param lattice  spacing, mm: out.
SurfacePoints candidatesFor(const ToolField& cut, std::size_t wanted, double& lattice) {
  lattice = std::min(0.4, cut.bounds().size().maxCoeff() / 8);
  for (;;) {
    SurfacePoints candidates = surfacePoints(cut, lattice);
    const double next = lattice / 1.4;
    if (candidates.at.size() >= 20 * wanted || (cut.bounds().size() / next).prod() > 4e6) return candidates;
    lattice = next;
  }
}

// Farthest first, from the lowest on: every next point is the one worst covered so far. Each stands for the area of
// the candidates that it is the nearest to.
// @param farthest  squared distance from a candidate to the nearest point chosen, at most, mm^2: out.
SurfacePoints chooseSpread(const SurfacePoints& all, std::size_t wanted, float& farthest) {
  const std::vector<Vec3f>& candidates = all.at;
  std::size_t next = 0;
  for (std::size_t n = 1; n < candidates.size(); ++n)
    if (candidates[n][2] < candidates[next][2]) next = n;

  std::vector<float> squared(candidates.size(), std::numeric_limits<float>::infinity());
  std::vector<std::size_t> nearest(candidates.size(), 0);
  SurfacePoints chosen;
  do {
    chosen.at.push_back(candidates[next]);
    farthest = 0;
    for (std::size_t n = 0; n < candidates.size(); ++n) {
      if (const float d = (candidates[n] - chosen.at.back()).squaredNorm(); d < squared[n]) {
        squared[n] = d;
        nearest[n] = chosen.at.size() - 1;
      }
      if (squared[n] > farthest) {
        farthest = squared[n];
        next = n;
      }
    }
  } while (chosen.at.size() < wanted && farthest > 0);

  chosen.area.assign(chosen.at.size(), 0);
  for (std::size_t n = 0; n < candidates.size(); ++n) chosen.area[nearest[n]] += all.area[n];
  return chosen;
}

}  // namespace

ToolSamples::ToolSamples(const ToolField& cut, int count) {
  if (cut.isEmpty()) return;
  const auto wanted = static_cast<std::size_t>(std::max(count, 1));
  double lattice = 0;
  const SurfacePoints candidates = candidatesFor(cut, wanted, lattice);
  if (candidates.at.empty()) return;

  float farthest = 0;
  const SurfacePoints chosen = chooseSpread(candidates, wanted, farthest);
  // A surface point is at most the lattice's half diagonal from a node, and that node's point as far again.
  spacing_ = std::sqrt(static_cast<double>(farthest)) + std::sqrt(3.0) * lattice;
  group(chosen.at, chosen.area, static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(wanted)))));
}

// Groups about the first few points, which are spread as evenly as so few can be.
void ToolSamples::group(const std::vector<Vec3f>& chosen, const std::vector<float>& areas, std::size_t most_groups) {
  const std::size_t group_count = std::min(chosen.size(), most_groups);
  std::vector<std::vector<std::size_t>> members(group_count);
  for (std::size_t n = 0; n < chosen.size(); ++n) {
    std::size_t nearest = 0;
    for (std::size_t g = 1; g < group_count; ++g)
      if ((chosen[n] - chosen[g]).squaredNorm() < (chosen[n] - chosen[nearest]).squaredNorm()) nearest = g;
    members[nearest].push_back(n);
  }

  for (std::size_t g = 0; g < group_count; ++g) {
    Group group{chosen[g], 0, static_cast<int>(points_.size()), 0};
    for (const std::size_t n : members[g]) {
      group.radius = std::max(group.radius, (chosen[n] - group.center).norm());
      points_.push_back(chosen[n]);
      areas_.push_back(areas[n]);
    }
    group.end = static_cast<int>(points_.size());
    groups_.push_back(group);
  }
}

}  // namespace kerf
