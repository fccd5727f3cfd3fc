// Haply Inverse3 through its service on this machine: JSON over a WebSocket, 127.0.0.1 port 10001. Never tried with the
// service or the device: by its public documents, against a simulator of ours.
//
//   service ──state──▶ ┌────────┐ ──newest hand──▶ ForceArm        one state for each command:
//   service ◀─force─── │ thread │ ◀─newest force── ForceArm        who sends nothing hears nothing
//
// A service that does not answer within 20 ms is told that there is no force, and so asked again; counts().trouble says
// since when it is silent, and what to do.
//
// A command counts once and is forgotten: a Kerf that is killed leaves no force behind. What is done with a hand and a
// force: force_arm.h. In the service's frames units are m and N; right-handed, Z up.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "geometry/base/error.h"
#include "sim/device/force_arm.h"
#include "sim/hand/device_profile.h"

namespace kerf {

/// As its maker describes such arms; not measured.
inline constexpr DeviceProfile kHaplyProfile{.delay_s = 0.002, .mass_kg = 0.15, .friction = 0.1, .encoder_mm = 0.05};
inline constexpr std::uint16_t kHaplyPort = 10001;

/// What the service says. What a state leaves out stays as it was: later ones are partial.
struct HaplyState {
  std::string id;  ///< of the first arm; empty: there is none
  HandFrame hand;
  bool has_place = false;  ///< its place has been told
};
enum class HaplyNews {
  kPlace,      ///< the place of the arm
  kOther,      ///< nothing about its place
  kMalformed,  ///< no JSON, or numbers that cannot be: nothing of it is used
};
/// Never throws; text of any length, nested at most 32 deep.
HaplyNews parseHaplyState(std::string_view text, HaplyState& state);
/// The hand of a state whose place is known, with what its service does not tell; but for number and time.
HandFrame handOf(const HaplyState& state);
/// "{"inverse3":[{"device_id":"...","commands":{"set_cursor_force":{"values":{"x":..."
std::string haplyForce(const std::string& id, const Vec3d& newtons);

class HaplyArm final : public ForceArm {
 public:
  /// @param port  text of a port of 127.0.0.1; empty: kHaplyPort. The service may start later.
  /// Errors: kBadValue: no port, or no thread.
  static Expected<std::unique_ptr<HaplyArm>> open(const std::string& port, const ArmSettings& settings,
                                                  const Rigid3& start = {}, ArmListener listener = {});
  /// Sends zero and ends the connection.
  ~HaplyArm() override;

  std::string what() const override;
  ArmCounts counts() const override;

 private:
  struct State;
  HaplyArm(const ArmSettings& settings, const Rigid3& start, std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
