// The loops of the step against plain formulas, in every instruction set this processor has.
#include <gtest/gtest.h>

#include <hwy/targets.h>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "sim/internal/relax_brick.h"
#include "sim/internal/sum_touching.h"

namespace kerf::internal {
namespace {

// Calls run() under each instruction set; the last call is under the best one.
void onEveryTarget(const std::function<void()>& run) {
  const auto all = static_cast<std::uint64_t>(hwy::SupportedTargets());
  int count = 0;
  for (std::uint64_t bit = std::uint64_t{1} << 62; bit != 0; bit >>= 1) {
    if (!(all & bit)) continue;
    hwy::SetSupportedTargetsForTest(static_cast<std::int64_t>(bit));
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    run();
    ++count;
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  // One alone would compare with nothing: every x86-64 of the last ten years has several.
  EXPECT_GE(count, 2);
}

TEST(RelaxBrick, FollowsTheExponentialAtEveryRate) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(-1, 1);
  std::vector<float> x(512), y(512), z(512), tau(512), phi(512), rates(512);
  for (std::size_t n = 0; n < 512; ++n) {
    x[n] = u(random), y[n] = u(random), z[n] = u(random), tau[n] = 0.2f * u(random), phi[n] = 0.2f * u(random);
    rates[n] = std::pow(10.0f, 4 * u(random) - 2);  // 1e-6 to 100
  }
  RelaxInput in;
  in.x = x.data(), in.y = y.data(), in.z = z.data(), in.tau = tau.data(), in.phi = phi.data(), in.rates = rates.data();
  in.least_radius = 0.1f, in.pivot = 5, in.cap = 0.15f;
  for (const LeverForm lever : {LeverForm::kRadius, LeverForm::kPivot, LeverForm::kOne}) {
    in.lever = lever;
    std::vector<float> first;
    onEveryTarget([&] {
      std::vector<float> out(512);
      const RelaxResult result = relaxBrick(in, out.data());
      float least = 1e9f;
      for (std::size_t n = 0; n < 512; ++n) {
        const double p = phi[n], d = std::max(0.0, -static_cast<double>(tau[n]) - p);
        const double arm = lever == LeverForm::kRadius
                               ? std::max(std::hypot(static_cast<double>(x[n]), static_cast<double>(y[n])), 0.1)
                           : lever == LeverForm::kPivot ? std::hypot(static_cast<double>(x[n]), z[n] - 5.0)
                                                        : 1.0;
        double expected = p + d * -std::expm1(-static_cast<double>(rates[n]) * arm);
        if (phi[n] < in.cap) expected = std::min(expected, static_cast<double>(in.cap));
        if (phi[n] >= in.cap) expected = p;
        ASSERT_NEAR(out[n], expected, 1e-7 + 4e-7 * d) << rates[n];
        least = std::min(least, out[n]);
      }
      EXPECT_EQ(result.least, least);
      EXPECT_LT(result.gap, 0);
      if (first.empty()) first = out;
      EXPECT_EQ(out, first);
    });
  }
}

TEST(SumTouching, IsTheSumOfItsFormulas) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> u(0, 1);
  for (const int count : {1, 7, 8, 50, 64}) {
    TouchingNodes nodes{};
    for (std::size_t n = 0; n < static_cast<std::size_t>(count); ++n) {
      nodes.overlap[n] = 0.02f * u(random), nodes.into_cut[n] = n % 3 == 0 ? 0 : 0.8f * nodes.overlap[n];
      nodes.slope[n] = 1.2f * u(random) - 0.2f, nodes.area[n] = 0.01f * u(random);
      Eigen::Vector3f normal(u(random) - 0.5f, u(random) - 0.5f, u(random) - 0.4f);
      normal.normalize();
      for (int c = 0; c < 3; ++c) {
        nodes.normal[c][n] = normal[c];
        nodes.from_tip[c][n] = 4 * u(random) - 2, nodes.in_tool[c][n] = 4 * u(random) - 2;
      }
      nodes.stiffness[n] = 200 * u(random), nodes.friction[n] = u(random), nodes.rate[n] = u(random);
    }
    nodes.count = (count + 7) / 8 * 8;
    TouchingTool tool;
    tool.lever = LeverForm::kRadius, tool.least_radius = 0.3f, tool.speed = 1000, tool.still_speed = 0.5f;
    tool.velocity[0] = 3, tool.angular[2] = 0.7f;
    for (const bool spins : {true, false}) {
      tool.body_spins = spins;
      using S = TouchingSums;
      std::array<double, S::kSums> expected{};
      double deepest = 0;
      for (std::size_t n = 0; n < static_cast<std::size_t>(count); ++n) {
        const double facing = std::clamp(2.0 * static_cast<double>(nodes.slope[n]), 0.0, 1.0);
        const double arm = std::max(std::hypot(double(nodes.in_tool[0][n]), double(nodes.in_tool[1][n])), 0.3);
        const double rate = double(nodes.rate[n]) * arm, part = -std::expm1(-rate);
        const double mean = double(nodes.overlap[n]) - double(nodes.into_cut[n]) * (1 - part / rate);
        const double after = double(nodes.overlap[n]) - double(nodes.into_cut[n]) * part;
        const double stiff = double(nodes.stiffness[n]) * facing * double(nodes.area[n]);
        const Vec3d r(nodes.from_tip[0][n], nodes.from_tip[1][n], nodes.from_tip[2][n]);
        const Vec3d normal(nodes.normal[0][n], nodes.normal[1][n], nodes.normal[2][n]);
        Eigen::Matrix<double, 6, 1> w;
        w << normal, r.cross(normal);
        int entry = S::kStiffness;
        for (int i = 0; i < 6; ++i) {
          expected[static_cast<std::size_t>(S::kForce + i)] += stiff * mean * w[i];
          expected[static_cast<std::size_t>(S::kForceAfter + i)] += stiff * after * w[i];
          for (int j = 0; j <= i; ++j) expected[static_cast<std::size_t>(entry++)] += stiff * w[i] * w[j];
        }
        const double load = stiff * mean, rubbing = double(nodes.friction[n]) * load;
        const bool cuts = nodes.into_cut[n] > 0;
        const double own = cuts || spins ? 1000 * arm : 0;
        expected[S::kNormalLoad] += load;
        if (cuts) expected[S::kCuttingLoad] += load;
        expected[S::kErodibleLoad] += stiff * double(nodes.into_cut[n]);
        if (cuts || spins) expected[S::kDriveLoad] += rubbing * arm;
        expected[S::kPower] += rubbing * own;
        const Vec3d v = Vec3d(3, 0, 0) + Vec3d(0, 0, 0.7).cross(r);
        const double drag = rubbing / std::max({own, v.norm(), 0.5});
        expected[S::kDrag] += drag;
        entry = S::kDragSecond;
        for (int i = 0; i < 3; ++i) {
          expected[static_cast<std::size_t>(S::kDragMoment + i)] += drag * r[i];
          for (int j = 0; j <= i; ++j) expected[static_cast<std::size_t>(entry++)] += drag * r[i] * r[j];
        }
        if (stiff > 0) {
          expected[S::kArea] += double(nodes.area[n]), expected[S::kCount] += 1;
          deepest = std::max(deepest, double(nodes.overlap[n]));
        }
      }
      std::vector<double> first;
      onEveryTarget([&] {
        TouchingSums sums;
        sumTouching(nodes, tool, sums);
        for (std::size_t s = 0; s < S::kSums; ++s)
          EXPECT_NEAR(sums.value[s], expected[s], 2e-6 * (1 + 10 * std::abs(expected[s]))) << s;
        EXPECT_NEAR(sums.deepest, deepest, 1e-9);
        const std::vector<double> bits(sums.value.begin(), sums.value.end());
        if (first.empty()) first = bits;
        EXPECT_EQ(bits, first);
      });
    }
  }
}

}  // namespace
}  // namespace kerf::internal
