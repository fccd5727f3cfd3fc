#include "ui/window/draw/live_overlay.h"

#include <cmath>
#include <cstddef>

namespace kerf::internal {
namespace {

constexpr const char* kVersion = "#version 330 core\n";
constexpr const char* kVertex = R"(
layout(location = 0) in vec3 position;  // world, mm
layout(location = 1) in vec4 color;     // sRGB, alpha
uniform mat4 to_clip;
noperspective out vec4 shown;
void main() {
  gl_Position = to_clip * vec4(position, 1.0);
  shown = color;
}
)";
constexpr const char* kFragment = R"(
noperspective in vec4 shown;
uniform float opacity;
out vec4 result;
void main() { result = vec4(shown.rgb, shown.a * opacity); }
)";

using Color = std::array<float, 4>;
constexpr Color kChosenFace{0.11f, 0.47f, 0.80f, 0.34f}, kOtherFace{0.36f, 0.42f, 0.50f, 0.22f};
constexpr Color kChosenEdge{0.04f, 0.25f, 0.52f, 0.95f}, kOtherEdge{0.27f, 0.32f, 0.39f, 0.85f};
constexpr Color kHalo{1, 1, 1, 0.40f}, kDrawn{0.04f, 0.25f, 0.52f, 1}, kPicked{0.04f, 0.33f, 0.66f, 1};

constexpr double kEdgePixels = 1.6, kTeethPixels = 2.6, kContourPixels = 2.8, kHaloPixels = 1.6, kDotPixels = 9;
constexpr double kNearer = 0.08;  // mm towards the viewer: keeps a line on the surface from sinking half into it
constexpr double kHidden = 0.30;  // of the opacity, behind tissue
constexpr double kArrow = 5;      // mm: entry side of the teeth
constexpr double kArrowHead = 1.2;

Vec3d normalOf(const LiveSlab& slab) {
  const Vec3d across = slab.corners[1] - slab.corners[0], along = slab.corners[3] - slab.corners[0];
  const Vec3d n = along.cross(across);
  return n.norm() > 1e-12 ? Vec3d(n.normalized()) : Vec3d(Vec3d::UnitZ());
}

}  // namespace

LiveOverlay::LiveOverlay() {
  glGenVertexArrays(1, &array_);
  glGenBuffers(1, &buffer_);
  glBindVertexArray(array_);
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Corner), bufferOffset(offsetof(Corner, position)));
  glVertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, sizeof(Corner), bufferOffset(offsetof(Corner, color)));
  glEnableVertexAttribArray(0);
  glEnableVertexAttribArray(1);
}

LiveOverlay::~LiveOverlay() {
  glDeleteVertexArrays(1, &array_);
  glDeleteBuffers(1, &buffer_);
  glDeleteProgram(program_.id);
}

Expected<void> LiveOverlay::build() { return program_.build({kVersion, kVertex}, {kVersion, kFragment}); }

// A box around the middle plane, outward: being convex, its faces towards the viewer form one layer.
void LiveOverlay::addFaces(const LiveSlab& slab) {
  const Vec3d half = 0.5 * slab.thickness * normalOf(slab);
  std::array<Vec3d, 8> p;
  for (std::size_t n = 0; n < 4; ++n) {
    p[n] = slab.corners[n] - half;
    p[n + 4] = slab.corners[n] + half;
  }
  const Color& color = slab.is_chosen ? kChosenFace : kOtherFace;
  static constexpr std::array<std::array<std::size_t, 4>, 6> kFaces = {
      {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}}};
  for (const auto& face : kFaces)
    for (const std::size_t n : {0, 1, 2, 0, 2, 3}) {
      const Vec3f at = p[face[n]].cast<float>();
      corners_.push_back({{at[0], at[1], at[2]}, color});
    }
}

// A strip that faces the viewer, longer by half of its width at either end: corners are whole. Pieces of a long line
// are not lengthened: overlaps would be darker.
void LiveOverlay::addLine(const OverlayView& view, const Vec3d& from, const Vec3d& to, double pixels,
                          const Color& color, bool is_piece) {
  const Vec3d to_viewer = view.camera.towardsViewer(0.5 * (from + to));
  Vec3d along = to - from;
  along -= to_viewer.dot(along) * to_viewer;
  const double length = along.norm();
  along = length > 1e-9 ? Vec3d(along / length) : view.camera.right();

  const Vec3d aside = to_viewer.cross(along), nearer = (is_piece ? kNearer : 0) * to_viewer;
  const auto corner = [&](const Vec3d& end, double outwards, double side) -> Vec3d {
    const double half = view.mm(0.5 * pixels, end);
    return end + half * ((is_piece ? 0 : outwards) * along + side * aside) + nearer;
  };
  const std::array<Vec3d, 4> p = {corner(from, -1, -1), corner(from, -1, 1), corner(to, 1, 1), corner(to, 1, -1)};
  for (const std::size_t n : {0, 1, 2, 0, 2, 3}) {
    const Vec3f at = p[n].cast<float>();
    corners_.push_back({{at[0], at[1], at[2]}, color});
  }
}

void LiveOverlay::addSlabLines(const LiveSlab& slab, const OverlayView& view) {
  const Vec3d half = 0.5 * slab.thickness * normalOf(slab);
  const Color& color = slab.is_chosen ? kChosenEdge : kOtherEdge;
  const auto& c = slab.corners;

  const auto addAll = [&](double extra, const Color& with) {
    for (std::size_t n = 0; n < 4; ++n) {
      const Vec3d &a = c[n], &b = c[(n + 1) % 4];
      const double pixels = (n == 0 ? kTeethPixels : kEdgePixels) + extra;
      addLine(view, a - half, b - half, pixels, with);
      addLine(view, a + half, b + half, pixels, with);
      addLine(view, a - half, a + half, kEdgePixels + extra, with);
    }
    for (const auto& piece : slab.contour) addLine(view, piece[0], piece[1], kContourPixels + extra, with, true);
    if (!slab.is_chosen) return;

    // Entry side of the teeth.
    const Vec3d entry = 0.5 * (c[0] + c[1]), into = (c[3] - c[0]).normalized(), aside = (c[1] - c[0]).normalized();
    addLine(view, entry - kArrow * into, entry, kTeethPixels + extra, with);
    for (const double side : {-1.0, 1.0})
      addLine(view, entry, entry - kArrowHead * into + 0.6 * side * kArrowHead * aside, kTeethPixels + extra, with);
  };
  Color halo = kHalo;
  if (!slab.is_chosen) halo[3] *= 0.6f;
  addAll(kHaloPixels, halo);
  addAll(0, color);
}

void LiveOverlay::addDot(const Vec3d& at, const OverlayView& view) {
  const auto add = [&](double pixels, const Color& color) {
    constexpr int kSides = 16;
    const double radius = view.mm(0.5 * pixels, at);
    const auto rim = [&](int n) -> Vec3d {
      const double angle = 2 * M_PI * n / kSides;
      return at + radius * (std::cos(angle) * view.camera.right() + std::sin(angle) * view.camera.up());
    };
    for (int n = 0; n < kSides; ++n)
      for (const Vec3d& p : {at, rim(n), rim(n + 1)}) {
        const Vec3f q = p.cast<float>();
        corners_.push_back({{q[0], q[1], q[2]}, color});
      }
  };
  add(kDotPixels + 3, {1, 1, 1, 0.9f});
  add(kDotPixels, kPicked);
}

void LiveOverlay::flush(const OverlayView& view, double opacity) {
  if (corners_.empty()) return;
  program_.use();
  program_.set("to_clip", Eigen::Matrix4f(view.to_clip.cast<float>()));
  program_.set("opacity", opacity);
  glBindVertexArray(array_);
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners_.size() * sizeof(Corner)), corners_.data(),
               GL_STREAM_DRAW);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(corners_.size()));
}

void LiveOverlay::draw(const LivePlan& plan, const OverlayView& view) {
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);

  for (const auto& [test, opacity] : {std::pair<GLenum, double>{GL_GREATER, kHidden}, {GL_LEQUAL, 1.0}}) {
    glDepthFunc(test);
    corners_.clear();
    for (const LiveSlab& slab : plan.slabs) addFaces(slab);
    glEnable(GL_CULL_FACE);
    flush(view, opacity);
    glDisable(GL_CULL_FACE);

    corners_.clear();
    for (const LiveSlab& slab : plan.slabs) addSlabLines(slab, view);
    flush(view, opacity);
  }

  glDepthFunc(GL_ALWAYS);
  corners_.clear();
  for (const LiveLine& line : plan.lines) {
    addLine(view, line.from, line.to, kTeethPixels + kHaloPixels, kHalo);
    addLine(view, line.from, line.to, kTeethPixels, kDrawn);
  }
  for (const Vec3d& at : plan.dots) addDot(at, view);
  flush(view, 1);

  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
}

}  // namespace kerf::internal
