// Temperature of the tissue under the tool, and of the pulp behind it: lumped, a few numbers advanced once per tick.
//
// Heat enters where the tool rubs: a share of the drive's power (StepOutput::power) over the area in contact. The rest
// leaves with chips, tool and spray. Four ways out:
//   conduction  into a semi-infinite solid. The step response of its surface is T = 2 q sqrt(t / pi) / e, e = sqrt(k
//               rho c) the effusivity (Carslaw & Jaeger, Conduction of Heat in Solids). Its impulse response is a
//               continuum of exponentials, 1/sqrt(pi t) = 1/pi integral xi^-1/2 exp(-xi t) dxi, of which 23 states, two
//               a decade from 1e-7 to 1e4 per s, are enough: within 0.2 % of the formula from 10 ms to a minute. Faster
//               ones follow at once.
//   sideways    what a disc of the contact's radius a loses beyond the one-dimensional model: a conductance k/a. Right
//               for short and long times (the centre of a disc settles at q a / k), up to 26 % low between.
//   chips       tissue removed at the speed v carries its warmth off: rho c v.
//   spray       a film conductance towards the coolant's temperature.
// The temperature at a depth below the surface (the pulp, KeepOut's distance away) follows the surface's through a
// column of cells, solved implicitly, and falls off below a small contact as it does on the axis of a disc: by
// sqrt(1 + (z/a)^2) - z/a.
//
// Not modelled: that a tool which wanders warms new tissue each time (it counts as one spot, so the temperature reads
// high), blood flow, layers (the column is of the material under the tool), boiling. For training: the numbers rank
// ways of working; they predict no patient.
//
// mm, N, s: power in N mm/s = mW. Temperatures are rises above the body's, K; degrees Celsius at the UI's edge only.
#pragma once

#include <array>

#include "geometry/field/material.h"
#include "sim/step/device_sample.h"

namespace kerf {

/// Of one tissue. 1 W/(m K) = 1 mW/(mm K), 1e6 J/(m^3 K) = 1 mJ/(mm^3 K).
struct ThermalProperties {
  double conductivity = 0;   ///< k, mW/(mm K)
  double heat_capacity = 0;  ///< rho c, mJ/(mm^3 K)
  const char* source = "";
  double effusivity() const noexcept;  ///< sqrt(k rho c), mW s^(1/2) / (mm^2 K)
  double diffusivity() const noexcept { return conductivity / heat_capacity; }  ///< mm^2/s
};
/// Of every material; one without numbers of its own takes those of a similar one, and says so in `source`. @rt safe.
const ThermalProperties& thermalProperties(Material material) noexcept;

/// Degrees Celsius of the body, for the UI's edge: shown temperature = kBodyCelsius + rise.
inline constexpr double kBodyCelsius = 37;
/// Bone dies after a minute at 47 C (Eriksson & Albrektsson's limit, quoted by Arch Orthop Trauma Surg 2007, doi
/// 10.1007/s00402-007-0427-3; the minute from memory).
inline constexpr double kBoneLimitRise = 10, kBoneLimitSeconds = 60;
/// A pulp that warms by 5.5 K: 15 % did not recover (Zach & Cohen 1965, quoted by synapse.koreamed.org 1090001).
inline constexpr double kPulpLimitRise = 5.5;

struct HeatSettings {
  /// Shares of the drive's power that stay in the tissue, dry and in full spray. Chosen: calorimetry of drilling and
  /// grinding spreads from a few per cent to a half. Too large: every touch burns; 0: nothing ever warms.
  double dry_share = 0.3, wet_share = 0.05;
  /// Film conductance of air and of full spray, mW/(mm^2 K). Chosen within textbook ranges, not looked up: gases 5-25,
  /// forced liquids 100-20 000 W/(m^2 K).
  double air_film = 0.02, spray_film = 5;
  /// Spray minus body, K. 0 leaves the tooth at body temperature when nothing is cut; room temperature is -15.
  double coolant_rise = 0;
  bool spreads_sideways = true;  ///< false: strictly one-dimensional, hotter
  double least_area = 0.05;      ///< mm^2: contact counts as at least this; smaller needs a hotter spot than lumps tell
};

/// One tick's worth, from StepOutput.
struct HeatInput {
  double power = 0;                       ///< StepOutput::power, N mm/s; >= 0
  double area = 0;                        ///< StepOutput::area, mm^2; 0: not touching
  double removed = 0;                     ///< StepOutput::removed_mm3 of this tick
  double irrigation = 0;                  ///< DeviceSample::irrigation, 0 to 1; 0 when the spray does not reach tissue
  Material material = Material::kDentin;  ///< under the tool
  /// Tissue left between surface and pulp, mm (KeepOut::Reading::distance); < 0: no pulp near.
  double pulp_depth = -1;
};

/// Times in s since the start; < 0: not yet. Latched: cooling does not take an alarm back.
struct HeatAlarms {
  double bone_warm = -1;     ///< bone first at its limit
  double bone_dead = -1;     ///< bone has spent kBoneLimitSeconds at or above it, taken together
  double pulp = -1;          ///< pulp first at its limit
  double bone_exposure = 0;  ///< s at or above the limit so far
};

/// A value; belongs to the thread that steps it.
class Heat {
 public:
  explicit Heat(const HeatSettings& settings = {}) noexcept;
  /// One tick of dt seconds with constant input. Inputs that are not finite count as 0, out of range as the nearest
  /// in range.  @rt safe.  @cost below 1 microsecond.
  void step(const HeatInput& in, double dt = kTick) noexcept;

  double surfaceRise() const noexcept { return surface_; }  ///< of the tissue under the tool, K above body
  /// At a depth below the surface, mm, K above body. @rt safe.
  double riseAt(double depth) const noexcept;
  double pulpRise() const noexcept { return pulp_; }  ///< at the last pulp_depth; 0 without one
  double time() const noexcept { return time_; }      ///< s
  const HeatAlarms& alarms() const noexcept { return alarms_; }
  /// Back to body temperature, alarms cleared.
  void reset() noexcept { *this = Heat(settings_); }

  static constexpr int kStates = 23, kCells = 48;

 private:
  void setTick(double dt) noexcept;
  void stepColumn(double diffusivity, double dt) noexcept;

  HeatSettings settings_;
  std::array<double, kStates> rate_{}, weight_{}, decay_{}, state_{};  // 1/s; s^-1/2; per tick; K s^1/2
  double instant_ = 0;                                                 // s^1/2: gain of all faster states at once
  double gain_ = 0;                                                    // s^1/2: of a tick's flux
  double dt_ = 0;                                                      // s: that of decay_ and gain_
  std::array<double, kCells> depth_{}, width_{}, cell_{};              // mm, mm, K
  double radius_ = 0;                                                  // of the last contact, mm
  double surface_ = 0, pulp_ = 0, time_ = 0;
  HeatAlarms alarms_;
};

}  // namespace kerf
