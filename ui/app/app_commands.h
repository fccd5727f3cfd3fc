// Everything a user can ask the window for, in one table: menus, keys, scripts and the reference page read it.
//
// A new command is a row in app_commands.cpp.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/camera.h"
#include "ui/app/command_words.h"
#include "ui/app/workbench.h"

namespace kerf {

class SettingsFile;

/// What a command acts on.
struct AppContext {
  Workbench& bench;
  Camera& camera;
  int width = 1280, height = 800;  ///< of the picture, pixels
  bool wants_quit = false;
  /// Writes what the window shows; null where nothing is drawn.
  std::function<Expected<void>(const std::filesystem::path& png)> screenshot{};
  std::optional<std::array<double, 2>> pointer{};                ///< pixel of the picture; none: not over it
  std::function<void(const std::string& text)> set_clipboard{};  ///< null: to standard output
  SettingsFile* settings = nullptr;                              ///< null: nothing is kept
  bool shows_settings = false;
  bool wants_palette = false;
};

struct AppCommand {
  std::string_view id;           ///< "file.open"
  std::string_view menu;         ///< heading under which a menu lists it; empty: in scripts alone
  std::string_view label;        ///< in the menu
  std::string_view key;          ///< by default: "Ctrl+Z"; empty: none
  std::string_view parameters;   ///< in a script: "PATH", "[MM]"
  std::string_view description;  ///< one sentence
  bool (*is_enabled)(const AppContext&);
  Expected<void> (*run)(AppContext&, AppWords);
};

std::span<const AppCommand> appCommands();
/// Null: there is none of that id.
const AppCommand* findAppCommand(std::string_view id);
/// Runs a command if it is enabled. Errors: kNotFound for an unknown id, kUnsupported if it is not enabled now,
/// kBadValue for its parameters.
Expected<void> runAppCommand(AppContext& context, std::string_view id, AppWords parameters = {});

/// The words of a line of a script: blanks part them, double quotes keep them together, # begins a comment.
Expected<std::vector<std::string>> wordsOfLine(const std::string& line);

/// The table as Markdown: docs/reference/window-commands.md is this text.
std::string appCommandReference();

/// Under the pixel that two words name, the first of them word `n`.   Error kBadValue.
Expected<Ray> rayOf(const AppContext& context, AppWords words, std::size_t n = 0);
/// The ray under a pixel (y downwards) of the picture: parallel projection.
Ray rayUnder(const Camera& camera, double x, double y, int width, int height);
/// The way back: where a point of the world is in the picture.
std::array<double, 2> pixelOf(const Camera& camera, const Vec3d& point, int width, int height);
/// The view of something that was just opened: from its occlusal side if it has one, else as `otherwise` says.
void firstView(AppContext& context, const Camera& otherwise);
/// The box in view, with some margin.
void fitToBox(Camera& camera, const Box3& box, int width, int height);

/// Lines of commands; # begins a comment; words in double quotes may hold blanks. Beside the commands of the table:
///   wait               until no job runs and no plane is sawn
///   wait SECONDS       of the simulation
///   print              state as one line of JSON on standard output
///   expect WHAT LOW HIGH  ends the script unless removed (mm^3), depth (mm), sawn (percent of
///                      the plane sawn last), triangles or pieces is in that range
/// The first error ends it, and names the line.   @param frame  is called about 60 times a second while it waits.
Expected<void> runScript(AppContext& context, const std::filesystem::path& script, const std::function<void()>& frame);

}  // namespace kerf
