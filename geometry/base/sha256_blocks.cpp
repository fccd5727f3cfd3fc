#include "geometry/base/sha256_blocks.h"

#include <bit>
#include <cstring>

#if defined(__x86_64__)
#include <cpuid.h>
#include <immintrin.h>
#endif

namespace kerf::internal {
namespace {

alignas(16) constexpr std::array<std::uint32_t, 64> kRound = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

constexpr std::size_t kBlockBytes = 64;

std::uint32_t bigEndian(const std::byte* p) {
  std::uint32_t word;
  std::memcpy(&word, p, sizeof word);
  return std::endian::native == std::endian::little ? __builtin_bswap32(word) : word;
}

// The eight words change places by their numbers, not by copies: in round i the word called `a` in the standard is
// number -i modulo 8. The schedule is a ring of 16 words.
void sha256BlockPortable(Sha256State& state, const std::byte* block) {
  std::uint32_t w[16];
  for (std::size_t i = 0; i < 16; ++i) w[i] = bigEndian(block + 4 * i);

  Sha256State s = state;
  const auto round = [&s](std::size_t i, std::uint32_t scheduled) {
    const std::uint32_t a = s[(64 - i) % 8], b = s[(65 - i) % 8], c = s[(66 - i) % 8];
    const std::uint32_t e = s[(68 - i) % 8], f = s[(69 - i) % 8], g = s[(70 - i) % 8];
    std::uint32_t &d = s[(67 - i) % 8], &h = s[(71 - i) % 8];

    const std::uint32_t s1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
    const std::uint32_t s0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
    h += s1 + (g ^ (e & (f ^ g))) + scheduled;
    d += h;
    h += s0 + ((a & b) | (c & (a | b)));
  };

#pragma GCC unroll 16
  for (std::size_t i = 0; i < 16; ++i) round(i, kRound[i] + w[i]);
  for (std::size_t begin = 16; begin < 64; begin += 16)
#pragma GCC unroll 16
    for (std::size_t i = 0; i < 16; ++i) {
      const std::uint32_t before = w[(i + 1) % 16], late = w[(i + 14) % 16];
      const std::uint32_t s0 = std::rotr(before, 7) ^ std::rotr(before, 18) ^ (before >> 3);
      const std::uint32_t s1 = std::rotr(late, 17) ^ std::rotr(late, 19) ^ (late >> 10);
      w[i] += s0 + w[(i + 9) % 16] + s1;
      round(i, kRound[begin + i] + w[i]);
    }

  for (std::size_t i = 0; i < 8; ++i) state[i] += s[i];
}

#if defined(__x86_64__)

bool hasShaInstructions() noexcept {
  unsigned a = 0, b = 0, c = 0, d = 0;
  if (!__get_cpuid(1, &a, &b, &c, &d)) return false;
  constexpr unsigned kSsse3 = 1u << 9, kSse41 = 1u << 19;
  if ((c & kSsse3) == 0 || (c & kSse41) == 0) return false;

  if (!__get_cpuid_count(7, 0, &a, &b, &c, &d)) return false;
  constexpr unsigned kSha = 1u << 29;
  return (b & kSha) != 0;
}

// After Intel, "Intel SHA Extensions", 2013: one instruction does two rounds, on words in the orders ABEF and CDGH.
__attribute__((target("sha,ssse3,sse4.1"))) void sha256BlocksX86(Sha256State& state, const std::byte* blocks,
                                                                 std::size_t count) {
  const auto load = [](const void* p) __attribute__((target("sha,ssse3,sse4.1"))) {
    return _mm_loadu_si128(static_cast<const __m128i*>(p));
  };
  const __m128i big_endian = _mm_set_epi64x(0x0c0d0e0f08090a0b, 0x0405060700010203);

  // From a to h in order, to ABEF and CDGH.
  const __m128i cdab = _mm_shuffle_epi32(load(state.data()), 0xb1);
  const __m128i efgh = _mm_shuffle_epi32(load(state.data() + 4), 0x1b);
  __m128i abef = _mm_alignr_epi8(cdab, efgh, 8);
  __m128i cdgh = _mm_blend_epi16(efgh, cdab, 0xf0);

  for (; count > 0; --count, blocks += kBlockBytes) {
    const __m128i abef_before = abef, cdgh_before = cdgh;

    // Four words of the schedule at a time, the last 16 of them in a ring.
    __m128i w[4];
#pragma GCC unroll 16
    for (std::size_t four = 0; four < 16; ++four) {
      __m128i& now = w[four % 4];
      if (four < 4) {
        now = _mm_shuffle_epi8(load(blocks + 16 * four), big_endian);
      } else {
        const __m128i &next = w[(four + 1) % 4], &ninth = w[(four + 2) % 4], &last = w[(four + 3) % 4];
        const __m128i partial = _mm_add_epi32(_mm_sha256msg1_epu32(now, next), _mm_alignr_epi8(last, ninth, 4));
        now = _mm_sha256msg2_epu32(partial, last);
      }

      const __m128i sum = _mm_add_epi32(now, load(kRound.data() + 4 * four));
      cdgh = _mm_sha256rnds2_epu32(cdgh, abef, sum);
      abef = _mm_sha256rnds2_epu32(abef, cdgh, _mm_shuffle_epi32(sum, 0x0e));
    }

    abef = _mm_add_epi32(abef, abef_before);
    cdgh = _mm_add_epi32(cdgh, cdgh_before);
  }

  const __m128i feba = _mm_shuffle_epi32(abef, 0x1b), dchg = _mm_shuffle_epi32(cdgh, 0xb1);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(state.data()), _mm_blend_epi16(feba, dchg, 0xf0));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(state.data() + 4), _mm_alignr_epi8(dchg, feba, 8));
}

#endif

}  // namespace

void sha256BlocksPortable(Sha256State& state, const std::byte* blocks, std::size_t count) {
  for (; count > 0; --count, blocks += kBlockBytes) sha256BlockPortable(state, blocks);
}

Sha256Blocks sha256BlocksByInstructions() noexcept {
#if defined(__x86_64__)
  static const bool has_them = hasShaInstructions();
  if (has_them) return sha256BlocksX86;
#endif
  return nullptr;
}

Sha256Blocks sha256BlocksHere() noexcept {
  const Sha256Blocks instructions = sha256BlocksByInstructions();
  return instructions ? instructions : sha256BlocksPortable;
}

}  // namespace kerf::internal
