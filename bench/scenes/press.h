// A simulated device and hand press on a rigid wall: whether the device gains energy.
#pragma once

#include <memory>

#include "sim/hand/virtual_hand.h"
#include "sim/object/baked_object.h"
#include "sim/step/step.h"

namespace kerf::scenes {

/// 3 mm down in 0.5 s, 2 mm of them beyond z = 0, a hold of one second, and up again.
CutPath downAndUp();

struct Press {
  double energy = -1e9;  ///< peak energy gain of the device beyond its own losses, N mm = mJ; above 0: gain
  double trembling = 0;  ///< mm peak to peak, during the hold
};

/// A hand follows downAndUp() with the first tool of the model.
Press press(const Model& model, const std::shared_ptr<const BakedObject>& object, const DeviceHand::Options& options);

}  // namespace kerf::scenes
