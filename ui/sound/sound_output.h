// Sink of samples: a sound card, or a test's recorder.
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "geometry/base/error.h"

namespace kerf {

class SoundOutput {
 public:
  static constexpr double kRate = 48000;  ///< samples per second, one channel

  virtual ~SoundOutput() = default;
  /// Takes samples in [-1, 1]; waits for free space, a second at most. One thread.
  /// Error kUnsupported: the device is gone.
  virtual Expected<void> write(std::span<const float> samples) = 0;
};

using OpenSound = std::function<Expected<std::unique_ptr<SoundOutput>>()>;

}  // namespace kerf
