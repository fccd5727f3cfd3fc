#include "ui/app/settings/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <ostream>
#include <sstream>
#include <utility>
#include <vector>

#include "geometry/base/atomic_file.h"
#include "geometry/base/text.h"
#include "geometry/base/toml_reader.h"
#include "ui/app/base/user_files.h"
#include "ui/app/view/camera.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

std::string quotedSetting(const std::string& text) {
  std::ostringstream out;
  out << toml::value<std::string>(text);
  return out.str();
}

std::string joined(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : " ") + word;
  return out;
}

// Drops duplicates.
std::vector<std::string> wordsOf(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream words(text);
  for (std::string word; words >> word;)
    if (std::find(out.begin(), out.end(), word) == out.end()) out.push_back(word);
  return out;
}

// The table of keys: how to read and write each.
struct Key {
  const char* name;
  std::string (*text)(const Settings&);
  bool (*isSame)(const Settings&, const Settings&);
};
const std::vector<Key>& keys() {
  static const std::vector<Key> kKeys = {
      {"theme", [](const Settings& s) { return std::string(s.theme == Theme::kDark ? "\"dark\"" : "\"light\""); },
       [](const Settings& a, const Settings& b) { return a.theme == b.theme; }},
      {"ui_scale", [](const Settings& s) { return fmt::format("{:.2f}", s.ui_scale); },
       [](const Settings& a, const Settings& b) { return a.ui_scale == b.ui_scale; }},
      {"hints_dismissed", [](const Settings& s) { return std::string(s.are_hints_dismissed ? "true" : "false"); },
       [](const Settings& a, const Settings& b) { return a.are_hints_dismissed == b.are_hints_dismissed; }},
      {"last_folder", [](const Settings& s) { return quotedSetting(s.last_folder.string()); },
       [](const Settings& a, const Settings& b) { return a.last_folder == b.last_folder; }},
      {"force_N", [](const Settings& s) { return fmt::format("{:.2f}", s.force_N); },
       [](const Settings& a, const Settings& b) { return a.force_N == b.force_N; }},
      {"depth_mm", [](const Settings& s) { return fmt::format("{:.2f}", s.depth_mm); },
       [](const Settings& a, const Settings& b) { return a.depth_mm == b.depth_mm; }},
      {"sound_volume", [](const Settings& s) { return fmt::format("{:.0f}", s.sound_volume); },
       [](const Settings& a, const Settings& b) { return a.sound_volume == b.sound_volume; }},
      {"sound_muted", [](const Settings& s) { return std::string(s.is_muted ? "true" : "false"); },
       [](const Settings& a, const Settings& b) { return a.is_muted == b.is_muted; }},
      {"space_mouse", [](const Settings& s) { return quotedSetting(nameOf(s.space_mouse.leads)); },
       [](const Settings& a, const Settings& b) { return a.space_mouse.leads == b.space_mouse.leads; }},
      {"space_mouse_gain", [](const Settings& s) { return fmt::format("{:.2f}", s.space_mouse.gain); },
       [](const Settings& a, const Settings& b) { return a.space_mouse.gain == b.space_mouse.gain; }},
      {"space_mouse_dead_band", [](const Settings& s) { return fmt::format("{:.2f}", s.space_mouse.dead_band); },
       [](const Settings& a, const Settings& b) { return a.space_mouse.dead_band == b.space_mouse.dead_band; }},
      {"space_mouse_dominant",
       [](const Settings& s) { return std::string(s.space_mouse.is_dominant ? "true" : "false"); },
       [](const Settings& a, const Settings& b) { return a.space_mouse.is_dominant == b.space_mouse.is_dominant; }},
      {"space_mouse_inverted", [](const Settings& s) { return quotedSetting(namesOfInverted(s.space_mouse)); },
       [](const Settings& a, const Settings& b) { return a.space_mouse.is_inverted == b.space_mouse.is_inverted; }},
      {"perspective_deg", [](const Settings& s) { return fmt::format("{:.1f}", s.perspective_deg); },
       [](const Settings& a, const Settings& b) { return a.perspective_deg == b.perspective_deg; }},
      {"perspective", [](const Settings& s) { return std::string(s.is_perspective ? "true" : "false"); },
       [](const Settings& a, const Settings& b) { return a.is_perspective == b.is_perspective; }},
      {"language", [](const Settings& s) { return quotedSetting(s.language); },
       [](const Settings& a, const Settings& b) { return a.language == b.language; }},
      {"file_dialog", [](const Settings& s) { return std::string(s.has_own_dialog ? "\"own\"" : "\"system\""); },
       [](const Settings& a, const Settings& b) { return a.has_own_dialog == b.has_own_dialog; }},
      {"left_button", [](const Settings& s) { return std::string(s.left_turns ? "\"turn\"" : "\"tool\""); },
       [](const Settings& a, const Settings& b) { return a.left_turns == b.left_turns; }},
      {"window_width", [](const Settings& s) { return std::to_string(s.window_width); },
       [](const Settings& a, const Settings& b) { return a.window_width == b.window_width; }},
      {"window_height", [](const Settings& s) { return std::to_string(s.window_height); },
       [](const Settings& a, const Settings& b) { return a.window_height == b.window_height; }},
      {"left_width", [](const Settings& s) { return fmt::format("{:.0f}", s.left_width); },
       [](const Settings& a, const Settings& b) { return a.left_width == b.left_width; }},
      {"right_width", [](const Settings& s) { return fmt::format("{:.0f}", s.right_width); },
       [](const Settings& a, const Settings& b) { return a.right_width == b.right_width; }},
      {"favourite_tools", [](const Settings& s) { return quotedSetting(joined(s.favourite_tools)); },
       [](const Settings& a, const Settings& b) { return a.favourite_tools == b.favourite_tools; }},
  };
  return kKeys;
}

void readSpaceMouse(TomlTable& table, SpaceMouseSettings& out) {
  constexpr const char* kExpected = "\"tool\", \"view\" or \"nothing\"";
  const std::string leads = table.getOr<std::string>("space_mouse", nameOf(out.leads), kExpected);
  bool is_known = false;
  for (const auto one : {SpaceMouseLeads::kTool, SpaceMouseLeads::kView, SpaceMouseLeads::kNothing}) {
    if (leads != nameOf(one)) continue;
    out.leads = one;
    is_known = true;
  }
  if (!is_known) table.reject("space_mouse", "\"" + leads + "\"", kExpected);

  using Limits = SpaceMouseSettings;
  out.gain = table.numberOr("space_mouse_gain", out.gain, Limits::kLeastGain, Limits::kMostGain, "times");
  out.dead_band = table.numberOr("space_mouse_dead_band", out.dead_band, 0, Limits::kMostDeadBand, "of its range");
  out.is_dominant = table.getOr<bool>("space_mouse_dominant", false, "true or false");
  const std::string names = table.getOr<std::string>("space_mouse_inverted", "", "names of axes");
  if (const auto inverted = invertedFromNames(names))
    out.is_inverted = *inverted;
  else
    table.reject("space_mouse_inverted", "\"" + names + "\"", inverted.error().expected);
}

// Keeps unknown keys: another Kerf version may use them.
Expected<Settings> readSettings(const fs::path& path) {
  KERF_TRY(root, parseToml(path));
  TomlTable table(root, path, "settings");
  for (const auto& [key, value] : root) table.allow(std::string(key.str()));

  Settings out;
  const std::string theme = table.getOr<std::string>("theme", "light", "\"light\" or \"dark\"");
  if (theme != "light" && theme != "dark") table.reject("theme", "\"" + theme + "\"", "\"light\" or \"dark\"");
  out.theme = theme == "dark" ? Theme::kDark : Theme::kLight;
  out.ui_scale = table.numberOr("ui_scale", out.ui_scale, Settings::kSmallestScale, Settings::kLargestScale, "times");
  out.are_hints_dismissed = table.getOr<bool>("hints_dismissed", false, "true or false");
  out.last_folder = table.getOr<std::string>("last_folder", "", "a folder");
  out.force_N = table.numberOr("force_N", out.force_N, Strokes::kLeastForce, Strokes::kMostForce, "N");
  out.depth_mm = table.numberOr("depth_mm", out.depth_mm, 0, Strokes::kMostDepth);
  out.sound_volume = table.numberOr("sound_volume", out.sound_volume, 0, 100, "%");
  out.is_muted = table.getOr<bool>("sound_muted", false, "true or false");
  readSpaceMouse(table, out.space_mouse);
  out.perspective_deg =
      table.numberOr("perspective_deg", out.perspective_deg, Camera::kLeastField, Camera::kMostField, "deg");
  out.is_perspective = table.getOr<bool>("perspective", false, "true or false");
  out.language = table.getOr<std::string>("language", out.language, "a language, such as \"de\"");
  const std::string dialog = table.getOr<std::string>("file_dialog", "system", "\"own\" or \"system\"");
  if (dialog != "own" && dialog != "system") table.reject("file_dialog", "\"" + dialog + "\"", "\"own\" or \"system\"");
  out.has_own_dialog = dialog == "own";
  const std::string left = table.getOr<std::string>("left_button", "tool", "\"tool\" or \"turn\"");
  if (left != "tool" && left != "turn") table.reject("left_button", "\"" + left + "\"", "\"tool\" or \"turn\"");
  out.left_turns = left == "turn";
  const auto size = [&](const char* key) {
    return static_cast<int>(table.numberOr(key, 0, 0, Settings::kWidestWindow, "units"));
  };
  out.window_width = size("window_width");
  out.window_height = size("window_height");
  const auto column = [&](const char* key, double otherwise) {
    return table.numberOr(key, otherwise, Settings::kNarrowestColumn, Settings::kWidestColumn, "units");
  };
  out.left_width = column("left_width", out.left_width);
  out.right_width = column("right_width", out.right_width);
  out.favourite_tools = wordsOf(table.getOr<std::string>("favourite_tools", "", "ids of tools"));
  KERF_CHECK(table.finish());
  return out;
}

bool settingsAreThere(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

std::vector<std::string> linesOf(const fs::path& path) {
  std::istringstream in(readSmallFile(path, 16 << 20).value_or(""));
  std::vector<std::string> out;
  for (std::string line; std::getline(in, line);) out.push_back(line);
  return out;
}

bool isLineOf(const std::string& line, const std::string& key) {
  const std::size_t from = line.find_first_not_of(" \t");
  if (from == line.npos || line.compare(from, key.size(), key) != 0) return false;
  const std::size_t next = line.find_first_not_of(" \t", from + key.size());
  return next != line.npos && line[next] == '=';
}

// Kerf's keys come before the first table. A value is one line.
void setLine(std::vector<std::string>& lines, const std::string& key, const std::string& value) {
  const std::string line = key + " = " + value;
  std::size_t n = 0;
  for (; n < lines.size(); ++n) {
    const std::size_t from = lines[n].find_first_not_of(" \t");
    if (from != std::string::npos && lines[n][from] == '[') break;
    if (!isLineOf(lines[n], key)) continue;
    lines[n] = line;
    return;
  }
  lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(n), line);
}

}  // namespace

std::string namesOfInverted(const SpaceMouseSettings& settings) {
  std::string out;
  for (std::size_t n = 0; n < settings.is_inverted.size(); ++n)
    if (settings.is_inverted[n]) out += (out.empty() ? "" : " ") + std::string(SpaceMouseSettings::kAxes[n]);
  return out;
}

Expected<std::array<bool, 6>> invertedFromNames(const std::string& names) {
  std::array<bool, 6> out{};
  std::istringstream words(names);
  for (std::string word; words >> word;) {
    const auto& axes = SpaceMouseSettings::kAxes;
    const auto at = std::find(axes.begin(), axes.end(), word);
    if (at == axes.end())
      return fail({.code = Error::Code::kBadValue,
                   .found = "\"" + word + "\"",
                   .expected = "any of right, away, up, pitch, roll, yaw"});
    out[static_cast<std::size_t>(at - axes.begin())] = true;
  }
  return out;
}

const char* nameOf(SpaceMouseLeads leads) {
  switch (leads) {
    case SpaceMouseLeads::kTool:
      return "tool";
    case SpaceMouseLeads::kView:
      return "view";
    case SpaceMouseLeads::kNothing:
      break;
  }
  return "nothing";
}

SettingsFile::SettingsFile(fs::path folder)
    : path_((folder.empty() ? userConfigFolder() : std::move(folder)) / "settings.toml") {
  if (!settingsAreThere(path_)) return;
  auto read = readSettings(path_);
  if (!read) {
    error_ = read.error();
    if (error_->hint.empty()) error_->hint = "correct the line, or set the file aside in the settings window";
    return;
  }
  values = written_ = *read;
}

Expected<void> SettingsFile::save() {
  if (error_) return fail(*error_);
  if (values == written_) return {};
  // The user may have edited it since.
  if (settingsAreThere(path_))
    if (const auto now = readSettings(path_); !now) return fail(now.error());

  std::vector<std::string> lines = linesOf(path_);
  if (lines.empty()) lines.push_back("# Settings of kerf-sim. Unknown lines stay unchanged.");
  for (const Key& key : keys())
    if (!key.isSame(values, written_)) setLine(lines, key.name, key.text(values));

  std::error_code failed;
  fs::create_directories(path_.parent_path(), failed);
  KERF_TRY(file, AtomicFile::create(path_));
  for (const std::string& line : lines) file.stream() << line << '\n';
  KERF_CHECK(file.commit());
  written_ = values;
  return {};
}

Expected<void> SettingsFile::setAside() {
  if (!error_) return {};
  fs::path aside = path_;
  aside += ".broken";
  for (int n = 2; settingsAreThere(aside); ++n) aside = path_.string() + fmt::format(".broken-{}", n);
  std::error_code failed;
  fs::rename(path_, aside, failed);
  if (failed)
    return fail({.code = Error::Code::kWriteFailed,
                 .file = path_.string(),
                 .found = failed.message(),
                 .expected = "to be renamed to " + aside.filename().string(),
                 .hint = "rename the file yourself"});
  error_.reset();
  written_ = {};
  return {};
}

}  // namespace kerf
