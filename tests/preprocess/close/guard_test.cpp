#include "preprocess/close/guard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/mesh/solids.h"
#include "tests/preprocess/solid_checks.h"

namespace kerf {
namespace {

using internal::judgeSolid;
using internal::windingVolume;

std::vector<std::string> guardWarnings(const Mesh& imported, const Mesh& solid, const CloseReport& report) {
  return judgeSolid(imported, solid, report).warnings;
}

// A box with a hollow of 3 x 3 x 4.5 mm inside.
Mesh hollowBox() {
  Mesh out = box({0, 0, 0}, {4, 4, 5.5});
  const Mesh inner = flipped(box({0.5, 0.5, 0.5}, {3.5, 3.5, 5}));
  const auto first = static_cast<std::uint32_t>(out.vertices.size());
  out.vertices.insert(out.vertices.end(), inner.vertices.begin(), inner.vertices.end());
  for (const Triangle& f : inner.triangles) out.triangles.push_back({f[0] + first, f[1] + first, f[2] + first});
  return out;
}

CloseReport exactReport() {
  CloseReport out;
  out.exact = true;
  return out;
}

TEST(Guard, ASolidThatIsWhatWasScannedIsNotComplainedAbout) {
  const Mesh ball_of_5 = ball(12, 24, 5);
  EXPECT_TRUE(guardWarnings(ball_of_5, ball_of_5, exactReport()).empty());
  // An open scan encloses nothing to compare with.
  Mesh open = box({0, 0, 0}, {4, 3, 2});
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 2);
  EXPECT_TRUE(guardWarnings(open, box({0, 0, -2}, {4, 3, 2}), exactReport()).empty());
}

TEST(Guard, AVolumeThatGrewOrWentIsSaidAloud) {
  const Mesh mesh = box({0, 0, 0}, {4, 3, 2});
  for (const double height : {2.3, 7.4, 0.9}) {
    const auto said = guardWarnings(mesh, box({0, 0, 0}, {4, 3, height}), exactReport());
    ASSERT_EQ(said.size(), 1u) << height;
    EXPECT_NE(said[0].find("NOT WHAT WAS SCANNED"), std::string::npos) << said[0];
    EXPECT_NE(said[0].find("try --close"), std::string::npos) << said[0];
  }
  // Without a few triangles, as a stair-stepped skull: as good as closed.
  Mesh fine = ball(60, 120, 5);
  fine.triangles.erase(fine.triangles.begin() + 3000, fine.triangles.begin() + 3002);
  EXPECT_EQ(guardWarnings(fine, box({-9, -9, -9}, {9, 9, 9}), exactReport()).size(), 1u);
}

TEST(Guard, AScanOfWhichATenthIsGoneIsSaidAloud) {
  const Mesh mesh = ball(12, 24, 5);
  CloseReport report = exactReport();
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

// n boxes of 2 mm in a row, 1 mm apart.
Mesh rowOfBoxes(int n) {
  Mesh out;
  for (int k = 0; k < n; ++k) append(out, box({3.0 * k, 0, 0}, {3.0 * k + 2, 2, 2}));
  return out;
}

TEST(Guard, ASolidOfTwiceTheVolumeIsRefusedAndTheWayOutNamed) {
  const Mesh mesh = box({0, 0, 0}, {4, 3, 2});
  EXPECT_FALSE(judgeSolid(mesh, box({0, 0, 0}, {4, 3, 3.9}), exactReport()).refusal);
  EXPECT_FALSE(judgeSolid(mesh, box({0, 0, 0}, {4, 3, 0.6}), exactReport()).refusal);
  for (const double height : {4.2, 9.0, 0.4}) {
    const auto judged = judgeSolid(mesh, box({0, 0, 0}, {4, 3, height}), exactReport());
    ASSERT_TRUE(judged.refusal) << height;
    EXPECT_EQ(judged.refusal->code, Error::Code::kGeometry);
    EXPECT_NE(judged.refusal->hint.find("--accept-doubtful"), std::string::npos) << judged.refusal->message();
    EXPECT_NE(judged.refusal->hint.find("--close wrap"), std::string::npos);
    EXPECT_EQ(judged.warnings.size(), 1u) << "what is accepted is warned of";
  }
}

TEST(Guard, ShellsInEachOtherAndPiecesInsideOutAreCountedByWinding) {
  Mesh onion;
  for (const double r : {1.0, 1.5, 2.0, 2.2, 2.4, 2.6, 2.8, 3.0}) append(onion, ball(12, 24, r));
  const Mesh outer = ball(12, 24, 3);
  EXPECT_LT(signedVolume(outer), 0.4 * signedVolume(onion));
  EXPECT_NEAR(windingVolume(onion), signedVolume(outer), 0.03 * signedVolume(outer));
  const auto judged = judgeSolid(onion, outer, exactReport());
  EXPECT_TRUE(judged.warnings.empty()) << judged.warnings.front();

  Mesh mixed = rowOfBoxes(6);
  for (std::size_t t = 0; t < 36; ++t) std::swap(mixed.triangles[t][1], mixed.triangles[t][2]);
  append(mixed, box({-3, 0, 0}, {-2, 2, 2}));
  ASSERT_LT(std::abs(signedVolume(mixed)), 10);
  EXPECT_TRUE(judgeSolid(mixed, both(rowOfBoxes(6), box({-3, 0, 0}, {-2, 2, 2})), exactReport()).warnings.empty());
}

TEST(Guard, MoreThanTwoLayersOfAScanLostIsRefusedUnlessInnerShellsAre) {
  const Mesh whole = ball(12, 24, 5);
  std::vector<char> keep(whole.triangles.size(), 1);
  std::fill(keep.begin(), keep.begin() + 200, 0);
  const Mesh open = subset(whole, keep);
  CloseReport report = exactReport();
  report.vertices_lost = open.vertices.size() / 2;
  EXPECT_FALSE(judgeSolid(open, ball(12, 24, 5), report).refusal);
  report.vertices_lost = 2 * open.vertices.size() / 3;
  const auto judged = judgeSolid(open, ball(12, 24, 5), report);
  ASSERT_TRUE(judged.refusal);
  EXPECT_NE(judged.refusal->found.find("vertices"), std::string::npos);

  // A union of solids in each other loses the inner ones, as it should.
  const Mesh nested = both(ball(12, 24, 5), ball(30, 60, 2));
  const auto s = closeMesh(nested);
  ASSERT_TRUE(s) << s.error().message();
  EXPECT_GT(3 * s->report.vertices_lost, nested.vertices.size());
}

// A comb without thickness: walls around each tooth make a block of many times what little there is.
TEST(Guard, AWrapOfManyTimesTheVolumeIsRefusedAndCanBeAccepted) {
  Mesh comb;  // plates 0.05 mm thick, 0.5 mm apart: a wrap of 1 mm fills all between them
  for (int k = 0; k < 20; ++k) append(comb, box({0.5 * k, 0, 0}, {0.5 * k + 0.05, 5, 5}));
  CloseOptions options{.mode = CloseMode::kWrap, .wrap_alpha_mm = 1};
  const auto refused = closeMesh(comb, options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().hint.find("--accept-doubtful"), std::string::npos) << refused.error().message();

  options.accept_doubtful = true;
  const auto taken = closeMesh(comb, options);
  ASSERT_TRUE(taken) << taken.error().message();
  EXPECT_GT(signedVolume(taken->mesh), 2 * signedVolume(comb));
  EXPECT_NEAR(taken->report.volume_closed_mm3, signedVolume(comb), 0.05 * signedVolume(comb));
  ASSERT_FALSE(taken->report.warnings.empty());
  EXPECT_NE(taken->report.warnings[0].find("NOT WHAT WAS SCANNED"), std::string::npos) << taken->report.warnings[0];
}

TEST(Guard, ManyHolesRightThroughAreSaidInCapitals) {
  const Mesh mesh = ball(12, 24, 5);
  CloseReport report = exactReport();
  report.handles_added = 9;
  EXPECT_TRUE(judgeSolid(mesh, mesh, report).warnings.empty());
  report.handles_added = 50;
  const auto said = judgeSolid(mesh, mesh, report).warnings;
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("FULL OF HOLES"), std::string::npos) << said[0];
}

// Specks: counted, and dropped where that is asked for, never the largest piece.
TEST(Guard, SpecksAreDroppedOnlyWhenAsked) {
  Mesh mesh = box({0, 0, 0}, {10, 10, 10});
  for (int k = 0; k < 36; ++k) append(mesh, box({20.0 + k, 0, 0}, {20.4 + k, 0.5, 0.5}));
  const auto kept = closeMesh(mesh);
  ASSERT_TRUE(kept);
  EXPECT_EQ(countPieces(kept->mesh).specks, 36u);

  const auto dropped = closeMesh(mesh, {.drop_specks_mm3 = 1});
  ASSERT_TRUE(dropped);
  expectSolid(*dropped);
  EXPECT_EQ(countPieces(dropped->mesh).pieces, 1u);
  EXPECT_EQ(dropped->report.specks_dropped, 36u);
  EXPECT_NEAR(dropped->report.specks_dropped_mm3, 3.6, 1e-5);
  EXPECT_NE(dropped->report.changes.back().find("36 pieces smaller than 1 mm3 were dropped"), std::string::npos);

  const auto small = closeMesh(box({0, 0, 0}, {4, 3, 2}), {.drop_specks_mm3 = 1000});
  ASSERT_TRUE(small);
  EXPECT_EQ(small->mesh.triangles.size(), 12u);
}

}  // namespace
}  // namespace kerf
