#include "preprocess/print/columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kerf::internal {
namespace {

constexpr double kLargest = 1e4;  // mm
constexpr double kMostLines = 50e6;
constexpr double kUnits = 65536;  // of a mm: products of differences up to 10 m fit in 64 bits

using Fixed = std::array<std::int64_t, 2>;

std::int64_t fixed(double mm) { return std::llround(mm * kUnits); }

// Twice the area of (a, b, p): positive, p lies to the left of a -> b. Never 0 for a != b: p counts as shifted by
// (e, e^2) for an infinitely small e.
std::int64_t side(const Fixed& a, const Fixed& b, const Fixed& p, bool& is_left) {
  const std::int64_t dx = b[0] - a[0], dy = b[1] - a[1];
  const std::int64_t area = dx * (p[1] - a[1]) - dy * (p[0] - a[0]);
  is_left = area ? area > 0 : dy ? dy < 0 : dx > 0;
  return area;
}

}  // namespace

tl::unexpected<Error> openAt(const ColumnGrid& grid, std::size_t line, double z) {
  const Vec3d p = grid.place(line, z);
  return fail({.code = Error::Code::kGeometry,
               .place = fmt::format("near ({:.2f}, {:.2f}, {:.2f})", p[0], p[1], p[2]),
               .found = "an open surface",
               .expected = "a closed solid",
               .hint = "kerf bake, then kerf export"});
}

Expected<void> checkAxis(const Vec3d& axis, const char* place) {
  if (axis.allFinite() && std::abs(axis.norm() - 1) < 1e-6) return {};
  return fail({.place = place,
               .found = fmt::format("({:g}, {:g}, {:g})", axis[0], axis[1], axis[2]),
               .expected = "a vector of length 1"});
}

Expected<ColumnGrid> ColumnGrid::around(const Mesh& mesh, const Vec3d& axis, double voxel_mm) {
  if (mesh.triangles.empty()) return fail({.code = Error::Code::kEmpty, .found = "a mesh without triangles"});
  ColumnGrid out;
  out.voxel_ = voxel_mm;
  int least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Vec3d x = (Vec3d::Unit(least) - axis * axis[least]).normalized();
  out.turn_ << x.transpose(), axis.cross(x).transpose(), axis.transpose();
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) out.box_.add(out.toFrame(mesh.vertices[v]));
  const Vec3d size = out.box_.size();
  if (size.maxCoeff() > kLargest)
    return fail({.code = Error::Code::kGeometry,
                 .found = fmt::format("a mesh of {:.0f} mm", size.maxCoeff()),
                 .expected = fmt::format("at most {:.0f} mm", kLargest),
                 .hint = "the right unit"});
  const double lines = (size[0] / voxel_mm + 3) * (size[1] / voxel_mm + 3);
  if (lines > kMostLines)
    return fail({.place = "voxel size",
                 .found = fmt::format("{:g} mm: {:.0f} million columns", voxel_mm, lines / 1e6),
                 .expected = fmt::format("at most {:.0f} million", kMostLines / 1e6),
                 .hint = fmt::format("{:.2g} mm", 1.2 * voxel_mm * std::sqrt(lines / kMostLines))});
  out.low_ = out.box_.min - Vec3d::Constant(voxel_mm);
  out.nx_ = static_cast<int>(std::ceil(size[0] / voxel_mm)) + 2;
  out.ny_ = static_cast<int>(std::ceil(size[1] / voxel_mm)) + 2;
  return out;
}

bool ColumnGrid::eachCrossing(const Mesh& mesh, const Progress& progress,
                              const std::function<void(std::size_t, double, bool)>& hit) const {
  const auto steps = std::max<std::size_t>(mesh.triangles.size() / 50, 1);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t % steps == 0 &&
        !report(progress, static_cast<double>(t) / static_cast<double>(mesh.triangles.size()), "columns"))
      return false;
    std::array<Vec3d, 3> p;
    std::array<Fixed, 3> f;
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(k);
      p[at] = toFrame(mesh.corner(t, k)) - Vec3d(low_[0], low_[1], 0);
      f[at] = {fixed(p[at][0]), fixed(p[at][1])};
    }
    const std::int64_t area = (f[1][0] - f[0][0]) * (f[2][1] - f[0][1]) - (f[1][1] - f[0][1]) * (f[2][0] - f[0][0]);
    if (area == 0) continue;  // seen edge-on: the lines pass beside it
    const auto [y_low, y_high] = std::minmax({p[0][1], p[1][1], p[2][1]});
    const int j_end = std::min(ny_ - 1, static_cast<int>(std::floor(y_high / voxel_)) + 1);
    for (int j = std::max(0, static_cast<int>(std::floor(y_low / voxel_)) - 1); j <= j_end; ++j) {
      const double y = (j + 0.5) * voxel_;
      const std::int64_t fixed_y = fixed(y);
      // The span of the triangle on this row, a little too wide.
      double x_low = std::numeric_limits<double>::infinity(), x_high = -x_low;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d &a = p[k], &b = p[(k + 1) % 3];
        if (std::min(a[1], b[1]) > y + 1e-3 || std::max(a[1], b[1]) < y - 1e-3) continue;
        const double share = std::clamp(std::abs(b[1] - a[1]) > 1e-3 ? (y - a[1]) / (b[1] - a[1]) : 0.0, 0.0, 1.0);
        const double slack =
            std::abs(b[1] - a[1]) > 1e-3 ? 1e-3 * std::abs((b[0] - a[0]) / (b[1] - a[1])) : std::abs(b[0] - a[0]);
        const double x = a[0] + share * (b[0] - a[0]);
        x_low = std::min(x_low, x - slack);
        x_high = std::max(x_high, x + slack);
      }
      if (x_low > x_high) continue;
      const int i_end = static_cast<int>(std::min(nx_ - 1.0, std::floor(x_high / voxel_) + 1));
      for (int i = static_cast<int>(std::max(0.0, std::floor(x_low / voxel_) - 1)); i <= i_end; ++i) {
        const Fixed at{fixed((i + 0.5) * voxel_), fixed_y};
        std::array<bool, 3> left;
        std::array<double, 3> weight;
        for (std::size_t k = 0; k < 3; ++k)
          weight[k] = static_cast<double>(side(f[(k + 1) % 3], f[(k + 2) % 3], at, left[k]));
        if (left[0] != left[1] || left[1] != left[2]) continue;
        const double z = (weight[0] * p[0][2] + weight[1] * p[1][2] + weight[2] * p[2][2]) / static_cast<double>(area);
        hit(static_cast<std::size_t>(j) * static_cast<std::size_t>(nx_) + static_cast<std::size_t>(i), z, area < 0);
      }
    }
  }
  return true;
}

}  // namespace kerf::internal
