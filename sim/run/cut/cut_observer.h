// Observers of every tick of a cut against resistance: the interface, and the list of all observers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "geometry/base/error.h"
#include "sim/object/cut_object.h"
#include "sim/run/cut/haptic_cut.h"
#include "sim/run/files/haptic_summary.h"
#include "sim/run/scene/cut_scene.h"
#include "sim/session/session.h"
#include "sim/step/step.h"

namespace kerf::internal {

/// One finished tick.
struct CutTick {
  const DeviceSample& sample;
  const StepOutput& output;
  std::span<const CutObject> objects;     ///< the case to be cut, then its neighbours
  std::uint64_t ticks = 0;                ///< so far, including this one
  double removed_mm3 = 0, added_mm3 = 0;  ///< of the case so far
};

/// Receives every tick, in lockstep. Its results go into the summary, or into a file of its own in the run.
class CutObserver {
 public:
  virtual ~CutObserver() = default;
  virtual void tick(const CutTick& tick) = 0;
  /// After the last tick: closes the file. Error kWriteFailed.
  virtual Expected<void> close() { return {}; }
  /// After the last tick: its part of the summary.
  virtual void addTo(HapticSummary& /*summary*/, std::span<const CutObject> /*objects*/) const {}
};

/// All observers of a cut, in their calling order.
class CutObservers {
 public:
  /// @param staging  where the files go.   @param run_folder  their final folder, named in errors.
  /// @cost seconds: measures distances to pulp, nerve canal and neighbours beforehand.
  static Expected<CutObservers> make(const CutScene& scene, const HapticCutOptions& options,
                                     const std::filesystem::path& staging, const std::filesystem::path& run_folder);

  /// The session writes to the log itself; the log also holds commands, strokes and checks.
  SessionSink& log() { return *log_; }
  void tick(const CutTick& tick) {
    for (const auto& observer : all_) observer->tick(tick);
  }
  /// Closes the files in any case. Returns the first error.
  Expected<void> close();
  void addTo(HapticSummary& summary, std::span<const CutObject> objects) const {
    for (const auto& observer : all_) observer->addTo(summary, objects);
  }

 private:
  template <class Observer, class... Arguments>
  Observer& add(Arguments&&... arguments) {
    auto made = std::make_unique<Observer>(std::forward<Arguments>(arguments)...);
    Observer& observer = *made;
    all_.push_back(std::move(made));
    return observer;
  }
  std::vector<std::unique_ptr<CutObserver>> all_;
  SessionSink* log_ = nullptr;
};

}  // namespace kerf::internal
