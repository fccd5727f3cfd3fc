// Scanner colours of a chunk's vertices: the colour of the nearest place of the scan.
#pragma once

#include <memory>
#include <vector>

#include "geometry/field/brick_field.h"
#include "geometry/mesh/box_tree.h"
#include "geometry/mesh/mesh.h"
#include "sim/live/remesher.h"

namespace kerf {

/// Colours of a case's solid. Never changes: any thread may read it.
class ScanColours {
 public:
  /// Null: the solid has no colours.   @param solid  of the case, mm.
  /// @cost  0.4 us and 160 bytes a triangle.
  static std::shared_ptr<const ScanColours> of(Mesh solid);

  const Mesh& solid() const { return solid_; }
  /// Numbers of the triangles whose boxes meet this one, in no order.
  std::vector<std::uint32_t> near(const Box3& box) const;
  /// With vertex colours, their mix over the triangle's corners; else the triangle's own.
  /// @param weights  of its corners: not negative, 1 in all.
  Rgba8 colourAt(std::uint32_t triangle, const Vec3d& weights) const;

 private:
  explicit ScanColours(Mesh solid);

  Mesh solid_;
  BoxTree tree_;
};

/// One colour per vertex of the chunk, sRGB; alpha holds the gloss of the chunk's own colours. A vertex within a voxel
/// of the scan has the scan's colour. From there to two voxels, and where the surface was cut (cutShare()), it blends
/// into the chunk's own colour, which is that of its tissue.
/// Pure: the same chunk, the same bytes. Any thread. The triangles near a chunk are looked up once for all of it.
/// @param original  the field of the case before the cut.
/// @pre  chunk.colours has one per vertex.
std::vector<Rgba8> scanColours(const MeshChunk& chunk, const ScanColours& scan, const BrickField& original);

}  // namespace kerf
