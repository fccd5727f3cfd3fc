// Pages that collect the chunks of one object for the graphics card, so that a frame takes tens of draw calls, 13 us
// each, instead of thousands.
#pragma once

#include <epoxy/gl.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "geometry/base/types.h"
#include "sim/live/remesher.h"
#include "ui/window/draw/seen_triangles.h"

namespace kerf::internal {

/// Vertex layout of the shaders.
struct LiveVertex {
  Vec3f position;                      ///< object frame, mm
  std::array<std::int16_t, 3> normal;  ///< unit, of 32767
  std::int16_t open = 32767;           ///< share of the ambient light, of 32767
  Rgba8 color;                         ///< alpha: gloss
};
static_assert(sizeof(LiveVertex) == 24);

/// A stored chunk.
struct LiveChunk {
  std::vector<LiveVertex> vertices;
  std::vector<std::array<std::uint16_t, 3>> triangles;
  Box3 box;  ///< object frame, mm
};
/// Empty for a chunk without triangles, and for an invalid one.
LiveChunk liveChunk(const MeshChunk& chunk, std::span<const Rgba8> colours, std::span<const std::uint8_t> occlusion);

/// The chunks of 8 x 8 x 8 bricks in one vertex buffer. Needs the context current, the destructor too.
class LivePage {
 public:
  static constexpr int kBricksLog = 3;

  LivePage() = default;
  ~LivePage();
  LivePage(const LivePage&) = delete;
  LivePage& operator=(const LivePage&) = delete;

  /// Replaces a chunk; an empty one removes it.
  void set(const Vec3i& brick, LiveChunk chunk);
  bool isEmpty() const { return chunks_.empty(); }
  bool isDirty() const { return is_dirty_; }         ///< changed since upload(); the old state is drawn
  bool isNew() const { return vertex_array_ == 0; }  ///< not drawn yet
  /// Calls of wait() since it is dirty.
  std::uint32_t waited() const { return waited_; }
  void wait() { ++waited_; }
  /// Brings vertices and box up to date. @return bytes uploaded.
  std::size_t upload();

  /// Chooses the triangles that this sight needs (seen_triangles.h). Does nothing if neither sight nor chunks changed.
  /// @return bytes uploaded.
  std::size_t choose(const Sight& sight);

  /// A chunk in the list of indices that choose() chose.
  struct Range {
    std::size_t first = 0, count = 0;
    Box3 box;  ///< object frame, mm
  };
  const std::vector<Range>& ranges() const { return ranges_; }
  const Box3& box() const { return box_; }  ///< object frame, mm
  std::size_t triangles() const { return triangles_.triangles(); }
  double meanEdge() const { return mean_edge_; }  ///< mm
  GLuint vertexArray() const { return vertex_array_; }

 private:
  std::map<std::array<int, 3>, LiveChunk> chunks_;  // ordered: the picture does not depend on the order of arrival
  GLuint vertex_array_ = 0, vertex_buffer_ = 0, index_buffer_ = 0;
  SeenTriangles triangles_;                  // of all chunks
  std::vector<std::size_t> first_of_chunk_;  // in triangles_; one more at the end
  std::vector<Range> ranges_;
  std::optional<Sight> chosen_;  // none: no choice yet
  Box3 box_;
  double mean_edge_ = 0;
  bool is_dirty_ = false;
  std::uint32_t waited_ = 0;
};

}  // namespace kerf::internal
