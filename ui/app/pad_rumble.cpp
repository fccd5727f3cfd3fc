#include "ui/app/pad_rumble.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

namespace kerf {
namespace {

constexpr double kFine = 0.25;             // of the fast motor, at full speed in the air
constexpr double kHeavy = 3;               // N of contact that shake the slow motor fully
constexpr double kStanding = 0.05;         // of the free speed: slower it is felt no more
constexpr std::chrono::seconds kRumblePause{1};  // after a pad was lost, until it is tried again

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

PadRumble::PadRumble() : PadRumble([](const PadId& pad) { return RumblePad::open(pad.vendor, pad.product); }) {}

// Another pad, or none. One that is being opened is let go when it is.
void PadRumble::change(const std::optional<PadId>& pad) {
  of_ = pad;
  pad_.reset();
  has_tried_ = false;
  is_stale_ = opening_.valid();
  not_before_ = {};
  trouble_.clear();
}

void PadRumble::begin() {
  has_tried_ = true;
  trouble_.clear();
  try {
    opening_ = std::async(std::launch::async, open_, *of_);
  } catch (const std::system_error& e) {
    trouble_ = e.what();
  }
}

// Not every pad is known to shake: that is no news.
void PadRumble::takeOpened() {
  Opened opened = opening_.get();
  if (std::exchange(is_stale_, false)) return;
  if (opened)
    pad_ = std::move(*opened);
  else if (opened.error().code != Error::Code::kUnsupported)
    trouble_ = opened.error().message();
}

std::optional<std::string> PadRumble::update(const std::optional<PadId>& pad, const Rumble& wanted) {
  if (pad != of_) change(pad);
  if (opening_.valid() && opening_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) takeOpened();

  if (pad_ && !pad_->isConnected()) {
    pad_.reset();
    has_tried_ = false;
    not_before_ = Clock::now() + kRumblePause;
  }
  const bool may_open = of_ && !pad_ && !has_tried_ && !opening_.valid();
  if (may_open && wanted != Rumble{} && Clock::now() >= not_before_) begin();
  if (pad_) pad_->set(wanted);
  if (pad_ && !pad_->isGuarded()) trouble_ = "the process that guards it is gone; plug it out and in";

  const bool is_news = trouble_ != std::exchange(told_, trouble_) && !trouble_.empty();
  if (!is_news) return {};
  return "The gamepad does not shake: " + trouble_;
}

}  // namespace kerf
