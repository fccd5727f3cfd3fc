#include "ui/app/view/camera.h"
#include "ui/app/commands/zoom.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "ui/app/commands/pointing.h"

namespace kerf::camera_test {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(Camera, NamedViewsLookFromTheSideTheyName) {
  const std::pair<const char*, Vec3d> sides[] = {{"front", {0, -1, 0}}, {"back", {0, 1, 0}}, {"left", {-1, 0, 0}},
                                                 {"right", {1, 0, 0}},  {"top", {0, 0, 1}},  {"occlusal", {0, 0, 1}},
                                                 {"bottom", {0, 0, -1}}};
  for (const auto& [name, side] : sides) {
    const auto camera = cameraFromView(name);
    ASSERT_TRUE(camera) << name;
    EXPECT_NEAR((camera->backwards() - side).norm(), 0, 1e-12) << name;
  }
  EXPECT_NEAR((cameraFromView("front")->right() - Vec3d::UnitX()).norm(), 0, 1e-12);
  EXPECT_NEAR((cameraFromView("top")->up() - Vec3d::UnitY()).norm(), 0, 1e-12);
}

TEST(Camera, FrameIsRightHandedAndUpright) {
  for (double azimuth = -3; azimuth < 3; azimuth += 0.7)
    for (double elevation = -1.5; elevation < 1.5; elevation += 0.6) {
      const Camera camera{.azimuth = azimuth, .elevation = elevation};
      const Eigen::Matrix3d m = camera.rotation();
      EXPECT_NEAR((m * m.transpose() - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
      EXPECT_NEAR(m.determinant(), 1, 1e-12);
      EXPECT_GT(camera.up().z(), 0);
    }
}

TEST(Camera, AnySideCanBeUp) {
  for (const char* name : {"+x", "-x", "+y", "-y", "+z", "-z"}) {
    const auto side = axisFromName(name);
    ASSERT_TRUE(side) << name;
    EXPECT_EQ(nameOfAxis(*side), name);
    const Eigen::Matrix3d m = uprightFrame(*side);
    EXPECT_EQ(m * m.transpose(), Eigen::Matrix3d::Identity()) << name;
    EXPECT_EQ(m.determinant(), 1) << name;
    EXPECT_EQ(m * *side, Vec3d::UnitZ()) << name;
    EXPECT_EQ(uprightFrame(*side + 0.4 * Vec3d(0.3, -0.8, 0.5)), m) << name;

    Camera top = *cameraFromView("top");
    top.upright = m;
    EXPECT_NEAR((top.backwards() - *side).norm(), 0, 1e-12) << name;
    Camera front = *cameraFromView("front");
    front.upright = m;
    EXPECT_NEAR((front.up() - *side).norm(), 0, 1e-12) << name;
    for (const Vec3d& from : {Vec3d(0.3, -0.8, 0.5), Vec3d(-1, 0.2, 0.1), *side}) {
      lookFrom(front, from);
      EXPECT_NEAR((front.backwards() - from.normalized()).norm(), 0, 1e-12) << name;
    }
  }
  EXPECT_EQ(uprightFrame(Vec3d::UnitZ()), Eigen::Matrix3d::Identity());
  EXPECT_EQ(axisFromName("y"), Vec3d::UnitY());
  for (const char* bad : {"", "+", "w", "+xy", "x+", "--z"}) EXPECT_FALSE(axisFromName(bad)) << bad;
}

TEST(Camera, WhatIsUprightStandsUprightFromAnySide) {
  const Vec3d up = Vec3d(0.2, -0.1, 1).normalized();
  for (const char* name : {"+z", "-x", "+y"})
    for (const Vec3d& from : {Vec3d(0.3, -0.8, 0.5), Vec3d(-1, 0.2, 0.1), Vec3d(0, 0, 1), Vec3d(0, 0, -1)}) {
      Camera camera;
      camera.upright = uprightFrame(*axisFromName(name));
      lookFrom(camera, from, up);
      EXPECT_NEAR((camera.backwards() - from.normalized()).norm(), 0, 1e-9) << name;
      EXPECT_NEAR(camera.right().dot(up), 0, 1e-9) << name << " leans in the picture";
      EXPECT_GT(camera.up().dot(up), 0) << name;
    }
  Camera level;
  lookFrom(level, Vec3d(0, -1, 0.3), Vec3d::UnitZ());
  EXPECT_EQ(level.roll, 0);
}

TEST(Camera, AnglesAreReadInDegrees) {
  const auto camera = cameraFromView("35,-20.5");
  ASSERT_TRUE(camera);
  EXPECT_NEAR(camera->azimuth, 35 * kPi / 180, 1e-12);
  EXPECT_NEAR(camera->elevation, -20.5 * kPi / 180, 1e-12);
}

TEST(Camera, UnknownViewIsAnErrorThatListsTheNames) {
  for (const char* bad : {"sideways", "", "1,2,3", "10,91", "nan,0", "1e999,0", "10;20", ","}) {
    const auto camera = cameraFromView(bad);
    ASSERT_FALSE(camera) << bad;
    for (const NamedView& view : namedViews())
      EXPECT_NE(camera.error().message().find(view.name), std::string::npos) << bad;
  }
}

TEST(Camera, FitShowsAllOfTheMeshAndNoMore) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back({100.0 + 10 * (i & 1), -50.0 + 4 * ((i >> 1) & 1), 7.0 + 2 * (i >> 2)});
  for (const char* view : {"front", "top", "iso", "70,-12"}) {
    Camera camera = *cameraFromView(view);
    fitTo(camera, mesh, 300, 200, 0.1);
    double widest = 0, highest = 0;
    for (const Vec3d& p : mesh.vertices) {
      const Vec3d q = camera.rotation() * (p - camera.target);
      widest = std::max(widest, std::abs(q.x()) / (camera.half_height * 1.5));
      highest = std::max(highest, std::abs(q.y()) / camera.half_height);
    }
    EXPECT_NEAR(std::max(widest, highest), 0.8, 1e-9) << view;
  }
}

TEST(Camera, EmptyAndPointMeshesGetAField) {
  Camera camera;
  fitTo(camera, {}, 100, 100);
  EXPECT_GT(camera.half_height, 0);
  Mesh point;
  point.vertices = {{1, 2, 3}};
  fitTo(camera, point, 100, 100);
  EXPECT_GT(camera.half_height, 0);
  EXPECT_NEAR((camera.target - Vec3d(1, 2, 3)).norm(), 0, 1e-12);
}

// Place of a point in a picture of 800 x 600.
std::array<double, 2> at(const Camera& camera, const Vec3d& p) { return pixelOf(camera, p, 800, 600); }

// The grabbed point stays under the cursor at any rotation of the view.
TEST(Camera, TurnsAboutWhatIsUnderTheCursor) {
  for (const double field : {0.0, 30.0})
    for (const double roll : {0.0, 0.7}) {
      Camera camera = *cameraFromView("35,20");
      camera.target = {3, -2, 5};
      camera.half_height = 12;
      camera.roll = roll;
      setFieldOfView(camera, field * std::numbers::pi / 180);
      const Vec3d pivot(6, 1, 9);
      const auto before = at(camera, pivot);
      const Eigen::Matrix3d was = camera.rotation();
      for (int n = 0; n < 40; ++n) orbitAbout(camera, pivot, 7, -3);
      EXPECT_NEAR(at(camera, pivot)[0], before[0], 1e-6) << field << " " << roll;
      EXPECT_NEAR(at(camera, pivot)[1], before[1], 1e-6) << field << " " << roll;
      EXPECT_GT((camera.rotation() - was).norm(), 0.1);
    }
}

Camera perspective(double degrees) {
  Camera camera{.azimuth = 0.6, .elevation = 0.4, .target = {1, 2, 3}, .half_height = 12};
  setFieldOfView(camera, degrees * kPi / 180);
  return camera;
}

TEST(Camera, InPerspectiveWhatIsNearerIsLargerAndTheFocusIsAsItWas) {
  for (const double degrees : {10, 30, 90}) {
    const Camera camera = perspective(degrees);
    Camera parallel = camera;
    setFieldOfView(parallel, 0);
    const Vec3d beside = camera.target + 3 * camera.right() + 2 * camera.up();
    EXPECT_NEAR(at(camera, beside)[0], at(parallel, beside)[0], 1e-9) << "at the focus";
    EXPECT_NEAR(at(camera, beside)[1], at(parallel, beside)[1], 1e-9);

    // Half-way to the eye everything is twice as large.
    const Vec3d nearer = beside + 0.5 * camera.eyeDistance() * camera.backwards();
    EXPECT_NEAR(at(camera, nearer)[0] - 400, 2 * (at(camera, beside)[0] - 400), 1e-9);
    EXPECT_NEAR(camera.mmPerPixelAt(nearer, 600), 0.5 * camera.mmPerPixel(600), 1e-12);
    EXPECT_NEAR(2 * std::atan(camera.half_height / camera.eyeDistance()), degrees * kPi / 180, 1e-12);
  }
}

TEST(Camera, ARayMeetsEveryPointOfItsPixelInBothProjections) {
  for (const double degrees : {0, 5, 30, 90}) {
    const Camera camera = perspective(degrees);
    for (const Vec3d& p : {Vec3d(4, -1, 2), Vec3d(-3, 6, 8), Vec3d(1, 2, 3)}) {
      const auto pixel = at(camera, p);
      const Ray ray = rayUnder(camera, pixel[0], pixel[1], 800, 600);
      EXPECT_NEAR(ray.direction.cross(p - ray.origin).norm(), 0, 1e-9) << degrees;
      EXPECT_GT(ray.direction.dot(p - ray.origin), 0) << degrees;
      EXPECT_NEAR((ray.direction + camera.towardsViewer(p)).norm(), 0, 1e-9) << degrees;
    }
  }
}

TEST(Camera, FocusMovesAndThePictureStays) {
  Camera camera = perspective(40);
  const Vec3d eye = camera.target + camera.eyeDistance() * camera.backwards();
  const Vec3d p(4, -1, 2), other(-3, 6, 8);
  const auto before = at(camera, p), beside = at(camera, other);
  focusOn(camera, p);
  EXPECT_NEAR(camera.shrinkAt(p), 1, 1e-12);
  EXPECT_NEAR((camera.target + camera.eyeDistance() * camera.backwards() - eye).norm(), 0, 1e-9);
  EXPECT_NEAR(at(camera, p)[0], before[0], 1e-9);
  EXPECT_NEAR(at(camera, other)[1], beside[1], 1e-9);
}

TEST(Camera, FitShowsAllInPerspectiveToo) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.push_back({100.0 + 10 * (i & 1), -50.0 + 4 * ((i >> 1) & 1), 7.0 + 22 * (i >> 2)});
  for (const char* view : {"front", "top", "iso", "70,-12"}) {
    Camera camera = *cameraFromView(view);
    setFieldOfView(camera, 1.2);
    fitTo(camera, mesh, 300, 200, 0.1);
    double farthest = 0;
    for (const Vec3d& p : mesh.vertices) {
      EXPECT_GT(camera.shrinkAt(p), Camera::kNearest) << view;
      const auto pixel = pixelOf(camera, p, 300, 200);
      farthest = std::max({farthest, std::abs(pixel[0] - 150) / 150, std::abs(pixel[1] - 100) / 100});
    }
    EXPECT_LE(farthest, 0.8 + 1e-9) << view;
    EXPECT_GT(farthest, 0.7) << view;
  }
}

TEST(Camera, RollTurnsThePictureAndDragsFollowIt) {
  Camera camera{.azimuth = 0.6, .elevation = 0.4, .target = {1, 2, 3}, .half_height = 12};
  const Vec3d up = camera.up(), p = camera.target + 5 * up;
  camera.roll = kPi / 2;
  EXPECT_NEAR(at(camera, p)[0], 400 + 5 / camera.mmPerPixel(600), 1e-9) << "clockwise: what was up is at the right";
  EXPECT_NEAR(at(camera, p)[1], 300, 1e-9);
  EXPECT_NEAR((camera.rotation() * camera.rotation().transpose() - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);

  // A point in front of the target follows the cursor, rotated or not.
  for (const double roll : {0.0, 0.7, kPi / 2, -2.0}) {
    Camera turned = camera;
    turned.roll = roll;
    const Vec3d near = turned.target + 5 * turned.backwards();
    orbit(turned, 4, 0);
    EXPECT_GT(at(turned, near)[0], 401) << roll;
    EXPECT_NEAR(at(turned, near)[1], 300, 1.5) << roll;
  }
}

TEST(Camera, PanKeepsThePointUnderTheCursor) {
  Camera camera{.azimuth = 0.6, .elevation = 0.4, .target = {1, 2, 3}, .half_height = 12};
  const Vec3d point(4, -1, 2);
  const auto pixel = [&] { return Vec3d(camera.rotation() * (point - camera.target) / camera.mmPerPixel(600)); };
  const Vec3d before = pixel();
  pan(camera, 31, -17, 600);
  EXPECT_NEAR(pixel().x() - before.x(), 31, 1e-9);
  EXPECT_NEAR(pixel().y() - before.y(), 17, 1e-9);  // view y is upwards
}

TEST(Camera, OrbitStopsAtThePoles) {
  Camera camera;
  orbit(camera, 0, 1000);
  EXPECT_NEAR(camera.elevation, kPi / 2, 1e-12);
  orbit(camera, 0, -2000);
  EXPECT_NEAR(camera.elevation, -kPi / 2, 1e-12);
}

TEST(Camera, ScaleBarIsARoundLengthUpToAQuarter) {
  EXPECT_DOUBLE_EQ(scaleBarLength(0.02, 1200), 5);   // a quarter is 6 mm
  EXPECT_DOUBLE_EQ(scaleBarLength(0.016, 1200), 2);  // 4.8 mm
  EXPECT_DOUBLE_EQ(scaleBarLength(0.005, 1200), 1);  // 1.5 mm
  EXPECT_DOUBLE_EQ(scaleBarLength(0.0005, 1200), 0.1);
}

}  // namespace
}  // namespace kerf::camera_test
