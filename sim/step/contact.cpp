#include "sim/step/contact.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "sim/object/relax_brick.h"
#include "sim/object/shell_nodes.h"
#include "sim/step/sum_touching.h"
#include "sim/step/touching_shell.h"

namespace kerf {
namespace {

constexpr int kBlock = 4;              // bricks along a side of a block
constexpr float kEquatorFloor = 0.2f;  // the axis of a bur does not stand still: of the equator's speed
constexpr float kStillSpeed = 0.5f;    // mm/s: below it Coulomb friction fades, so that it can be integrated

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
                             in.tool->drive.drag_factor / in.tool->drive.energy_factor * in.dt * in.load_scale);
    }
  }
};

Eigen::Matrix3d crossMatrix(const Vec3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

}  // namespace

void ContactSums::add(const ContactSums& o) {
  force += o.force;
  torque += o.torque;
  force_after += o.force_after;
  torque_after += o.torque_after;
  stiffness += o.stiffness;
  drag += o.drag;
  drag_moment += o.drag_moment;
  drag_second += o.drag_second;
  normal_load += o.normal_load;
  cutting_load += o.cutting_load;
  drive_load += o.drive_load;
  power += o.power;
  erodible_load += o.erodible_load;
  area += o.area;
  deepest = std::max(deepest, o.deepest);
  tested += o.tested;
  touching += o.touching;
  if (o.material_area > material_area) {
    material = o.material;
    material_area = o.material_area;
  }
}

void ContactSums::scale(double factor) {
  force *= factor;
  torque *= factor;
  force_after *= factor;
  torque_after *= factor;
  stiffness *= factor;
  drag *= factor;
  drag_moment *= factor;
  drag_second *= factor;
  normal_load *= factor;
  cutting_load *= factor;
  erodible_load *= factor;
  drive_load *= factor;
  power *= factor;
}

ContactSums ContactSums::rotated(const Eigen::Matrix3d& r) const {
  ContactSums out = *this;
  out.force = r * force;
  out.torque = r * torque;
  out.force_after = r * force_after;
  out.torque_after = r * torque_after;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      out.stiffness.block<3, 3>(3 * i, 3 * j) = r * stiffness.block<3, 3>(3 * i, 3 * j) * r.transpose();
  out.drag_moment = r * drag_moment;
  out.drag_second = r * drag_second * r.transpose();
  return out;
}

Wrench ownDrag(const ToolModel& tool, const Rigid3& pose, double speed, const ContactSums& sums) noexcept {
  Wrench out;
  if (tool.motion != ToolMotion::kSpin) return out;
  const Vec3d spin = pose.rotation * Vec3d(0, 0, -speed);
  out.force = -spin.cross(sums.drag_moment);
  out.torque = -(sums.drag_second.trace() * spin - sums.drag_second * spin);
  return out;
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
        object.bricks().forEachIn(begin, (begin + Vec3i::Constant(kBlock - 1)).cwiseMin(high), [&](int s) {
          const CutObject::Slot& slot = object.slot(s);
          if (object.odometer < slot.sleeps_until_cut &&
              (slot.shell_count == 0 || object.odometer < slot.sleeps_until_contact))
            return;
          const Vec3d center = h * (8 * slot.brick.cast<double>() + Vec3d::Constant(3.5));
          const Vec3f q = (to_tool * (center - T.translation)).cast<float>();
          px[count] = q[0];
          py[count] = q[1];
          pz[count] = q[2];
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
          slots_[count_] = slots[n];
          cut_[count_] = least_cut;
          body_[count_] = least_body;
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
  internal::TouchingTool moving;
  moving.lever = leverForm(tool.motion);
  moving.least_radius = kEquatorFloor * static_cast<float>(tool.equator_mm);
  moving.pivot = static_cast<float>(tool.pivot_mm);
  moving.speed = static_cast<float>(std::abs(in.speed));
  moving.still_speed = kStillSpeed;
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
    pad(found.overlap);
    pad(found.into_cut);
    pad(found.area);
    pad(found.stiffness);
    pad(found.friction);
    pad(found.rate);
    for (int c = 0; c < 3; ++c) {
      pad(found.normal[c]);
      pad(found.from_tip[c]);
      pad(found.in_tool[c]);
    }
    tool.cut.distances(qx, qy, qz, cut_in, padded);
    if (any_body) tool.body.distances(qx, qy, qz, body_in, padded);
    for (int n = 0; n < padded; ++n)
      found.slope[static_cast<std::size_t>(n)] =
          ((any_body ? std::min(cut_in[n], body_in[n]) : cut_in[n]) - tau[n]) / look;
    found.count = padded;
    internal::sumTouching(found, moving, totals);
    found.count = 0;
    any_body = false;
  };
  sums.tested +=
      internal::forEachTouching(object, near, tool, in.T_object_tool, [&](const internal::TouchingNode& node) {
        any_body |= node.body_is_near;
        const auto i = static_cast<std::size_t>(found.count);
        const Vec3f inwards = node.in_tool - look * (to_tool_f * node.normal);
        qx[i] = inwards[0];
        qy[i] = inwards[1];
        qz[i] = inwards[2];
        tau[i] = node.tau;
        for (int c = 0; c < 3; ++c) {
          found.normal[c][i] = node.normal[c];
          found.from_tip[c][i] = static_cast<float>(node.from_tip[c]);
          found.in_tool[c][i] = node.in_tool[c];
        }
        const Tissue& tissue = (*in.tissues)[node.material];
        found.overlap[i] = -node.gap;
        found.into_cut[i] = std::max(0.0f, -node.tau_cut - node.phi);
        found.area[i] = node.area;
        found.stiffness[i] = tissue.stiffness;
        found.friction[i] = static_cast<float>(tool.drive.drag_factor) * tissue.friction;
        found.rate[i] = rates.value[node.material];
        area_of[node.material] += node.area;
        if (++found.count == kGather) flush();
      });
  flush();
  for (std::size_t m = 0; m < area_of.size(); ++m)
    if (static_cast<double>(area_of[m]) > sums.material_area) {
      sums.material_area = static_cast<double>(area_of[m]);
      sums.material = static_cast<std::uint8_t>(m);
    }
  using S = internal::TouchingSums;
  const auto value = [&](int at) { return totals.value[static_cast<std::size_t>(at)]; };
  const auto vector = [&](int at) { return Vec3d(value(at), value(at + 1), value(at + 2)); };
  sums.force += vector(S::kForce);
  sums.torque += vector(S::kTorque);
  sums.force_after += vector(S::kForceAfter);
  sums.torque_after += vector(S::kTorqueAfter);
  for (int row = 0, entry = S::kStiffness; row < 6; ++row)
    for (int column = 0; column <= row; ++column, ++entry) {
      sums.stiffness(row, column) += value(entry);
      if (column != row) sums.stiffness(column, row) += value(entry);
    }
  sums.normal_load += value(S::kNormalLoad);
  sums.cutting_load += value(S::kCuttingLoad);
  sums.erodible_load += value(S::kErodibleLoad);
  sums.drive_load += value(S::kDriveLoad);
  sums.power += value(S::kPower);
  sums.drag += value(S::kDrag);
  sums.drag_moment += vector(S::kDragMoment);
  for (int row = 0, entry = S::kDragSecond; row < 3; ++row)
    for (int column = 0; column <= row; ++column, ++entry) {
      sums.drag_second(row, column) += value(entry);
      if (column != row) sums.drag_second(column, row) += value(entry);
    }
  sums.area += value(S::kArea);
  sums.deepest = std::max(sums.deepest, static_cast<double>(totals.deepest));
  sums.touching += static_cast<int>(value(S::kCount));
}

CutResult erode(CutObject& object, const NearBricks& near, const ContactInput& in) noexcept {
  CutResult result;
  const ToolModel& tool = *in.tool;
  if (object.isFrozen() || tool.cut.isEmpty() || (!in.geometry_only && in.speed == 0)) return result;
  const double h = object.voxel(), slack = tool.cut.slack();
  const Eigen::Matrix3d to_tool = in.T_object_tool.rotation.toRotationMatrix().transpose();
  const Rates rates(in);
  float x[kBrickNodes], y[kBrickNodes], z[kBrickNodes], tau[kBrickNodes], rate[kBrickNodes], next[kBrickNodes];
  internal::RelaxInput relax;
  relax.x = x;
  relax.y = y;
  relax.z = z;
  relax.tau = tau;
  relax.lever = leverForm(tool.motion);
  relax.geometry_only = in.geometry_only;
  // Air is air: values rise to the end of the band that was baked around the surface, and no further.
  relax.cap = object.baked().phi0().background();
  relax.least_radius = kEquatorFloor * static_cast<float>(tool.equator_mm);
  relax.pivot = static_cast<float>(tool.pivot_mm);
  for (std::size_t b = 0; b < near.size(); ++b) {
    const int s = near.slot(b);
    CutObject::Slot& slot = object.slot(s);
    if (object.odometer < slot.sleeps_until_cut || near.leastCut(b) >= -slot.least) continue;
    const internal::BrickToTool map(to_tool, in.T_object_tool.translation, slot.brick, h);
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
    if (!object.carve(s, next, relaxed_to.least, result.removed_mm3)) {
      result.pool_ran_out = true;
      break;
    }
    ++result.bricks;
  }
  return result;
}

FillResult fill(CutObject& object, const ContactInput& in, Material material) noexcept {
  FillResult result;
  const ToolField& tool = in.tool->cut;
  if (object.isFrozen() || tool.isEmpty()) return result;
  const double h = object.voxel(), e = kShellHalfWidth * h, cell = h * h * h;
  const float background = object.baked().phi0().background(), interior = object.baked().phi0().interior();
  const Rigid3& T = in.T_object_tool;
  const Eigen::Matrix3d to_tool = T.rotation.toRotationMatrix().transpose();
  Box3 box;
  const Box3& b = tool.bounds();
  for (int c = 0; c < 8; ++c)
    box.add(T * Vec3d((c & 1 ? b.max : b.min)[0], (c & 2 ? b.max : b.min)[1], (c & 4 ? b.max : b.min)[2]));
  box.grow(static_cast<double>(background));
  // The outermost layer of the directory stays air.
  const Vec3i first = object.baked().directoryLow() + Vec3i::Ones();
  const Vec3i last = object.baked().directoryLow() + object.baked().directorySize() - Vec3i::Constant(2);
  const auto brickAt = [&](const Vec3d& p) -> Vec3i {
    const Vec3d at = (p / (8 * h)).array().floor();
    return at.cwiseMax((first - Vec3i::Ones()).cast<double>())
        .cwiseMin((last + Vec3i::Ones()).cast<double>())
        .cast<int>();
  };
  const Vec3i low = brickAt(box.min), high = brickAt(box.max);
  const double brick_radius = 0.5 * std::sqrt(3.0) * 7 * h + tool.slack();
  float x[kBrickNodes], y[kBrickNodes], z[kBrickNodes], tau[kBrickNodes], next[kBrickNodes];
  for (int i = low[0]; i <= high[0]; ++i)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int k = low[2]; k <= high[2]; ++k) {
        const Vec3i brick(i, j, k);
        const Vec3d middle = h * (8 * brick.cast<double>() + Vec3d::Constant(3.5));
        const Vec3f q = (to_tool * (middle - T.translation)).cast<float>();
        const double least = static_cast<double>(tool.distance(q)) - brick_radius;
        if (least >= static_cast<double>(background)) continue;
        if ((brick.array() < first.array()).any() || (brick.array() > last.array()).any()) {
          result.is_clipped |= least < 0;
          continue;
        }
        int s = object.find(brick);
        const float* phi = s < 0 ? object.baked().outsideBrick() : object.slot(s).phi;
        const internal::BrickToTool map(to_tool, T.translation, brick, h);
        internal::placeNodes(map.base, map.along, x, y, z);
        tool.distances(x, y, z, tau, kBrickNodes);
        bool changes = false;
        for (int n = 0; n < kBrickNodes; ++n) {
          next[n] = std::min(phi[n], std::max(tau[n], interior));
          changes |= next[n] != phi[n];
        }
        if (!changes) continue;
        if (s < 0) s = object.addAir(brick);
        if (s < 0) {
          result.is_clipped = true;
          continue;
        }
        CutObject::Slot& slot = object.slot(s);
        const std::uint8_t faces = slot.changed_faces;
        float* own = object.write(s);
        if (!own) {
          result.pool_ran_out = true;
          continue;
        }
        slot.changed_faces = faces | facesThatDiffer(own, next);
        const auto number = static_cast<std::uint8_t>(material);
        for (int n = 0; n < kBrickNodes; ++n) {
          if (next[n] == own[n] || static_cast<double>(next[n]) >= e) continue;
          const double before = cell * insidePart(own[n], e), after = cell * insidePart(next[n], e);
          result.added_mm3 += after - before;
          const std::uint8_t was = slot.materials[n];
          if (own[n] >= 0 && was != number) object.writeMaterials(s)[n] = number;
          object.added_mm3[was] -= before;
          object.added_mm3[slot.materials[n]] += after;
        }
        std::memcpy(own, next, sizeof next);
        slot.least = *std::min_element(next, next + kBrickNodes);
        slot.sleeps_until_contact = slot.sleeps_until_cut = -1;
        ++result.bricks;
      }
  return result;
}

}  // namespace kerf
