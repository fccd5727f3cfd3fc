// Draws objects while they are cut, chunk by chunk, with the tool that cuts them. OpenGL 3.3 core, one pass.
//
// Made for a processor without a graphics card: one pass over the triangles with all of the light in it, no pass over
// the picture, back faces and what lies outside the view left out. Light is computed per vertex where triangles are a
// few pixels large and per pixel where they are larger. What a frame costs: docs/how-it-works/window.md.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "geometry/base/error.h"
#include "sim/live/remesher.h"
#include "sim/live/tissue_section.h"
#include "ui/app/camera.h"
#include "ui/window/image.h"
#include "ui/window/live_overlay.h"
#include "ui/window/live_tool.h"

namespace kerf {

/// What one frame shows beside the objects.
struct LiveFrame {
  std::optional<Rigid3> T_world_tool = {};  ///< none, or one that is not usable: no tool, tint, shadow nor line
  bool is_ghost = false;                    ///< the tool hovers: translucent
  double contact_mm = 0.3;                  ///< tissue this near to what cuts is tinted; 0: no tint
  bool has_shadow = true;                   ///< outline of what cuts, dark, along the approach: where it would go in
  bool has_axis_line = true;                ///< from the tip along the approach, a tick every mm, on top of everything
  double axis_line_mm = 6;                  ///< its length
  /// What lies on the side its normal points to is not drawn; the inside shows flat, as setSection() says, or in
  /// `section_color`. Tools are not cut. Open meshes show their inside in the same colours.
  std::optional<Plane> section = {};
  Rgba8 section_color = {214, 168, 128, 255};
  LivePlan plan = {};     ///< planned cuts, and what is being picked: translucent, over everything
  int supersampling = 1;  ///< n x n points a pixel, 1 to 3: smooth edges, 2 to 7 times the cost
  /// Bytes of surface that are copied to the graphics card in one frame, or one page more. The rest comes with the next
  /// frames, what waits longest first, an object of which nothing is there yet last; until then it is drawn as it was.
  /// No limit: all at once, some 15 ms a MB in software.
  std::size_t most_upload = std::numeric_limits<std::size_t>::max();
  bool is_culled = true;  ///< false: everything goes through the pipeline. The pixels are the same; for tests
};

/// Counts of the last frame, for a panel and for tests.
struct LiveCounts {
  std::size_t triangles = 0;        ///< in all visible objects
  std::size_t drawn_triangles = 0;  ///< sent to the pipeline
  std::size_t draw_calls = 0;       ///< of objects
  std::size_t uploaded_bytes = 0;
  std::size_t waiting_pages = 0;  ///< that changed, and come with the next frames
  double half_depth_mm = 1;       ///< in parallel projection a depth d lies (1 - 2 d) times that above the target
};

/// Objects are numbers that the caller chooses; one that was never given a chunk is empty.
/// Needs its OpenGL context current on the calling thread in every call, the destructor included.
class LiveRenderer {
 public:
  static Expected<std::unique_ptr<LiveRenderer>> create();
  ~LiveRenderer();

  /// Replaces the chunk of that brick; an empty one removes it. Costs a copy; uploaded by the next draws together with
  /// the chunks of the 8 x 8 x 8 bricks around, up to 500 KB: LiveFrame::most_upload.
  /// @param colours  per vertex, sRGB; in the place of alpha the gloss (tissue_colours.h). Empty: ivory.
  /// @param occlusion  per vertex (chunk_occlusion.h). Empty: all the light.
  /// A chunk with an index out of range, or with colours or occlusion of another length, is taken as empty.
  void setChunk(std::size_t object, const MeshChunk& chunk, std::span<const Rgba8> colours = {},
                std::span<const std::uint8_t> occlusion = {});
  /// Identity until set. An object whose pose is not usable is not drawn.
  void setPose(std::size_t object, const Rigid3& T_world_object);
  void setVisible(std::size_t object, bool is_visible);  ///< true until set
  /// Its nearest surface is drawn translucent over all solid things; a section is open in it. False until set.
  void setGhost(std::size_t object, bool is_ghost);
  /// What the object shows where the next frames cut it open. The picture is of the plane of LiveFrame::section, in the
  /// object's frame. Copied to the graphics card. An empty one: `section_color`.
  void setSection(std::size_t object, const TissueSection& section);
  void removeObject(std::size_t object);  ///< its pose and visibility, too
  void clear();                           ///< all objects; the tool stays
  /// Of the gradient behind everything, sRGB: in the middle, at the corners. A bluish grey until set.
  void setBackground(const Vec3f& middle, const Vec3f& edge);
  /// A few ms. An empty mesh: no tool.
  void setTool(const ToolLook& tool);

  /// Draws into the framebuffer that is bound; its bytes are replaced. It needs a depth buffer and no stencil buffer.
  /// Nothing is drawn, and that is no error, if a side is 0 or the camera is not finite. Leaves depth test, blending
  /// and culling off, and the framebuffer bound. A frame with a section, or supersampled, takes a copy more: 8 ms.
  /// @return an error if the framebuffer is gone or incomplete, or OpenGL reports one; the next call may succeed.
  Expected<void> draw(const Camera& camera, int width, int height, const LiveFrame& frame);
  /// The picture, 1 to 8192 pixels a side, of all that was set. Same chunks, camera, frame and driver: the same bytes,
  /// whatever the order in which the chunks came.
  Expected<Image> picture(const Camera& camera, int width, int height, const LiveFrame& frame);

  /// Of the last frame.
  const LiveCounts& counts() const;

  /// Another number when the same camera and frame would show another picture.
  std::uint64_t version() const;

 private:
  LiveRenderer();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kerf
