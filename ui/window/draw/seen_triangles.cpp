#include "ui/window/draw/seen_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ui/window/draw/seen_triangles.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kerf::internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 8>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;
using V = hn::Vec<F>;

// @return  the least w; NaN counts as 0.
float projectHere(const float* const positions[3], std::size_t count, const float rows[3][4], float* x, float* y) {
  const F f;
  const std::size_t lanes = hn::Lanes(f);
  const V one = hn::Set(f, 1.0f);
  V least = one;
  for (std::size_t n = 0; n < count; n += lanes) {
    const V px = hn::LoadU(f, positions[0] + n), py = hn::LoadU(f, positions[1] + n),
            pz = hn::LoadU(f, positions[2] + n);
    const auto along = [&](const float row[4]) {
      return hn::Add(hn::Add(hn::Mul(px, hn::Set(f, row[0])), hn::Mul(py, hn::Set(f, row[1]))),
                     hn::Add(hn::Mul(pz, hn::Set(f, row[2])), hn::Set(f, row[3])));
    };
    const V w = along(rows[2]);
    const V known = hn::IfThenElseZero(hn::Eq(w, w), w);
    least = hn::Min(least, hn::IfThenElse(hn::FirstN(f, count - n), known, one));
    hn::StoreU(hn::Div(along(rows[0]), w), f, x + n);
    hn::StoreU(hn::Div(along(rows[1]), w), f, y + n);
  }
  return hn::GetLane(hn::MinOfLanes(f, least));
}

struct Corner {
  V x, y;
};

// Twice the signed area of (from, to, point), and its rounding error.
struct Side {
  V across, along, slack;  // of the edge; its slack
  Corner from;
};

HWY_INLINE Side sideOf(const Corner& from, const Corner& to, V slack, V turn) {
  const V dx = hn::Sub(to.x, from.x), dy = hn::Sub(to.y, from.y);
  return {hn::Mul(turn, dx), hn::Mul(turn, dy), hn::Neg(hn::Mul(slack, hn::Add(hn::Abs(dx), hn::Abs(dy)))), from};
}

HWY_INLINE auto isWithin(const Side& side, V x, V y) {
  const V at = hn::Sub(hn::Mul(side.across, hn::Sub(y, side.from.y)), hn::Mul(side.along, hn::Sub(x, side.from.x)));
  return hn::Ge(at, side.slack);
}

std::size_t chooseHere(const float* x, const float* y, const std::uint32_t* const corners[3], std::size_t count,
                       float slack_pixels, bool has_backs, std::uint32_t* out) {
  const F f;
  const U u;
  const I i;
  const std::size_t lanes = hn::Lanes(f);
  const V slack = hn::Set(f, slack_pixels), one = hn::Set(f, 1.0f), two = hn::Set(f, 2.0f);
  std::size_t kept = 0;
  for (std::size_t n = 0; n < count; n += lanes) {
    // Beyond the last triangle: the first vertex, which exists.
    const auto is_there = hn::FirstN(u, count - n);
    const auto na = hn::IfThenElseZero(is_there, hn::LoadU(u, corners[0] + n));
    const auto nb = hn::IfThenElseZero(is_there, hn::LoadU(u, corners[1] + n));
    const auto nc = hn::IfThenElseZero(is_there, hn::LoadU(u, corners[2] + n));
    const auto cornerAt = [&](auto number) {
      const auto at = hn::BitCast(i, number);
      return Corner{hn::GatherIndex(f, x, at), hn::GatherIndex(f, y, at)};
    };
    const Corner a = cornerAt(na), b = cornerAt(nb), c = cornerAt(nc);

    // Seen from the front, or so nearly from the side that rounding could turn it.
    const V area =
        hn::Sub(hn::Mul(hn::Sub(b.x, a.x), hn::Sub(c.y, a.y)), hn::Mul(hn::Sub(b.y, a.y), hn::Sub(c.x, a.x)));
    const V turn = hn::IfThenElse(hn::Lt(area, hn::Zero(f)), hn::Neg(one), one);
    const Side ab = sideOf(a, b, slack, turn), bc = sideOf(b, c, slack, turn), ca = sideOf(c, a, slack, turn);
    auto is_seen = hn::FirstN(f, count - n);
    const V least_area = hn::Add(ab.slack, hn::Add(bc.slack, ca.slack));
    if (!has_backs) is_seen = hn::And(is_seen, hn::Not(hn::Lt(area, least_area)));
    if (hn::AllFalse(f, is_seen)) continue;

    // The first middle of a pixel in its box, and the three beside it; keeps triangles with a larger box.
    const V left = hn::Ceil(hn::Sub(hn::Min(hn::Min(a.x, b.x), c.x), slack));
    const V low = hn::Ceil(hn::Sub(hn::Min(hn::Min(a.y, b.y), c.y), slack));
    const V right = hn::Add(hn::Max(hn::Max(a.x, b.x), c.x), slack);
    const V high = hn::Add(hn::Max(hn::Max(a.y, b.y), c.y), slack);
    const auto isOver = [&](V px, V py) {
      const auto is_in_box = hn::And(hn::Le(px, right), hn::Le(py, high));
      return hn::And(hn::And(is_in_box, isWithin(ab, px, py)), hn::And(isWithin(bc, px, py), isWithin(ca, px, py)));
    };
    const V beside = hn::Add(left, one), above = hn::Add(low, one);
    auto covers =
        hn::Or(hn::Or(isOver(left, low), isOver(beside, low)), hn::Or(isOver(left, above), isOver(beside, above)));
    const auto is_wide = hn::Le(hn::Add(left, two), right), is_high = hn::Le(hn::Add(low, two), high);
    const auto is_crossed = hn::And(hn::Le(left, right), hn::Le(low, high));
    covers = hn::Or(covers, hn::And(is_crossed, hn::Or(is_wide, is_high)));
    // Draws triangles with NaN.
    covers = hn::Or(covers, hn::Not(hn::Eq(area, area)));
    is_seen = hn::And(is_seen, covers);

    const auto chosen = hn::RebindMask(u, is_seen);
    hn::StoreInterleaved3(hn::Compress(na, chosen), hn::Compress(nb, chosen), hn::Compress(nc, chosen), u,
                          out + 3 * kept);
    kept += hn::CountTrue(u, chosen);
  }
  return kept;
}

}  // namespace kerf::internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kerf::internal {

HWY_EXPORT(projectHere);
HWY_EXPORT(chooseHere);

namespace {

constexpr std::size_t kBeyond = 8;      // numbers behind the last one that a whole vector may read or write
constexpr float kRounding = 1.0f / 32;  // pixels: OpenGL promises corners to a sixteenth
constexpr float kNearest = 1e-3f;       // w of points too near to the eye, or behind it

}  // namespace

void SeenTriangles::clear() { *this = {}; }

void SeenTriangles::addVertex(const Vec3f& position) {
  for (int axis = 0; axis < 3; ++axis) positions_[axis].push_back(position[axis]);
  farthest_ = farthest_.cwiseMax(position.cwiseAbs());
}

void SeenTriangles::addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  corners_[0].push_back(a);
  corners_[1].push_back(b);
  corners_[2].push_back(c);
}

void SeenTriangles::look(const Sight& sight) {
  has_backs_ = sight.has_backs;
  has_all_ = sight.has_all;
  if (has_all_) return;

  const std::size_t count = positions_[0].size();
  for (auto& axis : positions_) axis.reserve(count + kBeyond);
  for (auto& axis : pixels_) axis.resize(count + kBeyond);
  for (auto& corner : corners_) corner.reserve(corner.size() + kBeyond);

  float rows[3][4];
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) rows[r][c] = sight.to_pixels(r, c);
  const float* const positions[3] = {positions_[0].data(), positions_[1].data(), positions_[2].data()};
  const float least_w = HWY_DYNAMIC_DISPATCH(projectHere)(positions, count, rows, pixels_[0].data(), pixels_[1].data());
  if (!(least_w > kNearest)) {
    has_all_ = true;
    return;
  }

  // Far from the origin single precision itself moves corners, here and in the driver.
  float largest = 0;
  for (int r = 0; r < 3; ++r)
    largest = std::max(largest,
                       sight.to_pixels.row(r).head<3>().cwiseAbs().dot(farthest_.transpose()) + std::abs(rows[r][3]));
  slack_ = kRounding + 8 * std::numeric_limits<float>::epsilon() * largest / least_w;
}

void SeenTriangles::choose(std::size_t first, std::size_t last, std::vector<std::uint32_t>& out) const {
  const std::size_t before = out.size();
  out.resize(before + 3 * (last - first + kBeyond));
  std::size_t kept = last - first;
  if (has_all_) {
    for (std::size_t n = 0; n < kept; ++n)
      for (std::size_t k = 0; k < 3; ++k) out[before + 3 * n + k] = corners_[k][first + n];
  } else {
    const std::uint32_t* const corners[3] = {corners_[0].data() + first, corners_[1].data() + first,
                                             corners_[2].data() + first};
    kept = HWY_DYNAMIC_DISPATCH(chooseHere)(pixels_[0].data(), pixels_[1].data(), corners, last - first, slack_,
                                            has_backs_, out.data() + before);
  }
  out.resize(before + 3 * kept);
}

}  // namespace kerf::internal
#endif
