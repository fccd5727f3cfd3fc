#include "ui/sound/sound_thread.h"

#include <array>
#include <chrono>
#include <system_error>
#include <utility>

namespace kerf {
namespace {

using Clock = std::chrono::steady_clock;

// Keeps the thread at the pace of the clock if the device does not block.
class Pace {
 public:
  void add(std::size_t samples) {
    const auto now = Clock::now();
    end_ += std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(static_cast<double>(samples) / SoundOutput::kRate));
    if (end_ < now) end_ = now;  // does not catch up after a delay
    if (end_ - now > kMostAhead) std::this_thread::sleep_for(end_ - now - kMostAhead);
  }

 private:
  static constexpr std::chrono::duration<double> kMostAhead{SoundThread::kMostAheadSeconds};
  Clock::time_point end_ = Clock::now();  // end of the rendered sound, played from its beginning
};

}  // namespace

SoundThread::SoundThread(OpenSound open) {
  try {
    thread_ = std::thread([this, open = std::move(open)] {
      const auto played = run(open);
      if (!played) error_ = played.error();
      has_ended_.store(true, std::memory_order_release);
    });
  } catch (const std::system_error& e) {
    error_ = Error{.code = Error::Code::kUnsupported, .place = "sound", .found = e.what(), .expected = "a thread"};
    has_ended_.store(true, std::memory_order_release);
  }
}

SoundThread::~SoundThread() {
  is_stopping_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

void SoundThread::play(const DrillSoundInput& now) noexcept {
  newest_.back() = now;
  newest_.publish();
}

std::optional<Error> SoundThread::takeError() {
  if (!has_ended_.load(std::memory_order_acquire)) return {};
  return std::exchange(error_, std::nullopt);
}

Expected<void> SoundThread::run(const OpenSound& open) {
  KERF_TRY(output, open());
  DrillSound sound(SoundOutput::kRate);
  std::array<float, kBlock> block;
  constexpr auto kStaleBlocks = static_cast<std::size_t>(kStaleSeconds * SoundOutput::kRate / kBlock);
  // A second of silence is played, then none: the device starts again with the next sound.
  constexpr std::size_t kSilentBlocks = static_cast<std::size_t>(SoundOutput::kRate) / kBlock;
  constexpr std::chrono::milliseconds kRest{20};

  Pace pace;
  std::size_t blocks_since = 0, silent_blocks = 0;
  while (!is_stopping_.load(std::memory_order_acquire)) {
    blocks_since = newest_.update() ? 0 : blocks_since + 1;
    DrillSoundInput now = newest_.front();
    if (blocks_since > kStaleBlocks) now.is_running = false;
    silent_blocks = sound.isSilent() && !now.is_running ? silent_blocks + 1 : 0;
    if (silent_blocks > kSilentBlocks) {
      std::this_thread::sleep_for(kRest);
      continue;
    }
    sound.render(now, block);
    KERF_CHECK(output->write(block));
    pace.add(block.size());
  }
  return {};
}

}  // namespace kerf
