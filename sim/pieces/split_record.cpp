#include "sim/pieces/split_record.h"

#include <utility>

namespace kerf {

TrackedState trackedState(const CutObject& object) {
  return {object.T_world_object, {object.removed_mm3, object.added_mm3}};
}

std::unique_ptr<Split> prepareSplit(std::vector<CutObject> parts) {
  auto out = std::make_unique<Split>();
  out->parts = parts.size();
  out->out_of_scene.reserve(parts.size());
  out->for_exchange.reserve(parts.size());
  for (CutObject& part : parts) {
    TrackedState tracked = trackedState(part);
    out->out_of_scene.push_back({std::move(part), std::move(tracked)});
  }
  return out;
}

std::unique_ptr<Split> prepareDeletion() {
  auto out = std::make_unique<Split>();
  out->out_of_scene.reserve(kMostObjects);
  return out;
}

}  // namespace kerf
