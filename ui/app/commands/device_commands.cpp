#include "ui/app/commands/device_commands.h"

#include <nlohmann/json.hpp>

#include "sim/device/record/arm_opener.h"
#include "ui/app/commands/command_tables.h"
#include "ui/app/document/jobs.h"
#include "ui/app/session/arm_lead.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/force_device.h"

namespace kerf::device_commands {
namespace {

using DeviceLimits = SpaceMouseSettings;

SpaceMouseSettings& settingsOf(AppContext& c) { return c.settings->values.space_mouse; }

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
  c.bench.notices->say(now == SpaceMouseLeads::kTool   ? "The SpaceMouse moves the tool"
                       : now == SpaceMouseLeads::kView ? "The SpaceMouse moves the view"
                                                       : "The SpaceMouse is off");
  return c.settings->save();
}

Expected<void> gain(AppContext& c, AppWords words) {
  KERF_TRY(factor, numberOf(words, 0, "FACTOR", DeviceLimits::kLeastGain, DeviceLimits::kMostGain));
  settingsOf(c).gain = factor;
  return c.settings->save();
}

Expected<void> deadBand(AppContext& c, AppWords words) {
  KERF_TRY(percent, numberOf(words, 0, "PERCENT", 0, 100 * DeviceLimits::kMostDeadBand));
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
  if (words.empty()) return wrongWord("nothing", "any of right, away, up, pitch, roll, yaw; or none");
  std::string names;
  if (words.size() != 1 || words[0] != "none")
    for (const std::string& word : words) names += word + " ";
  KERF_TRY(inverted, invertedFromNames(names));
  settingsOf(c).is_inverted = inverted;
  return c.settings->save();
}

// ---- The force-feedback device

ArmLead& armOf(AppContext& c) { return c.bench.device->arm(); }

bool isOpen(const AppContext& c) { return c.bench.device->arm().isOpen(); }
bool isLeading(const AppContext& c) { return c.bench.device->isLed(); }
bool isArmed(const AppContext& c) { return c.bench.device->arm().isArmed(); }

Expected<void> open(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no device", kArmNames);
  return c.bench.device->open(words[0]);
}

Expected<void> close(AppContext& c, AppWords) {
  armOf(c).close();
  c.bench.notices->say("Force-feedback device closed. The mouse controls the tool.");
  return {};
}

Expected<void> arm(AppContext& c, AppWords) { return armOf(c).armForce(); }

Expected<void> disarm(AppContext& c, AppWords) {
  armOf(c).disarmForce();
  return {};
}

Expected<void> fit(AppContext& c, AppWords) { return c.bench.device->fit(); }

Expected<void> force(AppContext& c, AppWords words) {
  ArmChoice choice = armOf(c).choice();
  KERF_TRY(newtons, numberOf(words, 0, "NEWTONS", ArmChoice::kLeastForce, ArmChoice::kMostForce));
  choice.most_force = newtons;
  armOf(c).choose(choice);
  return {};
}

Expected<void> scale(AppContext& c, AppWords words) {
  ArmChoice choice = armOf(c).choice();
  KERF_TRY(factor, numberOf(words, 0, "FACTOR", ArmChoice::kLeastScale, ArmChoice::kMostScale));
  choice.scale = factor;
  armOf(c).choose(choice);
  return {};
}

Expected<void> turn(AppContext& c, AppWords words) {
  ArmChoice choice = armOf(c).choice();
  KERF_TRY(degrees, numberOf(words, 0, "DEG", -360, 360));
  choice.turn_deg = degrees;
  armOf(c).choose(choice);
  return {};
}

Expected<void> pedal(AppContext& c, AppWords words) {
  ArmChoice choice = armOf(c).choice();
  KERF_TRY(is_down, onOrOff(words, choice.pedal_is_down));
  choice.pedal_is_down = is_down;
  armOf(c).choose(choice);
  return {};
}

Expected<void> profile(AppContext& c, AppWords words) {
  ArmChoice choice = armOf(c).choice();
  DeviceProfile profile;
  KERF_TRY(delay_ms, numberOf(words, 0, "MS", 0, 50));
  KERF_TRY(mass, numberOf(words, 1, "KG", 0.001, 10));
  KERF_TRY(friction, numberOf(words, 2, "NEWTONS", 0, 10));
  KERF_TRY(encoder, numberOf(words, 3, "MM", 0, 1));
  profile.delay_s = delay_ms / 1000;
  profile.mass_kg = mass;
  profile.friction = friction;
  profile.encoder_mm = encoder;
  choice.profile = profile;
  armOf(c).choose(choice);
  return {};
}

Expected<void> place(AppContext& c, AppWords words) {
  Vec3d tip;
  for (int n = 0; n < 3; ++n) {
    KERF_TRY(value, numberOf(words, static_cast<std::size_t>(n), "X Y Z", -1e4, 1e4));
    tip[n] = value;
  }
  return c.bench.device->place(tip);
}

Expected<void> test(AppContext& c, AppWords words) {
  KERF_TRY(newtons, numberOr(words, 0, 0.5, "NEWTONS", 0, ForceArm::kMostTestForce));
  Vec3d direction = Vec3d::UnitZ();
  for (int n = 0; n < 3 && words.size() > 1; ++n) {
    KERF_TRY(value, numberOf(words, static_cast<std::size_t>(n) + 1, "X Y Z", -1, 1));
    direction[n] = value;
  }
  if (direction.norm() < 1e-3) return wrongWord("no direction", "X Y Z of the device");
  return armOf(c).testForce(newtons * direction.normalized());
}

constexpr AppCommand kRows[] = {
    {"device.leads", "Edit:2", "Switch SpaceMouse: tool or view", "", "[tool|view|nothing]",
     "Sets whether a SpaceMouse moves the tool or the view (default: the other one).", when::hasSettings, leads},
    {"device.gain", "", "", "", "FACTOR", "Sets the speed of a SpaceMouse, 0.1 to 4.", when::hasSettings, gain},
    {"device.dead-band", "", "", "", "PERCENT", "Sets the dead band of the SpaceMouse axes, 0 to 50 % of their range.",
     when::hasSettings, deadBand},
    {"device.dominant", "", "", "", "[on|off]", "Uses only the dominant axis of a SpaceMouse.", when::hasSettings,
     dominant},
    {"device.invert", "", "", "", "AXIS...|none",
     "Inverts axes of a SpaceMouse: right, away, up, pitch, roll, yaw. All others are not inverted.", when::hasSettings,
     invert},
    {"device.panel", "Device", "Devices...", "", "[on|off]",
     "Shows or hides the device panel: force-feedback device with its limits, SpaceMouse, gamepad or joystick.",
     when::always, switchPanel<"device">},
    {"device.open", "", "", "", "NAME",
     "Opens a force-feedback device: bridge, bridge:PORT, path or serial number. The device controls the tool once it "
     "is ready. The open object continues in a new session that fits the device.",
     when::isIdle, open},
    {"device.close", "Device", "Close device", "", "", "Turns the force off and returns the tool to the mouse.", isOpen,
     close},
    {"device.arm", "Device", "Arm: turn force on", "", "",
     "Turns the force of the device on; it fades in. Keep a hand on the device.", isOpen, arm},
    {"device.disarm", "Device", "Disarm: turn force off", "F8", "",
     "Turns the force off at once. The device still controls the tool.", isOpen, disarm},
    {"device.fit", "Device", "Fit session to device", "", "",
     "Continues in a new session whose coupling fits the current device.", when::isOpenAndIdle, fit},
    {"device.force", "", "", "", "NEWTONS", "Limits the force, 0.1 to 20 N. The device may limit it further.",
     when::always, force},
    {"device.scale", "", "", "", "FACTOR", "Sets the motion scale: mm in the scene per mm of the hand, 0.05 to 5.",
     when::always, scale},
    {"device.turn", "", "", "", "DEG", "Turns the device about the scene's z axis.", when::always, turn},
    {"device.pedal", "", "", "", "[on|off]", "Runs the drive without button 1 of the device.", when::always, pedal},
    {"device.profile", "", "", "", "MS KG N MM",
     "Sets the device profile: delay, mass, friction, encoder step. The coupling of the next session uses it.",
     when::always, profile},
    {"device.place", "", "", "", "X Y Z",
     "Places the tool tip at a point, in mm. The current hand position then maps to this point.", isLeading, place},
    {"device.test", "Device", "Test force: 0.5 N up", "", "[NEWTONS [X Y Z]]",
     "Pushes the hand gently for 1.5 s, at most 1 N, along a direction of the device (default: up).", isArmed, test},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

std::string deviceState(const AppContext& c) {
  const ArmView v = c.bench.device->arm().view();
  const auto list = [](const Vec3d& p) { return nlohmann::json{p[0], p[1], p[2]}; };
  const nlohmann::json j{{"device", v.what},
                         {"is_there", v.is_there},
                         {"is_leading", v.is_leading},
                         {"is_armed", v.is_armed},
                         {"missing", v.missing},
                         {"hand_mm", list(v.hand.pose.translation)},
                         {"buttons", v.hand.buttons},
                         {"force_N", list(v.felt.force)},
                         {"ramp", v.felt.ramp},
                         {"is_clamped", v.felt.is_clamped},
                         {"has_fault", v.felt.has_fault},
                         {"hands", v.counts.hands},
                         {"refused", v.counts.refused},
                         {"age_ms", {{"p50", v.age_p50_ms}, {"p99", v.age_p99_ms}, {"p99.9", v.age_p999_ms}}}};
  return j.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace kerf::device_commands
