#include "sim/step/node_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/step/node_kernels.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 8>;
using I = hn::RebindToSigned<F>;
using V = hn::Vec<F>;

// Reads base and along first: the compiler cannot know that the results do not overwrite them.
void placeHere(const float base[3], const float along[3][3], float* x, float* y, float* z) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  float* out[3] = {x, y, z};
  for (int c = 0; c < 3; ++c) {
    const float first = base[c], by_slab = along[0][c], by_row = along[1][c];
    const V in_row = hn::Set(f, along[2][c]);
    float* at = out[c];
    for (int row = 0; row < 64; ++row, at += 8) {
      const float start = first + static_cast<float>(row >> 3) * by_slab + static_cast<float>(row & 7) * by_row;
      for (int k = 0; k < 8; k += lanes)
        hn::StoreU(hn::Add(hn::Set(f, start), hn::Mul(hn::Iota(f, static_cast<float>(k)), in_row)), f, at + k);
    }
  }
}

void placeShellHere(const float base[3], const float along[3][3], const std::uint16_t* offsets, int count, float* x,
                    float* y, float* z) {
  const F f;
  const I i;
  const hn::Rebind<std::uint16_t, F> u16;
  const int lanes = static_cast<int>(hn::Lanes(f));
  float* out[3] = {x, y, z};
  const V b0[3] = {hn::Set(f, base[0]), hn::Set(f, base[1]), hn::Set(f, base[2])};
  const V a0[3] = {hn::Set(f, along[0][0]), hn::Set(f, along[0][1]), hn::Set(f, along[0][2])};
  const V a1[3] = {hn::Set(f, along[1][0]), hn::Set(f, along[1][1]), hn::Set(f, along[1][2])};
  const V a2[3] = {hn::Set(f, along[2][0]), hn::Set(f, along[2][1]), hn::Set(f, along[2][2])};
  const auto seven = hn::Set(i, 7);
  for (int n = 0; n < count; n += lanes) {
    const auto at = hn::PromoteTo(i, hn::LoadU(u16, offsets + n));
    const V a = hn::ConvertTo(f, hn::ShiftRight<6>(at)), b = hn::ConvertTo(f, hn::And(hn::ShiftRight<3>(at), seven)),
            c = hn::ConvertTo(f, hn::And(at, seven));
    for (int axis = 0; axis < 3; ++axis)
      hn::StoreU(hn::Add(hn::Add(hn::Add(b0[axis], hn::Mul(a, a0[axis])), hn::Mul(b, a1[axis])), hn::Mul(c, a2[axis])),
                 f, out[axis] + n);
  }
}

// values[numbers[n]]
template <class Number>
HWY_INLINE void gather(const float* values, const Number* numbers, int count, float* out) {
  const F f;
  const I i;
  const hn::Rebind<Number, F> as_stored;
  for (int n = 0; n < count; n += static_cast<int>(hn::Lanes(f)))
    hn::StoreU(hn::GatherIndex(f, values, hn::PromoteTo(i, hn::LoadU(as_stored, numbers + n))), f, out + n);
}

void valuesHere(const float* values, const std::uint16_t* offsets, int count, float* out) {
  gather(values, offsets, count, out);
}

void valuesOfHere(const float* values, const std::uint8_t* numbers, int count, float* out) {
  gather(values, numbers, count, out);
}

float largestHere(const float* values, int n) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  V largest = hn::LoadU(f, values);
  for (int at = lanes; at < n; at += lanes) largest = hn::Max(largest, hn::LoadU(f, values + at));
  return hn::GetLane(hn::MaxOfLanes(f, largest));
}

std::uint64_t rowsBelowHere(const float* values, float limit) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  const V bound = hn::Set(f, limit);
  std::uint64_t rows = 0;
  for (int row = 0; row < 64; ++row) {
    V least = hn::LoadU(f, values + 8 * row);
    for (int at = lanes; at < 8; at += lanes) least = hn::Min(least, hn::LoadU(f, values + 8 * row + at));
    rows |= std::uint64_t{!hn::AllFalse(f, hn::Lt(least, bound))} << row;
  }
  return rows;
}

std::uint64_t touchingHere(const float* cut, const float* body, const float* phi, int count, float least_overlap,
                           float& least_gap) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  const V far = hn::Set(f, 1e30f), touches = hn::Set(f, -least_overlap);
  V least = hn::Set(f, least_gap);
  std::uint64_t bits = 0;
  const auto test = [&](int at, V gap) {
    least = hn::Min(least, gap);
    const auto touching = hn::Lt(gap, touches);
    if (hn::AllFalse(f, touching)) return;  // usual case
    std::uint8_t part[8] = {};
    hn::StoreMaskBits(f, touching, part);
    bits |= std::uint64_t{part[0]} << at;
  };
  const auto gapAt = [&](int at) {
    V nearest = hn::LoadU(f, cut + at);
    if (body) nearest = hn::Min(nearest, hn::LoadU(f, body + at));
    return hn::Add(nearest, hn::LoadU(f, phi + at));
  };
  int at = 0;
  for (; at + lanes <= count; at += lanes) test(at, gapAt(at));
  if (at < count) test(at, hn::IfThenElse(hn::FirstN(f, static_cast<std::size_t>(count - at)), gapAt(at), far));
  least_gap = hn::GetLane(hn::MinOfLanes(f, least));
  return bits;
}

}  // namespace kerf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::internal {

HWY_EXPORT(placeHere);
HWY_EXPORT(placeShellHere);
HWY_EXPORT(valuesHere);
HWY_EXPORT(valuesOfHere);
HWY_EXPORT(largestHere);
HWY_EXPORT(rowsBelowHere);
HWY_EXPORT(touchingHere);

void placeNodes(const float base[3], const float along[3][3], float* x, float* y, float* z) noexcept {
  HWY_DYNAMIC_DISPATCH(placeHere)(base, along, x, y, z);
}

void placeShell(const float base[3], const float along[3][3], const std::uint16_t* offsets, int count, float* x,
                float* y, float* z) noexcept {
  HWY_DYNAMIC_DISPATCH(placeShellHere)(base, along, offsets, count, x, y, z);
}

void valuesAt(const float* values, const std::uint16_t* offsets, int count, float* out) noexcept {
  HWY_DYNAMIC_DISPATCH(valuesHere)(values, offsets, count, out);
}

void valuesOf(const float* values, const std::uint8_t* numbers, int count, float* out) noexcept {
  HWY_DYNAMIC_DISPATCH(valuesOfHere)(values, numbers, count, out);
}

float largestOf(const float* values, int n) noexcept { return HWY_DYNAMIC_DISPATCH(largestHere)(values, n); }

std::uint64_t rowsBelow(const float* values, float limit) noexcept {
  return HWY_DYNAMIC_DISPATCH(rowsBelowHere)(values, limit);
}

std::uint64_t touchingNodes(const float* cut, const float* body, const float* phi, int count, float least_overlap,
                            float& least_gap) noexcept {
  return HWY_DYNAMIC_DISPATCH(touchingHere)(cut, body, phi, count, least_overlap, least_gap);
}

}  // namespace kerf::internal
#endif
