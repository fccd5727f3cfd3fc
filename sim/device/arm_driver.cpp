#include "sim/device/arm_driver.h"

#include <algorithm>
#include <iterator>

namespace kerf {

// A driver is a row in its own source, and its name in these two lines.
extern const ArmDriver kWoody, kRawArm;
namespace {
constexpr const ArmDriver* kArms[] = {&kWoody, &kRawArm};
}  // namespace

std::span<const ArmDriver* const> armDrivers() { return kArms; }

const ArmDriver* armDriverOf(const HidInfo& info) {
  const auto* const found = std::find_if(std::begin(kArms), std::end(kArms),
                                         [&](const ArmDriver* driver) { return driver->nameOf(info) != nullptr; });
  return found == std::end(kArms) ? nullptr : *found;
}

}  // namespace kerf
