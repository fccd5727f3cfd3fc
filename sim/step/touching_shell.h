// The walk over a shell's nodes that overlap a tool, for the sums of contact and the gathering of contact points.
#pragma once

#include <hwy/cache_control.h>

#include <algorithm>
#include <bit>

#include "sim/step/brick_to_tool.h"
#include "sim/step/contact.h"
#include "sim/step/node_kernels.h"

namespace kerf::internal {

/// A node of the shell that overlaps the tool.
struct TouchingNode {
  Vec3f area_vector;      ///< outward, object axes, mm^2; its length is `area`, not 0
  Vec3f in_tool;          ///< tool frame, mm
  Vec3d from_tip;         ///< object axes, mm
  float area;             ///< mm^2
  float phi, tau;         ///< mm; tau of the nearer of both fields
  float tau_cut, gap;     ///< mm; gap = tau + phi < -ToolField::leastOverlap(). tau_cut is kFar if far away
  bool body_is_near;      ///< tau is the nearer of cutting part and body; else the body is surely farther
  std::uint8_t material;  ///< number

  Vec3f normal() const { return area_vector / area; }  ///< outward unit normal, object axes
};

/// Prefetches the data that forEachTouching() reads of every node. A large contact does not fit the caches: while one
/// brick is summed, the next one's nodes come nearer.
inline void fetchShell(const CutObject::Slot& slot) {
  if (!slot.shell) return;  // not made yet
  for (int begin = 0; begin < slot.shell_count; begin += ShellChunk::kNodes) {
    const ShellChunk& chunk = slot.chunk(static_cast<std::size_t>(begin / ShellChunk::kNodes));
    const auto fetch = [](const auto& row) {
      for (std::size_t n = 0; n < row.size(); n += 64 / sizeof row[0]) hwy::Prefetch(&row[n]);
    };
    fetch(chunk.phi);
    fetch(chunk.offset);
  }
}

/// Calls visit(node) for every node with an area that overlaps the tool, in the order of `near`. Puts bricks to sleep
/// that cannot touch for a while. @return number of nodes tested. @rt if visit is.
template <class Visit>
int forEachTouching(CutObject& object, const NearBricks& near, const ToolModel& tool, const Rigid3& T_object_tool,
                    const Visit& visit) noexcept {
  constexpr int kGather = ShellChunk::kNodes;
  const double h = object.voxel();
  const Eigen::Matrix3d to_tool = T_object_tool.rotation.toRotationMatrix().transpose();
  const bool has_body = !tool.body.isEmpty();
  const double slack = std::max(tool.cut.slack(), tool.body.slack());
  const float aside = static_cast<float>(2 * (slack + 0.2 * h));
  const float beside = static_cast<float>(0.05 * h);

  int tested = 0;
  float px[kGather], py[kGather], pz[kGather], now[kGather], cut[kGather], body[kGather];
  for (std::size_t b = 0; b < near.size(); ++b) {
    CutObject::Slot& slot = object.slot(near.slot(b));
    if (slot.shell_count == 0 || object.odometer < slot.sleeps_until_contact || near.leastAny(b) >= -slot.least)
      continue;
    object.needShell(near.slot(b));
    if (b + 1 < near.size()) fetchShell(object.slot(near.slot(b + 1)));
    const BrickToTool map(to_tool, T_object_tool.translation, slot.brick, h);
    const Vec3d corner = h * 8 * slot.brick.cast<double>() - T_object_tool.translation;
    const bool body_may_touch = has_body && near.leastBody(b) < -slot.least;
    // Looks up the cutting part where it may nearly touch: a visitor may ask which of both parts is the nearer.
    const bool cut_is_near = !body_may_touch || near.leastCut(b) < beside - slot.least;
    // Distance of the tool from touching the brick. A part without a computed distance has its bound.
    float clearance = has_body && !body_may_touch ? near.leastBody(b) + slot.least : ToolField::kFar;
    if (!cut_is_near) {
      clearance = near.leastCut(b) + slot.least;
      std::fill_n(cut, kGather, ToolField::kFar);
    }
    bool touches = false;

    for (int begin = 0; begin < slot.shell_count; begin += kGather) {
      const ShellChunk& chunk = slot.chunk(static_cast<std::size_t>(begin / kGather));
      const int count = std::min(kGather, slot.shell_count - begin), padded = (count + 7) / 8 * 8;
      placeShell(map.base, map.along, chunk.offset.data(), padded, px, py, pz);
      const float* phi = chunk.phi.data();
      if (slot.isListed(SlotBit::kDirty)) {  // cut since, with no memory left for the repair
        valuesAt(slot.phi, chunk.offset.data(), padded, now);
        phi = now;
      }
      if (cut_is_near) tool.cut.distances(px, py, pz, cut, padded);

      // Where the cutting part is nearer than the body can be, there and a step further inwards, the body has no
      // effect.
      const bool body_is_near = body_may_touch && largestOf(cut, padded) > near.leastBody(b) - aside;
      if (body_is_near) tool.body.distances(px, py, pz, body, padded);
      tested += count;

      for (std::uint64_t bits =
               touchingNodes(cut, body_is_near ? body : nullptr, phi, count, tool.cut.leastOverlap(), clearance);
           bits != 0; bits &= bits - 1) {
        const int n = std::countr_zero(bits);
        const float nearest = body_is_near ? std::min(cut[n], body[n]) : cut[n];
        const float gap = nearest + phi[n];
        const auto at = static_cast<std::size_t>(n);
        const Vec3f w(chunk.x[at], chunk.y[at], chunk.z[at]);
        const float area = w.norm();
        if (!(area > 0)) continue;

        touches = true;
        const int offset = chunk.offset[at];
        visit(TouchingNode{w, Vec3f(px[n], py[n], pz[n]), corner + h * Vec3d(offset >> 6, offset >> 3 & 7, offset & 7),
                           area, phi[n], nearest, cut[n], gap, body_is_near, chunk.material[at]});
      }
    }

    slot.sleeps_until_contact =
        touches ? -1 : object.odometer + staggered(static_cast<double>(clearance) - slack, near.slot(b));
  }
  return tested;
}

}  // namespace kerf::internal
