#include "sim/run/added_materials.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <vector>

namespace kerf::internal {
namespace {

// Whether there is more in a brick than was loaded; depths below a hundredth of a voxel are rounding.
bool hasMore(const BrickSlot& slot, double voxel) {
  if (!slot.own) return false;
  const auto rounding = static_cast<float>(0.01 * voxel);
  for (std::size_t n = 0; n < kBrickNodes; ++n)
    if (slot.own[n] < slot.baked[n] - rounding) return true;
  return false;
}

MaterialBricks::Numbers materialsOf(const std::vector<const BrickSlot*>& slots) {
  MaterialBricks::Numbers out;
  for (std::size_t n = 0; n < out.size(); ++n) {
    const auto hasLess = [n](const BrickSlot* a, const BrickSlot* b) { return a->phi[n] < b->phi[n]; };
    out[n] = (*std::min_element(slots.begin(), slots.end(), hasLess))->materials[n];
  }
  return out;
}

void nameAdded(const BrickSlot& slot, const MaterialTable& table, std::map<std::uint8_t, std::string>& names) {
  if (!slot.hasChangedMaterials()) return;
  for (std::size_t n = 0; n < kBrickNodes; ++n) {
    const std::uint8_t number = slot.materials[n];
    if (number == slot.baked_materials[n] || names.contains(number)) continue;
    const MaterialProperties* const row = table.find(static_cast<Material>(number));
    if (row) names[number] = row->id;
  }
}

}  // namespace

MaterialBricks addedMaterials(const Objects& objects, const MaterialBricks& before, const MaterialTable& table) {
  MaterialBricks out;
  out.voxel = objects.front()->voxel();
  out.added = before.added;

  std::map<std::uint64_t, std::vector<const BrickSlot*>> found;  // by coordKey()
  for (const CutObject* const object : objects)
    for (int s = 0; s < object->slotCount(); ++s) {
      const BrickSlot& slot = object->slot(s);
      const bool is_added =
          slot.hasChangedMaterials() || hasMore(slot, out.voxel) || before.find(slot.brick) != nullptr;
      if (is_added && object->bricks().has(s)) found[coordKey(slot.brick)].push_back(&slot);
    }

  for (const auto& [key, slots] : found) {
    out.bricks.push_back(slots.front()->brick);
    out.numbers.push_back(materialsOf(slots));
    for (const BrickSlot* const slot : slots) nameAdded(*slot, table, out.added);
  }
  return out;
}

}  // namespace kerf::internal
