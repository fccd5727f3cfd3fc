// A split, ready to be put in place: the objects that take the place of one, or that one again.
#pragma once

#include <memory>
#include <vector>

#include "sim/object/cut_object.h"

namespace kerf {

/// Pose and ledger of an object, as of the end of a stroke.
struct TrackedState {
  Rigid3 pose;
  Ledger ledger;
};
TrackedState trackedState(const CutObject& object);

/// One step of undo and redo: either the whole or its parts are in the scene, the others are here.
struct Split {
  struct Part {
    CutObject object;
    TrackedState tracked;
  };
  std::size_t index = 0;  ///< of the whole in the scene; its first part takes that place, the others are the last ones
  std::size_t parts = 0;  ///< how many
  /// The objects of this split that are not in the scene: the whole while it is split, else its parts.
  std::vector<Part> out_of_scene;
  /// Empty, its memory reserved: takes what leaves the scene when the two change places.
  std::vector<Part> for_exchange;
  std::unique_ptr<Split> next;  ///< in a list of splits
};

/// What SessionHistory::split() wants, made by any thread. Allocates.
std::unique_ptr<Split> prepareSplit(std::vector<CutObject> parts);

}  // namespace kerf
