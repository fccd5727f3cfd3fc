// Contact of a tool's core: keeps thin and pointed tools from sinking.
//
// The shell's force (sim/step/contact.h) grows with the overlap of surfaces. It is lost once a thin part has gone
// through: its own flanks face away from the push, and past its middle its distance points the other way. A core point
// (sim/step/tool_core.h) is stopped before that, on the near side of the object's surface:
//
//   allowed   delta = min(0.4 r, r - 0.7 h, band - 0.7 h), r the point's radius, h the voxel, band the object's outer
//             one: the least allowed distance. A point with a radius below 0.7 voxels may go in by the difference. A
//             drill's may come nearer, r - h: pushed beyond its greatest feed it leans on its core, and an earlier hold
//             slows its feed. Below one voxel it may go in.
//   distance  phi and its gradient g by quadratic B-splines over the 27 nodes around: smooth across nodes. Between two
//             walls g is short by itself; only a g longer than 1 is shortened.
//   push      N = K max(0, delta - phi') along g, K = 1.5 mm^2 times the contact stiffness of the material there, phi'
//             the distance at the end of this evaluation: solved together with the body (OneSidedLoads), so that K has
//             no upper limit.
//   friction  mu N over the sliding speed, at the place where ball and surface meet; felt one evaluation later.
//   erosion   by the load of the evaluation before: rates are scaled as if the shell pressed with both.
//
// Soft tissue, whose K is small, stops a tool at rest: 0.1 mm deeper than min(delta, 0) a second spring makes K up to
// 300 N/mm.
//
// Points, edges and fins that are thinner (CorePoint::is_thin) hold a tool at rest: they may go in by h / 2 - r. They
// do not count while the drive turns faster than kAtRest.
//
// A tool that starts inside (after an undo, added material, or a moved object) is not held until its core has been
// outside once: CutObject::is_core_clear.
//
// Ordinary tools under ordinary loads do not come so near: for them nothing changes, to the bit. Only for
// Response::kPenalty, coupled: a tool fixed to a machine has no body to hold, and the other responses have points of
// their own.
//
// All functions are @rt.
#pragma once

#include "sim/step/contact.h"
#include "sim/step/coupling.h"

namespace kerf {

/// Result of one evaluation's core for the next; world axes, about the tip. The objects hold the load:
/// CutObject::core_load.
struct CoreDrag {
  double drag = 0;                                   ///< N s/mm: as ContactSums::drag
  Vec3d moment = Vec3d::Zero();                      ///< N s
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  ///< N s mm
  Matrix6d normal = Matrix6d::Zero();                ///< as ContactSums::normal_drag

  bool isZero() const { return drag == 0; }
  void addTo(ContactSums& sums) const;
};

/// Core points near an object's surface, and the loads that hold them out.
class CoreContact {
 public:
  static constexpr std::size_t kMost = OneSidedLoads::kMost;

  /// Adds the points of one object (CutObject::is_core_clear: else none) that may be pushed in this evaluation. Keeps
  /// the kMost deepest of all objects.
  /// @param number  of the object.   @param way_mm  largest motion of the tool meanwhile.
  /// @cost  reads one node, or nine, for each core point, and 27 for each near one.
  void gather(CutObject& object, std::size_t number, const ContactInput& in, double way_mm) noexcept;
  bool isEmpty() const { return count_ == 0; }

  /// Solves for the velocity in advance(). @pre not empty
  Vector6d solve(const Matrix6d& a, const Vector6d& b, double dt) noexcept;

  /// Part of the solved loads on one object that is on the cutting part, N.
  double cuttingLoad(std::size_t number) const;
  /// Adds the points that carry a load to the nodes in contact.   @return objectBit() of their objects.
  std::uint64_t countTouched(ContactSums& sums) const;
  /// Their friction.
  CoreDrag drag(const ToolBody& body) const;

 private:
  struct Row {
    Vec3d lever, touch;    // of the point, and of its ball's contact with the surface, from the tip; world axes, mm
    double clearance = 0;  // phi - delta, mm
    double stiffness = 0;  // N/mm
    double friction = 0;
    double slope = 1;      // length of the gradient
    double own_speed = 0;  // of the tool's surface there, mm/s
    std::size_t object = 0;
    std::uint8_t material = 0;
    bool cuts = false;
  };
  void add(const Row& row, const Vec3d& push) noexcept;
  double normalLoad(std::size_t n) const;

  std::array<Row, kMost> rows_;
  OneSidedLoads::Directions directions_;
  std::size_t count_ = 0;
  OneSidedLoads loads_;
  double per_s_ = 0;  // converts loads, which are impulses, to forces
};

/// Most of a core's load that erodes, N: more than a hand presses. A tool that starts inside, after added material or a
/// moved object, is pushed out hard, and must not cut its way.
inline constexpr double kMostCoreLoad = 20;

/// Scales the shell's loads and drive by the core's share of the load, and returns the factor on erosion.
/// @param core_load  CutObject::core_load.   @return ContactInput::load_scale, 1 at least.
double shareCoreLoad(double core_load, double speed, ContactSums& sums) noexcept;

}  // namespace kerf
