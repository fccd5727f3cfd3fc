// The colour of each vertex of a chunk as the scanner saw it: that of the nearest place of the scan.
#pragma once

#include <memory>
#include <vector>

#include "geometry/field/brick_field.h"
#include "geometry/mesh/box_tree.h"
#include "geometry/mesh/mesh.h"
#include "sim/live/remesher.h"

namespace kerf {

/// The solid of a case, to be asked for its colours. Never changes: any thread may ask.
class ScanColours {
 public:
  /// Null: the solid has no colours.   @param solid  of the case, mm.
  /// @cost  0.4 us and 160 bytes a triangle.
  static std::shared_ptr<const ScanColours> of(Mesh solid);

  const Mesh& solid() const { return solid_; }
  /// Numbers of the triangles whose boxes meet this one, in no order.
  std::vector<std::uint32_t> near(const Box3& box) const;
  /// Where vertices have colours, mixed of those of the triangle's corners; else the triangle's own.
  /// @param weights  of its corners: not negative, 1 in all.
  Rgba8 colourAt(std::uint32_t triangle, const Vec3d& weights) const;

 private:
  explicit ScanColours(Mesh solid);

  Mesh solid_;
  BoxTree tree_;
};

/// One colour per vertex of the chunk, sRGB; the gloss in the place of alpha is that of the chunk's own colours. A
/// vertex within a voxel of the scan has the scan's colour. From there to two voxels, and where the surface was cut
/// (cutShare()), it goes over into the chunk's own, which is that of its tissue.
/// Pure: the same chunk, the same bytes. Any thread. The triangles near a chunk are looked up once for all of it.
/// @param original  the field of the case, before anything was cut.
/// @pre  chunk.colours has one per vertex.
std::vector<Rgba8> scanColours(const MeshChunk& chunk, const ScanColours& scan, const BrickField& original);

}  // namespace kerf
