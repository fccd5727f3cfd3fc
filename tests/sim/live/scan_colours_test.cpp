#include "sim/live/scan_colours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "bench/scenes/carved_field.h"
#include "geometry/field/marching_cubes.h"
#include "geometry/field/sample_field.h"
#include "sim/live/tissue_colours.h"
#include "tests/support/open_block.h"

namespace kerf::scan_colours_test {
namespace {

constexpr double kVoxel = 0.1;
constexpr Rgba8 kTissue = {230, 200, 120, 90}, kRose = {220, 120, 130, 255}, kIvory = {240, 235, 210, 255};

/// A block of 6 x 6 x 4 mm, its top at z = 0.
BrickField block(double voxel) {
  return sampleDistance(
      [](const Vec3d& p) {
        const Vec3d q = (p - Vec3d(0, 0, -2)).cwiseAbs() - Vec3d(3, 3, 2);
        return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
      },
      {{-3, -3, -4}, {3, 3, 0}}, voxel);
}

/// The same block as a scan: its own triangles, rose at x < 0, ivory elsewhere.
enum class Per { kVertex, kFace };
Mesh scanned(Per per) {
  Mesh mesh = marchingCubes(block(0.07));
  const auto colourAt = [](double x) { return x < 0 ? kRose : kIvory; };
  if (per == Per::kVertex)
    for (const Vec3d& p : mesh.vertices) mesh.vertex_colors.push_back(colourAt(p[0]));
  else
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      mesh.face_colors.push_back(colourAt((mesh.corner(t, 0)[0] + mesh.corner(t, 1)[0] + mesh.corner(t, 2)[0]) / 3));
  return mesh;
}

/// On a side of the block, away from its edges, which voxels round off.
bool isOnASide(const Vec3d& p) {
  const Vec3d from_edge = (Vec3d(3, 3, 2) - (p - Vec3d(0, 0, -2)).cwiseAbs()).cwiseAbs();
  return (from_edge.array() < 0.15).count() < 2;
}

bool isNear(const Rgba8& a, const Rgba8& b, int most = 2) {
  for (std::size_t k = 0; k < 3; ++k)
    if (std::abs(int{a[k]} - int{b[k]}) > most) return false;
  return true;
}

/// Colours of all vertices after `edit` on the block, whose tissue has one colour.
using Check = std::function<void(const Vec3d& p, const Rgba8& colour)>;
void forEach(const ScanColours& scan, const std::function<std::vector<BrickEdit>(OverlayField&)>& edit,
             const Check& check) {
  const BrickField phi0 = block(kVoxel);
  Remesher remesher(phi0, {.marching_cubes = {}, .is_parallel = false});
  if (edit) {
    OverlayField field(phi0);
    remesher.apply(edit(field));
  }
  for (const MeshChunkPtr& known : remesher.changedSince(0)) {
    MeshChunk chunk = *known;
    chunk.colours.assign(chunk.vertices.size(), kTissue);
    const std::vector<Rgba8> colours = scanColours(chunk, scan, phi0);
    ASSERT_EQ(colours.size(), chunk.vertices.size());
    for (std::size_t v = 0; v < colours.size(); ++v) {
      EXPECT_EQ(colours[v][3], kTissue[3]) << "the gloss is that of the tissue";
      check(chunk.vertices[v].cast<double>(), colours[v]);
    }
  }
}

TEST(ScanColours, ABlockOfTwoColoursKeepsItsHalves) {
  for (const Per per : {Per::kVertex, Per::kFace}) {
    const auto scan = ScanColours::of(scanned(per));
    ASSERT_TRUE(scan);
    int rose = 0, ivory = 0;
    forEach(*scan, {}, [&](const Vec3d& p, const Rgba8& colour) {
      if (std::abs(p[0]) < 0.2 || !isOnASide(p)) return;  // 0.2 mm: as wide as triangles of the scan
      EXPECT_TRUE(isNear(colour, p[0] < 0 ? kRose : kIvory)) << p.transpose();
      ++(p[0] < 0 ? rose : ivory);
    });
    EXPECT_GT(rose, 1000);
    EXPECT_GT(ivory, 1000);
  }
}

TEST(ScanColours, AcrossATriangleTheyAreMixed) {
  Mesh box = test::blockMesh(true, {6, 6, 4});  // two triangles a side
  for (const Vec3d& p : box.vertices) box.vertex_colors.push_back(p[0] < 0 ? kRose : kIvory);
  const auto scan = ScanColours::of(box);
  ASSERT_TRUE(scan);
  int vertices = 0;
  forEach(*scan, {}, [&](const Vec3d& p, const Rgba8& colour) {
    const double share = std::clamp(p[0] / 6 + 0.5, 0.0, 1.0);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(colour[k], (1 - share) * kRose[k] + share * kIvory[k], 2) << p.transpose();
    ++vertices;
  });
  EXPECT_GT(vertices, 5000);
}

TEST(ScanColours, TheFloorOfACutHasTheColourOfItsTissue) {
  const auto scan = ScanColours::of(scanned(Per::kVertex));
  ASSERT_TRUE(scan);
  int cut = 0, sound = 0;
  forEach(
      *scan,
      [](OverlayField& field) {
        return scenes::carve(field, {0.8, 0, 0}, 1.5);
      },
      [&](const Vec3d& p, const Rgba8& colour) {
        const bool is_floor = std::abs((p - Vec3d(0.8, 0, 0)).norm() - 1.5) < 0.05 && p[2] < -1.4 * kVoxel;
        if (is_floor) {
          EXPECT_TRUE(isNear(colour, kTissue, 0)) << p.transpose();
          ++cut;
        } else if (p[2] > -0.01 && isOnASide(p) && (p - Vec3d(0.8, 0, 0)).norm() > 1.6 && std::abs(p[0]) > 0.2) {
          EXPECT_TRUE(isNear(colour, p[0] < 0 ? kRose : kIvory)) << p.transpose();
          ++sound;
        }
      });
  EXPECT_GT(cut, 200);
  EXPECT_GT(sound, 200);
}

TEST(ScanColours, WhatWasAddedHasTheColourOfItsTissue) {
  const auto scan = ScanColours::of(scanned(Per::kFace));
  ASSERT_TRUE(scan);
  int added = 0;
  forEach(
      *scan,
      [](OverlayField& field) {
        return scenes::carve(field, {0, 0, 0}, 1, true);
      },
      [&](const Vec3d& p, const Rgba8& colour) {
        if (p[2] < 2.2 * kVoxel) return;
        EXPECT_TRUE(isNear(colour, kTissue, 0)) << p.transpose();
        ++added;
      });
  EXPECT_GT(added, 100);
}

TEST(ScanColours, ASolidWithoutColoursHasNone) { EXPECT_FALSE(ScanColours::of(marchingCubes(block(0.3)))); }

}  // namespace
}  // namespace kerf::scan_colours_test
