#include "ui/window/draw/live_renderer.h"

#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "ui/window/draw/live_pages.h"
#include "ui/window/draw/live_parts.h"
#include "ui/window/draw/live_section.h"
#include "ui/window/draw/live_shaders.h"
#include "ui/window/gl/gl_program.h"
#include "ui/window/gl/gl_target.h"

namespace kerf {
namespace {

using internal::describeFlat;
using internal::FlatCorner;
using internal::FrameView;
using internal::glFailure;
using internal::GlProgram;
using internal::LiveChunk;
using internal::LivePage;
using internal::LiveSection;
using internal::matrixOf;
using internal::ToolReach;

constexpr int kLargestSide = 8192;
constexpr double kPixelsPerTriangle = 10;  // longer edges: light by pixel

/// Background, sRGB: in the middle, at the corners.
const Vec3f kBackgroundMiddle(0.80f, 0.835f, 0.87f), kBackgroundEdge(0.49f, 0.55f, 0.62f);

bool isFinite(const Camera& c) {
  return std::isfinite(c.azimuth) && std::isfinite(c.elevation) && c.target.allFinite() &&
         std::isfinite(c.half_height) && c.half_height > 0 && std::isfinite(c.roll) && c.field_of_view >= 0 &&
         c.field_of_view < std::numbers::pi;
}

/// Whether there is a section. A section is drawn into a framebuffer with a stencil buffer, which a window need not
/// have.
bool isOpen(const LiveFrame& frame) {
  return frame.section && frame.section->point.allFinite() && frame.section->normal.allFinite();
}

struct Object {
  Rigid3 T_world_object;
  bool is_visible = true, is_ghost = false;
  std::map<std::array<int, 3>, LivePage> pages;  // in order: so are the draw calls
  LiveSection section;
};

/// One page to draw in this frame: all of it, or its chunks within one reach of the tool.
struct Drawn {
  LivePage* page = nullptr;
  const Object* object = nullptr;
  double depth = 0;       ///< view z of the middle
  bool is_whole = true;   ///< in view
  bool is_split = false;  ///< by reach
  bool is_by_pixel = false;
  internal::Reach reach = internal::Reach::kNone;
};

}  // namespace

struct LiveRenderer::Impl {
  enum Variant {
    kByPixel = 1,
    kSection = 2,
    kTool = 4,
    kTint = 8,
    kGhost = 12,  // no tool on ghosts
    kPerspective = 16,
    kVariants = 32
  };
  std::array<GlProgram, kVariants> tissue;
  GlProgram flat, reduce;
  internal::LiveOverlay overlay;
  internal::LiveTool hand_tool;

  std::map<std::size_t, Object> objects;
  std::uint64_t changes = 0;  // of the drawn content, except poses and visibility of objects
  LiveCounts counts;

  // Background, and targets for pictures and supersampled frames.
  GLuint background_array = 0, background_buffer = 0, empty_array = 0;
  GLsizei background_corners = 0;
  GLuint points_target = 0, points_color = 0, points_depth = 0;
  int points_width = 0, points_height = 0;

  Impl() {
    glGenVertexArrays(1, &background_array);
    glGenVertexArrays(1, &empty_array);
    glGenBuffers(1, &background_buffer);
    glGenFramebuffers(1, &points_target);
    glGenTextures(1, &points_color);
    glGenRenderbuffers(1, &points_depth);
    describeFlat(background_array, background_buffer);
    makeBackground(kBackgroundMiddle, kBackgroundEdge);
  }
  ~Impl() {
    objects.clear();
    for (const GLuint array : {background_array, empty_array}) glDeleteVertexArrays(1, &array);
    glDeleteBuffers(1, &background_buffer);
    glDeleteTextures(1, &points_color);
    glDeleteFramebuffers(1, &points_target);
    glDeleteRenderbuffers(1, &points_depth);
    for (const GlProgram& program : tissue) glDeleteProgram(program.id);
    for (const GlProgram* program : {&flat, &reduce}) glDeleteProgram(program->id);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  Expected<void> build() {
    using namespace live_shaders;
    const char* const version = "#version 330 core\n";
    for (std::size_t n = 0; n < tissue.size(); ++n) {
      const char* const by_pixel = n & kByPixel ? "#define BY_PIXEL\n" : "";
      const std::size_t tool_part = n & kGhost;
      const char* const with_tool = tool_part == kTool || tool_part == kTint ? "#define TOOL\n" : "";
      const char* const with_tint = tool_part == kTint    ? "#define TINT\n"
                                    : tool_part == kGhost ? "#define GHOST\n"
                                                          : "";
      const char* const with_section = n & kSection ? "#define SECTION\n" : "";
      const char* const in_perspective = n & kPerspective ? "#define PERSPECTIVE\n" : "";
      KERF_CHECK(tissue[n].build(
          {version, by_pixel, with_tool, with_tint, with_section, in_perspective, kAcross, kLight, kTissueVertex},
          {version, by_pixel, with_tool, with_tint, with_section, in_perspective, kAcross, kLight, kTissueFragment}));
    }
    KERF_CHECK(overlay.build());
    KERF_CHECK(hand_tool.build());
    KERF_CHECK(flat.build({version, kFlatVertex}, {version, kFlatFragment}));
    return reduce.build({version, kReduceVertex}, {version, kReduceFragment});
  }

  /// A gradient in a few large triangles with a colour at each corner: cheaper than a formula for each pixel, or a copy
  /// of a picture.
  void makeBackground(const Vec3f& middle, const Vec3f& edge) {
    constexpr int kColumns = 16, kRows = 10;
    const auto corner = [&](int column, int row) {
      const float x = 2.0f * static_cast<float>(column) / kColumns - 1;
      const float y = 2.0f * static_cast<float>(row) / kRows - 1;
      const float off = std::clamp(0.5f * (x * x + (y - 0.15f) * (y - 0.15f)), 0.0f, 1.0f);
      const Vec3f c = middle + off * (edge - middle);
      return FlatCorner{{x, y}, {c[0], c[1], c[2], 1}};
    };
    std::vector<FlatCorner> corners;
    for (int row = 0; row < kRows; ++row)
      for (int column = 0; column < kColumns; ++column)
        for (const auto& [i, j] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}})
          corners.push_back(corner(column + i, row + j));
    background_corners = static_cast<GLsizei>(corners.size());
    glBindBuffer(GL_ARRAY_BUFFER, background_buffer);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(FlatCorner)), corners.data(),
                 GL_STATIC_DRAW);
  }

  // A frame, in the order in which its parts are drawn.
  FrameView viewOf(const Camera& camera, int width, int height, const LiveFrame& frame,
                   const std::optional<Rigid3>& tool) const;
  std::vector<Drawn> whatIsSeen(const FrameView& view, const LiveFrame& frame, const std::optional<Rigid3>& tool,
                                bool is_ghost);
  void drawObjects(const FrameView& view, const LiveFrame& frame, const std::optional<Rigid3>& tool);
  void drawGhosts(const FrameView& view, const LiveFrame& frame);
  void drawPages(const std::vector<Drawn>& seen, const FrameView& view, const LiveFrame& frame,
                 const std::optional<Rigid3>& tool, bool is_ghost);
  void liftSection(const FrameView& view, const Plane& plane);
  void drawBackground();
  void drawPlan(const FrameView& view, const LiveFrame& frame, const Camera& camera);
  void upload(std::size_t most);
  Expected<void> drawInto(GLuint target, const Camera& camera, int width, int height, const LiveFrame& frame);
  Expected<void> drawPoints(GLuint target, const Camera& camera, int width, int height, const LiveFrame& frame);
  Expected<void> resizePoints(int width, int height);

  void setObjectUniforms(const GlProgram& program, const FrameView& view, const LiveFrame& frame, const Drawn& drawn,
                         const std::optional<Rigid3>& tool) const;
};

FrameView LiveRenderer::Impl::viewOf(const Camera& camera, int width, int height, const LiveFrame& frame,
                                     const std::optional<Rigid3>& tool) const {
  FrameView view;
  view.rotation = camera.rotation();
  view.target = camera.target;
  view.width = width;
  view.height = height;
  view.mm_per_pixel = camera.mmPerPixel(height);

  // Deep enough for all objects, visible or not.
  double depth = 1e-3;
  const auto reach = [&](const Box3& box, const Rigid3& pose) {
    if (box.isEmpty()) return;
    const Vec3d middle = view.toView(pose * box.center());
    depth = std::max(depth, std::abs(middle[2]) + 0.5 * box.size().norm());
  };
  for (const auto& [number, object] : objects)
    if (object.T_world_object.isUsable())
      for (const auto& [key, page] : object.pages) reach(page.box(), object.T_world_object);
  if (tool) reach(hand_tool.box(), *tool);
  for (const LiveSlab& slab : frame.plan.slabs) {
    Box3 box;
    for (const Vec3d& corner : slab.corners) box.add(corner);
    box.grow(slab.thickness);
    reach(box, {});
  }
  view.half_extent = Vec3d(0.5 * width * view.mm_per_pixel, camera.half_height, 1.05 * depth);

  Eigen::Matrix4d to_view = Eigen::Matrix4d::Identity();
  to_view.topLeftCorner<3, 3>() = view.rotation;
  to_view.topRightCorner<3, 1>() = -(view.rotation * camera.target);
  const Vec3d scale = view.half_extent.cwiseInverse();
  Eigen::Matrix4d projection = Eigen::Vector4d(scale[0], scale[1], -scale[2], 1).asDiagonal();
  if (camera.isPerspective()) {
    // w is the distance from the eye, relative to that of the target; depth spans from the nearest to the farthest
    // object.
    const double eye = camera.eyeDistance();
    view.slope = 1 / eye;
    const double nearest = std::max(1 - view.slope * view.half_extent[2], Camera::kNearest);
    const double farthest = 1 + view.slope * view.half_extent[2];
    projection(3, 2) = -view.slope;
    projection(2, 2) = -view.slope * (farthest + nearest) / (farthest - nearest);
    projection(2, 3) = (farthest + nearest - 2 * farthest * nearest) / (farthest - nearest);
  }
  view.to_clip = projection * to_view;
  return view;
}

std::vector<Drawn> LiveRenderer::Impl::whatIsSeen(const FrameView& view, const LiveFrame& frame,
                                                  const std::optional<Rigid3>& tool, bool is_ghost) {
  std::vector<Drawn> seen;
  for (auto& [number, object] : objects) {
    if (!object.is_visible || object.is_ghost != is_ghost || !object.T_world_object.isUsable()) continue;
    const Eigen::Matrix3d rotation = view.rotation * object.T_world_object.rotation.toRotationMatrix();
    const Eigen::Matrix3d spread = rotation.cwiseAbs();
    std::optional<ToolReach> tool_reach;
    if (tool) tool_reach = hand_tool.reachOf(frame, *tool, object.T_world_object);

    for (auto& [key, page] : object.pages) {
      const Box3& box = page.box();
      if (box.isEmpty()) continue;
      const Vec3d middle = view.toView(object.T_world_object * box.center());
      const Vec3d half = spread * (0.5 * box.size());
      Drawn drawn{.page = &page, .object = &object, .depth = middle[2]};
      const FrameView::Visibility visibility = view.visibilityOf(middle, half);
      drawn.is_whole = visibility.is_whole;
      if (visibility.is_outside && frame.is_culled) continue;

      drawn.is_by_pixel = page.meanEdge() > kPixelsPerTriangle * view.mm_per_pixel * view.shrinkAt(middle[2]);
      // Near the tool chunk by chunk: shaders with the tool cost half as much again.
      const internal::Reach reach = tool_reach ? tool_reach->of(box) : internal::Reach::kNone;
      drawn.is_split = reach != internal::Reach::kNone;
      for (const internal::Reach part : {internal::Reach::kNone, internal::Reach::kShadow, internal::Reach::kTip}) {
        if (part > reach) break;
        drawn.reach = part;
        seen.push_back(drawn);
      }
    }
  }
  // Nearest first: hidden parts behind are not shaded.
  std::stable_sort(seen.begin(), seen.end(), [](const Drawn& a, const Drawn& b) { return a.depth > b.depth; });
  return seen;
}

void LiveRenderer::Impl::setObjectUniforms(const GlProgram& program, const FrameView& view, const LiveFrame& frame,
                                           const Drawn& drawn, const std::optional<Rigid3>& tool) const {
  const Rigid3& pose = drawn.object->T_world_object;
  const Eigen::Matrix3d rotation = view.rotation * pose.rotation.toRotationMatrix();
  program.set("to_clip", Eigen::Matrix4f((view.to_clip * matrixOf(pose)).cast<float>()));
  program.set("to_view", Eigen::Matrix3f(rotation.cast<float>()));
  if (drawn.reach != internal::Reach::kNone)
    program.set("to_tool", Eigen::Matrix4f(matrixOf(hand_tool.toApproach(*tool, pose)).cast<float>()));
  if (isOpen(frame)) {
    const Vec3d n = pose.rotation.conjugate() * frame.section->normal;
    const double offset = frame.section->normal.dot(pose.translation - frame.section->point);
    drawn.object->section.setUniforms(program, view, *frame.section, pose);
    program.set("section", Eigen::Vector4f(Eigen::Vector4d(n[0], n[1], n[2], offset).cast<float>()));
  }
}

void LiveRenderer::Impl::drawObjects(const FrameView& view, const LiveFrame& frame, const std::optional<Rigid3>& tool) {
  const bool is_open = isOpen(frame);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glFrontFace(GL_CCW);
  glCullFace(GL_BACK);
  if (is_open) {
    glDisable(GL_CULL_FACE);
    glEnable(GL_CLIP_DISTANCE0);
    // Marks pixels that show the inside.
    glEnable(GL_STENCIL_TEST);
    glStencilMask(1);
    glStencilFuncSeparate(GL_FRONT, GL_ALWAYS, 0, 1);
    glStencilFuncSeparate(GL_BACK, GL_ALWAYS, 1, 1);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  } else {
    glEnable(GL_CULL_FACE);
  }
  drawPages(whatIsSeen(view, frame, tool, false), view, frame, tool, false);
  glDisable(GL_CLIP_DISTANCE0);
  if (is_open) liftSection(view, *frame.section);
  glDisable(GL_STENCIL_TEST);
}

/// Over all solid objects and the background: depth first, so that only the nearest surface shows.
void LiveRenderer::Impl::drawGhosts(const FrameView& view, const LiveFrame& frame) {
  const std::vector<Drawn> seen = whatIsSeen(view, frame, {}, true);
  if (seen.empty()) return;
  glEnable(GL_CULL_FACE);
  if (isOpen(frame)) glEnable(GL_CLIP_DISTANCE0);
  glDepthFunc(GL_LESS);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  drawPages(seen, view, frame, {}, true);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);

  glDepthFunc(GL_LEQUAL);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  drawPages(seen, view, frame, {}, true);
  glDisable(GL_BLEND);
  glDepthFunc(GL_LESS);
  glDisable(GL_CLIP_DISTANCE0);
}

void LiveRenderer::Impl::drawPages(const std::vector<Drawn>& seen, const FrameView& view, const LiveFrame& frame,
                                   const std::optional<Rigid3>& tool, bool is_ghost) {
  const bool is_open = isOpen(frame);
  hand_tool.bindTable();

  std::array<bool, kVariants> is_prepared{};
  std::array<const Object*, kVariants> set_for{};
  std::vector<GLsizei> counts_of;
  std::vector<const void*> offsets;
  const GlProgram* used = nullptr;
  const Object* bound = nullptr;
  for (const Drawn& drawn : seen) {
    const std::size_t variant = (drawn.is_by_pixel ? std::size_t{kByPixel} : 0) |
                                (drawn.reach == internal::Reach::kShadow ? std::size_t{kTool} : 0) |
                                (drawn.reach == internal::Reach::kTip ? std::size_t{kTint} : 0) |
                                (is_open ? std::size_t{kSection} : 0) | (is_ghost ? std::size_t{kGhost} : 0) |
                                (view.slope > 0 ? std::size_t{kPerspective} : 0);
    const GlProgram& program = tissue[variant];
    if (used != &program) program.use();
    used = &program;

    // Uniforms: once a frame, and when the object changes.
    if (!is_prepared[variant]) {
      is_prepared[variant] = true;
      internal::setLights(program);
      if (drawn.reach != internal::Reach::kNone) hand_tool.setUniforms(program, view, frame);
      if (is_open) {
        const Rgba8& c = frame.section_color;
        program.set("section_color", Vec3f(Vec3f(c[0], c[1], c[2]) / 255));
      }
    }
    if (is_open && bound != drawn.object) drawn.object->section.bind();
    bound = drawn.object;
    if (set_for[variant] != drawn.object) {
      set_for[variant] = drawn.object;
      setObjectUniforms(program, view, frame, drawn, tool);
    }

    // The visible chunks of the page, in as few ranges as possible.
    LivePage& page = *drawn.page;
    const Rigid3& pose = drawn.object->T_world_object;
    const Eigen::Matrix3d rotation = view.rotation * pose.rotation.toRotationMatrix();
    const Eigen::Matrix3d spread = rotation.cwiseAbs();
    const Vec3d origin = view.toView(pose.translation);
    const internal::Sight sight{
        .to_pixels = view.toPixels(pose).cast<float>(), .has_backs = is_open && !is_ghost, .has_all = !frame.is_culled};
    counts.uploaded_bytes += page.choose(sight);
    std::optional<ToolReach> tool_reach;
    if (drawn.is_split) tool_reach = hand_tool.reachOf(frame, *tool, pose);
    const auto isSeen = [&](const LivePage::Range& range) {
      if (drawn.is_whole || !frame.is_culled) return true;
      const Vec3d middle = origin + rotation * range.box.center();
      const Vec3d half = spread * (0.5 * range.box.size());
      return !view.visibilityOf(middle, half).is_outside;
    };
    counts_of.clear();
    offsets.clear();
    std::size_t end = std::numeric_limits<std::size_t>::max();
    for (const LivePage::Range& range : page.ranges()) {
      if (range.count == 0 || !isSeen(range)) continue;
      if (drawn.is_split && tool_reach->of(range.box) != drawn.reach) continue;
      if (range.first == end) {
        counts_of.back() += static_cast<GLsizei>(range.count);
      } else {
        counts_of.push_back(static_cast<GLsizei>(range.count));
        offsets.push_back(internal::bufferOffset(range.first * sizeof(std::uint32_t)));
      }
      end = range.first + range.count;
      counts.drawn_triangles += range.count / 3;
    }
    if (counts_of.empty()) continue;
    glBindVertexArray(page.vertexArray());
    glMultiDrawElements(GL_TRIANGLES, counts_of.data(), GL_UNSIGNED_INT, offsets.data(),
                        static_cast<GLsizei>(counts_of.size()));
    ++counts.draw_calls;
  }
}

/// So far the section has the depth of the wall behind it. Lifts it into its plane, so that a tool behind it is hidden.
void LiveRenderer::Impl::liftSection(const FrameView& view, const Plane& plane) {
  if (view.facing(view.toView(plane.point), view.rotation * plane.normal) < 1e-3) return;  // from its edge or behind

  // A plane of the world is one of clip space, too: a x + b y + c z + d = 0.
  Eigen::RowVector4d world;
  world << plane.normal.transpose(), -plane.normal.dot(plane.point);
  const Eigen::RowVector4d clip = world * view.to_clip.inverse();
  const Vec3d depth = -Vec3d(clip[0], clip[1], clip[3]) / clip[2];
  glStencilFunc(GL_EQUAL, 1, 1);
  glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
  glDepthFunc(GL_ALWAYS);
  glEnable(GL_DEPTH_CLAMP);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  flat.use();
  flat.set("depth", Vec3f(depth.cast<float>()));
  glBindVertexArray(background_array);
  glDrawArrays(GL_TRIANGLES, 0, background_corners);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDisable(GL_DEPTH_CLAMP);
  glDepthFunc(GL_LESS);
}

void LiveRenderer::Impl::drawBackground() {
  glDisable(GL_CULL_FACE);
  glDepthFunc(GL_LEQUAL);  // at the far end: only on empty pixels
  flat.use();
  flat.set("depth", Vec3f(0, 0, 1));
  flat.set("noise", 1.0 / 255);
  glBindVertexArray(background_array);
  glDrawArrays(GL_TRIANGLES, 0, background_corners);
}

void LiveRenderer::Impl::drawPlan(const FrameView& view, const LiveFrame& frame, const Camera& camera) {
  const double scale = std::max(1.0, view.height / 720.0);
  overlay.draw(frame.plan, {view.to_clip, camera, scale * view.mm_per_pixel});
}

/// One point a pixel, into a framebuffer with depth.
Expected<void> LiveRenderer::Impl::drawPoints(GLuint target, const Camera& camera, int width, int height,
                                              const LiveFrame& frame) {
  glBindFramebuffer(GL_FRAMEBUFFER, target);
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    return fail(glFailure("drawing", "the framebuffer is gone or incomplete"));

  std::optional<Rigid3> tool;
  if (!hand_tool.isEmpty() && frame.T_world_tool && frame.T_world_tool->isUsable()) tool = frame.T_world_tool;
  const FrameView view = viewOf(camera, width, height, frame, tool);
  counts.half_depth_mm = view.half_extent[2];

  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_FRAMEBUFFER_SRGB);
  glDisable(GL_MULTISAMPLE);  // skips triangles that cover no middle of a pixel
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glViewport(0, 0, width, height);
  glStencilMask(1);
  glClearDepth(1);
  glClearStencil(0);
  glClear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);

  drawObjects(view, frame, tool);
  if (tool && !frame.is_ghost) hand_tool.draw(view, frame, *tool);
  drawBackground();
  drawGhosts(view, frame);
  if (tool && frame.is_ghost) {
    glDepthFunc(GL_LESS);
    hand_tool.draw(view, frame, *tool);
  }
  if (!frame.plan.isEmpty()) drawPlan(view, frame, camera);
  if (tool && frame.has_axis_line) hand_tool.drawAxisLine(flat, view, frame, *tool);

  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  glBindVertexArray(0);
  return {};
}

Expected<void> LiveRenderer::Impl::resizePoints(int width, int height) {
  if (width == points_width && height == points_height) return {};
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  if (width > most || height > most)
    return fail(
        glFailure("picture", fmt::format("{} x {} points, but this driver draws at most {}", width, height, most)));

  points_width = points_height = 0;
  glBindTexture(GL_TEXTURE_2D, points_color);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glBindRenderbuffer(GL_RENDERBUFFER, points_depth);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
  glBindFramebuffer(GL_FRAMEBUFFER, points_target);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, points_color, 0);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, points_depth);
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    return fail(glFailure("picture", fmt::format("the driver refuses a framebuffer of {} x {}", width, height)));
  points_width = width;
  points_height = height;
  return {};
}

// Visible pages first, and objects without any page last: the cut is never delayed by an opening document. Among equals
// the longest waiting goes first: a wide tool changes more pages than fit in a frame.
void LiveRenderer::Impl::upload(std::size_t most) {
  struct Waiting {
    LivePage* page;
    bool is_visible, is_begun;
  };
  std::vector<Waiting> waiting;
  for (auto& [number, object] : objects) {
    const bool is_begun =
        std::any_of(object.pages.begin(), object.pages.end(), [](const auto& entry) { return !entry.second.isNew(); });
    for (auto& [key, page] : object.pages)
      if (page.isDirty()) waiting.push_back({&page, object.is_visible, is_begun});
  }
  std::stable_sort(waiting.begin(), waiting.end(), [](const Waiting& a, const Waiting& b) {
    if (a.is_visible != b.is_visible) return a.is_visible;
    if (a.is_begun != b.is_begun) return a.is_begun;
    return a.page->waited() > b.page->waited();
  });
  for (const Waiting& one : waiting) {
    if (counts.uploaded_bytes < most)
      counts.uploaded_bytes += one.page->upload();
    else
      one.page->wait();
  }

  for (auto& [number, object] : objects) {
    std::erase_if(object.pages, [](const auto& entry) { return entry.second.isEmpty(); });
    for (const auto& [key, page] : object.pages) {
      if (object.is_visible) counts.triangles += page.triangles();
      if (page.isDirty()) ++counts.waiting_pages;
    }
  }
  if (counts.waiting_pages > 0) ++changes;  // the next frame shows more
}

Expected<void> LiveRenderer::Impl::drawInto(GLuint target, const Camera& camera, int width, int height,
                                            const LiveFrame& frame) {
  counts = {};
  if (width <= 0 || height <= 0 || !isFinite(camera)) return {};
  while (glGetError() != GL_NO_ERROR) {
  }

  upload(frame.most_upload);
  const int factor = std::clamp(frame.supersampling, 1, 3);
  if (factor == 1 && !isOpen(frame)) {
    KERF_CHECK(drawPoints(target, camera, width, height, frame));
  } else {
    KERF_CHECK(resizePoints(width * factor, height * factor));
    KERF_CHECK(drawPoints(points_target, camera, width * factor, height * factor, frame));
    glBindFramebuffer(GL_FRAMEBUFFER, target);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
      return fail(glFailure("drawing", "the framebuffer is gone or incomplete"));
    glViewport(0, 0, width, height);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, points_color);
    glBindVertexArray(empty_array);
    reduce.use();
    reduce.set("points", 0);
    reduce.set("factor", factor);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindVertexArray(0);
  }
  if (const GLenum error = glGetError(); error != GL_NO_ERROR)
    return fail(glFailure("drawing", fmt::format("OpenGL error 0x{:x}", error)));
  return {};
}

// ------------------------------------------------------------------------------------------------------ the class

LiveRenderer::LiveRenderer() : impl_(std::make_unique<Impl>()) {}
LiveRenderer::~LiveRenderer() = default;

Expected<std::unique_ptr<LiveRenderer>> LiveRenderer::create() {
  if (epoxy_gl_version() < 33)
    return fail(glFailure("drawing", fmt::format("OpenGL {:.1f}", epoxy_gl_version() / 10.0)));
  std::unique_ptr<LiveRenderer> renderer(new LiveRenderer);
  KERF_CHECK(renderer->impl_->build());
  return renderer;
}

void LiveRenderer::setChunk(std::size_t object, const MeshChunk& chunk, std::span<const Rgba8> colours,
                            std::span<const std::uint8_t> occlusion) {
  std::array<int, 3> key{};
  for (std::size_t k = 0; k < 3; ++k) key[k] = chunk.brick[static_cast<Eigen::Index>(k)] >> LivePage::kBricksLog;
  LiveChunk made = internal::liveChunk(chunk, colours, occlusion);
  ++impl_->changes;
  auto& pages = impl_->objects[object].pages;
  if (made.triangles.empty() && !pages.contains(key)) return;
  pages[key].set(chunk.brick, std::move(made));
}

void LiveRenderer::setPose(std::size_t object, const Rigid3& T_world_object) {
  impl_->objects[object].T_world_object = T_world_object;
}
void LiveRenderer::setVisible(std::size_t object, bool is_visible) { impl_->objects[object].is_visible = is_visible; }
void LiveRenderer::setSection(std::size_t object, const TissueSection& section) {
  ++impl_->changes;
  impl_->objects[object].section.set(section);
}
void LiveRenderer::setGhost(std::size_t object, bool is_ghost) { impl_->objects[object].is_ghost = is_ghost; }
void LiveRenderer::removeObject(std::size_t object) { impl_->changes += impl_->objects.erase(object); }
void LiveRenderer::clear() {
  ++impl_->changes;
  impl_->objects.clear();
}
void LiveRenderer::setBackground(const Vec3f& middle, const Vec3f& edge) {
  ++impl_->changes;
  impl_->makeBackground(middle, edge);
}
void LiveRenderer::setTool(const ToolLook& tool) {
  ++impl_->changes;
  impl_->hand_tool.set(tool);
}
const LiveCounts& LiveRenderer::counts() const { return impl_->counts; }

std::uint64_t LiveRenderer::version() const {
  std::uint64_t out = impl_->changes;
  const auto mix = [&out](double value) { out = (out ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3ull; };
  for (const auto& [number, object] : impl_->objects) {
    if (!object.is_visible) continue;
    mix(static_cast<double>(number));
    mix(object.is_ghost ? 1 : 0);
    for (const double v : object.T_world_object.translation) mix(v);
    for (const double v : object.T_world_object.rotation.coeffs()) mix(v);
  }
  return out;
}

Expected<void> LiveRenderer::draw(const Camera& camera, int width, int height, const LiveFrame& frame) {
  GLint bound = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
  return impl_->drawInto(static_cast<GLuint>(bound), camera, width, height, frame);
}

Expected<Image> LiveRenderer::picture(const Camera& camera, int width, int height, const LiveFrame& frame) {
  if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide)
    return fail({.code = Error::Code::kBadValue,
                 .file = {},
                 .place = "picture size",
                 .found = fmt::format("{} x {}", width, height),
                 .expected = fmt::format("1 to {} pixels a side", kLargestSide),
                 .hint = "--size 1280x720"});
  const internal::GlTarget target(width, height);
  LiveFrame whole = frame;
  whole.most_upload = std::numeric_limits<std::size_t>::max();
  KERF_CHECK(impl_->drawInto(target.id(), camera, width, height, whole));
  return target.read();
}

}  // namespace kerf
