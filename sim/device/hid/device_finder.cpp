#include "sim/device/hid/device_finder.h"

#include <fmt/format.h>

#include <algorithm>

namespace kerf {
namespace {

bool isMeant(const FoundDevice& device, const std::string& name) {
  if (!device.serial().empty() && device.serial() == name) return true;
  return std::any_of(device.interfaces.begin(), device.interfaces.end(),
                     [&](const HidInfo& i) { return i.path == name; });
}

std::string listOf(const std::vector<FoundDevice>& devices) {
  std::string out;
  for (const FoundDevice& d : devices) {
    out += (out.empty() ? "" : ", ") + d.path();
    if (!d.serial().empty()) out += " (serial " + d.serial() + ")";
  }
  return out;
}

}  // namespace

bool FoundDevice::mayOpen() const {
  return std::all_of(interfaces.begin(), interfaces.end(), [](const HidInfo& i) { return i.may_open; });
}

std::vector<FoundDevice> groupDevices(const std::vector<HidInfo>& interfaces) {
  std::vector<FoundDevice> out;
  for (const HidInfo& info : interfaces) {
    const DeviceDriver* const driver = driverOf(info);
    if (!driver) continue;
    const auto same = std::find_if(out.begin(), out.end(), [&](const FoundDevice& d) {
      const HidInfo& first = d.interfaces.front();
      return d.driver == driver && !d.isArm() && first.parent == info.parent && first.product == info.product;
    });
    if (same != out.end())
      same->interfaces.push_back(info);
    else
      out.push_back({driver, driver->nameOf(info), {info}});
  }
  for (FoundDevice& d : out)
    std::stable_sort(d.interfaces.begin(), d.interfaces.end(),
                     [](const HidInfo& a, const HidInfo& b) { return a.interface < b.interface; });
  return out;
}

Expected<FoundDevice> chooseDevice(const std::vector<FoundDevice>& devices, const std::string& name) {
  std::vector<FoundDevice> meant;
  for (const FoundDevice& d : devices)
    if (name.empty() || isMeant(d, name)) meant.push_back(d);
  if (meant.size() == 1) return meant.front();

  const std::string what = name.empty() ? "" : " called \"" + name + "\"";
  if (meant.empty())
    return fail(
        {.code = Error::Code::kNotFound,
         .place = "devices",
         .found = "none" + what + (devices.empty() ? "" : ", but " + listOf(devices)),
         .expected = "a supported device",
         .hint =
             "plug it in, and list it with kerf devices; other arms need a bridge: docs/reference/device-bridge.md"});
  return fail({.code = Error::Code::kBadValue,
               .place = "devices",
               .found = fmt::format("{}{}: {}", meant.size(), what, listOf(meant)),
               .expected = "one",
               .hint = "name it by its path or, if each has its own, by its serial number"});
}

}  // namespace kerf
