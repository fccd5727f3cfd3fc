// The full path of a force in real time: simulated arm, datagrams, mailbox, haptic thread, and back to the arm's
// motors.
#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "bench/bench.h"
#include "bench/device_stack.h"
#include "bench/scenes/practice_block.h"
#include "bridges/simulated/arm_simulator.h"
#include "sim/device/arm/bridge_device.h"
#include "sim/hand/device_profile.h"
#include "sim/live/haptic_thread.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

constexpr double kSeconds = 10;
constexpr double kTransport = 0.003;  // s, as kerf live adds it

CutPath presses() {
  CutPath out;
  const auto go = [&](double t, const Vec3d& p) {
    if (!out.poses.empty()) out.cuts.push_back(1);
    out.poses.push_back({t, {Eigen::Quaterniond::Identity(), p}});
  };
  go(0, {0, 0, 0.5});
  go(1, {0, 0, 0.5});
  go(1.5, {0, 0, -2.5});
  go(kSeconds - 1, {0.5, 0, -2.5});
  go(kSeconds - 0.5, {0, 0, 0.5});
  go(kSeconds, {0, 0, 0.5});
  return out;
}

void addTimes(Result& r, const std::string& what, const TimeHistogram& times) {
  for (const auto& [name, p] : {std::pair("p50", 0.5), {"p99", 0.99}, {"p99.9", 0.999}})
    r.add(fmt::format("whole stack: {}, {}", what, name), times.percentileMs(p), "ms");
  r.add(fmt::format("whole stack: {}, max", what), times.maxMs(), "ms");
}

}  // namespace

Expected<void> pressThroughTheStack(Result& r, const Bench& bench) {
  if (!report(bench.progress, 0.95, "whole stack, 10 s on the clock")) return cancelled();
  DeviceProfile device{.delay_s = 0.001, .mass_kg = 0.08, .friction = 0.05, .encoder_mm = 0.02};
  DeviceProfile with_transport = device;
  with_transport.delay_s += kTransport;
  const DeviceCoupling coupling = couplingFor(with_transport);

  KERF_TRY(tool, toolOfRack("round-018"));
  KERF_TRY(model, makeModel(std::span(&tool, 1)));
  model.tools[0].drive.speed = 0;  // a wall: no cut
  model.settings.coupling = coupling.settings;
  KERF_TRY(block, practiceBlock({4, 4, 2}, 0.1, {}, Material::kEnamel));

  const Rigid3 start{Eigen::Quaterniond::Identity(), {0, 0, 0.5}};
  KERF_TRY(arm_here, BridgeDevice::open({.limits = {.force = 6, .rate = 2000, .ramp_s = 0.2}, .start = start}));
  arm_here->enable(true);
  HapticOptions options;
  options.stall_ms = 5000;
  HapticThread haptic(std::move(model), {block}, start, options);
  KERF_CHECK(haptic.start(*arm_here, {}, nullptr));
  DeviceHand::Options hand{.mass_kg = device.mass_kg, .friction = device.friction, .encoder_mm = device.encoder_mm};
  hand.delay_ticks = 1;
  KERF_TRY(arm, ArmSimulator::start(presses(), {.port = arm_here->port(),
                                                .hand = hand,
                                                .most_force = 6,
                                                .most_stiffness = coupling.settings.stiffness}));
  while (!arm->report().is_over) {
    haptic.update();
    // A machine that stalls a thread for 20 ms latches. The person continues.
    if (haptic.report().is_latched && arm_here->counts().is_talking) haptic.send(ClearLatch{});
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  haptic.stop();

  const ArmReport told = arm->report();
  if (told.most_force < 0.1) return brokenScene("whole stack", "no force reached the arm", "a pressed wall");
  r.add("whole stack: wall stiffness, as rated", coupling.settings.stiffness, "N/mm");
  addTimes(r, "age of a force at the motors", arm->ages());
  addTimes(r, "jitter of forces", arm->jitter());
  r.add("whole stack: most force", told.most_force, "N");
  r.add("whole stack: energy given, at the end", std::max(0.0, told.port_energy), "mJ");
  r.add("whole stack: stops by the dead-man", static_cast<double>(told.forceless));
  return {};
}

}  // namespace kerf::cli
