#include "preprocess/close/guard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/mesh/solids.h"
#include "preprocess/close/losses.h"
#include "tests/preprocess/solid_checks.h"

namespace kerf::guard_test {
namespace {

using internal::Chain;
using internal::judgeSolid;
using internal::windingVolume;

std::vector<std::string> guardWarnings(const Mesh& imported, const Mesh& solid, const CloseReport& report) {
  return judgeSolid(imported, solid, report).warnings;
}

Chain chainOf(const Mesh& mesh) {
  Chain out{.mesh = mesh, .source = {}, .source_vertices = static_cast<std::uint32_t>(mesh.vertices.size())};
  out.source.resize(mesh.triangles.size());
  std::iota(out.source.begin(), out.source.end(), 0u);
  return out;
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
  // An open scan encloses no volume for comparison.
  Mesh open = box({0, 0, 0}, {4, 3, 2});
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 2);
  EXPECT_TRUE(guardWarnings(open, box({0, 0, -2}, {4, 3, 2}), exactReport()).empty());
}

TEST(Guard, AVolumeThatGrewOrWentIsSaidAloud) {
  const Mesh mesh = box({0, 0, 0}, {4, 3, 2});
  for (const double height : {2.3, 7.4, 0.9}) {
    const auto said = guardWarnings(mesh, box({0, 0, 0}, {4, 3, height}), exactReport());
    ASSERT_EQ(said.size(), 1u) << height;
    EXPECT_NE(said[0].find("DIFFERS FROM THE SCAN"), std::string::npos) << said[0];
    EXPECT_NE(said[0].find("try --close"), std::string::npos) << said[0];
  }
  // Without a few triangles, like a stair-stepped skull: almost closed.
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

// A wrap comes from outside and fills hollows.
TEST(Guard, AWrapThatFillsAHollowWarns) {
  const auto s = closeMesh(hollowBox(), {.mode = CloseMode::kWrap, .wrap_alpha_mm = 1});
  ASSERT_TRUE(s) << s.error().message();
  ASSERT_GT(signedVolume(s->mesh), 1.5 * signedVolume(hollowBox()));
  EXPECT_TRUE(std::any_of(s->report.warnings.begin(), s->report.warnings.end(), [](const std::string& warning) {
    return warning.find("DIFFERS FROM THE SCAN") != std::string::npos;
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

bool saysLoudly(const std::vector<std::string>& warnings, const char* what) {
  return std::any_of(warnings.begin(), warnings.end(),
                     [what](const std::string& warning) { return warning.find(what) != std::string::npos; });
}

// The volume of triangles with mixed orientation has no meaning. Vertices swallowed by a union are no loss.
TEST(Guard, NothingIsSaidOfRightSolidsWhoseFilesFacedWrongOrCrossed) {
  Mesh every_second = ball(20, 40, 6);
  for (std::size_t t = 0; t < every_second.triangles.size(); t += 2)
    std::swap(every_second.triangles[t][1], every_second.triangles[t][2]);
  const Solid turned = closed(every_second);
  EXPECT_DOUBLE_EQ(signedVolume(turned.mesh), signedVolume(ball(20, 40, 6)));
  EXPECT_TRUE(turned.report.warnings.empty()) << turned.report.warnings.front();

  Mesh other = ball(20, 40, 6);
  for (Vec3d& p : other.vertices) p = roundedToFloat(p + Vec3d(4, 1, 0.5));
  for (const Mesh& second : {other, flipped(other)}) {
    const Solid united = closed(both(ball(20, 40, 6), second));
    EXPECT_GT(10 * united.report.vertices_lost, 2 * ball(20, 40, 6).vertices.size());
    EXPECT_TRUE(united.report.warnings.empty()) << united.report.warnings.front();
  }
}

// Synthetic faults for the guard: a piece subtracted or lost instead of united.
TEST(Guard, APieceThatWasSubtractedIsSaidAloud) {
  const Mesh row =
      both(both(box({0, 0, 0}, {10, 10, 10}), box({10, 0, 0}, {20, 10, 10})), flipped(box({20, 0, 0}, {30, 10, 10})));
  CloseReport report = exactReport();
  EXPECT_TRUE(guardWarnings(row, box({0, 0, 0}, {30, 10, 10}), report).empty());
  EXPECT_TRUE(saysLoudly(guardWarnings(row, box({0, 0, 0}, {20, 10, 10}), report), "DIFFERS FROM THE SCAN"));

  // As much outwards as inwards: the sum over the triangles is zero.
  const Mesh two = both(box(0, 8), flipped(box({4, 0, 0}, {12, 8, 8})));
  const Chain chain = chainOf(both(box(0, 8), box({4, 0, 0}, {12, 8, 8})));
  report.triangles_flipped = 12;
  EXPECT_TRUE(judgeSolid(two, box({0, 0, 0}, {12, 8, 8}), report, &chain).warnings.empty());
  const Mesh halves = both(box({0, 0, 0}, {4, 8, 8}), box({8, 0, 0}, {12, 8, 4}));
  EXPECT_TRUE(saysLoudly(judgeSolid(two, halves, report, &chain).warnings, "DIFFERS FROM THE SCAN"));
  report.triangles_flipped = 0;
  EXPECT_TRUE(saysLoudly(guardWarnings(two, box({0, 0, 0}, {1, 8, 8}), report), "DIFFERS FROM THE SCAN"));
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

  // A union of nested solids loses the inner ones, as it should.
  const Mesh nested = both(ball(12, 24, 5), ball(30, 60, 2));
  const auto s = closeMesh(nested);
  ASSERT_TRUE(s) << s.error().message();
  EXPECT_GT(3 * s->report.vertices_lost, nested.vertices.size());
}

// A comb without thickness: walls around each tooth make a block of many times its small volume.
TEST(Guard, AWrapOfManyTimesTheVolumeIsRefusedAndCanBeAccepted) {
  Mesh comb;  // plates 0.05 mm thick, 0.5 mm apart: a wrap of 1 mm fills the gaps
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
  EXPECT_NE(taken->report.warnings[0].find("DIFFERS FROM THE SCAN"), std::string::npos) << taken->report.warnings[0];
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

// A roof 5 mm high with a row of sockets at its front edge. A flap covers the mouth of each, so that the walls below
// meet, and a bay of the rim becomes a through shaft.
Mesh roofWithShafts(int sockets) {
  const int across = 3 * sockets + 1, deep = 5;
  Mesh m;
  for (int j = 0; j <= deep; ++j)
    for (int i = 0; i <= across; ++i) m.vertices.push_back({1.0 * i, 1.0 * j, 5});
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * (across + 1) + i); };
  for (int j = 0; j < deep; ++j)
    for (int i = 0; i < across; ++i) {
      if (i % 3 == 1 && j < 3) continue;
      m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  for (int k = 0; k < sockets; ++k) {
    const auto n = static_cast<std::uint32_t>(m.vertices.size());
    m.vertices.push_back(roundedToFloat(Vec3d(3 * k + 2.3, 0.2, 5.5)));
    m.vertices.push_back(roundedToFloat(Vec3d(3 * k + 2.3, 0.8, 5.5)));
    m.triangles.push_back({at(3 * k + 1, 0), n, n + 1});
    m.triangles.push_back({at(3 * k + 1, 0), n + 1, at(3 * k + 1, 1)});
  }
  return subset(m, std::vector<char>(m.triangles.size(), 1));
}

TEST(Guard, ShaftsThatABaseMakesAreCountedOnAMeshThatHasNone) {
  const CloseOptions straight{.base_smoothing_mm = 0, .base_direction = -Vec3d::UnitZ()};
  EXPECT_EQ(internal::handlesOf(roofWithShafts(24)), 0);
  const Solid many = closed(roofWithShafts(24), straight);
  EXPECT_EQ(many.report.handles_added, 24);
  ASSERT_FALSE(many.report.warnings.empty());
  EXPECT_NE(many.report.warnings.back().find("FULL OF HOLES: 24"), std::string::npos) << many.report.warnings.back();

  const Solid few = closed(roofWithShafts(2), straight);
  EXPECT_EQ(few.report.handles_added, 2);
  EXPECT_TRUE(few.report.warnings.empty()) << few.report.warnings.front();
}

// Twenty thousand copies of one triangle made a solid of 4.8 mm3 without a warning.
TEST(Guard, AWrapOfWhatEnclosesNothingIsRefused) {
  Mesh copies;
  copies.vertices = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}};
  copies.triangles.assign(20'000, {0, 1, 2});
  for (const CloseMode mode : {CloseMode::kAuto, CloseMode::kWrap}) {
    CloseOptions options{.mode = mode};
    const auto refused = closeMesh(copies, options);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Error::Code::kGeometry);
    EXPECT_NE(refused.error().found.find("encloses nothing"), std::string::npos) << refused.error().message();
    EXPECT_NE(refused.error().hint.find("--close base"), std::string::npos) << refused.error().message();
    EXPECT_NE(refused.error().hint.find("--accept-doubtful"), std::string::npos) << refused.error().message();

    options.accept_doubtful = true;
    const auto taken = closeMesh(copies, options);
    ASSERT_TRUE(taken) << taken.error().message();
    ASSERT_FALSE(taken->report.warnings.empty());
    EXPECT_NE(taken->report.warnings.back().find("A SKIN"), std::string::npos) << taken->report.warnings.back();
  }
  // Thin, but with an inside.
  EXPECT_TRUE(closeMesh(box({0, 0, 0}, {10, 10, 0.4}), {.mode = CloseMode::kWrap}));
}

TEST(Guard, ASideThatGrewOrShrankIsNamedWithItsMillimetres) {
  // An open scan encloses no volume: only the extent shows the fault.
  Mesh open = box({0, 0, 0}, {20, 20, 10});
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 2);
  const Chain chain = chainOf(open);
  CloseReport report = exactReport();
  report.base_direction = -Vec3d::UnitZ();
  EXPECT_TRUE(judgeSolid(open, box({0, 0, -9}, {20, 20, 10}), report, &chain).warnings.empty()) << "the base's side";
  EXPECT_TRUE(judgeSolid(open, box({-0.3, 0, -9}, {20.3, 20, 10}), report, &chain).warnings.empty()) << "a lip";

  const auto said = judgeSolid(open, box({0, 0, -9}, {23, 18, 10}), report, &chain).warnings;
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("it ends 2 mm short of the scan on the +y side, reaches 3 mm beyond the scan on the +x side"),
            std::string::npos)
      << said[0];
  EXPECT_NE(said[0].find("try --close"), std::string::npos) << said[0];

  // If both have a volume, the extent locates the fault.
  const Mesh whole = box({0, 0, 0}, {20, 20, 10});
  const Chain closed_chain = chainOf(whole);
  const auto grown = judgeSolid(whole, box({0, 0, 0}, {20, 20, 14}), exactReport(), &closed_chain).warnings;
  ASSERT_EQ(grown.size(), 1u);
  EXPECT_NE(grown[0].find("DIFFERS FROM THE SCAN"), std::string::npos) << grown[0];
  EXPECT_NE(grown[0].find("it reaches 4 mm beyond the scan on the +z side"), std::string::npos) << grown[0];
}

TEST(Guard, APieceThatIsLostIsSaidWithItsPlace) {
  const Mesh three = rowOfBoxes(3), two = rowOfBoxes(2);
  const Chain chain = chainOf(three);
  const auto said = judgeSolid(three, two, exactReport(), &chain).warnings;
  ASSERT_FALSE(said.empty());
  EXPECT_NE(said.back().find("A PIECE OF THE SCAN IS LOST: 1 of 3"), std::string::npos) << said.back();
  EXPECT_NE(said.back().find("(7.0, 1.0, 1.0) mm"), std::string::npos) << said.back();
  EXPECT_TRUE(judgeSolid(three, three, exactReport(), &chain).warnings.empty());

  // The whole process: a sheet is closed on its own back, which leaves nothing.
  Mesh sheet;
  sheet.vertices = {{12, 0, 0}, {16, 0, 0}, {16, 4, 0}, {12, 4, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto s = closeMesh(both(box({0, 0, 0}, {10, 10, 10}), sheet));
  ASSERT_TRUE(s) << s.error().message();
  EXPECT_TRUE(std::any_of(s->report.warnings.begin(), s->report.warnings.end(), [](const std::string& warning) {
    return warning.find("A PIECE OF THE SCAN IS LOST") != std::string::npos;
  })) << fmt::format("{}", fmt::join(s->report.changes, "; "));

  // A piece inside another disappears, as in every union: no loss.
  const auto nested = closeMesh(both(ball(12, 24, 5), ball(30, 60, 2)));
  ASSERT_TRUE(nested);
  for (const std::string& warning : nested->report.warnings)
    EXPECT_EQ(warning.find("A PIECE"), std::string::npos) << warning;
}

TEST(Guard, PiecesThatAWrapJoinsAreSaidAndThoseThatMeetAreNot) {
  const auto isJoined = [](const std::string& warning) { return warning.find("ARE JOINED: 2") != std::string::npos; };
  const Mesh apart = both(box({0, 0, 0}, {8, 8, 8}), box({8.3, 0, 0}, {16, 8, 8}));
  const auto wrapped = closeMesh(apart, {.mode = CloseMode::kWrap, .wrap_alpha_mm = 1});
  ASSERT_TRUE(wrapped) << wrapped.error().message();
  ASSERT_EQ(countPieces(wrapped->mesh).pieces, 1u);
  EXPECT_TRUE(std::any_of(wrapped->report.warnings.begin(), wrapped->report.warnings.end(), isJoined));

  const Mesh meeting = both(box({0, 0, 0}, {8, 8, 8}), box({7, 1, 1}, {16, 7, 7}));
  const auto one = closeMesh(meeting, {.mode = CloseMode::kWrap, .wrap_alpha_mm = 1});
  ASSERT_TRUE(one) << one.error().message();
  EXPECT_FALSE(std::any_of(one->report.warnings.begin(), one->report.warnings.end(), isJoined));

  // An exact solid joins only pieces connected by its walls or patches: a note.
  const Chain chain = chainOf(apart);
  const Mesh joined = closed(both(apart, box({7, 2, 2}, {9, 6, 6}))).mesh;
  const auto judged = judgeSolid(apart, joined, exactReport(), &chain);
  ASSERT_EQ(judged.notes.size(), 1u);
  EXPECT_NE(judged.notes[0].find("2 pieces of the scan that do not touch are one in the solid"), std::string::npos);
}

TEST(Guard, LostPlacesThatLieTogetherAreOneHeap) {
  std::vector<Vec3d> places;
  for (int k = 0; k < 30; ++k) places.push_back({1.5 * k, 0, 0});
  places.push_back({100, 0, 0});
  const auto heaps = internal::heapsOf(places, 2);
  ASSERT_EQ(heaps.size(), 2u);
  EXPECT_EQ(heaps[0].vertices, 30u);
  EXPECT_NEAR(heaps[0].middle.x(), 1.5 * 14.5, 1e-9);
  EXPECT_EQ(heaps[1].vertices, 1u);
}

// Specks are counted. On request they are dropped, but never the largest piece.
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
}  // namespace kerf::guard_test
