// With what a cut against resistance was made. Its forces and volumes say nothing without it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "sim/hand/virtual_hand.h"

namespace kerf {

/// The virtual hand: see sim/hand/virtual_hand.h.
enum class HandKind {
  kFeed,   ///< follows the path in its time, whatever the force
  kForce,  ///< pushes the tool along the path with constant force
  kDevice  ///< a simulated force-feedback device whose hand follows the path
};

/// The name of a virtual hand in command lines and files: "feed", "force", "device".
std::string_view nameOf(HandKind hand);

/// Of a cut along a path, as its options were when it was made.
struct CutSettings {
  std::string hand;      ///< nameOf()
  std::string response;  ///< name of a ResponseRow
  std::string drive;     ///< describeDrive() of the tool in its handpiece
  double spindle = 1;    ///< of the nominal speed
  bool is_reversed = false;
  double irrigation = 1;                      ///< of the full spray
  std::optional<double> push;                 ///< N, of hand "force" alone, as the next two
  std::optional<double> feed_limit;           ///< mm/s
  std::optional<double> patience;             ///< s
  std::optional<DeviceHand::Options> device;  ///< of hand "device" alone
  std::string added;                          ///< id of the material that was added; empty: it cut
};

/// The value of "settings" in summary.json.
nlohmann::json toJson(const CutSettings& settings);
/// Nothing when it is not what toJson() writes, numbers out of range among it.
std::optional<CutSettings> settingsFromJson(const nlohmann::json& j);

/// "a force hand, 1.5 N, at most 20 mm/s; turbine, 380000 rpm ...; full spray; response penalty".
std::string describe(const CutSettings& settings);

}  // namespace kerf
