#include "sim/hand/mouse_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "geometry/tool/sweep.h"
#include "geometry/tool/tool_file.h"
#include "sim/run/scene/load_scene.h"
#include "sim/session/session.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/slice.h"

namespace kerf::mouse_hand_test {
namespace {

constexpr double kSpeed = 12500, kFriction = 0.3;  // of the ball's surface, mm/s

// Removes `mm3_per_n` a second.
Model ball(double radius, double mm3_per_n) {
  Model model;
  model.tools = {practiceBall(radius, kSpeed)};
  model.tissues = test::oneTissue(200, kFriction, kFriction * kSpeed / mm3_per_n);
  return model;
}

Rigid3 upright(const Vec3d& tip) { return {Eigen::Quaterniond::Identity(), tip}; }

// A mouse on an object, in lockstep, as on the haptic thread.
class Desk {
 public:
  Desk(Model model, std::shared_ptr<const BakedObject> object)
      : object_(std::move(object)),
        hand_(std::shared_ptr<const BrickField>(object_, &object_->phi0()), upright({0, 0, 3})),
        session_(std::move(model), {object_}, upright({0, 0, 3})) {
    out.T_world_tool = upright({0, 0, 3});
  }

  void press(const Vec3d& at, double force, double depth) { press(at, force, depth, -Vec3d::UnitZ(), 0); }
  /// @param plunge, reach  of the tool, in its frame.
  void press(const Vec3d& at, double force, double depth, const Vec3d& plunge, double reach) {
    ++aim_.stroke;
    aim_.is_pressed = true;
    aim_.anchor = aim_.pointer = at;
    aim_.force = force;
    aim_.depth = depth;
    hand_.aim(aim_);
    aim_.reach = reach;
    hand_.aim(aim_);
    const Vec3d start = at + Vec3d(0, 0, 0.3 + reach);
    Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(plunge, -Vec3d::UnitZ());
    if (is_saw) q = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3d::UnitZ()) * q;
    EXPECT_TRUE(session_.apply(PlaceTool{{start[0], start[1], start[2]}, {q.w(), q.x(), q.y(), q.z()}}));
    hand_.placed(session_.state().body.pose);
  }
  void guide(const Vec3d& normal) { aim_.guide = normal; }
  void keep(std::shared_ptr<const Structures> structures, double mm, const ToolSamples& samples) {
    hand_.keepAwayFrom(std::move(structures));
    aim_.keep = mm;
    aim_.samples = &samples;
  }
  void point(const Vec3d& at) {
    aim_.pointer = at;
    hand_.aim(aim_);
  }
  void release() {
    aim_.is_pressed = false;
    hand_.aim(aim_);
  }
  template <class Look>
  void run(double seconds, const Look& look) {
    for (int n = 0; n < seconds / kTick; ++n) {
      sample = hand_.read();
      session_.tick(sample, out);
      hand_.write(out.force);
      removed += out.removed_mm3;
      work += out.power * kTick;
      look();
    }
  }
  void run(double seconds) {
    run(seconds, [] {});
  }
  Vec3d tip() const { return out.T_world_tool.translation; }
  MouseHand& hand() { return hand_; }
  const MouseAim& aim() const { return aim_; }
  const CutObject& object() const { return session_.state().objects[0]; }
  const BakedObject& baked() const { return *object_; }

  bool is_saw = false;  // its blade square to x
  DeviceSample sample;
  StepOutput out;
  double removed = 0, work = 0;

 private:
  std::shared_ptr<const BakedObject> object_;
  MouseHand hand_;
  Session session_;
  MouseAim aim_;
};

// From the tip to the foremost point, mm.
double reachOf(const Tool& tool) {
  double reach = 0;
  const Box3 box = tool.cut->bounds();
  for (int n = 0; n < 8; ++n) reach = std::max(reach, box.corner(n).dot(tool.plunge_direction));
  return reach;
}

std::shared_ptr<const BakedObject> someBlock() { return test::block({6, 4, 3}, 0.1); }

// A hill with a slope of up to 30 degrees: the part of a ball of 6 mm about (0, 0, -6).
std::shared_ptr<const BakedObject> hill() {
  Box3 box;
  box.add(Vec3d(-6.5, -6.5, -12.5));
  box.add(Vec3d(6.5, 6.5, 0.5));
  return test::bakedFrom([](const Vec3d& p) { return (p - Vec3d(0, 0, -6)).norm() - 6; }, box, 0.1);
}

TEST(MouseHand, AHeldButtonStopsAtTheDepthAndNeverPassesIt) {
  for (const double force : {0.3, 1.0, 5.0, 8.0})
    for (const double depth : {0.0, 0.2, 0.5, 1.0}) {
      Desk desk(ball(0.5, 2), someBlock());
      desk.press({0.02, 0.03, 0}, force, depth);
      double deepest = 0;
      desk.run(4, [&] { deepest = std::max(deepest, -desk.tip()[2]); });
      EXPECT_LE(deepest, depth + 0.03) << force << " N";
      EXPECT_GE(deepest, depth - 0.03) << force << " N";
    }
}

// Every tool of the rack with its own drive, in soft and hard tissue.
TEST(MouseHand, NoToolOfTheRackPassesTheDepth) {
  double worst = -1;
  int reached = 0, runs = 0;
  test::Slice slice(5);
  for (const ToolListing& listed : listTools(defaultToolFolders())) {
    ASSERT_TRUE(listed.tool) << listed.file;
    const Tool& tool = *listed.tool;
    const double reach = reachOf(tool);
    for (const Material material : {Material::kCaries, Material::kEnamel}) {
      auto block = practiceBlock({8, 6, 3}, 0.1, {}, material);
      ASSERT_TRUE(block);
      auto model = makeModel(std::span(&tool, 1));
      ASSERT_TRUE(model) << model.error().message();
      for (const double force : {1.0, 8.0}) {
        if (!slice.has()) continue;
        Desk desk(*model, *block);
        desk.press({0.02, 0.03, 0}, force, 0.5, tool.plunge_direction, reach);
        double deepest = 0;
        desk.run(1.5, [&] { deepest = std::max(deepest, reach - desk.tip()[2]); });
        worst = std::max(worst, deepest - 0.5);
        reached += deepest > 0.4;
        ++runs;
        EXPECT_LE(deepest, 0.53) << tool.id << ", " << force << " N, material " << static_cast<int>(material);
      }
    }
  }
  EXPECT_LE(worst, 0.03) << "mm";
  EXPECT_GE(reached, runs / 2) << "they did cut";
}

// Largest distance of the hole beyond a tool that went straight down `axis` to `depth`, mm.
double beyondStraightHole(const Desk& desk, const Tool& tool, const Vec3d& at, double reach, double depth) {
  const BrickField& before = desk.baked().phi0();
  const BrickField after = desk.object().bricks().field();
  const Eigen::Quaterniond q = desk.out.T_world_tool.rotation;
  const SweptTool straight(*tool.cut, {q, at + Vec3d(0, 0, reach)}, {q, at + Vec3d(0, 0, reach - depth)});
  const double h = before.voxel();
  const int side = static_cast<int>(2.9 / h), down = static_cast<int>((depth + 0.3) / h);
  double out = 0;
  for (int z = -down; z < 0; ++z)
    for (int y = -side; y <= side; ++y)
      for (int x = -side; x <= side; ++x) {
        const Vec3i node(x, y, z);
        const double phi = after.at(node);
        if (!(before.at(node) < 0 && phi > 0)) continue;
        const double off = straight.distance(h * node.cast<double>(), 3, 1e-3);
        if (off > 0) out = std::max(out, off + std::min(phi, h));
      }
  return out;
}

// Drag deflects the push of a slow tip, and a bur on a soft hand walks around its hole: 0.7 mm in enamel.
TEST(MouseHand, AHeldButtonDrillsAHoleAsWideAsTheBurInAllThatIsHard) {
  const Vec3d at(0.02, 0.03, 0);
  int runs = 0;
  test::Slice slice(7);
  for (const ToolListing& listed : listTools(defaultToolFolders())) {
    ASSERT_TRUE(listed.tool) << listed.file;
    const Tool& tool = *listed.tool;
    if (motionOf(tool) != ToolMotion::kSpin || tool.cut->bounds().size()[0] > 4) continue;
    const double reach = reachOf(tool);
    for (const Material material : {Material::kEnamel, Material::kDentin, Material::kCaries}) {
      if (!slice.has()) continue;
      auto block = practiceBlock({6, 6, 4}, 0.1, {}, material);
      ASSERT_TRUE(block);
      auto model = makeModel(std::span(&tool, 1));
      ASSERT_TRUE(model) << model.error().message();
      const std::string what = tool.id + ", material " + std::to_string(static_cast<int>(material));
      Desk desk(*model, *block);
      desk.press(at, 1, 2, tool.plunge_direction, reach);
      double deepest = 0, along = 0, removed = 0, work = 0;
      int pressed = 0, ticks = 0;
      desk.run(6, [&] {
        deepest = std::max(deepest, reach - desk.tip()[2]);
        if (deepest > 1.9) return;  // it rubs at the depth limit
        removed = desk.removed;
        work = desk.work;
        if (++ticks < 500) return;
        along += desk.out.force.force[2];
        ++pressed;
      });
      EXPECT_LE(beyondStraightHole(desk, tool, at, reach, deepest), 0.05) << what;
      if (pressed > 500) {
        EXPECT_NEAR(along / pressed, 1, 0.05) << what;
      }
      const double price = model->tools[0].drive.energy_factor /
                           static_cast<double>(model->tissues[static_cast<std::size_t>(material)].inverse_energy);
      const bool rubs_with_its_side = tool.id.starts_with("us-95");  // end-cutting burs
      if (!isDrill(tool) && !rubs_with_its_side && removed > 0.02) {
        EXPECT_NEAR(removed * price / work, 1, 0.1) << what;
      }
      ++runs;
    }
  }
  EXPECT_GT(runs, 20);
}

// It is a compliant hand: pushed off its place, it gives way.
TEST(MouseHand, TheFingerRestPushesNoHarderThanTwiceTheForce) {
  const auto block = someBlock();
  MouseHand hand(std::shared_ptr<const BrickField>(block, &block->phi0()), upright({0, 0, 1}));
  MouseAim aim;
  aim.is_pressed = true;
  aim.force = 1;
  hand.aim(aim);
  hand.placed(upright({0, 0, 0.3}));
  DeviceSample sample;
  for (int n = 0; n < 1000; ++n) {  // against a wall 5 mm from its place
    sample = hand.read();
    hand.write({Vec3d(5 - sample.T_world_device.translation[0], 0, 0), Vec3d::Zero()});
  }
  EXPECT_NEAR(sample.T_world_device.translation[0], -2, 0.01);
}

TEST(MouseHand, WhatIsHeldRemovesWhatTheLawSays) {
  for (const double force : {0.2, 1.0, 2.0}) {
    Desk desk(ball(0.8, 0.1), someBlock());
    desk.press({0.02, 0.03, 0}, force, 2.5);
    desk.run(1);  // from the air
    const double before = desk.removed;
    double along = 0, normal = 0;
    desk.run(5, [&] {
      along += desk.out.force.force[2] / 5000;
      normal += desk.out.normal_load / 5000;
    });
    EXPECT_NEAR(along / force, 1, 0.02) << force << " N";
    EXPECT_NEAR((desk.removed - before) / (5 * 0.1 * normal), 1, 0.05) << force << " N";
  }
}

TEST(MouseHand, AGrooveFollowsTheSurfaceAsItWasLoaded) {
  for (const double depth : {0.3, 1.0}) {
    Desk desk(ball(0.5, 4), hill());
    const auto surface = [](double x) { return std::sqrt(36 - x * x) - 6; };
    desk.press({-3, 0, surface(-3)}, 1.5, depth);
    desk.run(3);
    double worst = 0, most_left = 0;
    // Back and forth: the second pass runs over cut tissue.
    for (int n = 0; n <= 120; ++n) {
      const double x = n <= 60 ? -3 + 0.1 * n : 3 - 0.1 * (n - 60);
      desk.point({x, 0, surface(x)});
      desk.run(0.1, [&] {
        const double deep = surface(desk.tip()[0]) - desk.tip()[2];
        worst = std::max(worst, deep - depth);
        if (n > 70) most_left = std::max(most_left, depth - deep);
      });
    }
    EXPECT_LE(worst, 0.1) << depth;
    EXPECT_LE(most_left, 0.1) << depth;
  }
}

TEST(MouseHand, WithoutTheButtonItLiftsAndTheSpindleStops) {
  Desk desk(ball(0.5, 2), someBlock());
  desk.press({0, 0, 0}, 1, 0.5);
  desk.run(2);
  EXPECT_EQ(desk.sample.pedal, 1);
  desk.release();
  desk.run(0.5);
  EXPECT_EQ(desk.sample.pedal, 0);
  EXPECT_NEAR(desk.tip()[2], MouseHand::kClearance, 0.1);
}

TEST(MouseHand, AnAimWaitsUntilTheToolIsPlaced) {
  Desk desk(ball(0.5, 2), someBlock());
  MouseAim early = desk.aim();
  early.stroke = 1;
  early.is_pressed = true;
  desk.hand().aim(early);
  desk.run(0.5);
  EXPECT_EQ(desk.sample.pedal, 0);
  EXPECT_EQ(desk.removed, 0);
}

TEST(MouseHand, BesideTheEdgeItDoesNotPlungeDown) {
  Desk desk(ball(0.5, 2), someBlock());
  desk.press({2.5, 0, 0}, 2, 0.5);
  desk.run(1);
  desk.point({5, 0, 0});  // 2 mm beyond the edge
  desk.run(3);
  EXPECT_GE(desk.tip()[2], -1.7);
  EXPECT_NEAR(desk.tip()[0], 5, 0.1);
}

TEST(MouseHand, NeitherForceNorSpeedIsEverLarge) {
  Desk desk(ball(0.5, 0.1), someBlock());
  desk.press({-2, 0, 0}, 1, 0.5);
  double force = 0, way = 0;
  Vec3d before = desk.tip();
  bool is_first = true;
  int n = 0;
  desk.run(4, [&] {
    if (++n % 300 == 0) desk.point({n % 600 == 0 ? -2.0 : 2.0, n % 900 == 0 ? 1.0 : -1.0, 0});  // a fast mouse
    force = std::max(force, desk.out.force.force.norm());
    if (!std::exchange(is_first, false)) way = std::max(way, (desk.tip() - before).norm());
    before = desk.tip();
  });
  EXPECT_LT(force, 2.5);
  EXPECT_LT(way, 0.05);
}

// Under a wild mouse, a saw stays in the plane of its guide.
TEST(MouseHand, AGuideKeepsASawInItsPlane) {
  const auto file = findToolFile("saw-sagittal-10", defaultToolFolders());
  ASSERT_TRUE(file);
  const auto tool = readTool(*file);
  ASSERT_TRUE(tool);
  for (const bool is_guided : {true, false}) {
    Desk desk(*makeModel(std::span(&*tool, 1)), test::block({3, 14, 3}, 0.1));
    desk.is_saw = true;
    desk.guide(is_guided ? Vec3d(Vec3d::UnitX()) : Vec3d(Vec3d::Zero()));
    desk.press({0, 0, 0}, 4, 1.5, tool->plunge_direction, 0);
    double aside = 0, tilt = 0, along = 0;
    int n = 0;
    std::optional<Eigen::Quaterniond> attitude;
    desk.run(8, [&] {
      if (++n % 500 == 0) desk.point({n % 1000 == 0 ? 3.0 : -3.0, n % 1500 == 0 ? 1.0 : -1.0, 0});
      aside = std::max(aside, std::abs(desk.tip()[0]));
      along = std::max(along, std::abs(desk.tip()[1]));
      if (!attitude) attitude = desk.out.T_world_tool.rotation;
      tilt = std::max(tilt, desk.out.T_world_tool.rotation.angularDistance(*attitude));
    });
    EXPECT_GT(desk.removed, 0.3);
    if (is_guided) {
      EXPECT_LE(aside, 0.05) << "mm";
      EXPECT_LE(tilt, 0.011) << "rad: its flanks push back";
      EXPECT_GE(along, 0.2) << "within the plane it follows";
    } else {
      EXPECT_GT(aside, 0.1) << "mm: free-hand it is pulled out";
    }
  }
}

TEST(MouseHand, ReadsWithoutAllocating) {
  const auto block = someBlock();
  MouseHand hand(std::shared_ptr<const BrickField>(block, &block->phi0()), upright({0, 0, 1}));
  const AllocationGuard guard;
  hand.placed(upright({0, 0, 0.3}));
  for (int n = 0; n < 1000; ++n) {
    MouseAim aim;
    aim.is_pressed = true;
    aim.pointer = {0.001 * n, 0, 0};
    hand.aim(aim);
    hand.read();
    hand.write({{0, 0, 0.5}, {0, 0, 0}});
  }
}

// ---- Short of kept structures

// Pulp of that shape, in the frame of the block.
std::shared_ptr<const Structures> pulp(const std::function<double(const Vec3d&)>& distance, const Box3& box) {
  const auto baked = bakedFrom(distance, box, 0.1, Material::kPulp);
  EXPECT_TRUE(baked) << baked.error().message();
  const auto made = Structures::of(**baked);
  EXPECT_TRUE(made) << made.error().message();
  return *made;
}

Box3 boxOf(const Vec3d& low, const Vec3d& high) {
  Box3 out;
  out.add(low);
  out.add(high);
  return out;
}

constexpr double kShort = 0.5, kPassed = 0.05;  // mm

// Distance of a tool to a ball of 1 mm, by points of the ball.
double toBall(const Tool& tool, const Rigid3& T_world_tool, const Vec3d& center) {
  constexpr int kPoints = 300;
  const Rigid3 to_tool = T_world_tool.inverse();
  double out = 9;
  for (int n = 0; n < kPoints; ++n) {
    const double z = 1 - (2.0 * n + 1) / kPoints, r = std::sqrt(1 - z * z), turn = 2.399963 * n;
    out = std::min(out, tool.cut->distance(to_tool * (center + Vec3d(r * std::cos(turn), r * std::sin(turn), z))));
  }
  return out;
}

TEST(MouseHand, NoToolOfTheRackPassesWhatIsKept) {
  constexpr double kLabels = 0.06;  // mm: a labelled node stands for its voxel of 0.1 mm
  const Vec3d center(0, 0, -2.2);
  const auto kept = pulp([&](const Vec3d& p) { return (p - center).norm() - 1; }, boxOf({-1, -1, -3.2}, {1, 1, -1.2}));
  int reached = 0, runs = 0;
  test::Slice slice(5);
  for (const ToolListing& listed : listTools(defaultToolFolders())) {
    ASSERT_TRUE(listed.tool) << listed.file;
    const Tool& tool = *listed.tool;
    const double reach = reachOf(tool);
    auto model = makeModel(std::span(&tool, 1));
    ASSERT_TRUE(model) << model.error().message();
    const ToolSamples samples(model->tools[0].cut, kToolSamples);
    for (const Material material : {Material::kCaries, Material::kEnamel})
      for (const double force : {1.0, 8.0}) {
        if (!slice.has()) continue;
        auto block = practiceBlock({8, 6, 3}, 0.1, {}, material);
        ASSERT_TRUE(block);
        Desk desk(*model, *block);
        desk.keep(kept, kShort, samples);
        desk.press({0.02, 0.03, 0}, force, 5, tool.plunge_direction, reach);
        double least = 9, to_ball = 9;
        int ticks = 0;
        desk.run(1.2, [&] {
          const auto near = kept->nearest(samples, desk.out.T_world_tool).reading;
          if (!near.is_far) least = std::min(least, near.distance);
          if (++ticks % 40 == 0) to_ball = std::min(to_ball, toBall(tool, desk.out.T_world_tool, center));
        });
        EXPECT_GE(to_ball, kShort - kPassed - kLabels) << tool.id << ", " << force << " N";
        EXPECT_GE(least, kShort - kPassed) << tool.id << ", " << force << " N, " << static_cast<int>(material);
        reached += least < kShort + kPassed;
        ++runs;
      }
  }
  EXPECT_GE(reached, runs / 3) << "they did go there";
}

TEST(MouseHand, AlongWhatIsKeptTheToolGoesOnTowardsItItStops) {
  const auto kept = pulp([](const Vec3d& p) { return std::max(std::abs(p[0] - 2) - 0.3, std::abs(p[2] + 1) - 0.9); },
                         boxOf({1.7, -3, -1.9}, {2.3, 3, -0.1}));
  Desk desk(ball(0.5, 2), someBlock());
  const ToolSamples samples(ball(0.5, 2).tools[0].cut, kToolSamples);
  desk.keep(kept, kShort, samples);
  desk.press({-1, -1, 0}, 2, 0.5);
  double least = 9;
  const auto look = [&] { least = std::min(least, kept->nearest(samples, desk.out.T_world_tool).reading.distance); };
  desk.run(1, look);
  desk.point({2, -1, 0});
  desk.run(3, look);
  EXPECT_GE(least, kShort - kPassed);
  EXPECT_LE(least, kShort + 2 * kPassed) << "it went there";

  desk.point({2, 1, 0});
  desk.run(3, look);
  EXPECT_GE(least, kShort - kPassed);
  EXPECT_NEAR(desk.tip()[1], 1, 0.1) << "beside it there is nothing to stop for";

  desk.point({-1, 1, 0});
  desk.run(2, look);
  EXPECT_NEAR(desk.tip()[0], -1, 0.1) << "away it goes";
}

TEST(MouseHand, KeepingAllocatesNothing) {
  const auto kept =
      pulp([](const Vec3d& p) { return (p - Vec3d(0, 0, -1.5)).norm() - 0.5; }, boxOf({-1, -1, -2}, {1, 1, -1}));
  Desk desk(ball(0.5, 2), someBlock());
  const ToolSamples samples(ball(0.5, 2).tools[0].cut, kToolSamples);
  desk.keep(kept, kShort, samples);
  desk.press({0, 0, 0}, 2, 5);
  desk.run(1);
  const AllocationGuard guard;
  for (int n = 0; n < 100; ++n) (void)desk.hand().read();
}

}  // namespace
}  // namespace kerf::mouse_hand_test
