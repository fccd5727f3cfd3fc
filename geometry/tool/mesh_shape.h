// Distance to a closed mesh: parts of tools that do not turn, such as a handpiece.
#pragma once

#include <memory>

#include "geometry/mesh/mesh_distance.h"
#include "geometry/tool/tool_shape.h"

namespace kerf {

/// Exact signed distance to a closed mesh (MeshDistance). @cost about a microsecond for a few hundred triangles.
class MeshShape final : public ToolShape {
 public:
  /// @pre closed, 2-manifold, turned outwards, without self-intersections (checkMesh); mm.
  explicit MeshShape(const Mesh& mesh) : distance_(mesh) {}
  double distance(const Vec3d& p) const noexcept override { return distance_.nearest(p).signed_mm; }
  Box3 bounds() const override { return distance_.bounds(); }
  bool isConvex() const override { return false; }

 private:
  MeshDistance distance_;
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
