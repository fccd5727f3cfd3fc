#include "sim/step/contact_sums.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/step/contact_sums.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h
#include <hwy/highway.h>

#include "sim/step/eroded_part-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kerf::internal::HWY_NAMESPACE {

// The lever of the tool's own motion at places of its frame.
HWY_INLINE V leverAt(F f, const Lever& lever, V x, V y, V z) {
  switch (lever.form) {
    case LeverForm::kRadius:
      return hn::Max(hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(y, y))), hn::Set(f, lever.least_radius));
    case LeverForm::kPivot: {
      const V up = hn::Sub(z, hn::Set(f, lever.pivot));
      return hn::Sqrt(hn::Add(hn::Mul(x, x), hn::Mul(up, up)));
    }
    case LeverForm::kOne:
      break;
  }
  return hn::Set(f, 1.0f);
}

// The part of a node's area that is on a face of the tool: see CutArea. `slope` belongs to the cutting part's distance,
// from the foot of the normal inwards: 1 behind a face, 0.7 and less behind a right angle's edge.
HWY_INLINE V partOnFace(F f, V slope) {
  constexpr float kEdge = 0.4f, kLeast = 0.5f;
  const V part = hn::Mul(hn::Sub(slope, hn::Set(f, kEdge)), hn::Set(f, 1 / (1 - kEdge)));
  return hn::Min(hn::Max(part, hn::Set(f, kLeast)), hn::Set(f, 1.0f));
}

// Within two voxels of a blade's rim the object's normals lean between edge and flank. This draws the normals of cut
// nodes towards the nearer face, by the cubes of their parts: a choice of one would jump.
HWY_INLINE void drawToFace(F f, const TouchingTool& tool, hn::Mask<F> cuts, V normal[3]) {
  const V one = hn::Set(f, 1.0f), share = hn::Set(f, tool.cut_share);
  const auto dot = [](const V a[3], const V b[3]) {
    return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])), hn::Mul(a[2], b[2]));
  };
  const V axis[3] = {hn::Set(f, tool.across[0]), hn::Set(f, tool.across[1]), hn::Set(f, tool.across[2])};
  const V across = dot(axis, normal), flank = hn::Min(hn::Mul(across, across), one), edge = hn::Sub(one, flank);
  const V cubes = hn::Add(hn::Mul(hn::Mul(flank, flank), flank), hn::Mul(hn::Mul(edge, edge), edge));
  const V part = hn::Div(share, hn::Sqrt(cubes));
  const V kept = hn::Add(hn::Sub(one, share), hn::Mul(part, edge));
  const V more = hn::Mul(hn::Mul(part, hn::Sub(flank, edge)), across);

  V drawn[3];
  for (int c = 0; c < 3; ++c) drawn[c] = hn::Add(hn::Mul(kept, normal[c]), hn::Mul(more, axis[c]));
  const V to_unit = hn::Div(one, hn::Max(hn::Sqrt(dot(drawn, drawn)), hn::Set(f, 1e-6f)));
  for (int c = 0; c < 3; ++c) normal[c] = hn::IfThenElse(cuts, hn::Mul(drawn[c], to_unit), normal[c]);
}

void turnTouchingHere(const TouchingNodes::Row& phi, const float to_tool[3][3], float inwards, float beyond,
                      TouchingNodes& nodes, TouchingPlaces& places) {
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  const V tiny = hn::Set(f, 1e-30f), inwards_by = hn::Set(f, inwards), beyond_by = hn::Set(f, beyond);
  V turn[3][3];
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) turn[row][column] = hn::Set(f, to_tool[row][column]);

  for (int n = 0; n < nodes.count; n += lanes) {
    const V area = hn::Max(hn::LoadU(f, nodes.area.data() + n), tiny);
    V normal[3];
    for (int c = 0; c < 3; ++c) {
      normal[c] = hn::Div(hn::LoadU(f, nodes.normal[c].data() + n), area);
      hn::StoreU(normal[c], f, nodes.normal[c].data() + n);
    }

    const V out_by = hn::LoadU(f, phi.data() + n);
    for (int c = 0; c < 3; ++c) {
      const V outward = hn::Add(hn::Mul(turn[c][0], normal[0]),
                                hn::Add(hn::Mul(turn[c][1], normal[1]), hn::Mul(turn[c][2], normal[2])));
      const V place = hn::LoadU(f, nodes.in_tool[c].data() + n);
      hn::StoreU(hn::Sub(place, hn::Mul(inwards_by, outward)), f, places.inwards[c].data() + n);
      if (!(beyond > 0)) continue;
      const V foot = hn::Sub(place, hn::Mul(out_by, outward));
      hn::StoreU(foot, f, nodes.foot[c].data() + n);
      hn::StoreU(hn::Add(foot, hn::Mul(beyond_by, outward)), f, places.beyond[c].data() + n);
    }
  }
}

void sumTouchingHere(const TouchingNodes& nodes, const TouchingTool& tool, TouchingSums& out) {
  using S = TouchingSums;
  const F f;
  const int lanes = static_cast<int>(hn::Lanes(f));
  alignas(32) float lane[S::kSums][8] = {};
  const V zero = hn::Zero(f), one = hn::Set(f, 1.0f);
  V deepest = zero;
  const auto norm = [](V x, V y, V z) {
    return hn::Sqrt(hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z)));
  };

  for (int begin = 0; begin < nodes.count; begin += lanes) {
    const auto load = [&](const TouchingNodes::Row& row) { return hn::LoadU(f, row.data() + begin); };
    float* const column = &lane[0][begin % 8];
    const auto add = [&](int sum, V value) {
      float* at = column + 8 * sum;
      hn::StoreU(hn::Add(hn::LoadU(f, at), value), f, at);
    };

    // Overlap, facing weight, and the remaining fraction of an eroding overlap: its mean over this evaluation, and over
    // the next one if the tool stays.
    const V overlap = load(nodes.overlap), into_cut = load(nodes.into_cut), area = load(nodes.area);
    V facing = hn::Min(hn::Max(hn::Add(load(nodes.slope), load(nodes.slope)), zero), one);
    if (tool.geometry_only) facing = hn::IfThenElse(hn::Lt(into_cut, overlap), facing, zero);
    const V px = load(nodes.in_tool[0]), py = load(nodes.in_tool[1]), pz = load(nodes.in_tool[2]);
    const V arm = leverAt(f, tool.lever, px, py, pz);
    V x = hn::Mul(load(nodes.rate), arm);
    V erodes = into_cut;  // of the overlap
    auto is_lip = hn::Lt(one, zero);
    if (tool.lips.height > 0) {
      const V at_lips = hn::Mul(load(nodes.lip_rate), lipLever(arm));
      is_lip = hn::Lt(pz, hn::Set(f, tool.lips.height));
      x = hn::IfThenElse(is_lip, at_lips, x);
      erodes = hn::IfThenElse(is_lip, overRubbing(f, into_cut, hn::Set(f, tool.lips.rub), at_lips), into_cut);
    }

    V part = erodedPart(f, x);
    V mean_part = hn::IfThenElse(hn::Lt(x, hn::Set(f, 1e-6f)), one, hn::Div(part, hn::Max(x, hn::Set(f, 1e-6f))));
    if (tool.lips.height > 0) {  // a lip at its greatest feed goes in evenly
      const V most = hn::Div(hn::Set(f, tool.lips.most), hn::Max(erodes, hn::Set(f, 1e-9f)));
      const auto is_at_most = hn::And(is_lip, hn::Lt(most, part));
      mean_part = hn::IfThenElse(is_at_most, hn::Sub(one, hn::Mul(hn::Set(f, 0.5f), most)), mean_part);
      part = hn::IfThenElse(is_at_most, most, part);
    }
    const V mean = hn::Sub(overlap, hn::Mul(erodes, hn::Sub(one, mean_part)));
    const V kept = hn::Mul(hn::Sub(one, part), mean_part);
    const V next = hn::Sub(overlap, hn::Mul(erodes, hn::Sub(one, kept)));
    const auto cuts = hn::Gt(into_cut, zero);

    // Cut nodes count by the part of their area that is on a face, with the lever at the surface.
    V area_of_cut = area, arm_of_work = arm;
    if (tool.cut_share > 0) {
      const V share = hn::Set(f, tool.cut_share);
      const V slope = hn::Div(hn::Neg(hn::Add(into_cut, load(nodes.tau_beyond))), hn::Set(f, tool.beyond));
      area_of_cut = hn::Mul(area, hn::Sub(one, hn::Mul(share, hn::Sub(one, partOnFace(f, slope)))));
      const V at_foot = leverAt(f, tool.lever, load(nodes.foot[0]), load(nodes.foot[1]), load(nodes.foot[2]));
      arm_of_work = hn::IfThenElse(cuts, hn::Add(arm, hn::Mul(share, hn::Sub(at_foot, arm))), arm);
    }
    const V counted = hn::IfThenElse(cuts, hn::Mul(area_of_cut, hn::Set(f, tool.area_scale)), area);
    const V stiff = hn::Mul(hn::Mul(load(nodes.stiffness), facing), counted);  // N/mm
    const V stiff_next = hn::IfThenElse(cuts, hn::Mul(stiff, mean_part), stiff);
    const V size = hn::Mul(stiff, mean), size_next = hn::Mul(stiff, next);

    // Force, torque and stiffness, u = (n, r x n).
    const V r[3] = {load(nodes.from_tip[0]), load(nodes.from_tip[1]), load(nodes.from_tip[2])};
    V u[6] = {load(nodes.normal[0]), load(nodes.normal[1]), load(nodes.normal[2]), zero, zero, zero};
    if (tool.is_blade && tool.cut_share > 0) drawToFace(f, tool, cuts, u);
    for (int c = 0; c < 3; ++c) {
      const int d = (c + 1) % 3, e = (c + 2) % 3;
      u[3 + c] = hn::Sub(hn::Mul(r[d], u[e]), hn::Mul(r[e], u[d]));
    }
    int entry = S::kStiffness;
    for (int row = 0; row < 6; ++row) {
      add(S::kForce + row, hn::Mul(size, u[row]));
      add(S::kForceNext + row, hn::Mul(size_next, u[row]));
      const V scaled = hn::Mul(stiff_next, u[row]);
      add(S::kLoadSlope + row, scaled);
      for (int column_of = 0; column_of <= row; ++column_of) add(entry++, hn::Mul(scaled, u[column_of]));
    }

    // Loads, and the drive's expense for the tool's own motion.
    add(S::kNormalLoad, size);
    add(S::kLoadNext, size_next);
    add(S::kCuttingLoad, hn::IfThenElseZero(cuts, size));
    const V rubbing = hn::Mul(load(nodes.friction), size);
    V own = hn::Mul(hn::Set(f, tool.speed), arm), turning = hn::Mul(rubbing, arm_of_work);
    if (!tool.body_spins) {
      own = hn::IfThenElseZero(cuts, own);
      turning = hn::IfThenElseZero(cuts, turning);
    }
    add(S::kDriveLoad, turning);
    add(S::kPower, hn::Mul(hn::Set(f, tool.speed), turning));

    // Drag over the sliding speed, with its first and second moments about the tip.
    V v[3];
    for (int c = 0; c < 3; ++c) {
      const int d = (c + 1) % 3, e = (c + 2) % 3;
      v[c] = hn::Add(hn::Set(f, tool.velocity[c]),
                     hn::Sub(hn::Mul(hn::Set(f, tool.angular[d]), r[e]), hn::Mul(hn::Set(f, tool.angular[e]), r[d])));
    }
    const V sliding = hn::Max(hn::Max(own, norm(v[0], v[1], v[2])), hn::Set(f, tool.still_speed));
    V drag = hn::Div(rubbing, sliding);
    add(S::kDrag, drag);
    if (tool.lips.height > 0) {  // lips cut in pairs: their forces across the axis cancel, see DrillLips
      add(S::kLipTorque, hn::IfThenElseZero(is_lip, turning));
      if (!tool.is_at_rest) drag = hn::IfThenElse(is_lip, zero, drag);
    }
    entry = S::kDragSecond;
    for (int row = 0; row < 3; ++row) {
      const V moment = hn::Mul(drag, r[row]);
      add(S::kDragMoment + row, moment);
      for (int column_of = 0; column_of <= row; ++column_of) add(entry++, hn::Mul(moment, r[column_of]));
    }

    entry = S::kNormalDrag;
    for (int row = 0; tool.is_at_rest && row < 6; ++row)
      for (int column_of = 0; column_of <= row; ++column_of) add(entry++, hn::Mul(hn::Mul(drag, u[row]), u[column_of]));

    const auto counts = hn::Gt(stiff, zero);
    add(S::kArea, hn::IfThenElseZero(counts, area));
    add(S::kCount, hn::IfThenElseZero(counts, one));
    add(S::kErodibleLoad, hn::Mul(stiff, into_cut));
    V cut_by_shell = hn::Mul(hn::Mul(facing, area_of_cut), hn::Mul(erodes, part));
    if (tool.cut_share > 0) cut_by_shell = hn::Div(hn::Mul(cut_by_shell, arm_of_work), hn::Max(arm, hn::Set(f, 1e-6f)));
    add(S::kCutByShell, cut_by_shell);

    // The same without the facing weight.
    const V bare = hn::Mul(hn::Mul(load(nodes.stiffness), counted), into_cut);
    V bare_mean = hn::Mul(bare, mean_part);
    if (tool.lips.height > 0) {
      const V gone = hn::Mul(hn::Mul(load(nodes.stiffness), counted), hn::Mul(erodes, hn::Sub(one, mean_part)));
      bare_mean = hn::Sub(bare, gone);
    }
    add(S::kBareErodible, bare);
    add(S::kBareLoad, bare_mean);
    add(S::kBareDriveLoad, hn::Mul(hn::Mul(load(nodes.friction), bare_mean), arm_of_work));
    deepest = hn::Max(deepest, hn::IfThenElseZero(counts, overlap));
  }

  const std::size_t used = tool.is_at_rest ? S::kSums : S::kNormalDrag;
  for (std::size_t s = 0; s < used; ++s)
    for (const float part : lane[s]) out.value[s] += static_cast<double>(part);
  out.deepest = std::max(out.deepest, hn::GetLane(hn::MaxOfLanes(f, deepest)));
}

}  // namespace kerf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::internal {

HWY_EXPORT(turnTouchingHere);
HWY_EXPORT(sumTouchingHere);

void turnTouching(const TouchingNodes::Row& phi, const float to_tool[3][3], float inwards, float beyond,
                  TouchingNodes& nodes, TouchingPlaces& places) noexcept {
  HWY_DYNAMIC_DISPATCH(turnTouchingHere)(phi, to_tool, inwards, beyond, nodes, places);
}

void sumTouching(const TouchingNodes& nodes, const TouchingTool& tool, TouchingSums& sums) noexcept {
  HWY_DYNAMIC_DISPATCH(sumTouchingHere)(nodes, tool, sums);
}

}  // namespace kerf::internal
#endif
