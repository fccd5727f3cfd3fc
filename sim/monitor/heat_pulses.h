// Heat in the tissue as pulses: each an amount of energy, its place and its time. The temperature anywhere at depth is
// their sum; no area of contact enters.
//
// A pulse of energy E at the surface of a half-space (Carslaw & Jaeger, Conduction of Heat in Solids), tau later and r
// away:
//   dT = 2 E / (c (4 pi alpha tau)^1.5) exp(-r^2 / (4 alpha tau))
// A steady source of power P is a row of them, and settles as P / (2 pi k r) erfc(r / sqrt(4 alpha t)).
//
// At most kMost are kept. If there is one more, the two whose union changes the temperature least are merged: at first
// those of a tool that stands still, whose older pulses differ little.
//
// mm, s; energy in mJ, temperature in K.
#pragma once

#include <array>

#include "geometry/base/types.h"

namespace kerf {

/// Of one tissue. 1 W/(m K) = 1 mW/(mm K), 1e6 J/(m^3 K) = 1 mJ/(mm^3 K).
struct ThermalProperties {
  double conductivity = 0;   ///< k, mW/(mm K)
  double heat_capacity = 0;  ///< c = rho c_p, mJ/(mm^3 K)
  const char* source = "";
  double effusivity() const noexcept;                                           ///< sqrt(k c), mW s^(1/2) / (mm^2 K)
  double diffusivity() const noexcept { return conductivity / heat_capacity; }  ///< alpha, mm^2/s
};

/// A value; belongs to one thread.
class HeatPulses {
 public:
  static constexpr int kMost = 64;

  /// @param energy  mJ; negative: removed by cold water.   @param time  s, of its middle, not before the last one's.
  /// @param tissue  around it.   @rt safe.  @cost below a microsecond until there are kMost, then about 10.
  void add(double energy, const Vec3d& place, double time, const ThermalProperties& tissue) noexcept;

  /// K above the body at a place, `time` s. @param beside  mm: extra distance off the pulses' plane, so that the
  /// distance is sqrt(r^2 + beside^2).   @pre time after that of every pulse.   @rt safe.  @cost about a microsecond.
  double riseAt(const Vec3d& place, double time, double beside = 0) const noexcept;

  int count() const noexcept { return count_; }
  double energy() const noexcept;  ///< mJ, total: merging does not change it

 private:
  struct Pulse {
    Vec3d place;
    double energy, weight;  // mJ; its absolute value, of all energy merged into it
    double time;            // s
    double diffusivity, capacity;
  };
  void mergeNearestPair(double now) noexcept;

  std::array<Pulse, kMost + 1> pulses_{};
  int count_ = 0;
};

}  // namespace kerf
