#include "ui/app/view/piece_gizmo.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace kerf::piece_gizmo_test {
namespace {

const Vec3d kCenter(3, -2, 5);

Rigid3 some() { return {Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Vec3d(2, -1, 3).normalized())), {1, 2, 3}}; }

TEST(PieceGizmo, AnArrowMovesAlongItsAxisByWhatTheCursorGoes) {
  const auto camera = cameraFromView("30,40");
  const PieceGizmo gizmo(*camera, 800, 600, kCenter);
  for (int axis = 0; axis < 3; ++axis) {
    const Pixel tip = gizmo.arrowTip(axis), middle = 0.5 * (gizmo.center() + tip);
    ASSERT_TRUE(gizmo.handleAt(0.3 * gizmo.center() + 0.7 * tip));
    EXPECT_EQ(*gizmo.handleAt(0.1 * gizmo.center() + 0.9 * tip), static_cast<GizmoHandle>(axis));

    const Rigid3 after = gizmo.dragged(static_cast<GizmoHandle>(axis), middle, tip, some());
    const Vec3d moved = after.translation - some().translation;
    const double mm = 0.5 * PieceGizmo::kArrow * camera->mmPerPixel(600);
    EXPECT_LT((moved - mm * Vec3d::Unit(axis)).norm(), 1e-9);
    EXPECT_TRUE(after.rotation.isApprox(some().rotation));
  }
}

TEST(PieceGizmo, ARingTurnsAboutTheMiddleTheWayItIsDragged) {
  const auto camera = cameraFromView("top");
  const PieceGizmo gizmo(*camera, 800, 600, kCenter);
  const std::vector<Pixel> ring = gizmo.ring(2);
  const Pixel from = ring[6], to = ring[7];
  ASSERT_EQ(gizmo.handleAt(from), GizmoHandle::kTurnZ);
  const Rigid3 after = gizmo.dragged(GizmoHandle::kTurnZ, from, to, some());
  const Rigid3 by = after * some().inverse();
  EXPECT_LT((by * kCenter - kCenter).norm(), 1e-9) << "the middle stays";
  const Eigen::AngleAxisd turn(by.rotation);
  EXPECT_NEAR(turn.angle() * turn.axis()[2], 2 * std::numbers::pi / static_cast<double>(ring.size()), 0.005);
}

TEST(PieceGizmo, TheDiscMovesInThePicture) {
  const auto camera = cameraFromView("iso");
  const PieceGizmo gizmo(*camera, 800, 600, kCenter);
  ASSERT_EQ(gizmo.handleAt(gizmo.center()), GizmoHandle::kMoveInView);
  const Rigid3 after = gizmo.dragged(GizmoHandle::kMoveInView, {10, 10}, {60, -20}, some());
  const Vec3d moved = after.translation - some().translation;
  EXPECT_NEAR(moved.dot(camera->right()), 50 * camera->mmPerPixel(600), 1e-9);
  EXPECT_NEAR(moved.dot(camera->up()), 30 * camera->mmPerPixel(600), 1e-9);
  EXPECT_NEAR(moved.dot(camera->backwards()), 0, 1e-9);
}

TEST(PieceGizmo, InPerspectiveTheCentreIsLedToTheCursor) {
  Camera camera = *cameraFromView("30,40");
  camera.half_height = 12;
  setFieldOfView(camera, 1.0);
  const PieceGizmo gizmo(camera, 800, 600, kCenter);
  EXPECT_EQ(gizmo.handleAt(gizmo.center()), GizmoHandle::kMoveInView);

  for (int axis = 0; axis < 3; ++axis) {
    const Pixel tip = gizmo.arrowTip(axis);
    for (const double part : {-1.5, -0.3, 0.5, 2.0}) {
      const Pixel to = gizmo.center() + part * (tip - gizmo.center());
      const Rigid3 after = gizmo.dragged(static_cast<GizmoHandle>(axis), gizmo.center(), to, some());
      const Vec3d moved = after.translation - some().translation;
      EXPECT_LT((moved - moved[axis] * Vec3d::Unit(axis)).norm(), 1e-9);
      EXPECT_LT((PieceGizmo(camera, 800, 600, kCenter + moved).center() - to).norm(), 1e-6) << axis << " " << part;
    }
  }
  const Pixel aside = gizmo.center() + Pixel(120, -70);
  const Rigid3 after = gizmo.dragged(GizmoHandle::kMoveInView, gizmo.center(), aside, some());
  const Vec3d moved = after.translation - some().translation;
  EXPECT_LT((PieceGizmo(camera, 800, 600, kCenter + moved).center() - aside).norm(), 1e-6);
}

TEST(PieceGizmo, AnArrowThatPointsAtTheViewerIsNotGrabbed) {
  const PieceGizmo gizmo(*cameraFromView("top"), 800, 600, kCenter);
  EXPECT_LT((gizmo.arrowTip(2) - gizmo.center()).norm(), 1e-6);
  EXPECT_FALSE(gizmo.handleAt(gizmo.center() + Pixel(25, 25))) << "between disc, arrows and rings";
  EXPECT_FALSE(gizmo.handleAt({5, 5}));
}

}  // namespace
}  // namespace kerf::piece_gizmo_test
