// A simulated device and hand, pressed on a wall that does not give way: whether the device is given energy.
#pragma once

#include <memory>

#include "sim/hand/virtual_hand.h"
#include "sim/object/baked_object.h"
#include "sim/step/step.h"

namespace kerf::scenes {

/// 3 mm down in 0.5 s, 2 mm of them beyond z = 0; held there for a second; up again.
CutPath downAndUp();

struct Press {
  double energy = -1e9;  ///< the most the device was given beyond its own losses, N mm = mJ; above 0: it was
  double trembling = 0;  ///< mm from end to end, while the hand holds still
};

/// A hand that follows downAndUp() with the first tool of the model.
Press press(const Model& model, const std::shared_ptr<const BakedObject>& object, const DeviceHand::Options& options);

}  // namespace kerf::scenes
