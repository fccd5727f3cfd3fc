#include "sim/object/cut_object.h"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <new>
#include <utility>

#include "sim/object/node_volumes.h"

namespace kerf {

CutObject::CutObject(BrickStore bricks) : bricks_(std::move(bricks)), hash_(voxel()) {}

CutObject::CutObject(std::shared_ptr<const BakedObject> baked, std::size_t bricks)
    : CutObject(BrickStore(std::move(baked), BrickStore::Begin::kWithAllBricks)) {
  reserveLists(false);
  if (!reserve(std::min(bricks, bricks_.brickCount()))) throw std::bad_alloc();
}

// For the largest possible number of slots.
void CutObject::reserveLists(bool is_touched) {
  const std::size_t slots = bricks_.mostSlots();
  shell_.reserve(slots, is_touched);
  // A piece is a part of the loaded object, and there may be many pieces.
  constexpr std::size_t kOfAPiece = LoadedShells::kMostChunks / 8;
  loaded_shells_.reserve(baked(), bricks_.isPiece() ? kOfAPiece : LoadedShells::kMostChunks);
  hash_.reserve(slots, is_touched);
  for (DirtyLog* const log : {&for_mesher_, &for_pieces_}) {
    log->list.reserve(slots);
    if (is_touched) log->list.reserveTouched(slots);
  }
}

// Informs all parts of a change of a brick.
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
  if (!put(s, values, nullptr, 1, removed_mm3, removed)) return false;
  Slot& carved = slot(s);
  carved.least = least;
  carved.sleeps_until_contact = -1;
  return true;
}

bool CutObject::fill(int s, const float* values, const std::uint8_t* materials, double& added) noexcept {
  if (!put(s, values, materials, -1, added_mm3, added)) return false;
  Slot& filled = slot(s);
  filled.least = *std::min_element(values, values + kBrickNodes);
  filled.sleeps_until_contact = filled.sleeps_until_cut = -1;
  return true;
}

// @param materials  null: unchanged.   @param sign  of a loss in `book`.   @param sum  increased by the booked volume.
bool CutObject::put(int s, const float* values, const std::uint8_t* materials, int sign, std::array<double, 256>& book,
                    double& sum) noexcept {
  Slot& changing = slot(s);
  const std::uint8_t faces = changing.changed_faces;
  float* const own = write(s);
  if (!own) return false;

  const internal::NodeBits changed = internal::differingNodes(own, values);
  changing.changed_faces = faces | facesOf(changed);

  VolumeChange change(bricks_.around(changing), values, changed, bricks_.materialsAround(changing),
                      materials ? materials : changing.materials, baked().phi0().background());
  for (int face = 0; face < 6; ++face) {
    if (!(change.faces() >> face & 1)) continue;
    const int beside = bricks_.findBeside(changing, face);
    if (beside >= 0) change.addBeyond(face, bricks_.around(slot(beside)), bricks_.materialsAround(slot(beside)));
  }

  const double part = volumeOfPart(voxel());
  const std::int64_t lost = change.lost();
  sum += static_cast<double>(sign * lost) * part;
  if (change.isOfOneMaterial()) {
    double& one = book[changing.materials[0]];
    one = addParts(one, sign * lost, part);
  } else {
    PartsByNumber by_number{};
    change.addLost(by_number);
    for (std::size_t m = 0; m < by_number.size(); ++m)
      if (by_number[m] != 0) book[m] = addParts(book[m], sign * by_number[m], part);
  }

  std::memcpy(own, values, sizeof(BrickValues));
  if (materials) std::memcpy(writeMaterials(s), materials, kBrickNodes);
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
