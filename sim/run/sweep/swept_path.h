// Distance from a point to a tool's sweep along a path, without testing every motion.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/tool/tool_shape.h"
#include "sim/hand/path.h"

namespace kerf {

/// The cutting motions of a path in a binary tree that groups neighbours in time. The shape's distance is 1-Lipschitz:
/// the poses of a part deviate from its middle pose by a bounded amount, which gives a lower bound for skipping parts.
/// Shape and path must outlive it. Reading is safe from many threads.
class SweptPath {
 public:
  /// @cost O(motions), about 0.1 us each.
  SweptPath(const ToolShape& shape, const CutPath& path);

  struct Nearest {
    double distance_mm = 0;   ///< negative where the tool has been
    std::size_t motions = 0;  ///< number of motions tested
  };
  /// The minimum of SweptTool::distance() over all cutting motions.
  /// @param far        mm, > 0: the limit for larger distances.
  /// @param tolerance  mm, > 0, as in SweptTool::distance(); values below -far are no more accurate than that.
  /// @cost about 40 us with 20 000 motions, growing as their logarithm.
  Nearest nearest(const Vec3d& x_object, double far, double tolerance) const;

  std::size_t motionCount() const { return motions_.size(); }

 private:
  struct Node {
    std::size_t begin, end;       // in motions_
    std::size_t pose;             // in the middle, of path_.poses
    double travel = 0, turn = 0;  // mm, rad: largest deviation of any pose of the part from `pose`
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
