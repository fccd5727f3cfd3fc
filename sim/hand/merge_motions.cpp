#include "sim/hand/merge_motions.h"

#include <algorithm>
#include <vector>

namespace kerf {
namespace {

constexpr std::size_t kMostMerged = 256;  // motions in one
constexpr double kMostTurn = 0.5;         // rad, of a merged motion

class Merger {
 public:
  Merger(const CutPath& path, const MergeLimits& limits) : path_(path), limits_(limits), way_(path.poses.size(), 0) {
    for (std::size_t n = 0; n + 1 < path.poses.size(); ++n) {
      const double moved = farthestMove(n, n + 1);
      is_short_.push_back(path.cuts[n] && moved <= limits.short_mm);
      way_[n + 1] = way_[n] + moved;
    }
  }

  // Number of motions from pose `from` on that can be merged.
  std::size_t mergeable(std::size_t from) const {
    std::size_t run = 0;
    while (run < kMostMerged && from + run < is_short_.size() && is_short_[from + run]) ++run;
    for (std::size_t length = kMostMerged; length > 1; length /= 2)
      if (length <= run && staysClose(from, from + length)) return length;
    return 1;
  }

 private:
  const Rigid3& pose(std::size_t n) const { return path_.poses[n].T_object_tool; }

  // Largest move of any point of the tool between two poses, mm: an upper bound.
  double farthestMove(std::size_t a, std::size_t b) const {
    return (pose(b).translation - pose(a).translation).norm() +
           limits_.reach_mm * pose(a).rotation.angularDistance(pose(b).rotation);
  }

  // Whether one motion between two poses passes all poses between them, in their order. Between poses both ways lead
  // straight, and are no farther from each other than at the poses.
  bool staysClose(std::size_t from, std::size_t to) const {
    const Rigid3 &a = pose(from), &b = pose(to);
    const double length = way_[to] - way_[from];
    if (!(length > 0)) return true;  // it stands still
    if (a.rotation.angularDistance(b.rotation) > kMostTurn) return false;
    // A way that turns back is longer than the motion.
    if (length > farthestMove(from, to) + limits_.tolerance_mm) return false;

    for (std::size_t n = from + 1; n < to; ++n) {
      const double share = (way_[n] - way_[from]) / length;
      const Rigid3 merged{a.rotation.slerp(share, b.rotation), a.translation + share * (b.translation - a.translation)};
      const double off = (pose(n).translation - merged.translation).norm() +
                         limits_.reach_mm * pose(n).rotation.angularDistance(merged.rotation);
      if (off > limits_.tolerance_mm) return false;
    }
    return true;
  }

  const CutPath& path_;
  MergeLimits limits_;
  std::vector<char> is_short_;  // per motion
  std::vector<double> way_;     // to each pose, mm
};

}  // namespace

MergedPath mergeShortMotions(const CutPath& path, const MergeLimits& limits) {
  MergedPath out;
  if (path.poses.empty() || !(limits.short_mm > 0)) {
    out.path = path;
    return out;
  }

  const Merger merger(path, limits);
  out.path.poses.push_back(path.poses.front());
  for (std::size_t n = 0; n + 1 < path.poses.size();) {
    const std::size_t length = merger.mergeable(n);
    if (length > 1) out.merged += length;
    out.path.cuts.push_back(path.cuts[n]);
    out.path.poses.push_back(path.poses[n + length]);
    n += length;
  }
  return out;
}

}  // namespace kerf
