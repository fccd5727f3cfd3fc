// The window in which a person cuts: menus, rack, panels, mouse and keys around a LiveView.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/replay_film.h"
#include "ui/app/workbench.h"

namespace kerf {

struct WorkshopOptions {
  /// Meshes, recipes or cases: the first is worked on, the others stand beside it. None: the first screen.
  std::vector<std::filesystem::path> open;
  std::filesystem::path replay;  ///< a run that is watched, in the place of `open`; empty: none
  WorkbenchOptions bench;
  std::filesystem::path config;  ///< folder of settings.toml; empty: that of the user
  std::string space_mouse;       ///< path or serial number of the one that is used; empty: the only one
  std::string view = "top";      ///< from which side it is seen first
  int width = 1280, height = 800;
  int frames = 0;           ///< closes after that many, for tests; 0: when the user does
  bool tells = false;       ///< what it says to the user is also printed on standard error, as it is said
  bool is_watched = false;  ///< a script's frames are drawn as the window draws them, and FrameWatch::summary() printed
};

/// Opens the window and runs until it is closed.   @return frames drawn.
/// Errors: kUnsupported without a display or OpenGL 3.3.
Expected<int> runWorkshop(const WorkshopOptions& options);

/// Runs a script (ui/app/app_commands.h) without a window; pictures are drawn off screen.
Expected<void> runWorkshopScript(const std::filesystem::path& script, const WorkshopOptions& options);

/// Writes pictures of the replay of `options.replay`, drawn off screen.   @return how many.
Expected<std::size_t> runWorkshopFilm(const FilmOptions& film, const WorkshopOptions& options);

}  // namespace kerf
