// The triangles of a mesh that a picture needs: those that face the viewer and cover the middle of a pixel.
//
// Mesa, the renderer without a graphics card, takes 0.1 us to reject an invisible triangle. This takes 4 ns, on the
// thread that draws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/base/types.h"

namespace kerf::internal {

/// View of a mesh.
struct Sight {
  /// Object frame, mm -> (x w, y w, w). x, y: pixels, whole numbers in the middle of one. w: 1 at the camera's target.
  Eigen::Matrix<float, 3, 4> to_pixels = Eigen::Matrix<float, 3, 4>::Zero();
  bool has_backs = false;  ///< draws triangles seen from behind, too
  bool has_all = false;    ///< needs all triangles, with or without a covered pixel

  friend bool operator==(const Sight&, const Sight&) = default;
};

/// The vertices and triangles of one mesh, laid out for choosing. Thread: one at a time, any.
/// Times: 300 000 triangles with 150 000 vertices, one core of a shared virtual machine.
class SeenTriangles {
 public:
  void clear();
  void addVertex(const Vec3f& position);
  void addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  std::size_t triangles() const { return corners_[0].size(); }

  /// Projects the vertices for this sight: 2 ns each.
  void look(const Sight& sight);
  /// Appends those of the triangles first .. last - 1 that look()'s sight needs, three vertices each, in order. Keeps
  /// triangles that a driver's rounding could make visible: corners may be off by 1/32 pixel. 4 ns a triangle.
  void choose(std::size_t first, std::size_t last, std::vector<std::uint32_t>& out) const;

 private:
  std::vector<float> positions_[3];        // mm
  std::vector<float> pixels_[2];           // of look()
  std::vector<std::uint32_t> corners_[3];  // of triangles
  Vec3f farthest_ = Vec3f::Zero();         // mm, per axis
  float slack_ = 0;                        // pixels, of look()
  bool has_backs_ = false, has_all_ = true;
};

}  // namespace kerf::internal
