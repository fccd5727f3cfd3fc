// Print plans, and their run on a model.
#include <gtest/gtest.h>

#include "geometry/base/assets.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/mesh/solids.h"
#include "preprocess/print/prepare.h"
#include "tests/preprocess/print/print_shapes.h"
#include "tests/support/temporary_folder.h"

namespace kerf::prepare_test {
namespace {

class PrintPlans : public ::testing::Test {
 protected:
  Expected<PrintPlan> read(const std::string& text) {
    folder_.write("plan.toml", "format = \"kerf-print\"\nversion = 1\n" + text);
    return readPrintPlan(folder_.path() / "plan.toml");
  }
  TemporaryFolder folder_;
};

// Stands on its underside, z = 0.
Mesh block() { return box({0, 0, 0}, {30, 20, 16}); }

TEST_F(PrintPlans, AllKeysAreRead) {
  const auto plan = read(R"(up = [0, 0, 2]
to_bed = "Form 3"
[[step]]
do = "hollow"
wall = 2.5
rounding = 0.25
voxel = 0.2
least_cavity = 5
[[step]]
do = "drain"
diameter = 3
count = 4
side = "nearest"
at = [[1, 2, 3]]
[[step]]
do = "label"
text = "{case}"
on = "side"
height = 3
depth = 0.4
embossed = true
)");
  ASSERT_TRUE(plan) << plan.error().message();
  EXPECT_EQ(*plan->up, Vec3d::UnitZ());
  EXPECT_EQ(plan->to_bed, "Form 3");
  ASSERT_EQ(plan->steps.size(), 3u);
  const auto& hollow = std::get<HollowOptions>(plan->steps[0]);
  EXPECT_EQ(hollow.wall_mm, 2.5);
  EXPECT_EQ(hollow.rounding_mm, 0.25);
  EXPECT_EQ(hollow.voxel_mm, 0.2);
  EXPECT_EQ(hollow.least_cavity_mm3, 5);
  const auto& drain = std::get<DrainOptions>(plan->steps[1]);
  EXPECT_EQ(drain.diameter_mm, 3);
  EXPECT_EQ(drain.count, 4u);
  EXPECT_EQ(drain.side, DrainSide::kNearestWall);
  ASSERT_EQ(drain.at.size(), 1u);
  EXPECT_EQ(drain.at[0], Vec3d(1, 2, 3));
  const auto& label = std::get<LabelStep>(plan->steps[2]);
  EXPECT_EQ(label.face, LabelFace::kSide);
  EXPECT_EQ(label.label.text, "{case}");
  EXPECT_EQ(label.label.height_mm, 3);
  EXPECT_EQ(label.label.depth_mm, 0.4);
  EXPECT_TRUE(label.label.embossed);
}

TEST_F(PrintPlans, WrongOnesAreRefusedByLineAndKey) {
  const auto refuses = [&](const std::string& text, const std::string& word) {
    const auto plan = read(text);
    EXPECT_FALSE(plan) << text;
    if (!plan) EXPECT_NE(plan.error().message().find(word), std::string::npos) << plan.error().message();
  };
  refuses("[[step]]\ndo = \"hollow\"\nwal = 2\n", "wall");
  refuses("[[step]]\ndo = \"hollow\"\nwall = 0.1\n", "line 5");
  refuses("[[step]]\ndo = \"bake\"\n", "\"hollow\", \"drain\" or \"label\"");
  refuses("[[step]]\nwall = 2\n", "do");
  refuses("[[step]]\ndo = \"drain\"\ncount = 0\n", "1 to 20");
  refuses("[[step]]\ndo = \"drain\"\ncount = 1.5\n", "whole number");
  refuses("[[step]]\ndo = \"drain\"\nside = \"top\"\n", "\"underside\", \"nearest\"");
  refuses("[[step]]\ndo = \"label\"\n", "text");
  refuses("up = [0, 0, 0]\nstep = []\n", "direction");
  refuses("speed = 1\n[[step]]\ndo = \"hollow\"\n", "speed");
  refuses("", "step");
}

TEST_F(PrintPlans, TheUsualPlanOfTheDataIsReadable) {
  const auto found = findAssets("print/model.toml");
  ASSERT_FALSE(found.empty());
  const auto plan = readPrintPlan(found.front());
  ASSERT_TRUE(plan) << plan.error().message();
  EXPECT_EQ(plan->steps.size(), 3u);
}

TEST_F(PrintPlans, ABlockIsHollowDrainedLabelledAndOnTheBed) {
  const auto plan = read(R"(to_bed = "60x60x40"
[[step]]
do = "hollow"
wall = 2
voxel = 0.2
[[step]]
do = "drain"
[[step]]
do = "label"
text = "{case} {tooth}"
)");
  ASSERT_TRUE(plan) << plan.error().message();
  const Mesh solid = block();
  const auto done = prepareForPrint(solid, *plan, {{"case", "A"}, {"tooth", "36"}});
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_TRUE(checkMesh(done->mesh).print_ready);
  EXPECT_EQ(countPieces(done->mesh).cavities, 0u) << "the drains open it";
  EXPECT_EQ(done->source_vertices_kept, 8u);
  EXPECT_EQ(bounds(done->mesh).min[2], 0);
  EXPECT_TRUE(done->on_plate);
  EXPECT_NEAR(bounds(done->mesh).max[2], 16, 1e-4);
  EXPECT_NEAR(done->source_mm3, 30 * 20 * 16, 1e-9);
  const double cavity = 26 * 16 * 12;
  EXPECT_NEAR(done->resin_mm3, 30 * 20 * 16 - cavity, 0.03 * cavity);
  EXPECT_NEAR(done->resin_mm3, signedVolume(done->mesh), 1e-6);
  ASSERT_EQ(done->steps.size(), 3u);
  EXPECT_EQ(done->steps[1].numbers.at("cavities_left"), 0);
  EXPECT_NEAR(done->steps[0].numbers.at("wall_p05_mm"), 2, 0.05);
  // Flat on the plate its drains are closed by the plate: the report says so.
  ASSERT_FALSE(done->pockets.pockets.empty());
  EXPECT_TRUE(done->pockets.pockets.front().is_closed_by_plate);

  const auto again = prepareForPrint(solid, *plan, {{"case", "A"}, {"tooth", "36"}});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->mesh.vertices, done->mesh.vertices);
  EXPECT_EQ(again->mesh.triangles, done->mesh.triangles);
}

TEST_F(PrintPlans, AnErrorNamesTheStep) {
  const auto plan =
      read("[[step]]\ndo = \"hollow\"\nwall = 2\nvoxel = 0.25\n[[step]]\ndo = \"label\"\ntext = \"{dat}\"\n");
  ASSERT_TRUE(plan);
  const auto done = prepareForPrint(block(), *plan, {{"case", "A"}});
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().place.starts_with("step 2, label")) << done.error().message();
}

TEST_F(PrintPlans, AModelWithoutABaseNeedsADirection) {
  std::vector<Eigen::Vector2d> ball;
  test::addArc(ball, 8, -M_PI / 2, M_PI / 2);
  Mesh mesh = test::revolved(ball, 64);
  for (Vec3d& p : mesh.vertices) p = p.cast<float>().cast<double>();
  const auto plan = read("[[step]]\ndo = \"hollow\"\nvoxel = 0.3\n");
  ASSERT_TRUE(plan);
  const auto none = prepareForPrint(mesh, *plan, {});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().place, "up");
  PrintPlan given = *plan;
  given.up = Vec3d::UnitZ();
  const auto done = prepareForPrint(mesh, given, {});
  ASSERT_TRUE(done) << done.error().message();
  ASSERT_EQ(done->pockets.pockets.size(), 1u);
  EXPECT_EQ(done->pockets.pockets[0].kind, PocketKind::kSealed) << "no drains: resin is trapped";
}

TEST_F(PrintPlans, CancelledLeavesNothing) {
  const auto plan = read("[[step]]\ndo = \"hollow\"\nvoxel = 0.25\n");
  ASSERT_TRUE(plan);
  int calls = 0;
  const auto done = prepareForPrint(block(), *plan, {}, [&](double, std::string_view) { return ++calls < 2; });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Error::Code::kCancelled);
}

}  // namespace
}  // namespace kerf::prepare_test
