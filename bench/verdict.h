// Goals for the numbers of `kerf-bench`, and the verdict on a run.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/error.h"

namespace kerf::cli {

/// One number that a scene measured.
struct Measured {
  std::string name;  ///< the key in JSON: "50k nodes, p99"
  double value = 0;
  std::string unit;  ///< empty: a count or a ratio
};

/// Comparison of a number with its limit. NaN meets no goal.
enum class Sense { kAtMost, kAtLeast, kExactly };

/// "at most", "at least", "exactly"; with `_` for the blank, the key in JSON.
std::string_view wordsOf(Sense sense);

/// A missed goal fails the command. An aim is a goal known to be missed: it is shown, and fails nothing.
enum class Weight { kGoal, kAim };

/// One goal: a row of a scene's table.
struct Goal {
  std::string_view name;  ///< of the number; each {} matches any text: "force at {} mm"
  std::string_view unit;  ///< of the number; a different unit is a different number
  Sense sense = Sense::kAtMost;
  double limit = 0;
  Weight weight = Weight::kGoal;

  bool isAbout(const Measured& number) const;
  bool isMetBy(double value) const;
  /// "at most 0.05"
  std::string requirement() const;
  /// "met", "MISSED" or "MISSED, an aim"
  std::string_view verdictOn(double value) const;
};

/// The verdict on a run of one scene.
struct Verdict {
  std::vector<const Goal*> goal_of;       ///< for each number; null: it has no goal
  std::vector<const Goal*> not_measured;  ///< goals without a number
  std::vector<std::string> missed;        ///< a sentence for each missed goal, and for each row not measured

  bool isMet() const { return missed.empty(); }
};

/// Compares each number with its first matching goal. A goal without a number is missed, so a scene cannot silently
/// stop measuring. `goals` must outlive the verdict.
Verdict judge(std::span<const Goal> goals, std::span<const Measured> numbers);

/// Replaces limits by the user's own.
/// @param limits  each "NAME=NUMBER", NAME as in the table or as measured.
/// @return an error with the list of names, if no goal has that name.
Expected<void> changeLimits(std::vector<Goal>& goals, std::span<const std::string> limits);

}  // namespace kerf::cli
