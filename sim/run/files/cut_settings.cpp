#include "sim/run/files/cut_settings.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

namespace kerf {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 3> kHands = {"feed", "force", "device"};

// Reads the output of toJson(); the first other value ends it.
class Reader {
 public:
  explicit Reader(const json& j) : j_(j) {}

  double number(const char* key, double most) {
    const auto it = j_.find(key);
    if (it != j_.end() && it->is_number()) {
      const double value = it->get<double>();
      if (value >= 0 && value <= most) return value;
    }
    is_fine_ = false;
    return 0;
  }

  std::string text(const char* key) {
    const auto it = j_.find(key);
    if (it != j_.end() && it->is_string()) return it->get<std::string>();
    is_fine_ = false;
    return {};
  }

  bool flag(const char* key) {
    const auto it = j_.find(key);
    if (it != j_.end() && it->is_boolean()) return it->get<bool>();
    is_fine_ = false;
    return false;
  }

  bool isFine() const { return is_fine_; }

 private:
  const json& j_;
  bool is_fine_ = true;
};

json toJson(const DeviceHand::Options& d) {
  return {{"mass_kg", d.mass_kg},
          {"damping_N_s_per_mm", d.damping},
          {"friction_N", d.friction},
          {"encoder_mm", d.encoder_mm},
          {"delay_ms", d.delay_ticks},
          {"hand_stiffness_N_per_mm", d.hand_stiffness},
          {"hand_damping_N_s_per_mm", d.hand_damping}};
}

}  // namespace

std::string_view nameOf(HandKind hand) { return kHands[static_cast<std::size_t>(hand)]; }

json toJson(const CutSettings& s) {
  json j{{"hand", s.hand},
         {"response", s.response},
         {"drive", s.drive},
         {"spindle_of_nominal", s.spindle},
         {"is_reversed", s.is_reversed},
         {"irrigation", s.irrigation}};
  if (s.push) {
    j["push_N"] = *s.push;
    j["feed_limit_mm_per_s"] = *s.feed_limit;
    j["patience_s"] = *s.patience;
  }
  if (s.device) j["device"] = toJson(*s.device);
  if (!s.added.empty()) j["added_material"] = s.added;
  return j;
}

std::optional<CutSettings> settingsFromJson(const json& j) {
  constexpr double kMost = 1e6;
  if (!j.is_object()) return {};
  Reader r(j);
  CutSettings out;
  out.hand = r.text("hand");
  out.response = r.text("response");
  out.drive = r.text("drive");
  out.spindle = r.number("spindle_of_nominal", 1);
  out.is_reversed = r.flag("is_reversed");
  out.irrigation = r.number("irrigation", 1);
  if (j.contains("push_N")) {
    out.push = r.number("push_N", kMost);
    out.feed_limit = r.number("feed_limit_mm_per_s", kMost);
    out.patience = r.number("patience_s", kMost);
  }
  if (j.contains("added_material")) out.added = r.text("added_material");
  if (!r.isFine()) return {};

  if (const auto it = j.find("device"); it != j.end()) {
    if (!it->is_object()) return {};
    Reader of_device(*it);
    out.device = DeviceHand::Options{.mass_kg = of_device.number("mass_kg", kMost),
                                     .damping = of_device.number("damping_N_s_per_mm", kMost),
                                     .friction = of_device.number("friction_N", kMost),
                                     .encoder_mm = of_device.number("encoder_mm", kMost),
                                     .delay_ticks = static_cast<int>(of_device.number("delay_ms", kMost)),
                                     .hand_stiffness = of_device.number("hand_stiffness_N_per_mm", kMost),
                                     .hand_damping = of_device.number("hand_damping_N_s_per_mm", kMost)};
    if (!of_device.isFine()) return {};
  }
  return out;
}

std::string describe(const CutSettings& s) {
  std::string out = fmt::format("a {} hand", s.hand);
  if (s.push) out += fmt::format(", {:g} N, at most {:g} mm/s", *s.push, *s.feed_limit);
  if (s.device)
    out += fmt::format(", device of {:g} kg, {:g} N friction, {:g} ms delay", s.device->mass_kg, s.device->friction,
                       static_cast<double>(s.device->delay_ticks));
  out += "; " + s.drive;
  if (s.spindle < 1) out += fmt::format(", at {:.0f} % of it", 100 * s.spindle);
  if (s.is_reversed) out += ", reversed";
  out += s.irrigation >= 1  ? "; full irrigation"
         : s.irrigation > 0 ? fmt::format("; {:.0f} % irrigation", 100 * s.irrigation)
                            : "; dry";
  out += "; response " + s.response;
  if (!s.added.empty()) out += "; added " + s.added;
  return out;
}

}  // namespace kerf
