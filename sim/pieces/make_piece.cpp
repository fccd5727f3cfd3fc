#include "sim/pieces/make_piece.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <mutex>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "sim/object/for_each.h"
#include "sim/object/huge_pages.h"
#include "sim/pieces/brick_parts.h"

namespace kerf {

using internal::beside;

// Makes one piece: first its slots, then its own values, then the shells. Reads nothing that the cutting thread may
// write while the whole is frozen.
class PieceBuilder {
 public:
  static CutObject blank(std::shared_ptr<const BakedObject> baked, std::size_t bricks);
  static CutObject make(const CutObject& whole, const PieceBricks& bricks, std::unique_ptr<CutObject> blank,
                        bool is_parallel);

 private:
  // A part of the piece's bricks, for one thread.
  struct Part {
    std::span<const Vec3i> bricks;
    std::vector<Vec3i> others;  // bricks without a slot
    std::uint64_t key = 0;      // of its bricks: see BrickStore::pieceKey()
  };
  static constexpr std::size_t kBricksAPart = 4096;

  PieceBuilder(const CutObject& whole, const PieceBricks& bricks, CutObject& out, bool is_parallel)
      : whole_(whole),
        baked_(whole.baked()),
        bricks_(bricks),
        out_(out),
        store_(out.bricks_),
        is_parallel_(is_parallel) {}

  void takeSlots();
  std::vector<Part> placeLoaded();
  void addSlots(const std::vector<Part>& parts);
  void shareTouched();
  void share(int slot, const BrickSlot& from);
  void takeChanged();
  void copyValues();
  void makeShells();
  bool needsNewShell(int s) const;
  std::vector<int> shellsToMake();
  void makeShell(int s);
  template <class Work>
  void inLots(std::size_t count, const Work& work) const;

  const CutObject& whole_;
  const BakedObject& baked_;
  const PieceBricks& bricks_;
  CutObject& out_;
  BrickStore& store_;  // of out_
  bool is_parallel_;
  std::vector<int> own_;                   // slots with values other than loaded
  std::vector<unsigned char> is_changed_;  // per slot: its values differ from the whole's
  std::mutex mutex_;                       // guards the lists of memory
};

CutObject PieceBuilder::blank(std::shared_ptr<const BakedObject> baked, std::size_t bricks) {
  CutObject out{BrickStore(std::move(baked), BrickStore::Begin::kEmpty)};
  BrickStore& store = out.bricks_;
  const BakedObject& loaded = store.baked();
  store.is_piece_ = true;

  const BrickDirectory& box = loaded.directory();
  std::vector<std::int32_t> memory;
  internal::reserveLarge(memory, box.cellCount());
  store.directory_ = BrickDirectory(box.low(), box.size(), std::move(memory));

  store.reserveSlots(loaded.slots().size() + BrickStore::kMostAdded);
  store.slots_.resize(store.most_slots_);
  store.slots_.clear();
  for (const BakedObject::Slot& from : loaded.slots()) store.addLoaded(from);

  store.touched_.reserveTouched(store.most_slots_);
  out.reserveLists(true);
  if (!out.reserve(bricks)) throw std::bad_alloc();
  return out;
}

CutObject PieceBuilder::make(const CutObject& whole, const PieceBricks& bricks, std::unique_ptr<CutObject> blank,
                             bool is_parallel) {
  const bool is_usable = blank && blank->bricks().sharedBaked() == whole.bricks().sharedBaked();
  CutObject out =
      is_usable ? std::move(*blank) : CutObject(BrickStore(whole.bricks().sharedBaked(), BrickStore::Begin::kEmpty));
  if (out.slotCount() == 0) {
    BrickStore& store = out.bricks_;
    store.is_piece_ = true;
    store.directory_ = BrickDirectory(whole.baked().directoryLow(), whole.baked().directorySize());
    store.reserveSlots(bricks.bricks.size() + bricks.interior.size());
    out.reserveLists(false);
  }
  out.T_world_object = whole.T_world_object;
  out.plane_sides = whole.plane_sides;

  PieceBuilder builder(whole, bricks, out, is_parallel);
  builder.takeSlots();
  builder.takeChanged();
  builder.copyValues();
  builder.makeShells();
  return out;
}

// Calls work(n) for n below count, in batches on several threads.
template <class Work>
void PieceBuilder::inLots(std::size_t count, const Work& work) const {
  constexpr std::size_t kLot = 32;
  internal::forEach((count + kLot - 1) / kLot, is_parallel_, [&](std::size_t lot) {
    for (std::size_t n = lot * kLot; n < std::min(count, (lot + 1) * kLot); ++n) work(n);
  });
}

// Slots and directory: the part that the piece shares with the whole.
void PieceBuilder::takeSlots() {
  addSlots(placeLoaded());
  shareTouched();
}

// Enters the existing slots into the directory. A blank has a slot for every loaded brick in its loaded state: writes
// only differences.
std::vector<PieceBuilder::Part> PieceBuilder::placeLoaded() {
  std::vector<Part> parts;
  for (const auto* list : {&bricks_.bricks, &bricks_.interior})
    for (std::size_t begin = 0; begin < list->size(); begin += kBricksAPart)
      parts.push_back({std::span(*list).subspan(begin, std::min(kBricksAPart, list->size() - begin)), {}, 0});

  const bool is_blank = out_.slotCount() > 0;
  internal::forEach(parts.size(), is_parallel_, [&](std::size_t p) {
    Part& part = parts[p];
    for (const Vec3i& brick : part.bricks) {
      const std::size_t place = baked_.directory().indexOf(brick);
      assert(whole_.find(brick) >= 0);
      part.key += (coordKey(brick) + 1) * 0x9e3779b97f4a7c15ull;
      const int slot = is_blank ? baked_.directory().at(place) : -1;
      if (slot < 0)
        part.others.push_back(brick);
      else
        store_.directory_.set(place, slot);
    }
  });
  return parts;
}

// Makes slots for the bricks without one.
void PieceBuilder::addSlots(const std::vector<Part>& parts) {
  std::size_t slots = store_.slots_.size();
  for (const Part& part : parts) slots += part.others.size();
  if (slots + BrickStore::kMostAdded > store_.slots_.capacity()) {
    store_.reserveSlots(slots);
    out_.reserveLists(false);
  }

  for (const Part& part : parts) {
    store_.piece_key_ += part.key;
    for (const Vec3i& brick : part.others) {
      const std::size_t place = baked_.directory().indexOf(brick);
      const int loaded = baked_.directory().at(place);
      store_.directory_.set(place, out_.slotCount());
      store_.addLoaded(loaded < 0 ? baked_.air(brick) : baked_.slots()[static_cast<std::size_t>(loaded)]);
    }
  }
  store_.most_slots_ = slots + BrickStore::kMostAdded;  // firstSlotCount() uses it
  store_.brick_count_ = bricks_.bricks.size() + bricks_.interior.size();
}

// Values, materials and shells of the changed bricks: still those of the whole.
void PieceBuilder::shareTouched() {
  is_changed_.resize(store_.slots_.size());
  for (const int from : whole_.bricks().touched().numbers()) {
    const int slot = out_.find(whole_.slot(from).brick);
    if (slot < 0) continue;
    share(slot, whole_.slot(from));
    store_.touch(slot);
    if (out_.slot(slot).own) own_.push_back(slot);
  }
}

void PieceBuilder::share(int slot, const BrickSlot& from) {
  BrickSlot& to = out_.slot(slot);
  to.phi = from.phi;
  to.own = from.own;
  to.materials = from.materials;
  to.own_materials = from.own_materials;
  if (from.owns_shell) to.shell = from.shell;  // loaded shells come and go
  to.shell_count = from.shell_count;
  to.owns_shell = from.owns_shell;
  to.has_one_material = from.has_one_material;
  to.least = from.least;
  // Material was added where another piece's brick had been: the loaded materials there are not its own.
  if (!to.own_materials && to.own && std::memcmp(to.materials, to.baked_materials, kBrickNodes) != 0)
    to.own_materials = const_cast<std::uint8_t*>(to.materials);  // to be copied, as the whole's own are
}

// Points to the values of bricks near other pieces.
void PieceBuilder::takeChanged() {
  for (const BrickEdit& edit : bricks_.changed) {
    const int s = out_.find(edit.brick);
    is_changed_[static_cast<std::size_t>(s)] = 1;
    if (!out_.slot(s).own) own_.push_back(s);
    store_.touch(s);
    out_.slot(s).phi = edit.phi.data();
  }
}

// Copies all values that differ from the loaded ones.
void PieceBuilder::copyValues() {
  if (out_.freeBricks() < own_.size() + 64 && !out_.reserve(own_.size() + own_.size() / 2 + 64)) throw std::bad_alloc();
  inLots(own_.size(), [&](std::size_t n) {
    BrickSlot& slot = out_.slot(own_[n]);
    BrickVersion* version;
    {
      const std::lock_guard lock(mutex_);
      version = out_.memory_.takeVersion();
    }
    store_.copyInto(*version, own_[n], StrokeLog::kBeforeAll);
    if (is_changed_[static_cast<std::size_t>(own_[n])])
      slot.least = *std::min_element(slot.own, slot.own + kBrickNodes);
  });
  for (const int s : own_) out_.hash_.add(out_.slot(s), s, 0);
}

// A shell uses only gradients of its neighbours: one without nodes needs no update.
void PieceBuilder::makeShells() {
  const std::vector<int> shells = shellsToMake();
  inLots(shells.size(), [&](std::size_t n) { makeShell(shells[n]); });
}

// Whether its values or a neighbour's differ from the whole's, or a neighbour is missing.
bool PieceBuilder::needsNewShell(int s) const {
  if (whole_.dirtyCount() > 0 || is_changed_[static_cast<std::size_t>(s)]) return true;
  for (std::size_t face = 0; face < 6; ++face) {
    const Vec3i next = beside(out_.slot(s).brick, face);
    const int here = out_.find(next);
    if (here < 0 ? whole_.find(next) >= 0 : is_changed_[static_cast<std::size_t>(here)] != 0) return true;
  }
  return false;
}

// Slots that need a shell of their own, new or a copy, each once.
std::vector<int> PieceBuilder::shellsToMake() {
  std::vector<int> shells = store_.touched().numbers();
  const auto add = [&](const Vec3i& brick) {
    const int s = out_.find(brick);
    if (s < 0 || out_.slot(s).isListed(SlotBit::kTouched) || out_.slot(s).shell_count == 0 || !needsNewShell(s)) return;
    store_.touch(s);
    shells.push_back(s);
  };
  for (const BrickEdit& edit : bricks_.changed)
    for (std::size_t face = 0; face < 6; ++face) add(beside(edit.brick, face));
  for (const Vec3i& brick : bricks_.at_edge) add(brick);
  if (whole_.dirtyCount() > 0)
    for (std::size_t n = shells.size(); n-- > 0;)
      for (std::size_t face = 0; face < 6; ++face) add(beside(out_.slot(shells[n]).brick, face));

  std::erase_if(shells, [&](int s) { return !out_.slot(s).owns_shell && !needsNewShell(s); });
  return shells;
}

void PieceBuilder::makeShell(int s) {
  BrickSlot& slot = out_.slot(s);
  std::array<ShellChunk, kShellChunks> scratch;
  const bool is_new = needsNewShell(s);
  const int count =
      is_new ? shellOfBrick(store_.around(slot), slot.materials, out_.voxel(), scratch.data()) : slot.shell_count;
  const auto chunk_count = static_cast<std::size_t>(chunkCount(count));

  std::array<ShellChunk*, kShellChunks> chunks{};
  {
    const std::lock_guard lock(mutex_);
    for (std::size_t c = 0; c < chunk_count; ++c) {
      if (out_.memory_.freeChunks() == 0 && !out_.reserve(1024)) throw std::bad_alloc();
      chunks[c] = out_.memory_.takeChunk();
    }
  }

  for (std::size_t c = 0; c < chunk_count; ++c) *chunks[c] = is_new ? scratch[c] : slot.chunk(c);
  slot.setShell(std::span(chunks).first(chunk_count));
  slot.shell_count = static_cast<std::int16_t>(count);
  slot.owns_shell = true;
}

CutObject blankPiece(std::shared_ptr<const BakedObject> baked, std::size_t bricks) {
  return PieceBuilder::blank(std::move(baked), bricks);
}

CutObject makePiece(const CutObject& whole, const PieceBricks& bricks, std::unique_ptr<CutObject> blank,
                    bool is_parallel) {
  return PieceBuilder::make(whole, bricks, std::move(blank), is_parallel);
}

}  // namespace kerf
