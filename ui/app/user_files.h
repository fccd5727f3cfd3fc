// Where a user's files are, and the list of what was opened last.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// Cases, sessions, pictures: $XDG_DATA_HOME/kerf, or ~/.local/share/kerf.
std::filesystem::path userDataFolder();
/// Settings: $XDG_CONFIG_HOME/kerf, or ~/.config/kerf.
std::filesystem::path userConfigFolder();

/// A scan, a recipe or a case that was opened.
struct RecentFile {
  std::filesystem::path path;  ///< absolute
  bool is_there = false;       ///< when the list was read, or refresh() called
};

/// The files that were opened last, in FOLDER/recent.txt: one path a line, the newest first. Pictures of them are in
/// FOLDER/recent. The file is written beside, synced and renamed; two windows at once lose no more than an entry.
class RecentFiles {
 public:
  static constexpr std::size_t kMost = 12;
  /// Reads the list; a file that is missing is an empty list.
  explicit RecentFiles(std::filesystem::path folder);

  std::span<const RecentFile> list() const { return list_; }
  /// Asks again which of them are there.
  void refresh();
  /// Puts a file first. Errors: kWriteFailed.
  Expected<void> add(const std::filesystem::path& path);
  /// Takes a file off the list and deletes its picture; the file itself stays. Errors: kWriteFailed.
  Expected<void> forget(std::size_t n);
  /// Where the picture of a file is, or will be.
  std::filesystem::path pictureOf(const std::filesystem::path& path) const;

 private:
  Expected<void> write() const;
  void read();
  std::filesystem::path folder_;
  std::vector<RecentFile> list_;
};

}  // namespace kerf
