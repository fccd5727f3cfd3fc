// A few points that represent a whole contact, for the responses by constraints and by impulses.
//
// All functions are @rt and bounded: fixed arrays, no allocation, the same points on any machine.
#pragma once

#include "sim/step/contact.h"
#include "sim/step/one_sided_loads.h"

namespace kerf {

/// A shell node that overlaps the tool, world axes.
struct ContactPoint {
  Vec3d normal;      ///< direction of the push on the tool: the tissue's outward, at its edges the tool's inward
  Vec3d lever;       ///< from the tool's tip, mm
  double gap = 0;    ///< tau + phi < 0, mm
  double slope = 1;  ///< gap opened per unit of tool motion along the normal
  int object = 0;
  bool cuts = false;  ///< on the cutting part

  /// (n, r x n): its product with a twist about the tip is the tool's speed outwards at this point.
  Vector6d direction() const;
};

class ContactPoints {
 public:
  static constexpr int kMost = OneSidedLoads::kMost;
  void clear() noexcept { count_ = 0; }
  /// Adds the points of one object: the deepest node of each cell that faces the tool. Cells: cutting part or body, six
  /// directions of the normal, 4 x 4 x 4 places in that part's box, in the tool's frame. Keeps the deepest kMost of all
  /// objects, deepest first; with equal depth the earlier one.
  /// @param in  pose of the test; geometry_only omits the cutting part.
  /// @return number of nodes tested.   @cost that of sumContact() without its sums.
  int gather(CutObject& object, int index, const NearBricks& near, const ContactInput& in) noexcept;
  int size() const { return count_; }
  const ContactPoint& operator[](int n) const { return points_[static_cast<std::size_t>(n)]; }

 private:
  std::array<ContactPoint, kMost> points_;
  int count_ = 0;
};

/// The loads at such points, and the resulting motion.
struct ContactLoads {
  using Row = OneSidedLoads::Row;
  OneSidedLoads loads;

  const Vector6d& motion() const { return loads.motion; }
  double total() const;
  double ofObject(const ContactPoints& points, int object) const;
  double ofCutting(const ContactPoints& points, int object) const;  ///< of the points on the cutting part
  /// Sum of u_i load_i.
  Vector6d push(const ContactPoints& points) const;
  /// OneSidedLoads::solve() with the same softness at all points. @rt @cost 1 us a point at most
  void solve(const Matrix6d& a, const Vector6d& b, const ContactPoints& points, const Row& least,
             double softness) noexcept;

 private:
  int count_ = 0;
};

}  // namespace kerf
