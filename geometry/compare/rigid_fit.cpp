#include "geometry/compare/rigid_fit.h"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace kerf {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

struct Points {
  std::vector<Vec3d> at, normal;
};

// Points at equal steps of the area, each at a place of its triangle from the R2 sequence (Roberts 2018).
Points spreadPoints(const Mesh& mesh, const MeshDistance& distance, std::size_t count) {
  constexpr double kR2[] = {0.7548776662466927, 0.5698402909980532};
  const double step = surfaceArea(mesh) / static_cast<double>(count);
  Points out;
  double area = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    area += 0.5 * doubleAreaVector(mesh, t).norm();
    while (out.at.size() < count && (static_cast<double>(out.at.size()) + 0.5) * step < area) {
      const auto n = static_cast<double>(out.at.size() + 1);
      double u = n * kR2[0] - std::floor(n * kR2[0]), v = n * kR2[1] - std::floor(n * kR2[1]);
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      const Vec3d a = mesh.corner(t, 0);
      out.at.push_back(a + u * (mesh.corner(t, 1) - a) + v * (mesh.corner(t, 2) - a));
      out.normal.push_back(distance.normal(t));
    }
  }
  return out;
}

struct Moments {
  Vec3d middle;
  Eigen::Matrix3d axes;  // columns, right-handed, of ascending variance
};

Moments momentsOf(const std::vector<Vec3d>& points) {
  Moments out{Vec3d::Zero(), Eigen::Matrix3d::Identity()};
  for (const Vec3d& p : points) out.middle += p;
  out.middle /= static_cast<double>(points.size());
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Vec3d& p : points) sum += (p - out.middle) * (p - out.middle).transpose();
  out.axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sum).eigenvectors();
  if (out.axes.determinant() < 0) out.axes.col(2) *= -1;
  return out;
}

// The 24 rotations of a cube.
std::vector<Eigen::Matrix3d> axisOrders() {
  std::vector<Eigen::Matrix3d> out;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      for (int signs = 0; x != y && signs < 4; ++signs) {
        Eigen::Matrix3d m;
        m.col(0) = (signs & 1 ? -1 : 1) * Vec3d::Unit(x);
        m.col(1) = (signs & 2 ? -1 : 1) * Vec3d::Unit(y);
        m.col(2) = m.col(0).cross(m.col(1));
        out.push_back(m);
      }
  return out;
}

class Fitting {
 public:
  Fitting(const Points& points, const MeshDistance& to, double size) : points_(points), to_(to), size_(size) {}

  struct Result {
    Rigid3 pose;
    double cost = std::numeric_limits<double>::infinity();  // mm^2, each pair limited
    double median = 0, rms = 0;
    std::size_t kept = 0;
    int free_motions = 0;
  };

  enum class Keep {
    kRobust,   // within three standard deviations, estimated from the median
    kNearHalf  // the nearer half: finds the common surface where changed parts pull the robust fit aside
  };

  // Empty if no pairs are left.
  // @param still  a step shorter than this ends it, mm.
  std::optional<Result> refine(const Rigid3& start, int iterations, Keep keep, double still) {
    Result out{.pose = start};
    for (int n = 0;; ++n) {
      if (!pair(out, keep)) return {};
      if (n == iterations) return out;
      const Rigid3 step = stepOf(out);
      out.pose = step * out.pose;
      const double turn = Eigen::AngleAxisd(step.rotation).angle() * size_;
      const double shift = (step * middle_ - middle_).norm();
      if (turn + shift < still) return pair(out, keep) ? std::optional(out) : std::nullopt;
    }
  }

 private:
  // Finds the nearest points in this pose and chooses the pairs to keep.
  bool pair(Result& out, Keep keep) {
    const std::size_t count = points_.at.size();
    moved_.resize(count);
    nearest_.resize(count);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t n) {
      moved_[n] = out.pose * points_.at[n];
      nearest_[n] = to_.nearest(moved_[n]);
    });
    std::vector<double> distances;
    is_kept_.assign(count, 0);
    const double most = 0.05 * size_;
    out.cost = 0;
    for (std::size_t n = 0; n < count; ++n) {
      const Vec3d normal = out.pose.rotation * points_.normal[n];
      const bool is_pair = !nearest_[n].is_on_boundary && normal.dot(to_.normal(nearest_[n].triangle)) > 0;
      const double d = is_pair ? std::min(nearest_[n].distance_mm, most) : most;
      out.cost += d * d;
      if (!is_pair) continue;
      is_kept_[n] = 1;
      distances.push_back(nearest_[n].distance_mm);
    }
    out.cost /= static_cast<double>(count);
    constexpr std::size_t kLeast = 20;
    if (distances.size() < kLeast) return false;

    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    out.median = *middle;
    constexpr double kThreeSigma = 3 * 1.4826, kRounding = 1e-9;
    const double limit = (keep == Keep::kRobust ? kThreeSigma : 1) * out.median + kRounding;
    out.kept = 0;
    out.rms = 0;
    middle_ = Vec3d::Zero();
    for (std::size_t n = 0; n < count; ++n) {
      is_kept_[n] = is_kept_[n] && nearest_[n].distance_mm <= limit;
      if (!is_kept_[n]) continue;
      ++out.kept;
      out.rms += nearest_[n].distance_mm * nearest_[n].distance_mm;
      middle_ += moved_[n];
    }
    middle_ /= static_cast<double>(out.kept);
    out.rms = std::sqrt(out.rms / static_cast<double>(out.kept));
    return true;
  }

  // Least squares over (turn times size, shift), about the middle of the kept points.
  Rigid3 stepOf(Result& out) const {
    Matrix6 a = Matrix6::Zero();
    Vector6 b = Vector6::Zero();
    for (std::size_t n = 0; n < moved_.size(); ++n) {
      if (!is_kept_[n]) continue;
      const Vec3d& normal = to_.normal(nearest_[n].triangle);
      Vector6 row;
      row << (moved_[n] - middle_).cross(normal) / size_, normal;
      a += row * row.transpose();
      b += row * normal.dot(nearest_[n].point - moved_[n]);
    }
    const Eigen::SelfAdjointEigenSolver<Matrix6> solver(a);
    const double least = 1e-7 * solver.eigenvalues().maxCoeff();
    Vector6 x = Vector6::Zero();
    out.free_motions = 0;
    for (int k = 0; k < 6; ++k) {
      if (solver.eigenvalues()[k] > least)
        x += solver.eigenvectors().col(k) * (solver.eigenvectors().col(k).dot(b) / solver.eigenvalues()[k]);
      else
        ++out.free_motions;
    }
    Vec3d turn = x.head<3>() / size_;
    constexpr double kMostTurn = 0.5;  // rad: beyond, the linear step means nothing
    if (turn.norm() > kMostTurn) turn *= kMostTurn / turn.norm();
    Rigid3 step;
    if (turn.norm() > 0) step.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
    step.translation = middle_ + x.tail<3>() - step.rotation * middle_;
    return step;
  }

  const Points& points_;
  const MeshDistance& to_;
  double size_;  // mm
  std::vector<Vec3d> moved_;
  std::vector<NearestOnMesh> nearest_;
  std::vector<char> is_kept_;
  Vec3d middle_ = Vec3d::Zero();
};

}  // namespace

Expected<RigidFit> fitRigidly(const Mesh& first, const MeshDistance& first_distance, const Mesh& second,
                              const MeshDistance& second_distance, const RigidFitOptions& options,
                              const Progress& progress) {
  const bool is_second_smaller = surfaceArea(second) <= surfaceArea(first);
  const Mesh &from = is_second_smaller ? second : first, &to = is_second_smaller ? first : second;
  const MeshDistance &from_distance = is_second_smaller ? second_distance : first_distance,
                     &to_distance = is_second_smaller ? first_distance : second_distance;
  const double size = 0.5 * to_distance.bounds().size().norm();
  const Error no_pairs{.code = Error::Code::kGeometry,
                       .found = "no pairs of points to fit",
                       .expected = "two meshes of the same object, both turned outwards",
                       .hint = "kerf check both"};

  constexpr std::size_t kCoarse = 600;
  constexpr int kCoarseIterations = 25, kIterations = 60;
  using Keep = Fitting::Keep;
  const double roughly = 1e-4 * size;
  constexpr double kStill = 1e-9;  // mm
  const Points coarse = spreadPoints(from, from_distance, kCoarse);
  const Points fine = spreadPoints(from, from_distance, options.samples);
  Fitting start(coarse, to_distance, size);

  std::optional<Fitting::Result> best = start.refine({}, kCoarseIterations, Keep::kRobust, roughly);
  RigidFit out;
  if (options.from_anywhere) {
    const Moments a = momentsOf(fine.at), b = momentsOf(spreadPoints(to, to_distance, options.samples).at);
    const std::vector<Eigen::Matrix3d> orders = axisOrders();
    for (std::size_t n = 0; n < orders.size(); ++n) {
      if (!report(progress, 0.8 * static_cast<double>(n) / static_cast<double>(orders.size()), "aligning"))
        return cancelled();
      const Eigen::Quaterniond turn(b.axes * orders[n] * a.axes.transpose());
      const auto found =
          start.refine({turn.normalized(), b.middle - turn * a.middle}, kCoarseIterations, Keep::kRobust, roughly);
      // Equally good ones: the first, so that a symmetric object stays as it lies.
      constexpr double kClearly = 0.9, kRounding = 1e-6;
      if (found && (!best || found->cost < kClearly * best->cost - kRounding)) {
        best = found;
        out.from_axes = true;
      }
    }
  }
  if (!best) return fail(no_pairs);
  if (!report(progress, 0.8, "aligning")) return cancelled();

  Fitting whole(fine, to_distance, size);
  const auto before = whole.refine({}, 0, Keep::kRobust, kStill);
  auto fitted = whole.refine(best->pose, kIterations, Keep::kRobust, roughly);
  if (fitted) fitted = whole.refine(fitted->pose, kIterations, Keep::kNearHalf, kStill);
  if (fitted) fitted = whole.refine(fitted->pose, kIterations, Keep::kRobust, kStill);
  if (!fitted) return fail(no_pairs);
  out.T_first_second = is_second_smaller ? fitted->pose : fitted->pose.inverse();
  out.before_mm = before ? before->median : std::numeric_limits<double>::infinity();
  out.median_mm = fitted->median;
  out.rms_mm = fitted->rms;
  out.samples = fine.at.size();
  out.kept = fitted->kept;
  out.free_motions = fitted->free_motions;
  return out;
}

}  // namespace kerf
