#include "sim/contact.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sim/internal/relax_brick.h"
#include "sim/internal/relaxation.h"

namespace kerf {
namespace {

constexpr int kBlock = 4;              // bricks along a side of a block
constexpr float kEquatorFloor = 0.2f;  // the axis of a bur does not stand still: of the equator's speed
constexpr double kStillSpeed = 0.5;    // mm/s: below it Coulomb friction fades, so that it can be integrated

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

// Speed of the tool's own surface at a point over ToolDrive::speed: a radius in mm for what turns, 1 for a stroke.
inline float lever(const ToolModel& tool, float x, float y, float z) {
  switch (tool.motion) {
    case ToolMotion::kSpin:
      return std::max(std::sqrt(x * x + y * y), kEquatorFloor * static_cast<float>(tool.equator_mm));
    case ToolMotion::kSwing: {
      const float up = z - static_cast<float>(tool.pivot_mm);
      return std::sqrt(x * x + up * up);
    }
    default:
      return 1;
  }
}

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
  const double own_speed = std::abs(in.speed);
  const bool has_body = !tool.body.isEmpty();
  const double slack = std::max(tool.cut.slack(), tool.body.slack());
  // Lower triangle of the stiffness, row by row: plain numbers, as the compiler likes them.
  std::array<double, 21> stiffness{};
  std::array<double, 256> area_of{};
  // Nodes that overlap the tool, gathered until there are enough of them to look a step further inwards.
  constexpr int kGather = ShellChunk::kNodes;
  struct Touching {
    int offset;
    std::uint8_t material;
    float overlap, into_cut, area;
    Vec3f normal;
  } touching[kGather];
  float px[kGather], py[kGather], pz[kGather], qx[kGather], qy[kGather], qz[kGather], phi[kGather];
  float cut[kGather], body[kGather], cut_in[kGather], body_in[kGather];
  std::fill_n(body, kGather, ToolField::kFar), std::fill_n(body_in, kGather, ToolField::kFar);
  for (std::size_t b = 0; b < near.size(); ++b) {
    CutObject::Slot& slot = object.slot(near.slot(b));
    if (slot.shell_count == 0 || object.odometer < slot.sleeps_until_contact || near.leastAny(b) >= -slot.least)
      continue;
    const BrickToTool map(to_tool, in.T_object_tool.translation, slot.brick, h);
    const Vec3d corner = h * 8 * slot.brick.cast<double>() - in.T_object_tool.translation;
    const bool body_is_near = has_body && near.leastBody(b) < -slot.least;
    // Until the first of its nodes touches: a body that was not looked at is known by its bound.
    float room = has_body && !body_is_near ? near.leastBody(b) + slot.least : ToolField::kFar;
    bool touches = false;
    for (int begin = 0; begin < slot.shell_count; begin += kGather) {
      const ShellChunk& chunk = *slot.chunks[static_cast<std::size_t>(begin / kGather)];
      const int count = std::min(kGather, slot.shell_count - begin), padded = (count + 7) / 8 * 8;
      internal::placeShell(map.base, map.along, chunk.offset.data(), slot.phi, padded, px, py, pz, phi);
      tool.cut.distances(px, py, pz, cut, padded);
      if (body_is_near) tool.body.distances(px, py, pz, body, padded);
      sums.tested += count;
      int found = 0;
      for (int n = 0; n < count; ++n) {
        const float gap = std::min(cut[n], body_is_near ? body[n] : ToolField::kFar) + phi[n];
        room = std::min(room, gap);
        if (gap >= 0) continue;
        const auto at = static_cast<std::size_t>(n);
        const Vec3f w(chunk.x[at], chunk.y[at], chunk.z[at]);
        const float area = w.norm();
        if (!(area > 0)) continue;
        Touching& t = touching[found];
        t.offset = chunk.offset[at], t.material = chunk.material[at], t.overlap = -gap,
        t.into_cut = std::max(0.0f, -cut[n] - phi[n]), t.area = area;
        t.normal = w / area;
        const Vec3f inwards = Vec3f(px[n], py[n], pz[n]) - look * (to_tool_f * t.normal);
        // found <= n: what is overwritten has been read
        qx[found] = inwards[0], qy[found] = inwards[1], qz[found] = inwards[2];
        px[found] = px[n], py[found] = py[n], pz[found] = pz[n], phi[found] = phi[n];
        ++found;
      }
      if (found == 0) continue;
      touches = true;
      const int padded_in = (found + 7) / 8 * 8;
      for (int n = found; n < padded_in; ++n) qx[n] = qy[n] = qz[n] = 0;
      tool.cut.distances(qx, qy, qz, cut_in, padded_in);
      if (body_is_near) tool.body.distances(qx, qy, qz, body_in, padded_in);
      for (int n = 0; n < found; ++n) {
        const Touching& t = touching[n];
        const float tau = -t.overlap - phi[n];
        const float slope = (std::min(cut_in[n], body_is_near ? body_in[n] : ToolField::kFar) - tau) / look;
        const float facing = std::min(std::max(2 * slope, 0.0f), 1.0f);
        if (facing <= 0) continue;
        const Tissue& tissue = (*in.tissues)[t.material];
        if (in.geometry_only && t.into_cut >= t.overlap) continue;  // gone before it could resist
        const float arm = lever(tool, px[n], py[n], pz[n]);
        const float x_rate = rates.value[t.material] * arm;
        const float part = relaxed(x_rate);
        const float mean_part = x_rate < 1e-6f ? 1.0f : part / x_rate;
        const auto mean = static_cast<double>(t.overlap - t.into_cut * (1 - mean_part));
        const auto after = static_cast<double>(t.overlap - t.into_cut * part);
        const double area = static_cast<double>(t.area);
        const double stiff = static_cast<double>(tissue.stiffness * facing) * area;  // N/mm
        const int at = t.offset;
        const Vec3d r = corner + h * Vec3d(at >> 6, at >> 3 & 7, at & 7);
        const Vec3d normal = t.normal.cast<double>(), turn = r.cross(normal);
        const double size = stiff * mean, size_after = stiff * after;
        sums.force += size * normal, sums.torque += size * turn;
        sums.force_after += size_after * normal, sums.torque_after += size_after * turn;
        const double u[6] = {normal[0], normal[1], normal[2], turn[0], turn[1], turn[2]};
        for (std::size_t row = 0, entry = 0; row < 6; ++row) {
          const double scaled = stiff * u[row];
          for (std::size_t column = 0; column <= row; ++column) stiffness[entry++] += scaled * u[column];
        }
        sums.normal_load += size;
        const double rubbing = tool.drive.drag_factor * static_cast<double>(tissue.friction) * size;
        // What only collides does not move by itself, but for a bur's neck and shank, which spin.
        double own = 0;
        if (t.into_cut > 0) sums.cutting_load += size;
        if (t.into_cut > 0 || tool.motion == ToolMotion::kSpin) {
          own = own_speed * static_cast<double>(arm);
          sums.drive_load += rubbing * static_cast<double>(arm), sums.power += rubbing * own;
        }
        const double feed = (in.velocity + in.angular.cross(r)).norm();
        const double drag = rubbing / std::max({own, feed, kStillSpeed});
        sums.drag += drag, sums.drag_moment += drag * r, sums.drag_second += drag * r * r.transpose();
        area_of[t.material] += area;
        sums.area += area, sums.deepest = std::max(sums.deepest, static_cast<double>(t.overlap));
        ++sums.touching;
      }
    }
    slot.sleeps_until_contact = touches ? -1 : object.odometer + static_cast<double>(room) - slack;
  }
  for (std::size_t m = 0; m < area_of.size(); ++m)
    if (area_of[m] > sums.material_area) sums.material_area = area_of[m], sums.material = static_cast<std::uint8_t>(m);
  for (Eigen::Index row = 0, entry = 0; row < 6; ++row)
    for (Eigen::Index column = 0; column <= row; ++column, ++entry) {
      sums.stiffness(row, column) += stiffness[static_cast<std::size_t>(entry)];
      if (column != row) sums.stiffness(column, row) += stiffness[static_cast<std::size_t>(entry)];
    }
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
    slot.changed_faces = faces | CutObject::facesThatDiffer(own, next);
    for (int n = 0; n < kBrickNodes; ++n) {
      if (next[n] == own[n] || own[n] >= half_width || next[n] <= -half_width) continue;
      const double gone = cell * (insidePart(own[n], e) - insidePart(next[n], e));
      object.removed_mm3[slot.materials[n]] += gone;
      result.removed_mm3 += gone;
    }
    std::memcpy(own, next, sizeof next);
    slot.least = relaxed_to.least;
    slot.sleeps_until_contact = -1;
    ++result.bricks;
  }
  return result;
}

}  // namespace kerf
