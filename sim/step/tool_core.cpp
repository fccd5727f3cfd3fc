#include "sim/step/tool_core.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr double kPlaneStep = 0.005;   // mm along an axis
constexpr double kMostApart = 0.15;    // mm: half of the thinnest wall, or its rim slips between two points
constexpr double kLeastApart = 0.05;   // mm
constexpr double kTipBare = 0.2;       // mm: depth of a point before its core makes contact
constexpr double kEndOfBall = 0.95;    // a radius that grows like this belongs to a ball or flat further up
constexpr double kPointed = 0.6;       // a radius that grows faster belongs to a point
constexpr double kDiscLike = 3;        // ratio of width to depth of the axis
constexpr double kLatticeStep = 0.05;  // mm
constexpr double kNoGradient = 0.8;    // of a distance, by central differences: at the medial axis
constexpr double kThinStep = 0.025;    // mm, of a lattice in thin parts
constexpr double kThinApart = 0.1;     // mm, between thin points of a fin
constexpr double kEdgeApart = 0.03;    // mm, of a point or an edge
constexpr double kEdge = 0.03;         // mm, radius
constexpr double kLostTip = -0.02;     // mm, radius: a mesh's table is too coarse for a thinner tip
constexpr std::size_t kMostOfLattice = 1024;
constexpr double kAroundCut = 1;    // mm
constexpr double kMostOfBox = 2e6;  // points of a lattice

class CoreMaker {
 public:
  CoreMaker(const ToolField& cut, const ToolField& body) : cut_(cut), body_(body) {
    box_ = cut.bounds();
    if (!body.isEmpty()) box_.add(body.bounds());
  }

  void addAxis() {
    const double low = box_.min[2], high = box_.max[2] - 0.2;
    double z = low + kPlaneStep;
    for (; z < high; z += kPlaneStep) {
      const double radius = radiusAt({0, 0, z});
      const double slope = (radiusAt({0, 0, z + kPlaneStep}) - radius) / kPlaneStep;
      const double held = z - low - kShareOut * radius;
      if (radius >= kThinnestCore && slope < kEndOfBall && (slope < kPointed || held >= kTipBare)) break;
    }
    while (z < high) {
      add({0, 0, z});
      z += std::clamp(0.5 * radiusAt({0, 0, z}), kLeastApart, kMostApart);
    }
  }

  // Adds points below the lowest point of the axis, where it is sharp.
  void addThinAxis() {
    const double low = box_.min[2], high = points.empty() ? box_.max[2] - 0.2 : static_cast<double>(points[0].place[2]);
    for (double z = low + kPlaneStep; z < high; z += kPlaneStep) {
      const double radius = radiusAt({0, 0, z});
      const double slope = (radiusAt({0, 0, z + kPlaneStep}) - radius) / kPlaneStep;
      if (radius <= 0 || radius >= kThinnestCore || slope > kPointed) continue;
      addThin({0, 0, z});
      z += kEdgeApart - kPlaneStep;
    }
  }

  // For a disc: a circle inside its rim, at a distance of half its thickness.
  void addRim() {
    const double widest = std::max(cut_.bounds().max[0], cut_.bounds().max[1]);
    const double height = 0.5 * (cut_.bounds().min[2] + cut_.bounds().max[2]);
    const double half = radiusAt({0.5 * widest, 0, height});
    if (half < 0.02 || widest < kDiscLike * half) return;
    const double radius = widest - half;
    const int count = static_cast<int>(std::ceil(2 * std::numbers::pi * radius / kMostApart));
    for (int n = 0; n < count; ++n) {
      const double angle = 2 * std::numbers::pi * n / count;
      add({radius * std::cos(angle), radius * std::sin(angle), height});
    }
  }

  // For a plate: the line inside its outline at which its middle reaches half its thickness.
  void addOutline(double half) {
    std::vector<Vec3d> rim;
    const int nx = static_cast<int>(std::ceil(box_.size()[0] / kLatticeStep));
    const int nz = static_cast<int>(std::ceil(box_.size()[2] / kLatticeStep));
    for (int x = 0; x <= nx; ++x)
      for (int z = 0; z <= nz; ++z) {
        const Vec3d p(box_.min[0] + kLatticeStep * x, 0, box_.min[2] + kLatticeStep * z);
        if (radiusAt(p) < 0.95 * half) continue;
        // At the rim: two steps further on the plate is thinner.
        bool is_rim = false;
        for (const auto& [dx, dz] : {std::pair(2, 0), std::pair(-2, 0), std::pair(0, 2), std::pair(0, -2)})
          is_rim |= radiusAt(p + kLatticeStep * Vec3d(dx, 0, dz)) < 0.95 * half;
        if (is_rim) rim.push_back(p);
      }
    addThinned(rim, rim.size());
  }

  // Around the cutting part only: a handpiece is too thick to sink.
  void addLattice() {
    std::vector<Vec3d> found;
    Box3 box = cut_.bounds();
    box.grow(kAroundCut);
    box = {box.min.cwiseMax(box_.min), box.max.cwiseMin(box_.max)};
    step_ = std::max(kLatticeStep, std::cbrt(box.size().prod() / kMostOfBox));
    const Eigen::Array3i count = (box.size() / step_).array().ceil().cast<int>();
    for (int x = 0; x <= count[0]; ++x)
      for (int y = 0; y <= count[1]; ++y)
        for (int z = 0; z <= count[2]; ++z) {
          const Vec3d p = box.min + step_ * Vec3d(x, y, z);
          const double radius = radiusAt(p);
          if (radius >= kThinnestCore && gradientAt(p, step_).norm() < kNoGradient) found.push_back(p);
          if (std::abs(radius) < kThinnestCore + step_) findThin(p);
        }
    // From the tip upwards: the leading points must not be omitted.
    std::stable_sort(found.begin(), found.end(), [](const Vec3d& a, const Vec3d& b) { return a[2] < b[2]; });
    addThinned(found, kMostOfLattice);
  }

  // Adds the points of the lattice, from the tip upwards.
  void addThinLattice() {
    std::stable_sort(thin_.begin(), thin_.end(), [](const Vec3d& a, const Vec3d& b) { return a[2] < b[2]; });
    const std::size_t before = points.size();
    for (const Vec3d& p : thin_) {
      if (points.size() == before + kMostOfLattice) break;
      const double apart = radiusAt(p) < kEdge ? kEdgeApart : kThinApart;
      const bool is_far = std::none_of(points.begin(), points.end(),
                                       [&](const CorePoint& q) { return (p - q.place.cast<double>()).norm() < apart; });
      if (is_far) addThin(p);
    }
  }

  std::vector<CorePoint> points;

 private:
  static constexpr double kShareOut = 0.4;

  double radiusAt(const Vec3d& p) const {
    const Vec3f at = p.cast<float>();
    const float tau = body_.isEmpty() ? cut_.distance(at) : std::min(cut_.distance(at), body_.distance(at));
    return -static_cast<double>(tau);
  }

  Vec3d gradientAt(const Vec3d& p, double by) const {
    Vec3d g;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3d step = by * Vec3d::Unit(axis);
      g[axis] = (radiusAt(p + step) - radiusAt(p - step)) / (2 * by);
    }
    return g;
  }

  // Finds thin points in the cell of the lattice around p.
  void findThin(const Vec3d& p) {
    const int count = static_cast<int>(std::ceil(step_ / kThinStep));
    const double by = step_ / count;
    for (int x = 0; x < count; ++x)
      for (int y = 0; y < count; ++y)
        for (int z = 0; z < count; ++z) {
          const Vec3d q = p + by * (Vec3d(x, y, z).array() - 0.5 * (count - 1)).matrix();
          const double radius = radiusAt(q);
          if (radius >= kLostTip && radius < kThinnestCore && gradientAt(q, by).norm() < kPointed) thin_.push_back(q);
        }
  }

  bool isOfCut(const Vec3f& at) const { return body_.isEmpty() || cut_.distance(at) <= body_.distance(at); }
  void addThin(const Vec3d& p) {
    const Vec3f at = p.cast<float>();
    points.push_back({at, static_cast<float>(std::max(radiusAt(p), 0.0)), isOfCut(at), true});
  }

  void add(const Vec3d& p) {
    const double radius = radiusAt(p);
    if (radius < 0.02) return;
    const Vec3f at = p.cast<float>();
    points.push_back({at, static_cast<float>(radius), isOfCut(at)});
  }

  // In their order, none nearer to a kept one than half of its ball, within bounds.
  void addThinned(const std::vector<Vec3d>& candidates, std::size_t most) {
    std::vector<Vec3d> kept;
    for (const Vec3d& p : candidates) {
      if (kept.size() == most) break;
      const double apart = std::clamp(0.5 * radiusAt(p), kLeastApart, kMostApart);
      const bool is_far =
          std::none_of(kept.begin(), kept.end(), [&](const Vec3d& q) { return (p - q).norm() < apart; });
      if (is_far) kept.push_back(p);
    }
    for (const Vec3d& p : kept) add(p);
  }

  const ToolField &cut_, &body_;
  Box3 box_;
  double step_ = kLatticeStep;  // mm
  std::vector<Vec3d> thin_;
};

}  // namespace

std::vector<CorePoint> makeToolCore(const ToolField& cut, const ToolField& body, ToolShape::Symmetry symmetry,
                                    double half_thickness) {
  if (cut.isEmpty()) return {};
  CoreMaker maker(cut, body);
  switch (symmetry) {
    case ToolShape::Symmetry::kRevolved:
      maker.addAxis();
      maker.addRim();
      maker.addThinAxis();
      break;
    case ToolShape::Symmetry::kPlate:
      maker.addOutline(half_thickness);
      break;
    case ToolShape::Symmetry::kNone:
      maker.addLattice();
      maker.addThinLattice();
      break;
  }
  return std::move(maker.points);
}

}  // namespace kerf
