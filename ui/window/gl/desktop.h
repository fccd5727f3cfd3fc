// The desktop window: GLFW and Dear ImGui, fonts and style, and mouse and key input.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/settings/settings.h"
#include "ui/window/gl/double_click.h"
#include "ui/window/gl/key_trickle.h"

struct GLFWwindow;

namespace kerf {

/// One input event in units of GLFW: its key and button numbers, positions in window units, y downwards.
struct InputEvent {
  enum class Kind { kKey, kCharacter, kButton, kMove, kScroll, kDrop };
  Kind kind = Kind::kMove;
  int key = 0, modifiers = 0;  ///< button events: its number; moves: modifiers, Alt and Ctrl
  bool is_down = false, is_repeated = false;
  double x = 0, y = 0;                         ///< wheel events: notches
  double s = 0;                                ///< key events: time
  std::string path{};                          ///< character events: the character, UTF-8
  std::vector<std::filesystem::path> paths{};  ///< dropped files
};

/// One window. The destructor frees in reverse order. All calls from the thread that opened it.
class Desktop {
 public:
  Desktop() = default;
  ~Desktop();
  Desktop(const Desktop&) = delete;
  Desktop& operator=(const Desktop&) = delete;

  /// Opens the window; its OpenGL context is then current.   Errors: kUnsupported without a display or OpenGL 3.3.
  Expected<void> open(int width, int height);
  GLFWwindow* window() const { return window_; }
  /// Events since the last call, in order. A slow frame loses none.
  std::vector<InputEvent> takeEvents() { return std::exchange(heard_.events, {}); }
  /// Begins a frame of the panels: passes keys and characters to Dear ImGui, a slow frame's taps one by one.
  /// A double click is judged by the times of its events.
  void beginFrame();
  /// Events wait for the panels: the next frame should come at once.
  bool isBehind() const { return heard_.for_panels.isWaiting(); }
  /// Events wait for takeEvents().
  bool hasEvents() const { return !heard_.events.empty(); }
  /// The system has damaged the window since the last call: it must be drawn again.
  bool takeDamage() { return std::exchange(heard_.is_damaged, false); }
  /// Applies fonts and style to the panels, between two frames.   @param factor  times the scale of the display.
  void restyle(Theme theme, float factor) const;

 private:
  /// Events from GLFW: all of them for the window, keys also for the panels.
  struct Heard {
    std::vector<InputEvent> events;
    KeyTrickle for_panels;
    bool is_damaged = true;
    DoubleClick double_click;  // of the left button
    double x = 0, y = 0;       // of the last move
    int click_frames = 0;      // frames to come in which Dear ImGui spreads clicks
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
