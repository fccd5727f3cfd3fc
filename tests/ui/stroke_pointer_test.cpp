#include "ui/app/stroke_pointer.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/temporary_folder.h"

namespace kerf {
namespace {

class StrokePointerTest : public testing::Test {
 protected:
  TemporaryFolder folder_;
  static WorkbenchOptions in(const TemporaryFolder& folder) {
    WorkbenchOptions out;
    out.data_folder = folder.path();
    out.tools = {"round-014"};
    return out;
  }
  Workbench bench_{in(folder_)};
  Camera camera_ = *cameraFromView("top");
  AppContext context_{.bench = bench_, .camera = camera_, .width = 400, .height = 300};
  StrokePointer pointer_;
  static constexpr double kDegree = std::numbers::pi / 180;
};

TEST_F(StrokePointerTest, AltKeepsTheToolWhereItIsAndTiltsIt) {
  pointer_.move(context_, {200, 150}, {});
  EXPECT_TRUE(bench_.tilt.isUpright());
  pointer_.move(context_, {260, 150}, {.alt = true});
  EXPECT_EQ(pointer_.at(), Pixel(200, 150));
  EXPECT_NEAR(bench_.tilt.angle, 30 * kDegree, 1e-9);
  EXPECT_NEAR((bench_.tilt.towards - camera_.right()).norm(), 0, 1e-9);

  pointer_.move(context_, {261, 150}, {});
  EXPECT_EQ(pointer_.at(), Pixel(261, 150));
  EXPECT_NEAR(bench_.tilt.angle, 30 * kDegree, 1e-9) << "it holds";
}

TEST_F(StrokePointerTest, TwoTapsOnAltSetItUprightUnlessItWasTiltedBetween) {
  pointer_.move(context_, {0, 0}, {});
  pointer_.tapAlt(context_, 1);
  pointer_.move(context_, {60, 0}, {.alt = true});
  pointer_.tapAlt(context_, 1.2);
  EXPECT_FALSE(bench_.tilt.isUpright());
  pointer_.tapAlt(context_, 3);
  EXPECT_FALSE(bench_.tilt.isUpright()) << "too late";
  pointer_.tapAlt(context_, 3.2);
  EXPECT_TRUE(bench_.tilt.isUpright());
}

}  // namespace
}  // namespace kerf
