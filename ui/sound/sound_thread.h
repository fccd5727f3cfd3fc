// Renders and plays the drive's sound on a separate thread. The caller of play() never waits for it.
#pragma once

#include <atomic>
#include <optional>
#include <thread>

#include "sim/hand/triple_buffer.h"
#include "ui/sound/drill_sound.h"
#include "ui/sound/sound_output.h"

namespace kerf {

/// Without a device it ends by itself: silence, and takeError() gives the reason once.
class SoundThread {
 public:
  /// Samples per block: 5 ms.
  static constexpr std::size_t kBlock = 256;
  /// Lifetime of the last play(): the sound stops when the caller does.
  static constexpr double kStaleSeconds = 0.5;
  /// Limit of rendering ahead of the clock, for a device that takes all at once, such as ALSA's "null".
  static constexpr double kMostAheadSeconds = 0.1;

  /// @param open  called on the thread.
  explicit SoundThread(OpenSound open);
  /// Waits for the current block, or for `open`: a second at most with ALSA.
  ~SoundThread();
  SoundThread(const SoundThread&) = delete;
  SoundThread& operator=(const SoundThread&) = delete;

  /// Sets the sound from now on; the newest call counts. For one thread. Never waits.
  void play(const DrillSoundInput& now) noexcept;
  /// The reason for silence; once.
  std::optional<Error> takeError();

 private:
  Expected<void> run(const OpenSound& open);

  TripleBuffer<DrillSoundInput> newest_;
  std::atomic<bool> is_stopping_{false}, has_ended_{false};
  std::optional<Error> error_;  // written before has_ended_
  std::thread thread_;
};

}  // namespace kerf
