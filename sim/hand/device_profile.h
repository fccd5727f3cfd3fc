// Properties of a force-feedback device, and the virtual coupling that it can hold without trembling. Functions of
// their arguments alone: any thread, some microseconds, before a session; not for the 1 kHz thread (text allocates).
#pragma once

#include <span>
#include <string>

#include "sim/step/coupling.h"

namespace kerf {

/// At the tip of the tool. The defaults are for an unknown device.
struct DeviceProfile {
  double delay_s = 0.002;    ///< from a sample taken to its force at the motors
  double mass_kg = 0.08;     ///< moved by a hand
  double friction = 0.02;    ///< N, Coulomb
  double encoder_mm = 0.03;  ///< the step of its position; where it depends on the pose, the largest; 0: perfect
  double inertia_kgmm2 = 0;  ///< about the tip; 0: it gives no torque
  double turn_friction = 0;  ///< N mm, Coulomb
  double encoder_rad = 0;    ///< the step of its angle; 0: perfect
};

struct TypicalDevice {
  const char* name;
  DeviceProfile profile;
};
/// Typical numbers, not measured on any device.
std::span<const TypicalDevice> typicalDevices();

/// Reason for a coupling softer than wanted.
enum class CouplingBound {
  kNone,    ///< none: as stiff as wanted
  kMass,    ///< a delayed spring on a light mass becomes unstable
  kEncoder  ///< friction does not absorb the work of a spring over a step of the encoder
};

struct DeviceCoupling {
  CouplingSettings settings;
  CouplingBound bound = CouplingBound::kNone, turn_bound = CouplingBound::kNone;
};

/// With tau = delay + T / 2, T one tick, the wanted stiffness K0, and f at least 0.01 N:
///   K = min(K0, 0.2 m / tau^2, f / (sqrt(2) q))
///   B = K tau + 2 N s/m                                              while the drive turns
///   B = max(0.7 K tau, min(K tau + 2 N s/m, 2 f T / (a q)))          while it stands still
/// a = 1 - exp(-2 pi 150 Hz T) is the gain of the velocity's low-pass. A delay is a negative damping K tau, so B makes
/// up for it. K tau^2 / m = 0.55 is the limit of a delayed spring and damper on a mass, and 0.2 leaves room for hand
/// and filter. A rounded position needs f >= K q / 2 (Abbott & Okamura 2005). Half of that leaves room for turned axes,
/// and sqrt(2) for a tool that friction holds sideways while tissue holds it up: one friction against the steps of two
/// axes. One step of the encoder kicks the hand by B a q / T. The same for turning, with the wanted turning stiffness,
/// inertia, f at least 0.1 N mm, and 2 N mm s/rad. `kerf-bench devices` measures it.
///
/// A device without friction cannot be passive behind an encoder: its force stays small and bounded.
/// @param profile  delay not negative, mass positive.   @param wanted  source of all values that the profile does not
///   determine.
DeviceCoupling couplingFor(const DeviceProfile& profile, const CouplingSettings& wanted = {});

/// "0.44 N/mm, 1 wanted: the steps of its encoder are coarse for its friction", one sentence for a person.
std::string describeStiffness(const DeviceCoupling& coupling, const CouplingSettings& wanted);

}  // namespace kerf
