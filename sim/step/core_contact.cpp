#include "sim/step/core_contact.h"

#include <algorithm>
#include <cmath>

#include "sim/step/contact_evaluation.h"
#include "sim/step/drive.h"
#include "sim/step/erosion_rates.h"

namespace kerf {
namespace {

constexpr double kShareOut = 0.4;   // of a point's radius: least distance from the surface
constexpr double kBlur = 0.7;       // voxels: error of the field in a narrow hole, or at the end of its band
constexpr double kBlurAtTip = 0.5;  // voxels: thin parts lean on a face, or at most an edge
constexpr double kBlurAtLips = 1;   // voxels: a drill pushed beyond its greatest feed leans on its core
constexpr double kStiffArea = 1.5;  // mm^2: K over the contact stiffness of the material
constexpr double kHardest = 300;    // N/mm: K of hard tissue, at which softer tissue stops a tool at rest
constexpr double kGives = 0.1;      // mm below the surface, for that stop
constexpr double kClear = 0.05;     // mm: a core pressed in by less counts as outside
constexpr double kNodeReach = 0.9;  // voxels from a place to its nearest node, and a little
constexpr double kNoSlope = 1e-3;   // deep inside, where all values are equal, there is no way out
constexpr double kSettled = 1e-6;   // of the largest load

// The values of an object's nodes. Caches the last brick.
class Nodes {
 public:
  explicit Nodes(const CutObject& object) : object_(object), outside_(object.baked().phi0().background()) {}

  double phi(const Vec3i& node) {
    const BrickSlot* slot = slotOf(node);
    return slot ? static_cast<double>(slot->phi[offsetOf(node)]) : static_cast<double>(outside_);
  }
  // Least value of the eight nodes around a place.
  double leastAround(const Vec3d& in_voxels) {
    const Vec3i corner = in_voxels.array().floor().cast<int>();
    double least = static_cast<double>(outside_);
    for (int n = 0; n < 8; ++n) least = std::min(least, phi(corner + Vec3i(n >> 2, n >> 1 & 1, n & 1)));
    return least;
  }
  std::uint8_t material(const Vec3i& node) {
    const BrickSlot* slot = slotOf(node);
    return slot ? slot->materials[offsetOf(node)] : std::uint8_t{0};
  }

 private:
  static std::size_t offsetOf(const Vec3i& node) {
    return static_cast<std::size_t>((node[0] & 7) << 6 | (node[1] & 7) << 3 | (node[2] & 7));
  }
  const BrickSlot* slotOf(const Vec3i& node) {
    const Vec3i brick(node[0] >> 3, node[1] >> 3, node[2] >> 3);
    if (!is_known_ || brick != brick_) {
      const int s = object_.find(brick);
      slot_ = s < 0 ? nullptr : &object_.slot(s);
      brick_ = brick;
      is_known_ = true;
    }
    return slot_;
  }

  const CutObject& object_;
  const float outside_;
  Vec3i brick_ = Vec3i::Zero();
  const BrickSlot* slot_ = nullptr;
  bool is_known_ = false;
};

Vec3i nearestNode(const Vec3d& in_voxels) { return (in_voxels.array() + 0.5).floor().cast<int>(); }

struct SmoothDistance {
  double phi = 0;
  Vec3d gradient = Vec3d::Zero();
};

// Quadratic B-splines: weights of the node before, at and after, t in [-0.5, 0.5] from the one at; and their slopes.
SmoothDistance smoothDistance(Nodes& nodes, const Vec3d& in_voxels, const Vec3i& middle, double voxel) {
  double weight[3][3], slope[3][3];
  for (int c = 0; c < 3; ++c) {
    const double t = in_voxels[c] - middle[c];
    weight[c][0] = 0.5 * (0.5 - t) * (0.5 - t);
    weight[c][1] = 0.75 - t * t;
    weight[c][2] = 0.5 * (0.5 + t) * (0.5 + t);
    slope[c][0] = t - 0.5;
    slope[c][1] = -2 * t;
    slope[c][2] = t + 0.5;
  }
  SmoothDistance out;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      for (int z = 0; z < 3; ++z) {
        const double phi = nodes.phi(middle + Vec3i(x - 1, y - 1, z - 1));
        out.phi += phi * weight[0][x] * weight[1][y] * weight[2][z];
        out.gradient[0] += phi * slope[0][x] * weight[1][y] * weight[2][z];
        out.gradient[1] += phi * weight[0][x] * slope[1][y] * weight[2][z];
        out.gradient[2] += phi * weight[0][x] * weight[1][y] * slope[2][z];
      }
  out.gradient /= voxel;
  return out;
}

// Own surface speed at a core point, with the lever of the shell under it: for a bur the ball's own radius.
double ownSpeed(const ToolModel& tool, const CorePoint& point, double speed) {
  if (!point.cuts && tool.motion != ToolMotion::kSpin) return 0;
  const internal::Lever lever = internal::leverOf(tool);
  switch (lever.form) {
    case internal::LeverForm::kRadius:
      return std::abs(speed) * static_cast<double>(std::max(point.radius, lever.least_radius));
    case internal::LeverForm::kPivot:
      return std::abs(speed) * static_cast<double>(std::hypot(point.place[0], point.place[2] - lever.pivot));
    case internal::LeverForm::kOne:
      break;
  }
  return std::abs(speed);
}

}  // namespace

void CoreDrag::addTo(ContactSums& sums) const {
  sums.drag += drag;
  sums.drag_moment += moment;
  sums.drag_second += second;
  sums.normal_drag += normal;
}

void CoreContact::gather(CutObject& object, std::size_t number, const ContactInput& in, double way_mm) noexcept {
  const ToolModel& tool = *in.tool;
  const double h = object.voxel(), band = static_cast<double>(object.baked().phi0().background());
  const Eigen::Matrix3d to_object = in.T_object_tool.rotation.toRotationMatrix();
  const Eigen::Matrix3d to_world = object.T_world_object.rotation.toRotationMatrix();
  const double drag_factor = in.tool->drive.drag_factor;
  Nodes nodes(object);
  const double blur = (tool.lips.areThere() ? kBlurAtLips : kBlur) * h;
  const auto allowedOf = [&](const CorePoint& point) {
    const auto radius = static_cast<double>(point.radius);
    if (point.is_thin) return radius - kBlurAtTip * h;
    return std::min({kShareOut * radius, radius - blur, band - kBlur * h});
  };

  const auto stopOf = [&](const CorePoint& point) { return std::min(allowedOf(point), 0.0) - kGives; };

  // At rest all points hold; points that are not thin hold at their stop.
  const auto isOutside = [&](bool at_rest) {
    return std::all_of(tool.core.begin(), tool.core.end(), [&](const CorePoint& point) {
      if (point.is_thin && !at_rest) return true;
      const Vec3d at = (to_object * point.place.cast<double>() + in.T_object_tool.translation) / h;
      const Vec3i middle = nearestNode(at);
      const double held_at = at_rest && !point.is_thin ? stopOf(point) : allowedOf(point);
      const double there = nodes.phi(middle), least = held_at - kClear;
      if (std::abs(there - least) > kNodeReach * h) return there > least;
      return smoothDistance(nodes, at, middle, h).phi > least;
    });
  };
  object.is_core_clear = object.is_core_clear || isOutside(false);
  if (!object.is_core_clear) return;
  const bool is_at_rest = std::abs(in.speed) <= kAtRest * tool.drive.speed;
  object.is_tip_clear = is_at_rest && (object.is_tip_clear || isOutside(true));

  for (const CorePoint& point : tool.core) {
    if ((in.geometry_only && point.cuts) || (point.is_thin && !object.is_tip_clear)) continue;
    const Vec3d lever = to_object * point.place.cast<double>();
    const Vec3d in_voxels = (lever + in.T_object_tool.translation) / h;
    const Vec3i middle = nearestNode(in_voxels);
    const auto radius = static_cast<double>(point.radius);
    const double allowed = allowedOf(point);

    // Distances change no faster than the place: this test rejects most points. If a place is within the band, so is a
    // corner of its cell, though maybe not its nearest node.
    const double there = nodes.phi(middle);
    if (there > allowed + way_mm + kNodeReach * h) continue;
    if (there >= band && nodes.leastAround(in_voxels) >= band) continue;
    const SmoothDistance found = smoothDistance(nodes, in_voxels, middle, h);
    const double slope = found.gradient.norm();
    if (found.phi >= allowed + way_mm || slope < kNoSlope) continue;

    const Vec3d normal = found.gradient / std::max(slope, 1.0);
    const Vec3d touch = lever - radius / slope * found.gradient;
    const Vec3i inside = nearestNode(in_voxels - (found.phi / h + 0.5) / slope * found.gradient);
    Row row;
    row.material = nodes.material(inside);
    const Tissue& tissue = (*in.tissues)[row.material];
    row.lever = to_world * lever;
    row.touch = to_world * touch;
    row.clearance = found.phi - allowed;
    row.stiffness = kStiffArea * static_cast<double>(tissue.stiffness);
    row.friction = drag_factor * static_cast<double>(tissue.friction);
    row.slope = std::min(slope, 1.0);
    row.own_speed = ownSpeed(tool, point, in.speed);
    row.object = number;
    row.cuts = point.cuts;

    const Vec3d push = to_world * normal;
    add(row, push);

    row.clearance = found.phi - stopOf(point);
    row.stiffness = kHardest - row.stiffness;
    if (object.is_tip_clear && row.stiffness > 0 && row.clearance < way_mm) add(row, push);
  }
}

// Keeps the deepest points, with equal depth the earlier one.
void CoreContact::add(const Row& row, const Vec3d& push) noexcept {
  std::size_t at = count_;
  if (count_ == kMost) {
    at = 0;
    for (std::size_t n = 1; n < kMost; ++n)
      if (rows_[n].clearance >= rows_[at].clearance) at = n;
    if (row.clearance >= rows_[at].clearance) return;
  } else {
    ++count_;
  }
  rows_[at] = row;
  directions_[at] << push, row.lever.cross(push);
}

Vector6d CoreContact::solve(const Matrix6d& a, const Vector6d& b, double dt) noexcept {
  OneSidedLoads::Row least, softness;
  for (std::size_t n = 0; n < count_; ++n) {
    least[n] = -rows_[n].clearance / dt;
    softness[n] = 1 / (dt * dt * rows_[n].stiffness);
  }
  per_s_ = 1 / dt;
  loads_.load.fill(0);
  loads_.solve(a, b, std::span(directions_).first(count_), least, softness, kSettled);
  return loads_.motion;
}

double CoreContact::normalLoad(std::size_t n) const { return per_s_ * loads_.load[n] * rows_[n].slope; }

double CoreContact::cuttingLoad(std::size_t number) const {
  double sum = 0;
  for (std::size_t n = 0; n < count_; ++n)
    if (rows_[n].object == number && rows_[n].cuts) sum += normalLoad(n);
  return sum;
}

std::uint64_t CoreContact::countTouched(ContactSums& sums) const {
  std::uint64_t objects = 0;
  for (std::size_t n = 0; n < count_; ++n) {
    if (!(loads_.load[n] > 0)) continue;
    objects |= objectBit(rows_[n].object);
    if (sums.touching++ == 0) sums.material = rows_[n].material;
  }
  return objects;
}

CoreDrag CoreContact::drag(const ToolBody& body) const {
  CoreDrag out;
  for (std::size_t n = 0; n < count_; ++n) {
    const double normal = normalLoad(n);
    if (!(normal > 0)) continue;
    const Row& row = rows_[n];
    const double sliding = (body.velocity + body.angular.cross(row.touch)).norm();
    const double drag = row.friction * normal / std::max({row.own_speed, sliding, kStillSpeed});
    out.drag += drag;
    out.moment += drag * row.touch;
    out.second += drag * row.touch * row.touch.transpose();
    if (row.own_speed < kStillSpeed)
      out.normal += drag / directions_[n].head<3>().squaredNorm() * directions_[n] * directions_[n].transpose();
  }
  return out;
}

double shareCoreLoad(double core_load, double speed, ContactSums& sums) noexcept {
  if (!(core_load > 0)) return 1;
  sums.normal_load += core_load;
  sums.cutting_load += core_load;
  if (!(sums.bare_load > 0) || speed == 0) return 1;

  // The core's load rubs like the shell's: on the whole cutting part.
  const double lever = sums.bare_drive_load / sums.bare_load;
  sums.drive_load += core_load * lever;
  sums.power += core_load * lever * std::abs(speed);
  const double rate = relaxationRate(sums.bare_load, sums.bare_erodible);
  return std::max(1.0, erosionScale(sums.bare_load + core_load, rate, sums.bare_erodible));
}

}  // namespace kerf
