#include "ui/window/frame_times.h"

#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>

#include "ui/app/mesh_chunks.h"
#include "ui/window/gl_context.h"
#include "ui/window/gl_target.h"
#include "ui/window/live_renderer.h"
#include "ui/window/renderer.h"

namespace kerf {
namespace {

double processorTime() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/// A square rod of 1.4 mm, 12 mm long.
ToolLook rod() {
  ToolLook look;
  look.cutting = {{-0.7, -0.7, 0}, {0.7, 0.7, 1.4}};
  const Box3 box{{-0.7, -0.7, 0}, {0.7, 0.7, 12}};
  for (int n = 0; n < 8; ++n) look.mesh.vertices.push_back(box.corner(n));
  look.mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                         {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return look;
}

double percentileOf(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
}

std::string timeLine(const char* name, const std::vector<double>& ms) {
  return fmt::format("{} p50 {:.1f} p95 {:.1f} ms\n", name, percentileOf(ms, 0.5), percentileOf(ms, 0.95));
}

}  // namespace

std::string FrameTimes::summary() const { return timeLine("live", live) + timeLine("picture", picture); }

Expected<FrameTimes> timeFrames(const Mesh& mesh, Camera camera, int width, int height, int frames) {
  KERF_TRY(context, OffscreenContext::create());
  KERF_TRY(live, LiveRenderer::create());
  KERF_TRY(picture, Renderer::create());
  // 130 triangles a chunk, as a brick through which a surface passes has.
  const double cell =
      std::sqrt(130 * surfaceArea(mesh) / static_cast<double>(std::max<std::size_t>(1, mesh.triangles.size())));
  for (const ColouredChunk& made : chunksOf(mesh, cell > 0 ? cell : 1)) live->setChunk(0, made.chunk, made.colours);
  live->setTool(rod());
  picture->setMesh(mesh);

  const Box3 box = bounds(mesh);
  LiveFrame frame;
  if (!box.isEmpty()) frame.T_world_tool = Rigid3{.translation = {box.center()[0], box.center()[1], box.max[2] - 1}};
  const RenderOptions moving{.supersampling = 1, .occlusion_samples = 3};  // as the window draws while it is turned

  FrameTimes times{.triangles = mesh.triangles.size(), .driver = context->description, .live = {}, .picture = {}};
  const internal::GlTarget target(width, height);
  const auto timed = [&](const auto& draw, std::vector<double>& ms, bool counts) -> Expected<void> {
    glBindFramebuffer(GL_FRAMEBUFFER, target.id());
    const double before = processorTime();
    KERF_CHECK(draw());
    glFinish();
    if (counts) ms.push_back(processorTime() - before);
    return {};
  };
  for (int n = 0; n <= frames; ++n) {
    camera.azimuth += std::numbers::pi / 180;
    KERF_CHECK(timed([&] { return live->draw(camera, width, height, frame); }, times.live, n > 0));
    if (n % 5 == 0)
      KERF_CHECK(timed([&] { return picture->draw(camera, width, height, moving); }, times.picture, n > 0));
  }
  return times;
}

}  // namespace kerf
