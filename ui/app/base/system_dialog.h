// The system's file dialog as a separate program: zenity (GNOME, Xfce) or kdialog (KDE). The window keeps drawing and
// does not wait.
//
// If neither is on the PATH, the window shows its own dialog (file_browser.h). zenity uses the portal of xdg-desktop
// where the desktop is set up so; Kerf does not.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// A file choice to ask for.
struct FileQuestion {
  enum class What { kOpen, kOpenSeveral, kOpenFolder, kSave };
  What what = What::kOpen;
  std::string title{};             ///< "Open..."
  std::filesystem::path folder{};  ///< start folder; empty: the working folder
  std::string name{};              ///< suggested, of kSave
};

/// The chosen files. A case or a session to open is a folder: the user chooses its manifest, and the answer is the
/// folder.
using FileAnswer = std::vector<std::filesystem::path>;  ///< empty: cancelled

class SystemDialog {
 public:
  SystemDialog() = default;
  ~SystemDialog();  ///< closes the dialog
  SystemDialog(const SystemDialog&) = delete;
  SystemDialog& operator=(const SystemDialog&) = delete;

  /// The program on the PATH: "zenity" before "kdialog". None: there is no system dialog.
  static std::optional<std::string> program();

  /// Shows it.   @pre !isShown().   Errors: kNotFound without a program; kUnsupported if it can not be started.
  Expected<void> ask(const FileQuestion& question);
  bool isShown() const { return child_ > 0; }
  /// Once a frame: returns the choice once. None: the dialog is open, or was not opened.   @cost  microseconds; never
  /// waits.
  /// Errors: kUnsupported: the program failed, with its exit status; the dialog is gone then.
  std::optional<Expected<FileAnswer>> poll();
  /// Closes it, as if cancelled without an answer.
  void close();

 private:
  Expected<FileAnswer> answerOf(int status) const;

  pid_t child_ = 0;  // 0: none
  int out_ = -1;     // reads its output
  FileQuestion::What what_ = FileQuestion::What::kOpen;
  std::string program_, text_;
};

/// Its command line, the program first: for tests.   @param program  "zenity" or "kdialog".
std::vector<std::string> commandOf(const std::string& program, const FileQuestion& question);

}  // namespace kerf
