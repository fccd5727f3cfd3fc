// Contact of one tool with one object: nearby bricks, the force of their nodes, and the removed volume.
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

/// mm/s: slower sliding has the drag of this speed. At rest friction holds: advance().
inline constexpr double kStillSpeed = 0.5;
/// Whether the drive moves every part of the tool slower than that. @rt
bool isAtRest(const ToolModel& tool, double speed) noexcept;

/// Input of one evaluation: tool and time.
struct ContactInput {
  const ToolModel* tool = nullptr;
  const TissueTable* tissues = nullptr;
  Rigid3 T_object_tool;            ///< mm
  double speed = 0;                ///< current speed of the drive: see ToolDrive::speed; negative: backwards
  double dt = kTick;               ///< s
  bool geometry_only = false;      ///< the cutting part removes its swept volume, without resistance
  Vec3d velocity = Vec3d::Zero();  ///< of the tip relative to the object, mm/s, without the tool's own motion
  Vec3d angular = Vec3d::Zero();   ///< rad/s
  double load_scale = 1;           ///< of the eroding pressure: see erosionScale()
  double area_scale = 1;           ///< of the areas of cut nodes: CutArea
  /// Weight of the tool's faces in areas, normals and levers of cut nodes, 0 to 1: CutArea.
  double cut_share = 0;
};

/// Sums over the nodes in contact. A node overlaps the tool by d = max(0, -tau - phi), mm. Its pressure is p = k_n d g,
/// N/mm^2, k_n Tissue::stiffness. g = (1 - exp(-c dt)) / (c dt) is the mean of an eroding overlap over the evaluation,
/// c as in erode(). With the node's area vector w the force is the sum of p w, weighted by the node's facing: see
/// sumContact(). Friction makes mu p A.
struct ContactSums {
  Vec3d force = Vec3d::Zero(), torque = Vec3d::Zero();            ///< N, N mm, of the pressure, on the tool
  Vec3d force_next = Vec3d::Zero(), torque_next = Vec3d::Zero();  ///< in the next evaluation, if the tool stays
  /// -d(force_next, torque_next) / d(translation, rotation), symmetric, positive semi-definite: sum k_n g A u u^T with
  /// u = (n, r x n); g = 1 where nothing cuts.
  Matrix6d stiffness = Matrix6d::Zero();
  /// Drag on the tool is -(drag * twist) of its motion plus the part of its own motion: sums of mu p A over the surface
  /// speed, with their first and second moments about the tip.
  double drag = 0;                                        ///< N s/mm
  Vec3d drag_moment = Vec3d::Zero();                      ///< N s
  Eigen::Matrix3d drag_second = Eigen::Matrix3d::Zero();  ///< N s mm
  /// At rest: the part of dragMatrix() for motion along the normals, the sum of drag u u^T; else zero.
  Matrix6d normal_drag = Matrix6d::Zero();
  /// Normal load of the next evaluation, if the tool stays, N; and its decrease with the tool's motion along
  /// (translation, rotation): sum k_n g A u.
  double load_next = 0;
  Vector6d load_slope = Vector6d::Zero();
  double normal_load = 0;    ///< N = integral of p dA, N: the removal rate is proportional to it
  double cutting_load = 0;   ///< its part on the cutting part
  double erodible_load = 0;  ///< that part with g = 1: before this tick's erosion
  /// The same three for the whole cutting part, at any facing: erosion has no facing weight either.
  double bare_load = 0, bare_erodible = 0;  ///< N
  double bare_drive_load = 0;               ///< N mm (kStroke: N)
  double cut_by_shell = 0;                  ///< erosion by the areas of the nodes that face the tool, unscaled, mm^3
  double lip_torque = 0;                    ///< N mm: of a drill's lips about its axis, at any tilt
  double drive_load = 0;                    ///< of the spindle, N mm (kStroke: N): sum of mu p A times the lever
  double power = 0;                         ///< sum mu p A v_s, N mm/s: power of the drive
  double area = 0;                          ///< in contact, mm^2
  double deepest = 0;                       ///< largest overlap, mm
  int tested = 0, touching = 0;             ///< nodes
  std::uint8_t material = 0;                ///< number of the material with most of the area
  double material_area = 0;                 ///< mm^2

  void add(const ContactSums& other);
  /// Scales all values that grow with the pressure; area, nodes and depth stay.
  void scale(double factor);
  /// The same sums in axes rotated by R.
  ContactSums rotated(const Eigen::Matrix3d& R) const;
  /// drag as a 6 x 6 matrix over (translation, rotation).
  Matrix6d dragMatrix() const;
};

/// Drag on the tool by its own motion, about the tip. A stroke or swing goes to and fro: its mean is zero, and it only
/// makes friction along the feed small.
/// @param sums  in the frame of `pose`.   @param speed  of the drive. @rt
Wrench ownDrag(const ToolModel& tool, const Rigid3& pose, double speed, const ContactSums& sums) noexcept;

/// Bricks that a tool may touch or cut, found once per evaluation.
class NearBricks {
 public:
  explicit NearBricks(std::size_t capacity = 1 << 16);
  /// Finds the bricks within the object's band of the tool. Hierarchical: bounding box, blocks of 4^3 bricks, bricks.
  /// False if there are more than the capacity: omits the rest.
  bool find(const CutObject& object, const ToolModel& tool, const Rigid3& T_object_tool) noexcept;
  /// Takes those bricks of another list for which wanted(slot) is true. @pre its capacity is no greater than this
  /// one's. @rt
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

/// Force of the shell's nodes. A node's facing weight is clamp(2 n . grad tau, 0, 1), n the inward normal: the far side
/// of a thin wall does not push the tool through.
void sumContact(CutObject& object, const NearBricks& near, const ContactInput& in, ContactSums& sums) noexcept;

struct CutResult {
  double removed_mm3 = 0;
  int bricks = 0;
  bool pool_ran_out = false;
};
/// phi += d (1 - exp(-c dt)) with d = max(0, -tau_cut - phi) and the rate c = mu k_n v_s / (u_s f), f the tool's energy
/// factor, mu the material's friction times the tool's drag factor, v_s the surface speed at the node: the surface
/// relaxes towards the tool. At the lips of a drill: DrillLips. Geometry only: c is infinite. Updates the ledger.
/// CutObject::repair repairs the shells.
CutResult erode(CutObject& object, const NearBricks& near, const ContactInput& in) noexcept;

struct FillResult {
  double added_mm3 = 0;
  int bricks = 0;
  bool pool_ran_out = false;
  /// Part of the fill was omitted: in air farther out than kAirAround, or beyond CutObject::kMostAdded bricks of air.
  bool is_clipped = false;
};
/// Adds material at the tool's cutting part: phi = min(phi, tau). A node that was outside becomes `material` if
/// the added surface is now its nearest surface, at most 1.5 voxels away. Updates the ledger. CutObject::repair repairs
/// the shells.
FillResult fill(CutObject& object, const ContactInput& in, Material material) noexcept;

}  // namespace kerf
