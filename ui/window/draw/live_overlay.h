// Planned cuts over the picture: slabs as wide as a kerf, lines, dots. OpenGL 3.3 core.
//
// Everything is drawn twice: clearly in front of the tissue, faintly behind or inside it. A slab has edge lines with a
// width in pixels, so that it stays visible edge-on.
#pragma once

#include <epoxy/gl.h>

#include <array>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"
#include "ui/app/view/camera.h"
#include "ui/window/gl/gl_program.h"

namespace kerf {

/// A planned saw cut. World frame, mm.
struct LiveSlab {
  /// Corners of the middle plane: entering left, entering right, far right, far left.
  std::array<Vec3d, 4> corners{};
  double thickness = 0.4;  ///< width of the kerf
  bool is_chosen = true;   ///< blue; else grey
  /// Segments where the middle plane meets the surface.
  std::vector<std::array<Vec3d, 2>> contour{};
  bool operator==(const LiveSlab&) const = default;
};

/// On top of everything.
struct LiveLine {
  Vec3d from = Vec3d::Zero(), to = Vec3d::Zero();
  bool operator==(const LiveLine&) const = default;
};

/// Overlay of one frame.
struct LivePlan {
  std::vector<LiveSlab> slabs{};
  std::vector<LiveLine> lines{};  ///< lines being drawn
  std::vector<Vec3d> dots{};      ///< picked points

  bool isEmpty() const { return slabs.empty() && lines.empty() && dots.empty(); }
  bool operator==(const LivePlan&) const = default;
};

namespace internal {

/// View of the frame.
struct OverlayView {
  Eigen::Matrix4d to_clip = Eigen::Matrix4d::Identity();
  Camera camera;
  double mm_per_pixel = 0.1;  ///< scale of a line's width, at the target: of the window, at its scale

  /// mm of so many pixels, at a point.
  double mm(double pixels, const Vec3d& at) const { return pixels * mm_per_pixel * camera.shrinkAt(at); }
};

/// Needs its OpenGL context current in every call, the destructor included.
class LiveOverlay {
 public:
  LiveOverlay();
  ~LiveOverlay();
  LiveOverlay(const LiveOverlay&) = delete;
  LiveOverlay& operator=(const LiveOverlay&) = delete;

  Expected<void> build();
  /// Draws into the bound framebuffer, over objects and their depth. Leaves depth test on, blending and culling off,
  /// depth writes on.
  void draw(const LivePlan& plan, const OverlayView& view);

 private:
  struct Corner {
    std::array<float, 3> position;
    std::array<float, 4> color;
  };
  void addFaces(const LiveSlab& slab);
  void addLine(const OverlayView& view, const Vec3d& from, const Vec3d& to, double pixels,
               const std::array<float, 4>& color, bool is_piece = false);
  void addSlabLines(const LiveSlab& slab, const OverlayView& view);
  void addDot(const Vec3d& at, const OverlayView& view);
  void flush(const OverlayView& view, double opacity);

  GlProgram program_;
  GLuint array_ = 0, buffer_ = 0;
  std::vector<Corner> corners_;
};

}  // namespace internal
}  // namespace kerf
