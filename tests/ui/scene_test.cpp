// Display of a run in kerf-sim: tissues on the walls of the cut, and on its section plane.
#include "ui/app/view/scene.h"

#include <cmath>
#include <numbers>

#include "geometry/boolean/post_op_mesh.h"
#include "geometry/field/material.h"
#include "tests/ui/cli_runner.h"

namespace kerf::scene_test {
namespace {

constexpr double kRadius = 0.7, kTip = -1.5;  // of round-014, and the height of its lowest point

/// A box of 6 x 5 x 4 mm with a round tunnel along x, entirely inside: a groove that the neck does not open.
class TissueScene : public Cli {
 protected:
  void makeTissueRun() {
    folder_.write("box.off", box());
    folder_.write("groove.csv", groove(kTip));
    folder_.write("tissues.toml",
                  "format = \"kerf-recipe\"\nversion = 1\nunit = \"mm\"\nvoxel = 0.1\n[[part]]\nmaterial = \"enamel\"\n"
                  "depth = 0.5\n[[part]]\nmaterial = \"dentin\"\nmesh = \"box.off\"\n");
    const Outcome baked = runKerf({"bake", at("tissues.toml"), "-o", at("tissues.case")});
    ASSERT_EQ(baked.exit_code, 0) << baked.err;
    const Outcome cut = runKerf(
        {"cut", at("tissues.case"), "--tool", "round-014", "--path", at("groove.csv"), "-o", at("tissues.run")});
    ASSERT_EQ(cut.exit_code, 0) << cut.err;
  }
  const Rgba8 enamel_ = readDefaultMaterials()->find(Material::kEnamel)->color,
              dentin_ = readDefaultMaterials()->find(Material::kDentin)->color;
  static Vec3d middle(const Mesh& mesh, std::size_t t) {
    return (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
  }
  /// Area of the triangles that lie in the plane x = 0.
  static double lidArea(const Mesh& mesh) {
    double area = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      if (std::abs(mesh.corner(t, 0)[0]) + std::abs(mesh.corner(t, 1)[0]) + std::abs(mesh.corner(t, 2)[0]) < 1e-9)
        area += doubleAreaVector(mesh, t).norm() / 2;
    return area;
  }
  static inline const SectionPlane kAcross{.through = SectionPlane::Through::kCut, .normal = {1, 0, 0}};
};

// A picture and its scale bar are in mm, for any unit of the file. Numbers too small for a dental object in mm are
// metres.
TEST_F(TissueScene, AMeshInMetresIsShownInMm) {
  std::string metres = box();
  folder_.write("box.off", metres);
  const auto millimetres = loadScene(in("box.off"), {}, "mm");
  const auto asked = loadScene(in("box.off"), {}, "cm");
  ASSERT_TRUE(millimetres && asked);
  EXPECT_NEAR(bounds(asked->mesh).size()[0], 10 * bounds(millimetres->mesh).size()[0], 1e-9);
  EXPECT_NE(asked->note.find("in cm"), std::string::npos) << asked->note;

  std::string small = "OFF\n8 12 0\n";
  for (int c = 0; c < 8; ++c)
    small += fmt::format("{} {} {}\n", c & 1 ? 0.03 : -0.03, c & 2 ? 0.025 : -0.025, c & 4 ? 0.04 : 0.0);
  folder_.write("small.off", small + metres.substr(metres.find("3 0 2 3")));
  const auto guessed = loadScene(in("small.off"));
  ASSERT_TRUE(guessed);
  EXPECT_NE(guessed->note.find("in m"), std::string::npos) << guessed->note;
  EXPECT_NEAR(bounds(guessed->mesh).size()[0], 60, 1e-9);
}

TEST_F(TissueScene, WallsOfACutShowTheTissueTheyLieIn) {
  makeTissueRun();
  const auto scene = loadScene(in("tissues.run"));
  ASSERT_TRUE(scene) << scene.error().message();
  const Mesh& mesh = scene->mesh;
  ASSERT_EQ(mesh.face_colors.size(), mesh.triangles.size());
  std::size_t deep = 0, shallow = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    EXPECT_NE(mesh.face_colors[t], PostOpOptions{}.cut_color);
    const Vec3d p = middle(mesh, t);
    if (std::hypot(p[1] - 0.3, p[2] - kTip - kRadius) > kRadius + 0.1 || std::abs(p[0]) > 2) continue;  // no wall
    const double depth = -p[2];
    if (depth < 0.35) {
      EXPECT_EQ(mesh.face_colors[t], enamel_) << p.transpose();
      ++shallow;
    } else if (depth > 0.65) {
      EXPECT_EQ(mesh.face_colors[t], dentin_) << p.transpose();
      ++deep;
    }
  }
  EXPECT_GT(deep, 50u);
  EXPECT_GT(shallow, 50u);
}

TEST_F(TissueScene, ARunCutOpenShowsTheHoleAndTheTissuesAroundIt) {
  makeTissueRun();
  const auto whole =
      loadScene(in("tissues.case"), SectionPlane{.through = SectionPlane::Through::kCenter, .normal = {1, 0, 0}});
  ASSERT_TRUE(whole) << whole.error().message();
  EXPECT_NEAR(lidArea(whole->mesh), 5 * 4, 0.1);  // corners are cut off at a voxel, 0.1 mm
  const auto cut = loadScene(in("tissues.run"), kAcross);
  ASSERT_TRUE(cut) << cut.error().message();
  EXPECT_NEAR(lidArea(cut->mesh), 5 * 4 - std::numbers::pi * kRadius * kRadius, 0.1);
  EXPECT_EQ(cut->note, "");
  for (const Vec3d& p : cut->mesh.vertices) EXPECT_LT(p[0], 1e-9);
  double tissue[2] = {0, 0};
  for (std::size_t t = 0; t < cut->mesh.triangles.size(); ++t) {
    if (middle(cut->mesh, t)[0] < -1e-9) continue;
    tissue[0] += cut->mesh.face_colors[t] == enamel_ ? doubleAreaVector(cut->mesh, t).norm() / 2 : 0;
    tissue[1] += cut->mesh.face_colors[t] == dentin_ ? doubleAreaVector(cut->mesh, t).norm() / 2 : 0;
  }
  // Enamel: a frame of 0.5 mm, 8 mm2, less a segment of the circle. Labels are exact to half a voxel, along 14 mm.
  EXPECT_NEAR(tissue[0], 8 - 0.36, 0.8);
  EXPECT_NEAR(tissue[0] + tissue[1], lidArea(cut->mesh), 1e-6);
}

TEST_F(TissueScene, ARunOfOneMaterialKeepsItsCutColourWhenCutOpen) {
  makeRun();
  const auto scene = loadScene(in("box.run"), kAcross);
  ASSERT_TRUE(scene) << scene.error().message();
  EXPECT_GT(std::count(scene->mesh.face_colors.begin(), scene->mesh.face_colors.end(), PostOpOptions{}.cut_color), 50);
}

TEST_F(TissueScene, PlanesThatTakeAllAreRefusedAndThoseThatTakeNothingAreNoted) {
  makeRun();
  const auto at_x = [](double x) { return SectionPlane{.point = {x, 0, 0}, .normal = {1, 0, 0}}; };
  for (const char* bundle : {"box.case", "box.run"}) {
    const auto all = loadScene(in(bundle), at_x(-50));
    ASSERT_FALSE(all);
    EXPECT_NE(all.error().message().find("removes the whole object; the object lies in (-3.00, -2.50, -4.00)"),
              std::string::npos)
        << all.error().message();
    const auto nothing = loadScene(in(bundle), at_x(50));
    ASSERT_TRUE(nothing) << nothing.error().message();
    EXPECT_NE(nothing->note.find("removes nothing"), std::string::npos) << nothing->note;
  }
  EXPECT_FALSE(loadScene(in("box.case"), kAcross)) << "a case has no cut";
  EXPECT_FALSE(loadScene(in("box.off"), at_x(0))) << "a mesh file has no inside";
}

}  // namespace
}  // namespace kerf::scene_test
