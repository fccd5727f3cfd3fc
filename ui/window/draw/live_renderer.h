// Draws objects chunk by chunk during the cut, with the tool. OpenGL 3.3 core, one pass.
//
// Made for a processor without a graphics card: one pass over the triangles with all of the light in it, no pass over
// the picture; back faces and parts outside the view are skipped. Light is computed per vertex where triangles are a
// few pixels large and per pixel where they are larger. Cost of a frame: docs/how-it-works/window.md.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "geometry/base/error.h"
#include "sim/live/remesher.h"
#include "sim/live/tissue_section.h"
#include "ui/app/view/camera.h"
#include "ui/window/draw/live_overlay.h"
#include "ui/window/draw/live_tool.h"
#include "ui/window/gl/image.h"

namespace kerf {

/// One frame: everything beside the objects.
struct LiveFrame {
  std::optional<Rigid3> T_world_tool = {};  ///< none or not usable: no tool, tint, shadow nor line
  bool is_ghost = false;                    ///< the tool hovers: translucent
  double contact_mm = 0.3;                  ///< tints tissue this near to the cutting part; 0: no tint
  bool has_shadow = true;                   ///< dark outline of the cutting part along the approach: the entry place
  bool has_axis_line = true;                ///< from the tip along the approach, a tick every mm, on top of everything
  double axis_line_mm = 6;                  ///< its length
  /// Hides the side its normal points to. The inside shows flat, by setSection() or in `section_color`. Tools are not
  /// cut. Open meshes show their inside in the same colours.
  std::optional<Plane> section = {};
  Rgba8 section_color = {214, 168, 128, 255};
  LivePlan plan = {};     ///< planned cuts and picked points: translucent, over everything
  int supersampling = 1;  ///< n x n points a pixel, 1 to 3: smooth edges, 2 to 7 times the cost
  /// Bytes of surface copied to the graphics card in one frame, or one page more. The rest follows in the next frames:
  /// the longest waiting first, objects without any page last. Until then the old state is drawn. No limit: all at
  /// once, some 15 ms a MB in software.
  std::size_t most_upload = std::numeric_limits<std::size_t>::max();
  bool is_culled = true;  ///< false: sends everything to the pipeline. Same pixels; for tests
};

/// Counts of the last frame, for a panel and for tests.
struct LiveCounts {
  std::size_t triangles = 0;        ///< in all visible objects
  std::size_t drawn_triangles = 0;  ///< sent to the pipeline
  std::size_t draw_calls = 0;       ///< of objects
  std::size_t uploaded_bytes = 0;
  std::size_t waiting_pages = 0;  ///< changed pages, due in the next frames
  double half_depth_mm = 1;       ///< in parallel projection a depth d lies (1 - 2 d) times that above the target
};

/// The caller chooses the numbers of objects; one without chunks is empty.
/// Needs its OpenGL context current on the calling thread in every call, the destructor included.
class LiveRenderer {
 public:
  static Expected<std::unique_ptr<LiveRenderer>> create();
  ~LiveRenderer();

  /// Replaces the chunk of that brick; an empty one removes it. Costs a copy; the next draws upload it together with
  /// the chunks of the 8 x 8 x 8 bricks around, up to 500 KB: LiveFrame::most_upload.
  /// @param colours  per vertex, sRGB; alpha holds the gloss (tissue_colours.h). Empty: ivory.
  /// @param occlusion  per vertex (chunk_occlusion.h). Empty: all the light.
  /// A chunk with an index out of range, or with colours or occlusion of another length, counts as empty.
  void setChunk(std::size_t object, const MeshChunk& chunk, std::span<const Rgba8> colours = {},
                std::span<const std::uint8_t> occlusion = {});
  /// Identity by default. An object whose pose is not usable is not drawn.
  void setPose(std::size_t object, const Rigid3& T_world_object);
  void setVisible(std::size_t object, bool is_visible);  ///< default: true
  /// Draws its nearest surface translucent over all solid objects; a section is open in it. Default: false.
  void setGhost(std::size_t object, bool is_ghost);
  /// Face of the object where the next frames cut it open. The picture belongs to the plane of LiveFrame::section, in
  /// the object's frame. Copied to the graphics card. An empty one: `section_color`.
  void setSection(std::size_t object, const TissueSection& section);
  void removeObject(std::size_t object);  ///< with its pose and visibility
  void clear();                           ///< all objects; the tool stays
  /// Background gradient, sRGB: in the middle, at the corners. Default: a bluish grey.
  void setBackground(const Vec3f& middle, const Vec3f& edge);
  /// A few ms. An empty mesh: no tool.
  void setTool(const ToolLook& tool);

  /// Draws into the bound framebuffer and replaces its bytes. It needs a depth buffer and no stencil buffer. If a side
  /// is 0 or the camera is not finite, draws nothing, without an error. Leaves depth test, blending and culling off,
  /// and the framebuffer bound. A frame with a section, or supersampled, takes a copy more: 8 ms.
  /// @return an error if the framebuffer is gone or incomplete, or OpenGL reports one; the next call may succeed.
  Expected<void> draw(const Camera& camera, int width, int height, const LiveFrame& frame);
  /// The picture of everything set, 1 to 8192 pixels a side. Same chunks, camera, frame and driver: the same bytes, in
  /// any order of the chunks.
  Expected<Image> picture(const Camera& camera, int width, int height, const LiveFrame& frame);

  /// Counts of the last frame.
  const LiveCounts& counts() const;

  /// Changes when the same camera and frame would give another picture.
  std::uint64_t version() const;

 private:
  LiveRenderer();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf
