// The main window: menus, rack, panels, mouse and keys around a LiveView.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/script/replay_film.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

struct WorkshopOptions {
  /// Meshes, recipes or cases: the first is the object to cut, the others its neighbours. None: the first screen.
  std::vector<std::filesystem::path> open;
  std::filesystem::path replay;  ///< run to watch, instead of `open`; empty: none
  WorkbenchOptions bench;
  std::filesystem::path config;  ///< folder of settings.toml; empty: the user's
  std::string space_mouse;       ///< path or serial number of the SpaceMouse; empty: the only one
  std::string view = "top";      ///< first view
  int width = 1280, height = 800;
  bool has_size = false;    ///< of the command line; else the size at the last end
  int frames = 0;           ///< closes after so many frames, for tests; 0: when the user closes it
  bool tells = false;       ///< also prints messages to the user on standard error
  bool is_watched = false;  ///< draws a script's frames like the window, and prints FrameWatch::summary()
};

/// Opens the window and runs until the user closes it.   @return frames drawn.
/// Errors: kUnsupported without a display or OpenGL 3.3.
Expected<int> runWorkshop(const WorkshopOptions& options);

/// Runs a script (ui/app/commands/app_commands.h) without a window; pictures are drawn off screen.
Expected<void> runWorkshopScript(const std::filesystem::path& script, const WorkshopOptions& options);

/// Writes pictures of the replay of `options.replay`, drawn off screen.   @return number of pictures.
Expected<std::size_t> runWorkshopFilm(const FilmOptions& film, const WorkshopOptions& options);

}  // namespace kerf
