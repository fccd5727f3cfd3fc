#include "sim/step/one_sided_loads.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace kerf {

void OneSidedLoads::solve(const Matrix6d& a, const Vector6d& b, std::span<const Vector6d> directions, const Row& least,
                          const Row& softness, double settled) noexcept {
  constexpr int kSweeps = 60;

  // Effect of a unit of each load: answer_i = A^-1 u_i.
  const Eigen::LDLT<Matrix6d> inverse(a);
  motion = inverse.solve(b);
  Directions answer;
  Row flexibility;
  for (std::size_t n = 0; n < directions.size(); ++n) {
    answer[n] = inverse.solve(directions[n]);
    flexibility[n] = directions[n].dot(answer[n]);
    motion += load[n] * answer[n];
  }

  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double change = 0, largest = 0;
    for (std::size_t n = 0; n < directions.size(); ++n) {
      const double before = load[n];
      load[n] = std::max(
          0.0, before + (least[n] - directions[n].dot(motion) - softness[n] * before) / (flexibility[n] + softness[n]));
      motion += (load[n] - before) * answer[n];
      change = std::max(change, std::abs(load[n] - before));
      largest = std::max(largest, load[n]);
    }
    if (change <= settled * largest) break;
  }

  if (!motion.allFinite()) {
    motion.setZero();
    load.fill(0);
  }
}

}  // namespace kerf
