#include "ui/app/tool/tilt.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/tool/tool_file.h"
#include "sim/run/scene/load_scene.h"
#include "sim/session/session.h"
#include "tests/sim/block_scene.h"

namespace kerf::tilt_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Tool toolOf(const char* id) {
  const auto file = findToolFile(id, defaultToolFolders());
  EXPECT_TRUE(file) << id;
  auto tool = readTool(*file);
  EXPECT_TRUE(tool) << id;
  return std::move(*tool);
}

// On the plane z = 0, upright.
ToolOverSurface standing(const Tool& tool, const Vec3d& point) {
  const Plunge plunge = plungeOf(tool);
  ToolOverSurface out;
  out.point = point;
  out.reach = plunge.reach;
  out.T_world_tool = {attitudeAlong(plunge, out.normal), point + plunge.reach * out.normal};
  return out;
}

TEST(Tilt, ADirectionInTheViewIsThatOfThePicture) {
  for (const char* const view : {"top", "front", "iso"}) {
    const Camera camera = *cameraFromView(view);
    EXPECT_NEAR((tiltInView(camera, 1, 0).towards - camera.right()).norm(), 0, 1e-12) << view;
    EXPECT_NEAR((tiltInView(camera, 1, 90 * kDegree).towards - camera.up()).norm(), 0, 1e-12) << view;
    EXPECT_NEAR(azimuthInView(camera, tiltInView(camera, 1, 2)), 2, 1e-12) << view;
  }
  EXPECT_EQ(tiltInView(Camera{}, 2, 0).angle, Tilt::kMost);
  EXPECT_EQ(tiltInView(Camera{}, -1, 0).angle, 0);
}

TEST(Tilt, APointerThatGoesToAndFroLeavesNone) {
  const Camera camera = *cameraFromView("top");
  Tilt tilt = tiltedBy({}, camera, 40, 0);
  EXPECT_NEAR(tilt.angle, 20 * kDegree, 1e-12);
  EXPECT_NEAR(azimuthInView(camera, tilt), 0, 1e-12);
  tilt = tiltedBy(tilt, camera, 0, -40);  // upwards
  EXPECT_NEAR(tilt.angle, 20 * std::sqrt(2) * kDegree, 1e-12);
  EXPECT_NEAR(azimuthInView(camera, tilt), 45 * kDegree, 1e-12);
  EXPECT_NEAR(tiltedBy(tilt, camera, -40, 40).angle, 0, 1e-9);
}

TEST(Tilt, TheAxisLeansFromTheNormalByItsAngle) {
  const Tilt tilt{30 * kDegree, Vec3d::UnitX()};
  for (const Vec3d& normal : {Vec3d(0, 0, 1), Vec3d(0.3, -0.4, 0.8).normalized(), Vec3d(1, 0, 0), Vec3d(-1, 0, 0)}) {
    const Vec3d axis = tiltedAxis(tilt, normal);
    EXPECT_NEAR(axis.norm(), 1, 1e-12);
    EXPECT_NEAR(std::acos(axis.dot(normal)), 30 * kDegree, 1e-9);
    EXPECT_GE(axis[0], normal.dot(Vec3d::UnitX()) * std::cos(tilt.angle) - 1e-9) << "towards x";
  }
}

// The middle of a ball stays above its contact point.
TEST(Tilt, ARoundBurTurnsAboutItsMiddle) {
  const Tool tool = toolOf("round-014");
  const double radius = 0.5 * tool.head_diameter_mm;
  for (const double angle : {10, 45, 75}) {
    ToolOverSurface over = standing(tool, {1, 2, 0});
    tiltTool(over, {angle * kDegree, Vec3d::UnitX()}, TouchPoints(tool));
    const Vec3d middle = over.T_world_tool * Vec3d(0, 0, radius);
    EXPECT_NEAR((middle - Vec3d(1, 2, radius)).norm(), 0, 0.01) << angle;
    EXPECT_NEAR(over.normal.dot(over.front), 0, 1e-12);
    EXPECT_NEAR((over.T_world_tool.translation + over.front - over.reach * over.normal - over.point).norm(), 0, 1e-12);
    EXPECT_NEAR(over.slant.norm(), std::tan(angle * kDegree), 1e-9);
    EXPECT_LT(over.slant[0], 0) << "it goes in away from where the shank leans";
  }
}

TEST(Tilt, WhatTouchesIsTheFarthestOfWhatCuts) {
  for (const char* const id : {"round-014", "837-012", "847-016", "us-330", "disc-22", "saw-reciprocating-25"}) {
    const Tool tool = toolOf(id);
    const TouchPoints touch(tool);
    for (const Vec3d& direction : {Vec3d(0, 0, -1), Vec3d(-1, 0, 0), Vec3d(-0.5, 0.3, -0.7).normalized()}) {
      const Vec3d at = touch.farthest(direction);
      EXPECT_NEAR(tool.cut->distance(at), 0, 0.02) << id;
      EXPECT_GT(tool.cut->distance(at + 0.05 * direction), 0.03) << id;
    }
  }
}

// A held button, in lockstep: the tool's deepest point stops at the depth, and the tool entered along its axis.
class TiltedStroke {
 public:
  TiltedStroke(const Tool& tool, double angle, double force)
      : tool_(tool), touch_(tool), block_(*practiceBlock({8, 8, 3}, 0.1, {}, Material::kDentin)) {
    ToolOverSurface over = standing(tool, {0.02, 0.03, 0});
    tiltTool(over, {angle, Vec3d::UnitX()}, touch_);
    const Stroke stroke(block_->phi0(), over, {});
    start_ = stroke.start();

    auto model = makeModel(std::span(&tool, 1));
    EXPECT_TRUE(model);
    const CouplingSettings& coupling = model->settings.coupling;
    hand_.emplace(std::shared_ptr<const BrickField>(block_, &block_->phi0()), start_, coupling);
    session_.emplace(std::move(*model), std::vector{block_}, start_);
    out_.T_world_tool = start_;
    stroke.begin(aim_);
    aim_.force = force;
    hand_->aim(aim_);
    const Eigen::Quaterniond& q = start_.rotation;
    const Vec3d& at = start_.translation;
    EXPECT_TRUE(session_->apply(PlaceTool{{at[0], at[1], at[2]}, {q.w(), q.x(), q.y(), q.z()}}));
    hand_->placed(session_->state().body.pose);
  }
  void depth(double mm) {
    aim_.depth = mm;
    hand_->aim(aim_);
  }
  void run(double seconds) {
    for (int n = 0; n < seconds / kTick; ++n) {
      const DeviceSample sample = hand_->read();
      session_->tick(sample, out_);
      hand_->write(out_.force);
      deepest_ = std::max(deepest_, depthNow());
      most_force_ = std::max(most_force_, out_.force.force.norm());
    }
  }
  double depthNow() const {
    const Rigid3& pose = out_.T_world_tool;
    return -(pose * touch_.farthest(pose.rotation.conjugate() * -Vec3d::UnitZ()))[2];
  }
  double deepest() const { return deepest_; }
  double mostForce() const { return most_force_; }
  // Displacement of the touching point since contact, mm.
  Vec3d way() const { return out_.T_world_tool.translation - start_.translation; }

 private:
  const Tool& tool_;
  TouchPoints touch_;
  std::shared_ptr<const BakedObject> block_;
  Rigid3 start_;
  std::optional<MouseHand> hand_;
  std::optional<Session> session_;
  MouseAim aim_;
  StepOutput out_;
  double deepest_ = -1, most_force_ = 0;
};

TEST(Tilt, AHeldButtonStopsATiltedToolAtTheDepthAndItGoesInAlongItsAxis) {
  for (const char* const id : {"round-014", "856-016", "837-012", "us-330", "disc-22", "saw-reciprocating-25"})
    for (const double angle : {30, 60}) {
      const Tool tool = toolOf(id);
      TiltedStroke stroke(tool, angle * kDegree, 1);
      stroke.depth(0.5);
      stroke.run(4);
      const std::string what = fmt::format("{}, {} degrees", id, angle);
      EXPECT_LE(stroke.deepest(), 0.55) << what;
      EXPECT_GE(stroke.depthNow(), 0.45) << what;
      EXPECT_NEAR(stroke.way()[0], -std::tan(angle * kDegree) * stroke.depthNow(), 0.14) << what;
      EXPECT_LE(stroke.mostForce(), 1.3) << what << ": it presses no harder than it was told to";
    }
}

TEST(Tilt, NeitherMuchForceNorMuchTiltPassesTheDepth) {
  for (const char* const id : {"round-014", "837-012", "disc-22"}) {
    const Tool tool = toolOf(id);
    TiltedStroke stroke(tool, Tilt::kMost, 8);
    stroke.depth(0.5);
    stroke.run(4);
    EXPECT_LE(stroke.deepest(), 0.55) << id;
    EXPECT_GE(stroke.deepest(), 0.2) << id;
    EXPECT_LE(stroke.mostForce(), 9) << id;
  }
}

}  // namespace
}  // namespace kerf::tilt_test
