// kerf live: a session with a force-feedback device behind a bridge, without a window.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>

#include "geometry/tool/tool_file.h"
#include "sim/device/record/arm_opener.h"
#include "sim/run/session/live_run.h"
#include "ui/cli/command.h"
#include "ui/cli/interruption.h"

namespace kerf::cli {
namespace {

using std::chrono::duration;
using std::chrono::steady_clock;

// s: a ms each for the bridge's clock, Kerf's thread and the tick. Without it, a simulated arm that cut a block
// received 2.4 N mm in 9 s; with it, it gave 0.7.
constexpr double kTransport = 0.003;

struct LiveArguments {
  std::string case_folder, run_folder, tool, device = "udp:4417", start;
  double seconds = 0, wait_s = 30;
  double force = 3, scale = 1, turn_deg = 0;
  bool is_forceless = false, pedal_is_down = false;
  double delay_ms = 2;
  DeviceProfile profile;
  bool json = false;
};

Expected<Vec3d> pointOf(const std::string& text) {
  Vec3d out;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int n = 0; n < 3; ++n) {
    const auto [after, error] = std::from_chars(at, end, out[n]);
    const bool is_last = n == 2;
    if (error != std::errc() || (is_last ? after != end : after == end || *after != ','))
      return fail({.code = Error::Code::kBadValue,
                   .place = "--start",
                   .found = "\"" + text + "\"",
                   .expected = "X,Y,Z in mm, as in --start 1.5,0,8"});
    at = after + (is_last ? 0 : 1);
  }
  return out;
}

// Waits for the bridge's first frame, which has the device's stiffness limit.
Expected<HandFrame> waitForHand(const ForceArm& device, double most_s) {
  HandFrame hand;
  for (const auto began = steady_clock::now(); !isInterrupted();) {
    if (device.lastHand(hand)) return hand;
    if (duration<double>(steady_clock::now() - began).count() > most_s) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const ArmCounts counts = device.counts();
  return fail(
      {.code = Error::Code::kNotFound,
       .place = device.what(),
       .found = counts.refused > 0 ? fmt::format("{} malformed frames: {}", counts.refused, counts.last_fault)
                                   : fmt::format("no hand in {:g} s", most_s),
       .expected = "a device or a bridge that sends its pose",
       .hint = counts.trouble + "; to try a bridge, start kerf-bridge-simulated (docs/reference/device-bridge.md)"});
}

// Runs the session and reports when the hand comes and goes. Clears a latch some time after the hand is back.
void follow(LiveRun& run, const ForceArm& device, const LiveArguments& a) {
  constexpr double kBack = 0.3;  // s
  const auto began = steady_clock::now();
  auto last_away = began;
  bool was_talking = true;
  while (!isInterrupted()) {
    const auto now = steady_clock::now();
    if (a.seconds > 0 && duration<double>(now - began).count() >= a.seconds) return;
    if (device.isGone() || device.isOver()) {
      if (!a.json) printText("{:8.3f} s  {}\n", duration<double>(now - began).count(), device.counts().trouble);
      return;
    }
    run.takeChunks();
    run.thread().update();
    const bool is_talking = device.counts().is_talking;
    if (!is_talking) last_away = now;
    if (is_talking != was_talking && !a.json)
      printText("{:8.3f} s  {}\n", duration<double>(now - began).count(),
                is_talking ? "the hand is back" : "no data from the hand: force off");
    was_talking = is_talking;
    const bool is_back = duration<double>(now - last_away).count() > kBack;
    if (run.thread().report().is_latched && is_back) {
      run.send(ClearLatch{});
      last_away = now;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

int say(const LiveArguments& a, const RunManifest& manifest, const HapticReport& report, const ArmCounts& counts) {
  double removed = 0;
  for (std::size_t n = 0; n < report.object_count; ++n) removed += report.objects[n].removed_mm3;
  if (a.json) {
    printJson({{"run", a.run_folder},
               {"seconds", manifest.duration_s},
               {"removed_mm3", removed},
               {"state_hash", manifest.state_hash},
               {"ticks", report.counts.ticks},
               {"overruns", report.counts.overruns},
               {"hand_frames", counts.hands},
               {"force_frames", counts.forces},
               {"refused_frames", counts.refused},
               {"old_frames", counts.old}});
    return kOk;
  }
  printText("cut for {:.3f} s with {}; removed {:.4f} mm3; state {}\n", manifest.duration_s, manifest.tool_id, removed,
            manifest.state_hash);
  printText("frames: {} from the hand, {} rejected, {} too old; {} with force\n", counts.hands, counts.refused,
            counts.old, counts.forces);
  printText("run written: {}\n", a.run_folder);
  return kOk;
}

int runLive(const LiveArguments& a) {
  const auto start = pointOf(a.start);
  if (!start) return complainOfUsage(start.error());
  const auto file = findToolFile(a.tool, defaultToolFolders());
  if (!file) return complain(file.error());
  const auto tool = readTool(*file);
  if (!tool) return complain(tool.error());

  const Interruption interruption;
  constexpr double kRadians = 0.017453292519943295;
  ArmSettings settings;
  settings.limits.force = a.force;
  settings.map = WorkspaceMap(Eigen::Quaterniond(Eigen::AngleAxisd(a.turn_deg * kRadians, Vec3d::UnitZ())), a.scale);
  settings.pedal_is_down = a.pedal_is_down;
  Rigid3 begin;
  begin.translation = *start;
  auto opened = openArm(a.device, settings, begin);
  if (!opened && opened.error().code == Error::Code::kBadValue) return complainOfUsage(opened.error());
  if (!opened) return complain(opened.error());
  const std::unique_ptr<ForceArm> device = std::move(opened->arm);
  if (!a.json) printText("waiting for a hand: {}\n", device->what());
  std::fflush(stdout);
  const auto hand = waitForHand(*device, a.wait_s);
  if (!hand) return complain(hand.error());

  DeviceProfile profile = withTurning(a.profile, *hand);
  profile.delay_s = a.delay_ms / 1000 + kTransport;
  CouplingSettings wanted;
  if (hand->most_stiffness > 0) wanted.stiffness = std::min(wanted.stiffness, hand->most_stiffness / a.scale);
  wanted.force_limit = std::min({wanted.force_limit, a.force, hand->most_force});
  const DeviceCoupling coupling = couplingFor(settings.map.inWorld(profile), wanted);

  LiveRunOptions live;
  live.tools = {{*file, *tool}};
  live.start = begin;
  live.step.coupling = coupling.settings;
  live.is_felt = true;
  auto session = [&] {
    TerminalProgress progress;
    return LiveRun::open(a.case_folder, a.run_folder, std::move(live), progress.callback());
  }();
  if (!session) return complain(session.error());
  if (!a.json)
    printText("coupling {}; force at most {:.2g} N{}\n", describeStiffness(coupling, wanted), wanted.force_limit,
              a.is_forceless ? ", switched off" : "");
  std::fflush(stdout);
  device->enable(!a.is_forceless);
  if (const auto started = (*session)->start(*device); !started) return complain(started.error());
  follow(**session, *device, a);

  const auto manifest = (*session)->finish();
  if (!manifest) return complain(manifest.error());
  (*session)->thread().update();
  return say(a, *manifest, (*session)->thread().report(), device->counts());
}

}  // namespace

void addLive(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<LiveArguments>();
  command.footer(
      "A bridge is a small program for a device, which sends its pose to a port of 127.0.0.1 and gets its force\n"
      "(docs/reference/device-bridge.md). Kerf rejects other machines. All devices: docs/reference/devices.md.\n"
      "Tested with simulated arms only: keep a hand on the switch of the device.\n"
      "Button 1 is the pedal; while button 2 is held the hand moves and the tool stays.\n"
      "Ctrl-C ends the session and writes its run, for replay and export.\n"
      "Example: kerf live molar.case --tool round-014 --start 0,0,9 -o molar.run\n"
      "         kerf-bridge-simulated                                    (in another terminal, to try)");
  command.add_option("CASE", a->case_folder, "case folder")->required();
  command.add_option("--tool", a->tool, "tool id (kerf tool list) or a tool's TOML file")->required();
  command.add_option("-o,--output", a->run_folder, "run folder to write")->required();
  command.add_option("--start", a->start, "start position of the tool tip, X,Y,Z in mm; the tool is upright")
      ->required();
  command.add_option("--device", a->device, "bridge, bridge:PORT; replay:FILE; path or serial number of an arm")
      ->capture_default_str();
  const auto number = [&](const char* name, double& value, const char* what, double low, double high) {
    command.add_option(name, value, what)->check(CLI::Range(low, high))->capture_default_str();
  };
  number("--for", a->seconds, "duration, s; 0: until Ctrl-C", 0, 1e5);
  number("--wait", a->wait_s, "longest wait for the hand, s", 0.1, 1e5);
  number("--force", a->force, "force limit, N; at most the limit of the device", 0.1, 20);
  number("--scale", a->scale, "mm of the scene per mm of the hand", 0.05, 5);
  number("--turn", a->turn_deg, "rotation of the device about the scene's z axis, degrees", -360, 360);
  number("--delay", a->delay_ms,
         "delay of the device alone, from a sample to its force at the motors, ms; Kerf adds 3 for the datagrams", 0,
         50);
  number("--mass", a->profile.mass_kg, "mass of the device at the tip, kg", 0.001, 10);
  number("--friction", a->profile.friction, "friction of the device at the tip, N", 0, 10);
  number("--encoder", a->profile.encoder_mm, "encoder step at the tip, mm; 0: perfect", 0, 1);
  command.add_flag("--no-force", a->is_forceless, "the device controls the tool without force");
  command.add_flag("--pedal", a->pedal_is_down, "run the drive without button 1");
  command.add_flag("--json", a->json, "print JSON on standard output");
  command.callback([a, &exit_code] { exit_code = runLive(*a); });
}

}  // namespace kerf::cli
