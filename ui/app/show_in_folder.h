// Shows written files in the file manager of the desktop: by D-Bus, which also marks them, else their folder by
// xdg-open.
//
// Both are programs on the PATH; nothing here waits for them. The file manager stays when the window ends.
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

/// One thread, the window's.
class ShowInFolder {
 public:
  /// Begins. What was under way is forgotten.   @param files  in one folder; at least one.
  /// Error kUnsupported: there is neither dbus-send nor xdg-open; it names the folder.
  Expected<void> begin(std::vector<std::filesystem::path> files);
  /// Nobody knows yet whether it is shown.
  bool isUnderWay() const { return child_ > 0; }
  /// Once a frame: how it ended, once; none: it is under way, or nothing was begun.   @cost  microseconds.
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

/// "file:///scans/tooth%2036.stl": RFC 3986, all but unreserved letters and the slash escaped.
std::string uriOf(const std::filesystem::path& file);
/// The words of the call org.freedesktop.FileManager1.ShowItems.
std::vector<std::string> showItemsCommand(std::span<const std::filesystem::path> files);

}  // namespace kerf
