#include "preprocess/close/winding.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf::internal {
namespace {

/// Half the solid angle of triangle abc seen from p, positive if p is behind it.
double halfSolidAngle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double numerator = a.dot(b.cross(c));
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return std::atan2(numerator, denominator);
}

double one(const Mesh& mesh, std::size_t t, const Vec3d& p) {
  return halfSolidAngle(mesh.corner(t, 0) - p, mesh.corner(t, 1) - p, mesh.corner(t, 2) - p);
}

}  // namespace

double windingNumber(const Mesh& mesh, const Vec3d& p, std::span<const char> skip) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (skip.empty() || !skip[t]) sum += one(mesh, t, p);
  return sum / (2 * std::numbers::pi);
}

double windingNumberExcept(const Mesh& mesh, const Vec3d& p, std::span<const std::uint32_t> except) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    bool listed = false;
    for (const std::uint32_t e : except) listed = listed || e == t;
    if (!listed) sum += one(mesh, t, p);
  }
  return sum / (2 * std::numbers::pi);
}

RayWinding::RayWinding(const Mesh& mesh)
    : turn_(Eigen::AngleAxisd(0.7390851, Vec3d(0.5671433, 0.2614972, 0.7834305).normalized()).toRotationMatrix()),
      direction_(turn_.row(0)) {
  // The triangles, turned; and the grid across the ray.
  constexpr std::size_t kMostCells = 1 << 20, kMostEntries = 32;  // of a triangle, in the mean
  mesh_.triangles = mesh.triangles;
  mesh_.vertices.reserve(mesh.vertices.size());
  for (const Vec3d& v : mesh.vertices) mesh_.vertices.emplace_back(turn_ * v);
  const Box3 box = bounds(mesh_);
  const Vec3d size = box.size();
  low_ = box.min;
  const double wanted = std::clamp(static_cast<double>(mesh.triangles.size()), 1.0, double{kMostCells});
  cell_ = std::max({std::sqrt(size[1] * size[2] / wanted), size[1] / kMostCells, size[2] / kMostCells, 1e-9});

  const auto cellsOf = [&](std::size_t t) {
    Box3 b;
    for (int k = 0; k < 3; ++k) b.add(mesh_.corner(t, k));
    return std::pair(cellOf(b.min[1], b.min[2]), cellOf(b.max[1], b.max[2]));
  };
  // Large triangles behind each other would fill the memory: then the cells become larger.
  const auto divide = [&] {
    const auto count = [&](double length) { return static_cast<std::size_t>(length / cell_) + 1; };
    ny_ = count(size[1]);
    nz_ = count(size[2]);
    std::size_t entries = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto [from, to] = cellsOf(t);
      entries += (to / nz_ - from / nz_ + 1) * (to % nz_ - from % nz_ + 1);
    }
    return entries;
  };
  while (divide() > kMostEntries * mesh.triangles.size() + kMostCells && ny_ * nz_ > 1) cell_ *= 2;

  // Counted per cell, then sorted in.
  first_.assign(ny_ * nz_ + 1, 0);
  const auto forEachCell = [&](std::size_t t, const auto& work) {
    const auto [from, to] = cellsOf(t);
    for (std::size_t y = from / nz_; y <= to / nz_; ++y)
      for (std::size_t z = from % nz_; z <= to % nz_; ++z) work(y * nz_ + z);
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) forEachCell(t, [&](std::size_t c) { ++first_[c + 1]; });
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];

  triangle_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    forEachCell(t, [&](std::size_t c) { triangle_[next[c]++] = static_cast<std::uint32_t>(t); });
}

std::size_t RayWinding::cellOf(double y, double z) const {
  const auto cell = [&](double x, double low, std::size_t n) {
    return static_cast<std::size_t>(std::clamp((x - low) / cell_, 0.0, static_cast<double>(n - 1)));
  };
  return cell(y, low_[1], ny_) * nz_ + cell(z, low_[2], nz_);
}

std::optional<int> RayWinding::at(const Vec3d& point, const std::function<bool(std::uint32_t)>& skip) const {
  const Vec3d p = turn_ * point;
  constexpr double kGrazing = 1e-9;  // of the triangle's size
  const std::size_t cell = cellOf(p[1], p[2]);
  int winding = 0;
  for (std::uint32_t n = first_[cell]; n < first_[cell + 1]; ++n) {
    const std::uint32_t t = triangle_[n];
    if (skip(t)) continue;
    const Vec3d a = mesh_.corner(t, 0) - p, b = mesh_.corner(t, 1) - p, c = mesh_.corner(t, 2) - p;
    const auto side = [](const Vec3d& u, const Vec3d& v) { return u[1] * v[2] - u[2] * v[1]; };
    const double ea = side(b, c), eb = side(c, a), ec = side(a, b);
    const double longest = std::max({a.squaredNorm(), b.squaredNorm(), c.squaredNorm()});
    const double graze = kGrazing * longest;
    if (std::max({ea, eb, ec}) < -graze || std::min({ea, eb, ec}) > graze) {
      const double x = (ea * a[0] + eb * b[0] + ec * c[0]) / (ea + eb + ec);
      if (std::abs(x) < kGrazing * std::sqrt(longest)) return {};
      if (x > 0) winding += ea > 0 ? 1 : -1;
    } else if ((ea >= -graze && eb >= -graze && ec >= -graze) || (ea <= graze && eb <= graze && ec <= graze)) {
      return {};
    }
  }
  return winding;
}

}  // namespace kerf::internal
