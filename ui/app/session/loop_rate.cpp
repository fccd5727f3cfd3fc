#include "ui/app/session/loop_rate.h"

namespace kerf {
namespace {

constexpr auto kMeasuresApart = std::chrono::milliseconds(20);
constexpr auto kWindow = std::chrono::seconds(1);

}  // namespace

void LoopRate::add(std::uint64_t ticks, Clock::time_point now) {
  if (count_ > 0 && ticks < last_.ticks) clear();
  last_ = {ticks, now};
  const std::size_t newest = (next_ + kMost - 1) % kMost;
  if (count_ > 0 && now < ring_[newest].when + kMeasuresApart) return;
  ring_[next_] = last_;
  next_ = (next_ + 1) % kMost;
  if (count_ < kMost) ++count_;
}

std::optional<double> LoopRate::hz() const {
  for (std::size_t back = 1; back <= count_; ++back) {
    const Moment& then = ring_[(next_ + kMost - back) % kMost];
    if (last_.when - then.when < kWindow) continue;
    const double seconds = std::chrono::duration<double>(last_.when - then.when).count();
    return static_cast<double>(last_.ticks - then.ticks) / seconds;
  }
  return {};
}

}  // namespace kerf
