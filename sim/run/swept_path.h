// How far a point is from all that a tool sweeps along a path, without asking each of its motions.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/tool/tool_shape.h"
#include "sim/hand/path.h"

namespace kerf {

/// The cutting motions of a path in a binary tree, neighbours in time together. From the pose in the middle of a part
/// nothing of that part is farther than its poses differ, because the shape's distance is 1-Lipschitz: a lower bound by
/// which parts are left out. Shape and path must outlive it. Reading is safe from many threads.
class SweptPath {
 public:
  /// @cost O(motions), about 0.1 us each.
  SweptPath(const ToolShape& shape, const CutPath& path);

  struct Nearest {
    double distance_mm = 0;   ///< negative where the tool has been
    std::size_t motions = 0;  ///< that were asked
  };
  /// The minimum of SweptTool::distance() over all cutting motions.
  /// @param far        mm, > 0: what is at or beyond it comes back as `far`.
  /// @param tolerance  mm, > 0, as of SweptTool::distance(); values below -far are known no better than that.
  /// @cost about 40 us with 20 000 motions, growing as their logarithm.
  Nearest nearest(const Vec3d& x_object, double far, double tolerance) const;

  std::size_t motionCount() const { return motions_.size(); }

 private:
  struct Node {
    std::size_t begin, end;       // in motions_
    std::size_t pose;             // in the middle, of path_.poses
    double travel = 0, turn = 0;  // mm, rad: of any pose of the part from that one, at most
    std::size_t second = 0;       // the second child, the first follows the node; 0: a leaf
  };

  std::size_t build(std::size_t begin, std::size_t end);
  double lowerBound(const Node& node, const Vec3d& x) const;
  void visit(std::size_t n, const Vec3d& x, double far, double tolerance, Nearest& out) const;

  const ToolShape& shape_;
  const CutPath& path_;
  std::vector<std::size_t> motions_;  // motion m leads from pose m to pose m + 1
  std::vector<Node> nodes_;
};

}  // namespace kerf
