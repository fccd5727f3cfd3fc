#include "sim/object/cut_object.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <new>
#include <utility>

namespace kerf {

CutObject::CutObject(BrickStore bricks) : bricks_(std::move(bricks)), hash_(voxel()) {}

CutObject::CutObject(std::shared_ptr<const BakedObject> baked, std::size_t bricks)
    : CutObject(BrickStore(std::move(baked), BrickStore::Begin::kWithAllBricks)) {
  reserveLists(false);
  if (!reserve(std::min(bricks, bricks_.brickCount()))) throw std::bad_alloc();
}

// For all slots there can ever be.
void CutObject::reserveLists(bool is_touched) {
  const std::size_t slots = bricks_.mostSlots();
  shell_.reserve(slots, is_touched);
  hash_.reserve(slots, is_touched);
  for (DirtyLog* const log : {&for_mesher_, &for_pieces_}) {
    log->list.reserve(slots);
    if (is_touched) log->list.reserveTouched(slots);
  }
}

// Tells all parts that a brick has changed.
void CutObject::mark(int s) noexcept {
  Slot& changed = slot(s);
  shell_.add(changed, s);
  for_mesher_.list.add(changed, s);
  for_pieces_.list.add(changed, s);
  hash_.add(changed, s, shell_.round());
  bricks_.touch(s);
}

float* CutObject::write(int s) noexcept {
  Slot& written = slot(s);
  if (!strokes_.isCurrent(written.version)) {
    BrickVersion* const version = memory_.takeVersion();
    if (!version) return nullptr;
    bricks_.copyInto(*version, s, strokes_.number());
    strokes_.add(version);
  }
  mark(s);
  written.changed_faces = kAllFaces;
  return written.own;
}

std::uint8_t* CutObject::writeMaterials(int s) noexcept {
  assert(strokes_.isCurrent(slot(s).version));
  return bricks_.ownMaterials(s);
}

bool CutObject::carve(int s, const float* values, float least, double& removed) noexcept {
  Slot& carved = slot(s);
  const std::uint8_t faces = carved.changed_faces;
  float* const own = write(s);
  if (!own) return false;

  const double e = kShellHalfWidth * voxel(), cell = voxel() * voxel() * voxel();
  const auto half_width = static_cast<float>(e);
  double lost[kBrickNodes];
  const internal::NodeBits changed = internal::differingNodes(own, values);
  carved.changed_faces = faces | facesOf(changed);
  internal::volumeLost(own, values, changed, e, cell, lost);

  // One sum per material, node by node: the order is part of the result.
  double one_material = removed_mm3[carved.materials[0]];
  for (int word = 0; word < kBrickSide; ++word)
    for (std::uint64_t bits = changed[static_cast<std::size_t>(word)]; bits != 0; bits &= bits - 1) {
      const int n = 64 * word + std::countr_zero(bits);
      if (own[n] >= half_width || values[n] <= -half_width) continue;
      (carved.has_one_material ? one_material : removed_mm3[carved.materials[n]]) += lost[n];
      removed += lost[n];
    }
  if (carved.has_one_material) removed_mm3[carved.materials[0]] = one_material;

  std::memcpy(own, values, sizeof(BrickValues));
  carved.least = least;
  carved.sleeps_until_contact = -1;
  return true;
}

bool CutObject::restore(int s, const BrickValues& values, const std::uint8_t* materials) {
  forgetCore();
  if (freeBricks() == 0 && !reserve(1024)) return false;
  float* own = write(s);
  Slot& restored = slot(s);
  std::copy(values.begin(), values.end(), own);
  if (materials || restored.own_materials)
    std::copy_n(materials ? materials : restored.baked_materials, kBrickNodes, writeMaterials(s));
  restored.least = *std::min_element(own, own + kBrickNodes);
  restored.sleeps_until_contact = restored.sleeps_until_cut = -1;
  return true;
}

void CutObject::swapStroke(const LinkedList<BrickVersion>& stroke, bool is_undo) noexcept {
  forgetCore();
  for (BrickVersion* version = stroke.first; version; version = version->next) {
    Slot& swapped = slot(version->slot);
    swapped.changed_faces |= bricks_.swapIn(*version, is_undo);
    swapped.sleeps_until_contact = swapped.sleeps_until_cut = -1;
    mark(version->slot);
  }
}

}  // namespace kerf
