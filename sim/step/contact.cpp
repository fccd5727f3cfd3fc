#include "sim/step/contact.h"

#include <algorithm>
#include <cmath>

#include "sim/step/contact_sums.h"
#include "sim/step/erosion_rates.h"
#include "sim/step/touching_shell.h"

namespace kerf {
namespace {

Eigen::Matrix3d crossMatrix(const Vec3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

// Sums the nodes of one object that overlap the tool. Gathers nodes of any brick until there are enough for the vector
// loops: tau one step further inwards, for its slope, and the sums themselves.
class NodeSums {
 public:
  NodeSums(const CutObject& object, const ContactInput& in)
      : tissues_(*in.tissues),
        tool_(*in.tool),
        drag_factor_(static_cast<float>(in.tool->drive.drag_factor)),
        inwards_(static_cast<float>(0.2 * object.voxel())),
        beyond_(static_cast<float>(0.5 * object.voxel())),
        share_(static_cast<float>(in.cut_share)),
        rates_(in) {
    const Eigen::Matrix3d to_object = in.T_object_tool.rotation.toRotationMatrix();
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) to_tool_[row][column] = static_cast<float>(to_object(column, row));
    moving_.lever = internal::leverOf(tool_);
    moving_.lips = internal::lipsOf(in);
    moving_.speed = static_cast<float>(std::abs(in.speed));
    moving_.still_speed = static_cast<float>(kStillSpeed);
    moving_.body_spins = tool_.motion == ToolMotion::kSpin;
    moving_.geometry_only = in.geometry_only;
    moving_.is_at_rest = isAtRest(tool_, in.speed);
    moving_.area_scale = static_cast<float>(in.area_scale);
    moving_.beyond = beyond_;
    moving_.is_blade = tool_.flank_axis >= 0;
    for (int c = 0; c < 3; ++c) {
      moving_.across[c] = moving_.is_blade ? to_tool_[tool_.flank_axis][c] : 0;
      moving_.velocity[c] = static_cast<float>(in.velocity[c]);
      moving_.angular[c] = static_cast<float>(in.angular[c]);
    }
  }

  void add(const internal::TouchingNode& node) {
    any_body_ |= node.body_is_near;
    any_cut_ |= share_ > 0 && node.tau_cut + node.phi < 0;
    const auto i = static_cast<std::size_t>(found_.count);
    phi_[i] = node.phi;
    tau_[i] = node.tau;
    for (int c = 0; c < 3; ++c) {
      found_.normal[c][i] = node.area_vector[c];  // until flush()
      found_.from_tip[c][i] = static_cast<float>(node.from_tip[c]);
      found_.in_tool[c][i] = node.in_tool[c];
    }

    const Tissue& tissue = tissues_[node.material];
    found_.overlap[i] = -node.gap;
    found_.into_cut[i] = std::max(0.0f, -node.tau_cut - node.phi);
    found_.area[i] = node.area;
    found_.stiffness[i] = tissue.stiffness;
    found_.friction[i] = drag_factor_ * tissue.friction;
    found_.rate[i] = rates_.value[node.material];
    if (moving_.lips.height > 0) {
      found_.lip_rate[i] = rates_.at_lips[node.material];
      if (node.in_tool[2] < moving_.lips.height)
        found_.friction[i] = static_cast<float>(tool_.lips.drag_factor) * tissue.friction;
    }
    area_of_[node.material] += node.area;
    if (++found_.count == kGather) flush();
  }

  // Sums the gathered nodes; called once more at the end.
  void flush() {
    if (found_.count == 0) return;
    const int padded = pad();
    found_.count = padded;
    internal::turnTouching(phi_, to_tool_, inwards_, any_cut_ ? beyond_ : 0, found_, places_);

    lookUp(tool_.cut, places_.inwards, cut_in_);
    if (any_body_) lookUp(tool_.body, places_.inwards, body_in_);
    for (std::size_t n = 0; n < static_cast<std::size_t>(padded); ++n)
      found_.slope[n] = ((any_body_ ? std::min(cut_in_[n], body_in_[n]) : cut_in_[n]) - tau_[n]) / inwards_;

    moving_.cut_share = any_cut_ ? share_ : 0;
    if (any_cut_) lookUp(tool_.cut, places_.beyond, found_.tau_beyond);
    any_cut_ = false;
    internal::sumTouching(found_, moving_, totals_);
    found_.count = 0;
    any_body_ = false;
  }

  void addTo(ContactSums& sums) const {
    addMaterial(sums);
    addTotals(sums);
  }

 private:
  static constexpr int kGather = ShellChunk::kNodes;
  static_assert(kGather == internal::TouchingNodes::kMost);

  using Row = internal::TouchingNodes::Row;

  // The tool's distances at the places of all nodes.
  void lookUp(const ToolField& field, const Row (&at)[3], Row& out) const {
    field.distances(at[0].data(), at[1].data(), at[2].data(), out.data(), found_.count);
  }

  // Fills up to a multiple of 8 with nodes without stiffness. Returns that multiple.
  int pad() {
    const int count = found_.count, padded = (count + 7) / 8 * 8;
    const auto clear = [&](auto& row) {
      for (auto n = static_cast<std::size_t>(count); n < static_cast<std::size_t>(padded); ++n) row[n] = 0;
    };
    clear(phi_);
    clear(tau_);
    clear(found_.overlap);
    clear(found_.into_cut);
    clear(found_.area);
    clear(found_.stiffness);
    clear(found_.friction);
    clear(found_.rate);
    if (moving_.lips.height > 0) clear(found_.lip_rate);
    for (int c = 0; c < 3; ++c) {
      clear(found_.normal[c]);
      clear(found_.from_tip[c]);
      clear(found_.in_tool[c]);
    }
    return padded;
  }

  void addMaterial(ContactSums& sums) const {
    for (std::size_t m = 0; m < area_of_.size(); ++m)
      if (static_cast<double>(area_of_[m]) > sums.material_area) {
        sums.material_area = static_cast<double>(area_of_[m]);
        sums.material = static_cast<std::uint8_t>(m);
      }
  }

  void addTotals(ContactSums& sums) const {
    using S = internal::TouchingSums;
    const auto value = [&](int at) { return totals_.value[static_cast<std::size_t>(at)]; };
    const auto vector = [&](int at) { return Vec3d(value(at), value(at + 1), value(at + 2)); };
    // A symmetric matrix from its lower triangle.
    const auto addSymmetric = [&](auto& matrix, int entry) {
      for (int row = 0; row < matrix.rows(); ++row)
        for (int column = 0; column <= row; ++column, ++entry) {
          matrix(row, column) += value(entry);
          if (column != row) matrix(column, row) += value(entry);
        }
    };

    sums.force += vector(S::kForce);
    sums.torque += vector(S::kTorque);
    sums.force_next += vector(S::kForceNext);
    sums.torque_next += vector(S::kTorqueNext);
    addSymmetric(sums.stiffness, S::kStiffness);
    sums.load_next += value(S::kLoadNext);
    for (int row = 0; row < 6; ++row) sums.load_slope[row] += value(S::kLoadSlope + row);

    sums.normal_load += value(S::kNormalLoad);
    sums.cutting_load += value(S::kCuttingLoad);
    sums.erodible_load += value(S::kErodibleLoad);
    sums.bare_load += value(S::kBareLoad);
    sums.bare_erodible += value(S::kBareErodible);
    sums.bare_drive_load += value(S::kBareDriveLoad);
    sums.cut_by_shell += value(S::kCutByShell);
    sums.lip_torque += value(S::kLipTorque);
    sums.drive_load += value(S::kDriveLoad);
    sums.power += value(S::kPower);

    sums.drag += value(S::kDrag);
    sums.drag_moment += vector(S::kDragMoment);
    addSymmetric(sums.drag_second, S::kDragSecond);
    if (moving_.is_at_rest) addSymmetric(sums.normal_drag, S::kNormalDrag);

    sums.area += value(S::kArea);
    sums.deepest = std::max(sums.deepest, static_cast<double>(totals_.deepest));
    sums.touching += static_cast<int>(value(S::kCount));
  }

  const TissueTable& tissues_;
  const ToolModel& tool_;
  const float drag_factor_;
  const float inwards_;  // step of the directional derivative of tau, mm
  const float beyond_;   // step into the tool from the surface, mm
  const float share_;    // ContactInput::cut_share
  float to_tool_[3][3];  // by rows: from object axes to the tool's
  const internal::ErosionRates rates_;
  internal::TouchingTool moving_;
  internal::TouchingSums totals_;
  std::array<float, 256> area_of_{};
  internal::TouchingNodes found_;
  internal::TouchingPlaces places_;
  Row phi_, tau_, cut_in_, body_in_;  // of found_; the last two at places_.inwards
  bool any_body_ = false, any_cut_ = false;
};

}  // namespace

bool isAtRest(const ToolModel& tool, double speed) noexcept {
  const double lever = tool.motion == ToolMotion::kStroke ? 1 : tool.cut.reach() + std::abs(tool.pivot_mm);
  return std::abs(speed) * lever < kStillSpeed;
}

void ContactSums::add(const ContactSums& o) {
  force += o.force;
  torque += o.torque;
  force_next += o.force_next;
  torque_next += o.torque_next;
  stiffness += o.stiffness;
  load_next += o.load_next;
  load_slope += o.load_slope;
  drag += o.drag;
  drag_moment += o.drag_moment;
  drag_second += o.drag_second;
  normal_drag += o.normal_drag;
  normal_load += o.normal_load;
  cutting_load += o.cutting_load;
  lip_torque += o.lip_torque;
  drive_load += o.drive_load;
  power += o.power;
  erodible_load += o.erodible_load;
  bare_load += o.bare_load;
  cut_by_shell += o.cut_by_shell;
  bare_erodible += o.bare_erodible;
  bare_drive_load += o.bare_drive_load;
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
  force_next *= factor;
  torque_next *= factor;
  stiffness *= factor;
  load_next *= factor;
  load_slope *= factor;
  drag *= factor;
  drag_moment *= factor;
  drag_second *= factor;
  normal_drag *= factor;
  normal_load *= factor;
  cutting_load *= factor;
  erodible_load *= factor;
  bare_load *= factor;
  bare_erodible *= factor;
  bare_drive_load *= factor;
  lip_torque *= factor;
  drive_load *= factor;
  power *= factor;
}

ContactSums ContactSums::rotated(const Eigen::Matrix3d& r) const {
  ContactSums out = *this;
  out.force = r * force;
  out.torque = r * torque;
  out.force_next = r * force_next;
  out.torque_next = r * torque_next;
  for (Matrix6d ContactSums::*matrix : {&ContactSums::stiffness, &ContactSums::normal_drag})
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j)
        (out.*matrix).block<3, 3>(3 * i, 3 * j) = r * (this->*matrix).block<3, 3>(3 * i, 3 * j) * r.transpose();
  out.load_slope << r * load_slope.head<3>(), r * load_slope.tail<3>();
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
  if (speed != 0) out.torque -= sums.lip_torque * (pose.rotation * Vec3d(0, 0, -std::copysign(1.0, speed)));
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

void sumContact(CutObject& object, const NearBricks& near, const ContactInput& in, ContactSums& sums) noexcept {
  NodeSums nodes(object, in);
  sums.tested += internal::forEachTouching(object, near, *in.tool, in.T_object_tool,
                                           [&](const internal::TouchingNode& node) { nodes.add(node); });
  nodes.flush();
  nodes.addTo(sums);
}

}  // namespace kerf
