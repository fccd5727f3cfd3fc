#include "preprocess/print/thickness.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "geometry/mesh/box_tree.h"

namespace kerf {
namespace {

constexpr double kInside = 1 - 1e-4;  // of its radius: a ball that cuts a surface no deeper touches it
constexpr double kLeast = 1e-6;       // mm
constexpr double kDegree = M_PI / 180;

// After Ericson, Real-Time Collision Detection, 5.1.5.
Vec3d nearestOn(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& p) {
  const Vec3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const double d3 = ab.dot(p - b), d4 = ac.dot(p - b);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const double d5 = ab.dot(p - c), d6 = ac.dot(p - c);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  return a + (vb * ab + vc * ac) / (va + vb + vc);
}

double square(double x) { return x * x; }

double squaredDistance(const Box3& box, const Vec3d& p) {
  return (p - p.cwiseMax(box.min).cwiseMin(box.max)).squaredNorm();
}

class ShrinkingBalls {
 public:
  ShrinkingBalls(const Mesh& mesh, const ThicknessOptions& options)
      : mesh_(mesh),
        most_(options.most_mm),
        opposite_(-std::cos(options.opposing_deg * kDegree)),
        tree_(boxes(mesh)),
        normals_(mesh.triangles.size()),
        first_(mesh.vertices.size() + 1) {
    for (std::size_t t = 0; t < normals_.size(); ++t) normals_[t] = doubleAreaVector(mesh, t).stableNormalized();
    for (const Triangle& t : mesh.triangles)
      for (const std::uint32_t v : t) ++first_[v + 1];
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) first_[v + 1] += first_[v];
    around_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      for (const std::uint32_t v : mesh.triangles[t]) around_[next[v]++] = t;
  }

  double at(std::size_t v) const {
    double out = most_;
    for (const Vec3d& normal : normalsOf(v)) out = std::min(out, ballAt(mesh_.vertices[v], normal, out));
    return out;
  }

 private:
  static std::vector<Box3> boxes(const Mesh& mesh) {
    std::vector<Box3> out(mesh.triangles.size());
    for (std::size_t t = 0; t < out.size(); ++t)
      for (int k = 0; k < 3; ++k) out[t].add(mesh.corner(t, k));
    return out;
  }

  // One normal where the surface is smooth, else those of the faces that meet, 20 degrees apart.
  std::vector<Vec3d> normalsOf(std::size_t v) const {
    Vec3d mean = Vec3d::Zero();
    for (std::uint32_t n = first_[v]; n < first_[v + 1]; ++n) {
      const Triangle& t = mesh_.triangles[around_[n]];
      const std::size_t k = t[0] == v ? 0 : t[1] == v ? 1 : 2;
      const Vec3d a = mesh_.vertices[t[(k + 1) % 3]] - mesh_.vertices[v];
      const Vec3d b = mesh_.vertices[t[(k + 2) % 3]] - mesh_.vertices[v];
      mean += std::atan2(a.cross(b).norm(), a.dot(b)) * normals_[around_[n]];
    }
    mean = mean.stableNormalized();
    std::vector<Vec3d> out;
    bool is_smooth = true;
    for (std::uint32_t n = first_[v]; n < first_[v + 1]; ++n) {
      const Vec3d& normal = normals_[around_[n]];
      if (normal.isZero()) continue;
      is_smooth &= normal.dot(mean) > std::cos(30 * kDegree);
      const bool is_new =
          std::none_of(out.begin(), out.end(), [&](const Vec3d& o) { return o.dot(normal) > std::cos(20 * kDegree); });
      if (is_new) out.push_back(normal);
    }
    if (is_smooth && !out.empty()) out.assign(1, mean);
    return out;
  }

  // Balls that touch at p are nested, so one visit suffices: each triangle in the present ball shrinks it.
  double ballAt(const Vec3d& p, const Vec3d& normal, double most) const {
    double r = most / 2;
    Vec3d centre = p - r * normal;
    tree_.visit([&](const Box3& box) { return squaredDistance(box, centre) < square(kInside * r); },
                [&](std::uint32_t t) {
                  if (normals_[t].dot(normal) >= opposite_) return true;
                  const Vec3d a = mesh_.corner(t, 0), b = mesh_.corner(t, 1), c = mesh_.corner(t, 2);
                  while (r > kLeast) {
                    const Vec3d way = p - nearestOn(a, b, c, centre);
                    if ((way - r * normal).norm() >= kInside * r) return true;
                    // Through p and that point; positive, since the point lies in a ball on this side of p.
                    r = std::min(r, way.squaredNorm() / (2 * std::max(way.dot(normal), 1e-15)));
                    centre = p - r * normal;
                  }
                  return true;
                });
    return r > kLeast ? 2 * r : 0;
  }

  const Mesh& mesh_;
  double most_, opposite_;
  BoxTree tree_;
  std::vector<Vec3d> normals_;
  std::vector<std::uint32_t> first_, around_;  // triangles around vertex v: around_[first_[v] .. first_[v + 1])
};

}  // namespace

Expected<std::vector<double>> wallThickness(const Mesh& solid, const ThicknessOptions& options,
                                            const Progress& progress) {
  if (solid.triangles.empty()) return fail({.code = Error::Code::kEmpty, .found = "a mesh without triangles"});
  if (!(options.most_mm > 0 && options.most_mm < 1e4))
    return fail({.place = "most thickness", .found = fmt::format("{:g} mm", options.most_mm), .expected = "above 0"});
  if (!(options.opposing_deg >= 5 && options.opposing_deg <= 85))
    return fail({.place = "angle of opposing surfaces",
                 .found = fmt::format("{:g} degrees", options.opposing_deg),
                 .expected = "5 to 85"});
  if (!(signedVolume(solid) > 0))
    return fail({.code = Error::Code::kGeometry,
                 .found = fmt::format("a volume of {:.3g} mm3", signedVolume(solid)),
                 .expected = "a closed solid, turned outwards"});
  if (!report(progress, 0, "wall thickness")) return cancelled();
  const ShrinkingBalls walls(solid, options);
  std::vector<double> out(solid.vertices.size());
  constexpr std::size_t kBlock = 8192;
  for (std::size_t begin = 0; begin < out.size(); begin += kBlock) {
    if (!report(progress, static_cast<double>(begin) / static_cast<double>(out.size()), "wall thickness"))
      return cancelled();
    tbb::parallel_for(begin, std::min(out.size(), begin + kBlock), [&](std::size_t v) { out[v] = walls.at(v); });
  }
  return out;
}

}  // namespace kerf
