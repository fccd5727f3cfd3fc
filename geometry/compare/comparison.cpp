#include "geometry/compare/comparison.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace kerf {
namespace {

struct Sample {
  Vec3d at;
  double area;
  std::uint32_t triangle;
};

// Halves the longest edge until none is longer than the spacing.
void addSamples(const std::array<Vec3d, 3>& corners, std::uint32_t triangle, double spacing, std::vector<Sample>& out) {
  const auto& [a, b, c] = corners;
  const std::array<double, 3> squared{(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()};
  const std::size_t k = static_cast<std::size_t>(std::max_element(squared.begin(), squared.end()) - squared.begin());
  if (squared[k] <= spacing * spacing) {
    out.push_back({(a + b + c) / 3, 0.5 * (b - a).cross(c - a).norm(), triangle});
    return;
  }
  const Vec3d &p = corners[k], &q = corners[(k + 1) % 3], &r = corners[(k + 2) % 3], middle = 0.5 * (p + q);
  addSamples({p, middle, r}, triangle, spacing, out);
  addSamples({middle, q, r}, triangle, spacing, out);
}

// About the number of samples.
double partsOf(const Mesh& mesh, double spacing) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    double longest = 0;
    for (int k = 0; k < 3; ++k) longest = std::max(longest, (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k)).norm());
    const double area = 0.5 * doubleAreaVector(mesh, t).norm();
    sum += longest <= spacing ? 1 : std::max(2 * longest / spacing, 4 * area / (spacing * spacing));
  }
  return sum;
}

class Measure {
 public:
  /// @param sign  +1: `to` has the material that deviations are measured from.
  Measure(const Mesh& from, const MeshDistance& from_distance, const MeshDistance& to, double sign,
          const ComparisonOptions& options)
      : from_(from), from_distance_(from_distance), to_(to), sign_(sign), options_(options) {}

  Expected<Deviations> all(const Progress& progress) {
    const double area = surfaceArea(from_);
    if (!(area > 0))
      return fail({.code = Error::Code::kEmpty, .found = "a mesh without area", .expected = "a surface"});
    constexpr double kParts = 200'000, kMost = 5e6, kCoarser = 1.4;
    out_.spacing_mm = options_.spacing_mm > 0 ? options_.spacing_mm : std::sqrt(4 * area / kParts);
    const double least = static_cast<double>(from_.triangles.size());
    while (options_.spacing_mm <= 0 && partsOf(from_, out_.spacing_mm) > kMost + least) out_.spacing_mm *= kCoarser;
    if (!vertices(partOf(progress, 0, 0.3)) || !samples(partOf(progress, 0.3, 1))) return cancelled();
    if (out_.value.empty())
      return fail({.code = Error::Code::kEmpty,
                   .found = "no part of one mesh lies over the other",
                   .expected = "two meshes of the same place",
                   .hint = "--align, if they are in different frames"});
    summarize();
    return std::move(out_);
  }

 private:
  // Empty where excluded.
  std::optional<double> deviation(const NearestOnMesh& nearest) const {
    if (nearest.distance_mm <= Deviations::kSame) return 0;
    if (nearest.is_on_boundary) return {};
    return sign_ * nearest.signed_mm;
  }

  void extend(double mm, const Vec3d& at) {
    if (!has_any_ || mm > out_.most.mm) out_.most = {mm, at};
    if (!has_any_ || mm < out_.least.mm) out_.least = {mm, at};
    has_any_ = true;
  }

  bool vertices(const Progress& progress) {
    constexpr float kExcluded = std::numeric_limits<float>::quiet_NaN();
    const std::size_t count = from_.vertices.size();
    std::vector<double> mm(count, std::numeric_limits<double>::quiet_NaN());
    for (std::size_t begin = 0; begin < count; begin += kBlock) {
      if (!report(progress, static_cast<double>(begin) / static_cast<double>(count), "comparing")) return false;
      tbb::parallel_for(begin, std::min(count, begin + kBlock), [&](std::size_t v) {
        if (const auto d = deviation(to_.nearest(from_.vertices[v]))) mm[v] = *d;
      });
    }
    out_.at_vertex.assign(count, kExcluded);
    for (const Triangle& t : from_.triangles)
      for (const std::uint32_t v : t) out_.at_vertex[v] = static_cast<float>(mm[v]);
    for (std::size_t v = 0; v < count; ++v)
      if (!std::isnan(out_.at_vertex[v])) extend(mm[v], from_.vertices[v]);
    return true;
  }

  bool samples(const Progress& progress) {
    std::vector<Sample> block;
    std::vector<NearestOnMesh> nearest;
    const auto count = static_cast<std::uint32_t>(from_.triangles.size());
    for (std::uint32_t t = 0; t < count;) {
      if (!report(progress, static_cast<double>(t) / count, "comparing")) return false;
      block.clear();
      for (; t < count && block.size() < kBlock; ++t)
        addSamples({from_.corner(t, 0), from_.corner(t, 1), from_.corner(t, 2)}, t, out_.spacing_mm, block);
      nearest.resize(block.size());
      tbb::parallel_for(std::size_t{0}, block.size(), [&](std::size_t n) { nearest[n] = to_.nearest(block[n].at); });
      for (std::size_t n = 0; n < block.size(); ++n) add(block[n], nearest[n]);
    }
    return true;
  }

  void add(const Sample& sample, const NearestOnMesh& nearest) {
    if (!(sample.area > 0)) return;
    const auto d = deviation(nearest);
    if (!d) {
      out_.excluded_mm2 += sample.area;
      return;
    }
    out_.area_mm2 += sample.area;
    out_.mean_mm += sample.area * *d;
    out_.mean_abs_mm += sample.area * std::abs(*d);
    out_.rms_mm += sample.area * *d * *d;
    (std::abs(*d) <= options_.tolerance_mm ? out_.within : *d > 0 ? out_.over : out_.under) += sample.area;
    if (*d == 0) out_.unchanged += sample.area;
    out_.normals_agree += sample.area * from_distance_.normal(sample.triangle).dot(to_.normal(nearest.triangle));
    out_.value.push_back(static_cast<float>(*d));
    out_.area.push_back(static_cast<float>(sample.area));
    extend(*d, sample.at);
  }

  void summarize() {
    out_.samples = out_.value.size();
    for (double* sum : {&out_.mean_mm, &out_.mean_abs_mm, &out_.rms_mm, &out_.within, &out_.over, &out_.under,
                        &out_.unchanged, &out_.normals_agree})
      *sum /= out_.area_mm2;
    out_.rms_mm = std::sqrt(out_.rms_mm);

    std::vector<std::uint32_t> order(out_.samples);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(std::abs(out_.value[a]), a) < std::pair(std::abs(out_.value[b]), b);
    });
    constexpr double kPart = 0.95;
    double below = 0;
    for (const std::uint32_t n : order) {
      below += static_cast<double>(out_.area[n]);
      out_.p95_mm = static_cast<double>(std::abs(out_.value[n]));
      if (below >= kPart * out_.area_mm2) break;
    }
  }

  static constexpr std::size_t kBlock = 20'000;  // between two reports
  const Mesh& from_;
  const MeshDistance &from_distance_, &to_;
  double sign_;
  const ComparisonOptions& options_;
  Deviations out_;
  bool has_any_ = false;
};

}  // namespace

Expected<Comparison> compareMeshes(const Mesh& first, const MeshDistance& first_distance, const Mesh& second,
                                   const MeshDistance& second_distance, const ComparisonOptions& options,
                                   const Progress& progress) {
  KERF_TRY(of_first, Measure(first, first_distance, second_distance, -1, options).all(partOf(progress, 0, 0.5)));
  KERF_TRY(of_second, Measure(second, second_distance, first_distance, +1, options).all(partOf(progress, 0.5, 1)));
  return Comparison{std::move(of_first), std::move(of_second)};
}

}  // namespace kerf
