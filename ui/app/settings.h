// What a user has set: kept in a text file that he may edit as well.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "geometry/base/error.h"

namespace kerf {

enum class Theme { kLight, kDark };

struct Settings {
  Theme theme = Theme::kLight;          ///< theme = "light" or "dark"
  double ui_scale = 1;                  ///< ui_scale: of type and panels, times that of the display; 0.75 to 3
  bool are_hints_dismissed = false;     ///< hints_dismissed
  std::filesystem::path last_folder{};  ///< last_folder: where the file browser begins; empty: the working folder
  double force_N = 1;                   ///< force_N: how hard a pressed button pushes at first, 0.1 to 8
  double depth_mm = 0.5;                ///< depth_mm: how deep a stroke may go at first, 0 to 5
  double sound_volume = 50;             ///< sound_volume: of the drill, %, 0 to 100
  bool is_muted = false;                ///< sound_muted
  double perspective_deg = 30;          ///< perspective_deg: field of view of a perspective, 5 to 90

  static constexpr double kSmallestScale = 0.75, kLargestScale = 3;
  bool operator==(const Settings&) const = default;
};

/// FOLDER/settings.toml. Lines that it does not know, comments among them, stay as they are. A file that can not be
/// read as settings is never written over: error() says what is wrong, the defaults hold, and save() refuses.
class SettingsFile {
 public:
  /// Reads it; a file that is missing is one with the defaults.
  /// @param folder  empty: userConfigFolder(). Made when it is first written.
  explicit SettingsFile(std::filesystem::path folder = {});

  const std::filesystem::path& path() const { return path_; }
  const std::optional<Error>& error() const { return error_; }
  Settings values;

  /// Writes what has changed since it was read or written: beside it, synced, renamed. Nothing changed: nothing is
  /// written.   Errors: kWriteFailed; error() if the file was broken, or is now.
  Expected<void> save();
  /// Renames a broken file to settings.toml.broken (-2, -3), and begins with the present values.
  Expected<void> setAside();

 private:
  std::filesystem::path path_;
  std::optional<Error> error_;
  Settings written_;
};

}  // namespace kerf
