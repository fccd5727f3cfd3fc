// Asks the user for a command's file and runs the command with it. Uses the system's dialog if there is one and the
// settings allow it, else the browser inside the window.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "ui/app/base/system_dialog.h"
#include "ui/app/commands/app_commands.h"
#include "ui/window/screens/file_browser.h"

namespace kerf {

/// On the window's thread. Frames go on while the user chooses.
class FileChooser {
 public:
  /// First folder to show.
  void setFolder(const std::filesystem::path& folder) { browser_.setFolder(folder); }
  /// Asks for the file of a command that takes a PATH. Closes an earlier dialog that is still open.
  void ask(AppContext& context, const AppCommand& command);
  /// The dialog or the browser is open.
  bool isShown() const { return browser_.isShown() || dialog_.isShown(); }
  /// The browser inside the window is open: Enter and Escape are for it.
  bool takesKeys() const { return browser_.isShown(); }
  void accept() { browser_.accept(); }
  void cancel() { browser_.cancel(); }
  /// Once a frame: draws the browser, and runs the command after a choice. The settings keep its folder.
  void update(AppContext& context);
  /// The part of update() for the system's dialog, which stays open while the window is minimised.
  void takeAnswer(AppContext& context);

 private:
  void askInside(const AppContext& context);
  void take(AppContext& context, std::vector<std::filesystem::path> files);
  void keepFolder(AppContext& context, const std::filesystem::path& folder);

  FileBrowser browser_;
  SystemDialog dialog_;
  std::optional<std::filesystem::path> before_sessions_;  // folder of the browser before it was that of the sessions
  const AppCommand* asked_for_ = nullptr;
  // Workbench::generation() when the dialog opened: the window stays usable meanwhile.
  std::uint64_t generation_ = 0;
  std::optional<std::uint32_t> piece_;
};

}  // namespace kerf
