// The surface during cutting, in the window: chunks from the mesher, with ray and plane queries.
#pragma once

#include <array>
#include <optional>
#include <unordered_map>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/field/brick_field.h"
#include "sim/live/remesher.h"

namespace kerf {

struct Ray {
  Vec3d origin = Vec3d::Zero();       ///< mm
  Vec3d direction = -Vec3d::UnitZ();  ///< unit
  Vec3d at(double way) const { return origin + way * direction; }
};

struct SurfaceHit {
  Vec3d point = Vec3d::Zero();    ///< mm
  Vec3d normal = Vec3d::UnitZ();  ///< unit, outward, of the triangle
  double way = 0;                 ///< along the ray, mm
};

/// Not thread-safe.
class LiveSurface {
 public:
  /// Newer chunks replace older ones of the same brick; empty ones remove them.
  void update(std::span<const MeshChunkPtr> chunks);
  void clear() { *this = {}; }

  /// In no order.
  template <class Visit>
  void forEachChunk(const Visit& visit) const {
    for (const auto& [key, placed] : chunks_) visit(*placed.chunk);
  }
  std::size_t triangleCount() const { return triangles_; }
  Box3 bounds() const;
  /// Volume enclosed by the surface, mm^3. 0 while chunks are missing.
  double volume() const { return volume_; }
  /// The first triangle that faces the ray. O(chunks + triangles of the chunks on the ray).
  std::optional<SurfaceHit> hit(const Ray& ray) const;
  /// Distance along the ray, mm, where it leaves the material: the first triangle beyond `from` that faces away.
  std::optional<double> exit(const Ray& ray, double from) const;
  /// Section of the surface by a plane within a box: line segments in no order.
  /// @cost  by the chunks on the plane, 1 ms for a jaw.
  std::vector<std::array<Vec3d, 2>> contour(const Plane& plane, const Box3& within) const;

 private:
  struct Placed {
    MeshChunkPtr chunk;
    Box3 box;
    double volume = 0;  // of the tetrahedra from the origin to its triangles, mm^3
  };
  std::unordered_map<std::uint64_t, Placed> chunks_;
  std::size_t triangles_ = 0;
  double volume_ = 0;
};

/// Distance along a ray, mm, between `from` and `to`, where it first enters {field < 0}; none: never.
/// @param field  narrow band of distances. The ray steps by the sampled distance, so it misses nothing thicker than a
///   voxel.   @cost  some µs.
std::optional<double> entry(const BrickField& field, const Ray& ray, double from, double to);

}  // namespace kerf
