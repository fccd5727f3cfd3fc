#include "preprocess/demo/demo_arch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "geometry/mesh/mesh_check.h"
#include "preprocess/close/close.h"
#include "preprocess/demo/demo_jaw.h"

namespace kerf::demo_arch_test {
namespace {

const DemoArchOptions kCoarse{.edge_mm = 0.5};

class DemoArchScan : public ::testing::Test {
 protected:
  static const DemoArch& arch() {
    static const DemoArch arch = *demoArch(kCoarse);
    return arch;
  }
};

TEST_F(DemoArchScan, HasTheFaultsItClaimsAndNoOthers) {
  const DemoArchDefects& d = arch().defects;
  EXPECT_EQ(d.pin_holes, 3u);
  EXPECT_EQ(d.islands, 2u);
  EXPECT_EQ(d.spikes, 1u);
  EXPECT_GT(d.flipped_triangles, 5u);

  const MeshReport report = checkMesh(arch().mesh);
  EXPECT_EQ(report.pieces, 1 + d.islands);
  ASSERT_EQ(report.boundary_loops.size(), d.rims + d.pin_holes + d.islands);
  EXPECT_GT(report.boundary_loops[0].length, 250);  // mm around the jaw
  std::size_t small = 0;
  for (const BoundaryLoop& loop : report.boundary_loops) small += loop.edges <= 15;
  EXPECT_EQ(small, d.pin_holes + d.islands);

  EXPECT_EQ(report.flipped_edges, d.flipped_edges);
  EXPECT_EQ(report.non_manifold_edges, 0u);
  EXPECT_EQ(report.non_manifold_vertices, 0u);
  EXPECT_EQ(report.degenerate_triangles, 0u);
  EXPECT_EQ(report.duplicate_triangles, 0u);
  EXPECT_EQ(report.self_intersections, 0u);

  const Pieces pieces = edgeConnectedPieces(arch().mesh);
  std::vector<std::size_t> size(pieces.count, 0);
  for (const std::uint32_t label : pieces.label) ++size[label];
  EXPECT_EQ(size[1] + size[2], d.island_triangles);

  // One vertex of the large piece stands far off.
  std::size_t spikes = 0;
  std::vector<char> counted(arch().mesh.vertices.size(), 0);
  for (std::size_t t = 0; t < size[0]; ++t)
    for (const std::uint32_t v : arch().mesh.triangles[t])
      if (!counted[v]) {
        counted[v] = 1;
        spikes += std::abs(internal::archSurface(arch().mesh.vertices[v])) > 0.5;
      }
  EXPECT_EQ(spikes, d.spikes);
}

TEST_F(DemoArchScan, IsAsNoisyAsAScanner) {
  // Far outliers are the spike and the islands.
  double sum = 0;
  int count = 0;
  for (const Vec3d& p : arch().mesh.vertices) {
    const double value = internal::archSurface(p);
    Vec3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3d d = 1e-4 * Vec3d::Unit(axis);
      gradient[axis] = (internal::archSurface(p + d) - internal::archSurface(p - d)) / 2e-4;
    }
    if (const double off = value / gradient.norm(); std::abs(off) < 0.1) {
      sum += off * off;
      ++count;
    }
  }
  EXPECT_GT(count, 20000);
  EXPECT_GT(1000 * std::sqrt(sum / count), 5);   // um
  EXPECT_LT(1000 * std::sqrt(sum / count), 12);  // um
}

TEST_F(DemoArchScan, IsAnArchOfTeethAndGums) {
  const Box3 box = bounds(arch().mesh);
  EXPECT_GT(box.size().x(), 60);
  EXPECT_LT(box.size().x(), 90);
  EXPECT_GT(box.size().y(), 45);
  EXPECT_LT(box.size().y(), 60);
  EXPECT_NEAR(box.max.z(), 0.5, 1.0);  // the occlusal plane is z = 0
  ASSERT_EQ(arch().mesh.vertex_colors.size(), arch().mesh.vertices.size());
  // Ivory is nearly as green as red, pink is not.
  for (std::size_t v = 0; v < arch().mesh.vertices.size(); ++v) {
    const Vec3d& p = arch().mesh.vertices[v];
    const int redder = arch().mesh.vertex_colors[v][0] - arch().mesh.vertex_colors[v][1];
    if (p.z() > -3) {
      ASSERT_LT(redder, 30) << p.transpose();
    }
    if (p.z() < -13) {
      ASSERT_GT(redder, 60) << p.transpose();
    }
  }
}

TEST_F(DemoArchScan, ClosesIntoASolid) {
  const auto closed = closeMesh(arch().mesh);
  ASSERT_TRUE(closed) << closed.error().message();
  const MeshReport report = checkMesh(closed->mesh);
  EXPECT_TRUE(report.print_ready) << describe(report);
  EXPECT_EQ(report.pieces, 1u);
  EXPECT_GT(closed->report.triangles_kept, 0.97 * static_cast<double>(arch().mesh.triangles.size()));
}

TEST_F(DemoArchScan, SeedDecides) {
  DemoArchOptions options{.edge_mm = 0.9};
  const DemoArch first = *demoArch(options), again = *demoArch(options);
  EXPECT_EQ(again.mesh.triangles, first.mesh.triangles);
  EXPECT_TRUE(again.mesh.vertices == first.mesh.vertices);
  EXPECT_EQ(again.mesh.vertex_colors, first.mesh.vertex_colors);
  options.seed = 37;
  EXPECT_NE(demoArch(options)->mesh.triangles, first.mesh.triangles);
}

TEST_F(DemoArchScan, RefusesWhatItCanNotMakeAndStopsWhenCancelled) {
  EXPECT_EQ(demoArch({.edge_mm = 0.01}).error().code, Error::Code::kBadValue);
  EXPECT_EQ(demoArch({.edge_mm = std::nan("")}).error().code, Error::Code::kBadValue);
  EXPECT_EQ(demoArch({.noise_mm = -1}).error().code, Error::Code::kBadValue);
  const auto stopped = demoArch(kCoarse, [](double fraction, std::string_view) { return fraction < 0.3; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Error::Code::kCancelled);
}

}  // namespace
}  // namespace kerf::demo_arch_test
