// Settings of a cut against resistance. Its forces and volumes are meaningless without them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "sim/hand/virtual_hand.h"

namespace kerf {

/// The virtual hand: see sim/hand/virtual_hand.h.
enum class HandKind {
  kFeed,   ///< follows the path in its time at any force
  kForce,  ///< pushes the tool along the path with constant force
  kDevice  ///< a simulated force-feedback device with a hand that follows the path
};

/// The name of a virtual hand in command lines and files: "feed", "force", "device".
std::string_view nameOf(HandKind hand);

/// Settings of a cut along a path, from its options.
struct CutSettings {
  std::string hand;      ///< nameOf()
  std::string response;  ///< name of a ResponseRow
  std::string drive;     ///< describeDrive() of the tool in its handpiece
  double spindle = 1;    ///< fraction of the nominal speed
  bool is_reversed = false;
  double irrigation = 1;                      ///< fraction of the full spray
  std::optional<double> push;                 ///< N; hand "force" only, as the next two
  std::optional<double> feed_limit;           ///< mm/s
  std::optional<double> patience;             ///< s
  std::optional<DeviceHand::Options> device;  ///< hand "device" only
  std::string added;                          ///< id of the added material; empty: the tool cut
};

/// The value of "settings" in summary.json.
nlohmann::json toJson(const CutSettings& settings);
/// Nothing if `j` is not an output of toJson(), or has numbers out of range.
std::optional<CutSettings> settingsFromJson(const nlohmann::json& j);

/// "a force hand, 1.5 N, at most 20 mm/s; turbine, 380000 rpm ...; full spray; response penalty".
std::string describe(const CutSettings& settings);

}  // namespace kerf
