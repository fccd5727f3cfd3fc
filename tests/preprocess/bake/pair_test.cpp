#include "preprocess/bake/pair.h"

#include <gtest/gtest.h>

#include <numbers>

#include "geometry/formats/mesh_writer.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/support/temporary_folder.h"

namespace kerf::pair_test {
namespace {

namespace fs = std::filesystem;

BakeOptions coarse() {
  BakeOptions options;
  options.voxelize.voxel_mm = 0.3;
  return options;
}

TEST(Pair, SharesOneFrameAndNothingMoves) {
  const TemporaryFolder folder;
  const std::array<fs::path, 2> meshes{folder.path() / "upper.ply", folder.path() / "lower.ply"};
  ASSERT_TRUE(writeMesh(meshes[0], ballMesh({40, 2, 13}, 10, 20)));
  ASSERT_TRUE(writeMesh(meshes[1], ballMesh({40, 2, -7}, 10, 20)));
  const auto folders = pairFolders(meshes, (folder.path() / "patient.case").string());
  ASSERT_TRUE(folders);
  EXPECT_EQ((*folders)[0].filename(), "patient-upper.case");
  const auto reports = bakePair(meshes, *folders, coarse());
  ASSERT_TRUE(reports) << reports.error().message();
  const auto upper = readCaseManifest((*folders)[0]), lower = readCaseManifest((*folders)[1]);
  ASSERT_TRUE(upper && lower);
  ASSERT_TRUE(upper->pair && lower->pair);
  EXPECT_EQ(upper->pair->frame, lower->pair->frame);
  EXPECT_EQ(upper->pair->partner, "patient-lower.case");
  EXPECT_EQ(lower->pair->partner, "patient-upper.case");
  EXPECT_NE(upper->id, lower->id);
  EXPECT_NEAR(upper->box.min.z() - lower->box.max.z(), 0, 0.5);  // they still meet
  EXPECT_NEAR(upper->box.center().x(), 40, 0.2);
}

TEST(Pair, JawsInDifferentUnitsAreRefusedAndNothingIsWritten) {
  const TemporaryFolder folder;
  const std::array<fs::path, 2> meshes{folder.path() / "upper.stl", folder.path() / "lower.stl"};
  ASSERT_TRUE(writeMesh(meshes[0], ballMesh({0, 0, 0}, 30, 20)));
  ASSERT_TRUE(writeMesh(meshes[1], ballMesh({0, 0, 0}, 0.03, 20)));  // in metres
  const auto folders = pairFolders(meshes, (folder.path() / "patient").string());
  const auto reports = bakePair(meshes, *folders, coarse());
  ASSERT_FALSE(reports);
  EXPECT_EQ(reports.error().expected, "one unit for both jaws of a pair");
  EXPECT_FALSE(fs::exists((*folders)[0]) || fs::exists((*folders)[1]));
}

TEST(Pair, AFailingPartnerTakesTheFirstCaseWithIt) {
  const TemporaryFolder folder;
  const std::array<fs::path, 2> meshes{folder.path() / "upper.ply", folder.path() / "lower.ply"};
  Mesh bowl = ballMesh({0, 0, 0}, 10, 20);
  std::erase_if(bowl.triangles, [&](const Triangle& f) { return bowl.vertices[f[0]].z() < 0; });
  ASSERT_TRUE(writeMesh(meshes[0], ballMesh({0, 0, 0}, 10, 20)));
  ASSERT_TRUE(writeMesh(meshes[1], bowl));
  const auto folders = pairFolders(meshes, (folder.path() / "patient").string());
  BakeOptions options = coarse();
  options.close.mode = CloseMode::kRepair;  // refuses a missing underside
  ASSERT_FALSE(bakePair(meshes, *folders, options));
  EXPECT_FALSE(fs::exists((*folders)[0]) || fs::exists((*folders)[1]));
}

/// Half a ring of gum with fourteen cusps, open below; see base_test.cpp. 10 mm high, cusps at z = 10.
Mesh arch() {
  Mesh m;
  constexpr int kAlong = 120, kAcross = 16;
  for (int i = 0; i <= kAlong; ++i)
    for (int j = 0; j <= kAcross; ++j) {
      const double a = std::numbers::pi * i / kAlong, b = std::numbers::pi * j / kAcross;
      const double r = 22 - 4.5 * std::cos(b);
      m.vertices.push_back(
          {r * std::cos(a), r * std::sin(a), 8 * std::sin(b) + std::pow(std::sin(b), 8) * (1 + std::cos(28 * a))});
    }
  const auto id = [&](int i, int j) { return static_cast<std::uint32_t>(i * (kAcross + 1) + j); };
  for (int i = 0; i < kAlong; ++i)
    for (int j = 0; j < kAcross; ++j) {
      m.triangles.push_back({id(i, j), id(i, j + 1), id(i + 1, j + 1)});
      m.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i + 1, j)});
    }
  return m;
}

Mesh turned(Mesh m, double angle, const Vec3d& shift) {
  const Eigen::AngleAxisd r(angle, Vec3d::UnitX());
  for (Vec3d& p : m.vertices) p = r * p + shift;
  return m;
}

Expected<std::array<BakeReport, 2>> bakeArches(const TemporaryFolder& folder, const Mesh& lower, const Mesh& upper) {
  const std::array<fs::path, 2> meshes{folder.path() / "lower.ply", folder.path() / "upper.ply"};
  if (!writeMesh(meshes[0], lower) || !writeMesh(meshes[1], upper)) return fail({});
  BakeOptions options = coarse();
  options.voxelize.voxel_mm = 0.5;
  options.close.find_occlusal_plane = true;
  options.close.base_height_mm = 16;
  return bakePair(meshes, *pairFolders(meshes, (folder.path() / "patient").string()), options);
}

TEST(Pair, BasesOfJawsThatMeetAreExactlyParallel) {
  const TemporaryFolder folder;
  // The upper jaw upside down, its cusps 1 mm into the lower jaw's, and askew by 4 degrees.
  const auto reports = bakeArches(folder, arch(), turned(arch(), std::numbers::pi - 0.07, {0, 0, 19}));
  ASSERT_TRUE(reports) << reports.error().message();
  ASSERT_TRUE((*reports)[0].pair_check);
  EXPECT_NEAR(*(*reports)[0].pair_check->planes_disagree_deg, 4, 0.5);
  EXPECT_TRUE((*reports)[0].pair_check->warnings.empty()) << (*reports)[0].pair_check->warnings[0];
  EXPECT_EQ(*(*reports)[0].close.base_direction, -*(*reports)[1].close.base_direction);
  EXPECT_NE(describe((*reports)[0]).find("one occlusal plane for both bases"), std::string::npos);
}

TEST(Pair, JawsThatCanNotBeInOneFrameAreWarnedOf) {
  const auto said = [](const BakeReport& r, const char* what) { return describe(r).find(what) != std::string::npos; };
  {
    const TemporaryFolder folder;
    const auto askew = bakeArches(folder, arch(), turned(arch(), std::numbers::pi - 0.7, {0, 0, 30}));
    ASSERT_TRUE(askew) << askew.error().message();
    EXPECT_TRUE(said((*askew)[0], "WARNING: the occlusal planes differ by 40 degrees")) << describe((*askew)[0]);
    EXPECT_NEAR(*(*askew)[1].pair_check->planes_disagree_deg, 40, 1);
  }
  {
    const TemporaryFolder folder;
    const auto apart = bakeArches(folder, arch(), turned(arch(), std::numbers::pi, {0, 0, 60}));
    ASSERT_TRUE(apart) << apart.error().message();
    EXPECT_TRUE(said((*apart)[0], "WARNING: the jaws are 40 mm apart")) << describe((*apart)[0]);
  }
  {
    const TemporaryFolder folder;
    const auto inside = bakeArches(folder, arch(), turned(arch(), std::numbers::pi, {0, 10, 12}));
    ASSERT_TRUE(inside) << inside.error().message();
    EXPECT_TRUE(said((*inside)[0], "WARNING: the jaws reach 8.0 mm into each other")) << describe((*inside)[0]);
  }
}

TEST(Pair, CasesOfOneNameAreRefused) {
  const auto folders = pairFolders({"a/scan.ply", "b/scan.stl"}, "patient");
  ASSERT_FALSE(folders);
  EXPECT_EQ(folders.error().code, Error::Code::kBadValue);
}

}  // namespace
}  // namespace kerf::pair_test
