// Contact of one tool with one object: which bricks are near, what force their nodes make, what the cut takes off.
//
// All functions are @rt: no allocation, lock, exception or system call; results depend on the state alone. Quantities
// are in the object's frame, torques and moments about the tool's tip.
#pragma once

#include <Eigen/Core>

#include "sim/object/cut_object.h"
#include "sim/step/device_sample.h"
#include "sim/step/one_sided_loads.h"
#include "sim/step/tissue.h"
#include "sim/step/tool_model.h"

namespace kerf {

/// mm/s: slower sliding drags as if it were this. At rest friction holds: advance().
inline constexpr double kStillSpeed = 0.5;
/// The drive moves no part of the tool that fast. @rt
bool isAtRest(const ToolModel& tool, double speed) noexcept;

/// What one evaluation needs to know of tool and time.
struct ContactInput {
  const ToolModel* tool = nullptr;
  const TissueTable* tissues = nullptr;
  Rigid3 T_object_tool;            ///< mm
  double speed = 0;                ///< of the drive now: see ToolDrive::speed; negative: backwards
  double dt = kTick;               ///< s
  bool geometry_only = false;      ///< the cutting part takes what it sweeps, without resistance
  Vec3d velocity = Vec3d::Zero();  ///< of the tip relative to the object, mm/s, without the tool's own motion
  Vec3d angular = Vec3d::Zero();   ///< rad/s
  double load_scale = 1;           ///< of the pressure that erodes: see erosionScale()
  double area_scale = 1;           ///< of the areas of nodes that are cut: CutArea
  /// How far areas, normals and levers of what cuts are those of its faces, 0 to 1: CutArea.
  double cut_share = 0;
};

/// Sums over the nodes in contact. A node overlaps the tool by d = max(0, -tau - phi), mm. Its pressure is p = k_n d g,
/// N/mm^2, k_n Tissue::stiffness; g = (1 - exp(-c dt)) / (c dt) is the mean over the evaluation of an overlap that
/// erodes, c as in erode(). With the node's area vector w the force is the sum of p w, weighted by how much the node
/// faces the tool: see sumContact(). Friction makes mu p A.
struct ContactSums {
  Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();            ///< N, N mm, of the pressure, on the tool
  Vec3d force_next = Vec3d::Zero(), torque_next = Vec3d::Zero();  ///< of the next evaluation, if the tool stays
  /// -d(force_next, torque_next) / d(translation, rotation), symmetric, positive semi-definite: sum k_n g A u u^T with
  /// u = (n, r x n); g = 1 where nothing cuts.
  Matrix6d stiffness = Matrix6d::Zero();
  /// Drag on the tool is -(drag * twist) of its motion plus the part of its own motion: sums of mu p A over the surface
  /// speed, with their first and second moments about the tip.
  double drag = 0;                                        ///< N s/mm
  Vec3d drag_moment = Vec3d::Zero();                      ///< N s
  Eigen::Matrix3d drag_second = Eigen::Matrix3d::Zero();  ///< N s mm
  /// At rest: the part of dragMatrix() that is of motion along the normals, the sum of drag u u^T; else zero.
  Matrix6d normal_drag = Matrix6d::Zero();
  /// Normal load of the next evaluation, if the tool stays, N; and how it falls as the tool moves along (translation,
  /// rotation): sum k_n g A u.
  double load_next = 0;
  Vector6d load_slope = Vector6d::Zero();
  double normal_load = 0;    ///< N = integral of p dA, N: what the removal rate is proportional to
  double cutting_load = 0;   ///< the part of it on what cuts
  double erodible_load = 0;  ///< that part with g = 1: before this tick's erosion
  /// The same three for all of what cuts, whichever way it faces: erosion asks for no facing either.
  double bare_load = 0, bare_erodible = 0;  ///< N
  double bare_drive_load = 0;               ///< N mm (kStroke: N)
  double cut_by_shell = 0;       ///< what erodes by the areas of the nodes that face the tool, unscaled, mm^3
  double lip_torque = 0;         ///< N mm: of a drill's lips, about its axis, whichever way it leans
  double drive_load = 0;         ///< of the spindle, N mm (kStroke: N): sum of mu p A times the lever
  double power = 0;              ///< sum mu p A v_s, N mm/s: what the drive spends
  double area = 0;               ///< touched, mm^2
  double deepest = 0;            ///< largest overlap, mm
  int tested = 0, touching = 0;  ///< nodes
  std::uint8_t material = 0;     ///< number of the one with most of the area
  double material_area = 0;      ///< mm^2

  void add(const ContactSums& other);
  /// All that grows with the pressure, times a factor; area, nodes and depth stay.
  void scale(double factor);
  /// The same sums in the axes that R turns theirs into.
  ContactSums rotated(const Eigen::Matrix3d& R) const;
  /// drag as a 6 x 6 matrix over (translation, rotation).
  Matrix6d dragMatrix() const;
};

/// Drag on the tool by its own motion, about the tip. A stroke or swing goes to and fro: its mean is zero, what stays
/// is that friction along the feed is small beside it.
/// @param sums  in the frame of `pose`.   @param speed  of the drive. @rt
Wrench ownDrag(const ToolModel& tool, const Rigid3& pose, double speed, const ContactSums& sums) noexcept;

/// Bricks a tool may touch or cut, found once per evaluation.
class NearBricks {
 public:
  explicit NearBricks(std::size_t capacity = 1 << 16);
  /// Bricks within the object's band of the tool. Hierarchical: bounding box, blocks of 4^3 bricks, bricks.
  /// Returns false if there are more than the capacity: the rest is left out.
  bool find(const CutObject& object, const ToolModel& tool, const Rigid3& T_object_tool) noexcept;
  /// Becomes those of another list whose slot is wanted(slot). @pre its capacity is no greater than this one's. @rt
  template <class Wanted>
  void take(const NearBricks& from, const Wanted& wanted) noexcept {
    count_ = 0;
    for (std::size_t n = 0; n < from.count_; ++n) {
      if (!wanted(from.slots_[n])) continue;
      slots_[count_] = from.slots_[n];
      cut_[count_] = from.cut_[n];
      body_[count_] = from.body_[n];
      ++count_;
    }
  }
  std::size_t size() const { return count_; }
  int slot(std::size_t n) const { return slots_[n]; }
  /// Lower bounds of the tool's distances in that brick, mm.
  float leastCut(std::size_t n) const { return cut_[n]; }
  float leastBody(std::size_t n) const { return body_[n]; }
  float leastAny(std::size_t n) const { return std::min(cut_[n], body_[n]); }

 private:
  std::vector<int> slots_;
  std::vector<float> cut_, body_;
  std::size_t count_ = 0;
};

/// Force of the shell's nodes. A node counts by its facing weight clamp(2 n . grad tau, 0, 1), n the inward normal: the
/// far side of a thin wall does not push the tool through.
void sumContact(CutObject& object, const NearBricks& near, const ContactInput& in, ContactSums& sums) noexcept;

struct CutResult {
  double removed_mm3 = 0;
  int bricks = 0;
  bool pool_ran_out = false;
};
/// phi += d (1 - exp(-c dt)) with d = max(0, -tau_cut - phi) and the rate c = mu k_n v_s / (u_s f), f the tool's energy
/// factor, mu that of the material times the tool's drag factor, v_s the surface speed at the node: the surface relaxes
/// towards the tool. At the lips of a drill: DrillLips. Geometry only: c is infinite. Updates the ledger; shells are
/// repaired by CutObject::repair.
CutResult erode(CutObject& object, const NearBricks& near, const ContactInput& in) noexcept;

struct FillResult {
  double added_mm3 = 0;
  int bricks = 0;
  bool pool_ran_out = false;
  /// Something was not added: to air farther out than kAirAround, or beyond CutObject::kMostAdded bricks of air.
  bool is_clipped = false;
};
/// Adds material where the cutting part of the tool is: phi = min(phi, tau). Nodes that were outside and to which the
/// added surface is now the nearest become `material`. Updates the ledger; shells are repaired by CutObject::repair.
FillResult fill(CutObject& object, const ContactInput& in, Material material) noexcept;

}  // namespace kerf
