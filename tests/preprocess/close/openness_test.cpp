#include "preprocess/close/openness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>

#include "tests/preprocess/solid_checks.h"

namespace kerf::openness_test {
namespace {

// Faces of voxels, two triangles each. Corners at the same place are one vertex.
class VoxelFaces {
 public:
  // The face of voxel (x, y, z) towards +axis or -axis.
  void add(std::array<int, 3> voxel, int axis, bool up) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::array<int, 3> corner = voxel;
    corner[static_cast<std::size_t>(axis)] += up;
    std::array<std::uint32_t, 4> quad{};
    for (std::size_t k = 0; k < 4; ++k) {
      std::array<int, 3> at = corner;
      at[static_cast<std::size_t>(u)] += k == 1 || k == 2;
      at[static_cast<std::size_t>(v)] += k == 2 || k == 3;
      quad[up ? k : 3 - k] = vertex(at);
    }
    mesh.triangles.push_back({quad[0], quad[1], quad[2]});
    mesh.triangles.push_back({quad[0], quad[2], quad[3]});
  }
  Mesh mesh;

 private:
  std::uint32_t vertex(const std::array<int, 3>& at) {
    const auto [found, is_new] = index_.try_emplace(at, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (is_new) mesh.vertices.emplace_back(at[0], at[1], at[2]);
    return found->second;
  }
  std::map<std::array<int, 3>, std::uint32_t> index_;
};

// A skull as a label volume's faces: a stair-stepped shell, 24 mm across, 2 mm thick.
constexpr int kOuter = 12, kInner = 10;
bool inBall(const std::array<int, 3>& voxel, double radius) {
  return (Vec3d(voxel[0], voxel[1], voxel[2]) + Vec3d::Constant(0.5)).norm() < radius;
}
bool isBone(const std::array<int, 3>& voxel) { return inBall(voxel, kOuter) && !inBall(voxel, kInner); }

template <class F>
void forEachVoxel(F&& f) {
  for (int z = -kOuter; z < kOuter; ++z)
    for (int y = -kOuter; y < kOuter; ++y)
      for (int x = -kOuter; x < kOuter; ++x) f(std::array{x, y, z});
}

VoxelFaces shell() {
  VoxelFaces out;
  forEachVoxel([&](const std::array<int, 3>& voxel) {
    if (!isBone(voxel)) return;
    for (int axis = 0; axis < 3; ++axis)
      for (const bool up : {false, true}) {
        std::array<int, 3> beside = voxel;
        beside[static_cast<std::size_t>(axis)] += up ? 1 : -1;
        if (!isBone(beside)) out.add(voxel, axis, up);
      }
  });
  return out;
}

// With a wall without thickness right through the hollow: the remainder of a thin wall.
VoxelFaces shellWithSheet() {
  VoxelFaces out = shell();
  forEachVoxel([&](const std::array<int, 3>& voxel) {
    if (voxel[0] == 0 && inBall(voxel, kInner)) out.add(voxel, 0, false);
  });
  return out;
}

// Removes two triangles of the outside.
Mesh punched(Mesh mesh) {
  double far = 0;
  std::size_t at = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 2)
    if (mesh.corner(t, 0).z() > far) {
      far = mesh.corner(t, 0).z();
      at = t;
    }
  mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(at),
                       mesh.triangles.begin() + static_cast<std::ptrdiff_t>(at) + 2);
  return mesh;
}

bool says(const std::vector<std::string>& lines, const std::string& part) {
  return std::any_of(lines.begin(), lines.end(), [&](const auto& line) { return line.find(part) != line.npos; });
}

TEST(Openness, CountsTheEdgesOfOneTriangleOnly) {
  const Mesh sheet = shellWithSheet().mesh;
  EXPECT_EQ(internal::openLength(sheet, sheet.triangles), 0);
  const Mesh open = punched(sheet);
  EXPECT_EQ(internal::openLength(open, open.triangles), 4);
}

// The boundary of the sheet, as long as the shell's circumference, is not the rim of a missing underside.
TEST(Openness, ASkullWithASheetInItGetsNoBase) {
  const double volume = signedVolume(shell().mesh);
  const Mesh skull = punched(shellWithSheet().mesh);
  const auto s = closeMesh(skull);
  ASSERT_TRUE(s) << s.error().message();
  EXPECT_EQ(s->report.rims_extruded, 0u);
  EXPECT_TRUE(s->report.exact);
  EXPECT_NEAR(signedVolume(s->mesh), volume, 1e-3 * volume);
  EXPECT_TRUE(says(s->report.changes, "1 sheet without thickness was dropped")) << s->report.changes.front();
  EXPECT_EQ(s->report.holes_filled, 1u);
  EXPECT_FALSE(says(s->report.warnings, "DIFFERS FROM THE SCAN"));
}

TEST(Openness, ASurfaceThatIsThereTwiceInPartsIsTakenOnce) {
  const double volume = signedVolume(shell().mesh);
  Mesh skull = shell().mesh;
  const std::size_t count = skull.triangles.size();
  // In stripes: their borders together are far longer than a rim.
  for (std::size_t t = 0; t < count; ++t)
    if (skull.corner(t, 0).x() > 0 && skull.corner(t, 1).x() > 0 && skull.corner(t, 2).x() > 0)
      skull.triangles.push_back(skull.triangles[t]);
  const auto s = closeMesh(punched(skull));
  ASSERT_TRUE(s) << s.error().message();
  EXPECT_EQ(s->report.rims_extruded, 0u);
  EXPECT_NEAR(signedVolume(s->mesh), volume, 1e-3 * volume);
}

// A sheet with its own hole might be part of a scan: closing drops nothing and adds nothing.
TEST(Openness, WhatCanNotBeToldIsWrappedAndSaidAloud) {
  Mesh skull = shellWithSheet().mesh;
  for (std::size_t t = skull.triangles.size() - 60; t < skull.triangles.size() - 58; ++t)
    skull.triangles[t] = {0, 0, 0};
  // The wrap fills the hollow. Kerf refuses more than twice the volume, unless the user accepts it.
  const auto filled = closeMesh(skull);
  ASSERT_FALSE(filled);
  EXPECT_NE(filled.error().hint.find("--accept-doubtful"), std::string::npos) << filled.error().message();
  EXPECT_EQ(filled.error().hint.find("--close wrap"), std::string::npos) << filled.error().message();

  const auto s = closeMesh(skull, {.accept_doubtful = true});
  ASSERT_TRUE(s) << s.error().message();
  EXPECT_EQ(s->report.rims_extruded, 0u);
  EXPECT_FALSE(s->report.exact);
  EXPECT_TRUE(says(s->report.changes, "no underside is missing"));
  EXPECT_TRUE(says(s->report.warnings, "DIFFERS FROM THE SCAN"));

  const auto refused = closeMesh(skull, {.mode = CloseMode::kRepair});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("no underside is missing"), std::string::npos) << refused.error().message();
}

TEST(Openness, ABaseThatIsAskedForIsBuilt) {
  const auto s = closeMesh(punched(shellWithSheet().mesh), {.mode = CloseMode::kBase});
  ASSERT_TRUE(s) << s.error().message();
  EXPECT_EQ(s->report.rims_extruded, 1u);
}

}  // namespace
}  // namespace kerf::openness_test
