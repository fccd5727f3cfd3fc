#include "sim/step/response.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>

#include "geometry/tool/tool_file.h"
#include "sim/run/files/log_sink.h"
#include "sim/run/report/replay.h"
#include "sim/step/contact_evaluation.h"
#include "sim/step/contact_points.h"
#include "tests/sim/block_scene.h"
#include "tests/support/temporary_file.h"

namespace kerf::response_test {
namespace {

using test::block;
using test::oneTissue;
using test::sampleAt;

struct Way {
  Response response;
  Rendering rendering;
};
std::string nameOf(const Way& w) {
  return std::string(rowOf(w.response).name) + (w.rendering == Rendering::kCoupled ? "Coupled" : "Direct");
}

class EachResponse : public testing::TestWithParam<Way> {
 protected:
  Model model(double friction = 0.5) const {
    Model m;
    m.tools = {practiceBall(0.5, 840)};
    m.tissues = oneTissue(200, friction, 1000);
    m.settings.response = GetParam().response;
    m.settings.rendering = GetParam().rendering;
    return m;
  }
  Attachment attachment() const { return model().settings.attachment(); }
  bool toolIsTheDevice() const { return attachment() == Attachment::kFixed; }
  bool isProxy() const { return attachment() == Attachment::kProxy; }
  // Contact points hold the tool at the surface. A response without them lets it overlap in proportion to its force.
  bool hasSkin() const { return rowOf(GetParam().response).direct != Attachment::kFixed; }
};

Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }

TEST_P(EachResponse, GivesNothingInTheAir) {
  const Model m = model();
  State state;
  state.objects.emplace_back(block({6, 6, 2}, 0.1));
  StepOutput out;
  for (int n = 0; n < 600; ++n) {
    // At rest, then to and fro, one voxel above the block.
    const double x = n < 200 ? 0 : 2 * std::sin(0.02 * (n - 200));
    step(m, state, sampleAt(at(x, 0, 0.1)), out);
    ASSERT_EQ(out.contact.force.norm(), 0) << n;
    ASSERT_EQ(out.contact.torque.norm(), 0) << n;
    ASSERT_EQ(out.normal_load, 0) << n;
    if (n < 200 || isProxy() || GetParam().rendering == Rendering::kDirect) {
      ASSERT_EQ(out.force.force.norm(), 0) << n;
      ASSERT_EQ(out.force.torque.norm(), 0) << n;
    }
  }
  EXPECT_EQ(state.objects[0].bricks().changedField().brickCount(), 0u);
}

// 0.5 m/s against a wall of 0.3 mm, ending 40 mm beyond it.
TEST_P(EachResponse, AThinWallHoldsWhateverTheHandDoes) {
  const Rigid3 wall{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vec3d(1, 0, 3).normalized())), Vec3d::Zero()};
  for (const double voxel : {0.1, 0.05}) {
    const Model m = model();
    State state;
    state.objects.emplace_back(block({8, 8, 0.3}, voxel, wall));
    StepOutput out;
    double lowest = 1e9;
    for (int n = 0; n < 400; ++n) {
      const double z = std::max(10 - 0.5 * n, -40.0);
      step(m, state, sampleAt({wall.rotation, wall * Vec3d(0, 0, z)}, 0), out);
      lowest = std::min(lowest, (wall.inverse() * out.T_world_tool.translation)[2]);
    }
    if (toolIsTheDevice()) {
      EXPECT_LT(lowest, -30);  // by definition: the tool is the device
      continue;
    }
    EXPECT_GT(lowest, -0.45) << voxel;
    if (isProxy()) {
      EXPECT_GT(lowest, -contactSkin(voxel) - 0.01) << voxel;  // nodes are up to 0.7 voxels off the axis
    }
    EXPECT_GT(out.force.force.norm(), 4) << voxel;
  }
}

TEST_P(EachResponse, AHandAMillimetreDeepIsPushedByTheCoupling) {
  if (toolIsTheDevice()) GTEST_SKIP() << "no coupling";
  for (const double voxel : {0.1, 0.05}) {
    const Model m = model();
    State state;
    state.objects.emplace_back(block({6, 6, 2}, voxel));
    StepOutput out;
    for (int n = 0; n < 1500; ++n) step(m, state, sampleAt(at(0.013, 0.027, std::max(0.2 - 0.004 * n, -1.0)), 0), out);
    const double depth = -out.T_world_tool.translation[2];
    EXPECT_NEAR(out.force.force[2], 1 - depth, 1e-4);  // 1 N/mm
    EXPECT_NEAR(out.contact.force[2], out.force.force[2], 1e-4);
    EXPECT_LT(out.force.force.head<2>().norm(), 1e-3);
    EXPECT_NEAR(out.normal_load, out.contact.force[2], 1e-3);
    if (!hasSkin()) continue;
    EXPECT_NEAR(out.force.force[2], 1, 0.02);
    EXPECT_LT(out.deepest, contactSkin(voxel) + 1e-3);
    // Error of the nearest node at the ball's lowest point: up to a voxel's half diagonal.
    EXPECT_LT(depth, contactSkin(voxel) + 0.5 * voxel * voxel / (2 * 0.5));
  }
}

TEST_P(EachResponse, SlidesSmoothlyOverABall) {
  const Vec3d center(0.013, 0.027, -5);
  const auto ball = scenes::practiceSphere(center, 5, 0.05);
  ASSERT_TRUE(ball);
  Model m = model(0);
  m.settings.coupling.force_rate = 1e6;  // the law itself
  m.settings.ramp_s = 0;
  State state;
  state.objects.emplace_back(*ball, 64);
  StepOutput out;
  const double depth = toolIsTheDevice() ? 0.055 : 1;  // about 1 N
  double jump = 0, least = 1e9, most = 0;
  Vec3d last = Vec3d::Zero();

  // Down to the depth from above, then 3 mm at 10 mm/s.
  for (int n = 0; n < 800; ++n) {
    const double down = std::min(1.0, n / 300.0), a = (-1.5 + 0.01 * std::max(n - 500, 0)) / 5;
    const Vec3d way = Vec3d(std::sin(a), 0.1 * a, std::cos(a)).normalized();
    step(m, state,
         sampleAt({Eigen::Quaterniond::Identity(), center + (5.5 - depth * down) * way - Vec3d(0, 0, 0.5)}, 0), out);
    if (n > 510) {
      jump = std::max(jump, (out.force.force - last).norm());
      least = std::min(least, out.force.force.norm());
      most = std::max(most, out.force.force.norm());
    }
    last = out.force.force;
  }

  EXPECT_GT(least, 0.8);
  EXPECT_LT(most / least, 1.05);
  EXPECT_LT(jump, 0.02);
}

TEST_P(EachResponse, CutsAsTheLawSaysTheSameBitsTwice) {
  // A ball of 0.5 mm, pushed down into the block and along it.
  const auto run = [&](double* law) {
    const Model m = model();
    State state;
    state.objects.emplace_back(block({6, 4, 3}, 0.05));
    StepOutput out;
    double removed = 0, expected = 0;
    for (int n = 0; n < 1500; ++n) {
      step(m, state, sampleAt(at(-1 + 0.002 * std::max(0, n - 500), 0.01, 0.05 - 0.001 * std::min(n, 500))), out);
      if (n > 800) {
        removed += out.removed_mm3;
        expected += 0.5 * out.normal_load * 840 / 1000 * kTick;
      }
    }
    EXPECT_EQ(state.objects[0].bricks().shellDefects(), 0u);
    EXPECT_GT(removed, 0.01);
    *law = removed / expected;
    return state.hash();
  };

  double law = 0;
  const std::uint64_t first = run(&law);
  // Impulses come in bursts, and some exceed the available overlap.
  EXPECT_NEAR(law, 1, GetParam().response == Response::kImpulse ? 0.15 : 0.05);
  EXPECT_EQ(run(&law), first);
}

TEST_P(EachResponse, ASessionIsReplayedBitForBit) {
  const auto object = block({6, 4, 2}, 0.1);
  const TemporaryFile file("session.log", "");
  std::filesystem::remove(file.path());
  auto writer = SessionLogWriter::create(file.path(), describe(Session(model(), {object}, at(-1, 0, 0.3))));
  ASSERT_TRUE(writer) << writer.error().message();
  LogSink sink(*writer);
  Session session(model(), {object}, at(-1, 0, 0.3), &sink);
  StepOutput out;
  for (int n = 0; n < 2500; ++n)
    session.tick(sampleAt(at(-1 + 0.0008 * n, 0.1, 0.3 - 0.6 * std::sin(0.004 * n)), n < 2400), out);
  session.finish();
  ASSERT_TRUE(sink.close());
  auto log = readSessionLog(file.path());
  ASSERT_TRUE(log) << log.error().message();
  Model other = model();
  other.settings = {};
  const auto again = replay(*log, "session.log", std::move(other), {object});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same) << again->differs_at;
  EXPECT_GE(again->checks, 3u);
  EXPECT_GT(again->removed_mm3, 0.01);
}

// Walls on both sides, an edge at either end: a blade 0.5 mm deep in its kerf, cut with the hand at most 2 mm beyond
// it.
TEST_P(EachResponse, ABladeCutsItsKerfAndIsHeldInIt) {
  if (toolIsTheDevice()) GTEST_SKIP() << "no coupling";
  const auto file = findToolFile("saw-reciprocating-25", defaultToolFolders());
  ASSERT_TRUE(file);
  const auto tool = readTool(*file);
  ASSERT_TRUE(tool);
  Model m = model();
  m.tools = {makeToolModel(*tool)};
  m.tissues = oneTissue(200, 0.3, 50);
  State state;
  state.objects.emplace_back(block({10, 3, 3}, 0.1));

  const Eigen::Quaterniond teeth_down = scenes::teethDown();

  StepOutput out;
  double removed = 0, law = 0, most = 0;
  for (int n = 0; n < 1600; ++n) {
    const double side = 0.5 * std::clamp((n - 1200) / 200.0, 0.0, 1.0);
    step(m, state, sampleAt({teeth_down, {-12.5, 0.01 + side, 0.2 - 0.0012 * std::min(n, 900)}}, n < 1000), out);
    removed += out.removed_mm3;
    law +=
        0.3 * m.tools[0].drive.drag_factor / m.tools[0].drive.energy_factor * out.cutting_load * out.speed / 50 * kTick;
    if (n > 400) most = std::max(most, out.normal_load);
  }

  const Vec3d tip = out.T_world_tool.translation;
  EXPECT_LT(tip[2], -0.2) << "it cut";
  EXPECT_NEAR(tip[0], -12.5, 0.1) << "along the kerf nothing holds it, and nothing drives it";
  EXPECT_NEAR(out.force.force[1], -0.5, 0.1) << "the flank holds against a hand 0.5 mm to the side";
  EXPECT_LT(std::abs(tip[1]), 0.1);
  EXPECT_NEAR(out.force.force[2], tip[2] - (0.2 - 0.0012 * 900), 0.05);
  EXPECT_NEAR(removed / law, 1, 0.12);
  EXPECT_LT(most, 10) << "walls on both sides do not press by themselves";
}

TEST(Response, IsFoundByItsNameAndOnlyByThat) {
  for (const ResponseRow& row : kResponses) EXPECT_EQ(findResponse(row.name), &rowOf(row.response)) << row.name;
  EXPECT_EQ(findResponse("god"), nullptr);
  EXPECT_EQ(findResponse(""), nullptr);
  EXPECT_TRUE(isKnown(Response::kImpulse));
  EXPECT_FALSE(isKnown(static_cast<Response>(kResponses.size())));
  EXPECT_FALSE(isKnown(static_cast<Response>(-1)));
}

TEST(Response, OnlyAToolThatMayBeFixedGoesWithAMachine) {
  StepSettings settings;
  for (const ResponseRow& row : kResponses) {
    settings.response = row.response;
    settings.rendering = Rendering::kRigid;
    if (row.response == Response::kPenalty) {
      EXPECT_TRUE(row.fits(Rendering::kRigid));
    }
    if (row.response == Response::kConstraint || row.response == Response::kImpulse) {
      EXPECT_FALSE(row.fits(Rendering::kRigid)) << row.name;
    }
    EXPECT_EQ(settings.attachment(), Attachment::kFixed) << row.name;
    EXPECT_EQ(settings.effectiveResponse(), Response::kPenalty) << row.name;

    settings.rendering = Rendering::kCoupled;
    EXPECT_NE(settings.attachment(), Attachment::kFixed) << row.name;
    EXPECT_EQ(settings.effectiveResponse(), row.response);
  }
}

TEST(Response, ALogThatDoesNotNameItIsOfThePenaltyLaw) {
  SessionLog log;
  Model m;
  m.tools = {practiceBall(0.5, 840)};
  m.tissues = oneTissue(200, 0.5, 1000);
  log.header = describe(Session(m, {block({1, 1, 1}, 0.1)}, {}));
  const auto set = [&](const char* key, const char* value) {
    for (auto& [k, v] : log.header)
      if (k == key) v = value;
  };

  Rigid3 start;
  set("response", "2");
  Model again = m;
  ASSERT_TRUE(restoreSettings(log, "a.log", again, start));
  EXPECT_EQ(again.settings.response, Response::kImpulse);
  std::erase_if(log.header, [](const auto& line) { return line.first == "response" || line.first == "restitution"; });
  ASSERT_TRUE(restoreSettings(log, "a.log", again, start));
  EXPECT_EQ(again.settings.response, Response::kPenalty);

  // Contact cannot hold back a machine's tool.
  log.header.emplace_back("response", "1");
  set("rendering", "2");
  EXPECT_FALSE(restoreSettings(log, "a.log", again, start));
  set("rendering", "0");
  set("response", std::to_string(kResponses.size()).c_str());
  EXPECT_FALSE(restoreSettings(log, "a.log", again, start));
}

// Thrown at a flat with 100 mm/s by a weak coupling.
TEST(Response, AnImpulseGivesBackWhatRestitutionSays) {
  for (const double restitution : {0.0, 0.5, 1.0}) {
    Model m;
    m.tools = {practiceBall(0.5, 840)};
    m.tissues = oneTissue(200, 0, 1000);
    m.settings.response = Response::kImpulse;
    m.settings.restitution = restitution;
    m.settings.coupling.stiffness = 1e-6;
    m.settings.coupling.damping = 0;
    State state;
    state.objects.emplace_back(block({4, 4, 2}, 0.1));
    state.place(at(0.02, 0.03, 0.5));
    state.body.velocity = Vec3d(0, 0, -100);
    StepOutput out;
    for (int n = 0; n < 10; ++n) step(m, state, sampleAt(at(0.02, 0.03, 0.5), 0), out);
    EXPECT_NEAR(state.body.velocity[2], 100 * restitution, 0.5) << restitution;
  }
}

TEST_P(EachResponse, WildHandsGetAFiniteForceWithinItsLimit) {
  const Model m = model();
  State state;
  state.objects.emplace_back(block({6, 4, 2}, 0.1), 16384);
  state.objects.emplace_back(block({2, 2, 1}, 0.05, at(0.5, 0, 1.2)), 16384);

  std::mt19937 random(7);
  std::normal_distribution<double> far;
  StepOutput out;
  DeviceSample sample;
  int touching = 0;
  for (int n = 0; n < 1500; ++n) {
    // Occasional jumps to another place and attitude; near the surface in between.
    if (n % 40 == 0) {
      sample.T_world_device.translation = Vec3d(2 * far(random), far(random), far(random));
      sample.T_world_device.rotation =
          Eigen::Quaterniond(far(random), far(random), far(random), far(random)).normalized();
    }
    sample.T_world_device.translation += 0.05 * Vec3d(far(random), far(random), far(random));
    sample.pedal = n % 3 == 0;
    step(m, state, sample, out);
    touching += out.touching > 0;
    ASSERT_TRUE(out.force.force.allFinite() && out.force.torque.allFinite()) << n;
    ASSERT_LE(out.force.force.norm(), m.settings.coupling.force_limit + 1e-9) << n;
    ASSERT_TRUE(out.T_world_tool.translation.allFinite() && std::isfinite(out.normal_load)) << n;
    ASSERT_NEAR(out.T_world_tool.rotation.norm(), 1, 1e-9) << n;
    ASSERT_GE(out.removed_mm3, 0) << n;
  }

  EXPECT_GT(touching, 100);
  for (const CutObject& object : state.objects) EXPECT_EQ(object.bricks().shellDefects(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Response, EachResponse, testing::ValuesIn([] {
                           std::vector<Way> ways;
                           for (const ResponseRow& row : kResponses)
                             for (const Rendering rendering : {Rendering::kCoupled, Rendering::kDirect})
                               ways.push_back({row.response, rendering});
                           return ways;
                         }()),
                         [](const auto& test) { return nameOf(test.param); });

TEST(Response, ErosionScaleGivesTheLoadBack) {
  const auto mean = [](double x) { return -std::expm1(-x) / x; };
  for (const double x : {1e-6, 0.01, 0.2, 1.0, 3.0, 8.0})
    for (const double load : {0.01, 0.3, 0.9}) {
      const double still = 0.7, now = still * mean(x);
      const double wanted = load * still / x;  // share of the load that would remove all overlap
      EXPECT_NEAR(relaxationRate(now, still), x, 1e-6 + 1e-6 * x);
      const double s = erosionScale(wanted, x, still);
      EXPECT_NEAR(s * still * mean(s * x) / wanted, 1, 1e-4) << x << " " << load;
    }
  EXPECT_EQ(relaxationRate(0, 0), 0);
  EXPECT_EQ(relaxationRate(0.5, 0.5), 0);
  EXPECT_EQ(erosionScale(0, 1, 1), 0);
  EXPECT_EQ(erosionScale(1, 1, 0), 0);
  EXPECT_NEAR(erosionScale(2, 0, 0.5), 4, 1e-9);  // a tool that hardly cuts
  EXPECT_LT(erosionScale(1e9, 0.7, 0.7), 10);     // some overlap must remain
}

TEST(ContactLoads, HoldAtEveryPointAndPullAtNone) {
  // Three feet on a floor, pressed down beside them; a fourth point that is far from touching.
  ContactPoints points;
  Model m;
  m.tools = {practiceBall(0.5, 840)};
  m.tissues = oneTissue(200, 0.5, 1000);
  State state;
  state.objects.emplace_back(block({4, 4, 2}, 0.1));
  state.body.pose = at(0.02, 0.03, -0.1);

  ContactInput in = contactInput(m, state, state.objects[0], kTick);
  ASSERT_TRUE(state.near.find(state.objects[0], m.tools[0], in.T_object_tool));
  points.clear();
  EXPECT_GT(points.gather(state.objects[0], 0, state.near, in), 0);
  ASSERT_GT(points.size(), 3);
  ContactLoads::Row least{};
  for (int n = 0; n < points.size(); ++n) {
    EXPECT_LT(points[n].gap, 0);
    EXPECT_GT(points[n].normal[2], 0.75);  // far from the ball's foot, half the ball's own
    if (n > 0) {
      EXPECT_GE(points[n].gap, points[n - 1].gap);
    }
    least[static_cast<std::size_t>(n)] = -points[n].gap;
  }
  EXPECT_NEAR(points[0].gap, -0.1, 0.005);

  ContactLoads loads;
  Matrix6d a = Matrix6d::Identity();
  a.diagonal().tail<3>().setConstant(1000);
  Vector6d b = Vector6d::Zero();
  b[2] = -1;
  loads.solve(a, b, points, least, 0);
  for (int n = 0; n < points.size(); ++n) {
    const auto i = static_cast<std::size_t>(n);
    EXPECT_GE(loads.loads.load[i], 0);
    EXPECT_GT(points[n].direction().dot(loads.motion()), least[i] - 1e-6);
    if (loads.loads.load[i] > 1e-9) {
      EXPECT_NEAR(points[n].direction().dot(loads.motion()), least[i], 1e-6);
    }
  }
  EXPECT_LT((a * loads.motion() - b - loads.push(points)).norm(), 1e-9);
}

}  // namespace
}  // namespace kerf::response_test
