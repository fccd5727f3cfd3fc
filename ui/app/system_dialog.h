// The system's own file dialog, as a program beside the window: zenity (GNOME, Xfce) or kdialog (KDE). The window goes
// on drawing: nothing here waits for it.
//
// Where neither is on the PATH there is no such dialog, and the window shows its own (file_browser.h). The portal of
// xdg-desktop is reached by zenity where the desktop is set up so, not by us.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// What is to be chosen.
struct FileQuestion {
  enum class What { kOpen, kOpenSeveral, kOpenFolder, kSave };
  What what = What::kOpen;
  std::string title{};             ///< "Open..."
  std::filesystem::path folder{};  ///< where it begins; empty: the working folder
  std::string name{};              ///< suggested, of kSave
};

/// What was chosen. To open: of a case or a session, which are folders, a person chooses the manifest in it: the folder
/// is meant.
using FileAnswer = std::vector<std::filesystem::path>;  ///< empty: cancelled

class SystemDialog {
 public:
  SystemDialog() = default;
  ~SystemDialog();  ///< takes the dialog away
  SystemDialog(const SystemDialog&) = delete;
  SystemDialog& operator=(const SystemDialog&) = delete;

  /// The program on the PATH: "zenity" before "kdialog". None: there is no system dialog.
  static std::optional<std::string> program();

  /// Shows it.   @pre !isShown().   Errors: kNotFound without a program; kUnsupported if it can not be started.
  Expected<void> ask(const FileQuestion& question);
  bool isShown() const { return child_ > 0; }
  /// Once a frame: what was chosen, once; none: it is still open, or was not asked.   @cost  microseconds; never waits.
  /// Errors: kUnsupported: the program failed, with what it ended with; the dialog is gone then.
  std::optional<Expected<FileAnswer>> poll();
  /// Takes it away, as if cancelled without an answer.
  void close();

 private:
  Expected<FileAnswer> answerOf(int status) const;

  pid_t child_ = 0;  // 0: none
  int out_ = -1;     // what it writes
  FileQuestion::What what_ = FileQuestion::What::kOpen;
  std::string program_, text_;
};

/// The words of its command line, the program first: for tests.   @param program  "zenity" or "kdialog".
std::vector<std::string> commandOf(const std::string& program, const FileQuestion& question);

}  // namespace kerf
