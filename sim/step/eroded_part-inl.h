// The eroded part of an overlap, 1 - exp(-x), x a rate times time: plain arithmetic, so that it gives the same bits
// with any C library and any instructions. Included once per instruction set.
#if defined(KERF_SIM_STEP_ERODED_PART_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef KERF_SIM_STEP_ERODED_PART_INL_H_
#undef KERF_SIM_STEP_ERODED_PART_INL_H_
#else
#define KERF_SIM_STEP_ERODED_PART_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 8>;
using I = hn::RebindToSigned<F>;
using V = hn::Vec<F>;

// 1 - exp(-x), x >= 0, without cancellation where x is small; relative error below 3e-7, 1 beyond x = 87.
HWY_INLINE V erodedPart(F f, V x) {
  const I i;
  const V one = hn::Set(f, 1.0f);
  V small = one;
  for (const float part : {1.0f / 5, 1.0f / 4, 1.0f / 3, 1.0f / 2})
    small = hn::Sub(one, hn::Mul(hn::Mul(x, hn::Set(f, part)), small));
  small = hn::Mul(x, small);
  const V bounded = hn::Min(x, hn::Set(f, 87.0f));
  const auto n = hn::ConvertTo(i, hn::Add(hn::Mul(bounded, hn::Set(f, 1.44269504f)), hn::Set(f, 0.5f)));
  const V turns = hn::ConvertTo(f, n);
  const V r =
      hn::Sub(hn::Sub(bounded, hn::Mul(turns, hn::Set(f, 0.693145752f))), hn::Mul(turns, hn::Set(f, 1.42860677e-6f)));
  V sum = one;
  for (const float part : {1.0f / 6, 1.0f / 5, 1.0f / 4, 1.0f / 3, 1.0f / 2, 1.0f})
    sum = hn::Sub(one, hn::Mul(hn::Mul(r, hn::Set(f, part)), sum));
  const V power = hn::BitCast(f, hn::ShiftLeft<23>(hn::Sub(hn::Set(i, 127), n)));
  const V decayed = hn::IfThenElse(hn::Lt(x, hn::Set(f, 87.0f)), hn::Mul(sum, power), hn::Zero(f));
  return hn::IfThenElse(hn::Lt(x, hn::Set(f, 0.125f)), small, hn::Sub(one, decayed));
}

// r^0.75 by two roots.
HWY_INLINE V lipLever(V r) { return hn::Mul(hn::Sqrt(r), hn::Sqrt(hn::Sqrt(r))); }

// The part of an overlap that lips can remove: rubbing keeps rub / x of it. x a rate times time.
HWY_INLINE V overRubbing(F f, V overlap, V rub, V x) {
  const V kept = hn::Div(rub, hn::Max(x, hn::Set(f, 1e-9f)));
  return hn::Max(hn::Sub(overlap, kept), hn::Zero(f));
}

}  // namespace kerf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
