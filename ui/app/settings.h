// What a user has set: kept in a text file that he may edit as well.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

enum class Theme { kLight, kDark };

enum class SpaceMouseLeads { kTool, kView, kNothing };

/// How a SpaceMouse is taken.
struct SpaceMouseSettings {
  SpaceMouseLeads leads = SpaceMouseLeads::kView;  ///< space_mouse = "tool", "view" or "nothing"
  double gain = 1;                                 ///< space_mouse_gain: times the speed, 0.1 to 4
  double dead_band = 0.05;                         ///< space_mouse_dead_band: so far an axis is at rest, 0 to 0.5
  bool is_dominant = false;                        ///< space_mouse_dominant: only the axis that is moved most counts
  /// space_mouse_inverted: names of axes with blanks between them, of kAxes.
  std::array<bool, 6> is_inverted{};

  static constexpr double kLeastGain = 0.1, kMostGain = 4, kMostDeadBand = 0.5;
  static constexpr std::array<const char*, 6> kAxes = {"right", "away", "up", "pitch", "roll", "yaw"};
  bool operator==(const SpaceMouseSettings&) const = default;
};

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

  SpaceMouseSettings space_mouse{};
  bool is_perspective = false;  ///< perspective: near things are larger, from the beginning of a session

  std::string language = "en";  ///< language: of the window; "en", or the name of a file of language.h

  bool has_own_dialog = false;  ///< file_dialog = "own" or "system": who asks for files where the system has a dialog

  /// favourite_tools: ids with blanks between them, in the order in which they were chosen; first in the rack.
  std::vector<std::string> favourite_tools{};

  static constexpr double kSmallestScale = 0.75, kLargestScale = 3;
  bool operator==(const Settings&) const = default;
};

/// "right up": the inverted axes; empty: none.
std::string namesOfInverted(const SpaceMouseSettings& settings);
/// Error kBadValue: a name that is none of kAxes.
Expected<std::array<bool, 6>> invertedFromNames(const std::string& names);
const char* nameOf(SpaceMouseLeads leads);

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
