// User settings in a text file that the user may edit.
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

/// Settings of a SpaceMouse.
struct SpaceMouseSettings {
  SpaceMouseLeads leads = SpaceMouseLeads::kView;  ///< space_mouse = "tool", "view" or "nothing"
  double gain = 1;                                 ///< space_mouse_gain: times the speed, 0.1 to 4
  double dead_band = 0.05;                         ///< space_mouse_dead_band: deflection at rest, 0 to 0.5
  bool is_dominant = false;                        ///< space_mouse_dominant: uses the dominant axis only
  /// space_mouse_inverted: names of kAxes, separated by blanks.
  std::array<bool, 6> is_inverted{};

  static constexpr double kLeastGain = 0.1, kMostGain = 4, kMostDeadBand = 0.5;
  static constexpr std::array<const char*, 6> kAxes = {"right", "away", "up", "pitch", "roll", "yaw"};
  bool operator==(const SpaceMouseSettings&) const = default;
};

struct Settings {
  Theme theme = Theme::kLight;          ///< theme = "light" or "dark"
  double ui_scale = 1;                  ///< ui_scale: of type and panels, a factor on the display's scale; 0.75 to 3
  bool are_hints_dismissed = false;     ///< hints_dismissed
  std::filesystem::path last_folder{};  ///< last_folder: start of the file browser; empty: the working folder
  double force_N = 1;                   ///< force_N: initial force of a pressed button, 0.1 to 8
  double depth_mm = 0.5;                ///< depth_mm: initial depth of a stroke, 0 to 5
  double sound_volume = 50;             ///< sound_volume: of the drill, %, 0 to 100
  bool is_muted = false;                ///< sound_muted
  double perspective_deg = 30;          ///< perspective_deg: field of view in perspective, 5 to 90

  SpaceMouseSettings space_mouse{};
  bool is_perspective = false;  ///< perspective: initial projection of a session

  std::string language = "en";  ///< language: of the window; "en", or the name of a file of language.h

  bool has_own_dialog = false;  ///< file_dialog = "own" or "system": the dialog to use where the system has one

  int window_width = 0, window_height = 0;     ///< window_width, window_height: at its last end, units; 0: the default
  double left_width = 250, right_width = 250;  ///< left_width, right_width: of the columns, units of type size 1
  static constexpr double kNarrowestColumn = 220, kWidestColumn = 500;
  static constexpr int kWidestWindow = 16384;

  /// left_button = "tool" or "turn": with "turn" it turns the view until the user takes the tool (tool.take).
  bool left_turns = false;

  /// favourite_tools: ids separated by blanks, in the order of choice; first in the rack.
  std::vector<std::string> favourite_tools{};

  static constexpr double kSmallestScale = 0.75, kLargestScale = 3;
  bool operator==(const Settings&) const = default;
};

/// "right up": the inverted axes; empty: none.
std::string namesOfInverted(const SpaceMouseSettings& settings);
/// Error kBadValue: a name outside kAxes.
Expected<std::array<bool, 6>> invertedFromNames(const std::string& names);
const char* nameOf(SpaceMouseLeads leads);

/// FOLDER/settings.toml. Unknown lines and comments stay. An unreadable file is never overwritten: error() names the
/// fault, the defaults apply, and save() fails.
class SettingsFile {
 public:
  /// Reads it. A missing file gives the defaults.
  /// @param folder  empty: userConfigFolder(). Made at the first write.
  explicit SettingsFile(std::filesystem::path folder = {});

  const std::filesystem::path& path() const { return path_; }
  const std::optional<Error>& error() const { return error_; }
  Settings values;

  /// Writes changes since the last read or write to a temporary file, syncs and renames it. Without changes it writes
  /// nothing.   Errors: kWriteFailed; error() if the file was broken, or is now.
  Expected<void> save();
  /// Renames a broken file to settings.toml.broken (-2, -3), and begins with the present values.
  Expected<void> setAside();

 private:
  std::filesystem::path path_;
  std::optional<Error> error_;
  Settings written_;
};

}  // namespace kerf
