#include "ui/app/session/trace.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr std::uint64_t kTicksPerSecond = 1000;

std::uint64_t slotOf(std::uint64_t tick) { return tick * Trace::kPerSecond / kTicksPerSecond; }

// mm^3/s
double rateBetween(const TraceInput& last, const TraceInput& now) {
  if (now.tick == last.tick || now.jumps != last.jumps) return 0;
  const double seconds = static_cast<double>(now.tick - last.tick) / kTicksPerSecond;
  return std::max(0.0, now.removed_mm3 - last.removed_mm3) / seconds;
}

}  // namespace

void Trace::add(const TraceInput& input) {
  if (!is_begun_ || input.tick < last_.tick) {
    clear();
    is_begun_ = true;
    last_ = input;
    return;
  }
  const std::uint64_t slots = slotOf(input.tick) - slotOf(last_.tick);
  if (slots == 0) return;

  const std::array<double, kChannels.size()> now{input.force,
                                                 input.torque,
                                                 input.load,
                                                 input.spindle,
                                                 input.depth,
                                                 input.penetration,
                                                 rateBetween(last_, input),
                                                 input.temperature};
  for (std::uint64_t n = 0; n < std::min<std::uint64_t>(slots, kCount); ++n) {
    for (std::size_t c = 0; c < values_.size(); ++c) values_[c][next_] = static_cast<float>(now[c]);
    next_ = (next_ + 1) % kCount;
  }
  last_ = input;
}

float Trace::largest(Channel channel) const {
  const auto& all = values(channel);
  return *std::max_element(all.begin(), all.end());
}

double Trace::scaleTop(const About& channel) const {
  const double wanted = std::max(static_cast<double>(largest(channel.channel)), channel.least_top);
  const double ten = std::pow(10, std::floor(std::log10(wanted)));
  for (const double times : {1.0, 2.0, 5.0})
    if (times * ten >= wanted * (1 - 1e-9)) return times * ten;
  return 10 * ten;
}

}  // namespace kerf
