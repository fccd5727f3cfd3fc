// A few points that stand for a whole contact: what the responses by constraints and by impulses solve for.
//
// All functions are @rt and bounded: fixed arrays, no allocation, the same points whatever machine.
#pragma once

#include "sim/step/contact.h"
#include "sim/step/one_sided_loads.h"

namespace kerf {

/// A shell node that overlaps the tool, world axes.
struct ContactPoint {
  Vec3d normal;      ///< where contact pushes the tool: the tissue's outward, at its edges the tool's inward
  Vec3d lever;       ///< from the tool's tip, mm
  double gap = 0;    ///< tau + phi < 0, mm
  double slope = 1;  ///< moving the tool along the normal by 1 opens the gap by this
  int object = 0;
  bool cuts = false;  ///< met by the cutting part

  /// (n, r x n): its product with a twist about the tip is how fast the tool moves out there.
  Vector6d direction() const;
};

class ContactPoints {
 public:
  static constexpr int kMost = OneSidedLoads::kMost;
  void clear() noexcept { count_ = 0; }
  /// Adds the points of one object: the deepest node of each cell that faces the tool. Cells: cutting part or body, six
  /// ways a normal may point, 4 x 4 x 4 places in that part's box, in the tool's frame. Of all objects' the deepest
  /// kMost are kept, deepest first; with equal depth the earlier one.
  /// @param in  where the tool is tested; geometry_only leaves the cutting part out.
  /// @return how many nodes were tested.   @cost of sumContact, less its sums.
  int gather(CutObject& object, int index, const NearBricks& near, const ContactInput& in) noexcept;
  int size() const { return count_; }
  const ContactPoint& operator[](int n) const { return points_[static_cast<std::size_t>(n)]; }

 private:
  std::array<ContactPoint, kMost> points_;
  int count_ = 0;
};

/// The loads at such points, and the motion they leave.
struct ContactLoads {
  using Row = OneSidedLoads::Row;
  OneSidedLoads loads;

  const Vector6d& motion() const { return loads.motion; }
  double total() const;
  double ofObject(const ContactPoints& points, int object) const;
  double ofCutting(const ContactPoints& points, int object) const;  ///< of those on what cuts
  /// Sum of u_i load_i.
  Vector6d push(const ContactPoints& points) const;
  /// OneSidedLoads::solve() with the same softness at all points. @rt @cost 1 us a point at most
  void solve(const Matrix6d& a, const Vector6d& b, const ContactPoints& points, const Row& least,
             double softness) noexcept;

 private:
  int count_ = 0;
};

}  // namespace kerf
