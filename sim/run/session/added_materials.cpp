#include "sim/run/session/added_materials.h"

#include <algorithm>
#include <map>
#include <vector>

namespace kerf::internal {
namespace {

// Whether a node has more than was loaded; depths below a hundredth of a voxel are rounding.
bool hasMore(const BrickSlot& slot, std::size_t node, double voxel) {
  return slot.own && slot.own[node] < slot.baked[node] - static_cast<float>(0.01 * voxel);
}

bool hasMore(const BrickSlot& slot, double voxel) {
  if (!slot.own) return false;  // usual case
  for (std::size_t n = 0; n < kBrickNodes; ++n)
    if (hasMore(slot, n, voxel)) return true;
  return false;
}

// The materials as loaded, of all pieces together: each piece treats the others' nodes as air of one material.
const std::uint8_t* loadedMaterials(const BakedObject& loaded, const Vec3i& brick) {
  const std::int32_t slot = loaded.directory().find(brick);
  return slot < 0 ? loaded.fallbackMaterials() : loaded.slots()[static_cast<std::size_t>(slot)].materials;
}

// The slots of a brick in each object that has it.
std::vector<const BrickSlot*> slotsOf(const Objects& objects, const Vec3i& brick) {
  std::vector<const BrickSlot*> out;
  for (const CutObject* const object : objects) {
    const int s = object->find(brick);
    if (s >= 0 && object->bricks().has(s)) out.push_back(&object->slot(s));
  }
  return out;
}

MaterialBricks::Numbers materialsOf(const std::vector<const BrickSlot*>& slots, const std::uint8_t* loaded,
                                    double voxel) {
  MaterialBricks::Numbers out;
  for (std::size_t n = 0; n < out.size(); ++n) {
    const auto hasLess = [n](const BrickSlot* a, const BrickSlot* b) { return a->phi[n] < b->phi[n]; };
    const BrickSlot& most = **std::min_element(slots.begin(), slots.end(), hasLess);
    const bool is_added = most.materials[n] != most.baked_materials[n] || hasMore(most, n, voxel);
    out[n] = is_added ? most.materials[n] : loaded[n];
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

  std::map<std::uint64_t, Vec3i> found;  // by coordKey()
  for (const CutObject* const object : objects)
    for (int s = 0; s < object->slotCount(); ++s) {
      const BrickSlot& slot = object->slot(s);
      const bool is_added =
          slot.hasChangedMaterials() || hasMore(slot, out.voxel) || before.find(slot.brick) != nullptr;
      if (is_added && object->bricks().has(s)) found[coordKey(slot.brick)] = slot.brick;
    }

  const BakedObject& loaded = objects.front()->baked();
  for (const auto& [key, brick] : found) {
    const std::vector<const BrickSlot*> slots = slotsOf(objects, brick);
    out.bricks.push_back(brick);
    out.numbers.push_back(materialsOf(slots, loadedMaterials(loaded, brick), out.voxel));
    for (const BrickSlot* const slot : slots) nameAdded(*slot, table, out.added);
  }
  return out;
}

}  // namespace kerf::internal
