#include "geometry/field/field_lookup.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "geometry/field/field_lookup.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 8>;
using I = hn::RebindToSigned<F>;
using V = hn::Vec<F>;

// How far x is outside of low..high; negative inside.
HWY_INLINE V outOf(F f, V x, float low, float high) {
  return hn::Max(hn::Sub(hn::Set(f, low), x), hn::Sub(x, hn::Set(f, high)));
}
HWY_INLINE V beyond(F f, V x, float low, float high) { return hn::Max(outOf(f, x, low, high), hn::Zero(f)); }

// Cell of a coordinate and where in it: clamped to the table.
struct Place {
  hn::Vec<I> cell;
  V part;
};
HWY_INLINE Place place(F f, V x, float origin, float inverse, int size) {
  const I i;
  const V at = hn::Min(hn::Max(hn::Mul(hn::Sub(x, hn::Set(f, origin)), hn::Set(f, inverse)), hn::Zero(f)),
                       hn::Set(f, static_cast<float>(size - 2)));
  const auto cell = hn::ConvertTo(i, at);
  return {cell, hn::Sub(at, hn::ConvertTo(f, cell))};
}

HWY_INLINE V between(V a, V b, V part) { return hn::Add(a, hn::Mul(part, hn::Sub(b, a))); }

HWY_INLINE V planar(F f, const FieldTable& t, V u, V v) {
  const I i;
  const Place a = place(f, u, t.origin[0], t.inverse, t.size[0]), b = place(f, v, t.origin[1], t.inverse, t.size[1]);
  const auto at = hn::Add(hn::Mul(a.cell, hn::Set(i, t.size[1])), b.cell);
  const auto next = hn::Add(at, hn::Set(i, t.size[1])), one = hn::Set(i, 1);
  const V near = between(hn::GatherIndex(f, t.values, at), hn::GatherIndex(f, t.values, hn::Add(at, one)), b.part);
  const V far = between(hn::GatherIndex(f, t.values, next), hn::GatherIndex(f, t.values, hn::Add(next, one)), b.part);

  const V du = beyond(f, u, t.low[0], t.high[0]), dv = beyond(f, v, t.low[1], t.high[1]);
  const V outside = hn::Sqrt(hn::Add(hn::Mul(du, du), hn::Mul(dv, dv)));
  return hn::IfThenElse(hn::Lt(hn::Max(du, dv), hn::Set(f, t.reach)), between(near, far, a.part), outside);
}

HWY_INLINE V spatial(F f, const FieldTable& t, V x, V y, V z) {
  const I i;
  const Place a = place(f, x, t.origin[0], t.inverse, t.size[0]), b = place(f, y, t.origin[1], t.inverse, t.size[1]),
              c = place(f, z, t.origin[2], t.inverse, t.size[2]);
  const auto row = hn::Set(i, t.size[2]), slab = hn::Set(i, t.size[1] * t.size[2]), one = hn::Set(i, 1);

  const auto at = hn::Add(hn::Add(hn::Mul(a.cell, slab), hn::Mul(b.cell, row)), c.cell);
  const auto along = [&](hn::Vec<I> from) {
    return between(hn::GatherIndex(f, t.values, from), hn::GatherIndex(f, t.values, hn::Add(from, one)), c.part);
  };
  const V near = between(along(at), along(hn::Add(at, row)), b.part);
  const V far = between(along(hn::Add(at, slab)), along(hn::Add(hn::Add(at, slab), row)), b.part);

  const V dx = beyond(f, x, t.low[0], t.high[0]), dy = beyond(f, y, t.low[1], t.high[1]),
          dz = beyond(f, z, t.low[2], t.high[2]);
  const V outside = hn::Sqrt(hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz)));
  return hn::IfThenElse(hn::Lt(hn::Max(hn::Max(dx, dy), dz), hn::Set(f, t.reach)), between(near, far, a.part), outside);
}

HWY_INLINE V fromBox(F f, const FieldTable& t, V x, V y, V z) {
  const V dx = outOf(f, x, t.low[0], t.high[0]), dy = outOf(f, y, t.low[1], t.high[1]),
          dz = outOf(f, z, t.low[2], t.high[2]);
  const V zero = hn::Zero(f);
  // Inside, and before a side, a root is unnecessary: it would give the same bits.
  const V higher = hn::Max(dx, dy), largest = hn::Max(higher, dz);
  const V second = hn::Max(hn::Min(dx, dy), hn::Min(higher, dz));
  if (hn::AllTrue(f, hn::Le(second, zero))) return largest;

  const V ox = hn::Max(dx, zero), oy = hn::Max(dy, zero), oz = hn::Max(dz, zero);
  const V outside = hn::Sqrt(hn::Add(hn::Add(hn::Mul(ox, ox), hn::Mul(oy, oy)), hn::Mul(oz, oz)));
  return hn::Add(outside, hn::Min(largest, zero));
}

// One loop per form, over a local copy of the table: constants stay in registers while the loop writes results.
template <TableForm kForm>
HWY_INLINE void lookUpAll(const FieldTable& table, const float* HWY_RESTRICT x, const float* HWY_RESTRICT y,
                          const float* HWY_RESTRICT z, float* HWY_RESTRICT out, int n) {
  const F f;
  const FieldTable t = table;
  const int lanes = static_cast<int>(hn::Lanes(f));
  for (int at = 0; at < n; at += lanes) {
    const V px = hn::LoadU(f, x + at), py = hn::LoadU(f, y + at), pz = hn::LoadU(f, z + at);
    V d;
    if constexpr (kForm == TableForm::kRevolved) {
      d = planar(f, t, hn::Sqrt(hn::Add(hn::Mul(px, px), hn::Mul(py, py))), pz);
    } else if constexpr (kForm == TableForm::kPlate) {
      const V flat = planar(f, t, px, pz), off = hn::Sub(hn::Abs(py), hn::Set(f, t.half));
      const V a = hn::Max(flat, hn::Zero(f)), b = hn::Max(off, hn::Zero(f));
      d = hn::Add(hn::Sqrt(hn::Add(hn::Mul(a, a), hn::Mul(b, b))), hn::Min(hn::Zero(f), hn::Max(flat, off)));
    } else if constexpr (kForm == TableForm::kBox) {
      d = fromBox(f, t, px, py, pz);
    } else {
      d = spatial(f, t, px, py, pz);
    }
    hn::StoreU(d, f, out + at);
  }
}

void lookUpHere(const FieldTable& t, const float* x, const float* y, const float* z, float* out, int n) {
  switch (t.form) {
    case TableForm::kRevolved:
      return lookUpAll<TableForm::kRevolved>(t, x, y, z, out, n);
    case TableForm::kPlate:
      return lookUpAll<TableForm::kPlate>(t, x, y, z, out, n);
    case TableForm::kBox:
      return lookUpAll<TableForm::kBox>(t, x, y, z, out, n);
    case TableForm::kSpatial:
      return lookUpAll<TableForm::kSpatial>(t, x, y, z, out, n);
  }
}

}  // namespace kerf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::internal {

HWY_EXPORT(lookUpHere);

void lookUp(const FieldTable& table, const float* x, const float* y, const float* z, float* out, int n) noexcept {
  HWY_DYNAMIC_DISPATCH(lookUpHere)(table, x, y, z, out, n);
}

}  // namespace kerf::internal
#endif
