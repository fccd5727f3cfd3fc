#include "ui/app/device_commands.h"

#include "ui/app/settings.h"

namespace kerf::device_commands {
namespace {

using Limits = SpaceMouseSettings;

SpaceMouseSettings& settingsOf(AppContext& c) { return c.settings->values.space_mouse; }

}  // namespace

Expected<void> leads(AppContext& c, AppWords words) {
  SpaceMouseLeads& now = settingsOf(c).leads;
  if (words.empty())
    now = now == SpaceMouseLeads::kTool ? SpaceMouseLeads::kView : SpaceMouseLeads::kTool;
  else if (words[0] == "tool")
    now = SpaceMouseLeads::kTool;
  else if (words[0] == "view")
    now = SpaceMouseLeads::kView;
  else if (words[0] == "nothing")
    now = SpaceMouseLeads::kNothing;
  else
    return wrongWord("\"" + words[0] + "\"", "tool, view or nothing");
  c.bench.say(std::string("The SpaceMouse leads ") + (now == SpaceMouseLeads::kNothing ? "" : "the ") + nameOf(now));
  return c.settings->save();
}

Expected<void> gain(AppContext& c, AppWords words) {
  KERF_TRY(factor, numberOf(words, 0, "FACTOR", Limits::kLeastGain, Limits::kMostGain));
  settingsOf(c).gain = factor;
  return c.settings->save();
}

Expected<void> deadBand(AppContext& c, AppWords words) {
  KERF_TRY(percent, numberOf(words, 0, "PERCENT", 0, 100 * Limits::kMostDeadBand));
  settingsOf(c).dead_band = percent / 100;
  return c.settings->save();
}

Expected<void> dominant(AppContext& c, AppWords words) {
  bool& now = settingsOf(c).is_dominant;
  if (words.empty())
    now = !now;
  else if (words[0] == "on" || words[0] == "off")
    now = words[0] == "on";
  else
    return wrongWord("\"" + words[0] + "\"", "on or off");
  return c.settings->save();
}

Expected<void> invert(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("nothing", "some of right, away, up, pitch, roll, yaw; or none");
  std::string names;
  if (words.size() != 1 || words[0] != "none")
    for (const std::string& word : words) names += word + " ";
  KERF_TRY(inverted, invertedFromNames(names));
  settingsOf(c).is_inverted = inverted;
  return c.settings->save();
}

}  // namespace kerf::device_commands
