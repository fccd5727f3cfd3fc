#include "ui/app/pad_rumble.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace kerf {
namespace {

constexpr double kFine = 0.25;      // of the fast motor, at full speed in the air
constexpr double kHeavy = 3;        // N of contact that shake the slow motor fully
constexpr double kStanding = 0.05;  // of the free speed: slower it is felt no more

// Two bytes, the lower one first.
std::optional<std::uint16_t> wordOf(std::string_view digits) {
  unsigned low = 0, high = 0;
  const auto read = [](std::string_view two, unsigned& out) {
    const auto [end, error] = std::from_chars(two.data(), two.data() + 2, out, 16);
    return error == std::errc() && end == two.data() + 2;
  };
  if (!read(digits.substr(0, 2), low) || !read(digits.substr(2, 2), high)) return {};
  return static_cast<std::uint16_t>(low | (high << 8));
}

}  // namespace

std::optional<PadId> padIdOf(const std::string& guid) {
  constexpr std::size_t kLength = 32, kVendor = 8, kProduct = 16;
  if (guid.size() != kLength) return {};
  const auto vendor = wordOf(std::string_view(guid).substr(kVendor, 4));
  const auto product = wordOf(std::string_view(guid).substr(kProduct, 4));
  if (!vendor || !product || *vendor == 0) return {};
  return PadId{*vendor, *product};
}

Rumble rumbleOf(const HapticReport& report, double drive_share) {
  const double speed = std::min(std::abs(drive_share), 1.0);
  if (report.is_latched || !(speed > kStanding)) return {};
  const double contact = std::clamp(report.output.normal_load / kHeavy, 0.0, 1.0);
  return {contact * speed, std::min(1.0, kFine * speed + 0.5 * contact)};
}

std::optional<std::string> PadRumble::update(const std::optional<PadId>& pad, const Rumble& wanted) {
  if (pad_ && (!pad_->isConnected() || pad != of_)) pad_.reset();
  if (pad != of_) {
    of_.reset();
    has_told_ = false;
  }
  if (!pad) return {};
  if (!pad_ && !of_ && wanted != Rumble{}) {
    of_ = pad;
    auto opened = RumblePad::open(pad->vendor, pad->product);
    if (opened)
      pad_ = std::move(*opened);
    else if (opened.error().code == Error::Code::kUnreadable && !std::exchange(has_told_, true))
      return "The gamepad does not shake: " + opened.error().message();
  }
  if (pad_) pad_->set(wanted);
  return {};
}

}  // namespace kerf
