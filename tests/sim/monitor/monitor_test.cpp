#include "sim/monitor/monitor.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "geometry/tool/tool_file.h"
#include "sim/session/session.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"

namespace kerf::monitor_test {
namespace {

using test::block;
using test::oneTissue;
using test::sampleAt;

constexpr double kRadius = 0.7, kVoxel = 0.1;

Rigid3 at(double x, double y, double z, const Eigen::Quaterniond& turn = Eigen::Quaterniond::Identity()) {
  return {turn, Vec3d(x, y, z)};
}

// A tooth of 6 x 5 x 4 mm with its top at z = 0, and neighbours 2 mm away on both sides: one turned, one of another
// voxel size.
struct Row {
  LoadedObjects objects;
  std::array<Vec3d, 3> middle, half;  // of the boxes, each in its own frame
  std::array<Rigid3, 3> pose;         // of those frames

  Row() {
    const Vec3d size(6, 5, 4);
    for (int n = 0; n < 3; ++n) {
      half[static_cast<std::size_t>(n)] = size / 2;
      middle[static_cast<std::size_t>(n)] = Vec3d(0, 0, -2);
    }
    pose[0] = at(0, 0, 0);
    pose[1] = at(-8.03, 0.21, 0.13);
    pose[2] = at(8.4, -0.3, 0.3, Eigen::Quaterniond(Eigen::AngleAxisd(0.2, Vec3d(1, 2, 3).normalized())));
    const std::array voxels{kVoxel, kVoxel, 0.14};
    for (std::size_t n = 0; n < 3; ++n) objects.push_back(block(size, voxels[n], pose[n]));
  }
  // Distance of a point, mm, to box n, which `moved` has moved since loading.
  double distance(std::size_t n, const Vec3d& p, const Rigid3& moved = {}) const {
    const Vec3d q = ((moved * pose[n]).inverse() * p - middle[n]).cwiseAbs() - half[n];
    return q.cwiseMax(0).norm() + std::min(0.0, q.maxCoeff());
  }
};

Model modelOf(const LoadedObjects& objects) {
  Model model;
  model.tools.push_back(practiceBall(kRadius, 2000));
  model.tissues = oneTissue(60, 0.1, 1e3);
  model.settings.rendering = Rendering::kRigid;
  for (const auto& object : objects) EXPECT_GT(object->slots().size(), 0u);
  return model;
}

// Distance of a ball at the tip to box n, and the error bound of a monitor: half a voxel of field, the gap between two
// of its points on the ball, and a field's corners between its nodes.
struct Bound {
  double low, high;
};
Bound boundAt(double exact, double voxel, double spacing) {
  const double sagitta = spacing * spacing / (2 * kRadius);
  return {exact - 0.5 * voxel - 0.002, exact + 0.5 * voxel + 2 * sagitta};
}

TEST(Monitor, NeighboursDistanceIsRightToHalfAVoxelWhileTheToolPassesBetweenThem) {
  const Row row;
  const Model model = modelOf(row.objects);
  auto monitor = Monitor::make(row.objects, model.tools[0]);
  ASSERT_TRUE(monitor) << monitor.error().message();
  ASSERT_EQ(monitor->structures().size(), 2u);
  EXPECT_EQ(monitor->structures()[0].id, "beside_1");
  EXPECT_EQ(monitor->structures()[1].id, "beside_2");

  Session session(model, row.objects, at(0, 0, 9));
  StepOutput output;
  std::array<double, 3> least{1e9, 1e9, 1e9};
  int near = 0;

  // Through the air above all three and down on both sides of the middle one.
  for (int n = 0; n < 4000; ++n) {
    const double a = 2 * std::numbers::pi * n / 4000;
    const DeviceSample sample = sampleAt(at(5.2 * std::cos(a), 2 * std::sin(2 * a), 2.2 + 2 * std::cos(3 * a)), 0);
    session.tick(sample, output);
    monitor->tick(sample, output, session.state().objects);
    for (std::size_t b = 1; b < 3; ++b) {
      const Monitor::Structure& s = monitor->structures()[b - 1];
      const double exact = row.distance(b, output.T_world_tool * Vec3d(0, 0, kRadius)) - kRadius;
      least[b] = std::min(least[b], s.distance);
      if (exact > 4.9 || exact < -0.9) continue;
      ++near;
      const Bound bound = boundAt(exact, row.objects[b]->voxel(), monitor->spacing());
      ASSERT_GE(s.distance, bound.low) << n;
      ASSERT_LE(s.distance, bound.high) << n;
      ASSERT_FALSE(s.is_far);
    }
  }

  EXPECT_GT(near, 3000);
  for (std::size_t b = 1; b < 3; ++b) EXPECT_EQ(monitor->structures()[b - 1].least, least[b]);
}

TEST(Monitor, ANeighbourThatIsMovedIsFollowed) {
  const Row row;
  const Model model = modelOf(row.objects);
  auto monitor = Monitor::make(row.objects, model.tools[0]);
  ASSERT_TRUE(monitor) << monitor.error().message();
  Session session(model, row.objects, at(-4.6, 0, 1.2));
  StepOutput output;
  const DeviceSample sample = sampleAt(at(-4.6, 0, 1.2), 0);
  for (int n = 0; n < 60; ++n) {
    const double t = 0.05 * n;
    const Rigid3 moved = at(-t, 0.3 * t, 0.4 * t, Eigen::Quaterniond(Eigen::AngleAxisd(0.2 * t, Vec3d::UnitY())));
    const Eigen::Quaterniond& q = moved.rotation;
    const Vec3d& p = moved.translation;
    ASSERT_TRUE(session.apply(MoveObject{1, {p[0], p[1], p[2]}, {q.w(), q.x(), q.y(), q.z()}}));
    session.tick(sample, output);
    monitor->tick(sample, output, session.state().objects);
    const double exact = row.distance(1, output.T_world_tool * Vec3d(0, 0, kRadius), moved) - kRadius;
    const Bound bound = boundAt(exact, kVoxel, monitor->spacing());
    EXPECT_GE(monitor->structures()[0].distance, bound.low) << n;
    EXPECT_LE(monitor->structures()[0].distance, bound.high) << n;
    EXPECT_EQ(monitor->structures()[0].is_far, monitor->structures()[0].distance >= 5) << n;
  }
  EXPECT_GT(monitor->structures()[0].distance, monitor->structures()[0].least + 1);
}

// In the band of the baked field the error of half a voxel vanishes: this decides whether a tooth was touched.
TEST(Monitor, NearItsSurfaceANeighboursDistanceIsExactToATwentiethOfAVoxel) {
  const Row row;
  auto field = KeepOut::ofSolid(*row.objects[2]);
  ASSERT_TRUE(field) << field.error().message();
  double worst = 0;
  int near = 0;
  for (int n = 0; n < 20000; ++n) {  // along its faces, away from the edges
    const Vec3d local(2 * std::sin(0.37 * n), 1.6 * std::cos(0.23 * n), 0.25 * std::sin(1.7 * n));
    const Vec3d p = row.pose[2] * local;
    const double exact = row.distance(2, p);
    ++near;
    worst = std::max(worst, std::abs(static_cast<double>((*field)->distance(p.cast<float>())) - exact));
  }
  EXPECT_EQ(near, 20000);
  EXPECT_LE(worst, 0.05 * row.objects[2]->voxel());
}

TEST(Monitor, ANickedNeighbourIsNoFartherAwayAndWhatItLostIsCounted) {
  const Row row;
  const Model model = modelOf(row.objects);
  auto monitor = Monitor::make(row.objects, model.tools[0]);
  ASSERT_TRUE(monitor) << monitor.error().message();
  Session session(model, row.objects, at(-7, 0.2, 0.5));
  StepOutput output;
  double removed = 0;
  const auto go = [&](double x, double z, double pedal) {
    const DeviceSample sample = sampleAt(at(x, 0.2, z), pedal);
    session.tick(sample, output);
    monitor->tick(sample, output, session.state().objects);
    removed += output.removed_mm3;
  };

  for (int n = 0; n < 1500; ++n) go(-7, 0.5 - 0.0006 * n, 1);  // down into it
  const Monitor::Structure& nicked = monitor->structures()[0];
  EXPECT_GT(removed, 0.2);
  EXPECT_NEAR(nicked.removed_mm3, removed, 1e-9);
  EXPECT_EQ(monitor->structures()[1].removed_mm3, 0);
  EXPECT_GT(nicked.ticks_in, 100u);
  EXPECT_GE(nicked.ticks_touched, nicked.ticks_in);
  EXPECT_EQ(monitor->structures()[1].ticks_touched, 0u);
  EXPECT_NEAR(nicked.distance, -(0.13 - (0.5 - 0.0006 * 1499)), 0.03) << "its top stands at 0.13";

  const double deepest = nicked.least;
  EXPECT_EQ(deepest, nicked.distance);
  const std::uint64_t ticks = nicked.ticks_in;
  for (int n = 0; n < 1000; ++n) go(-7, -0.4 + 0.001 * n, 0);  // up, and back into the cut, now air
  for (int n = 0; n < 1000; ++n) go(-7, 0.6 - 0.0009 * n, 0);
  EXPECT_LT(nicked.distance, -0.3);
  EXPECT_LE(nicked.least, deepest);
  EXPECT_LE(nicked.ticks_in, ticks + 1000);
}

// A bur of 1.4 mm beside a wall that touches its shank of 1.6 mm, with any response.
TEST(Monitor, ANeighbourThatOnlyTheShankRubsIsTouchedAndNotCut) {
  const auto file = findToolFile("round-014", defaultToolFolders());
  ASSERT_TRUE(file) << file.error().message();
  const auto tool = readTool(*file);
  ASSERT_TRUE(tool) << tool.error().message();
  const LoadedObjects objects{block({3, 3, 2}, kVoxel), block({3, 3, 22}, kVoxel, at(2.4, 0, 18))};  // from x = 0.9
  for (const ResponseRow& row : kResponses) {
    Model model;
    model.tools.push_back(makeToolModel(*tool, 0.5));
    model.tissues = oneTissue(60, 0.1, 1e3);
    model.settings.response = row.response;
    auto monitor = Monitor::make(objects, model.tools[0]);
    ASSERT_TRUE(monitor) << monitor.error().message();

    Session session(model, objects, at(-0.1, 0, 0.5));
    StepOutput output;
    const auto go = [&](double x) {
      const DeviceSample sample = sampleAt(at(x, 0, 0.5));
      session.tick(sample, output);
      monitor->tick(sample, output, session.state().objects);
    };

    for (int n = 0; n < 200; ++n) go(-0.1);
    const Monitor::Structure& wall = monitor->structures()[0];
    EXPECT_EQ(wall.ticks_touched, 0u);
    for (int n = 0; n < 400; ++n) go(-0.1 + 0.0006 * n);
    EXPECT_NEAR(static_cast<double>(wall.ticks_touched), 66, 8) << "from x = 0.1 on; " << row.name;
    EXPECT_EQ(output.objects_touched, objectBit(1));
    EXPECT_EQ(wall.removed_mm3, 0);
    EXPECT_GT(wall.least, 0.02) << "the head came as near as the shank let it";
    EXPECT_LT(wall.least, 0.12);
  }
}

// A structure of pulp a millimetre below a tool that spends its power in the tissue above. Its distance is that from
// the ball's middle, where heat enters as long as no tissue is close.
TEST(Monitor, ThePulpWarmsAsBelowASteadySource) {
  Box3 box;
  box.add(Vec3d(-3, -3, -6));
  box.add(Vec3d(3, 3, 0));
  const auto pulp =
      kerf::bakedFrom([](const Vec3d& p) { return (p - Vec3d(0, 0, -3)).norm() - 3; }, box, kVoxel, Material::kPulp);
  ASSERT_TRUE(pulp) << pulp.error().message();
  const LoadedObjects objects{*pulp, block({3, 3, 2}, kVoxel, at(20, 0, 0))};
  const Model model = modelOf(objects);
  HeatSource source;
  source.share = 0.1;
  const HeatSettings settings{.coolant_rise = 0};
  Session session(model, objects, at(0, 0, 1));
  DeviceSample sample = sampleAt(at(0, 0, 1));
  sample.irrigation = 0;
  StepOutput output;
  output.T_world_tool = at(0, 0, 1);
  output.touching = 1;
  output.power = 2000;
  output.material = Material::kDentin;
  const auto riseAfter = [&](double seconds, std::size_t touched) {
    auto monitor = Monitor::make(objects, model.tools[0], source, settings);
    EXPECT_TRUE(monitor) << monitor.error().message();
    output.objects_touched = objectBit(touched);
    for (int n = 0; n < seconds / kTick; ++n) monitor->tick(sample, output, session.state().objects);
    EXPECT_NEAR(monitor->heat().riseAt({0, 0, 0}), monitor->pulpRise(), 0.05 * monitor->pulpRise());
    EXPECT_EQ(monitor->mostPulpRise(), monitor->pulpRise());
    EXPECT_GT(monitor->temperature(), 60);
    return monitor->pulpRise();
  };

  // Almost all heat is conducted: hardly any film, no chips.
  const ThermalProperties& dentin = thermalProperties(Material::kDentin);
  const double off = 1 + kRadius;
  const double exact = 0.1 * 2000 / (2 * std::numbers::pi * dentin.conductivity * off) *
                       std::erfc(off / std::sqrt(4 * dentin.diffusivity() * 20));
  EXPECT_NEAR(riseAfter(20, 0) / exact, 1, 0.05);
  EXPECT_EQ(riseAfter(2, 1), 0) << "the heat went into the neighbour";
}

TEST(Monitor, TicksWithoutAllocating) {
  const Row row;
  const Model model = modelOf(row.objects);
  auto monitor = Monitor::make(row.objects, model.tools[0]);
  ASSERT_TRUE(monitor) << monitor.error().message();
  Session session(model, row.objects, at(-5, 0, 0.5));
  StepOutput output;
  const DeviceSample sample = sampleAt(at(-5, 0, 0.5));
  session.tick(sample, output);
  output.touching = 1;
  output.objects_touched = 3;
  output.power = 1000;
  const AllocationGuard guard;
  for (int n = 0; n < 100; ++n) {
    output.T_world_tool.translation[2] -= 0.01;
    monitor->tick(sample, output, session.state().objects);
  }
}

TEST(Monitor, VoxelsOfAnySizeHaveAReach) {
  for (const double voxel : {0.02, 0.6}) {
    const LoadedObjects objects{block(Vec3d::Constant(20 * voxel), voxel), block(Vec3d::Constant(20 * voxel), voxel)};
    const auto monitor = Monitor::make(objects, practiceBall(kRadius, 1));
    EXPECT_TRUE(monitor) << monitor.error().message();
  }
}

}  // namespace
}  // namespace kerf::monitor_test
