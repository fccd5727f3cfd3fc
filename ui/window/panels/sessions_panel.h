// The list of saved sessions: picture, name, date and size; open, rename, delete.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include "ui/app/commands/app_commands.h"
#include "ui/window/gl/picture_textures.h"

namespace kerf {

struct SessionsPanelState {
  PictureTextures pictures;
  bool was_drawn = false;
  std::optional<std::filesystem::path> renamed{}, deleted{};  ///< the session of the open question
  /// Closes the question.   @return  false: there is none.
  bool stopAsking() {
    const bool asked = renamed || deleted;
    renamed.reset();
    deleted.reset();
    return asked;
  }
  char name[101] = {};  ///< of the renamed one
};

/// Draws nothing while its switch is off.
void drawSessions(AppContext& context, SessionsPanelState& state);

}  // namespace kerf
