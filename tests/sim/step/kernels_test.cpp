// The loops of the step against plain formulas, in every instruction set of this processor.
#include <gtest/gtest.h>

#include <hwy/targets.h>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>
#include <tuple>
#include <vector>

#include "sim/object/node_volumes.h"
#include "sim/object/shell_nodes.h"
#include "sim/step/contact_sums.h"
#include "sim/step/erode_brick.h"
#include "sim/step/node_kernels.h"

namespace kerf::internal {
namespace {

// Calls run() under each instruction set, the best one last.
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
  // A single set compares with nothing. Every x86-64 of the last ten years has several.
  EXPECT_GE(count, 2);
}

TEST(ErodeBrick, FollowsTheExponentialAtEveryRate) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(-1, 1);
  std::vector<float> x(512), y(512), z(512), tau(512), phi(512), rates(512);
  for (std::size_t n = 0; n < 512; ++n) {
    x[n] = u(random);
    y[n] = u(random);
    z[n] = u(random);
    tau[n] = 0.2f * u(random);
    phi[n] = 0.2f * u(random);
    rates[n] = std::pow(10.0f, 4 * u(random) - 2);  // 1e-6 to 100
  }
  ErodeBrickInput in;
  in.x = x.data();
  in.y = y.data();
  in.z = z.data();
  in.tau = tau.data();
  in.phi = phi.data();
  in.rates = rates.data();
  in.lever = {LeverForm::kOne, 0.1f, 5};
  in.cap = 0.15f;

  for (const LeverForm lever : {LeverForm::kRadius, LeverForm::kPivot, LeverForm::kOne}) {
    in.lever.form = lever;
    std::vector<float> first;
    onEveryTarget([&] {
      std::vector<float> out(512);
      const ErodeBrickResult result = erodeBrick(in, out.data());
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

TEST(ErodeBrick, LeavesAirAndTheLeastOverlapAlone) {
  std::vector<float> x(512), tau(512), phi(512);
  for (std::size_t n = 0; n < 512; ++n) {
    phi[n] = n % 3 == 0 ? 0.15f : -0.1f;  // air and tissue, in the same rows
    tau[n] = n % 3 == 0 ? -10.0f : 0.1f - (n % 2 ? 2e-6f : 0.5e-6f);
  }
  ErodeBrickInput in;
  in.x = in.y = in.z = x.data();
  in.tau = tau.data();
  in.phi = phi.data();
  in.rate = 2;
  in.cap = 0.15f;
  in.least_overlap = 1e-6f;

  for (const bool geometry_only : {false, true}) {
    in.geometry_only = geometry_only;
    onEveryTarget([&] {
      std::vector<float> out(512);
      const ErodeBrickResult result = erodeBrick(in, out.data());
      for (std::size_t n = 0; n < 512; ++n) ASSERT_EQ(out[n] != phi[n], n % 3 != 0 && n % 2 == 1) << n;
      EXPECT_NEAR(result.gap, -2e-6f, 1e-8f);
      EXPECT_EQ(result.least, -0.1f);
    });
  }
}

// Random nodes in their valid ranges.
TouchingNodes randomNodes(int count, std::mt19937& random) {
  std::uniform_real_distribution<float> u(0, 1);
  TouchingNodes nodes{};
  for (std::size_t n = 0; n < static_cast<std::size_t>(count); ++n) {
    nodes.overlap[n] = 0.02f * u(random);
    nodes.into_cut[n] = n % 3 == 0 ? 0 : 0.8f * nodes.overlap[n];
    nodes.slope[n] = 1.2f * u(random) - 0.2f;
    nodes.area[n] = 0.01f * u(random);
    Eigen::Vector3f normal(u(random) - 0.5f, u(random) - 0.5f, u(random) - 0.4f);
    normal.normalize();
    for (int c = 0; c < 3; ++c) {
      nodes.normal[c][n] = normal[c];
      nodes.from_tip[c][n] = 4 * u(random) - 2;
      nodes.in_tool[c][n] = 4 * u(random) - 2;
      nodes.foot[c][n] = nodes.in_tool[c][n] + 0.2f * u(random) - 0.1f;
    }
    nodes.tau_beyond[n] = 0.02f * u(random) - 0.06f;
    nodes.stiffness[n] = 200 * u(random);
    nodes.friction[n] = u(random);
    nodes.rate[n] = u(random);
  }
  nodes.count = (count + 7) / 8 * 8;
  return nodes;
}

TEST(NodeKernels, ValuesAreLookedUpByOffsetAndByMaterial) {
  std::vector<float> values(512);
  std::vector<std::uint16_t> offsets(64);
  std::vector<std::uint8_t> numbers(512);
  for (std::size_t n = 0; n < 512; ++n) {
    values[n] = static_cast<float>(n) + 0.25f;
    numbers[n] = static_cast<std::uint8_t>(n * 37);
  }
  for (std::size_t n = 0; n < 64; ++n) offsets[n] = static_cast<std::uint16_t>(511 - 8 * n);

  onEveryTarget([&] {
    std::vector<float> at(64), of(512);
    valuesAt(values.data(), offsets.data(), 64, at.data());
    valuesOf(values.data(), numbers.data(), 512, of.data());
    for (std::size_t n = 0; n < 64; ++n) ASSERT_EQ(at[n], values[offsets[n]]) << n;
    for (std::size_t n = 0; n < 512; ++n) ASSERT_EQ(of[n], values[numbers[n]]) << n;
  });
}

double plainLever(const Lever& lever, const TouchingNodes::Row (&place)[3], std::size_t n) {
  const double x = double(place[0][n]), y = double(place[1][n]), z = double(place[2][n]);
  switch (lever.form) {
    case LeverForm::kRadius:
      return std::max(std::hypot(x, y), double(lever.least_radius));
    case LeverForm::kPivot:
      return std::hypot(x, z - double(lever.pivot));
    case LeverForm::kOne:
      break;
  }
  return 1;
}

// A tool's contribution of one node, by the formulas of sim/step/contact.h in double.
void addPlain(const TouchingNodes& nodes, std::size_t n, const TouchingTool& tool,
              std::array<double, TouchingSums::kSums>& sums, double& deepest) {
  using S = TouchingSums;
  const auto at = [&sums](int entry) -> double& { return sums[static_cast<std::size_t>(entry)]; };
  const double facing = std::clamp(2.0 * static_cast<double>(nodes.slope[n]), 0.0, 1.0);
  const double arm = plainLever(tool.lever, nodes.in_tool, n);
  const double rate = double(nodes.rate[n]) * arm, part = -std::expm1(-rate);
  const double mean = double(nodes.overlap[n]) - double(nodes.into_cut[n]) * (1 - part / rate);
  const bool cuts = nodes.into_cut[n] > 0;
  const double next = double(nodes.overlap[n]) - double(nodes.into_cut[n]) * (1 - (1 - part) * part / rate);
  const double slope = -(double(nodes.into_cut[n]) + double(nodes.tau_beyond[n])) / double(tool.beyond);
  const double on_face = std::clamp((slope - 0.4) / 0.6, 0.5, 1.0), share = double(tool.cut_share);
  const double at_foot = plainLever(tool.lever, nodes.foot, n);
  const double arm_of_work = cuts ? arm + share * (at_foot - arm) : arm;
  const double area = double(nodes.area[n]), of_cut = area * (1 - share * (1 - on_face));
  const double counted = cuts ? double(tool.area_scale) * of_cut : area;
  const double stiff = double(nodes.stiffness[n]) * facing * counted;
  const double stiff_next = cuts ? stiff * part / rate : stiff;

  const Vec3d r(nodes.from_tip[0][n], nodes.from_tip[1][n], nodes.from_tip[2][n]);
  Vec3d normal(nodes.normal[0][n], nodes.normal[1][n], nodes.normal[2][n]);
  if (tool.is_blade && cuts) {
    const Vec3d flank(tool.across[0], tool.across[1], tool.across[2]);
    const double across = flank.dot(normal);
    const Vec3d along = normal - across * flank;
    const Vec3d face = (along.squaredNorm() * along + across * across * across * flank).normalized();
    normal = (normal + share * (face - normal)).normalized();
  }
  Eigen::Matrix<double, 6, 1> w;
  w << normal, r.cross(normal);
  int entry = S::kStiffness;
  for (int i = 0; i < 6; ++i) {
    at(S::kForce + i) += stiff * mean * w[i];
    at(S::kForceNext + i) += stiff * next * w[i];
    at(S::kLoadSlope + i) += stiff_next * w[i];
    for (int j = 0; j <= i; ++j) at(entry++) += stiff_next * w[i] * w[j];
  }

  const double load = stiff * mean, rubbing = double(nodes.friction[n]) * load;
  const double own = cuts || tool.body_spins ? 1000 * arm : 0;
  at(S::kNormalLoad) += load;
  at(S::kLoadNext) += stiff * next;
  if (cuts) at(S::kCuttingLoad) += load;
  at(S::kErodibleLoad) += stiff * double(nodes.into_cut[n]);
  const double bare = double(nodes.stiffness[n]) * counted * double(nodes.into_cut[n]);
  at(S::kCutByShell) += facing * of_cut * double(nodes.into_cut[n]) * part * arm_of_work / arm;
  at(S::kBareErodible) += bare;
  at(S::kBareLoad) += bare * part / rate;
  at(S::kBareDriveLoad) += double(nodes.friction[n]) * bare * part / rate * arm_of_work;
  if (cuts || tool.body_spins) at(S::kDriveLoad) += rubbing * arm_of_work;
  if (cuts || tool.body_spins) at(S::kPower) += rubbing * 1000 * arm_of_work;

  const Vec3d v = Vec3d(3, 0, 0) + Vec3d(0, 0, 0.7).cross(r);
  const double drag = rubbing / std::max({own, v.norm(), 0.5});
  at(S::kDrag) += drag;
  entry = S::kDragSecond;
  for (int i = 0; i < 3; ++i) {
    at(S::kDragMoment + i) += drag * r[i];
    for (int j = 0; j <= i; ++j) at(entry++) += drag * r[i] * r[j];
  }

  entry = S::kNormalDrag;
  for (int i = 0; tool.is_at_rest && i < 6; ++i)
    for (int j = 0; j <= i; ++j) at(entry++) += drag * w[i] * w[j];

  if (stiff > 0) {
    at(S::kArea) += double(nodes.area[n]);
    at(S::kCount) += 1;
    deepest = std::max(deepest, double(nodes.overlap[n]));
  }
}

TEST(TurnTouching, IsItsFormulasAndLeavesWhatItIsNotAskedForAlone) {
  std::mt19937 random(6);
  std::uniform_real_distribution<float> u(-1, 1);
  const Eigen::Matrix3f turn = Eigen::Quaternionf(0.8f, 0.3f, -0.2f, 0.4f).normalized().toRotationMatrix();
  float to_tool[3][3];
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) to_tool[row][column] = turn(row, column);

  for (const int count : {1, 8, 13, 64})
    for (const float beyond : {0.0f, 0.05f}) {
      TouchingNodes given = randomNodes(count, random);
      TouchingNodes::Row phi{};
      for (std::size_t n = 0; n < static_cast<std::size_t>(count); ++n) {
        phi[n] = 0.1f * u(random);
        for (auto& axis : given.normal) axis[n] *= given.area[n];
      }

      std::vector<float> first;
      onEveryTarget([&] {
        TouchingNodes nodes = given;
        TouchingPlaces places{};
        turnTouching(phi, to_tool, 0.02f, beyond, nodes, places);

        std::vector<float> bits;
        for (std::size_t n = 0; n < static_cast<std::size_t>(given.count); ++n) {
          const auto at = [n](const TouchingNodes::Row(&row)[3]) { return Vec3f(row[0][n], row[1][n], row[2][n]); };
          const Vec3f normal = at(nodes.normal), place = at(given.in_tool), outward = turn * normal;
          const bool is_padding = n >= static_cast<std::size_t>(count);
          EXPECT_NEAR(normal.norm(), is_padding ? 0 : 1, 1e-5);
          EXPECT_LT((normal * given.area[n] - at(given.normal)).norm(), 1e-7f);
          EXPECT_LT((at(places.inwards) - (place - 0.02f * outward)).norm(), 1e-6f);
          const Vec3f foot = place - phi[n] * outward;
          if (beyond > 0) {
            EXPECT_LT((at(nodes.foot) - foot).norm(), 1e-6f);
            EXPECT_LT((at(places.beyond) - (foot + beyond * outward)).norm(), 1e-6f);
          } else {
            EXPECT_EQ(at(nodes.foot), at(given.foot));
            EXPECT_EQ(at(places.beyond), Vec3f(0, 0, 0));
          }
          for (const Vec3f& found : {normal, at(places.inwards), at(nodes.foot), at(places.beyond)})
            bits.insert(bits.end(), found.data(), found.data() + 3);
        }
        if (first.empty()) first = bits;
        EXPECT_EQ(bits, first);
      });
    }
}

TEST(SumTouching, IsTheSumOfItsFormulas) {
  std::mt19937 random(5);
  for (const int count : {1, 7, 8, 50, 64}) {
    const TouchingNodes nodes = randomNodes(count, random);
    TouchingTool tool;
    tool.speed = 1000;
    tool.still_speed = 0.5f;
    tool.area_scale = 1.25f;
    tool.velocity[0] = 3;
    tool.angular[2] = 0.7f;
    tool.beyond = 0.05f;
    const Lever radius{LeverForm::kRadius, 0.3f, 0}, pivot{LeverForm::kPivot, 0, 4}, one{LeverForm::kOne, 0, 0};
    using Case = std::tuple<bool, float, Lever>;
    for (const auto& [spins, share, lever] :
         {Case(true, 0.0f, radius), Case(true, 1.0f, radius), Case(false, 0.6f, pivot), Case(false, 1.0f, one)}) {
      tool.lever = lever;
      tool.body_spins = spins;
      tool.is_blade = !spins;
      tool.across[1] = 0.6f;
      tool.across[2] = -0.8f;
      tool.cut_share = share;
      tool.is_at_rest = share < 1;
      std::array<double, TouchingSums::kSums> expected{};
      double deepest = 0;
      for (std::size_t n = 0; n < static_cast<std::size_t>(count); ++n) addPlain(nodes, n, tool, expected, deepest);

      std::vector<double> first;
      onEveryTarget([&] {
        TouchingSums sums;
        sumTouching(nodes, tool, sums);
        for (std::size_t s = 0; s < expected.size(); ++s)
          EXPECT_NEAR(sums.value[s], expected[s], 2e-6 * (1 + 10 * std::abs(expected[s]))) << s;
        EXPECT_NEAR(sums.deepest, deepest, 1e-9);
        const std::vector<double> bits(sums.value.begin(), sums.value.end());
        if (first.empty()) first = bits;
        EXPECT_EQ(bits, first);
      });
    }
  }
}

// The formula of a shell's node, evaluated one by one.
int plainShell(const BrickNeighborhood& bricks, const std::uint8_t* materials, float e, float scale, ShellChunk* out) {
  int count = 0;
  for (int n = 0; n < kBrickNodes; ++n) {
    if (!(std::abs(bricks.self[n]) < e)) continue;
    const float u = bricks.self[n] / e, fade = 1 - u * u, weight = scale * fade * fade;
    ShellChunk& chunk = out[count / ShellChunk::kNodes];
    const auto at = static_cast<std::size_t>(count++ % ShellChunk::kNodes);
    float* const area[3] = {&chunk.x[at], &chunk.y[at], &chunk.z[at]};
    for (int axis = 0, stride = 64; axis < 3; ++axis, stride /= 8) {
      const int place = n / stride & 7;
      const float below = place > 0 ? bricks.self[n - stride] : bricks.face[2 * axis][n + 7 * stride];
      const float above = place < 7 ? bricks.self[n + stride] : bricks.face[2 * axis + 1][n - 7 * stride];
      *area[axis] = weight * (above - below);
    }
    chunk.phi[at] = bricks.self[n];
    chunk.offset[at] = static_cast<std::uint16_t>(n);
    chunk.material[at] = materials[n];
  }
  return count;
}

TEST(ShellNodes, AreThoseOfTheFormulaToTheBit) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> u(-1, 1);
  // From none to all of the nodes: 0, 1, a chunk, a chunk and one, and larger numbers.
  for (const int wanted : {0, 1, 8, 64, 65, 200, 512}) {
    std::vector<std::vector<float>> bricks(7, std::vector<float>(512));
    for (auto& brick : bricks)
      for (float& value : brick) value = 0.15f * u(random);
    std::vector<std::uint8_t> materials(512);
    for (auto& m : materials) m = static_cast<std::uint8_t>(random());
    for (std::size_t n = 0; n < 512; ++n) {
      // A stride coprime to 512 spreads the nodes over all rows and borders.
      const std::size_t at = n * 77 % 512;
      bricks[0][at] = static_cast<int>(n) < wanted ? 0.0749f * u(random) : (n % 2 ? 0.075f : -0.2f);
    }

    BrickNeighborhood around{bricks[0].data(), {}};
    for (std::size_t f = 0; f < 6; ++f) around.face[f] = bricks[f + 1].data();
    std::vector<ShellChunk> expected(kShellChunks), out(kShellChunks);
    const int count = plainShell(around, materials.data(), 0.075f, 0.03f, expected.data());
    ASSERT_EQ(count, wanted);

    onEveryTarget([&] {
      std::memset(static_cast<void*>(out.data()), 0xff, out.size() * sizeof(ShellChunk));
      ASSERT_EQ(shellNodes(around, materials.data(), 0.075f, 0.03f, out.data()), count);
      for (std::size_t n = 0; n < static_cast<std::size_t>((count + 63) / 64 * 64); ++n) {
        const ShellChunk &a = out[n / 64], &b = expected[n / 64];
        const bool is_node = static_cast<int>(n) < count;
        ASSERT_EQ(a.x[n % 64], is_node ? b.x[n % 64] : 0) << n;
        ASSERT_EQ(a.y[n % 64], is_node ? b.y[n % 64] : 0) << n;
        ASSERT_EQ(a.z[n % 64], is_node ? b.z[n % 64] : 0) << n;
        ASSERT_EQ(a.phi[n % 64], is_node ? b.phi[n % 64] : a.phi[0]) << n;
        ASSERT_EQ(a.offset[n % 64], is_node ? b.offset[n % 64] : a.offset[0]) << n;
        ASSERT_EQ(a.material[n % 64], is_node ? b.material[n % 64] : 0) << n;
      }
    });
  }
}

TEST(RowsBelow, AreThoseWithAValueBelowTheLimit) {
  std::mt19937 random(19);
  std::vector<float> values(512, 0.15f);
  std::uint64_t expected = 0;
  for (const int row : {0, 1, 7, 30, 31, 32, 63}) {
    values[static_cast<std::size_t>(8 * row) + random() % 8] = 0.149f;
    expected |= std::uint64_t{1} << row;
  }
  onEveryTarget([&] {
    EXPECT_EQ(rowsBelow(values.data(), 0.15f), expected);
    EXPECT_EQ(rowsBelow(values.data(), 0.1f), 0u);
    EXPECT_EQ(rowsBelow(values.data(), 0.2f), ~std::uint64_t{0});
  });
}

TEST(TouchingNodes, AreThoseInsideTheToolAndClearanceIsToTheNearest) {
  std::mt19937 random(17);
  std::uniform_real_distribution<float> u(-1, 1);
  for (const int count : {1, 7, 8, 33, 64})
    for (const bool has_body : {false, true}) {
      std::vector<float> cut(64), body(64), phi(64);
      for (std::size_t n = 0; n < 64; ++n) {
        cut[n] = 0.8f + u(random);
        body[n] = 0.9f + u(random);
        phi[n] = u(random);
      }
      for (const float least_overlap : {0.0f, 0.4f}) {
        std::uint64_t expected = 0;
        float least = 0.5f;
        for (std::size_t n = 0; n < static_cast<std::size_t>(count); ++n) {
          const float gap = (has_body ? std::min(cut[n], body[n]) : cut[n]) + phi[n];
          expected |= std::uint64_t{gap < -least_overlap} << n;
          least = std::min(least, gap);
        }
        onEveryTarget([&] {
          float clearance = 0.5f;
          EXPECT_EQ(
              touchingNodes(cut.data(), has_body ? body.data() : nullptr, phi.data(), count, least_overlap, clearance),
              expected);
          EXPECT_EQ(clearance, least);
          EXPECT_EQ(largestOf(cut.data(), 64), *std::max_element(cut.begin(), cut.end()));
        });
      }
    }
}

TEST(DifferingNodes, AreThoseWhoseValuesDiffer) {
  std::mt19937 random(11);
  std::vector<float> a(512, 0.1f);
  for (const int changes : {0, 1, 3, 40, 512}) {
    std::vector<float> b = a;
    for (int n = 0; n < changes; ++n) b[changes == 512 ? static_cast<std::size_t>(n) : random() % 512] = 0.2f;
    onEveryTarget([&] {
      const NodeBits bits = differingNodes(a.data(), b.data());
      for (std::size_t n = 0; n < 512; ++n) ASSERT_EQ(bits[n / 64] >> n % 64 & 1, a[n] != b[n]) << n;
    });
  }
}

TEST(NodeVolumes, GoByTheNearestCrossing) {
  std::mt19937 random(13);
  std::uniform_real_distribution<float> u(-0.1f, 0.1f);
  constexpr std::size_t kCount = 48;
  std::array<std::vector<float>, 7> values;  // of the nodes, and of their neighbours
  for (auto& of : values)
    for (std::size_t n = 0; n < kCount; ++n) of.push_back(u(random));
  const float* const beside[6] = {values[1].data(), values[2].data(), values[3].data(),
                                  values[4].data(), values[5].data(), values[6].data()};
  onEveryTarget([&] {
    std::vector<std::int32_t> parts(kCount, -7);
    nodeVolumes(values[0].data(), beside, kCount, 0.06f, parts.data());
    for (std::size_t n = 0; n < kCount; ++n) {
      const double v = values[0][n];
      double least = 0.5;
      for (std::size_t side = 1; side <= 6; ++side) {
        const double w = values[side][n], size = std::min(std::abs(v), 0.06);
        if ((v < 0) != (w < 0)) least = std::min(least, size / (size + std::min(std::abs(w), 0.06)));
      }
      ASSERT_NEAR(parts[n], kCellParts * (v < 0 ? 0.5 + least : 0.5 - least), 0.51) << n;
    }
  });
}

}  // namespace
}  // namespace kerf::internal
