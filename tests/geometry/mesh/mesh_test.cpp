#include "geometry/mesh/mesh.h"

#include <gtest/gtest.h>

namespace kerf::mesh_test {
namespace {

Mesh tetrahedron(const Vec3d& at) {
  Mesh m;
  m.vertices = {at, at + Vec3d::UnitX(), at + Vec3d::UnitY(), at + Vec3d::UnitZ()};
  m.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return m;
}

TEST(Mesh, VolumeOfTetrahedronIsASixthWhereverItStands) {
  EXPECT_NEAR(signedVolume(tetrahedron(Vec3d::Zero())), 1.0 / 6, 1e-15);
  EXPECT_NEAR(signedVolume(tetrahedron({200, -300, 1000})), 1.0 / 6, 1e-12);
}

TEST(Mesh, PiecesAreCountedThroughEdges) {
  Mesh m = tetrahedron(Vec3d::Zero());
  append(m, tetrahedron({5, 0, 0}));
  const Pieces pieces = edgeConnectedPieces(m);
  EXPECT_EQ(pieces.count, 2u);
  EXPECT_EQ(pieces.label, (std::vector<std::uint32_t>{0, 0, 0, 0, 1, 1, 1, 1}));
}

TEST(Mesh, SubsetKeepsOrderAndColours) {
  Mesh m = tetrahedron(Vec3d::Zero());
  m.vertex_colors = {{1, 0, 0, 255}, {2, 0, 0, 255}, {3, 0, 0, 255}, {4, 0, 0, 255}};
  const Mesh s = subset(m, {0, 0, 1, 0});
  ASSERT_EQ(s.vertices.size(), 3u);
  EXPECT_EQ(s.vertex_colors[0][0], 2);
  EXPECT_EQ(s.triangles[0], (Triangle{0, 1, 2}));
}

}  // namespace
}  // namespace kerf::mesh_test
