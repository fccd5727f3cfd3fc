// The window of the desktop: GLFW and Dear ImGui, its type and style, and what a person did with mouse and keys.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/settings.h"
#include "ui/window/key_trickle.h"

struct GLFWwindow;

namespace kerf {

/// What happened, in the units of GLFW: keys and buttons by its numbers, places in window units, y downwards.
struct InputEvent {
  enum class Kind { kKey, kCharacter, kButton, kMove, kScroll, kDrop };
  Kind kind = Kind::kMove;
  int key = 0, modifiers = 0;  ///< of a button: its number. Of a move: those of Alt and Ctrl
  bool is_down = false, is_repeated = false;
  double x = 0, y = 0;                         ///< of a wheel: notches
  double s = 0;                                ///< of a key: when
  std::string path{};                          ///< of a character: itself, UTF-8
  std::vector<std::filesystem::path> paths{};  ///< dropped
};

/// One window. Taken down in reverse; all calls from the thread that opened it.
class Desktop {
 public:
  Desktop() = default;
  ~Desktop();
  Desktop(const Desktop&) = delete;
  Desktop& operator=(const Desktop&) = delete;

  /// Opens it, its OpenGL context current.   Errors: kUnsupported without a display or OpenGL 3.3.
  Expected<void> open(int width, int height);
  GLFWwindow* window() const { return window_; }
  /// What happened since this was asked last, in its order: nothing is lost in a slow frame.
  std::vector<InputEvent> takeEvents() { return std::exchange(heard_.events, {}); }
  /// Begins a frame of the panels: Dear ImGui is told of keys and characters, a slow frame's taps one by one.
  void beginFrame();
  /// The panels have not been told of everything yet: the next frame should come at once.
  bool isBehind() const { return heard_.for_panels.isWaiting(); }
  /// Type and panels anew, between two frames.   @param factor  times the scale of the display.
  void restyle(Theme theme, float factor) const;

 private:
  /// What GLFW has told: all of it for the window, keys also for the panels.
  struct Heard {
    std::vector<InputEvent> events;
    KeyTrickle for_panels;
  };

  void listen();
  void listenToKeys();
  static Heard& heardBy(GLFWwindow* window);

  GLFWwindow* window_ = nullptr;
  bool is_started_ = false, has_panels_ = false;
  float scale_ = 1;
  Heard heard_;
};

}  // namespace kerf
