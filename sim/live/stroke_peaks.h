// The peaks of a session, kept stroke by stroke: those of strokes that were taken back are told apart.
//
// A tick belongs to the stroke that began last, also after its pedal came up: the tool still leaves its hole then. A
// stroke that changed nothing is no step of undo, and stands.
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
  std::array<Peak, kMostKept> nearest_mm;  ///< the least distance to each structure that is kept
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
  HeatAlarms alarms;              ///< of all strokes: heat is not taken back
};

/// Belongs to the thread that ticks the session.
class StrokePeaks {
 public:
  using Distances = std::array<double, CutPeaks::kMostKept>;

  StrokePeaks() { steps_.reserve(SessionHistory::kMostSteps + UndoList::kMostNewest); }
  /// After the step.   @param list  Session::undoList().   @param tick  State::tick before the step.
  /// @param celsius, distances  not a number where nothing is known. @rt
  void tick(const DeviceSample& sample, const StepOutput& output, const UndoList& list, std::uint64_t tick,
            double celsius, const Distances& distances) noexcept;
  /// After commands that no tick follows. @rt
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

  std::vector<Step> steps_;  // as the list has them, the oldest first; reserved
  std::size_t done_ = 0;     // of them, not taken back
  std::size_t at_ = kNone;   // the step of the stroke that began last; none: it changed nothing yet
  std::uint64_t began_ = 0;  // tick of that stroke
  bool is_pressed_ = false;
  std::uint64_t forgotten_ = 0;
  CutPeaks stroke_;    // that has no step yet
  CutPeaks for_good_;  // strokes without a step, and steps too old to be taken back
  CutPeaks dropped_;   // taken back, and others came in their place
};

}  // namespace kerf
