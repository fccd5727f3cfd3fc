#include "bench/scenes/press.h"

#include <algorithm>
#include <limits>

namespace kerf::scenes {

CutPath downAndUp() {
  CutPath path;
  for (const auto& [t, z] : {std::pair(0.0, 1.0), std::pair(0.5, -2.0), std::pair(1.5, -2.0), std::pair(1.8, 1.0)})
    path.poses.push_back({t, {Eigen::Quaterniond::Identity(), {0, 0, z}}});
  path.cuts = {1, 1, 1};
  return path;
}

Press press(const Model& model, const std::shared_ptr<const BakedObject>& object, const DeviceHand::Options& options) {
  State state;
  state.objects.emplace_back(object, 16);
  const CutPath path = downAndUp();
  DeviceHand hand(path, options);
  StepOutput out;
  DeviceSample sample;
  state.place(poseAt(path, 0));

  // The hand holds still from 0.5 to 1.5 s, and is at rest by 1.2 s.
  Press result;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (int n = 0; hand.next(out, sample); ++n) {
    step(model, state, sample, out);
    result.energy = std::max(result.energy, hand.portEnergy());
    if (n > 1200 && n < 1490) {
      low = std::min(low, hand.position()[2]);
      high = std::max(high, hand.position()[2]);
    }
  }
  result.trembling = high - low;
  return result;
}

}  // namespace kerf::scenes
