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
  bool asks_before_quit = false;  ///< a person is there who can be asked: quit.h. In scripts nobody is
  bool is_asking_to_quit = false;
  /// Writes what the window shows; null where nothing is drawn.
  std::function<Expected<void>(const std::filesystem::path& png)> screenshot{};
  std::optional<std::array<double, 2>> pointer{};                ///< pixel of the picture; none: not over it
  std::function<void(const std::string& text)> set_clipboard{};  ///< null: to standard output
  SettingsFile* settings = nullptr;                              ///< null: nothing is kept
  bool shows_settings = false;
  bool wants_palette = false;
  bool shows_plots = false;
  bool shows_device = false;
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

/// A person is asked for a file before it is run.
inline bool asksForFile(const AppCommand& command) { return command.parameters.starts_with("PATH"); }

std::span<const AppCommand> appCommands();
/// Null: there is none of that id.
const AppCommand* findAppCommand(std::string_view id);
/// Runs a command if it is enabled. Errors: kNotFound for an unknown id, kUnsupported if it is not enabled now,
/// kBadValue for its parameters.
Expected<void> runAppCommand(AppContext& context, std::string_view id, AppWords parameters = {});

/// The table as Markdown: docs/reference/window-commands.md is this text.
std::string appCommandReference();

}  // namespace kerf
