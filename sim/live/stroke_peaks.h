// The peaks of a session, kept stroke by stroke, so that undone strokes can be separated.
//
// A tick belongs to the stroke that began last, also after its pedal came up: the tool still leaves its hole then. A
// stroke without changes is no step of undo, and stands.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/monitor/heat.h"
#include "sim/session/session.h"

namespace kerf {

struct CutPeaks {
  static constexpr std::size_t kMostKept = 10;  ///< pulp, nerve canals, and eight neighbours
  struct Peak {
    double value = 0;
    double at_s = -1;  ///< < 0: there is none
    bool isKnown() const noexcept { return at_s >= 0; }
  };
  Peak contact_N, celsius;                 ///< the largest force on the tool; the warmest tissue under it
  std::array<Peak, kMostKept> nearest_mm;  ///< least distance to each kept structure
  double contact_sum = 0;                  ///< N, over the ticks in contact
  std::uint64_t ticks_in_contact = 0;

  void add(const CutPeaks& other) noexcept;
  double meanContact() const noexcept {
    return ticks_in_contact > 0 ? contact_sum / static_cast<double>(ticks_in_contact) : 0;
  }
};

/// The peaks of a whole session.
struct SessionPeaks {
  CutPeaks standing, taken_back;
  std::vector<std::string> kept;  ///< ids of CutPeaks::nearest_mm
  HeatAlarms alarms;              ///< of all strokes: undo does not reverse heat
};

/// For the thread that ticks the session.
class StrokePeaks {
 public:
  using Distances = std::array<double, CutPeaks::kMostKept>;

  StrokePeaks() { steps_.reserve(SessionHistory::kMostSteps + UndoList::kMostNewest); }
  /// After the step.   @param list  Session::undoList().   @param tick  State::tick before the step.
  /// @param celsius, distances  NaN where unknown. @rt
  void tick(const DeviceSample& sample, const StepOutput& output, const UndoList& list, std::uint64_t tick,
            double celsius, const Distances& distances) noexcept;
  /// After commands without a following tick. @rt
  void follow(const UndoList& list) noexcept;

  CutPeaks standing() const noexcept;
  CutPeaks takenBack() const noexcept;

 private:
  static constexpr std::size_t kNone = ~std::size_t{0};
  struct Step {
    std::uint64_t number = 0;
    CutPeaks peaks;
  };
  void beginStroke(std::uint64_t tick) noexcept;
  void addStep(const UndoStep& step) noexcept;
  void dropFrom(std::size_t first) noexcept;
  void forgetOldest() noexcept;

  std::vector<Step> steps_;  // in the order of the list, oldest first; reserved
  std::size_t done_ = 0;     // steps that are not undone
  std::size_t at_ = kNone;   // the step of the stroke that began last; none: no changes yet
  std::uint64_t began_ = 0;  // tick of that stroke
  bool is_pressed_ = false;
  std::uint64_t forgotten_ = 0;
  CutPeaks stroke_;    // of a stroke without a step yet
  CutPeaks for_good_;  // strokes without a step, and steps too old to be undone
  CutPeaks dropped_;   // undone, then replaced by others
};

}  // namespace kerf
