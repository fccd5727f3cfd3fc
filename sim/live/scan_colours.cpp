#include "sim/live/scan_colours.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sim/live/tissue_colours.h"

namespace kerf {
namespace {

constexpr double kFull = 1, kNone = 2;  // voxels from the scan: up to the first only its colour, from the second none
                                        // of it

std::vector<Box3> boxesOf(const Mesh& mesh) {
  std::vector<Box3> out(mesh.triangles.size());
  for (std::size_t t = 0; t < out.size(); ++t)
    for (int k = 0; k < 3; ++k) out[t].add(mesh.corner(t, k));
  return out;
}

double squaredDistance(const Box3& box, const Vec3d& p) {
  return (box.min - p).cwiseMax(p - box.max).cwiseMax(0.0).squaredNorm();
}

// Weights of the corners at the place of a triangle that is nearest to p.
// After Ericson, Real-Time Collision Detection (2005), 5.1.5.
Vec3d nearestWeights(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};

  const Vec3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) {
    const double v = d1 / (d1 - d3);
    return {1 - v, v, 0};
  }

  const Vec3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) {
    const double w = d2 / (d2 - d6);
    return {1 - w, 0, w};
  }
  const double va = d3 * d6 - d5 * d4;
  const double along_b = d4 - d3, along_c = d5 - d6;
  if (va <= 0 && along_b >= 0 && along_c >= 0 && along_b + along_c > 0) {
    const double w = along_b / (along_b + along_c);
    return {0, 1 - w, w};
  }

  const double sum = va + vb + vc;
  if (!(sum > 0)) return {1, 0, 0};
  return {va / sum, vb / sum, vc / sum};
}

struct NearestPlace {
  std::uint32_t triangle = 0;
  Vec3d weights = Vec3d::UnitX();
  double squared_distance = std::numeric_limits<double>::infinity();
};

/// The triangles near a chunk, vertex after vertex: each search begins at the last nearest triangle.
class NearTriangles {
 public:
  NearTriangles(const ScanColours& scan, const Box3& box) : mesh_(scan.solid()), numbers_(scan.near(box)) {
    boxes_.resize(numbers_.size());
    for (std::size_t n = 0; n < numbers_.size(); ++n)
      for (int k = 0; k < 3; ++k) boxes_[n].add(mesh_.corner(numbers_[n], k));
  }
  bool isEmpty() const { return numbers_.empty(); }

  NearestPlace nearest(const Vec3d& p) {
    NearestPlace best;
    if (last_ < numbers_.size()) compare(p, last_, best);
    for (std::size_t n = 0; n < numbers_.size(); ++n)
      if (squaredDistance(boxes_[n], p) < best.squared_distance) compare(p, n, best);
    return best;
  }

 private:
  void compare(const Vec3d& p, std::size_t n, NearestPlace& best) {
    const std::uint32_t t = numbers_[n];
    const Vec3d a = mesh_.corner(t, 0), b = mesh_.corner(t, 1), c = mesh_.corner(t, 2);
    const Vec3d weights = nearestWeights(p, a, b, c);
    const double squared = (weights[0] * a + weights[1] * b + weights[2] * c - p).squaredNorm();
    if (!(squared < best.squared_distance)) return;
    best = {t, weights, squared};
    last_ = n;
  }

  const Mesh& mesh_;
  std::vector<std::uint32_t> numbers_;
  std::vector<Box3> boxes_;
  std::size_t last_ = 0;
};

Rgba8 mixed(const Rgba8& a, const Rgba8& b, double share) {
  Rgba8 out = a;  // with its gloss
  for (std::size_t k = 0; k < 3; ++k)
    out[k] = static_cast<std::uint8_t>(std::lround((1 - share) * a[k] + share * b[k]));
  return out;
}

}  // namespace

ScanColours::ScanColours(Mesh solid) : solid_(std::move(solid)), tree_(boxesOf(solid_)) {}

std::shared_ptr<const ScanColours> ScanColours::of(Mesh solid) {
  if (!solid.hasVertexColors() && !solid.hasFaceColors()) return nullptr;
  return std::shared_ptr<const ScanColours>(new ScanColours(std::move(solid)));
}

std::vector<std::uint32_t> ScanColours::near(const Box3& box) const {
  std::vector<std::uint32_t> out;
  tree_.visit([&](const Box3& node) { return overlap(node, box); },
              [&](std::uint32_t triangle) {
                if (overlap(tree_.boxes()[triangle], box)) out.push_back(triangle);
                return true;
              });
  return out;
}

Rgba8 ScanColours::colourAt(std::uint32_t triangle, const Vec3d& weights) const {
  if (!solid_.hasVertexColors()) return solid_.face_colors[triangle];
  Rgba8 out{0, 0, 0, 255};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k)
      sum += weights[static_cast<Eigen::Index>(k)] * solid_.vertex_colors[solid_.triangles[triangle][k]][channel];
    out[channel] = static_cast<std::uint8_t>(std::lround(std::clamp(sum, 0.0, 255.0)));
  }
  return out;
}

std::vector<Rgba8> scanColours(const MeshChunk& chunk, const ScanColours& scan, const BrickField& original) {
  std::vector<Rgba8> out = chunk.colours;
  const double voxel = original.voxel();

  // How far each vertex lies on the scanned surface, 0 to 1.
  std::vector<float> shares(chunk.vertices.size());
  Box3 box;
  for (std::size_t v = 0; v < chunk.vertices.size(); ++v) {
    const Vec3d p = chunk.vertices[v].cast<double>();
    shares[v] = 1 - cutShare(original, p);
    if (shares[v] > 0) box.add(p);
  }
  if (box.isEmpty()) return out;

  box.grow(kNone * voxel);
  NearTriangles triangles(scan, box);
  if (triangles.isEmpty()) return out;
  for (std::size_t v = 0; v < chunk.vertices.size(); ++v) {
    if (!(shares[v] > 0)) continue;
    const NearestPlace place = triangles.nearest(chunk.vertices[v].cast<double>());
    const double away = std::sqrt(place.squared_distance) / voxel;
    const double share = static_cast<double>(shares[v]) * std::clamp((kNone - away) / (kNone - kFull), 0.0, 1.0);
    out[v] = mixed(chunk.colours[v], scan.colourAt(place.triangle, place.weights), share);
  }
  return out;
}

}  // namespace kerf
