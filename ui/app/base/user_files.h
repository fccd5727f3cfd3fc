// Paths of the user's files, and the list of recently opened files.
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

/// An opened scan, recipe or case, or a session to continue.
struct RecentFile {
  std::filesystem::path path;  ///< absolute
  bool is_there = false;       ///< at the time the list was read, or of refresh()
};

/// The recently opened files, in FOLDER/recent.txt: one path a line, newest first. Their pictures are in FOLDER/recent.
/// Written to a temporary file, synced and renamed; two windows at once lose at most one entry.
class RecentFiles {
 public:
  static constexpr std::size_t kMost = 12;
  /// Reads the list; a missing file is an empty list.
  explicit RecentFiles(std::filesystem::path folder);

  std::span<const RecentFile> list() const { return list_; }
  /// Updates is_there of all files.
  void refresh();
  /// Puts a file first. Errors: kWriteFailed.
  Expected<void> add(const std::filesystem::path& path);
  /// Puts `now` first and takes `old` off the list with its picture: a session of a file in place of the file. An `old`
  /// that is not in the list has no effect. Errors: kWriteFailed.
  Expected<void> replace(const std::filesystem::path& old, const std::filesystem::path& now);
  /// Takes a file off the list and deletes its picture; the file itself stays. Errors: kWriteFailed.
  Expected<void> forget(std::size_t n);
  /// Path of a file's picture, existing or not. A session has its own in its folder.
  std::filesystem::path pictureOf(const std::filesystem::path& path) const;

 private:
  Expected<void> write() const;
  void read();
  std::filesystem::path listPictureOf(const std::filesystem::path& path) const;
  std::filesystem::path folder_;
  std::vector<RecentFile> list_;
};

}  // namespace kerf
