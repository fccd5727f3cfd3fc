// The table of all window commands. Menus, keys, scripts and `kerf help window` read it.
//
// A new command is a row of a table beside its function: command_tables.h.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"
#include "ui/app/base/command_words.h"
#include "ui/app/view/camera.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

class SettingsFile;

/// Panels that a command shows or hides, by the id of their row: "plots".
class PanelSwitches {
 public:
  /// Off until it is set. The reference stays valid.
  bool& operator[](std::string_view id) {
    const auto at = is_on_.find(id);
    return at != is_on_.end() ? at->second : is_on_.emplace(id, false).first->second;
  }

 private:
  std::map<std::string, bool, std::less<>> is_on_;
};

/// Pixels of the picture that panels cover, at each side.
struct ViewMargins {
  int left = 0, top = 0, right = 0, bottom = 0;
};

/// State that a command reads and changes.
struct AppContext {
  Workbench& bench;
  Camera& camera;
  int width = 1280, height = 800;  ///< size of the picture, pixels
  ViewMargins margins{};           ///< of the window's panels
  bool wants_quit = false;
  bool asks_before_quit = false;  ///< a user can answer: quit.h; false in scripts
  bool is_asking_to_quit = false;
  /// Writes the window's picture; null if nothing is drawn.
  std::function<Expected<void>(const std::filesystem::path& png)> screenshot{};
  std::optional<std::array<double, 2>> pointer{};                ///< pixel of the picture; none: outside
  std::function<void(const std::string& text)> set_clipboard{};  ///< null: to standard output
  SettingsFile* settings = nullptr;                              ///< null: settings are not saved
  bool wants_palette = false;
  bool is_tool_taken = false;  ///< while the left button turns the view: tool.take
  /// Asks for the file of a command, then runs it; null: nobody can answer.
  std::function<void(std::string_view id)> ask_for_file{};
  PanelSwitches panels{};
};

/// The left button leads the tool, not the view.
bool leftButtonCuts(const AppContext& context);

struct AppCommand {
  std::string_view id;  ///< "file.open"
  /// Heading in the menu, a section of it and its sub-menu: "File:2", "View:3>Section"; empty: scripts only.
  std::string_view menu;
  std::string_view label;        ///< text in the menu
  std::string_view key;          ///< default key: "Ctrl+Z"; empty: none
  std::string_view parameters;   ///< in a script: "PATH", "[MM]"
  std::string_view description;  ///< one sentence
  bool (*is_enabled)(const AppContext&);
  Expected<void> (*run)(AppContext&, AppWords);
};

/// The window prompts for a file before it runs the command.
inline bool asksForFile(const AppCommand& command) { return command.parameters.starts_with("PATH"); }

std::span<const AppCommand> appCommands();
/// "File": the heading without the section.
constexpr std::string_view menuOf(const AppCommand& command) { return command.menu.substr(0, command.menu.find(':')); }
/// "Section": the sub-menu; empty: none.
constexpr std::string_view submenuOf(const AppCommand& command) {
  const std::size_t at = command.menu.find('>');
  return at == std::string_view::npos ? std::string_view{} : command.menu.substr(at + 1);
}
/// The commands under a heading of the menu, section by section.
std::vector<const AppCommand*> commandsOfMenu(std::string_view heading);
/// Null if no command has that id.
const AppCommand* findAppCommand(std::string_view id);
/// Runs a command if it is enabled. Errors: kNotFound for an unknown id, kUnsupported if it is disabled now,
/// kBadValue for its parameters.
Expected<void> runAppCommand(AppContext& context, std::string_view id, AppWords parameters = {});
/// Runs a command if it is enabled. An error becomes a notice.
void runIfEnabled(AppContext& context, std::string_view id, AppWords parameters = {});
/// Numbers as parameters: they read back exactly.
std::vector<std::string> wordsOf(std::initializer_list<double> numbers);

}  // namespace kerf
