#include "bridges/haply_state.h"

#include <nlohmann/json.hpp>

namespace bridge {
namespace {

using Json = nlohmann::json;
constexpr double kFarthest = 10;  // m
constexpr int kDeepest = 32;
constexpr std::size_t kLongestId = 64;

// Null: missing, or another type.
const Json* find(const Json& of, const char* key) {
  if (!of.is_object()) return nullptr;
  const auto at = of.find(key);
  return at == of.end() ? nullptr : &*at;
}

bool number(const Json& of, const char* key, double& out) {
  const Json* const value = find(of, key);
  if (!value || !value->is_number()) return false;
  out = value->get<double>();
  return std::isfinite(out);
}

bool vector(const Json& of, Vec3& out) {
  Vec3 read{};
  if (!number(of, "x", read[0]) || !number(of, "y", read[1]) || !number(of, "z", read[2])) return false;
  for (const double value : read)
    if (std::abs(value) > kFarthest) return false;
  out = read;
  return true;
}

const Json* firstOf(const Json& all, const char* key) {
  const Json* const list = find(all, key);
  return list && list->is_array() && !list->empty() ? &list->front() : nullptr;
}

void takeButtons(const Json& grip, Hand& hand) {
  const Json* const buttons = find(grip, "buttons");
  if (!buttons) return;
  std::uint32_t down = 0;
  constexpr const char* kNames[] = {"a", "b", "c"};
  for (std::uint32_t n = 0; n < 3; ++n)
    if (const Json* const one = find(*buttons, kNames[n]); one && one->is_boolean() && one->get<bool>())
      down |= 1U << n;
  hand.buttons = down;
}

void takeGrip(const Json& grip, Hand& hand) {
  takeButtons(grip, hand);
  const Json* const q = find(grip, "orientation");
  double x = 0, y = 0, z = 0, w = 0;
  if (!q || !number(*q, "x", x) || !number(*q, "y", y) || !number(*q, "z", z) || !number(*q, "w", w)) return;
  const double length = std::sqrt(x * x + y * y + z * z + w * w);
  if (!(std::abs(length - 1) <= 1e-2)) return;
  hand.orientation = {x / length, y / length, z / length, w / length};
  hand.senses_orientation = true;
}

}  // namespace

HaplyNews parseHaplyState(std::string_view text, HaplyState& state) {
  const auto bounded = [](int depth, Json::parse_event_t, Json&) { return depth <= kDeepest; };
  Json all;
  try {
    all = Json::parse(text, bounded, false);
  } catch (const std::exception&) {
    return HaplyNews::kMalformed;
  }
  if (!all.is_object()) return HaplyNews::kMalformed;
  const Json* const arm = firstOf(all, "inverse3");
  if (!arm) return HaplyNews::kOther;

  HaplyState next = state;
  if (const Json* const id = find(*arm, "device_id"); id && id->is_string())
    next.id = id->get<std::string>().substr(0, kLongestId);
  for (const char* const key : {"wireless_verse_grip", "wired_verse_grip", "verse_grip"})
    if (const Json* const grip = firstOf(all, key))
      if (const Json* const now = find(*grip, "state")) takeGrip(*now, next.hand);

  const Json* const now = find(*arm, "state");
  const Json* const place = now ? find(*now, "cursor_position") : nullptr;
  if (!place) {
    state = std::move(next);
    return HaplyNews::kOther;
  }
  if (!vector(*place, next.hand.position)) return HaplyNews::kMalformed;
  state = std::move(next);
  return HaplyNews::kPlace;
}

std::string haplyForce(const std::string& id, const Vec3& newtons) {
  const bool is_finite = std::isfinite(newtons[0]) && std::isfinite(newtons[1]) && std::isfinite(newtons[2]);
  const Vec3 force = is_finite ? newtons : Vec3{};
  const Json out = {
      {"inverse3",
       Json::array({{{"device_id", id},
                     {"commands",
                      {{"set_cursor_force", {{"values", {{"x", force[0]}, {"y", force[1]}, {"z", force[2]}}}}}}}}})}};
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace bridge
