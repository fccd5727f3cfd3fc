// Shows written files in the desktop's file manager: by D-Bus, which also selects them, else their folder by xdg-open.
//
// Both are programs on the PATH; Kerf does not wait for them. The file manager stays when the window ends.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// Window thread only.
class ShowInFolder {
 public:
  /// Begins, and drops an earlier request.   @param files  in one folder; at least one.
  /// Error kUnsupported: neither dbus-send nor xdg-open exists; it names the folder.
  Expected<void> begin(std::vector<std::filesystem::path> files);
  /// The request is still running.
  bool isUnderWay() const { return child_ > 0; }
  /// Once a frame: returns the outcome once. None: still running, or no request.   @cost  microseconds.
  /// Error kUnsupported: neither program could show it, with the folder to look in.
  std::optional<Expected<void>> poll();

 private:
  Expected<void> openFolder();
  tl::unexpected<Error> notShown(std::string found) const;

  std::vector<std::filesystem::path> files_;
  pid_t child_ = 0;  // 0: none
  bool is_by_bus_ = false;
  std::chrono::steady_clock::time_point began_;
};

/// "file:///scans/tooth%2036.stl": RFC 3986, escapes all but unreserved letters and the slash.
std::string uriOf(const std::filesystem::path& file);
/// The words of the call org.freedesktop.FileManager1.ShowItems.
std::vector<std::string> showItemsCommand(std::span<const std::filesystem::path> files);

}  // namespace kerf
