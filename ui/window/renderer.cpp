#include "ui/window/renderer.h"

#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "geometry/mesh/ground_shadow.h"
#include "geometry/mesh/shading_normals.h"
#include "ui/window/gl_program.h"
#include "ui/window/gl_target.h"
#include "ui/window/shaders.h"

namespace kerf {
namespace {

using internal::glFailure;
using Program = internal::GlProgram;

struct Corner {
  Vec3f position;  ///< relative to the mesh's centre, so that float32 is enough far from the origin
  Vec3f normal;
  Rgba8 color;
};
static_assert(sizeof(Corner) == 28);

const Vec3f kStillKeyLight = Vec3f(-0.46f, 0.62f, 0.63f).normalized();
constexpr int kLargestStillSide = 8192;

void makeTexture(GLuint texture, GLint format, int width, int height, GLenum layout, GLenum type, const void* data,
                 GLint filter) {
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, layout, type, data);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void bindTexture(int unit, GLuint texture) {
  glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
  glBindTexture(GL_TEXTURE_2D, texture);
}

}  // namespace

struct Renderer::Impl {
  Program surface, occlusion, shade, reduce;
  GLuint vertex_array = 0, empty_array = 0, vertex_buffer = 0;
  enum Texture { kColor, kNormal, kDepth, kOcclusion, kShaded, kGround, kTextures };
  GLuint texture[kTextures] = {};
  enum Target { kSurfaceTarget, kOcclusionTarget, kShadedTarget, kTargets };
  GLuint target[kTargets] = {};
  int width = 0, height = 0;  ///< of the targets, points
  GLsizei corners = 0;
  Vec3d center = Vec3d::Zero();
  double radius = 1;  ///< of the mesh about its centre, mm
  GroundShadow shadow;

  Impl() {
    glGenVertexArrays(1, &vertex_array);
    glGenVertexArrays(1, &empty_array);
    glGenBuffers(1, &vertex_buffer);
    glGenTextures(kTextures, texture);
    glGenFramebuffers(kTargets, target);
  }
  ~Impl() {
    glDeleteVertexArrays(1, &vertex_array);
    glDeleteVertexArrays(1, &empty_array);
    glDeleteBuffers(1, &vertex_buffer);
    glDeleteTextures(kTextures, texture);
    glDeleteFramebuffers(kTargets, target);
    for (const Program* p : {&surface, &occlusion, &shade, &reduce}) glDeleteProgram(p->id);
  }

  Expected<void> resize(int w, int h) {
    if (w == width && h == height) return {};
    GLint most = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (w > most || h > most)
      return fail(glFailure("picture", fmt::format("{} x {} points, but this driver draws at most {}", w, h, most)));

    width = height = 0;
    makeTexture(texture[kColor], GL_RGBA8, w, h, GL_RGBA, GL_UNSIGNED_BYTE, nullptr, GL_NEAREST);
    makeTexture(texture[kNormal], GL_RGBA16F, w, h, GL_RGBA, GL_FLOAT, nullptr, GL_NEAREST);
    makeTexture(texture[kDepth], GL_DEPTH_COMPONENT32F, w, h, GL_DEPTH_COMPONENT, GL_FLOAT, nullptr, GL_NEAREST);
    makeTexture(texture[kOcclusion], GL_RG16F, w, h, GL_RG, GL_FLOAT, nullptr, GL_NEAREST);
    makeTexture(texture[kShaded], GL_RGBA16F, w, h, GL_RGBA, GL_FLOAT, nullptr, GL_NEAREST);

    const auto attach = [&](Target to, GLenum point, Texture what) {
      glBindFramebuffer(GL_FRAMEBUFFER, target[to]);
      glFramebufferTexture2D(GL_FRAMEBUFFER, point, GL_TEXTURE_2D, texture[what], 0);
    };
    attach(kSurfaceTarget, GL_COLOR_ATTACHMENT0, kColor);
    attach(kSurfaceTarget, GL_COLOR_ATTACHMENT1, kNormal);
    attach(kSurfaceTarget, GL_DEPTH_ATTACHMENT, kDepth);
    const GLenum both[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glDrawBuffers(2, both);
    attach(kOcclusionTarget, GL_COLOR_ATTACHMENT0, kOcclusion);
    attach(kShadedTarget, GL_COLOR_ATTACHMENT0, kShaded);

    for (const GLuint id : target) {
      glBindFramebuffer(GL_FRAMEBUFFER, id);
      if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        return fail(glFailure("picture", "the driver refuses a framebuffer of " + fmt::format("{} x {}", w, h)));
    }
    width = w;
    height = h;
    return {};
  }

  /// What every pass of a picture uses.
  struct Frame {
    const Camera& camera;
    const RenderOptions& options;
    Eigen::Matrix3f rotation;  ///< world -> view
    double mm_per_point, half_depth, reach, shadow_reach;
    Vec3d shift;  ///< of the mesh's centre in view, mm
  };
  Frame frameOf(const Camera& camera, const RenderOptions& options) const {
    const Vec3d shift = camera.rotation() * (center - camera.target);
    const double visible = std::min(radius, 1.5 * camera.half_height);  // zoomed in: crevices of the detail
    return {.camera = camera,
            .options = options,
            .rotation = camera.rotation().cast<float>(),
            .mm_per_point = camera.mmPerPixel(height),
            .half_depth = 1.05 * (radius + std::abs(shift.z())),
            .reach = 0.22 * visible,
            .shadow_reach = 0.55 * visible,
            .shift = shift};
  }

  /// Colour, normal and depth of the mesh.
  void drawSurface(const Frame& frame) {
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_FRAMEBUFFER_SRGB);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);

    glViewport(0, 0, width, height);
    glBindFramebuffer(GL_FRAMEBUFFER, target[kSurfaceTarget]);
    glClearColor(0, 0, 0, 0);
    glClearDepth(1);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);

    const Vec3d half_extent(0.5 * width * frame.mm_per_point, frame.camera.half_height, frame.half_depth);
    surface.use();
    surface.set("rotation", frame.rotation);
    surface.set("shift", Vec3f(frame.shift.cast<float>()));
    surface.set("half_extent", Vec3f(half_extent.cast<float>()));
    glBindVertexArray(vertex_array);
    if (corners > 0) glDrawArrays(GL_TRIANGLES, 0, corners);
  }

  /// The passes over the whole picture read what those before them drew.
  void bindTextures() {
    glDisable(GL_DEPTH_TEST);
    glBindVertexArray(empty_array);
    bindTexture(0, texture[kDepth]);
    bindTexture(1, texture[kNormal]);
    bindTexture(2, texture[kColor]);
    bindTexture(3, texture[kOcclusion]);
    bindTexture(4, texture[kGround]);
    bindTexture(5, texture[kShaded]);
  }

  void setCommon(const Program& program, const Frame& frame) {
    program.use();
    program.set("depth_map", 0);
    program.set("normal_map", 1);
    program.set("mm_per_point", frame.mm_per_point);
    program.set("half_depth", frame.half_depth);
    program.set("reach", frame.reach);
    program.set("key_light", kStillKeyLight);
  }

  void drawOcclusion(const Frame& frame) {
    glBindFramebuffer(GL_FRAMEBUFFER, target[kOcclusionTarget]);
    setCommon(occlusion, frame);
    occlusion.set("shadow_reach", frame.shadow_reach);
    occlusion.set("samples", std::clamp(frame.options.occlusion_samples, 0, 64));
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }

  void drawShade(const Frame& frame) {
    const Vec3f ground = (shadow.center - frame.camera.target).cast<float>();
    const bool has_ground = frame.options.ground_shadow && corners > 0;
    glBindFramebuffer(GL_FRAMEBUFFER, target[kShadedTarget]);
    setCommon(shade, frame);
    shade.set("color_map", 2);
    shade.set("occlusion_map", 3);
    shade.set("ground_map", 4);
    shade.set("rotation", frame.rotation);
    glUniform4f(shade.at("ground"), ground.x(), ground.y(), ground.z(), static_cast<float>(shadow.side));
    glUniform2f(shade.at("points"), static_cast<float>(width), static_cast<float>(height));
    shade.set("flags", (has_ground ? 1 : 0) | (frame.options.transparent ? 2 : 0));
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }

  /// All passes; the last one draws into framebuffer `to`.
  Expected<void> drawInto(GLuint to, const Camera& camera, int out_width, int out_height,
                          const RenderOptions& options) {
    const int factor = std::clamp(options.supersampling, 1, 4);
    KERF_CHECK(resize(out_width * factor, out_height * factor));
    const Frame frame = frameOf(camera, options);
    drawSurface(frame);
    bindTextures();
    drawOcclusion(frame);
    drawShade(frame);

    // The mean of factor x factor points for each pixel.
    glBindFramebuffer(GL_FRAMEBUFFER, to);
    glViewport(0, 0, out_width, out_height);
    reduce.use();
    reduce.set("shaded_map", 5);
    reduce.set("factor", factor);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glActiveTexture(GL_TEXTURE0);
    if (const GLenum error = glGetError(); error != GL_NO_ERROR)
      return fail(glFailure("drawing", fmt::format("OpenGL error 0x{:x}", error)));
    return {};
  }
};

Renderer::Renderer() : impl_(std::make_unique<Impl>()) {}
Renderer::~Renderer() = default;

Expected<std::unique_ptr<Renderer>> Renderer::create() {
  if (epoxy_gl_version() < 33)
    return fail(glFailure("drawing", fmt::format("OpenGL {:.1f}", epoxy_gl_version() / 10.0)));
  std::unique_ptr<Renderer> renderer(new Renderer);
  Impl& impl = *renderer->impl_;
  KERF_CHECK(impl.surface.build({shaders::kSurfaceVertex}, {shaders::kSurfaceFragment}));
  KERF_CHECK(impl.occlusion.build({shaders::kScreenVertex}, {shaders::kOcclusionFragment}));
  KERF_CHECK(impl.shade.build({shaders::kScreenVertex}, {shaders::kShadeFragment}));
  KERF_CHECK(impl.reduce.build({shaders::kScreenVertex}, {shaders::kReduceFragment}));
  renderer->setMesh({});
  return renderer;
}

void Renderer::setMesh(const Mesh& mesh) {
  Impl& impl = *impl_;
  const Box3 box = bounds(mesh);
  impl.center = box.isEmpty() ? Vec3d(Vec3d::Zero()) : box.center();
  impl.radius = std::max(1e-3, 0.5 * box.size().norm());
  impl.shadow = groundShadow(mesh);

  const std::vector<Vec3f> normals = cornerNormals(mesh, 40 * std::numbers::pi / 180);
  std::vector<Corner> corners(normals.size());
  for (std::size_t c = 0; c < corners.size(); ++c) {
    const std::uint32_t v = mesh.triangles[c / 3][c % 3];
    corners[c].position = (mesh.vertices[v] - impl.center).cast<float>();
    corners[c].normal = normals[c];
    corners[c].color = mesh.hasFaceColors()     ? mesh.face_colors[c / 3]
                       : mesh.hasVertexColors() ? mesh.vertex_colors[v]
                                                : kIvory;
  }

  impl.corners = static_cast<GLsizei>(corners.size());
  glBindVertexArray(impl.vertex_array);
  glBindBuffer(GL_ARRAY_BUFFER, impl.vertex_buffer);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(Corner)), corners.data(),
               GL_STATIC_DRAW);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Corner), internal::bufferOffset(offsetof(Corner, position)));
  glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof(Corner), internal::bufferOffset(offsetof(Corner, normal)));
  glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(Corner),
                        internal::bufferOffset(offsetof(Corner, color)));
  for (GLuint i = 0; i < 3; ++i) glEnableVertexAttribArray(i);
  makeTexture(impl.texture[Impl::kGround], GL_R32F, GroundShadow::kCells, GroundShadow::kCells, GL_RED, GL_FLOAT,
              impl.shadow.darkness.data(), GL_LINEAR);
}

Expected<void> Renderer::draw(const Camera& camera, int width, int height, const RenderOptions& options) {
  GLint bound = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
  return impl_->drawInto(static_cast<GLuint>(bound), camera, width, height, options);
}

Expected<Image> Renderer::picture(const Camera& camera, int width, int height, const RenderOptions& options) {
  if (width < 1 || height < 1 || width > kLargestStillSide || height > kLargestStillSide)
    return fail({.code = Error::Code::kBadValue,
                 .file = {},
                 .place = "picture size",
                 .found = fmt::format("{} x {}", width, height),
                 .expected = fmt::format("1 to {} pixels a side", kLargestStillSide),
                 .hint = "--size 1600x1200"});

  const internal::GlTarget target(width, height);
  KERF_CHECK(impl_->drawInto(target.id(), camera, width, height, options));
  return target.read();
}

}  // namespace kerf
