#include "sim/session/packed_samples.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>

#include "sim/session/session_format.h"

namespace kerf::internal {
namespace {

constexpr std::size_t kOrders = SampleHistory::kDepth;
constexpr unsigned kMostShift = 63;
constexpr std::size_t kHead = 4;  // count, which numbers move

// ---- Bits, the lowest of a byte first

class BitWriter {
 public:
  explicit BitWriter(std::vector<std::byte>& to) : to_(to) {}

  void put(std::uint64_t bits, unsigned count) {
    for (unsigned n = 0; n < count; ++n) {
      if (used_ == 0) to_.push_back({});
      to_.back() |= static_cast<std::byte>((bits >> n & 1) << used_);
      used_ = (used_ + 1) % 8;
    }
  }

 private:
  std::vector<std::byte>& to_;
  unsigned used_ = 0;  // of the last byte
};

class BitReader {
 public:
  explicit BitReader(std::span<const std::byte> from) : from_(from) {}

  std::uint64_t get(unsigned count) {
    std::uint64_t out = 0;
    for (unsigned n = 0; n < count; ++n) out |= std::uint64_t{bit()} << n;
    return out;
  }
  bool bit() {
    const std::size_t byte = at_ / 8;
    is_short_ |= byte >= from_.size();
    if (is_short_) return false;
    return (std::to_integer<unsigned>(from_[byte]) >> at_++ % 8 & 1) != 0;
  }
  bool isShort() const { return is_short_; }
  /// All bits are read, and the padding of the last byte is zero.
  bool isAtEnd() const {
    if (is_short_ || (at_ + 7) / 8 != from_.size()) return false;
    return at_ % 8 == 0 || std::to_integer<unsigned>(from_.back()) >> at_ % 8 == 0;
  }

 private:
  std::span<const std::byte> from_;
  std::size_t at_ = 0;
  bool is_short_ = false;
};

// ---- Extrapolation: the polynomial through the last `order` samples, one tick on

std::uint64_t predicted(const std::array<std::uint64_t, kOrders>& before, std::size_t order) {
  switch (order) {
    case 1:
      return before[0];
    case 2:
      return 2 * before[0] - before[1];
    case 3:
      return 3 * before[0] - 3 * before[1] + before[2];
    default:
      return 4 * before[0] - 6 * before[1] + 4 * before[2] - before[3];
  }
}

// A difference of either sign as a small number: 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
std::uint64_t folded(std::uint64_t difference) {
  const std::uint64_t sign = difference >> 63 ? ~std::uint64_t{0} : 0;
  return difference << 1 ^ sign;
}
std::uint64_t unfolded(std::uint64_t value) { return value >> 1 ^ (~(value & 1) + 1); }

// ---- The code of a number: how many bits it has beyond the lowest `shift`, in unary; those but the first; the lowest

unsigned bitsBeyond(std::uint64_t value, unsigned shift) {
  return static_cast<unsigned>(std::bit_width(value >> shift));
}

void putCode(BitWriter& out, std::uint64_t value, unsigned shift) {
  const unsigned width = bitsBeyond(value, shift);
  for (unsigned n = 0; n < width; ++n) out.put(0, 1);
  out.put(1, 1);
  if (width > 1) out.put(value >> shift, width - 1);
  out.put(value, shift);
}

// Sets `is_bad` for an invalid code.
std::uint64_t getCode(BitReader& in, unsigned shift, bool& is_bad) {
  unsigned width = 0;
  while (!in.isShort() && width + shift <= 64 && !in.bit()) ++width;
  if (in.isShort() || width + shift > 64) {
    is_bad = true;
    return 0;
  }
  std::uint64_t beyond = 0;
  if (width > 0) beyond = std::uint64_t{1} << (width - 1);
  if (width > 1) beyond |= in.get(width - 1);
  return beyond << shift | in.get(shift);
}

struct Way {
  std::size_t order = 1;
  unsigned shift = 0;
  std::uint64_t bits = std::numeric_limits<std::uint64_t>::max();
};

// Finds the shift with the shortest code for numbers of these widths.   @param widths  count of numbers of each width.
void improve(Way& best, std::size_t order, const std::array<unsigned, 65>& widths) {
  for (unsigned shift = 0; shift <= kMostShift; ++shift) {
    std::uint64_t bits = 0;
    for (unsigned w = 0; w < widths.size(); ++w) {
      const unsigned beyond = w > shift ? w - shift : 0;
      bits += std::uint64_t{widths[w]} * (beyond + 1 + (beyond > 1 ? beyond - 1 : 0) + shift);
    }
    if (bits < best.bits) best = {order, shift, bits};
  }
}

std::array<std::uint64_t, kOrders> columnOf(const SampleHistory& history, std::size_t number) {
  std::array<std::uint64_t, kOrders> out;
  for (std::size_t n = 0; n < kOrders; ++n) out[n] = history.before[n][number];
  return out;
}

template <class T, std::size_t N>
void follow(std::array<T, N>& before, const T& value) {
  std::move_backward(before.begin(), before.end() - 1, before.end());
  before[0] = value;
}

// Difference of each sample's number from its extrapolation.
std::vector<std::uint64_t> differences(std::span<const SampleBits> samples, std::size_t number,
                                       const SampleHistory& history, std::size_t order) {
  std::vector<std::uint64_t> out;
  out.reserve(samples.size());
  auto before = columnOf(history, number);
  for (const SampleBits& sample : samples) {
    out.push_back(folded(sample[number] - predicted(before, order)));
    follow(before, sample[number]);
  }
  return out;
}

Way shortestWay(std::span<const SampleBits> samples, std::size_t number, const SampleHistory& history) {
  Way best;
  for (std::size_t order = 1; order <= kOrders; ++order) {
    std::array<unsigned, 65> widths{};
    for (const std::uint64_t d : differences(samples, number, history, order)) ++widths[bitsBeyond(d, 0)];
    improve(best, order, widths);
  }
  return best;
}

}  // namespace

std::vector<std::byte> packSamples(std::span<const SampleBits> samples, SampleHistory& history) {
  assert(!samples.empty() && samples.size() <= kMostPackedSamples);

  // Moving numbers, and their shortest code.
  std::uint32_t moves = 0;
  std::array<Way, kSampleNumbers> ways;
  for (std::size_t number = 0; number < kSampleNumbers; ++number) {
    const std::uint64_t last = history.before[0][number];
    if (std::all_of(samples.begin(), samples.end(), [&](const SampleBits& s) { return s[number] == last; })) continue;
    moves |= 1u << number;
    ways[number] = shortestWay(samples, number, history);
  }

  std::vector<std::byte> out(kHead);
  BytePacker(out.data()).u32(static_cast<std::uint32_t>(samples.size()) | moves << 16);
  for (std::size_t number = 0; number < kSampleNumbers; ++number)
    if (moves >> number & 1) out.push_back(static_cast<std::byte>((ways[number].order - 1) | ways[number].shift << 2));

  BitWriter bits(out);
  for (std::size_t number = 0; number < kSampleNumbers; ++number) {
    if (!(moves >> number & 1)) continue;
    for (const std::uint64_t d : differences(samples, number, history, ways[number].order))
      putCode(bits, d, ways[number].shift);
  }
  for (const SampleBits& sample : samples) follow(history.before, sample);
  return out;
}

bool unpackSamples(std::span<const std::byte> payload, SampleHistory& history, std::vector<SampleBits>& out) {
  if (payload.size() < kHead) return false;
  const std::uint32_t head = ByteUnpacker(payload.data()).u32();
  const std::size_t count = head & 0xffff;
  const std::uint32_t moves = head >> 16;
  if (count == 0 || count > kMostPackedSamples || moves >> kSampleNumbers != 0) return false;

  const std::size_t moving = static_cast<std::size_t>(std::popcount(moves));
  if (payload.size() < kHead + moving) return false;
  const std::span<const std::byte> ways = payload.subspan(kHead, moving);
  BitReader bits(payload.subspan(kHead + moving));

  const std::size_t first = out.size();
  out.resize(first + count, history.before[0]);
  bool is_bad = false;
  std::size_t nth = 0;
  for (std::size_t number = 0; number < kSampleNumbers && !is_bad; ++number) {
    if (!(moves >> number & 1)) continue;
    const unsigned way = std::to_integer<unsigned>(ways[nth++]);
    auto before = columnOf(history, number);
    for (std::size_t n = 0; n < count && !is_bad; ++n) {
      const std::uint64_t value = predicted(before, 1 + (way & 3)) + unfolded(getCode(bits, way >> 2, is_bad));
      out[first + n][number] = value;
      follow(before, value);
    }
  }
  is_bad |= !bits.isAtEnd();
  for (std::size_t n = first; n < out.size() && !is_bad; ++n) is_bad = !isSample(out[n]);
  if (is_bad) {
    out.resize(first);
    return false;
  }
  for (std::size_t n = first; n < out.size(); ++n) follow(history.before, out[n]);
  return true;
}

SampleBits bitsOfSample(const std::byte* packed) {
  ByteUnpacker in(packed);
  SampleBits out;
  for (std::size_t n = 0; n + 1 < kSampleNumbers; ++n) out[n] = in.u64();
  out.back() = in.u32();
  return out;
}

bool isSample(const SampleBits& bits) { return bits.back() <= std::numeric_limits<std::uint32_t>::max(); }

DeviceSample sampleOf(const SampleBits& bits) {
  std::array<std::byte, kSampleBytes> packed;
  BytePacker to(packed.data());
  for (std::size_t n = 0; n + 1 < kSampleNumbers; ++n) to.u64(bits[n]);
  to.u32(static_cast<std::uint32_t>(bits.back()));
  return unpackSample(packed.data());
}

}  // namespace kerf::internal
