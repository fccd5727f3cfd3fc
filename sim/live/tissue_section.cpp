#include "sim/live/tissue_section.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/live/label_reader.h"

namespace kerf {
namespace {

/// Mean colour of the eight nodes around a point, with trilinear weights.
class MeanColour {
 public:
  MeanColour(const TissueLabels& labels, const TissuePalette& palette)
      : reader_(labels), nodes_per_mm_(1 / labels.baked->voxel()) {
    for (std::size_t n = 0; n < colours_.size(); ++n) {
      const Rgba8 c = palette.shown(static_cast<std::uint8_t>(n));
      colours_[n] = Vec3f(c[0], c[1], c[2]);
    }
  }

  Rgba8 at(const Vec3d& p) {
    const Vec3d q = nodes_per_mm_ * p;
    const Vec3i low = q.array().floor().cast<int>().matrix();
    const Vec3f t = (q - low.cast<double>()).cast<float>();

    Vec3f sum = Vec3f::Zero();
    float labelled = 0;
    for (int n = 0; n < 8; ++n) {
      const Vec3i step{n >> 2, n >> 1 & 1, n & 1};
      const std::uint8_t material = reader_.at(low + step);
      if (material == 0) continue;
      float weight = 1;
      for (int axis = 0; axis < 3; ++axis) weight *= step[axis] ? t[axis] : 1 - t[axis];
      sum += weight * colours_[material];
      labelled += weight;
    }
    const auto byte = [](float v) { return static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0f, 255.0f))); };
    return {byte(sum[0]), byte(sum[1]), byte(sum[2]), byte(255 * labelled)};
  }

 private:
  LabelReader reader_;
  double nodes_per_mm_;
  std::array<Vec3f, 256> colours_;
};

// The corners of the box's cut with the plane, as (along u, along v) from its point.
Eigen::AlignedBox2d extentOf(const Plane& plane, const Box3& box, const Vec3d& u, const Vec3d& v) {
  Eigen::AlignedBox2d out;
  for (int n = 0; n < 8; ++n)
    for (const int bit : {1, 2, 4}) {
      if (n & bit) continue;
      const Vec3d a = box.corner(n), b = box.corner(n | bit);
      const double low = plane.height(a), high = plane.height(b);
      if ((low < 0) == (high < 0)) continue;
      const Vec3d p = a + low / (low - high) * (b - a) - plane.point;
      out.extend(Eigen::Vector2d(u.dot(p), v.dot(p)));
    }
  return out;
}

}  // namespace

TissueSection tissueSection(const Plane& plane, const TissueLabels& labels, const TissuePalette& palette,
                            std::size_t most) {
  TissueSection out;
  const Box3 box = labels.baked->bounds();
  if (box.isEmpty() || !plane.point.allFinite() || !plane.normal.allFinite() || plane.normal.norm() < 1e-9) return out;
  const Vec3d u = plane.normal.unitOrthogonal(), v = plane.normal.normalized().cross(u);
  const Eigen::AlignedBox2d extent = extentOf(plane, box, u, v);
  if (extent.isEmpty()) return out;

  const Eigen::Vector2d size = extent.sizes();
  const double least = std::sqrt(size[0] * size[1] / static_cast<double>(std::max<std::size_t>(most, 1)));
  const double step = std::max({labels.baked->voxel(), least, size.maxCoeff() / 4096});
  out.width = static_cast<int>(std::ceil(size[0] / step)) + 1;
  out.height = static_cast<int>(std::ceil(size[1] / step)) + 1;
  out.origin = plane.point + extent.min()[0] * u + extent.min()[1] * v;
  out.u = step * u;
  out.v = step * v;

  MeanColour colour(labels, palette);
  out.colours.reserve(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
  for (int j = 0; j < out.height; ++j)
    for (int i = 0; i < out.width; ++i) out.colours.push_back(colour.at(out.origin + i * out.u + j * out.v));
  return out;
}

}  // namespace kerf
