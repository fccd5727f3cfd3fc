// A recording as a force-feedback arm: "replay:FILE" instead of the name of a device. Its hand repeats the recorded one
// bit for bit; no force goes anywhere.
//
// Its time begins when the haptic thread first uses the arm. Until then its first hand stands still.
#pragma once

#include <memory>
#include <string>

#include "sim/device/arm/force_arm.h"

namespace kerf {

class ReplayArm final : public ForceArm {
 public:
  /// Errors: those of readRecording(); kUnsupported: not a recording of an arm; kBadValue: no hand in it, or no thread.
  static Expected<std::unique_ptr<ReplayArm>> open(const std::string& file, const ArmSettings& settings,
                                                   const Rigid3& start = {});
  ~ReplayArm() override;

  /// Language of its messages: findTakeHand().
  const std::string& language() const;

  std::string what() const override;
  ArmCounts counts() const override;
  bool isOver() const override;
  void arm() noexcept override;

 private:
  struct State;
  ReplayArm(const ArmSettings& settings, const Rigid3& start, std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kerf
