// Asks for the file that a command needs, and gives the command what was chosen: by the system's dialog where there is
// one and the settings do not say otherwise, else by the browser inside the window.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "ui/app/app_commands.h"
#include "ui/app/system_dialog.h"
#include "ui/window/file_browser.h"

namespace kerf {

/// On the window's thread. A frame never waits for a person.
class FileChooser {
 public:
  /// Where it begins.
  void setFolder(const std::filesystem::path& folder) { browser_.setFolder(folder); }
  /// Asks for the file of a command that takes a PATH. What was asked before and is still open is put away.
  void ask(AppContext& context, const AppCommand& command);
  /// A file is being chosen, by either.
  bool isShown() const { return browser_.isShown() || dialog_.isShown(); }
  /// The browser inside the window is shown: Enter and Escape are for it.
  bool takesKeys() const { return browser_.isShown(); }
  void accept() { browser_.accept(); }
  void cancel() { browser_.cancel(); }
  /// Once a frame: draws the browser, and runs the command when something was chosen. Its folder is kept in the
  /// settings.
  void update(AppContext& context);
  /// What update() does of the system's dialog, which goes on while the window is minimised.
  void takeAnswer(AppContext& context);

 private:
  void askInside(const AppContext& context);
  void take(AppContext& context, std::vector<std::filesystem::path> files);
  void keepFolder(AppContext& context, const std::filesystem::path& folder);

  FileBrowser browser_;
  SystemDialog dialog_;
  const AppCommand* asked_for_ = nullptr;
  // What it was asked of: the window stays usable under the system's dialog.
  std::uint64_t generation_ = 0;
  std::optional<std::uint32_t> piece_;
};

}  // namespace kerf
