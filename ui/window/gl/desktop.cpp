#include "ui/window/gl/desktop.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cstdlib>

#include "ui/window/gl/font.h"
#include "ui/window/gl/gl_context.h"
#include "ui/window/gl/glfw_error.h"
#include "ui/window/gl/theme.h"

namespace kerf {
namespace {

constexpr float kFontPixels = 15;  // at a scale of 1
constexpr int kClickFrames = 4;    // for a press and a release, twice

int heldOf(GLFWwindow* window) {
  const auto isDown = [&](int key) { return glfwGetKey(window, key) == GLFW_PRESS; };
  const bool alt = isDown(GLFW_KEY_LEFT_ALT) || isDown(GLFW_KEY_RIGHT_ALT);
  const bool ctrl = isDown(GLFW_KEY_LEFT_CONTROL) || isDown(GLFW_KEY_RIGHT_CONTROL);
  return (alt ? GLFW_MOD_ALT : 0) | (ctrl ? GLFW_MOD_CONTROL : 0);
}

std::string utf8(unsigned code) {
  const auto tail = [&](int shift) { return static_cast<char>(0x80 | ((code >> shift) & 0x3F)); };
  if (code < 0x80) return {static_cast<char>(code)};
  if (code < 0x800) return {static_cast<char>(0xC0 | (code >> 6)), tail(0)};
  if (code < 0x10000) return {static_cast<char>(0xE0 | (code >> 12)), tail(6), tail(0)};
  return {static_cast<char>(0xF0 | (code >> 18)), tail(12), tail(6), tail(0)};
}

}  // namespace

Desktop::~Desktop() {
  if (has_panels_) {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
  }
  if (window_) glfwDestroyWindow(window_);
  if (is_started_) glfwTerminate();
}

Expected<void> Desktop::open(int width, int height) {
#ifdef GLFW_PLATFORM_X11  // GLFW 3.4 would try Wayland first; the window is tested on X11
  if (std::getenv("DISPLAY")) glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
  if (!glfwInit()) return fail(noWindow("cannot open a window: " + lastGlfwError()));
  is_started_ = true;
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  window_ = glfwCreateWindow(width, height, "Kerf", nullptr, nullptr);
  if (!window_) return fail(noOpenGl());

  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  listen();  // before Dear ImGui, which passes on all its events but keys
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // leaves no file behind in the working folder
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  has_panels_ = true;
  listenToKeys();
  if (!ImGui_ImplOpenGL3_Init("#version 330 core")) return fail(noWindow("Dear ImGui found no OpenGL 3.3"));

  float y = 1;
  glfwGetWindowContentScale(window_, &scale_, &y);
  scale_ = std::max(scale_, 1.0f);
  return {};
}

Desktop::Heard& Desktop::heardBy(GLFWwindow* window) { return *static_cast<Heard*>(glfwGetWindowUserPointer(window)); }

void Desktop::listen() {
  using Kind = InputEvent::Kind;
  glfwSetWindowUserPointer(window_, &heard_);
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int modifiers) {
    // GLFW would give the place of the pointer now: after a slow frame far from that of the press.
    const InputEvent e{.kind = Kind::kButton,
                       .key = button,
                       .modifiers = modifiers,
                       .is_down = action == GLFW_PRESS,
                       .x = heardBy(w).x,
                       .y = heardBy(w).y};
    heardBy(w).events.push_back(e);
    heardBy(w).click_frames = kClickFrames;
    if (button == GLFW_MOUSE_BUTTON_LEFT && e.is_down) heardBy(w).double_click.press(glfwGetTime(), e.x, e.y);
  });
  glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double x, double y) {
    heardBy(w).x = x;
    heardBy(w).y = y;
    heardBy(w).events.push_back({.kind = Kind::kMove, .modifiers = heldOf(w), .x = x, .y = y});
  });
  glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { heardBy(w).is_damaged = true; });
  glfwSetScrollCallback(
      window_, [](GLFWwindow* w, double, double y) { heardBy(w).events.push_back({.kind = Kind::kScroll, .y = y}); });
  glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** paths) {
    InputEvent drop{.kind = Kind::kDrop};
    drop.paths.assign(paths, paths + count);
    heardBy(w).events.push_back(std::move(drop));
  });
}

// Replaces Dear ImGui's callbacks: beginFrame() passes on the events that fit.
void Desktop::listenToKeys() {
  using Kind = InputEvent::Kind;
  glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int scancode, int action, int modifiers) {
    heardBy(w).events.push_back({.kind = Kind::kKey,
                                 .key = key,
                                 .modifiers = modifiers,
                                 .is_down = action != GLFW_RELEASE,
                                 .is_repeated = action == GLFW_REPEAT,
                                 .s = glfwGetTime()});
    heardBy(w).for_panels.add({.key = key, .scancode = scancode, .action = action, .modifiers = modifiers});
  });
  glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned code) {
    heardBy(w).events.push_back({.kind = Kind::kCharacter, .path = utf8(code)});
    heardBy(w).for_panels.add({.character = code});
  });
}

void Desktop::beginFrame() {
  for (const KeyTrickle::Event& e : heard_.for_panels.takeFrame()) {
    if (e.character)
      ImGui_ImplGlfw_CharCallback(window_, e.character);
    else
      ImGui_ImplGlfw_KeyCallback(window_, e.key, e.scancode, e.action, e.modifiers);
  }
#if IMGUI_VERSION_NUM >= 18700
  // Dear ImGui spreads clicks over frames. Keys are spread already: twice, text would lag behind the key that ends it.
  ImGui::GetIO().ConfigInputTrickleEventQueue = heard_.click_frames > 0;
  heard_.click_frames = std::max(heard_.click_frames - 1, 0);
#endif
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  // Dear ImGui compares the times of frames: in slow ones it misses most double clicks.
  const bool is_double = heard_.double_click.take();
  ImGui::GetIO().MouseDoubleClicked[0] = is_double;
#if IMGUI_VERSION_NUM >= 18700
  if (is_double) ImGui::GetIO().MouseClickedCount[0] = 2;
#endif
}

void Desktop::restyle(Theme theme, float factor) const {
  ImGui::GetIO().Fonts->Clear();
  addFont(*ImGui::GetIO().Fonts, kFontPixels * scale_ * factor);
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
  applyStyle(theme, scale_ * factor);
}

}  // namespace kerf
