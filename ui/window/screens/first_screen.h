// The screen while no document is open: drop target, recent files and sessions with pictures, demos, lost sessions.
#pragma once

#include <imgui.h>

#include <functional>
#include <optional>

#include "ui/app/commands/app_commands.h"
#include "ui/window/gl/picture_textures.h"

namespace kerf {

/// Width and height of the pictures of recent files, pixels.
inline constexpr int kCardWidth = 320, kCardHeight = 200;

/// Owns textures: its OpenGL context is current in every call, the destructor included.
class FirstScreen {
 public:
  /// @param ask_for_file  asks for a path, then runs the command with it.
  void draw(AppContext& context, const std::function<void(const AppCommand&)>& ask_for_file);
  /// Reloads pictures and drops files that no longer exist.
  void refresh(AppContext& context);

 private:
  void drawLost(AppContext& context);
  void drawRecent(AppContext& context);
  void drawCard(AppContext& context, std::size_t n, float width);
  void drawSessionButtons(AppContext& context, std::size_t n, bool is_clicked, const ImVec2& at, float width);

  PictureTextures pictures_;
  bool was_drawn_ = false;
  std::optional<std::size_t> asks_to_forget_;  // a lost session
};

}  // namespace kerf
