#include "geometry/tool/tool_field.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>
#include <cmath>
#include <random>

#include "geometry/tool/tool_file.h"

namespace kerf::tool_field_test {
namespace {

struct Points {
  std::vector<float> x, y, z;

  void add(const Vec3f& p) {
    x.push_back(p[0]);
    y.push_back(p[1]);
    z.push_back(p[2]);
  }
};
Points pointsAround(const Box3& box, double margin, int n, unsigned seed) {
  std::mt19937 random(seed);
  Points p;
  for (int i = 0; i < n; ++i) {
    const auto along = [&](int c) {
      return static_cast<float>(
          std::uniform_real_distribution<double>(box.min[c] - margin, box.max[c] + margin)(random));
    };
    p.x.push_back(along(0));
    p.y.push_back(along(1));
    p.z.push_back(along(2));
  }
  return p;
}

// Every tool of the rack: the table is the distance within the margin, and a lower bound above the margin beyond it.
TEST(ToolField, TablesHoldTheDistanceOfEveryToolOfTheRack) {
  int tools = 0;
  for (const ToolListing& listing : listTools(defaultToolFolders())) {
    ASSERT_TRUE(listing.tool) << listing.file;
    const Tool& tool = *listing.tool;
    for (const ToolShape* shape : {tool.cut.get(), tool.body.get()}) {
      if (!shape) continue;
      const ToolField field(*shape);
      const double spacing = tool.kind == ToolKind::kMesh ? 0.05 : 0.02;
      const Points p = pointsAround(shape->bounds(), 0.8, 2048, 7);
      std::vector<float> d(p.x.size());
      field.distances(p.x.data(), p.y.data(), p.z.data(), d.data(), static_cast<int>(d.size()));
      for (std::size_t n = 0; n < d.size(); ++n) {
        const Vec3f at(p.x[n], p.y[n], p.z[n]);
        const double exact = shape->distance(at.cast<double>());
        const double got = static_cast<double>(d[n]);
        // Interpolation error is below half a spacing at the sharpest corner.
        if (exact < 0.45) {
          ASSERT_NEAR(got, exact, 0.5 * spacing) << tool.id << " at " << at.transpose();
        } else {
          ASSERT_LE(got, exact + 0.5 * spacing) << tool.id;
        }
        if (exact >= 0.51) {
          ASSERT_GE(got, 0.45) << tool.id;
        }
        if (n % 64 == 0) {
          ASSERT_EQ(field.distance(at), d[n]);
        }
      }
    }
    ++tools;
  }
  EXPECT_GE(tools, 90);
}

TEST(ToolField, IsGoodToATenthOfAMicrometreWhereABurIsSmooth) {
  RevolvedProfile profile;
  profile.arcTo({0, 0.8}, {0, 1.6});
  const RevolvedShape ball(profile);
  const ToolField field(ball);
  const Points p = pointsAround(ball.bounds(), 0.3, 4096, 3);
  double worst = 0;
  for (std::size_t n = 0; n < p.x.size(); ++n) {
    const Vec3f at(p.x[n], p.y[n], p.z[n]);
    const double exact = (at.cast<double>() - Vec3d(0, 0, 0.8)).norm() - 0.8;
    if (std::abs(exact) < 0.3) worst = std::max(worst, std::abs(static_cast<double>(field.distance(at)) - exact));
  }
  EXPECT_LT(worst, 5e-5);  // h^2 / 8 of curvature 1/0.5 at a spacing of 0.01
}

// A blade's parts are boxes: no table, at any distance.
TEST(ToolField, OfABoxIsItsDistanceToTheRounding) {
  const BoxShape box(Box3{Vec3d(0, -0.22, -1.5), Vec3d(0.5, 0.22, 26.5)});
  const ToolField field(box);
  const Points p = pointsAround(box.bounds(), 5, 4096, 11);
  std::vector<float> d(p.x.size());
  field.distances(p.x.data(), p.y.data(), p.z.data(), d.data(), static_cast<int>(d.size()));
  for (std::size_t n = 0; n < d.size(); ++n) {
    const Vec3f at(p.x[n], p.y[n], p.z[n]);
    ASSERT_NEAR(static_cast<double>(d[n]), box.distance(at.cast<double>()), 2e-6) << at.transpose();
  }

  // The lookup handles eight points at once. Its shortcuts for points beside and inside must give the same bits.
  for (const Vec3f& from :
       {Vec3f(0.25f, 0.3f, 3), Vec3f(0.7f, 0.1f, 20), Vec3f(0.1f, -0.05f, -1.7f), Vec3f(0.2f, 0.1f, 9)}) {
    Points before, mixed;
    for (int n = 0; n < 8; ++n) {
      before.add(from + Vec3f(0.01f, 0.011f, 0.3f) * static_cast<float>(n) / 8);
      mixed.add(n == 5 ? Vec3f(3, 3, 30) : Vec3f(before.x.back(), before.y.back(), before.z.back()));
    }
    float alike[8], unlike[8];
    field.distances(before.x.data(), before.y.data(), before.z.data(), alike, 8);
    field.distances(mixed.x.data(), mixed.y.data(), mixed.z.data(), unlike, 8);
    for (std::size_t n = 0; n < 8; ++n) {
      if (n == 5) continue;
      EXPECT_EQ(alike[n], unlike[n]) << from.transpose() << " " << n;
      const Vec3d at(double(before.x[n]), double(before.y[n]), double(before.z[n]));
      EXPECT_NEAR(static_cast<double>(alike[n]), box.distance(at), 2e-6);
    }
  }
  EXPECT_LT(field.slack(), 1e-4);
  EXPECT_EQ(field.leastOverlap(), 1e-6f);
  EXPECT_FALSE(field.isEmpty());
}

TEST(ToolField, OnlyWhatHasFlatSidesLeavesAnOverlapAlone) {
  const auto leastOf = [](const char* id) {
    const auto tool = readTool(*findToolFile(id, defaultToolFolders()));
    EXPECT_TRUE(tool) << id;
    return ToolField(*tool->cut).leastOverlap();
  };
  EXPECT_EQ(leastOf("saw-reciprocating-25"), 1e-6f);
  EXPECT_EQ(leastOf("saw-sagittal-10"), 1e-6f);
  EXPECT_EQ(leastOf("round-014"), 0);
  EXPECT_EQ(leastOf("disc-22"), 0);
}

// A session recorded on one machine replays on another: all instruction sets give the same bits.
TEST(ToolField, AllInstructionSetsGiveTheSameBits) {
  for (const char* id : {"round-014", "saw-reciprocating-25", "saw-sagittal-10"}) {
    const auto file = findToolFile(id, defaultToolFolders());
    ASSERT_TRUE(file) << id;
    const auto tool = readTool(*file);
    ASSERT_TRUE(tool);
    const ToolField field(*tool->cut);
    const Points p = pointsAround(field.bounds(), 0.7, 4096, 5);
    std::vector<std::vector<float>> results;
    const auto all = hwy::SupportedTargets();
    for (std::uint64_t bit = 1; bit != 0 && bit <= static_cast<std::uint64_t>(all); bit <<= 1) {
      if (!(static_cast<std::uint64_t>(all) & bit)) continue;
      hwy::SetSupportedTargetsForTest(static_cast<std::int64_t>(bit));
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      results.emplace_back(p.x.size());
      field.distances(p.x.data(), p.y.data(), p.z.data(), results.back().data(), static_cast<int>(p.x.size()));
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    ASSERT_GE(results.size(), 1u);
    for (const auto& other : results) EXPECT_EQ(other, results.front());
  }
}

TEST(ToolField, NoSolidIsFarAway) {
  const ToolField none;
  EXPECT_TRUE(none.isEmpty());
  EXPECT_EQ(none.distance(Vec3f(0, 0, 0)), ToolField::kFar);
}

}  // namespace
}  // namespace kerf::tool_field_test
