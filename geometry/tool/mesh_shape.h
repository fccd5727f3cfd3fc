// Distance to a closed mesh: parts of tools that do not turn, such as a handpiece.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "geometry/mesh/mesh.h"
#include "geometry/tool/tool_shape.h"

namespace kerf {

/// Exact signed distance to a closed mesh: the nearest triangle by a tree of boxes, the side by the pseudonormal of the
/// nearest corner, edge or face (Baerentzen & Aanaes 2005). @cost about a microsecond for a few hundred triangles.
class MeshShape final : public ToolShape {
 public:
  /// @pre closed, 2-manifold, turned outwards, without self-intersections (checkMesh); mm.
  explicit MeshShape(const Mesh& mesh);
  double distance(const Vec3d& p) const noexcept override;
  Box3 bounds() const override { return box_; }
  bool isConvex() const override { return false; }

 private:
  struct Node {
    Box3 box;
    std::uint32_t first = 0, count = 0;  ///< triangles of a leaf, in order_; an inner node has none ...
    std::uint32_t right = 0;             ///< ... but its left child right behind it, and this one
  };
  struct Corners {
    std::array<Vec3d, 3> at;
    Vec3d face;
    std::array<Vec3d, 3> edge, corner;  ///< pseudonormals; edge k runs from corner k to k + 1
  };
  std::uint32_t build(std::uint32_t first, std::uint32_t count, const std::vector<Vec3d>& centers);

  Box3 box_;
  std::vector<Corners> triangles_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

/// The part of a solid above a level z. Exact inside; outside a lower bound if the rest of the solid or the
/// rim of the cut is nearer. The zero level is exact.
class HalfShape final : public ToolShape {
 public:
  HalfShape(std::shared_ptr<const ToolShape> solid, double level) : solid_(std::move(solid)), level_(level) {}
  double distance(const Vec3d& p) const noexcept override;
  Box3 bounds() const override;
  bool isConvex() const override { return solid_->isConvex(); }

 private:
  std::shared_ptr<const ToolShape> solid_;
  double level_;
};

}  // namespace kerf
