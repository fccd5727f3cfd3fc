#include "sim/hand/device_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/step/device_sample.h"

namespace kerf {
namespace {

constexpr double kFilterHz = 150;
constexpr double kLeastFriction = 0.01;     // N
constexpr double kLeastTurnFriction = 0.1;  // N mm
constexpr double kBaseDamping = 0.002;      // N s/mm
constexpr double kBaseTurnDamping = 2;      // N mm s/rad
constexpr double kUnbound = std::numeric_limits<double>::infinity();

// One direction of motion: translation in N, mm, t; turning in N mm, rad, t mm^2.
struct Axis {
  double wanted = 0;  // stiffness
  double mass = 0, friction = 0, step = 0;
  double base_damping = 0;
};

struct AxisCoupling {
  double stiffness = 0, still = 0, running = 0;  // and damping
  CouplingBound bound = CouplingBound::kNone;
};

AxisCoupling coupled(const Axis& axis, double tau) {
  const double by_mass = 0.2 * axis.mass / (tau * tau);
  const double by_encoder = axis.step > 0 ? axis.friction / (std::numbers::sqrt2 * axis.step) : kUnbound;
  AxisCoupling out;
  out.stiffness = std::min({axis.wanted, by_mass, by_encoder});
  if (out.stiffness < axis.wanted) out.bound = by_mass < by_encoder ? CouplingBound::kMass : CouplingBound::kEncoder;

  const double gain = 1 - std::exp(-2 * std::numbers::pi * kFilterHz * kTick);
  const double kick = axis.step > 0 ? 2 * axis.friction * kTick / (gain * axis.step) : kUnbound;
  out.running = out.stiffness * tau + axis.base_damping;
  out.still = std::max(0.7 * out.stiffness * tau, std::min(out.running, kick));
  return out;
}

// Delay in s, mass in kg, friction in N, encoder in mm.
constexpr TypicalDevice kTypicalDevices[] = {
    {"nothing is known", {}},
    {"desk arm of six axes, 55 um, USB", {0.0015, 0.07, 0.26, 0.055}},
    {"parallel arm, 30 um, 1 kHz", {0.001, 0.08, 0.05, 0.03}},
    {"light arm of little friction, 30 um, 2 ms late", {0.002, 0.08, 0.02, 0.03}},
    {"the same by a coarse encoder", {0.002, 0.08, 0.02, 0.055}},
    {"small arm, 4 ms late", {0.004, 0.05, 0.05, 0.03}},
    {"very light arm, 5 ms late", {0.005, 0.03, 0.05, 0.005}},
};

}  // namespace

std::span<const TypicalDevice> typicalDevices() { return kTypicalDevices; }

DeviceCoupling couplingFor(const DeviceProfile& p, const CouplingSettings& wanted) {
  constexpr double kTonnes = 1e-3;  // of a kg
  const double tau = p.delay_s + kTick / 2;
  DeviceCoupling out;
  out.settings = wanted;
  out.settings.filter_hz = kFilterHz;

  const AxisCoupling shift = coupled(
      {wanted.stiffness, kTonnes * p.mass_kg, std::max(p.friction, kLeastFriction), p.encoder_mm, kBaseDamping}, tau);
  out.settings.stiffness = shift.stiffness;
  out.settings.damping = shift.still;
  out.settings.running_damping = shift.running;
  out.bound = shift.bound;
  if (p.inertia_kgmm2 <= 0) return out;

  const AxisCoupling turn = coupled({wanted.turn_stiffness, kTonnes * p.inertia_kgmm2,
                                     std::max(p.turn_friction, kLeastTurnFriction), p.encoder_rad, kBaseTurnDamping},
                                    tau);
  out.settings.turn_stiffness = turn.stiffness;
  out.settings.turn_damping = turn.still;
  out.settings.running_turn_damping = turn.running;
  out.turn_bound = turn.bound;
  return out;
}

std::string describeStiffness(const DeviceCoupling& coupling, const CouplingSettings& wanted) {
  const double stiffness = coupling.settings.stiffness;
  switch (coupling.bound) {
    case CouplingBound::kNone:
      break;
    case CouplingBound::kMass:
      return fmt::format("{:.3g} N/mm, {:.3g} wanted: the device is light for its delay", stiffness, wanted.stiffness);
    case CouplingBound::kEncoder:
      return fmt::format("{:.3g} N/mm, {:.3g} wanted: the steps of its encoder are coarse for its friction", stiffness,
                         wanted.stiffness);
  }
  return fmt::format("{:.3g} N/mm", stiffness);
}

}  // namespace kerf
