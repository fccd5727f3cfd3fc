#include "ui/window/window.h"

#include <epoxy/gl.h>
#include <fmt/format.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <cmath>
#include <cstring>
#include <string>

#include "ui/window/glfw_error.h"
#include "ui/window/renderer.h"
#include "ui/window/scale_bar.h"
#include "ui/window/widgets.h"

namespace kerf {
namespace {

/// GLFW, its window and Dear ImGui, taken down in reverse.
struct ViewerDesktop {
  GLFWwindow* window = nullptr;
  bool started = false, panels = false;
  ~ViewerDesktop() {
    if (panels) {
      ImGui_ImplOpenGL3_Shutdown();
      ImGui_ImplGlfw_Shutdown();
      ImGui::DestroyContext();
    }
    if (window) glfwDestroyWindow(window);
    if (started) glfwTerminate();
  }
};

struct View {
  Camera camera;
  const Mesh* mesh = nullptr;
  int width = 1, height = 1;   ///< framebuffer, pixels
  double pixels_per_unit = 1;  ///< framebuffer pixels per window unit
};

void fit(View& view) { fitTo(view.camera, *view.mesh, view.width, view.height); }

void takeNamedView(View& view, std::size_t i) {
  if (auto named = cameraFromView(namedViews()[i].name)) {
    view.camera = *named;
    fit(view);
  }
}

void moveByMouse(View& view, const ImGuiIO& io) {
  if (io.WantCaptureMouse) return;
  const double dx = io.MouseDelta.x * view.pixels_per_unit, dy = io.MouseDelta.y * view.pixels_per_unit;
  const bool pans = ImGui::IsMouseDown(ImGuiMouseButton_Middle) || ImGui::IsMouseDown(ImGuiMouseButton_Right) ||
                    (ImGui::IsMouseDown(ImGuiMouseButton_Left) && io.KeyShift);
  if (pans)
    pan(view.camera, dx, dy, view.height);
  else if (ImGui::IsMouseDown(ImGuiMouseButton_Left))
    orbit(view.camera, io.MouseDelta.x, io.MouseDelta.y);

  if (io.MouseWheel != 0) {
    const double x = io.MousePos.x * view.pixels_per_unit - 0.5 * view.width;
    const double y = io.MousePos.y * view.pixels_per_unit - 0.5 * view.height;
    pan(view.camera, -x, -y, view.height);
    zoomBy(view.camera, std::pow(1.15, io.MouseWheel));
    pan(view.camera, x, y, view.height);
  }
}

void drawScenePanel(const Scene& scene, const Vec3d& size, View& view) {
  ImGui::SetNextWindowPos({12, 12}, ImGuiCond_FirstUseEver);
  ui::begin("Scene", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
  ui::text(ui::asItIs(scene.mesh_file.filename().string()));
  ui::text(fmt::format("{} triangles", scene.mesh.triangles.size()));
  ui::text(fmt::format("{:.2f} x {:.2f} x {:.2f} mm", size.x(), size.y(), size.z()));
  ui::text("unit: " + scene.unit);

  ImGui::Separator();
  for (std::size_t i = 0; i < namedViews().size(); ++i) {
    if (i % 4) ImGui::SameLine();
    if (ui::button(namedViews()[i].name, {56, 0})) takeNamedView(view, i);
  }
  ImGui::SameLine();
  if (ui::button("fit", {56, 0})) fit(view);
  ImGui::End();
}

void drawScaleBarOverlay(const View& view) {
  const ImGuiIO& io = ImGui::GetIO();
  drawScaleBarAt({io.DisplaySize.x - 24, io.DisplaySize.y - 24}, view.camera, view.width, view.height,
                 view.pixels_per_unit, IM_COL32(58, 62, 68, 255));
}

Expected<void> open(ViewerDesktop& desktop, const Scene& scene, const WindowOptions& options) {
  if (!glfwInit()) return fail(noWindow("no window can be opened: " + lastGlfwError()));
  desktop.started = true;
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);

  const std::string title = scene.mesh_file.filename().string() + " - Kerf";
  desktop.window = glfwCreateWindow(options.width, options.height, title.c_str(), nullptr, nullptr);
  if (!desktop.window) return fail(noOpenGl());

  glfwMakeContextCurrent(desktop.window);
  glfwSwapInterval(1);

  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // leaves no file behind in the working folder
  ImGui::StyleColorsLight();
  ImGui_ImplGlfw_InitForOpenGL(desktop.window, true);
  if (!ImGui_ImplOpenGL3_Init("#version 330 core")) {
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    return fail(noWindow("Dear ImGui found no OpenGL 3.3"));
  }
  desktop.panels = true;
  return {};
}

}  // namespace

Expected<int> runWindow(const Scene& scene, Camera camera, const WindowOptions& options) {
  ViewerDesktop desktop;
  KERF_CHECK(open(desktop, scene, options));
  KERF_TRY(renderer, Renderer::create());
  renderer->setMesh(scene.mesh);
  const Vec3d size = bounds(scene.mesh).size();

  // Jagged edges while the software renderer draws, smooth ones with a graphics card.
  const bool slow = std::strstr(reinterpret_cast<const char*>(glGetString(GL_RENDERER)), "llvmpipe") != nullptr;
  const RenderOptions still{.supersampling = slow ? 1 : 2, .occlusion_samples = slow ? 8 : 16};
  const RenderOptions moving{.supersampling = still.supersampling, .occlusion_samples = slow ? 3 : 16};

  View view{camera, &scene.mesh, options.width, options.height, 1};
  int frames = 0;
  while (!glfwWindowShouldClose(desktop.window) && (options.frames == 0 || frames < options.frames)) {
    // Sleeps while nothing happens; four times a second the panel gets its turn anyway. A counted run never waits.
    options.frames > 0 ? glfwPollEvents() : glfwWaitEventsTimeout(0.25);
    int window_width = 0, window_height = 0;
    glfwGetWindowSize(desktop.window, &window_width, &window_height);
    glfwGetFramebufferSize(desktop.window, &view.width, &view.height);
    if (view.width == 0 || view.height == 0 || window_width == 0) {  // minimised
      glfwWaitEventsTimeout(0.1);
      continue;
    }

    view.pixels_per_unit = static_cast<double>(view.width) / window_width;
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();

    moveByMouse(view, ImGui::GetIO());
    for (std::size_t i = 0; i < namedViews().size(); ++i)
      if (ImGui::IsKeyPressed(GLFW_KEY_1 + static_cast<int>(i), false)) takeNamedView(view, i);
    if (ImGui::IsKeyPressed(GLFW_KEY_F, false)) fit(view);
    if (ImGui::IsKeyPressed(GLFW_KEY_ESCAPE, false)) glfwSetWindowShouldClose(desktop.window, GLFW_TRUE);

    drawScenePanel(scene, size, view);
    drawScaleBarOverlay(view);

    ImGui::Render();
    KERF_CHECK(renderer->draw(view.camera, view.width, view.height, ImGui::IsAnyMouseDown() ? moving : still));
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glfwSwapBuffers(desktop.window);
    ++frames;
  }
  return frames;
}

}  // namespace kerf
