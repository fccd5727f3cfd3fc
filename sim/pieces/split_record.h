// A prepared split: exchanges an object for its parts, or back.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "sim/object/cut_object.h"

namespace kerf {

/// Pose and ledger of an object at the end of a stroke.
struct TrackedState {
  Rigid3 pose;
  Ledger ledger;
};
TrackedState trackedState(const CutObject& object);

/// One step of undo and redo: a split, or a deletion. Either the whole or its parts are in the scene; this holds the
/// others.
struct Split {
  struct Part {
    CutObject object;
    TrackedState tracked;
  };
  std::size_t index = 0;  ///< of the whole in the scene; its first part takes that place, the others are appended
  std::size_t parts = 0;  ///< how many
  bool is_plane_cut = false;
  double lost_mm3 = 0;  ///< of a plane cut or a deletion: volume that left the scene
  /// A deletion: bits of the objects in the scene that it removes; then `index` and `parts` have no meaning.
  std::uint64_t deleted = 0;
  std::size_t heir = 0;  ///< of a deletion: before it, the object that takes over their volumes as removed_before_mm3
  std::array<double, 256> heir_before{};  ///< its other value, for the exchange
  /// The objects of this split that are not in the scene: the whole while it is split, else its parts.
  std::vector<Part> out_of_scene;
  /// Empty, with reserved memory: takes the objects that leave the scene in the exchange.
  std::vector<Part> for_exchange;
  std::unique_ptr<Split> next;  ///< in a list of splits
};

/// Input of SessionHistory::split(), made by any thread. Allocates.
std::unique_ptr<Split> prepareSplit(std::vector<CutObject> parts);
/// Memory for SessionHistory::erase() of any objects. Allocates.
std::unique_ptr<Split> prepareDeletion();

}  // namespace kerf
