#include "preprocess/voxelize/voxel_union.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>

#include <algorithm>
#include <cmath>

#include "geometry/field/marching_cubes.h"
#include "geometry/field/vdb_bricks.h"
#include "preprocess/voxelize/mesh_field.h"

namespace kerf {
namespace {

// The field plus a constant: another level of the same distance.
BrickField shifted(const BrickField& field, float by) {
  BrickField out(field.voxel(), field.background() + by, field.interior() + by);
  out.reserve(field.brickCount());
  for (std::size_t b = 0; b < field.brickCount(); ++b) {
    BrickValues values = field.brick(b);
    for (float& v : values) v += by;
    out.add(field.brickCoord(b), values);
  }
  for (const Vec3i& brick : field.interiorBricks()) out.markInterior(brick);
  return out;
}

}  // namespace

Expected<VoxelUnion> voxelUnion(std::span<const Mesh> solids, double voxel_mm, const Progress& progress) {
  try {
    openvdb::initialize();
    internal::Interrupter interrupter(progress);
    const auto h = static_cast<float>(voxel_mm);
    openvdb::FloatGrid::Ptr all;
    for (std::size_t n = 0; n < solids.size(); ++n) {
      if (!interrupter.step(0.6 * static_cast<double>(n) / static_cast<double>(solids.size()), "uniting fields"))
        return cancelled();
      const auto field = internal::meshField(solids[n], voxel_mm, {4, 4}, interrupter);
      if (interrupter.isCancelled()) return cancelled();
      if (!field) continue;
      if (all)
        openvdb::tools::csgUnion(*all, *field);
      else
        all = field;
    }
    if (!all || all->tree().leafCount() == 0)
      return fail({.code = Error::Code::kEmpty,
                   .place = "parts",
                   .found = "no surface at this voxel size",
                   .expected = "parts larger than a voxel",
                   .hint = "a finer voxel"});

    if (!interrupter.step(0.6, "closing gaps")) return cancelled();
    const BrickField near = internal::toBricks(*all);
    const Mesh outside = marchingCubes(shifted(near, -h));
    const auto back = internal::meshField(outside, voxel_mm, {3, 5}, interrupter);
    if (!back || interrupter.isCancelled()) return cancelled();

    if (!interrupter.step(0.9, "meshing")) return cancelled();

    VoxelUnion out;
    out.mesh = marchingCubes(shifted(internal::toBricks(*back), h));

    double sum = 0;
    for (const Vec3d& p : out.mesh.vertices) {
      const double off = std::abs(near.sample(p));
      sum += off * off;
      out.largest_off_mm = std::max(out.largest_off_mm, off);
    }
    if (!out.mesh.vertices.empty()) out.rms_off_mm = std::sqrt(sum / static_cast<double>(out.mesh.vertices.size()));
    return out;
  } catch (const std::bad_alloc&) {
    return fail(
        {.code = Error::Code::kBadValue, .place = "voxel size", .found = "out of memory", .hint = "a coarser --voxel"});
  } catch (const std::exception& e) {
    return fail({.code = Error::Code::kGeometry,
                 .place = "uniting parts",
                 .found = e.what(),
                 .expected = "closed meshes",
                 .hint = "kerf check on each mesh"});
  }
}

}  // namespace kerf
