// kerf-bridge-simulated: an arm for tests without hardware, for `kerf live --device bridge` and the window.
//
// Options set mass, damping, friction, encoder and delay. A hand that follows a path holds it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "bridges/simulated/arm_simulator.h"
#include "sim/device/record/arm_opener.h"
#include "sim/hand/device_profile.h"
#include "sim/hand/path.h"

namespace {

using namespace kerf;

std::atomic<bool> is_interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set by a signal handler");

struct Arguments {
  std::string path;
  int port = kBridgePort;
  double seconds = 0;
  DeviceHand::Options hand{.mass_kg = DeviceProfile{}.mass_kg,
                           .friction = DeviceProfile{}.friction,
                           .encoder_mm = DeviceProfile{}.encoder_mm};
  double delay_ms = 1000 * DeviceProfile{}.delay_s;
  bool json = false;
};

// A hand that comes down, presses for some seconds on a small circle, and lifts again.
CutPath ownPath() {
  CutPath out;
  const auto go = [&](double t, const Vec3d& p, bool cuts) {
    if (!out.poses.empty()) out.cuts.push_back(cuts);
    out.poses.push_back({t, {Eigen::Quaterniond::Identity(), p}});
  };
  go(0, {0, 0, 0}, false);
  go(1, {0, 0, 0}, false);
  go(3, {0, 0, -4}, true);
  for (int n = 1; n <= 40; ++n) {
    const double angle = 0.157079632679489662 * n;
    go(3 + 0.1 * n, {0.4 * std::sin(angle), 0.4 * (1 - std::cos(angle)), -4}, true);
  }
  go(8, {0, 0, 2}, false);
  go(9, {0, 0, 2}, false);
  return out;
}

void print(const ArmReport& r, bool json) {
  if (json) {
    const nlohmann::json out = {{"seconds", 1e-3 * static_cast<double>(r.ticks)},
                                {"most_force_N", r.most_force},
                                {"energy_Nmm", r.port_energy},
                                {"most_energy_Nmm", r.most_energy},
                                {"force_frames", r.force_frames},
                                {"stops", r.forceless},
                                {"worst_age_ms", r.worst_age_ms}};
    fmt::print("{}\n", out.dump(2));
    return;
  }
  fmt::print("{} ticks, {} force frames, {} stops by the dead-man; force {:.2f} N at most, up to {:.1f} ms old\n",
             r.ticks, r.force_frames, r.forceless, r.most_force, r.worst_age_ms);
  fmt::print("energy given to the hand: {:.4f} N mm at most, {:.4f} in the end\n", r.most_energy, r.port_energy);
}

Expected<void> simulate(const Arguments& a) {
  using std::chrono::duration;
  using std::chrono::steady_clock;
  CutPath path = ownPath();
  if (!a.path.empty()) {
    KERF_TRY(read, readPath(a.path));
    path = std::move(read);
  }
  KERF_TRY(arm, ArmSimulator::start(std::move(path), {.port = static_cast<std::uint16_t>(a.port), .hand = a.hand}));
  if (!a.json) fmt::print("a simulated arm sends to 127.0.0.1, port {}\n", a.port);
  std::fflush(stdout);

  const auto began = steady_clock::now();
  double last = -1;
  ArmReport r;
  for (;; std::this_thread::sleep_for(std::chrono::milliseconds(10))) {
    r = arm->report();
    const double now = duration<double>(steady_clock::now() - began).count();
    if (is_interrupted || r.is_over || (a.seconds > 0 && now >= a.seconds)) break;
    if (a.json || now - last < 0.5) continue;
    last = now;
    fmt::print("{:7.2f} s  at {:+.2f} {:+.2f} {:+.2f} mm, force {:+.2f} {:+.2f} {:+.2f} N{}\n", now, r.position[0],
               r.position[1], r.position[2], r.force[0], r.force[1], r.force[2], r.is_enabled ? "" : ", none");
    std::fflush(stdout);
  }
  print(r, a.json);
  return {};
}

}  // namespace

int main(int argc, char** argv) try {
  Arguments a;
  CLI::App app(
      "An arm that is not there, behind a bridge: Kerf takes it for a force-feedback device.\n"
      "Begin with: kerf live ... --device bridge, or kerf-sim --device bridge; then start this program.",
      "kerf-bridge-simulated");
  const auto number = [&](const char* name, double& value, const char* what, double low, double high) {
    app.add_option(name, value, what)->check(CLI::Range(low, high))->capture_default_str();
  };
  app.add_option("--port", a.port, "of 127.0.0.1, where Kerf listens")
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();
  app.add_option("--path", a.path, "a tool path that the hand follows; default: down, and a small circle")
      ->type_name("FILE");
  number("--for", a.seconds, "how long, s; 0: to the end of the path", 0, 1e5);
  number("--delay", a.delay_ms, "from a sample to its force at the motors, ms", 0, 50);
  number("--mass", a.hand.mass_kg, "that the hand moves at the tip, kg", 0.001, 10);
  number("--damping", a.hand.damping, "N s/mm", 0, 1);
  number("--friction", a.hand.friction, "at the tip, N", 0, 10);
  number("--encoder", a.hand.encoder_mm, "step of its position at the tip, mm; 0: perfect", 0, 1);
  app.add_flag("--json", a.json, "as JSON on standard output, once it is over");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  a.hand.delay_ticks = static_cast<int>(std::lround(a.delay_ms));
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, [](int) { is_interrupted = true; });

  const auto done = simulate(a);
  if (!done) fmt::print(stderr, "kerf-bridge-simulated: error: {}\n", done.error().message());
  return done ? 0 : 1;
} catch (const std::exception& e) {
  std::fprintf(stderr, "kerf-bridge-simulated: error: %s\n", e.what());
  return 1;
}
