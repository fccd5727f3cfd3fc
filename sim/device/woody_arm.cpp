// WoodenHaptics and the first Polhem: arms that people build, on HID. Never tried on hardware: reports and dimensions
// are those that the project published (the arm of 2015; others differ in their torque constants and gears).
//
//   from the arm, 14 bytes, no number   six encoders, int16 each; information, int16: bit 0 the button
//   to the arm, 14 bytes                currents of three motors, int16, mA; command, int16 (0: currents, 1: encoders
//   are
//                                       set); what three encoders are set to, int16 each
//
// 1234:0006 sends 14 bytes; the same by a Teensy as raw HID, 16c0:0486, sends them in 64, the rest zero. An encoder of
// more than 5000 counts at the fourth place says that the button of the pen is down. The arm answers what it is sent:
// it is sent something at least each 10 ms. Its firmware switches the motors off after 500 ms without a report: a guard
// does so at once when Kerf is killed. Its encoders count from where it was switched on: it is calibrated first.
#include "sim/device/woody_arm.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "sim/device/arm_driver.h"

namespace kerf {
namespace {

// Of the arm of 2015.
WoodyModel theModel() noexcept { return {}; }

std::int16_t word(std::span<const std::uint8_t> bytes, std::size_t n) {
  return static_cast<std::int16_t>(bytes[2 * n] | (bytes[2 * n + 1] << 8));
}
void putWord(ArmReportBytes& out, std::size_t n, double value) {
  const auto number = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(value)));
  out[1 + 2 * n] = static_cast<std::uint8_t>(number & 255);
  out[2 + 2 * n] = static_cast<std::uint8_t>(number >> 8);
}

constexpr std::uint16_t kTeensyVendor = 0x16c0, kTeensyProduct = 0x0486;
constexpr std::size_t kShort = 14, kLong = 64;
std::size_t lengthFor(const HidInfo& info) { return info.vendor == kTeensyVendor ? kLong : kShort; }

const char* nameOf(const HidInfo& info) {
  if (info.vendor == 0x1234 && info.product == 0x0006) return "WoodenHaptics";
  const bool is_raw = info.usage_page == 0xFFAB && info.usage == 0x0200;
  return info.vendor == kTeensyVendor && info.product == kTeensyProduct && is_raw ? "WoodenHaptics, Teensy" : nullptr;
}

FrameFault take(std::span<const std::uint8_t> report, ArmState& state) noexcept {
  constexpr int kPenButton = 5000, kPenOffset = 10000;
  if (report.size() != kShort && report.size() != kLong) return FrameFault::kLength;
  const WoodyModel model = theModel();
  for (std::size_t n = 0; n < 6; ++n) state.counts[n] = word(report, n);
  const bool is_pen_down = state.counts[3] > kPenButton;
  if (is_pen_down) state.counts[3] -= kPenOffset;
  const WoodyPose pose = woodyPose(model, state.counts);
  state.jacobian = pose.jacobian;

  HandFrame& hand = state.hand;
  hand.pose = {Eigen::Quaterniond::Identity(), pose.position};
  hand.buttons = (is_pen_down || (word(report, 6) & 1)) ? 1 : 0;
  hand.is_ready = true;
  hand.senses_orientation = false;
  hand.most_force = model.most_force;
  hand.most_stiffness = model.most_stiffness;
  return FrameFault::kNone;
}

std::size_t write(const ForceFrame& force, const ArmState& state, const HidInfo& info, ArmReportBytes& out) noexcept {
  out.fill(0);
  if (force.is_enabled && force.force.allFinite()) {
    const Vec3d currents = woodyCurrents(theModel(), state.jacobian, force.force);
    for (int n = 0; n < 3; ++n) putWord(out, static_cast<std::size_t>(n), currents[n]);
  }
  return 1 + lengthFor(info);
}

// The last three encoders would be set by the places of the currents: to zero.
std::size_t calibrate(const HidInfo& info, ArmReportBytes& out) noexcept {
  out.fill(0);
  putWord(out, 3, 1);
  const WoodyModel model = theModel();
  for (std::size_t n = 0; n < 3; ++n) putWord(out, 4 + n, model.home[n]);
  return 1 + lengthFor(info);
}

bool isAtHome(const ArmState& state) noexcept {
  constexpr int kTrembles = 50;  // counts: up to 3 mm at the tip
  const WoodyModel model = theModel();
  for (std::size_t n = 0; n < 3; ++n)
    if (std::abs(state.counts[n] - model.home[n]) > kTrembles) return false;
  return true;
}

}  // namespace

WoodyPose woodyPose(const WoodyModel& m, const std::array<int, 6>& counts) noexcept {
  std::array<double, 3> t{}, per_motor{};
  for (std::size_t n = 0; n < 3; ++n) {
    per_motor[n] = m.direction[n] * m.capstan / m.body[n];
    t[n] = per_motor[n] * 2 * std::numbers::pi * counts[n] / m.counts_per_turn[n];
  }
  const double ca = std::cos(t[0]), sa = std::sin(t[0]);
  const double r = m.lb * std::sin(t[1]) + m.lc * std::sin(t[2]);
  const double rb = m.lb * std::cos(t[1]), rc = m.lc * std::cos(t[2]);

  WoodyPose out;
  out.position = Vec3d(r * ca, r * sa, m.la + m.lb * std::cos(t[1]) - m.lc * std::cos(t[2])) - m.origin;
  out.jacobian.col(0) = per_motor[0] * Vec3d(-r * sa, r * ca, 0);
  out.jacobian.col(1) = per_motor[1] * Vec3d(rb * ca, rb * sa, -m.lb * std::sin(t[1]));
  out.jacobian.col(2) = per_motor[2] * Vec3d(rc * ca, rc * sa, m.lc * std::sin(t[2]));
  return out;
}

Vec3d woodyCurrents(const WoodyModel& m, const Eigen::Matrix3d& jacobian, const Vec3d& force) noexcept {
  Vec3d out = 1000 / m.newton_mm_per_ampere * (jacobian.transpose() * force);
  const double most = out.cwiseAbs().maxCoeff();
  if (most > kWoodyMostCurrent) out *= kWoodyMostCurrent / most;
  return out;
}

extern const ArmDriver kWoody;
const ArmDriver kWoody{"woody",
                       "three axes with force",
                       {.delay_s = 0.002, .mass_kg = 0.15, .friction = 0.1, .encoder_mm = 0.05},
                       true,
                       true,
                       nameOf,
                       take,
                       write,
                       calibrate,
                       isAtHome};

}  // namespace kerf
