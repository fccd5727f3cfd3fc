#include "sim/device/record/replay_arm.h"

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

#include "sim/device/arm/arm_thread.h"
#include "sim/device/hid/device_driver.h"
#include "sim/device/record/device_recording.h"

namespace kerf {

struct ReplayArm::State {
  void play();
  void say(const HandFrame& hand);

  std::string file, device, language;
  std::vector<RecordedHand> hands;  // at least one
  ReplayArm* arm = nullptr;
  std::atomic<bool> has_begun{false}, is_over{false};
  internal::ArmThread thread;
};

void ReplayArm::State::say(const HandFrame& hand) {
  const std::int64_t now = deviceClock();
  {
    const std::lock_guard lock(thread.mutex);
    ++thread.counts.hands;
    thread.counts.newest_came_ns = now;
  }
  arm->publish({hand, now});
}

void ReplayArm::State::play() {
  constexpr auto kRest = std::chrono::milliseconds(2);
  while (!thread.isStopping() && !has_begun.load(std::memory_order_acquire)) {
    say(hands.front().hand);
    std::this_thread::sleep_for(kRest);
  }

  const std::int64_t began = deviceClock(), first = hands.front().time_us;
  for (const RecordedHand& next : hands) {
    const std::int64_t due = began + 1000 * (next.time_us - first);
    while (!thread.isStopping()) {
      const std::int64_t left = due - deviceClock();
      if (left <= 0) break;
      std::this_thread::sleep_for(std::min<std::chrono::nanoseconds>(std::chrono::nanoseconds(left), kRest));
    }
    if (thread.isStopping()) return;
    say(next.hand);
  }
  is_over.store(true, std::memory_order_release);
}

ReplayArm::ReplayArm(const ArmSettings& settings, const Rigid3& start, std::unique_ptr<State> state)
    : ForceArm(settings, start), state_(std::move(state)) {
  state_->arm = this;
}
ReplayArm::~ReplayArm() { state_->thread.stop(); }

Expected<std::unique_ptr<ReplayArm>> ReplayArm::open(const std::string& file, const ArmSettings& settings,
                                                     const Rigid3& start) {
  KERF_TRY(recording, readRecording(file));
  const auto refuse = [&](Error::Code code, std::string found) {
    return fail({.code = code,
                 .file = file,
                 .place = "recording",
                 .found = std::move(found),
                 .expected = "hands of a force-feedback arm",
                 .hint = "print the recording with kerf devices --replay"});
  };
  if (recording.arm.empty())
    return refuse(Error::Code::kUnsupported, "one of " + recording.device + ", not a force-feedback arm");

  auto state = std::make_unique<State>();
  state->file = file;
  state->device = recording.device;
  state->language = recording.arm;
  state->hands = replayHands(recording).hands;
  if (state->hands.empty()) return refuse(Error::Code::kBadValue, "no hand");

  std::unique_ptr<ReplayArm> arm(new ReplayArm(settings, start, std::move(state)));
  State& s = *arm->state_;
  KERF_CHECK(s.thread.start([&s] { s.play(); }, file, ""));
  return arm;
}

const std::string& ReplayArm::language() const { return state_->language; }
std::string ReplayArm::what() const { return "recording " + state_->file + " of " + state_->device; }
bool ReplayArm::isOver() const { return state_->is_over.load(std::memory_order_acquire); }

ArmCounts ReplayArm::counts() const {
  ArmCounts out = state_->thread.told();
  if (isOver()) out.trouble = "the recording is over: open it again";
  return out;
}

void ReplayArm::arm() noexcept {
  state_->has_begun.store(true, std::memory_order_release);
  ForceArm::arm();
}

}  // namespace kerf
