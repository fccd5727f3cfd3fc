// Mouse strokes on a tooth: a groove along a fissure of the demo molar, a held button, the removal at one newton.
//
// The full path from the cursor's pixel to the field, in lockstep: ray, stroke, MouseHand, the step. The tests compare
// the remaining field with the loaded one: on lines along the stroke's axis, the distance from the first loaded tissue
// to the first remaining tissue. That is the depth set by a person, and the depth of a probe.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "geometry/tool/tool_file.h"
#include "preprocess/demo/demo_molar.h"
#include "sim/live/remesher.h"
#include "sim/run/scene/load_scene.h"
#include "sim/run/session/live_run.h"
#include "sim/session/session.h"
#include "tests/sim/block_scene.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/tool/stroke.h"
#include "ui/app/view/live_scene.h"

namespace kerf::fissure_test {
namespace {

using Vec2d = Eigen::Vector2d;

constexpr double kVoxel = 0.1;                // mm
constexpr int kWidth = 800, kHeight = 600;    // of the picture, pixels
constexpr double kFissure = 2.9;              // mm, of onFissure()
constexpr double kStep = 0.1, kToStep = 0.1;  // a cursor at 1 mm a second: mm, s

// The chewing surface of the demo molar, 5 mm of the crown below it.
std::shared_ptr<const BakedObject> chewingSurface() {
  Box3 box;
  box.add(Vec3d(-4.6, -3.2, 2.4));
  box.add(Vec3d(4.6, 3.2, 8));
  const Vec3d middle = box.center(), half = 0.5 * box.size() - Vec3d::Constant(4 * kVoxel);
  const auto distance = [&](const Vec3d& p) {
    const double block = scenes::boxDistance(p, middle, half);
    return block > 1 ? block : std::max(block, demoMolarDistance(p));
  };
  auto baked = bakedFrom(distance, box, kVoxel, Material::kEnamel);
  EXPECT_TRUE(baked) << baked.error().message();
  return *baked;
}

// A path along the central fissure, from the mesial to the distal end of its middle part: x, y.
Vec2d onFissure(double part) {
  const Vec2d ends[] = {{1.4, -0.45}, {0.15, -0.05}, {-1.4, -0.45}};
  const double at = 2 * std::clamp(part, 0.0, 1.0);
  return at < 1 ? Vec2d(ends[0] + at * (ends[1] - ends[0])) : Vec2d(ends[1] + (at - 1) * (ends[2] - ends[1]));
}

// A person at the mouse with a view of the tooth from above, and the window behind it.
class Chair {
 public:
  Chair(Model model, const Tool& tool, std::shared_ptr<const BakedObject> tooth)
      : tooth_(std::move(tooth)),
        plunge_(plungeOf(tool)),
        head_(headOf(tool)),
        hand_(std::shared_ptr<const BrickField>(tooth_, &tooth_->phi0()), kAway, model.settings.coupling),
        session_(std::move(model), {tooth_}, kAway) {
    camera_.target = {0, -0.2, 6};
    camera_.half_height = 4;
    const Remesher surface(tooth_->phi0(), {.is_parallel = false});
    scene_.update(std::vector<ObjectChunks>{{1, surface.changedSince(0)}}, {});
    aim_.irrigation = 1;
  }

  // Above that place of the tooth, mm.
  bool press(const Vec2d& at, double force, double depth) {
    const auto over = toolOver(scene_, tooth_->phi0(), rayAt(at), plunge_);
    if (!over) return false;
    stroke_.emplace(tooth_->phi0(), *over, head_);
    stroke_->begin(aim_);
    aim_.force = force;
    aim_.depth = depth;
    hand_.aim(aim_);
    const Rigid3& start = stroke_->start();
    const Eigen::Quaterniond& q = start.rotation;
    const Vec3d& p = start.translation;
    EXPECT_TRUE(session_.apply(PlaceTool{{p[0], p[1], p[2]}, {q.w(), q.x(), q.y(), q.z()}}));
    hand_.placed(session_.state().body.pose);
    return true;
  }
  void drag(const Vec2d& to) {
    aim_.pointer = stroke_->pointerOf(rayAt(to));
    hand_.aim(aim_);
  }
  void limit(double depth) {
    aim_.depth = depth;
    hand_.aim(aim_);
  }
  template <class Look>
  void run(double seconds, const Look& look) {
    const auto ticks = static_cast<int>(std::lround(seconds / kTick));
    for (int n = 0; n < ticks; ++n) {
      session_.tick(hand_.read(), out);
      hand_.write(out.force);
      removed += out.removed_mm3;
      look();
    }
  }
  void run(double seconds) {
    run(seconds, [] {});
  }

  const Vec3d& axis() const { return stroke_->axis(); }
  const BrickField& loaded() const { return tooth_->phi0(); }
  BrickField left() { return scenes::currentField(session_.object(0)); }
  // On the loaded surface, under the place.
  Vec3d surfaceAt(const Vec2d& at) const { return stroke_->pointerOf(rayAt(at)); }
  // The tool's foremost point.
  Vec3d front() const { return out.T_world_tool * Vec3d(plunge_.reach * plunge_.direction); }
  // Its depth below the loaded surface, along the axis.
  std::optional<double> depth() const { return depthBelow(loaded(), front(), axis()); }

  StepOutput out;
  double removed = 0;  // mm^3

 private:
  static inline const Rigid3 kAway{Eigen::Quaterniond::Identity(), {0, 0, 14}};

  static Mesh headOf(const Tool& tool) {
    Mesh head;
    for (const Vec3d& v : toolMesh(tool, 0.05).vertices)
      if (v[2] < 4) head.vertices.push_back(v);
    return head;
  }
  // Through the pixel, like the cursor's ray.
  Ray rayAt(const Vec2d& place) const {
    const auto pixel = pixelOf(camera_, {place[0], place[1], camera_.target[2]}, kWidth, kHeight);
    return rayUnder(camera_, pixel[0], pixel[1], kWidth, kHeight);
  }

  std::shared_ptr<const BakedObject> tooth_;
  Plunge plunge_;
  Mesh head_;
  MouseHand hand_;
  Session session_;
  Camera camera_ = *cameraFromView("top");
  LiveScene scene_;
  MouseAim aim_;
  std::optional<Stroke> stroke_;
};

// Cut depth on a line along the axis, mm: from the first loaded to the first remaining tissue.
std::optional<double> depthOfCut(const BrickField& loaded, const BrickField& left, const Vec3d& through,
                                 const Vec3d& axis) {
  constexpr double kAbove = 4;
  const Ray down{through + kAbove * axis, -axis};
  const auto before = entry(loaded, down, 0, 2 * kAbove), now = entry(left, down, 0, 2 * kAbove);
  if (!before || !now) return {};
  return *now - *before;
}

class Fissure : public testing::Test {
 protected:
  static void SetUpTestSuite() { tooth_ = chewingSurface(); }
  static void TearDownTestSuite() { tooth_.reset(); }

  static Tool toolOf(const char* id) {
    const auto file = findToolFile(id, defaultToolFolders());
    EXPECT_TRUE(file) << id;
    auto tool = readTool(*file);
    EXPECT_TRUE(tool) << id;
    return std::move(*tool);
  }
  // As in the window's session.
  static Model modelOf(const Tool& tool) {
    auto model = makeModel(std::span(&tool, 1), LiveRunOptions{}.step);
    EXPECT_TRUE(model) << model.error().message();
    return std::move(*model);
  }

  static inline std::shared_ptr<const BakedObject> tooth_;
};

// To and fro along the fissure.
struct Groove {
  double deepest = 0;      // maximum depth of the tool, mm
  std::vector<Vec3d> way;  // of the tool's foremost point, on the last two passes
};

/// @param begins  start of the stroke: share of the fissure.   @param layers  mm of depth per pass; 0: all at once.
Groove cutGroove(Chair& chair, double begins, int passes, double limit, double layers) {
  Groove out;
  const auto look = [&] {
    out.deepest = std::max(out.deepest, chair.depth().value_or(0));
    out.way.push_back(chair.front());
  };
  const auto allowed = [&](int pass) { return layers > 0 ? std::min(limit, layers * (pass + 1)) : limit; };
  EXPECT_TRUE(chair.press(onFissure(begins), 2, allowed(0)));
  chair.run(1, look);
  for (double part = begins; part > 0; part -= kStep / kFissure) {
    chair.drag(onFissure(part));
    chair.run(kToStep, look);
  }
  for (int pass = 0; pass < passes; ++pass) {
    chair.limit(allowed(pass));
    if (pass == passes - 2) out.way.clear();
    for (double part = 0; part <= 1; part += kStep / kFissure) {
      chair.drag(onFissure(pass % 2 ? 1 - part : part));
      chair.run(kToStep, look);
    }
  }
  return out;
}

// In layers, like a person, until nothing remains within the bur's reach.
TEST_F(Fissure, AGrooveWithALimitOfAMillimetreStaysWithinATenthOfIt) {
  constexpr double kLimit = 1, kWithin = 0.1;
  constexpr int kPasses = 18;
  const Tool bur = toolOf("round-010");
  for (const double begins : {0.5, 0.0}) {  // in the central pit; on the slope at its mesial end
    SCOPED_TRACE(begins);
    Chair chair(modelOf(bur), bur, tooth_);
    const Groove groove = cutGroove(chair, begins, kPasses, kLimit, 0.08);
    const BrickField left = chair.left();

    double least = 9, most = 0;
    Box3 along;
    for (std::size_t n = 0; n < groove.way.size(); n += 20) {
      const auto depth = depthOfCut(chair.loaded(), left, groove.way[n], chair.axis());
      ASSERT_TRUE(depth);
      least = std::min(least, *depth);
      most = std::max(most, *depth);
      along.add(groove.way[n]);
    }
    EXPECT_GE(least, kLimit - kWithin);
    EXPECT_LE(most, kLimit + kWithin);
    EXPECT_LE(groove.deepest, kLimit + kWithin) << "never, not only at last";
    EXPECT_GE(along.size()[0], 0.6 * kFissure) << "mm: it is a groove, not a pit";
  }
}

// At once, with a cursor far ahead of the bur. On a slope downwards the surface is lower at the cursor than at the
// tool.
TEST_F(Fissure, PulledAheadTheToolStaysAboveTheLimitWhereItIs) {
  constexpr double kLimit = 1, kPassed = 0.05;
  const Tool bur = toolOf("round-010");
  Chair chair(modelOf(bur), bur, tooth_);
  const Groove groove = cutGroove(chair, 0, 10, kLimit, 0);
  const BrickField left = chair.left();
  double most = 0;
  for (std::size_t n = 0; n < groove.way.size(); n += 20)
    most = std::max(most, depthOfCut(chair.loaded(), left, groove.way[n], chair.axis()).value_or(0));
  EXPECT_LE(groove.deepest, kLimit + kPassed);
  EXPECT_LE(most, kLimit + kPassed);
  EXPECT_GE(most, kLimit - kPassed) << "it got there";
}

// Along the axis, by the tool and by the field.
TEST_F(Fissure, AHeldButtonNeverPassesTheLimitOnSlopesAndInPits) {
  constexpr double kLimit = 0.15, kPassed = 0.03;
  const Tool bur = toolOf("round-010");
  const Vec2d places[] = {{0.1, -0.1}, {3.1, -0.05}, {-2.9, -0.35}, {1.4, -0.45}, {0.9, 1.7},  {-2.2, 1.4},
                          {2.65, 2.2}, {2.0, 1.4},   {-1.4, -2.0},  {0.1, -1.8},  {2.3, -2.2}, {-3.4, 0.9}};
  int reached = 0, runs = 0;
  for (const double force : {1.0, 2.5})
    for (const Vec2d& place : places) {
      SCOPED_TRACE(fmt::format("{} N at {}, {}", force, place[0], place[1]));
      Chair chair(modelOf(bur), bur, tooth_);
      ASSERT_TRUE(chair.press(place, force, kLimit));
      double deepest = 0;
      chair.run(4, [&] { deepest = std::max(deepest, chair.depth().value_or(0)); });
      const auto cut = depthOfCut(chair.loaded(), chair.left(), chair.front(), chair.axis());
      ASSERT_TRUE(cut);
      EXPECT_LE(deepest, kLimit + kPassed);
      EXPECT_LE(*cut, kLimit + kPassed);
      reached += deepest > kLimit - kPassed;
      ++runs;
    }
  EXPECT_GE(reached, 0.8 * runs) << "of " << runs << ": they did go there";
}

// The law: volume a second = surface speed x friction x normal load / specific energy. A ball without a drive that
// could stall has one surface speed.
TEST_F(Fissure, ANewtonHeldForFiveSecondsRemovesWhatTheLawSays) {
  constexpr double kSpeed = 12500, kFriction = 0.3, kPerNewton = 0.1;  // mm/s, -, mm^3 a second
  Tool bur = toolOf("round-010");
  Model model;
  model.tools = {practiceBall(0.5, kSpeed)};
  model.tissues = test::oneTissue(200, kFriction, kFriction * kSpeed / kPerNewton);
  for (const Vec2d& place : {onFissure(0), onFissure(0.5), Vec2d(2.0, 1.4)}) {
    Chair chair(model, bur, tooth_);
    ASSERT_TRUE(chair.press(place, 1, 5));
    chair.run(1);  // from the air
    const double before = chair.removed;
    double along = 0, normal = 0;
    chair.run(5, [&] {
      along += chair.out.force.force.dot(chair.axis()) / 5000;
      normal += chair.out.normal_load / 5000;
    });
    EXPECT_NEAR(along, 1, 0.02) << "N, of one";
    EXPECT_NEAR((chair.removed - before) / (5 * kPerNewton * normal), 1, 0.05);
  }
}

}  // namespace
}  // namespace kerf::fissure_test
