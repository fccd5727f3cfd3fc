// JSON of Haply's service: states it sends, and commands it takes. Units are m and N; right-handed, Z up.
#pragma once

#include <string>
#include <string_view>

#include "bridges/kerf_link.h"

namespace bridge {

/// State from the service. Later states are partial: missing values stay.
struct HaplyState {
  std::string id;  ///< of the first arm; empty: there is none
  Hand hand{.most_force = 8};
};
enum class HaplyNews {
  kPlace,      ///< has the place of the arm
  kOther,      ///< without a place
  kMalformed,  ///< no JSON, or numbers out of range: `state` keeps its value
};
/// Never throws; text of any length, nested at most 32 deep.
HaplyNews parseHaplyState(std::string_view text, HaplyState& state);
/// {"inverse3":[{"device_id":"...","commands":{"set_cursor_force":{"values":{"x":...
std::string haplyForce(const std::string& id, const Vec3& newtons);

}  // namespace bridge
