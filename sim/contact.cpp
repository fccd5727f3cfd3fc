#include "sim/contact.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "sim/internal/relax_brick.h"
#include "sim/internal/shell_nodes.h"
#include "sim/internal/sum_touching.h"

namespace kerf {
namespace {

constexpr std::size_t kCacheLine = 64;  // bytes
constexpr int kBlock = 4;               // bricks along a side of a block
constexpr float kEquatorFloor = 0.2f;   // the axis of a bur does not stand still: of the equator's speed
constexpr float kStillSpeed = 0.5f;     // mm/s: below it Coulomb friction fades, so that it can be integrated

// From a node's place in its brick to the tool's frame: p = base + i * along[0] + j * along[1] + k * along[2].
struct BrickToTool {
  float along[3][3];  // [axis of the brick][coordinate of the tool]
  float base[3];

  BrickToTool(const Eigen::Matrix3d& object_to_tool, const Vec3d& tip, const Vec3i& brick, double h) {
    const Vec3d b = object_to_tool * (h * 8 * brick.cast<double>() - tip);
    for (int c = 0; c < 3; ++c) {
      base[c] = static_cast<float>(b[c]);
      for (int axis = 0; axis < 3; ++axis) along[axis][c] = static_cast<float>(h * object_to_tool(c, axis));
    }
  }
};

internal::LeverForm leverForm(ToolMotion motion) {
  return motion == ToolMotion::kSpin    ? internal::LeverForm::kRadius
         : motion == ToolMotion::kSwing ? internal::LeverForm::kPivot
                                        : internal::LeverForm::kOne;
}

// c dt over the lever, per material.
struct Rates {
  std::array<float, 256> value;
  explicit Rates(const ContactInput& in) {
    for (std::size_t m = 0; m < 256; ++m) {
      const Tissue& t = (*in.tissues)[m];
      value[m] =
          static_cast<float>(static_cast<double>(t.friction * t.stiffness * t.inverse_energy) * std::abs(in.speed) *
                             in.tool->drive.drag_factor / in.tool->drive.energy_factor * in.dt);
    }
  }
};

// What sumContact() reads of every node. A large contact does not fit the caches: while one brick is summed, the next
// one's nodes come nearer.
void fetchShell(const CutObject::Slot& slot) {
  for (int begin = 0; begin < slot.shell_count; begin += ShellChunk::kNodes) {
    const ShellChunk& chunk = *slot.chunks[static_cast<std::size_t>(begin / ShellChunk::kNodes)];
    const auto fetch = [](const auto& row) {
      for (std::size_t n = 0; n < row.size(); n += kCacheLine / sizeof row[0]) hwy::Prefetch(&row[n]);
    };
    fetch(chunk.phi), fetch(chunk.offset);
  }
}

Eigen::Matrix3d crossMatrix(const Vec3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

}  // namespace

void ContactSums::add(const ContactSums& o) {
  force += o.force, torque += o.torque, force_after += o.force_after, torque_after += o.torque_after;
  stiffness += o.stiffness;
  drag += o.drag, drag_moment += o.drag_moment, drag_second += o.drag_second;
  normal_load += o.normal_load, cutting_load += o.cutting_load, drive_load += o.drive_load, power += o.power;
  area += o.area, deepest = std::max(deepest, o.deepest);
  tested += o.tested, touching += o.touching;
  if (o.material_area > material_area) material = o.material, material_area = o.material_area;
}

Matrix6d ContactSums::dragMatrix() const {
  // v(r) = v + w x r; force = -sum c v(r), torque = sum r x force
  Matrix6d m;
  const Eigen::Matrix3d s = crossMatrix(drag_moment);
  m.topLeftCorner<3, 3>() = drag * Eigen::Matrix3d::Identity();
  m.topRightCorner<3, 3>() = -s;
  m.bottomLeftCorner<3, 3>() = s;
  m.bottomRightCorner<3, 3>() = drag_second.trace() * Eigen::Matrix3d::Identity() - drag_second;
  return m;
}

NearBricks::NearBricks(std::size_t capacity) : slots_(capacity), cut_(capacity), body_(capacity) {}

bool NearBricks::find(const CutObject& object, const ToolModel& tool, const Rigid3& T) noexcept {
  count_ = 0;
  const double h = object.voxel();
  const double band = std::max(-static_cast<double>(object.baked().phi0().interior()), kShellHalfWidth * h);
  const double slack = std::max(tool.cut.slack(), tool.body.slack());
  const double brick_radius = 0.5 * std::sqrt(3.0) * 7 * h + slack;
  const double block_radius = 0.5 * std::sqrt(3.0) * (8 * kBlock - 1) * h + slack;
  Box3 box;
  for (const ToolField* field : {&tool.cut, &tool.body}) {
    if (field->isEmpty()) continue;
    const Box3& b = field->bounds();
    for (int c = 0; c < 8; ++c)
      box.add(T * Vec3d((c & 1 ? b.max : b.min)[0], (c & 2 ? b.max : b.min)[1], (c & 4 ? b.max : b.min)[2]));
  }
  if (box.isEmpty()) return true;
  box.grow(band);
  const Vec3i first = object.baked().directoryLow();
  const Vec3i last = first + object.baked().directorySize() - Vec3i::Ones();
  // Clamped before they become integers: a tool may be anywhere.
  const auto brickAt = [&](const Vec3d& p) -> Vec3i {
    const Vec3d b = (p / (8 * h)).array().floor();
    return b.cwiseMax((first - Vec3i::Ones()).cast<double>())
        .cwiseMin((last + Vec3i::Ones()).cast<double>())
        .cast<int>();
  };
  const Vec3i low = brickAt(box.min).cwiseMax(first), high = brickAt(box.max).cwiseMin(last);
  const Eigen::Matrix3d to_tool = T.rotation.toRotationMatrix().transpose();
  bool fits = true;
  float px[kBlock * kBlock * kBlock], py[kBlock * kBlock * kBlock], pz[kBlock * kBlock * kBlock];
  float cut[kBlock * kBlock * kBlock], body[kBlock * kBlock * kBlock];
  for (int x = low[0]; x <= high[0]; x += kBlock)
    for (int y = low[1]; y <= high[1]; y += kBlock)
      for (int z = low[2]; z <= high[2]; z += kBlock) {
        const Vec3i begin(x, y, z);
        const Vec3d middle = h * (8 * begin.cast<double>() + Vec3d::Constant(0.5 * (8 * kBlock - 1)));
        const Vec3f p = (to_tool * (middle - T.translation)).cast<float>();
        const double nearest = static_cast<double>(std::min(tool.cut.distance(p), tool.body.distance(p)));
        if (nearest - block_radius >= band) continue;
        int slots[kBlock * kBlock * kBlock], count = 0;
        object.forEachIn(begin, (begin + Vec3i::Constant(kBlock - 1)).cwiseMin(high), [&](int s) {
          const CutObject::Slot& slot = object.slot(s);
          if (object.odometer < slot.sleeps_until_cut &&
              (slot.shell_count == 0 || object.odometer < slot.sleeps_until_contact))
            return;
          const Vec3d center = h * (8 * slot.brick.cast<double>() + Vec3d::Constant(3.5));
          const Vec3f q = (to_tool * (center - T.translation)).cast<float>();
          px[count] = q[0], py[count] = q[1], pz[count] = q[2];
          slots[count++] = s;
        });
        const int padded = (count + 7) / 8 * 8;
        for (int n = count; n < padded; ++n) px[n] = py[n] = pz[n] = 0;
        tool.cut.distances(px, py, pz, cut, padded);
        tool.body.distances(px, py, pz, body, padded);
        for (int n = 0; n < count; ++n) {
          const CutObject::Slot& slot = object.slot(slots[n]);
          const float least_cut = cut[n] - static_cast<float>(brick_radius);
          const float least_body = body[n] - static_cast<float>(brick_radius);
          if (std::min(least_cut, least_body) >= -slot.least) continue;
          if (count_ == slots_.size()) {
            fits = false;
            break;
          }
          slots_[count_] = slots[n], cut_[count_] = least_cut, body_[count_] = least_body;
          ++count_;
        }
      }
  return fits;
}

void sumContact(CutObject& object, const NearBricks& near, const ContactInput& in, ContactSums& sums) noexcept {
  const double h = object.voxel();
  const ToolModel& tool = *in.tool;
  const Eigen::Matrix3d to_tool = in.T_object_tool.rotation.toRotationMatrix().transpose();
  const Eigen::Matrix3f to_tool_f = to_tool.cast<float>();
  const Rates rates(in);
  const float look = static_cast<float>(0.2 * h);  // step of the directional derivative of tau
  const bool has_body = !tool.body.isEmpty();
  const double slack = std::max(tool.cut.slack(), tool.body.slack());
  const float aside = static_cast<float>(2 * (slack + 0.2 * h));
  internal::TouchingTool moving;
  moving.lever = leverForm(tool.motion);
  moving.least_radius = kEquatorFloor * static_cast<float>(tool.equator_mm);
  moving.pivot = static_cast<float>(tool.pivot_mm);
  moving.speed = static_cast<float>(std::abs(in.speed)), moving.still_speed = kStillSpeed;
  moving.body_spins = tool.motion == ToolMotion::kSpin;
  moving.geometry_only = in.geometry_only;
  for (int c = 0; c < 3; ++c) {
    moving.velocity[c] = static_cast<float>(in.velocity[c]);
    moving.angular[c] = static_cast<float>(in.angular[c]);
  }
  internal::TouchingSums totals;
  std::array<float, 256> area_of{};
  // Nodes that overlap the tool, of whatever brick, gathered until there are enough of them to look a step further
  // inwards, for the slope of tau there, and to be summed.
  constexpr int kGather = ShellChunk::kNodes;
  static_assert(kGather == internal::TouchingNodes::kMost);
  internal::TouchingNodes found;
  float qx[kGather], qy[kGather], qz[kGather], tau[kGather], cut_in[kGather], body_in[kGather];
  bool any_body = false;
  const auto flush = [&] {
    const int count = found.count, padded = (count + 7) / 8 * 8;
    if (count == 0) return;
    const auto pad = [&](auto& row) {
      for (auto n = static_cast<std::size_t>(count); n < static_cast<std::size_t>(padded); ++n) row[n] = 0;
    };
    for (int n = count; n < padded; ++n) qx[n] = qy[n] = qz[n] = tau[n] = 0;
    pad(found.overlap), pad(found.into_cut), pad(found.area);
    pad(found.stiffness), pad(found.friction), pad(found.rate);
    for (int c = 0; c < 3; ++c) pad(found.normal[c]), pad(found.from_tip[c]), pad(found.in_tool[c]);
    tool.cut.distances(qx, qy, qz, cut_in, padded);
    if (any_body) tool.body.distances(qx, qy, qz, body_in, padded);
    for (int n = 0; n < padded; ++n)
      found.slope[static_cast<std::size_t>(n)] =
          ((any_body ? std::min(cut_in[n], body_in[n]) : cut_in[n]) - tau[n]) / look;
    found.count = padded;
    internal::sumTouching(found, moving, totals);
    found.count = 0, any_body = false;
  };
  float px[kGather], py[kGather], pz[kGather], now[kGather], cut[kGather], body[kGather];
  for (std::size_t b = 0; b < near.size(); ++b) {
    CutObject::Slot& slot = object.slot(near.slot(b));
    if (slot.shell_count == 0 || object.odometer < slot.sleeps_until_contact || near.leastAny(b) >= -slot.least)
      continue;
    if (b + 1 < near.size()) fetchShell(object.slot(near.slot(b + 1)));
    const BrickToTool map(to_tool, in.T_object_tool.translation, slot.brick, h);
    const Vec3d corner = h * 8 * slot.brick.cast<double>() - in.T_object_tool.translation;
    const bool body_may_touch = has_body && near.leastBody(b) < -slot.least;
    // Until the first of its nodes touches: a body that was not looked at is known by its bound.
    float room = has_body && !body_may_touch ? near.leastBody(b) + slot.least : ToolField::kFar;
    bool touches = false;
    for (int begin = 0; begin < slot.shell_count; begin += kGather) {
      const ShellChunk& chunk = *slot.chunks[static_cast<std::size_t>(begin / kGather)];
      const int count = std::min(kGather, slot.shell_count - begin), padded = (count + 7) / 8 * 8;
      internal::placeShell(map.base, map.along, chunk.offset.data(), padded, px, py, pz);
      const float* phi = chunk.phi.data();
      if (slot.is_dirty) {  // cut since, and no room was left to repair it
        internal::valuesAt(slot.phi, chunk.offset.data(), padded, now);
        phi = now;
      }
      tool.cut.distances(px, py, pz, cut, padded);
      // Where what cuts is nearer than the body can be, there and a look further inwards, the body says nothing.
      const bool body_is_near = body_may_touch && internal::largestOf(cut, padded) > near.leastBody(b) - aside;
      if (body_is_near) tool.body.distances(px, py, pz, body, padded);
      sums.tested += count;
      for (std::uint64_t bits = internal::touchingNodes(cut, body_is_near ? body : nullptr, phi, count, room);
           bits != 0; bits &= bits - 1) {
        const int n = std::countr_zero(bits);
        const float nearest = body_is_near ? std::min(cut[n], body[n]) : cut[n];
        const float gap = nearest + phi[n];
        const auto at = static_cast<std::size_t>(n);
        const Vec3f w(chunk.x[at], chunk.y[at], chunk.z[at]);
        const float area = w.norm();
        if (!(area > 0)) continue;
        touches = true;
        any_body |= body_is_near;
        const auto i = static_cast<std::size_t>(found.count);
        const Vec3f normal = w / area;
        const Vec3f inwards = Vec3f(px[n], py[n], pz[n]) - look * (to_tool_f * normal);
        qx[i] = inwards[0], qy[i] = inwards[1], qz[i] = inwards[2], tau[i] = nearest;
        const int offset = chunk.offset[at];
        const Vec3d r = corner + h * Vec3d(offset >> 6, offset >> 3 & 7, offset & 7);
        const float place[3] = {px[n], py[n], pz[n]};
        for (int c = 0; c < 3; ++c) {
          found.normal[c][i] = normal[c];
          found.from_tip[c][i] = static_cast<float>(r[c]);
          found.in_tool[c][i] = place[c];
        }
        const std::uint8_t material = chunk.material[at];
        const Tissue& tissue = (*in.tissues)[material];
        found.overlap[i] = -gap, found.into_cut[i] = std::max(0.0f, -cut[n] - phi[n]), found.area[i] = area;
        found.stiffness[i] = tissue.stiffness;
        found.friction[i] = static_cast<float>(tool.drive.drag_factor) * tissue.friction;
        found.rate[i] = rates.value[material];
        area_of[material] += area;
        if (++found.count == kGather) flush();
      }
    }
    slot.sleeps_until_contact = touches ? -1 : object.odometer + static_cast<double>(room) - slack;
  }
  flush();
  for (std::size_t m = 0; m < area_of.size(); ++m)
    if (static_cast<double>(area_of[m]) > sums.material_area)
      sums.material_area = static_cast<double>(area_of[m]), sums.material = static_cast<std::uint8_t>(m);
  using S = internal::TouchingSums;
  const auto value = [&](int at) { return totals.value[static_cast<std::size_t>(at)]; };
  const auto vector = [&](int at) { return Vec3d(value(at), value(at + 1), value(at + 2)); };
  sums.force += vector(S::kForce), sums.torque += vector(S::kTorque);
  sums.force_after += vector(S::kForceAfter), sums.torque_after += vector(S::kTorqueAfter);
  for (int row = 0, entry = S::kStiffness; row < 6; ++row)
    for (int column = 0; column <= row; ++column, ++entry) {
      sums.stiffness(row, column) += value(entry);
      if (column != row) sums.stiffness(column, row) += value(entry);
    }
  sums.normal_load += value(S::kNormalLoad), sums.cutting_load += value(S::kCuttingLoad);
  sums.drive_load += value(S::kDriveLoad), sums.power += value(S::kPower);
  sums.drag += value(S::kDrag), sums.drag_moment += vector(S::kDragMoment);
  for (int row = 0, entry = S::kDragSecond; row < 3; ++row)
    for (int column = 0; column <= row; ++column, ++entry) {
      sums.drag_second(row, column) += value(entry);
      if (column != row) sums.drag_second(column, row) += value(entry);
    }
  sums.area += value(S::kArea), sums.deepest = std::max(sums.deepest, static_cast<double>(totals.deepest));
  sums.touching += static_cast<int>(value(S::kCount));
}

CutResult erode(CutObject& object, const NearBricks& near, const ContactInput& in) noexcept {
  CutResult result;
  const ToolModel& tool = *in.tool;
  if (tool.cut.isEmpty() || (!in.geometry_only && in.speed == 0)) return result;
  const double h = object.voxel(), e = kShellHalfWidth * h, cell = h * h * h, slack = tool.cut.slack();
  const auto half_width = static_cast<float>(e);
  const Eigen::Matrix3d to_tool = in.T_object_tool.rotation.toRotationMatrix().transpose();
  const Rates rates(in);
  float x[kBrickNodes], y[kBrickNodes], z[kBrickNodes], tau[kBrickNodes], rate[kBrickNodes], next[kBrickNodes];
  double lost[kBrickNodes];
  internal::RelaxInput relax;
  relax.x = x, relax.y = y, relax.z = z, relax.tau = tau;
  relax.lever = leverForm(tool.motion), relax.geometry_only = in.geometry_only;
  // Air is air: values rise to the end of the band that was baked around the surface, and no further.
  relax.cap = object.baked().phi0().background();
  relax.least_radius = kEquatorFloor * static_cast<float>(tool.equator_mm);
  relax.pivot = static_cast<float>(tool.pivot_mm);
  for (std::size_t b = 0; b < near.size(); ++b) {
    const int s = near.slot(b);
    CutObject::Slot& slot = object.slot(s);
    if (object.odometer < slot.sleeps_until_cut || near.leastCut(b) >= -slot.least) continue;
    const BrickToTool map(to_tool, in.T_object_tool.translation, slot.brick, h);
    internal::placeNodes(map.base, map.along, x, y, z);
    tool.cut.distances(x, y, z, tau, kBrickNodes);
    relax.phi = slot.phi;
    relax.rate = rates.value[slot.materials[0]];
    relax.rates = nullptr;
    if (!slot.has_one_material) {
      for (int n = 0; n < kBrickNodes; ++n) rate[n] = rates.value[slot.materials[n]];
      relax.rates = rate;
    }
    const internal::RelaxResult relaxed_to = internal::relaxBrick(relax, next);
    if (relaxed_to.gap >= 0) {
      slot.sleeps_until_cut = object.odometer + static_cast<double>(relaxed_to.gap) - slack;
      continue;
    }
    slot.sleeps_until_cut = -1;
    if (std::memcmp(next, slot.phi, sizeof next) == 0) continue;
    const std::uint8_t faces = slot.changed_faces;
    float* own = object.write(s);
    if (!own) {
      result.room_ran_out = true;
      break;
    }
    const internal::NodeBits changed = internal::differingNodes(own, next);
    slot.changed_faces = faces | CutObject::facesOf(changed);
    internal::volumeLost(own, next, changed, e, cell, lost);
    // One sum per material, node by node: the order is part of the result.
    double one_material = object.removed_mm3[slot.materials[0]];
    for (int word = 0; word < kBrickSide; ++word)
      for (std::uint64_t bits = changed[static_cast<std::size_t>(word)]; bits != 0; bits &= bits - 1) {
        const int n = 64 * word + std::countr_zero(bits);
        if (own[n] >= half_width || next[n] <= -half_width) continue;
        (slot.has_one_material ? one_material : object.removed_mm3[slot.materials[n]]) += lost[n];
        result.removed_mm3 += lost[n];
      }
    if (slot.has_one_material) object.removed_mm3[slot.materials[0]] = one_material;
    std::memcpy(own, next, sizeof next);
    slot.least = relaxed_to.least;
    slot.sleeps_until_contact = -1;
    ++result.bricks;
  }
  return result;
}

}  // namespace kerf
