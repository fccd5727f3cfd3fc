// A die from a click on a tooth: its planes lie in the saw plan, where the user sees and adjusts them; then one cut.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/round_hole.h"
#include "ui/app/saw/die_plan.h"
#include "ui/app/view/live_surface.h"

namespace kerf {

class Workbench;

/// Window thread only.
class DieMaking {
 public:
  explicit DieMaking(Workbench& bench) : bench_(bench) {}

  const DieChoice& choice() const { return choice_; }
  /// A number of the choice: taper, base, kerf, pin, pin-depth, or sides (2 or 4). Taper, base and sides plan the
  /// planes anew, and drop adjustments to them.   Errors: kBadValue; those of planDie().
  Expected<void> set(const std::string& name, double value);
  static std::string names();  ///< of set(), for errors

  /// Plans a die at the hit of a ray: its planes replace those of the previous die; the first is chosen.
  /// Errors: kEmpty without a hit; kUnsupported at a moved piece; those of planDie().   @cost 0.2 s.
  Expected<void> plan(const Ray& ray);
  /// A die is planned, and two of its planes at least are in the saw plan.
  bool isPlanned() const { return planes().size() >= 2; }
  /// Its planes as they are in the saw plan now; a deleted or renamed plane leaves the die.
  std::vector<SawPlane> planes() const;
  /// The pin hole for the planes as they are now. None: without a pin. Cached by the version of the plan.
  const Expected<std::optional<RoundHole>>& pin() const;

  /// Cuts the die out at once, with its hole; one undo step. The planes stay.
  /// Errors: kEmpty without a plan; that of pin(); those of Sawing::cutAtOnce().
  Expected<void> cut();
  void clear();

 private:
  struct Place {
    Vec3d at;
    std::uint32_t piece = 0;
    Vec3d occlusal;
  };
  Expected<void> planHere();

  Workbench& bench_;
  DieChoice choice_;
  std::optional<Place> place_;
  std::vector<std::string> names_;
  struct Pin {
    std::uint64_t version = ~std::uint64_t{0};
    DieChoice choice;
    Expected<std::optional<RoundHole>> hole = std::optional<RoundHole>{};
  };
  mutable Pin pin_;
};

}  // namespace kerf
