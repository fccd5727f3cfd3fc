#include "ui/cli/device_words.h"

#include <fmt/format.h>

#include <numbers>

namespace kerf::cli {
namespace {

std::string buttonsOf(std::uint64_t buttons) {
  std::string out;
  for (int n = 0; n < 64; ++n)
    if (buttons >> n & 1) out += fmt::format(" b{}", n + 1);
  return out;
}

nlohmann::json listOfWords(const Vec3d& v) { return {v[0], v[1], v[2]}; }

}  // namespace

std::string idOf(const HidInfo& info) { return fmt::format("{:04x}:{:04x}", info.vendor, info.product); }

nlohmann::json jsonOf(const FoundDevice& found) {
  nlohmann::json paths = nlohmann::json::array();
  for (const HidInfo& info : found.interfaces) paths.push_back(info.path);
  nlohmann::json out = {{"name", found.name},         {"id", idOf(found.interfaces.front())},
                        {"path", found.path()},       {"interfaces", paths},
                        {"serial", found.serial()},   {"driver", found.driver->id},
                        {"may_open", found.mayOpen()}};
  if (!found.mayOpen()) out["problem"] = kMayNotOpen;
  return out;
}

// ---- Devices with axes

nlohmann::json jsonOf(const DeviceReading& r, const std::array<double, 6>& axes) {
  nlohmann::json out = {{"axes", axes},
                        {"buttons", r.buttons},
                        {"reports", r.reports},
                        {"unknown", r.unknown},
                        {"malformed", r.malformed}};
  if (r.battery_percent >= 0) out["battery_percent"] = r.battery_percent;
  return out;
}

std::string textOf(const DeviceReading& r, const std::array<double, 6>& axes) {
  std::string out = fmt::format("right {:+.2f} away {:+.2f} up {:+.2f}, turned {:+.2f} {:+.2f} {:+.2f}", axes[0],
                                axes[1], axes[2], axes[3], axes[4], axes[5]);
  out += buttonsOf(r.buttons);
  if (r.battery_percent >= 0) out += fmt::format(", battery {} %{}", r.battery_percent, r.is_charging ? "+" : "");
  if (r.unknown + r.malformed > 0) out += fmt::format(", {} unknown, {} malformed", r.unknown, r.malformed);
  return out;
}

// ---- Arms

Vec3d HandSpeed::at(std::int64_t time_us, const HandFrame& hand) {
  constexpr std::int64_t kWindow = 50'000;  // us
  const Place now{time_us, hand.pose.translation};
  if (next_.time_us < 0) from_ = next_ = now;
  if (time_us - next_.time_us >= kWindow) {
    from_ = next_;
    next_ = now;
  }
  if (!hand.velocity.isZero(0) || time_us == from_.time_us) return hand.velocity;
  return (now.position - from_.position) / (1e-6 * static_cast<double>(time_us - from_.time_us));
}

std::string textOf(const HandFrame& hand, const Vec3d& velocity) {
  const Vec3d& p = hand.pose.translation;
  std::string out = fmt::format("at {:+.2f} {:+.2f} {:+.2f} mm, {:+.1f} {:+.1f} {:+.1f} mm/s", p[0], p[1], p[2],
                                velocity[0], velocity[1], velocity[2]);
  if (hand.senses_orientation) {
    const Eigen::AngleAxisd turn(hand.pose.rotation);
    out += fmt::format(", turned {:.1f} deg about {:+.2f} {:+.2f} {:+.2f}", turn.angle() * 180 / std::numbers::pi,
                       turn.axis()[0], turn.axis()[1], turn.axis()[2]);
  }
  out += buttonsOf(hand.buttons);
  if (!hand.is_ready) out += ", not ready";
  return out;
}

nlohmann::json jsonOf(const HandFrame& hand, const Vec3d& velocity) {
  const Eigen::Vector4d q = hand.pose.rotation.coeffs();
  nlohmann::json out = {{"position_mm", listOfWords(hand.pose.translation)},
                        {"velocity_mm_per_s", listOfWords(velocity)},
                        {"buttons", hand.buttons},
                        {"is_ready", hand.is_ready},
                        {"most_force_N", hand.most_force}};
  if (hand.senses_orientation) out["quaternion_xyzw"] = {q[0], q[1], q[2], q[3]};
  return out;
}

}  // namespace kerf::cli
