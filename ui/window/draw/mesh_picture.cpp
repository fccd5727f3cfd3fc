#include "ui/window/draw/mesh_picture.h"

#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/mesh/ground_shadow.h"
#include "ui/app/view/mesh_chunks.h"
#include "ui/window/draw/live_parts.h"
#include "ui/window/draw/live_renderer.h"
#include "ui/window/draw/live_shaders.h"
#include "ui/window/draw/picture_shaders.h"
#include "ui/window/gl/gl_program.h"
#include "ui/window/gl/gl_target.h"

namespace kerf {
namespace {

constexpr int kLargestPicture = 8192;
constexpr std::size_t kOutside = 0, kInside = 1;  // objects of the renderer

// The other side of a surface, bluish.
void turnInsideOut(ColouredChunk& made) {
  constexpr std::array<int, 3> kBluish{84, 108, 148};
  for (auto& triangle : made.chunk.triangles) std::swap(triangle[1], triangle[2]);
  for (Vec3f& normal : made.chunk.normals) normal = -normal;
  for (Rgba8& colour : made.colours) {
    for (std::size_t k = 0; k < 3; ++k) colour[k] = static_cast<std::uint8_t>((colour[k] + 3 * kBluish[k]) / 4);
    colour[3] = 0;
  }
}

}  // namespace

struct MeshPicture::Impl {
  std::unique_ptr<LiveRenderer> renderer;
  internal::GlProgram occlusion, finish;
  enum Map { kDepth, kColor, kOcclusion, kGround, kMaps };
  GLuint map[kMaps] = {}, points_target = 0, occlusion_target = 0, empty_array = 0;
  double radius = 1;  // of the mesh about its centre, mm
  bool is_empty = true;
  GroundShadow shadow;

  Impl() {
    glGenVertexArrays(1, &empty_array);
    glGenTextures(kMaps, map);
    glGenFramebuffers(1, &points_target);
    glGenFramebuffers(1, &occlusion_target);
  }
  ~Impl() {
    glDeleteVertexArrays(1, &empty_array);
    glDeleteTextures(kMaps, map);
    glDeleteFramebuffers(1, &points_target);
    glDeleteFramebuffers(1, &occlusion_target);
    for (const auto* program : {&occlusion, &finish}) glDeleteProgram(program->id);
  }

  void makeMap(Map which, GLint format, int width, int height, GLenum layout, const void* data = nullptr) {
    const GLint filter = which == kGround ? GL_LINEAR : GL_NEAREST;
    glBindTexture(GL_TEXTURE_2D, map[which]);
    glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, layout, GL_FLOAT, data);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }

  Expected<void> resize(int width, int height) {
    GLint most = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (width > most || height > most)
      return fail(internal::glFailure(
          "picture", fmt::format("{} x {} points, but this driver draws at most {}", width, height, most)));
    makeMap(kColor, GL_RGBA8, width, height, GL_RGBA);
    makeMap(kDepth, GL_DEPTH_COMPONENT32F, width, height, GL_DEPTH_COMPONENT);
    makeMap(kOcclusion, GL_RG16F, width, height, GL_RG);
    const auto attach = [&](GLuint target, GLenum point, Map which) {
      glBindFramebuffer(GL_FRAMEBUFFER, target);
      glFramebufferTexture2D(GL_FRAMEBUFFER, point, GL_TEXTURE_2D, map[which], 0);
      return glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
    };
    attach(points_target, GL_DEPTH_ATTACHMENT, kDepth);
    if (attach(points_target, GL_COLOR_ATTACHMENT0, kColor) &&
        attach(occlusion_target, GL_COLOR_ATTACHMENT0, kOcclusion))
      return {};
    return fail(
        internal::glFailure("picture", fmt::format("the driver refuses a framebuffer of {} x {}", width, height)));
  }

  // Both passes read the maps drawn before.
  void begin(const internal::GlProgram& program, GLuint target, int width, int height) const {
    glBindFramebuffer(GL_FRAMEBUFFER, target);
    glViewport(0, 0, width, height);
    glBindVertexArray(empty_array);
    program.use();
    const std::array<const char*, kMaps> names{"depth_map", "color_map", "occlusion_map", "ground_map"};
    for (int n = 0; n < kMaps; ++n) {
      glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + n));
      glBindTexture(GL_TEXTURE_2D, program.id == occlusion.id && n == kOcclusion ? 0 : map[n]);
      program.set(names[static_cast<std::size_t>(n)], n);
    }
    glActiveTexture(GL_TEXTURE0);
  }

  Expected<void> draw(GLuint target, const Camera& camera, int width, int height, const PictureOptions& options) {
    const int factor = std::clamp(options.supersampling, 1, 4);
    KERF_CHECK(resize(width * factor, height * factor));
    glBindFramebuffer(GL_FRAMEBUFFER, points_target);
    KERF_CHECK(renderer->draw(camera, width * factor, height * factor, {}));

    const double mm_per_point = camera.mmPerPixel(height * factor);
    const double visible = std::min(radius, 1.5 * camera.half_height);  // zoomed in: crevices of the detail
    const auto setCommon = [&](const internal::GlProgram& program) {
      program.set("mm_per_point", mm_per_point);
      program.set("half_depth", renderer->counts().half_depth_mm);
      program.set("reach", 0.22 * visible);
    };
    begin(occlusion, occlusion_target, width * factor, height * factor);
    setCommon(occlusion);
    internal::setLights(occlusion);
    occlusion.set("shadow_reach", 0.55 * visible);
    occlusion.set("samples", std::clamp(options.occlusion_samples, 0, 64));
    glDrawArrays(GL_TRIANGLES, 0, 3);

    const Vec3f ground = (shadow.center - camera.target).cast<float>();
    begin(finish, target, width, height);
    setCommon(finish);
    finish.set("rotation", Eigen::Matrix3f(camera.rotation().cast<float>()));
    finish.set("ground", Eigen::Vector4f(ground[0], ground[1], ground[2], static_cast<float>(shadow.side)));
    finish.set("points", Eigen::Vector2f(static_cast<float>(width * factor), static_cast<float>(height * factor)));
    finish.set("flags", (options.ground_shadow && !is_empty ? 1 : 0) | (options.transparent ? 2 : 0));
    finish.set("factor", factor);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindVertexArray(0);
    if (const GLenum error = glGetError(); error != GL_NO_ERROR)
      return fail(internal::glFailure("drawing", fmt::format("OpenGL error 0x{:x}", error)));
    return {};
  }
};

MeshPicture::MeshPicture() : impl_(std::make_unique<Impl>()) {}
MeshPicture::~MeshPicture() = default;

Expected<std::unique_ptr<MeshPicture>> MeshPicture::create() {
  KERF_TRY(renderer, LiveRenderer::create());
  std::unique_ptr<MeshPicture> out(new MeshPicture);
  Impl& impl = *out->impl_;
  impl.renderer = std::move(renderer);
  const char* const version = "#version 330 core\n";
  KERF_CHECK(impl.occlusion.build({version, live_shaders::kReduceVertex}, {version, picture_shaders::kOcclusion}));
  KERF_CHECK(impl.finish.build({version, live_shaders::kReduceVertex}, {version, picture_shaders::kFinish}));
  out->setMesh({});
  return out;
}

void MeshPicture::setMesh(const Mesh& mesh) {
  Impl& impl = *impl_;
  const Box3 box = bounds(mesh);
  const Vec3d center = box.isEmpty() ? Vec3d(Vec3d::Zero()) : box.center();
  impl.is_empty = mesh.triangles.empty();
  impl.radius = std::max(1e-3, 0.5 * box.size().norm());
  impl.shadow = groundShadow(mesh);
  impl.makeMap(Impl::kGround, GL_R32F, GroundShadow::kCells, GroundShadow::kCells, GL_RED, impl.shadow.darkness.data());

  Mesh centred = mesh;  // so that float32 is enough far from the origin
  for (Vec3d& p : centred.vertices) p -= center;
  impl.renderer->clear();
  for (ColouredChunk& made : chunksOf(centred, impl.radius / 20)) {
    impl.renderer->setChunk(kOutside, made.chunk, made.colours);
    turnInsideOut(made);
    impl.renderer->setChunk(kInside, made.chunk, made.colours);
  }
  for (const std::size_t side : {kOutside, kInside}) impl.renderer->setPose(side, {.translation = center});
}

Expected<Image> MeshPicture::picture(const Camera& camera, int width, int height, const PictureOptions& options) {
  if (width < 1 || height < 1 || width > kLargestPicture || height > kLargestPicture)
    return fail({.code = Error::Code::kBadValue,
                 .place = "picture size",
                 .found = fmt::format("{} x {}", width, height),
                 .expected = fmt::format("1 to {} pixels a side", kLargestPicture),
                 .hint = "--size 1600x1200"});
  const internal::GlTarget target(width, height);
  KERF_CHECK(impl_->draw(target.id(), camera, width, height, options));
  return target.read();
}

}  // namespace kerf
