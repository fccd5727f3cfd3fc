// The core of a tool: positions and support of its points, and no effect elsewhere.
#include "sim/step/core_contact.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <vector>

#include "bench/scenes/sink.h"
#include "geometry/tool/tool_file.h"
#include "sim/step/contact_evaluation.h"
#include "sim/step/tool_core.h"
#include "tests/sim/block_scene.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/places.h"

namespace kerf::core_contact_test {
namespace {

using scenes::SinkScene;

ToolModel toolOfRack(const std::string& id) {
  const auto tool = readTool(std::filesystem::path(kSourceFolder) / "assets/tools" / (id + ".toml"));
  EXPECT_TRUE(tool) << tool.error().message();
  return makeToolModel(*tool);
}

Model modelOf(const ToolModel& tool, double stiffness = 200) {
  Model model;
  model.tools = {tool};
  model.tissues = scenes::oneTissue(stiffness, 0.3, 1000);
  return model;
}

SinkScene pushedBy(double hand_mm, double height = 4, double voxel = 0.1) {
  SinkScene scene;
  scene.object = test::block({5, 5, height}, voxel);
  scene.hand_mm = hand_mm;
  return scene;
}

// --- positions of the points ---

TEST(ToolCore, ABallHasItsMiddleForTheLowestPoint) {
  const ToolModel ball = practiceBall(0.5, 840);
  ASSERT_FALSE(ball.core.empty());
  EXPECT_NEAR(ball.core.front().place[2], 0.5, 0.03);
  EXPECT_NEAR(ball.core.front().radius, 0.5, 0.03);
  EXPECT_TRUE(ball.core.front().cuts);
}

TEST(ToolCore, EveryBallLiesInsideItsTool) {
  for (const char* id : {"859-012", "round-005", "drill-20", "disc-22", "saw-piezo-050", "saw-sagittal-10", "us-699"}) {
    const ToolModel tool = toolOfRack(id);
    ASSERT_FALSE(tool.core.empty()) << id;
    for (const CorePoint& point : tool.core) {
      float tau = tool.cut.distance(point.place);
      if (!tool.body.isEmpty()) tau = std::min(tau, tool.body.distance(point.place));
      EXPECT_NEAR(-tau, point.radius, 1e-6) << id;
    }
  }
}

TEST(ToolCore, NoGapAlongAnAxisIsWiderThanHalfOfAThinWall) {
  const ToolModel needle = toolOfRack("859-012");
  for (std::size_t n = 1; n < needle.core.size() && !needle.core[n].is_thin; ++n)
    EXPECT_LT((needle.core[n].place - needle.core[n - 1].place).norm(), 0.151f) << n;
  EXPECT_LT(needle.core.front().place[2], 0.2f);
  EXPECT_GE(needle.core.front().radius, static_cast<float>(kThinnestCore));
}

TEST(ToolCore, ADiscAndABladeAreHeldByTheirRims) {
  const auto farthest = [](const ToolModel& tool, const Vec3f& way) {
    float most = -1e9f;
    for (const CorePoint& point : tool.core) most = std::max(most, way.dot(point.place));
    return most;
  };
  const ToolModel disc = toolOfRack("disc-22");
  EXPECT_NEAR(farthest(disc, Vec3f::UnitX()), 11, 0.2);
  const ToolModel blade = toolOfRack("saw-reciprocating-25");
  EXPECT_NEAR(farthest(blade, -Vec3f::UnitX()), -blade.cut.bounds().min[0], 0.35);
  EXPECT_NEAR(farthest(blade, -Vec3f::UnitZ()), -blade.cut.bounds().min[2], 0.35);
}

// --- support by the points ---

TEST(CoreContact, ANeedleStandsOnEnamelWithTheForceOfItsHand) {
  const Model model = modelOf(toolOfRack("859-012"));
  const scenes::Sink still = sink(model, 0, pushedBy(8));
  EXPECT_LT(still.deepest, 0.25);
  EXPECT_GT(still.force, 7.5);
  EXPECT_LT(still.fall, 0.05);

  Model without = model;
  without.tools[0].core.clear();
  EXPECT_GT(sink(without, 0, pushedBy(8)).deepest, 2);  // the scene requires the core
}

TEST(CoreContact, TheHandFeelsNoFallOfForceButOnceTheToolHasTouched) {
  SinkScene scene = pushedBy(4);
  const Model model = modelOf(toolOfRack("round-014"));
  EXPECT_LT(sink(model, 0, scene).fall, 0.01);  // 0.07 N set the tool in motion in air, and vanish before contact

  Model without = modelOf(toolOfRack("859-012"));
  without.tools[0].core.clear();
  EXPECT_GT(sink(without, 0, scene).fall, 0.05);
}

// A cone with a flat end of 0.6 mm, whose shell carries less as its rim goes deeper, and a point thinner than two
// voxels: their cores have to take over in time.
TEST(CoreContact, ASlowHandFeelsNoToolGiveWay) {
  for (const auto& [id, voxel] : {std::pair("847-012", 0.05), std::pair("863-012", 0.1)})
    for (const double lean : {0.0, 0.21}) {
      Model model = modelOf(toolOfRack(id));
      model.settings.ramp_s = 0;  // a rising force would hide a falling one
      SinkScene scene = pushedBy(8, 4, voxel);
      scene.speed = 4;
      scene.lean = lean;
      EXPECT_LT(sink(model, 0, scene).fall, 0.05) << id << " " << voxel << " " << lean;
    }
}

// At the end of the object's band, the nodes around a point hold it. In the middle of an oblique cell the nearest node
// is 0.87 voxels farther out: beyond the band, while the point is within it.
TEST(CoreContact, AtTheEndOfTheBandAPointIsHeldInTheMiddleOfACellToo) {
  constexpr double kVoxel = 0.05;
  const Rigid3 frame = scenes::turned(0.9553, {-1, 1, 0}, {0.01, 0.02, 0});  // its normal along (1, 1, 1)
  const Model model = modelOf(toolOfRack("847-012"));
  const CorePoint lowest = model.tools[0].core.front();
  ASSERT_GT(0.4 * double(lowest.radius), 2.3 * kVoxel);  // the band bounds it
  State state;
  state.objects.emplace_back(test::block({5, 4, 3}, kVoxel, frame), 16);

  int held = 0, all = 0;
  for (int x = -20; x < 20; ++x)
    for (int y = -20; y < 20; ++y)
      for (int z = -20; z < 20; ++z) {
        const Vec3d middle = frame.inverse() * Vec3d(kVoxel * (Vec3d(x, y, z) + Vec3d::Constant(0.5 + 1e-6)));
        if (middle[2] < 2.17 * kVoxel || middle[2] > 2.28 * kVoxel) continue;  // outside the surface
        state.body.pose = frame * Rigid3{Eigen::Quaterniond::Identity(), middle - lowest.place.cast<double>()};
        CoreContact core;
        state.objects[0].is_core_clear = true;
        core.gather(state.objects[0], 0, contactInput(model, state, state.objects[0], kTick), 0);
        held += !core.isEmpty();
        ++all;
      }
  EXPECT_GT(all, 0);
  EXPECT_EQ(held, all);
}

// --- thin parts: points, edges, fins ---

// A solid as a mesh without symmetry.
class AsMesh final : public ToolShape {
 public:
  AsMesh(std::function<double(const Vec3d&)> distance, const Box3& box) : distance_(std::move(distance)), box_(box) {}
  double distance(const Vec3d& p) const noexcept override { return distance_(p); }
  Box3 bounds() const override { return box_; }
  bool isConvex() const override { return false; }

 private:
  std::function<double(const Vec3d&)> distance_;
  Box3 box_;
};

RevolvedShape cone(double half_angle) {
  return RevolvedShape(RevolvedProfile().lineTo(6 * std::tan(half_angle), 6).close());
}

// An edge along y of 1.5 mm.
AsMesh chisel(double half_angle) {
  const double c = std::cos(half_angle), s = std::sin(half_angle);
  const auto distance = [=](const Vec3d& p) {
    return std::max({std::abs(p[0]) * c - p[2] * s, std::abs(p[1]) - 0.75, p[2] - 5});
  };
  return {distance, {{-5 * s / c, -0.75, 0}, {5 * s / c, 0.75, 5}}};
}

// Three fins about the axis, under a shank.
AsMesh fins(double thickness) {
  const BoxShape fin({{0, -0.5 * thickness, 0}, {1, 0.5 * thickness, 4}}), shank({{-0.5, -0.5, 3.5}, {0.5, 0.5, 5}});
  const auto distance = [=](const Vec3d& p) {
    double out = shank.distance(p);
    for (int n = 0; n < 3; ++n)
      out = std::min(out, fin.distance(Eigen::AngleAxisd(2.0944 * n + 0.3, Vec3d::UnitZ()) * p));
    return out;
  };
  return {distance, {{-1, -1, 0}, {1, 1, 5}}};
}

ToolModel modelOfShape(const ToolShape& shape) {
  ToolModel out = practiceBall(0.5, 840);
  out.cut = ToolField(shape);
  out.core = makeToolCore(out.cut, {}, shape.symmetry(), 0);
  out.reach_mm = out.cut.reach();
  out.finest_mm = 0.05;
  return out;
}

struct ThinTool {
  const char* name;
  ToolModel tool;
};
std::vector<ThinTool> thinTools() {
  const RevolvedShape needle = cone(0.07), point = cone(0.26);
  const AsMesh explorer([&](const Vec3d& p) { return needle.distance(p); }, needle.bounds());
  std::vector<ThinTool> out{{"cone of 8 deg", modelOfShape(needle)},
                            {"cone of 30 deg", modelOfShape(point)},
                            {"explorer of a mesh", modelOfShape(explorer)},
                            {"chisel of 20 deg", modelOfShape(chisel(0.175))}};
  for (const double thickness : {0.05, 0.12, 0.2, 0.3}) out.push_back({"fins", modelOfShape(fins(thickness))});
  return out;
}

TEST(CoreContact, WhatIsThinHoldsAtRestInHardTissueOverAllVoxels) {
  for (const ThinTool& thin : thinTools())
    for (const double voxel : {0.05, 0.1, 0.15})
      for (const double lean : {0.0, 0.2}) {
        Model model = modelOf(thin.tool);
        model.settings.ramp_s = 0;  // a rising force would hide a falling one
        SinkScene scene = pushedBy(3.4, 3, voxel);
        scene.speed = 4;
        scene.lean = lean;
        const scenes::Sink got = sink(model, 0, scene);
        const std::string what = fmt::format("{}, voxels {}, lean {}", thin.name, voxel, lean);
        EXPECT_LT(got.deepest, 0.2) << what;
        EXPECT_GT(got.force, 3) << what;
        EXPECT_LT(got.fall, 0.05) << what;
      }
}

TEST(CoreContact, ABallHasNoThinPoint) {
  std::size_t balls = 0;
  for (const ToolListing& listed : listTools(defaultToolFolders())) {
    if (!listed.tool || !listed.tool->id.starts_with("round-")) continue;
    const ToolModel model = makeToolModel(*listed.tool);
    EXPECT_TRUE(std::none_of(model.core.begin(), model.core.end(), [](const CorePoint& p) { return p.is_thin; }))
        << listed.tool->id;
    ++balls;
  }
  EXPECT_GT(balls, 8u);
}

// A motor runs down for half a minute.
TEST(CoreContact, WhatIsThinHoldsAMotorThatHardlyTurns) {
  Model model = modelOf(thinTools()[1].tool);
  SinkScene scene = pushedBy(3.4, 3);
  scene.turns = 0.01;
  EXPECT_LT(sink(model, 0, scene).deepest, 0.2);
}

TEST(CoreContact, WhatIsThinCutsAsBeforeWhileItRuns) {
  Model model = modelOf(thinTools()[1].tool), without = model;
  std::erase_if(without.tools[0].core, [](const CorePoint& point) { return point.is_thin; });
  ASSERT_LT(without.tools[0].core.size(), model.tools[0].core.size());
  const scenes::Dig with_them = dig(model, 0, pushedBy(0, 3), 2, 0.1), none = dig(without, 0, pushedBy(0, 3), 2, 0.1);
  EXPECT_EQ(with_them.removed, none.removed);
  EXPECT_GT(with_them.removed, 0.001);
}

TEST(CoreContact, AThinWallIsNotPassedByATapOfAMetrePerSecond) {
  for (const char* id : {"859-012", "round-005", "us-699", "disc-22"}) {
    const Model model = modelOf(toolOfRack(id));
    SinkScene scene = pushedBy(2, 0.3);
    scene.speed = 1000;
    if (std::string_view(id) == "disc-22") scene.first = -Vec3d::UnitX();
    EXPECT_LT(sink(model, 0, scene).deepest, 0.5) << id;
  }
}

TEST(CoreContact, SoftTissueLetsItIn) {
  const ToolModel needle = toolOfRack("859-012");
  const double hard = sink(modelOf(needle), 0, pushedBy(2)).deepest;
  const double soft = sink(modelOf(needle, 2), 0, pushedBy(2)).deepest;
  EXPECT_GT(soft, 2 * hard);
}

TEST(CoreContact, SoftTissueStopsAToolAtRestAndSaysSoOverAllVoxels) {
  for (const double stiffness : {1.0, 20.0})
    for (const char* id : {"round-014", "837-012", "847-012", "859-012"})
      for (const double voxel : {0.05, 0.1, 0.15})
        for (const double height : {4.0, 1.0}) {
          Model model = modelOf(toolOfRack(id), stiffness);
          model.settings.ramp_s = 0;  // a rising force would hide a falling one
          const double width = 2 * double(model.tools[0].core.front().radius);
          const scenes::Sink got = sink(model, 0, pushedBy(8, height, voxel));
          const std::string what = fmt::format("{} in {} N/mm3, {} mm high, voxels {}", id, stiffness, height, voxel);
          EXPECT_LT(got.deepest, 0.4 + width) << what;
          EXPECT_GT(got.force, 7) << what;
          // A flat end: its surface covers the second row of points.
          EXPECT_LT(got.fall, std::string_view(id) == "837-012" ? 0.4 : 0.05) << what;
          EXPECT_EQ(got.untold, 0) << what;
        }
}

TEST(CoreContact, AnOrdinaryToolUnderAnOrdinaryLoadDoesNotKnowOfIt) {
  const Model model = modelOf(toolOfRack("round-014"));
  Model without = model;
  without.tools[0].core.clear();
  const SinkScene scene = pushedBy(4);
  EXPECT_EQ(sink(model, 0, scene).state, sink(without, 0, scene).state);
}

TEST(CoreContact, WhatAThinToolRemovesIsPaidForByItsWork) {
  const Model model = modelOf(toolOfRack("round-005"));
  const scenes::Dig dug = dig(model, 0, pushedBy(0, 4, 0.05), 3, 0.15);
  const double paid = dug.work / 1000 / model.tools[0].drive.energy_factor;
  EXPECT_GT(dug.removed, 0.01);
  EXPECT_GT(dug.removed / paid, 0.95);
  EXPECT_LT(dug.removed / paid, 1.25);

  Model without = model;
  without.tools[0].core.clear();
  const scenes::Dig fell = dig(without, 0, pushedBy(0, 4, 0.05), 3, 0.15);
  EXPECT_LT(fell.removed, 0.1 * dug.removed);  // it fell through and cut nothing
}

TEST(CoreContact, AMachineIsNotHeld) {
  Model model = modelOf(toolOfRack("859-012"));
  model.settings.rendering = Rendering::kRigid;
  EXPECT_NEAR(sink(model, 0, pushedBy(2)).deepest, 2, 1e-9);
}

// As after an undo, an addition of material, or a move of an object onto the tool.
TEST(CoreContact, AToolThatFindsItselfInsideIsNotShotOut) {
  // Distance travelled from 1 mm below the surface in 0.3 s, at the hand's rest position.
  const auto wayOut = [](const ToolModel& tool, bool was_outside) {
    const Model model = modelOf(tool);
    const Rigid3 inside{Eigen::Quaterniond::Identity(), {0.02, 0.03, -1}};
    State state;
    state.objects.emplace_back(pushedBy(0).object, 64);
    state.place(inside);
    state.objects[0].is_core_clear = was_outside;
    StepOutput out;
    for (int n = 0; n < 300; ++n) {
      step(model, state, scenes::sampleAt(inside, 0), out);
      EXPECT_TRUE(out.T_world_tool.isUsable() && out.force.force.allFinite());
    }
    return (out.T_world_tool.translation - inside.translation).norm();
  };

  for (const char* id : {"859-012", "round-005"}) {
    const ToolModel tool = toolOfRack(id);
    EXPECT_LT(wayOut(tool, false), 0.2) << id;
    EXPECT_GT(wayOut(tool, true), 0.5) << id;  // the ejection that the law prevents
  }
}

TEST(CoreContact, ItAllocatesNothing) {
  const Model model = modelOf(toolOfRack("859-012"));
  const SinkScene scene = pushedBy(4);
  State state;
  state.objects.emplace_back(scene.object, 64);
  state.place({Eigen::Quaterniond::Identity(), {0, 0, 0.05}});
  StepOutput out;
  {
    const AllocationGuard guard;
    for (int n = 0; n < 300; ++n)
      step(model, state, scenes::sampleAt({Eigen::Quaterniond::Identity(), {0, 0, 0.05 - 0.01 * n}}, 0), out);
  }
  EXPECT_GT(state.objects[0].core_load, 1);
  EXPECT_FALSE(state.core_drag.isZero());

  // Another tool, or another place, resets it.
  state.place({Eigen::Quaterniond::Identity(), {0, 0, 5}});
  EXPECT_EQ(state.objects[0].core_load, 0);
  EXPECT_TRUE(state.core_drag.isZero());
}

// --- the loads ---

TEST(OneSidedLoads, OneSoftSpringHasItsFormula) {
  const double mass = 2e-5, dt = 1e-3, stiffness = 300, overlap = 0.05, coming = -40;
  const Matrix6d a = mass * Matrix6d::Identity();
  Vector6d b = Vector6d::Zero();
  b[2] = mass * coming;
  OneSidedLoads loads;
  OneSidedLoads::Row least{}, softness{};
  least[0] = overlap / dt;
  softness[0] = 1 / (dt * dt * stiffness);
  const Vector6d up = Vector6d::Unit(2);
  loads.solve(a, b, std::span(&up, 1), least, softness);
  const double expected = dt * stiffness * (overlap - dt * coming) / (1 + dt * dt * stiffness / mass);
  EXPECT_NEAR(loads.load[0], expected, 1e-12);
  EXPECT_NEAR(loads.motion[2], coming + expected / mass, 1e-9);

  // Separating fast enough: no load.
  b[2] = mass * 60;
  OneSidedLoads away;
  away.solve(a, b, std::span(&up, 1), least, softness);
  EXPECT_EQ(away.load[0], 0);
}

}  // namespace
}  // namespace kerf::core_contact_test
