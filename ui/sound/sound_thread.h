// Renders and plays the sound of the drive on a thread of its own. Who says what is to be heard never waits for it.
#pragma once

#include <atomic>
#include <optional>
#include <thread>

#include "sim/hand/triple_buffer.h"
#include "ui/sound/drill_sound.h"
#include "ui/sound/sound_output.h"

namespace kerf {

/// Without a device it ends by itself: all is silent, and takeError() says why, once.
class SoundThread {
 public:
  /// So many samples are rendered at a time: 5 ms.
  static constexpr std::size_t kBlock = 256;
  /// What was said last holds so long: who has stopped to say anything is not heard for ever.
  static constexpr double kStaleSeconds = 0.5;
  /// No more is rendered ahead of the clock, for a device that takes all at once as ALSA's "null" does.
  static constexpr double kMostAheadSeconds = 0.1;

  /// @param open  called on the thread.
  explicit SoundThread(OpenSound open);
  /// Waits for the block under way, or for `open`: a second at most with ALSA.
  ~SoundThread();
  SoundThread(const SoundThread&) = delete;
  SoundThread& operator=(const SoundThread&) = delete;

  /// What is to be heard from now on; the newest counts. For one thread. Never waits.
  void play(const DrillSoundInput& now) noexcept;
  /// Why nothing is heard any more; once.
  std::optional<Error> takeError();

 private:
  Expected<void> run(const OpenSound& open);

  TripleBuffer<DrillSoundInput> newest_;
  std::atomic<bool> is_stopping_{false}, has_ended_{false};
  std::optional<Error> error_;  // written before has_ended_
  std::thread thread_;
};

}  // namespace kerf
