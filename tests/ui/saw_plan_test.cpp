#include "ui/app/saw/saw_plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/tool/saw_blade.h"
#include "geometry/tool/tool_file.h"
#include "tests/sim/block_scene.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/saw/saw_clearance.h"
#include "ui/app/saw/saw_section.h"

namespace kerf::saw_plan_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Tool toolOf(const std::string& id) {
  const auto file = findToolFile(id, defaultToolFolders());
  EXPECT_TRUE(file) << id;
  auto tool = readTool(*file);
  EXPECT_TRUE(tool) << id;
  return *tool;
}
SawBlade bladeOf(const std::string& id) {
  const auto blade = SawBlade::of(toolOf(id));
  EXPECT_TRUE(blade) << id;
  return *blade;
}
const std::vector<std::string> kSaws = {"disc-22",       "saw-die-178",          "saw-die-254",
                                        "saw-piezo-050", "saw-reciprocating-25", "saw-sagittal-10",
                                        "saw-sagittal-6"};

void expectSound(const SawPlane& plane) {
  EXPECT_NEAR(plane.normal.norm(), 1, 1e-12);
  EXPECT_NEAR(plane.approach.norm(), 1, 1e-12);
  EXPECT_NEAR(plane.normal.dot(plane.approach), 0, 1e-12);
}

// ---- Planes

TEST(SawPlane, MovedByAPoseItsCornersMoveSo) {
  SawPlane plane = *planeSquareTo({1, 2, 3}, {1, 2, 2});
  const Rigid3 by{Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Vec3d(1, 1, 0).normalized())), {3, -1, 2}};
  const SawPlane moved = movedPlane(plane, by);
  expectSound(moved);
  for (std::size_t n = 0; n < 4; ++n) EXPECT_NEAR((moved.corners()[n] - by * plane.corners()[n]).norm(), 0, 1e-12);
}

TEST(SawPlane, ThreePointsMakeTheirPlane) {
  const std::array<Vec3d, 3> points = {Vec3d(1, 0, 0), {0, 2, 0}, {0, 0, 3}};
  const auto plane = planeThrough(points, Vec3d(0, 0, 1));
  ASSERT_TRUE(plane);
  expectSound(*plane);
  for (const Vec3d& p : points) EXPECT_NEAR(plane->toPlane(p)[2], 0, 1e-12);
  // x + y/2 + z/3 = 1
  EXPECT_NEAR(std::abs(plane->normal.dot(Vec3d(1, 0.5, 1.0 / 3).normalized())), 1, 1e-12);
  // No other direction in the plane points more against the surface.
  const double into = plane->approach.dot(-Vec3d::UnitZ());
  for (int n = 0; n < 360; ++n)
    EXPECT_LE(Vec3d(Eigen::AngleAxisd(n * kDegree, plane->normal) * plane->approach).dot(-Vec3d::UnitZ()),
              into + 1e-12);
}

TEST(SawPlane, PointsThatMakeNoPlaneAreRefusedWithWhatToDo) {
  const std::array<Vec3d, 3> line = {Vec3d(0, 0, 0), {1, 1, 1}, {5, 5, 5.01}},
                             near = {Vec3d(0, 0, 0), {0.3, 0, 0}, {0, 9, 0}};
  for (const auto& points : {line, near}) {
    const auto plane = planeThrough(points, Vec3d::UnitZ());
    ASSERT_FALSE(plane);
    EXPECT_FALSE(plane.error().hint.empty());
  }
  EXPECT_FALSE(planeAlongView({0, 0, 0}, {0, 0, 9}, -Vec3d::UnitZ())) << "a point, as seen";
  EXPECT_FALSE(planeSquareTo({0, 0, 0}, {0, 0, 0}));
}

TEST(SawPlane, ALineInTheViewIsSeenEdgeOn) {
  const Vec3d view = Vec3d(1, 2, -2).normalized(), from(3, 1, 0), to(5, 4, 7);
  const auto plane = planeAlongView(from, to, view);
  ASSERT_TRUE(plane);
  expectSound(*plane);
  EXPECT_NEAR(plane->normal.dot(view), 0, 1e-12);
  EXPECT_NEAR((plane->approach - view).norm(), 0, 1e-12);
  EXPECT_NEAR(plane->toPlane(from)[2], 0, 1e-12);
  EXPECT_NEAR(plane->toPlane(to)[2], 0, 1e-12);
  const Vec3d line = to - from;
  EXPECT_NEAR(plane->width, std::sqrt(line.squaredNorm() - std::pow(view.dot(line), 2)), 1e-12);
}

TEST(SawPlane, SquareToANormalItGoesDownUnlessTold) {
  const auto plane = planeSquareTo({1, 2, 3}, {4, 0, 0});
  ASSERT_TRUE(plane);
  EXPECT_NEAR((plane->normal - Vec3d::UnitX()).norm(), 0, 1e-12);
  EXPECT_NEAR((plane->approach + Vec3d::UnitZ()).norm(), 0, 1e-12);
  const auto other = planeSquareTo({1, 2, 3}, {1, 0, 0}, Vec3d(5, 1, 0));
  ASSERT_TRUE(other);
  EXPECT_NEAR((other->approach - Vec3d::UnitY()).norm(), 0, 1e-12);
  expectSound(*planeSquareTo({0, 0, 0}, {0, 0, 1}));
}

TEST(SawPlane, StepsGoByTheirFormulas) {
  SawPlane plane = *planeSquareTo({1, 2, 3}, {1, 0, 0});
  movePlane(plane, 0.1);
  EXPECT_NEAR((plane.point - Vec3d(1.1, 2, 3)).norm(), 0, 1e-12);

  turnPlane(plane, 10 * kDegree, 0);  // about -z
  EXPECT_NEAR((plane.normal - Vec3d(std::cos(10 * kDegree), -std::sin(10 * kDegree), 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((plane.approach + Vec3d::UnitZ()).norm(), 0, 1e-12);
  turnPlane(plane, -10 * kDegree, 0);

  // Across is x x -z = +y: about it the normal x goes to -z.
  turnPlane(plane, 0, 5 * kDegree);
  EXPECT_NEAR((plane.normal - Vec3d(std::cos(5 * kDegree), 0, -std::sin(5 * kDegree))).norm(), 0, 1e-12);
  expectSound(plane);

  const Vec3d middle = plane.fromPlane(0, 0.5 * plane.depth);
  turnApproach(plane, 33 * kDegree);
  expectSound(plane);
  EXPECT_NEAR((plane.fromPlane(0, 0.5 * plane.depth) - middle).norm(), 0, 1e-12);
  for (const Vec3d& corner : plane.corners()) EXPECT_NEAR(plane.toPlane(corner)[2], 0, 1e-12);
  EXPECT_NEAR((plane.corners()[2] - plane.corners()[0]).norm(), std::hypot(plane.width, plane.depth), 1e-12);
}

// ---- Blades

TEST(SawBlade, EveryBladeOfTheRackIsASawAndNothingElse) {
  std::vector<std::string> saws;
  for (const ToolListing& listed : listTools(defaultToolFolders()))
    if (listed.tool && SawBlade::of(*listed.tool)) saws.push_back(listed.tool->id);
  EXPECT_EQ(saws, kSaws);
}

TEST(SawBlade, ItStandsInThePlaneWithItsTeethForward) {
  const Vec3d normal = Vec3d(1, 2, 3).normalized(), approach = normal.unitOrthogonal(), at(4, 5, 6);
  for (const std::string& id : kSaws)
    for (const bool is_turned : {false, true}) {
      const Tool tool = toolOf(id);
      const SawBlade blade = bladeOf(id);
      const Rigid3 pose = blade.poseAt(at, normal, approach, is_turned);
      EXPECT_TRUE(pose.isUsable());
      EXPECT_NEAR((pose.rotation * tool.plunge_direction - approach).norm(), 0, 1e-9) << id;
      EXPECT_NEAR((pose * blade.front - at).norm(), 0, 1e-9) << id;

      // The cutting part is symmetric about the plane, as wide as the kerf, and does not extend beyond the front.
      const Box3 box = tool.cut->bounds();
      double low = 1e9, high = -1e9, ahead = -1e9;
      for (int n = 0; n < 8; ++n) {
        const Vec3d corner = pose * box.corner(n) - at;
        low = std::min(low, normal.dot(corner));
        high = std::max(high, normal.dot(corner));
        ahead = std::max(ahead, approach.dot(corner));
      }
      EXPECT_NEAR(low, -0.5 * tool.kerfWidth(), 1e-9) << id;
      EXPECT_NEAR(high, 0.5 * tool.kerfWidth(), 1e-9) << id;
      EXPECT_NEAR(ahead, 0, 1e-9) << id;
      EXPECT_NEAR(tool.cut->distance(blade.front), 0, 1e-6) << id;

      const Vec3d across = normal.cross(approach);
      EXPECT_NEAR((pose.rotation * blade.edge).dot(across), is_turned ? -1 : 1, 1e-9) << id;
    }
}

TEST(SawBlade, ReachFollowsFromItsNumbers) {
  const SawBlade reciprocating = bladeOf("saw-reciprocating-25"), sagittal = bladeOf("saw-sagittal-10"),
                 disc = bladeOf("disc-22");
  EXPECT_NEAR(reciprocating.span, 25 + 3, 1e-9);
  EXPECT_NEAR(reciprocating.most_width, reciprocating.span, 1e-9);
  EXPECT_NEAR(sagittal.span, toolOf("saw-sagittal-10").sweptWidth(), 0.02);
  EXPECT_NEAR(sagittal.most_depth, 25, 1e-9);
  EXPECT_NEAR(disc.most_depth, 11 - 2.35 / 2 - 0.5, 1e-9);
  EXPECT_NEAR(disc.sag, 11 - std::sqrt(121 - 0.25 * disc.step * disc.step), 1e-9);
}

// ---- The bone in a plane

// A bar of 40 x 8 x 10 mm along x.
std::shared_ptr<const BakedObject> bar() { return test::block({40, 8, 10}, 0.25); }

TEST(FitToBone, TheRectangleIsTheSectionWithItsMargins) {
  const auto bone = bar();
  const Box3 box = bone->phi0().bounds();
  const double top = 0, middle = -5;  // the block's top is at z = 0
  ASSERT_LT(bone->phi0().sample({0, 0, -0.5}), 0);
  ASSERT_LT(bone->phi0().sample({0, 0, -9.5}), 0);
  const auto plane =
      fitToBone(*planeSquareTo({3, 1, middle}, {1, 0, 0}), bone->phi0(), bladeOf("saw-reciprocating-25"));
  ASSERT_TRUE(plane) << plane.error().message();
  EXPECT_NEAR(plane->point[0], 3, 1e-9);
  EXPECT_NEAR(plane->point[1], 0, 0.2);
  EXPECT_NEAR(plane->point[2], top + 0.5, 0.3);
  EXPECT_NEAR(plane->width, 8 + 1, 0.5);
  EXPECT_NEAR(plane->depth, 10 + 1.5, 0.5);
  EXPECT_FALSE(box.isEmpty());
}

TEST(FitToBone, ABladeThatReachesTooLittleIsTurnedOrBounded) {
  const auto bone = bar();
  // Lengthwise, 40 x 10: 28 mm of teeth do not span it from above, but they do from an end.
  const SawPlane lengthwise = *planeSquareTo({0, 0, -5}, {0, 1, 0});
  const SawBlade blade = bladeOf("saw-reciprocating-25");
  const auto turned = fitToBone(lengthwise, bone->phi0(), blade);
  ASSERT_TRUE(turned);
  EXPECT_GT(std::abs(turned->approach[0]), 0.99);
  EXPECT_NEAR(turned->width, 10 + 1, 0.5);

  const auto bounded = fitToBone(lengthwise, bone->phi0(), blade, {.keeps_approach = true});
  ASSERT_TRUE(bounded);
  EXPECT_NEAR(bounded->width, blade.span, 1e-9);
  const auto shallow = fitToBone(lengthwise, bone->phi0(), bladeOf("disc-22"), {.keeps_approach = true});
  ASSERT_TRUE(shallow);
  EXPECT_NEAR(shallow->depth, bladeOf("disc-22").most_depth, 1e-9);
}

// Two bars of 40 x 6 x 8 mm along x, their middles at y = -16 and 16.
BrickField twoBars() {
  const auto one = test::block({40, 6, 8}, 0.25);
  const BrickField& phi = one->phi0();
  BrickField out(0.25, phi.background(), phi.interior());
  for (const int away : {-8, 8}) {
    const Vec3i by{0, away, 0};  // bricks of 2 mm
    for (std::size_t b = 0; b < phi.brickCount(); ++b) out.add(phi.brickCoord(b) + by, phi.brick(b));
    for (const Vec3i& brick : phi.interiorBricks()) out.markInterior(brick + by);
  }
  return out;
}

TEST(FitToBone, ALineAcrossAnArchSpansBothSidesIfTheBladeDoes) {
  const BrickField arch = twoBars();
  const SawPlane across = *planeSquareTo({3, 15, -4}, {1, 0, 0});
  const double to_middle = across.across()[1] > 0 ? -15 : 15;
  const FitOptions line{.across = {{to_middle - 25, to_middle + 25}}, .keeps_approach = true};
  const auto both = fitToBone(across, arch, SawBlade{}, line);
  ASSERT_TRUE(both) << both.error().message();
  EXPECT_NEAR(both->width, 38 + 1, 0.6);
  EXPECT_NEAR(both->point[1], 0, 0.5);
  const SawCoverage whole = coverageOf(*both, arch, SawBlade{});
  EXPECT_TRUE(whole.passesThrough()) << whole.share;
  EXPECT_EQ(whole.sections_met, 2);

  const auto near = fitToBone(across, arch, bladeOf("saw-reciprocating-25"), line);
  ASSERT_TRUE(near);
  EXPECT_NEAR(near->width, 6 + 1, 0.6) << "28 mm of teeth do not span the arch";
  const SawCoverage one = coverageOf(*near, arch, SawBlade{});
  EXPECT_TRUE(one.passesThrough());
  EXPECT_EQ(one.sections, 2);
  EXPECT_EQ(one.sections_met, 1);

  // Seen from the side the other bar lies behind the first: it does not count.
  const SawPlane from_side = *planeSquareTo({3, 18, -4}, {1, 0, 0}, Vec3d(0, -1, 0));
  const auto first = fitToBone(from_side, arch, SawBlade{}, {.across = {{-20, 20}}, .keeps_approach = true});
  ASSERT_TRUE(first);
  EXPECT_NEAR(first->depth, 6 + 1.5, 0.6);
}

TEST(SawCoverage, SaysHowMuchOfTheSectionIsReached) {
  const auto bone = bar();
  auto plane = fitToBone(*planeSquareTo({3, 1, -5}, {1, 0, 0}), bone->phi0(), SawBlade{});
  ASSERT_TRUE(plane);
  EXPECT_TRUE(coverageOf(*plane, bone->phi0(), SawBlade{}).passesThrough());
  constexpr double kCellsAtEdges = 0.05;  // of 4 and 5 mm in cells of 0.25 mm
  plane->depth = 5.5;                     // 0.5 mm of it above the bar
  EXPECT_NEAR(coverageOf(*plane, bone->phi0(), SawBlade{}).share, 0.5, kCellsAtEdges);
  plane->width = 4;
  EXPECT_NEAR(coverageOf(*plane, bone->phi0(), SawBlade{}).share, 0.25, kCellsAtEdges);
  SawBlade shallow;
  shallow.most_depth = 3;
  EXPECT_NEAR(coverageOf(*plane, bone->phi0(), shallow).share, 0.125, kCellsAtEdges);
}

TEST(FitToBone, NoBoneIsAnErrorThatSaysWhere) {
  const auto plane = fitToBone(*planeSquareTo({90, 0, 0}, {1, 0, 0}), bar()->phi0(), bladeOf("saw-sagittal-6"));
  ASSERT_FALSE(plane);
  EXPECT_NE(plane.error().message().find("90.0"), std::string::npos) << plane.error().message();
}

TEST(SawPasses, TheyCoverTheSectionAndStopAtTheDepth) {
  const auto bone = bar();
  for (const std::string& id : kSaws) {
    if (id.starts_with("saw-die")) continue;  // 140 mm of teeth
    const Tool tool = toolOf(id);
    const SawBlade blade = bladeOf(id);
    auto plane = fitToBone(*planeSquareTo({3, 0, -5}, {1, 0, 0}), bone->phi0(), blade, {.keeps_approach = true});
    ASSERT_TRUE(plane);
    plane->depth = std::min(plane->depth, 6.0);
    const bool is_turned = isTurned(*plane, blade, bone->phi0().bounds());
    const auto passes = passesOf(*plane, bone->phi0(), blade, is_turned);
    ASSERT_FALSE(passes.empty()) << id;

    SawnSection section(*plane, bone->phi0(), tool, blade);
    EXPECT_NEAR(section.plannedMm2(), std::min(8.0, plane->width) * 5.5, 3) << id;
    EXPECT_EQ(section.share(), 0);
    for (const SawPass& pass : passes) {
      EXPECT_LE(pass.to, plane->depth);
      EXPECT_LT(pass.from, 0.6);
      for (double v = pass.from; v < pass.to + 0.2; v += 0.2)
        section.mark(
            blade.poseAt(plane->fromPlane(pass.u, std::min(v, pass.to)), plane->normal, plane->approach, is_turned));
    }
    EXPECT_GT(section.share(), 0.97) << id;
    EXPECT_LE(section.share(), 1) << id;
    const double beside = blade.is_held_at_end ? 5.5 * std::max(0.0, std::min(8.0, blade.span) - plane->width) : 0;
    EXPECT_LE(section.beyondMm2(), beside + 1.5) << id;
  }
}

TEST(SawPasses, WhereThereIsNoBoneThereIsNothingToSaw) {
  SawPlane plane = *planeSquareTo({90, 0, 0}, {1, 0, 0});
  EXPECT_TRUE(passesOf(plane, bar()->phi0(), bladeOf("saw-sagittal-10"), false).empty());
}

// ---- The plan

TEST(SawPlan, NamesAreUniqueAndChoicesFollow) {
  SawPlan plan;
  EXPECT_EQ(plan.chosen(), nullptr);
  plan.add(*planeSquareTo({0, 0, 0}, {1, 0, 0}));
  plan.add(*planeSquareTo({1, 0, 0}, {1, 0, 0}));
  EXPECT_EQ(plan.chosen()->name, "plane 2");
  EXPECT_TRUE(plan.renameChosen("distal"));
  EXPECT_FALSE(plan.renameChosen("plane 1")) << "the other one's";
  EXPECT_FALSE(plan.renameChosen(""));
  EXPECT_TRUE(plan.renameChosen("distal")) << "its own";
  EXPECT_TRUE(plan.choose("plane 1"));
  const auto unknown = plan.choose("mesial");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message().find("distal"), std::string::npos);

  const std::uint64_t before = plan.version();
  plan.removeChosen();
  EXPECT_GT(plan.version(), before);
  ASSERT_EQ(plan.planes().size(), 1u);
  EXPECT_EQ(plan.chosen()->name, "distal");
  plan.removeChosen();
  plan.removeChosen();
  EXPECT_EQ(plan.chosen(), nullptr);
}

TEST(SawPlan, AFileBringsBackEveryBit) {
  const TemporaryFolder folder;
  SawPlan plan;
  SawPlane plane = *planeSquareTo({1.0 / 3, 2e-7, -31.25}, {1, 2, 3});
  turnPlane(plane, 0.1, 0.2);
  plane.name = "left \"distal\"";
  plan.add(plane);
  plan.add(*planeSquareTo({4, 5, 6}, {0, 1, 0}));
  const auto file = folder.path() / "plan.toml";
  ASSERT_TRUE(plan.save(file));

  SawPlan back;
  const auto loaded = back.load(file);
  ASSERT_TRUE(loaded) << loaded.error().message();
  ASSERT_EQ(back.planes().size(), 2u);
  EXPECT_EQ(back.planes()[0].name, plane.name);
  EXPECT_EQ(back.planes()[0].point, plane.point);
  EXPECT_EQ(back.planes()[0].normal, plane.normal);
  EXPECT_EQ(back.planes()[0].approach, plane.approach);
  EXPECT_EQ(back.planes()[1].name, "plane 1");

  ASSERT_TRUE(SawPlan().save(file));
  EXPECT_TRUE(back.load(file)) << "none is a plan, too";
  EXPECT_TRUE(back.planes().empty());
}

TEST(SawPlan, ABadFileIsRefusedAndThePlanStays) {
  const TemporaryFolder folder;
  SawPlan plan;
  plan.add(*planeSquareTo({0, 0, 0}, {1, 0, 0}));
  const std::string head = "format = \"kerf-saw-plan\"\nversion = 1\n";
  const std::string good =
      "[[plane]]\nname = \"a\"\npoint = [0, 0, 0]\nnormal = [1, 0, 0]\napproach = [0, 0, -1]\nwidth = 5\ndepth = 5\n";
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string out = good;
    return head + out.replace(out.find(from), from.size(), to);
  };
  const std::pair<std::string, const char*> cases[] = {{"format = \"kerf-run\"\nversion = 1\n", "kerf-saw-plan"},
                                                       {"format = \"kerf-saw-plan\"\nversion = 2\n", "version 2"},
                                                       {with("normal = [1, 0, 0]", "normal = [1, 1, 0]"), "normal"},
                                                       {with("[0, 0, -1]", "[1, 0, 0]"), "square"},
                                                       {with("width = 5", "width = -5"), "width"},
                                                       {with("width = 5", "widht = 5"), "widht"},
                                                       {with("\"a\"", "\"\""), "name"},
                                                       {head + good + good, "duplicate name"},
                                                       {head + "plane = 3\n", "plane"},
                                                       {"nonsense", "line 1"}};
  for (const auto& [text, words] : cases) {
    const auto loaded = plan.load(folder.write("bad.toml", text));
    ASSERT_FALSE(loaded) << text;
    EXPECT_NE(loaded.error().message().find(words), std::string::npos) << loaded.error().message();
    EXPECT_EQ(plan.planes().size(), 1u);
  }
  EXPECT_FALSE(plan.load(folder.path() / "missing.toml"));
  EXPECT_FALSE(plan.save("/nowhere/plan.toml"));
}

TEST(SawClearance, IsTheDistanceFromTheKerfToWhatIsKept) {
  Box3 box;
  box.add(Vec3d(-1, -1, -1));
  box.add(Vec3d(1, 1, 1));
  const auto baked = bakedFrom([](const Vec3d& p) { return p.norm() - 1; }, box, 0.1, Material::kNerveCanal);
  ASSERT_TRUE(baked) << baked.error().message();
  const auto canal = Structures::of(**baked);
  ASSERT_TRUE(canal) << canal.error().message();

  SawPlane plane;  // x = 0, entering at its point along -z
  plane.width = plane.depth = 8;
  const auto at = [&](const Vec3d& point) {
    plane.point = point;
    return clearanceOf(plane, 0.4, **canal);
  };
  for (const double x : {1.5, 2.0, 4.0}) EXPECT_NEAR(at({x, 0, 4}).distance_mm, x - 1 - 0.2, 0.1) << x;
  EXPECT_EQ(at({1.5, 0, 4}).material, Material::kNerveCanal);
  EXPECT_LT(at({0.5, 0, 4}).distance_mm, 0) << "through it";
  EXPECT_NEAR(at({0, 0, 11}).distance_mm, 2 - 0.2, 0.1) << "the plane ends above it";
  EXPECT_NEAR(at({0, 7, 4}).distance_mm, 2 - 0.2, 0.1) << "or beside it";
  EXPECT_TRUE(at({20, 0, 4}).is_far);
}

// Small voxels limit the range of distances: beyond it the result is far, not the limit.
TEST(SawClearance, OfSmallVoxelsIsFarWhereNothingIsMeasured) {
  Box3 box;
  box.add(Vec3d(-0.2, -0.2, -0.2));
  box.add(Vec3d(0.2, 0.2, 0.2));
  const auto baked = bakedFrom([](const Vec3d& p) { return p.norm() - 0.2; }, box, 0.01, Material::kNerveCanal);
  ASSERT_TRUE(baked) << baked.error().message();
  const auto canal = Structures::of(**baked);
  ASSERT_TRUE(canal) << canal.error().message();
  SawPlane plane;
  plane.width = plane.depth = 2;
  plane.point = Vec3d(4.5, 0, 1);
  EXPECT_TRUE(clearanceOf(plane, 0.4, **canal).is_far);
  plane.point = Vec3d(1.5, 0, 1);
  EXPECT_FALSE(clearanceOf(plane, 0.4, **canal).is_far);
}

}  // namespace
}  // namespace kerf::saw_plan_test
