#include "preprocess/voxelize/mesh_field.h"

#include <openvdb/tools/Composite.h>
#include <openvdb/tools/MeshToVolume.h>

#include <numeric>
#include <span>

#include "preprocess/close/nesting.h"

namespace kerf::internal {
namespace {

using openvdb::FloatGrid;

// Lets OpenVDB read a Mesh in place, in voxel units.
struct MeshAdapter {
  const Mesh& mesh;
  std::span<const std::uint32_t> triangles;
  bool reversed;
  double voxel;

  std::size_t polygonCount() const { return triangles.size(); }
  std::size_t pointCount() const { return mesh.vertices.size(); }
  std::size_t vertexCount(std::size_t) const { return 3; }
  void getIndexSpacePoint(std::size_t n, std::size_t v, openvdb::Vec3d& pos) const {
    const Triangle& t = mesh.triangles[triangles[n]];
    const Vec3d& p = mesh.vertices[t[reversed && v > 0 ? 3 - v : v]];
    pos = openvdb::Vec3d(p[0], p[1], p[2]) / voxel;
  }
};

FloatGrid::Ptr levelField(const Mesh& mesh, const NestingLevel& level, double voxel_mm, const Bands& bands,
                          Interrupter& interrupter) {
  const MeshAdapter adapter{mesh, level.triangles, level.is_void, voxel_mm};
  const auto transform = openvdb::math::Transform::createLinearTransform(voxel_mm);
  // A void is made as a solid and subtracted: its exterior band is the tissue around it.
  return openvdb::tools::meshToVolume<FloatGrid>(interrupter, adapter, *transform,
                                                 level.is_void ? bands.interior : bands.exterior,
                                                 level.is_void ? bands.exterior : bands.interior);
}

}  // namespace

FloatGrid::Ptr meshField(const Mesh& solid, double voxel_mm, const Bands& bands, Interrupter& interrupter) {
  FloatGrid::Ptr phi;
  for (const NestingLevel& level : nestingLevels(solid)) {
    const FloatGrid::Ptr field = levelField(solid, level, voxel_mm, bands, interrupter);
    if (interrupter.isCancelled()) return nullptr;
    if (!phi)
      phi = field;
    else if (level.is_void)
      openvdb::tools::csgDifference(*phi, *field);
    else
      openvdb::tools::csgUnion(*phi, *field);
  }
  return phi;
}

FloatGrid::Ptr bareMeshField(const Mesh& solid, double voxel_mm, const Bands& bands, Interrupter& interrupter) {
  NestingLevel all;
  all.triangles.resize(solid.triangles.size());
  std::iota(all.triangles.begin(), all.triangles.end(), 0u);
  return levelField(solid, all, voxel_mm, bands, interrupter);
}

}  // namespace kerf::internal
