// Loads that push but never pull: they hold the tool out of the tissue.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

namespace kerf {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// y minimises y^T A y / 2 - b^T y over u_i^T y >= least_i - softness_i load_i; load_i >= 0 are its multipliers, A y =
/// b + sum u_i load_i. By projected Gauss-Seidel (after Moreau, in the form of Catto, GDC 2005), a bounded number of
/// sweeps, starting from the current loads.
struct OneSidedLoads {
  static constexpr std::size_t kMost = 64;
  using Row = std::array<double, kMost>;
  using Directions = std::array<Vector6d, kMost>;

  Row load{};
  Vector6d motion = Vector6d::Zero();  ///< y

  /// @param a  symmetric, positive definite.   @param softness  >= 0; bounds the loads of walls on both sides.
  /// @param settled  fraction of the largest load: a sweep with a smaller change is the last.
  /// If not finite: no motion, no load. @pre at most kMost directions. @rt @cost 1 us a direction at most
  void solve(const Matrix6d& a, const Vector6d& b, std::span<const Vector6d> directions, const Row& least,
             const Row& softness, double settled = 1e-9) noexcept;
};

}  // namespace kerf
