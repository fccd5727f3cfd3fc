#include "ui/window/draw/live_tool.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/mesh/shading_normals.h"
#include "ui/app/view/camera.h"
#include "ui/window/draw/live_pages.h"
#include "ui/window/draw/live_renderer.h"
#include "ui/window/draw/live_shaders.h"

namespace kerf::internal {
namespace {

constexpr double kShadowReach = 8;       // mm below the tip
constexpr double kShadowStrength = 0.5;  // of the shown value
const Vec3f kContactTint(0.10f, 0.56f, 0.82f);

double contactOf(const LiveFrame& frame) {
  return std::isfinite(frame.contact_mm) ? std::clamp(frame.contact_mm, 0.0, ToolTable::kMargin) : 0;
}

}  // namespace

LiveTool::LiveTool() {
  for (GLuint* const array : {&array_, &line_array_}) glGenVertexArrays(1, array);
  for (GLuint* const buffer : {&buffer_, &line_buffer_}) glGenBuffers(1, buffer);
  glGenTextures(1, &table_texture_);
  describeFlat(line_array_, line_buffer_);
}

LiveTool::~LiveTool() {
  for (const GLuint array : {array_, line_array_}) glDeleteVertexArrays(1, &array);
  for (const GLuint buffer : {buffer_, line_buffer_}) glDeleteBuffers(1, &buffer);
  glDeleteTextures(1, &table_texture_);
  glDeleteProgram(steel_.id);
}

Expected<void> LiveTool::build() {
  using namespace live_shaders;
  const char* const version = "#version 330 core\n";
  return steel_.build({version, kToolVertex}, {version, kLight, kToolFragment});
}

Rigid3 LiveTool::approachPose(const Rigid3& T_world_tool) const {
  const Eigen::Quaterniond turn(Eigen::Matrix3d(table_.approach_from_tool.transpose()));
  return {(T_world_tool.rotation * turn).normalized(), T_world_tool.translation};
}

Rigid3 LiveTool::toApproach(const Rigid3& T_world_tool, const Rigid3& T_world_object) const {
  return approachPose(T_world_tool).inverse() * T_world_object;
}

ToolReach LiveTool::reachOf(const LiveFrame& frame, const Rigid3& T_world_tool, const Rigid3& T_world_object) const {
  ToolReach reach{.T_approach_object = toApproach(T_world_tool, T_world_object), .around_tip = {}, .in_shadow = {}};
  const double contact = contactOf(frame);
  if (contact > 0) {
    reach.around_tip = table_.cutting;
    reach.around_tip.grow(contact);
  }
  if (frame.has_shadow) {
    reach.in_shadow = table_.cutting;
    reach.in_shadow.min[2] -= kShadowReach;
  }
  return reach;
}

void LiveTool::bindTable() const {
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_3D, table_texture_);
}

void LiveTool::set(const ToolLook& look) {
  std::vector<LiveVertex> corners;
  box_ = {};
  if (!look.mesh.triangles.empty()) {
    const std::vector<Vec3f> normals = cornerNormals(look.mesh, 40 * std::numbers::pi / 180);
    corners.resize(normals.size());
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const std::uint32_t v = look.mesh.triangles[c / 3][c % 3];
      LiveVertex& corner = corners[c];
      corner.position = look.mesh.vertices[v].cast<float>();
      for (std::size_t k = 0; k < 3; ++k)
        corner.normal[k] = static_cast<std::int16_t>(std::lround(32767 * normals[c][static_cast<Eigen::Index>(k)]));
      corner.color = look.mesh.hasFaceColors()     ? look.mesh.face_colors[c / 3]
                     : look.mesh.hasVertexColors() ? look.mesh.vertex_colors[v]
                                                   : Rgba8{176, 182, 190, 255};
      box_.add(look.mesh.vertices[v]);
    }
  }

  corners_ = static_cast<GLsizei>(corners.size());
  glBindVertexArray(array_);
  glBindBuffer(GL_ARRAY_BUFFER, buffer_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(LiveVertex)), corners.data(),
               GL_STATIC_DRAW);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(LiveVertex), bufferOffset(offsetof(LiveVertex, position)));
  glVertexAttribPointer(1, 4, GL_SHORT, GL_TRUE, sizeof(LiveVertex), bufferOffset(offsetof(LiveVertex, normal)));
  glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(LiveVertex), bufferOffset(offsetof(LiveVertex, color)));
  for (GLuint i = 0; i < 3; ++i) glEnableVertexAttribArray(i);
  if (corners_ > 0) setTable(look);
}

void LiveTool::setTable(const ToolLook& look) {
  constexpr int kSide = ToolTable::kSide;
  table_ = toolTable(look);
  glBindTexture(GL_TEXTURE_3D, table_texture_);
  glTexImage3D(GL_TEXTURE_3D, 0, GL_R32F, kSide, kSide, kSide, 0, GL_RED, GL_FLOAT, table_.distances.data());
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
    glTexParameteri(GL_TEXTURE_3D, axis, GL_CLAMP_TO_EDGE);
  table_.distances = {};
}

void LiveTool::setUniforms(const GlProgram& program, const FrameView& view, const LiveFrame& frame) const {
  const Vec3d middle = table_.cutting.center();
  const Vec3d half = 0.5 * table_.cutting.size();
  const double strength = frame.has_shadow ? kShadowStrength : 0;
  program.set("tool_distance", 0);
  program.set("table_low", Vec3f(table_.box.min.cast<float>()));
  program.set("table_scale", Vec3f(table_.box.size().cwiseInverse().cast<float>()));
  program.set("footprint", Eigen::Vector4f(Eigen::Vector4d(middle[0], middle[1], half[0], half[1]).cast<float>()));
  program.set(
      "shadow",
      Eigen::Vector4f(
          Eigen::Vector4d(strength, kShadowReach, table_.is_round ? 1 : 0, 1 / view.mm_per_pixel).cast<float>()));
  program.set("tool_height",
              Eigen::Vector2f(Eigen::Vector2d(table_.cutting.min[2], table_.cutting.max[2]).cast<float>()));
  program.set("contact", contactOf(frame));
  program.set("tint", kContactTint);
}

void LiveTool::draw(const FrameView& view, const LiveFrame& frame, const Rigid3& tool) const {
  steel_.use();
  setLights(steel_);
  steel_.set("to_clip", Eigen::Matrix4f((view.to_clip * matrixOf(tool)).cast<float>()));
  steel_.set("to_view", Eigen::Matrix3f((view.rotation * tool.rotation.toRotationMatrix()).cast<float>()));
  steel_.set("alpha", frame.is_ghost ? 0.4 : 1.0);
  glBindVertexArray(array_);
  glEnable(GL_CULL_FACE);

  if (frame.is_ghost) {  // only its nearest surface shines through: depth first
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    glDrawArrays(GL_TRIANGLES, 0, corners_);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthFunc(GL_LEQUAL);
    glEnable(GL_BLEND);
    glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  }
  glDrawArrays(GL_TRIANGLES, 0, corners_);
  glDisable(GL_BLEND);
  glDepthFunc(GL_LESS);
}

void LiveTool::drawAxisLine(const GlProgram& flat, const FrameView& view, const LiveFrame& frame,
                            const Rigid3& tool) const {
  if (!std::isfinite(frame.axis_line_mm) || frame.axis_line_mm <= 0) return;
  const double length = std::min(frame.axis_line_mm, 100.0);
  const Rigid3 approach = approachPose(tool);
  const auto inPixels = [&](double below) {
    const Vec3d p = view.toView(
        approach * Vec3d(table_.cutting.center()[0], table_.cutting.center()[1], table_.cutting.min[2] - below));
    return Eigen::Vector2d(p.head<2>() / (view.mm_per_pixel * std::max(view.shrinkAt(p[2]), Camera::kNearest)));
  };
  const Eigen::Vector2d from = inPixels(0), to = inPixels(length);
  if ((to - from).norm() < 2) return;  // seen from its end
  const Eigen::Vector2d along = (to - from).normalized(), aside(-along[1], along[0]);
  const Eigen::Vector2d half(0.5 * view.width, 0.5 * view.height);

  std::vector<FlatCorner> corners;
  // A stroke of `width` pixels; its colour fades with the depth of its ends.
  const auto addStroke = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b, double width, const Vec3f& color,
                             double alpha_a, double alpha_b) {
    const Eigen::Vector2d direction = (b - a).normalized();
    const Eigen::Vector2d side = 0.5 * width * Eigen::Vector2d(-direction[1], direction[0]);
    const auto corner = [&](const Eigen::Vector2d& p, double alpha) {
      const Eigen::Vector2f at = p.cwiseQuotient(half).cast<float>();
      corners.push_back({{at[0], at[1]}, {color[0], color[1], color[2], static_cast<float>(alpha)}});
    };
    for (const auto& [p, alpha] : {std::pair{Eigen::Vector2d(a - side), alpha_a},
                                   {Eigen::Vector2d(a + side), alpha_a},
                                   {Eigen::Vector2d(b + side), alpha_b},
                                   {Eigen::Vector2d(a - side), alpha_a},
                                   {Eigen::Vector2d(b + side), alpha_b},
                                   {Eigen::Vector2d(b - side), alpha_b}})
      corner(p, alpha);
  };
  const double scale = std::max(1.0, view.height / 720.0);
  const auto addAll = [&](const Vec3f& color, double extra, double opacity) {
    addStroke(from, to, (1.5 + extra) * scale, color, opacity, 0.15 * opacity);
    for (int mm = 1; mm <= static_cast<int>(length); ++mm) {
      const Eigen::Vector2d at = inPixels(mm);
      const double reach = (mm % 5 ? 4 : 7) * scale, alpha = opacity * (1 - 0.85 * mm / length);
      addStroke(at - reach * aside, at + reach * aside, (1.5 + extra) * scale, color, alpha, alpha);
    }
  };
  addAll(Vec3f(1, 1, 1), 2, 0.45);  // a light edge, visible on dark and on bright
  addAll(Vec3f(0.05f, 0.17f, 0.32f), 0, 0.9);

  glBindVertexArray(line_array_);
  glBindBuffer(GL_ARRAY_BUFFER, line_buffer_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(FlatCorner)), corners.data(),
               GL_STREAM_DRAW);
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  flat.use();
  flat.set("depth", Vec3f(0, 0, 0));
  flat.set("noise", 0.0);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(corners.size()));
  glDisable(GL_BLEND);
}

}  // namespace kerf::internal
