// A histogram of durations in a fixed amount of memory, for threads that must not allocate.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace kerf {

/// Bins of 1/32 of an octave from 32 ns to 17 s: a percentile is read to 3 %, the largest exactly. @rt safe.
class TimeHistogram {
 public:
  void add(std::int64_t ns) noexcept {
    const auto value = static_cast<std::uint64_t>(std::max<std::int64_t>(ns, 0));
    ++bins_[binOf(value)];
    ++count_;
    max_ = std::max(max_, value);
  }
  std::uint64_t count() const noexcept { return count_; }
  double maxMs() const noexcept { return 1e-6 * static_cast<double>(max_); }
  /// The value that a share `p` (0 to 1) of all does not exceed, ms: the upper end of its bin, or the largest if that
  /// is less. 0 without values.
  double percentileMs(double p) const noexcept {
    const auto wanted = static_cast<std::uint64_t>(p * static_cast<double>(count_));
    std::uint64_t seen = 0;
    for (std::size_t bin = 0; bin + 1 < bins_.size(); ++bin) {  // the last one has no end
      seen += bins_[bin];
      if (seen > wanted) return 1e-6 * static_cast<double>(std::min(endOf(bin), max_));
    }
    return maxMs();
  }

 private:
  static constexpr unsigned kSubBits = 5, kSub = 1u << kSubBits, kOctaves = 29;
  static std::size_t binOf(std::uint64_t value) noexcept {
    if (value < kSub) return 0;
    const auto octave = static_cast<unsigned>(std::bit_width(value)) - 1 - kSubBits;  // value >> octave is in [32, 64)
    if (octave >= kOctaves) return 1 + kOctaves * kSub;
    return 1 + octave * kSub + static_cast<std::size_t>((value >> octave) - kSub);
  }
  static std::uint64_t endOf(std::size_t bin) noexcept {
    if (bin == 0) return kSub;
    return (std::uint64_t{kSub} + (bin - 1) % kSub + 1) << ((bin - 1) / kSub);
  }
  std::array<std::uint32_t, kOctaves * kSub + 2> bins_{};
  std::uint64_t count_ = 0, max_ = 0;
};

}  // namespace kerf
