#include <chrono>
#include <cmath>
#include <thread>

#include "preprocess/demo/demo_arch.h"
#include "tests/ui/block_on_bench.h"
#include "ui/app/commands/zoom.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/sessions.h"

namespace kerf::tooth_views_test {
namespace {

namespace fs = std::filesystem;

// One object without an arch.
class ViewsOfABlock : public test::OnABlock {
 protected:
  Expected<void> run(const char* id, std::vector<std::string> words = {}) { return runAppCommand(context_, id, words); }
};

TEST_F(ViewsOfABlock, WhereNothingTellsTheSidesTheyAreAskedFor) {
  const Camera before = camera_;
  for (const char* view : {"view.occlusal", "view.buccal", "view.lingual", "view.mesial", "view.distal"}) {
    const auto refused = run(view);
    ASSERT_FALSE(refused) << view;
    EXPECT_EQ(refused.error().code, Error::Code::kUnsupported) << view;
    EXPECT_NE(refused.error().hint.find("view.sides "), std::string::npos) << refused.error().message();
  }
  EXPECT_EQ(camera_.backwards(), before.backwards());
  EXPECT_EQ(camera_.half_height, before.half_height);
}

TEST_F(ViewsOfABlock, AxesThatAPersonTellsAreTheSides) {
  ASSERT_TRUE(run("view.sides", {"-y", "+x"}));
  const std::pair<const char*, Vec3d> views[] = {{"view.occlusal", {0, 0, 1}},
                                                 {"view.buccal", {0, -1, 0}},
                                                 {"view.lingual", {0, 1, 0}},
                                                 {"view.mesial", {1, 0, 0}},
                                                 {"view.distal", {-1, 0, 0}}};
  for (const auto& [view, from] : views) {
    ASSERT_TRUE(run(view)) << view;
    EXPECT_NEAR((camera_.backwards() - from).norm(), 0, 1e-9) << view;
    EXPECT_NEAR((camera_.up() - (from.z() > 0 ? Vec3d(0, -1, 0) : Vec3d(0, 0, 1))).norm(), 0, 1e-9) << view;
  }
  for (const std::vector<std::string>& bad :
       {std::vector<std::string>{}, {"-y"}, {"-y", "-y"}, {"-y", "+y"}, {"+z", "+x"}, {"left", "+x"}, {"auto", "+x"}})
    EXPECT_FALSE(run("view.sides", bad));
  EXPECT_TRUE(run("view.buccal")) << "what was told stays";
  ASSERT_TRUE(run("view.sides", {"auto"}));
  EXPECT_FALSE(run("view.buccal"));
}

TEST_F(ViewsOfABlock, AViewThatAPersonCallsBuccalIsLookedFromAgain) {
  EXPECT_FALSE(run("view.sides-here", {"left"})) << "from above";
  ASSERT_TRUE(run("view.from", {"35,20"}));
  const Vec3d right = camera_.right(), back = camera_.backwards();
  EXPECT_FALSE(run("view.sides-here", {"up"}));
  for (const char* side : {"left", "right"}) {
    ASSERT_TRUE(run("view.from", {"35,20"}));
    ASSERT_TRUE(run("view.sides-here", {side}));
    ASSERT_TRUE(run("view.buccal"));
    EXPECT_NEAR((camera_.backwards() - Vec3d(back.x(), back.y(), 0).normalized()).norm(), 0, 1e-9) << side;
    ASSERT_TRUE(run("view.mesial"));
    EXPECT_NEAR((camera_.backwards() - (side == std::string("right") ? right : Vec3d(-right))).norm(), 0, 1e-9) << side;
  }
}

TEST_F(ViewsOfABlock, ThePlaceIsAPixelTheCursorOrTheMiddle) {
  ASSERT_TRUE(run("view.sides", {"-y", "+x"}));
  const Camera top = camera_;
  const auto targetOf = [&](std::vector<std::string> words) {
    camera_ = top;
    EXPECT_TRUE(run("view.buccal", std::move(words)));
    return camera_.target;
  };
  const Vec3d middle = targetOf({});
  EXPECT_NEAR(middle.z(), 0, 0.05) << "the surface in the middle of the view";
  EXPECT_NEAR(middle.head<2>().norm(), 0, 0.1);
  const Vec3d at = targetOf({"260", "150"});
  EXPECT_NEAR(at.x(), 60 * top.mmPerPixel(context_.height), 0.05);
  EXPECT_NEAR(at.z(), 0, 0.05);
  context_.pointer = {260, 150};
  EXPECT_EQ(targetOf({}), at);
  EXPECT_NEAR(targetOf({"200", "150"}).x(), middle.x(), 1e-9) << "a pixel goes before the cursor";

  const auto beside = run("view.buccal", {"1", "1"});
  ASSERT_FALSE(beside);
  EXPECT_EQ(beside.error().code, Error::Code::kBadValue);
  EXPECT_LE(camera_.half_height, 12);
}

// The demo arch, coarse: x to the patient's left, y backwards, z up.
class ViewsOfAnArch : public testing::Test {
 protected:
  static WorkbenchOptions in(const TemporaryFolder& folder) {
    WorkbenchOptions out;
    out.data_folder = folder.path();
    out.tools = {"round-014"};
    out.voxel_mm = 0.4;
    out.real_time = {.priority = 0, .lock_memory = false};
    return out;
  }
  void SetUp() override {
    const fs::path file = folder_.path() / "arch.ply";
    ASSERT_TRUE(writeMesh(file, demoArch({.edge_mm = 0.8})->mesh));
    bench_.sessions->open(file);
    do {
      bench_.update();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    } while (bench_.jobs->running() || (bench_.document->isOpen() && bench_.document->scene().triangleCount() == 0));
    ASSERT_TRUE(bench_.document->isOpen())
        << (bench_.notices->list().empty() ? "" : bench_.notices->list().back().text);
    fitToBox(camera_, bench_.document->scene().bounds(), context_.width, context_.height);
  }
  void TearDown() override {
    bench_.sessions->close();
    while (bench_.jobs->running()) bench_.update();
  }

  TemporaryFolder folder_;
  Workbench bench_{in(folder_)};
  Camera camera_ = *cameraFromView("top");
  AppContext context_{.bench = bench_, .camera = camera_, .width = 400, .height = 300};
  // The view of a side, for the place seen from above.
  Camera view(const char* id, const Vec3d& place) {
    camera_ = *cameraFromView("top");
    fitToBox(camera_, bench_.document->scene().bounds(), context_.width, context_.height);
    const auto pixel = pixelOf(camera_, place, context_.width, context_.height);
    const std::vector<std::string> words{std::to_string(pixel[0]), std::to_string(pixel[1])};
    EXPECT_TRUE(runAppCommand(context_, id, words)) << id;
    return camera_;
  }
};

TEST_F(ViewsOfAnArch, TheFrontIsThatOfTheIncisorsHoweverTheScanLies) {
  ASSERT_TRUE(bench_.document->occlusal().arch);
  const Vec3d front = bench_.document->occlusal().arch->front;
  for (const double turn : {0.0, 0.5, 1.0, 1.5}) {
    camera_.upright = Eigen::AngleAxisd(turn * std::numbers::pi, Vec3d::UnitZ()).toRotationMatrix();
    ASSERT_TRUE(runAppCommand(context_, "view.front"));
    EXPECT_GT(camera_.backwards().dot(front), 0.99) << turn;
    ASSERT_TRUE(runAppCommand(context_, "view.back"));
    EXPECT_LT(camera_.backwards().dot(front), -0.99) << turn;
  }
}

TEST_F(ViewsOfAnArch, EachSideOfAMolarAndOfAnIncisorIsSeenFromWhereItFaces) {
  ASSERT_TRUE(bench_.document->occlusal().arch);
  const Vec3d left_molar(20.5, 26, 0), right_molar(-20.5, 26, 0), incisor(2.5, 0.8, 0);
  const auto side = [](const Camera& c) { return Vec3d(c.backwards().x(), c.backwards().y(), 0).normalized(); };
  constexpr double kNear = 0.8;  // cosine of 37 degrees: teeth are rotated against the axes

  EXPECT_GT(side(view("view.buccal", left_molar)).x(), kNear);
  EXPECT_LT(side(view("view.buccal", right_molar)).x(), -kNear);
  EXPECT_LT(side(view("view.buccal", incisor)).y(), -kNear) << "labial";
  EXPECT_LT(side(view("view.lingual", left_molar)).x(), -kNear);
  EXPECT_GT(side(view("view.lingual", right_molar)).x(), kNear);
  EXPECT_GT(side(view("view.lingual", incisor)).y(), kNear);
  EXPECT_LT(side(view("view.mesial", left_molar)).y(), -kNear);
  EXPECT_LT(side(view("view.mesial", right_molar)).y(), -kNear);
  EXPECT_LT(side(view("view.mesial", incisor)).x(), -kNear) << "to the midline, from the left";
  EXPECT_GT(side(view("view.distal", left_molar)).y(), kNear);
  EXPECT_GT(side(view("view.distal", incisor)).x(), kNear);

  const Camera above = view("view.occlusal", left_molar);
  EXPECT_GT(above.backwards().z(), 0.99);
  EXPECT_LT(above.up().y(), -0.99) << "the front of the arch is up";
}

TEST_F(ViewsOfAnArch, WhatIsLookedAtIsInTheMiddleUprightAndNotHidden) {
  for (const char* id : {"view.buccal", "view.lingual", "view.mesial", "view.distal"})
    for (const Vec3d& place : {Vec3d(20.5, 26, 0), Vec3d(-18, 15, 0)}) {
      const Camera camera = view(id, place);
      EXPECT_NEAR(camera.target.x(), place.x(), 0.3) << id;
      EXPECT_NEAR(camera.target.y(), place.y(), 0.3) << id;
      EXPECT_LE(camera.half_height, 12);
      EXPECT_NEAR(camera.right().dot(*bench_.document->occlusal().normal), 0, 1e-9) << id;
      EXPECT_GT(camera.up().z(), 0.6) << id;

      // The other side of the arch does not hide it. The adjacent cusps may, by some mm.
      const Ray ray = rayUnder(camera, 0.5 * context_.width, 0.5 * context_.height, context_.width, context_.height);
      const auto hit = bench_.document->scene().hit(ray);
      ASSERT_TRUE(hit) << id;
      EXPECT_LT((hit->on_surface.point - camera.target).norm(), 6) << id << ' ' << place.transpose();
    }
}

TEST_F(ViewsOfAnArch, BesideTheTeethTheNearestPartOfTheArchIsMeant) {
  camera_.target = Vec3d(-4, 30, 0);  // the floor of the mouth, nearer to the right side
  camera_.half_height = 2;
  ASSERT_FALSE(bench_.document->scene().hit(rayUnder(camera_, 200, 150, 400, 300)));
  ASSERT_TRUE(runAppCommand(context_, "view.buccal"));
  EXPECT_LT(camera_.target.x(), -15);
  EXPECT_LT(camera_.backwards().x(), -0.8);
}

}  // namespace
}  // namespace kerf::tooth_views_test
