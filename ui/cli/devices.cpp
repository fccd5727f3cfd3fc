#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "sim/hand/device_profile.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct Arguments {
  double delay_ms = 2;
  DeviceProfile profile;
  double wanted = CouplingSettings{}.stiffness;
  bool is_own = false;  // some number was given
  bool json = false;
};

nlohmann::json jsonOf(const std::string& name, const DeviceProfile& p, const DeviceCoupling& c,
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

void print(const std::string& name, const DeviceProfile& p, const DeviceCoupling& c, const CouplingSettings& wanted) {
  fmt::print("{}: {:g} ms, {:g} kg, {:g} N, {:g} mm\n", name, 1000 * p.delay_s, p.mass_kg, p.friction, p.encoder_mm);
  fmt::print("  coupling {}; damping {:.2g} N s/m, {:.2g} while the drive turns\n", describeStiffness(c, wanted),
             1000 * c.settings.damping, 1000 * c.settings.running_damping);
}

int run(const Arguments& a) {
  CouplingSettings wanted;
  wanted.stiffness = a.wanted;
  nlohmann::json list = nlohmann::json::array();
  const auto show = [&](const std::string& name, const DeviceProfile& profile) {
    const DeviceCoupling coupling = couplingFor(profile, wanted);
    if (a.json)
      list.push_back(jsonOf(name, profile, coupling, wanted));
    else
      print(name, profile, coupling, wanted);
  };

  if (a.is_own) {
    DeviceProfile own = a.profile;
    own.delay_s = a.delay_ms / 1000;
    show("device", own);
  } else {
    if (!a.json)
      fmt::print("Numbers as such devices have them, not measured on any: delay, mass, friction, encoder.\n");
    for (const TypicalDevice& device : typicalDevices()) show(device.name, device.profile);
  }
  if (a.json) printJson(list);
  return kOk;
}

}  // namespace

void addDevices(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  command.footer(
      "A coupling that is too stiff for a device makes it tremble, or worse. Without options: typical devices.\n"
      "No device is opened yet. The law: docs/how-it-works/step.md.\n"
      "Example: kerf devices --delay 1.5 --mass 0.07 --friction 0.26 --encoder 0.055");
  const auto number = [&](const char* name, double& value, const char* what, double low, double high) {
    return command.add_option(name, value, what)->check(CLI::Range(low, high))->capture_default_str();
  };
  std::vector<CLI::Option*> own;
  own.push_back(number("--delay", a->delay_ms, "from a sample to its force at the motors, ms", 0, 50));
  own.push_back(number("--mass", a->profile.mass_kg, "that the hand moves at the tip, kg", 0.001, 10));
  own.push_back(number("--friction", a->profile.friction, "of the device at the tip, N", 0, 10));
  own.push_back(number("--encoder", a->profile.encoder_mm, "step of its position at the tip, mm; 0: perfect", 0, 1));
  number("--coupling", a->wanted, "stiffness that is wanted, N/mm", 0.01, 100);
  command.add_flag("--json", a->json, "as JSON on standard output");
  command.callback([a, own, &exit_code] {
    for (const CLI::Option* option : own) a->is_own = a->is_own || option->count() > 0;
    exit_code = run(*a);
  });
}

}  // namespace kerf::cli
