// Temperature of the tissue under the tool, and of the pulp and nerve behind it: a few numbers advanced once per tick.
//
// Heat enters where the tool cuts: a share beta of the drive's power P (StepOutput::power). The rest leaves with chips
// and tool. It enters through the area A of the cutting surface that is close to tissue (sim/monitor/contact_area.h), a
// disc of the radius a = sqrt(A / pi), under any contact response.
//
//   surface   dT = (beta P + h A dT_c) / (G + h A + c Q)
//             G = A e sqrt(pi / (4 t)) + pi k a
//             k, c, e of the tissue: conductivity, heat capacity rho c_p, effusivity sqrt(k c).
//             First term of G: the semi-infinite solid under constant flux, 2 q sqrt(t / pi) / e; second: the steady
//             value of a disc, q a / k, its other ways counted (both Carslaw & Jaeger, Conduction of Heat in Solids).
//             t, the dwell: the time in contact, or the time the tool takes over its own width, 2 a / wander speed.
//             h A: the film of air or spray, at dT_c against the body. c Q: chips leave as warm as the surface.
//   depth     Only G dT is conducted. It goes in as pulses of 0.1 s, each at its place: sim/monitor/heat_pulses.h. A
//             tool that wanders warms many spots, each a little; the temperature at depth is their sum.
//   boiling   Under full spray the surface is no hotter than 100 C; under less of it, in proportion.
//   afterwards  sqrt(1 + s / t) - sqrt(s / t) of the surface's rise is left s after the tool has gone.
//
// P, Q, A and the wander are means over 0.2 s.
//
// Not modelled: blood flow; layers (heat goes through one tissue, that under the tool when it entered); the rest of a
// tooth that spray cools far from the tool, so that cold water cools a pulp less than it does; the extent of a large
// contact at depth (one point, its middle). For training: the numbers rank ways of working; they predict no patient.
//
// mm, N, s: power in N mm/s = mW. Temperatures are rises above the body's, K; degrees Celsius at the UI's edge only.
#pragma once

#include <array>

#include "geometry/field/material.h"
#include "sim/monitor/heat_pulses.h"
#include "sim/step/device_sample.h"
#include "sim/step/tool_model.h"

namespace kerf {

/// Properties of every material. One without data has those of a similar one and names it in `source`. @rt safe.
const ThermalProperties& thermalProperties(Material material) noexcept;

/// Degrees Celsius of the body, for the UI's edge: shown temperature = kBodyCelsius + rise.
inline constexpr double kBodyCelsius = 37;
/// Bone dies after a minute at 47 C (Eriksson & Albrektsson's limit, quoted by Arch Orthop Trauma Surg 2007, doi
/// 10.1007/s00402-007-0427-3; the minute from memory).
inline constexpr double kBoneLimitRise = 10, kBoneLimitSeconds = 60;
/// A pulp that warms by 5.5 K: 15 % did not recover (Zach & Cohen 1965, quoted by synapse.koreamed.org 1090001).
inline constexpr double kPulpLimitRise = 5.5;

/// Heat source of a tool, by its kind.
///
/// Grains rub. Their share is of the order of Hahn's theory, beta = 1 / (1 + 0.97 k_tool / (e sqrt(r v))), r the grain,
/// v its speed (formula from memory): diamond 0.015-0.019. Taken: 0.03, which gives the 6.8 K in a pulp after a minute
/// dry (Farah 2019).
///
/// Edges shear a chip, and most of the heat leaves with it: the theory of grains does not hold (it gives carbide 0.17,
/// five times too much on teeth). The share that flows back from a chip falls with its speed (Weiner 1955, from
/// memory). Measured side by side, a carbide in a turbine warms a tooth less than a diamond: 13.6, 5.0, 2.7 K
/// against 16.8, 6.8, 4.0 K under little, medium and much spray (IADR 2002, San Diego 18318), 0.74 in the mean; dry
/// 0.33 in composite, 0.30 in amalgam (Mafrici et al. 2024, doi 10.2341/23-033-L). Kerf's carbides spend 1.25 times a
/// diamond's power: 0.03 x 0.74 / 1.25 = 0.018. Slower carbides, in motors: 0.10, between that and steel's 0.15 at 0.1
/// to 1.5 m/s; not measured. All are good to a factor of two.
struct HeatSource {
  double share = 0.03;      ///< beta without spray, 0 to 1. Too large: every touch burns; 0: nothing warms
  double spray_film = 10;   ///< h under full spray, mW/(mm^2 K): 1e4 W/(m^2 K) outside, less where spray hardly gets
  double least_area = 0.3;  ///< mm^2, > 0: least area of contact; a lumped model cannot resolve smaller, hotter spots
  Vec3d flank = Vec3d::Zero();  ///< see ContactArea
};
/// Diamond 0.03, carbide 0.018 (friction grip) and 0.10, steel drill and saw 0.15, piezo 0.20. A drill's film is 2 (in
/// its hole), a blade's 5 (in its kerf). A drill has at least its circle. Burs without an ISO number count as carbide,
/// discs as diamond.
HeatSource heatSource(const Tool& tool);

struct HeatSettings {
  double spray_share = 0.5;  ///< remaining part of the source's share under full spray
  double air_film = 0.02;    ///< h of air, mW/(mm^2 K): gases 5-25 W/(m^2 K), textbook
  /// Spray minus body, K. Water of 23 C is -14; some warms in the hose. 0: body temperature.
  double coolant_rise = -10;
  double boiling_rise = 63;  ///< K: 100 C
};

/// Input of one tick.
struct HeatInput {
  bool is_touching = false;
  double power = 0;                       ///< StepOutput::power, N mm/s; >= 0
  double area = 0;                        ///< ContactArea, mm^2
  double removed = 0;                     ///< StepOutput::removed_mm3 of this tick
  double irrigation = 0;                  ///< DeviceSample::irrigation, 0 to 1; 0 when the spray does not reach tissue
  Material material = Material::kDentin;  ///< under the tool
  Vec3d place = Vec3d::Zero();            ///< where heat enters, mm, frame of the watched object
  Vec3d velocity = Vec3d::Zero();         ///< of that place over the tissue, mm/s
  /// Heat goes into another object: the surface warms, the watched object does not.
  bool is_elsewhere = false;
};

/// Times in s since the start; < 0: not yet. Latched: cooling does not take an alarm back.
struct HeatAlarms {
  double bone_warm = -1;     ///< first time that bone under the tool is at its limit
  double bone_dead = -1;     ///< bone 0.5 mm beside the contact has spent kBoneLimitSeconds at or above it, together
  double pulp = -1;          ///< first time that pulp is at its limit
  double bone_exposure = 0;  ///< s at or above the limit so far, 0.5 mm beside the contact
};

/// Points of one structure with a watched temperature, chosen where the tool came near. A point less than kApart from
/// an existing one is not added. At kMost the coolest point older than kYoung is dropped, since the warmth of a new
/// place is still on its way.
class HeatProbes {
 public:
  static constexpr int kMost = 32;
  static constexpr double kApart = 0.5;  ///< mm
  static constexpr double kYoung = 20;   ///< s: heat takes this long over 2 mm. Without an older point the oldest is
                                         ///< dropped

  /// @rt safe.
  void watch(const Vec3d& place, const HeatPulses& pulses, double time) noexcept;
  /// Updates one of them, in turn: each is at most kMost ticks old. @rt safe.
  void step(const HeatPulses& pulses, double time) noexcept;
  double rise() const noexcept;  ///< K, of the warmest; 0 without points

 private:
  struct Probe {
    Vec3d place;
    double rise, since;  // K; s
  };
  std::array<Probe, kMost> probes_{};
  int count_ = 0, next_ = 0;
};

/// A value; belongs to the thread that steps it.
class Heat {
 public:
  /// Structures that can be watched at depth.
  enum Structure { kPulp, kNerve, kStructures };

  explicit Heat(const HeatSource& source = {}, const HeatSettings& settings = {}) noexcept;
  /// Changes the heating tool; warm tissue stays warm. @rt safe.
  void heatBy(const HeatSource& source) noexcept { source_ = source; }
  /// One tick of dt seconds with constant input. Inputs that are not finite count as 0, out of range as the nearest
  /// in range.  @rt safe.  @cost 1 to 3 microseconds; every tenth of a second 10 more.
  void step(const HeatInput& in, double dt = kTick) noexcept;
  /// Watches the temperature of a structure at this point from now on, mm, frame of HeatInput::place. @rt safe.
  void watch(Structure structure, const Vec3d& point) noexcept;

  double surfaceRise() const noexcept { return surface_; }  ///< of the tissue under the tool, K above body
  /// K above body at a place, mm, at least some 0.3 mm from where heat entered. @rt safe.
  double riseAt(const Vec3d& place) const noexcept;
  /// At this depth below the last contact. @rt safe.
  double riseBelow(double depth) const noexcept;
  /// The highest rise of the watched points, K above body; 0 without points.
  double rise(Structure structure) const noexcept { return probes_[structure].rise(); }
  double time() const noexcept { return time_; }  ///< s
  const HeatAlarms& alarms() const noexcept { return alarms_; }
  const HeatPulses& pulses() const noexcept { return pulses_; }
  /// Resets to body temperature, clears alarms and watched points.
  void reset() noexcept { *this = Heat(source_, settings_); }

  static constexpr double kMean = 0.2;        ///< s: inputs count by their mean over this
  static constexpr double kPulse = 0.1;       ///< s
  static constexpr double kBoneMargin = 0.5;  ///< mm beside the contact

 private:
  void touch(const HeatInput& in, double dt) noexcept;
  void leave(double dt) noexcept;
  void conduct(const HeatInput& in, double flow, double dt) noexcept;
  void closePulse() noexcept;
  void alarm(double dt) noexcept;

  HeatSource source_;
  HeatSettings settings_;
  // Means: mW, mm^2, mm^3/s, mm/s, mW/(mm K), mJ/(mm^3 K).
  double power_ = 0, area_ = 0, removal_ = 0, conductivity_ = 0, capacity_ = 0;
  Vec3d velocity_ = Vec3d::Zero();
  double averaged_ = 0;                                    // s of contact in these means
  double contact_ = 0, dwell_ = 0;                         // s
  double away_ = 0, left_at_ = 0;                          // s since the last contact; K, the surface then
  Vec3d place_ = Vec3d::Zero();                            // of the last contact, mm
  double radius_ = 0;                                      // of the last contact, mm
  double pulse_energy_ = 0, pulse_s_ = 0, pulse_age_ = 0;  // mJ; s in contact; s since it began
  Vec3d pulse_place_ = Vec3d::Zero();
  HeatPulses pulses_;
  std::array<HeatProbes, kStructures> probes_;
  Material material_ = Material::kNone;
  double surface_ = 0, beside_ = 0, time_ = 0;
  unsigned ticks_ = 0;
  HeatAlarms alarms_;
};

}  // namespace kerf
