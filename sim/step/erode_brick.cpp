#include "sim/step/erode_brick.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/step/erode_brick.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h
#include <hwy/highway.h>

#include "sim/step/eroded_part-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kerf::internal::HWY_NAMESPACE {

ErodeBrickResult erodeHere(const ErodeBrickInput& in, float* out) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  const V far = hn::Set(f, 1e30f), cap = hn::Set(f, in.cap), touches = hn::Set(f, -in.least_overlap);
  V gaps = far, least = far;
  for (int n = 0; n < kBrickNodes; n += lanes) {
    const V phi = hn::LoadU(f, in.phi + n), tau = hn::LoadU(f, in.tau + n);
    const V gap = hn::IfThenElse(hn::Lt(phi, cap), hn::Add(phi, tau), far);
    gaps = hn::Min(gaps, gap);

    const auto overlaps = hn::Lt(gap, touches);
    if (hn::AllFalse(f, overlaps)) {  // nothing to cut
      least = hn::Min(least, phi);
      hn::StoreU(phi, f, out + n);
      continue;
    }

    V next;
    if (in.geometry_only) {
      next = hn::IfThenElse(overlaps, hn::Neg(tau), phi);  // exact, so that a second pass changes nothing
    } else {
      V lever = hn::Set(f, 1.0f);
      if (in.lever.form == LeverForm::kRadius) {
        const V x = hn::LoadU(f, in.x + n), y = hn::LoadU(f, in.y + n);
        lever = hn::Max(hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y))), hn::Set(f, in.lever.least_radius));
      } else if (in.lever.form == LeverForm::kPivot) {
        const V x = hn::LoadU(f, in.x + n), up = hn::Sub(hn::LoadU(f, in.z + n), hn::Set(f, in.lever.pivot));
        lever = hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(up, up)));
      }
      const V rate = in.rates ? hn::LoadU(f, in.rates + n) : hn::Set(f, in.rate);
      const V overlap = hn::IfThenElseZero(overlaps, hn::Neg(gap));
      next = hn::Add(phi, hn::Mul(overlap, erodedPart(f, hn::Mul(rate, lever))));

      if (in.lips.height > 0) {
        const V lip_rate = in.lip_rates ? hn::LoadU(f, in.lip_rates + n) : hn::Set(f, in.lip_rate);
        const V over_time = hn::Mul(lip_rate, lipLever(lever));
        const V over = overRubbing(f, overlap, hn::Set(f, in.lips.rub), over_time);
        const V fed = hn::Min(hn::Mul(over, erodedPart(f, over_time)), hn::Set(f, in.lips.most));
        const auto is_lip = hn::Lt(hn::LoadU(f, in.z + n), hn::Set(f, in.lips.height));
        next = hn::IfThenElse(is_lip, hn::Add(phi, fed), next);
      }
    }

    next = hn::Min(next, hn::Max(phi, cap));
    least = hn::Min(least, next);
    hn::StoreU(next, f, out + n);
  }
  return {hn::GetLane(hn::MinOfLanes(f, gaps)), hn::GetLane(hn::MinOfLanes(f, least))};
}

}  // namespace kerf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::internal {

HWY_EXPORT(erodeHere);

ErodeBrickResult erodeBrick(const ErodeBrickInput& in, float* out) noexcept {
  return HWY_DYNAMIC_DISPATCH(erodeHere)(in, out);
}

}  // namespace kerf::internal
#endif
