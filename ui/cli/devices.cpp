#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "sim/device/record/arm_opener.h"
#include "sim/hand/device_profile.h"
#include "ui/cli/command.h"
#include "ui/cli/device_probe.h"
#include "ui/cli/device_words.h"

namespace kerf::cli {
namespace {

struct DevicesArguments {
  std::string device;  // path or serial
  bool wants_probe = false;
  std::string record, replay;  // files
  double seconds = 0;          // of probe and recording; 0: until an interrupt
  bool wants_typical = false;
  double delay_ms = 2;
  DeviceProfile profile;
  double wanted = CouplingSettings{}.stiffness;
  bool is_own = false;  // the user gave a number
  bool json = false;
};

// ---- Coupling limits

nlohmann::json devicesJson(const std::string& name, const DeviceProfile& p, const DeviceCoupling& c,
                           const CouplingSettings& wanted) {
  return {{"name", name},
          {"delay_ms", 1000 * p.delay_s},
          {"mass_kg", p.mass_kg},
          {"friction_N", p.friction},
          {"encoder_mm", p.encoder_mm},
          {"stiffness_N_per_mm", c.settings.stiffness},
          {"damping_Ns_per_m", 1000 * c.settings.damping},
          {"running_damping_Ns_per_m", 1000 * c.settings.running_damping},
          {"text", describeStiffness(c, wanted)}};
}

void printDevices(const std::string& name, const DeviceProfile& p, const DeviceCoupling& c,
                  const CouplingSettings& wanted) {
  printText("{}: {:g} ms, {:g} kg, {:g} N, {:g} mm\n", name, 1000 * p.delay_s, p.mass_kg, p.friction, p.encoder_mm);
  printText("  coupling {}; damping {:.2g} N s/m, {:.2g} while the drive turns\n", describeStiffness(c, wanted),
            1000 * c.settings.damping, 1000 * c.settings.running_damping);
}

int sayCouplings(const DevicesArguments& a) {
  CouplingSettings wanted;
  wanted.stiffness = a.wanted;
  nlohmann::json list = nlohmann::json::array();
  const auto show = [&](const std::string& name, const DeviceProfile& profile) {
    const DeviceCoupling coupling = couplingFor(profile, wanted);
    if (a.json)
      list.push_back(devicesJson(name, profile, coupling, wanted));
    else
      printDevices(name, profile, coupling, wanted);
  };

  if (a.is_own) {
    DeviceProfile own = a.profile;
    own.delay_s = a.delay_ms / 1000;
    show("device", own);
  } else {
    if (!a.json) printText("Typical numbers of such devices, not measured: delay, mass, friction, encoder.\n");
    for (const TypicalDevice& device : typicalDevices()) show(device.name, device.profile);
  }
  if (a.json) printJson(list);
  return kOk;
}

// ---- Connected devices

int listDevices(const DevicesArguments& a) {
  std::vector<FoundDevice> devices = findDevices();
  if (!a.device.empty()) {
    auto one = chooseDevice(devices, a.device);
    if (!one) return complain(one.error());
    devices = {std::move(*one)};
  }
  if (a.json) {
    nlohmann::json list = nlohmann::json::array();
    for (const FoundDevice& found : devices) list.push_back(cli::jsonOf(found));
    printJson(list);
    return kOk;
  }
  if (devices.empty()) printText("no supported device is plugged in\n");
  for (const FoundDevice& found : devices) {
    printText("{}: {}, {}\n", found.path(), found.name, found.driver->people);
    printText("  id {}, serial {}, driver {}", idOf(found.interfaces.front()),
              found.serial().empty() ? "none" : found.serial(), found.driver->id);
    if (found.interfaces.size() > 1) printText(", {}", counted(found.interfaces.size(), "interface"));
    printText("\n");
    if (!found.mayOpen()) printText("  {}\n", kMayNotOpen);
  }
  return kOk;
}

int runDevices(const DevicesArguments& a) {
  if (!a.replay.empty()) return printRecording(a.replay, a.json);
  if (a.wants_probe || !a.record.empty()) return probeDevice({a.device, a.wants_probe, a.record, a.seconds, a.json});
  if (a.is_own || a.wants_typical) return sayCouplings(a);
  return listDevices(a);
}

}  // namespace

void addDevices(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<DevicesArguments>();
  command.footer(
      "Without options: lists the supported devices that are plugged in, with path and serial number. No driver was\n"
      "tested on hardware: your recording helps (--record). It holds only the reports of the device.\n"
      "With a profile or --typical: the coupling that a force-feedback device can hold. One that is too stiff makes "
      "it\n"
      "tremble, or worse. The law: docs/how-it-works/step.md.\n"
      "--probe and --record also take an arm, as kerf live does: bridge[:PORT]; they send no force.\n"
      "Only the window reads gamepads and joysticks.\n"
      "Examples: kerf devices --probe --for 10\n"
      "          kerf devices bridge --record arm.txt, then kerf live --device replay:arm.txt ...\n"
      "          kerf devices /dev/hidraw3 --record mine.txt\n"
      "          kerf devices --delay 1.5 --mass 0.07 --friction 0.26 --encoder 0.055");
  CLI::Option* const device =
      command.add_option("DEVICE", a->device, "path or serial number, or bridge[:PORT]; default: the only device");
  CLI::Option* const probe = command.add_flag("--probe", a->wants_probe, "print its reports when they change");
  CLI::Option* const record = command.add_option("--record", a->record, "write its reports to this text file");
  CLI::Option* const replay =
      command.add_option("--replay", a->replay, "print the reports of such a file")->excludes(probe);
  replay->excludes(record)->excludes(device);
  command.add_option("--for", a->seconds, "how long to probe or record, s; 0: until Ctrl-C")
      ->check(CLI::Range(0.0, 1e5));
  CLI::Option* const typical =
      command.add_flag("--typical", a->wants_typical, "couplings of typical force-feedback devices");

  const auto number = [&](const char* name, double& value, const char* what, double low, double high) {
    return command.add_option(name, value, what)->check(CLI::Range(low, high))->capture_default_str();
  };
  std::vector<CLI::Option*> own;
  own.push_back(number("--delay", a->delay_ms, "delay from a sample to its force at the motors, ms", 0, 50));
  own.push_back(number("--mass", a->profile.mass_kg, "mass that the hand moves at the tip, kg", 0.001, 10));
  own.push_back(number("--friction", a->profile.friction, "friction of the device at the tip, N", 0, 10));
  own.push_back(number("--encoder", a->profile.encoder_mm, "encoder step at the tip, mm; 0: perfect", 0, 1));
  CLI::Option* const coupling = number("--coupling", a->wanted, "wanted stiffness, N/mm", 0.01, 100);
  for (CLI::Option* option : own) option->excludes(typical);
  command.add_flag("--json", a->json, "print JSON on standard output");
  command.callback([a, own, coupling, &exit_code] {
    for (const CLI::Option* option : own) a->is_own = a->is_own || option->count() > 0;
    if (coupling->count() > 0 && !a->is_own) a->wants_typical = true;
    exit_code = runDevices(*a);
  });
}

}  // namespace kerf::cli
