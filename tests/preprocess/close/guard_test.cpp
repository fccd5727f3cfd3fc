#include "preprocess/close/guard.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/preprocess/solid_checks.h"

namespace kerf {
namespace {

using internal::guardWarnings;

// A box with a hollow of 3 x 3 x 4.5 mm inside.
Mesh hollowBox() {
  Mesh out = box({0, 0, 0}, {4, 4, 5.5});
  const Mesh inner = flipped(box({0.5, 0.5, 0.5}, {3.5, 3.5, 5}));
  const auto first = static_cast<std::uint32_t>(out.vertices.size());
  out.vertices.insert(out.vertices.end(), inner.vertices.begin(), inner.vertices.end());
  for (const Triangle& f : inner.triangles) out.triangles.push_back({f[0] + first, f[1] + first, f[2] + first});
  return out;
}

TEST(Guard, ASolidThatIsWhatWasScannedIsNotComplainedAbout) {
  const Mesh ball_of_5 = ball(12, 24, 5);
  EXPECT_TRUE(guardWarnings(ball_of_5, ball_of_5, {.exact = true}).empty());
  // An open scan encloses nothing to compare with.
  Mesh open = box({0, 0, 0}, {4, 3, 2});
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 2);
  EXPECT_TRUE(guardWarnings(open, box({0, 0, -2}, {4, 3, 2}), {.exact = true}).empty());
}

TEST(Guard, AVolumeThatGrewOrWentIsSaidAloud) {
  const Mesh mesh = box({0, 0, 0}, {4, 3, 2});
  for (const double height : {2.3, 7.4, 0.9}) {
    const auto said = guardWarnings(mesh, box({0, 0, 0}, {4, 3, height}), {.exact = true});
    ASSERT_EQ(said.size(), 1u) << height;
    EXPECT_NE(said[0].find("NOT WHAT WAS SCANNED"), std::string::npos) << said[0];
    EXPECT_NE(said[0].find("try --close"), std::string::npos) << said[0];
  }
  // Without a few triangles, as a stair-stepped skull: as good as closed.
  Mesh fine = ball(60, 120, 5);
  fine.triangles.erase(fine.triangles.begin() + 3000, fine.triangles.begin() + 3002);
  EXPECT_EQ(guardWarnings(fine, box({-9, -9, -9}, {9, 9, 9}), {.exact = true}).size(), 1u);
}

TEST(Guard, AScanOfWhichATenthIsGoneIsSaidAloud) {
  const Mesh mesh = ball(12, 24, 5);
  CloseReport report{.exact = true};
  report.vertices_lost = mesh.vertices.size() / 20;
  EXPECT_TRUE(guardWarnings(mesh, mesh, report).empty());
  report.vertices_lost = mesh.vertices.size() / 3;
  const auto said = guardWarnings(mesh, mesh, report);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("MUCH OF THE SCAN IS LOST"), std::string::npos) << said[0];
}

// A wrap comes from outside: what is hollow gets full.
TEST(Guard, AWrapThatFillsAHollowWarns) {
  const auto s = closeMesh(hollowBox(), {.mode = CloseMode::kWrap, .wrap_alpha_mm = 1});
  ASSERT_TRUE(s) << s.error().message();
  ASSERT_GT(signedVolume(s->mesh), 1.5 * signedVolume(hollowBox()));
  EXPECT_TRUE(std::any_of(s->report.warnings.begin(), s->report.warnings.end(), [](const std::string& warning) {
    return warning.find("NOT WHAT WAS SCANNED") != std::string::npos;
  }));
}

}  // namespace
}  // namespace kerf
