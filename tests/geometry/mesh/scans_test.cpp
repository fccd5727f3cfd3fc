// The readers and checkMesh against real scans with independent measurements. The scans are not part of the project:
// set KERF_DATA to their folder, or put it beside the sources as shared/data.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>

#include "geometry/formats/mesh_io.h"
#include "geometry/mesh/mesh_check.h"
#include "tests/support/places.h"

namespace kerf::scans_test {
namespace {

struct Scan {
  const char* file;
  std::size_t triangles, loops, boundary_edges, non_manifold_edges, flipped_edges, degenerate, duplicates, pieces;
  bool print_ready;
};

constexpr Scan kScans[] = {
    {"lower-jaw-scan-01-facecolour.ply", 16000, 2, 820, 3, 0, 0, 1, 5, false},
    {"upper-arch-scan-02.stl", 10000, 3, 1028, 0, 0, 0, 0, 2, false},
    {"upper-jaw-cast-scan-03-vertexcolour.ply", 53627, 1, 1507, 0, 0, 0, 0, 1, false},
    {"gingiva-strip-open.ply", 5852, 5, 1246, 0, 1, 0, 0, 13, false},
    {"lower-crowns-16-closed.obj", 84250, 0, 0, 0, 0, 0, 0, 16, false},
    {"tooth-19-molar-crown-root.stl", 43980, 0, 0, 0, 0, 0, 0, 1, true},
    {"tooth-22-canine-crown-root.stl", 24876, 0, 0, 0, 0, 0, 0, 1, true},
    {"molar-L6-enamel.stl", 5658, 0, 0, 0, 0, 0, 0, 1, true},
    {"molar-L6-dentin.stl", 13506, 0, 0, 0, 0, 0, 0, 1, true},
    {"molar-L6-pulp.stl", 5534, 0, 0, 0, 0, 0, 0, 1, true},
    {"molar-L6-pdl.stl", 10726, 0, 0, 0, 0, 0, 0, 1, true},
    {"mandible-block-L4-L6-cortical.stl", 8098, 0, 0, 0, 0, 0, 0, 1, true},
    {"mandible-block-L4-L6-cancellous.stl", 12560, 0, 0, 0, 0, 0, 0, 1, true},
    {"mandible-with-teeth-closed.obj", 41760, 0, 0, 0, 0, 0, 0, 1, true},
    {"mandible-with-teeth-nasty.obj", 27205, 15, 2249, 0, 0, 0, 0, 46, false},
    {"upper-teeth-cast-metres.obj", 28156, 28, 164, 0, 0, 0, 0, 8, false},
    {"dental-handpiece-with-bur.obj", 514, 0, 0, 0, 0, 0, 0, 1, true},
    {"nasty-bunny-holes-nonmanifold.ply", 99785, 70, 353, 132, 0, 0, 0, 1, false},
    {"nasty-self-intersecting.obj", 17160, 0, 0, 0, 0, 0, 0, 1, false},
    {"nasty-missing-faces-inch.stl", 3476, 16, 576, 0, 0, 0, 0, 1, false},
    {"nasty-binary-stl-solid-header.stl", 18808, 0, 0, 0, 0, 0, 0, 1, false},
    {"nasty-degenerate-triangles.obj", 10200, 0, 0, 0, 0, 200, 0, 1, false},
};

std::filesystem::path dataFolder() {
  if (const char* folder = std::getenv("KERF_DATA")) return folder;
  return std::filesystem::path(kSourceFolder) / ".." / "shared" / "data";
}

double millisecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

TEST(Scans, CountsAgreeWithIndependentMeasurement) {
  const std::filesystem::path folder = dataFolder();
  if (!std::filesystem::is_directory(folder))
    GTEST_SKIP() << "no scans at " << folder << ": set KERF_DATA to test on real scans";
  for (const Scan& scan : kScans) {
    SCOPED_TRACE(scan.file);
    const auto start = std::chrono::steady_clock::now();
    const auto file = readMesh(folder / scan.file);
    const double read_ms = millisecondsSince(start);
    ASSERT_TRUE(file) << file.error().message();
    const auto between = std::chrono::steady_clock::now();
    const MeshReport r = checkMesh(file->mesh);
    std::printf("%-42s %6zu triangles, read %5.1f ms, check %5.1f ms\n", scan.file, r.triangles, read_ms,
                millisecondsSince(between));
    EXPECT_EQ(r.triangles, scan.triangles);
    EXPECT_EQ(r.boundary_loops.size(), scan.loops);
    EXPECT_EQ(r.boundary_edges, scan.boundary_edges);
    EXPECT_EQ(r.non_manifold_edges, scan.non_manifold_edges);
    EXPECT_EQ(r.flipped_edges, scan.flipped_edges);
    EXPECT_EQ(r.degenerate_triangles, scan.degenerate);
    EXPECT_EQ(r.duplicate_triangles, scan.duplicates);
    EXPECT_EQ(r.pieces, scan.pieces);
    EXPECT_EQ(r.print_ready, scan.print_ready) << describe(r);
    if (std::string(scan.file).find("facecolour") != std::string::npos) {
      EXPECT_TRUE(file->mesh.hasFaceColors());
    }
    if (std::string(scan.file).find("vertexcolour") != std::string::npos) {
      EXPECT_TRUE(file->mesh.hasVertexColors());
    }
  }
  const auto points = readMesh(folder / "points-only-tooth.ply");
  ASSERT_FALSE(points);
  EXPECT_NE(points.error().found.find("2048 points"), std::string::npos);
  EXPECT_FALSE(readMesh(folder / "cbct-jaws-teeth-labels.nii.gz"));
  EXPECT_FALSE(readMesh(folder / "ct-skull-phantom-128-intensity.nrrd"));
}

}  // namespace
}  // namespace kerf::scans_test
