#include "ui/app/commands/command_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "ui/app/base/language.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/strokes.h"

namespace kerf::settings_commands {
namespace {

constexpr double kStep = 0.1;  // of the scale

tl::unexpected<Error> wrongSetting(const std::string& found, std::string expected) {
  return fail({.code = Error::Code::kBadValue,
               .found = found.empty() ? "nothing" : "\"" + found + "\"",
               .expected = std::move(expected)});
}

Expected<void> scaleTo(AppContext& c, double scale) {
  c.settings->values.ui_scale = std::clamp(scale, Settings::kSmallestScale, Settings::kLargestScale);
  return c.settings->save();
}

Expected<void> setTheme(AppContext& c, AppWords words) {
  Theme& theme = c.settings->values.theme;
  if (words.empty())
    theme = theme == Theme::kLight ? Theme::kDark : Theme::kLight;
  else if (words[0] == "light")
    theme = Theme::kLight;
  else if (words[0] == "dark")
    theme = Theme::kDark;
  else
    return wrongSetting(words[0], "light or dark");
  return c.settings->save();
}

Expected<void> setScale(AppContext& c, AppWords words) {
  const std::string expected = fmt::format("FACTOR: {:g} to {:g}", Settings::kSmallestScale, Settings::kLargestScale);
  if (words.empty()) return wrongSetting("", expected);
  double scale = 0;
  const std::string& word = words[0];
  const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), scale);
  const bool is_number = failed == std::errc{} && end == word.data() + word.size();
  if (!is_number || !(scale >= Settings::kSmallestScale && scale <= Settings::kLargestScale))
    return wrongSetting(word, expected);
  return scaleTo(c, scale);
}

Expected<void> makeLarger(AppContext& c, AppWords) { return scaleTo(c, c.settings->values.ui_scale + kStep); }
Expected<void> makeSmaller(AppContext& c, AppWords) { return scaleTo(c, c.settings->values.ui_scale - kStep); }

Expected<void> setHints(AppContext& c, AppWords words) {
  bool& are_dismissed = c.settings->values.are_hints_dismissed;
  if (words.empty())
    are_dismissed = !are_dismissed;
  else if (words[0] == "on" || words[0] == "off")
    are_dismissed = words[0] == "off";
  else
    return wrongSetting(words[0], "on or off");
  return c.settings->save();
}

Expected<void> keepPush(AppContext& c, AppWords) {
  c.settings->values.force_N = c.bench.strokes->force;
  c.settings->values.depth_mm = c.bench.strokes->depth_mm;
  return c.settings->save();
}

Expected<void> setVolume(AppContext& c, AppWords words) {
  KERF_TRY(percent, numberOf(words, 0, "PERCENT", 0, 100));
  c.settings->values.sound_volume = std::round(percent);
  c.settings->values.is_muted = false;
  return c.settings->save();
}

Expected<void> mute(AppContext& c, AppWords words) {
  bool& is_muted = c.settings->values.is_muted;
  if (words.empty())
    is_muted = !is_muted;
  else if (words[0] == "on" || words[0] == "off")
    is_muted = words[0] == "on";
  else
    return wrongSetting(words[0], "on or off");
  return c.settings->save();
}

Expected<void> setDialog(AppContext& c, AppWords words) {
  if (words.empty() || (words[0] != "own" && words[0] != "system"))
    return wrongSetting(words.empty() ? "" : words[0], "own or system");
  c.settings->values.has_own_dialog = words[0] == "own";
  return c.settings->save();
}

Expected<void> setLanguage(AppContext& c, AppWords words) {
  if (words.empty()) return wrongSetting("", "a language: en, de");
  KERF_CHECK(showLanguage(words[0], c.settings->path().parent_path()));
  c.settings->values.language = words[0];
  return c.settings->save();
}

Expected<void> setLeftButton(AppContext& c, AppWords words) {
  if (words.empty() || (words[0] != "tool" && words[0] != "turn"))
    return wrongSetting(words.empty() ? "" : words[0], "tool or turn");
  c.settings->values.left_turns = words[0] == "turn";
  c.is_tool_taken = false;
  return c.settings->save();
}

constexpr AppCommand kRows[] = {
    {"settings.show", "Edit:2", "Settings...", "Ctrl+,", "[on|off]", "Shows or hides the settings.", when::hasSettings,
     switchPanel<"settings">},
    {"sound.volume", "", "", "", "PERCENT", "Sets the volume of the drill sound, 0 to 100.", when::hasSettings,
     setVolume},
    {"sound.mute", "Edit:2", "Mute drill sound", "Ctrl+M", "[on|off]", "Mutes or unmutes the drill sound.",
     when::hasSettings, mute},
    {"settings.dialog", "", "", "", "own|system",
     "Sets the file dialog: Kerf's own browser, or the system dialog if installed (zenity, kdialog).",
     when::hasSettings, setDialog},
    {"settings.language", "", "", "", "LANGUAGE",
     "Sets the language of the window: en, de, or a file in the languages folder of the settings. marked: puts each "
     "translatable text in «».",
     when::hasSettings, setLanguage},
    {"settings.left-button", "", "", "", "tool|turn",
     "Sets the left mouse button: it leads the tool, or turns the view until the tool is taken.", when::hasSettings,
     setLeftButton},
    {"settings.push", "", "", "", "", "Saves the current push and depth as defaults for later sessions.",
     when::hasSettings, keepPush},
    {"view.theme", "View:6>Window", "Switch light/dark theme", "Ctrl+Shift+L", "[light|dark]",
     "Switches between light and dark panels.", when::hasSettings, setTheme},
    {"view.larger", "View:6>Window", "Enlarge text and panels", "Ctrl+=", "", "Enlarges text and panels.",
     when::hasSettings, makeLarger},
    {"view.smaller", "View:6>Window", "Shrink text and panels", "Ctrl+-", "", "Shrinks text and panels.",
     when::hasSettings, makeSmaller},
    {"view.scale", "", "", "", "FACTOR", "Sets the size of text and panels, 0.75 to 3.", when::hasSettings, setScale},
    {"view.hints", "View:6>Window", "Toggle mouse hints", "", "[on|off]", "Shows or hides the mouse hints.",
     when::hasSettings, setHints},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::settings_commands
