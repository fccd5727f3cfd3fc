#include "geometry/tool/tool_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace kerf {
namespace {

using Symmetry = ToolShape::Symmetry;
using internal::TableForm;

constexpr float kRoundingOfPlates = 1e-6f;  // mm: ten times the rounding error of a coordinate of a millimetre
constexpr double kRoundings = 16;           // of a point's coordinates, seen from the tool before and after it moves

}  // namespace

ToolField::ToolField(const ToolShape& shape, const ToolFieldOptions& options) : bounds_(shape.bounds()) {
  const Symmetry form = shape.symmetry();
  lookup_.form = shape.isBox()                 ? TableForm::kBox
                 : form == Symmetry::kRevolved ? TableForm::kRevolved
                 : form == Symmetry::kPlate    ? TableForm::kPlate
                                               : TableForm::kSpatial;
  lookup_.half = static_cast<float>(shape.halfThickness());
  lookup_.reach = static_cast<float>(options.margin_mm);
  if (shape.isBox() || form == Symmetry::kPlate) least_overlap_ = kRoundingOfPlates;
  for (int c = 0; c < 8; ++c) reach_ = std::max(reach_, bounds_.corner(c).norm());

  if (shape.isBox()) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      lookup_.low[a] = static_cast<float>(bounds_.min[axis]);
      lookup_.high[a] = static_cast<float>(bounds_.max[axis]);
    }
    slack_ = kRoundings * std::numeric_limits<float>::epsilon() * (reach_ + options.margin_mm);
    return;
  }

  const bool is_planar = form != Symmetry::kNone;
  Vec3d low = bounds_.min, high = bounds_.max;
  if (is_planar) {
    const double radius = std::max({-low[0], high[0], -low[1], high[1]});
    low = form == Symmetry::kRevolved ? Vec3d(0, low[2], 0) : Vec3d(low[0], low[2], 0);
    high = form == Symmetry::kRevolved ? Vec3d(radius, high[2], 0) : Vec3d(high[0], high[2], 0);
  }

  // One sample beyond the margin on every side, so that no interpolation leaves the table.
  double spacing = is_planar ? options.spacing_mm : options.spacing_3d_mm;
  const auto samples = [&](int axis) {
    return static_cast<int>(std::ceil((high[axis] - low[axis] + 2 * options.margin_mm) / spacing)) + 3;
  };
  const auto total = [&] {
    std::size_t n = 1;
    for (int axis = 0; axis < (is_planar ? 2 : 3); ++axis) n *= static_cast<std::size_t>(samples(axis));
    return n;
  };

  while (total() > options.most_samples) spacing *= 1.1;

  slack_ = (is_planar ? 0.4 : 0.7) * spacing;
  lookup_.inverse = static_cast<float>(1 / spacing);

  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    lookup_.low[a] = static_cast<float>(low[axis]);
    lookup_.high[a] = static_cast<float>(high[axis]);
    lookup_.origin[a] = static_cast<float>(low[axis] - options.margin_mm - spacing);
    lookup_.size[a] = axis < (is_planar ? 2 : 3) ? samples(axis) : 1;
  }

  const double step = 1 / static_cast<double>(lookup_.inverse);
  const auto at = [&](int i, int j, int k) -> double {
    const Vec3d p(static_cast<double>(lookup_.origin[0]) + i * step, static_cast<double>(lookup_.origin[1]) + j * step,
                  static_cast<double>(lookup_.origin[2]) + k * step);
    if (!is_planar) return shape.distance(p);
    return shape.distance(form == Symmetry::kRevolved ? Vec3d(std::abs(p[0]), 0, p[1]) : Vec3d(p[0], 0, p[1]));
  };

  table_.resize(total());
  tbb::parallel_for(0, lookup_.size[0], [&](int i) {
    std::size_t n = static_cast<std::size_t>(i) * static_cast<std::size_t>(lookup_.size[1] * lookup_.size[2]);
    for (int j = 0; j < lookup_.size[1]; ++j)
      for (int k = 0; k < lookup_.size[2]; ++k) table_[n++] = static_cast<float>(at(i, j, k));
  });
}

void ToolField::distances(const float* x, const float* y, const float* z, float* out, int n) const noexcept {
  if (isEmpty()) {
    std::fill_n(out, n, kFar);
    return;
  }
  internal::FieldTable table = lookup_;
  table.values = table_.data();
  internal::lookUp(table, x, y, z, out, n);
}

float ToolField::distance(const Vec3f& p) const noexcept {
  float x[8], y[8], z[8], d[8];
  std::fill_n(x, 8, p[0]);
  std::fill_n(y, 8, p[1]);
  std::fill_n(z, 8, p[2]);
  distances(x, y, z, d, 8);
  return d[0];
}

}  // namespace kerf
