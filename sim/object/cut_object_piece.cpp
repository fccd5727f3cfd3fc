// How a piece of an object becomes an object: CutObject::blank() and piece().
#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <mutex>
#include <new>
#include <span>
#include <utility>
#include <vector>

#include "sim/object/cut_object.h"
#include "sim/object/for_each.h"
#include "sim/object/huge_pages.h"

namespace kerf {

CutObject CutObject::blank(std::shared_ptr<const BakedObject> baked, std::size_t bricks) {
  CutObject out(OfPiece{}, std::move(baked));
  out.is_piece_ = true;
  const std::size_t slots = out.baked_->slots().size();
  internal::reserveLarge(out.directory_, out.baked_->directory().size());
  out.directory_.assign(out.baked_->directory().size(), -1);
  out.reserveSlots(slots + kMostAdded);
  out.slots_.resize(out.most_slots_);
  out.slots_.clear();
  for (const BakedObject::Slot& from : out.baked_->slots()) out.addLoaded(from);
  for (std::vector<int>* list : {&out.dirty_, &out.export_, &out.watch_, &out.stale_, &out.touched_, &out.to_repair_}) {
    list->resize(out.most_slots_);
    list->clear();
  }
  if (!out.reserve(bricks)) throw std::bad_alloc();
  return out;
}

// Makes a piece of an object. Of the whole, what the thread that cuts goes on to write is not read.
class CutObject::PieceMaking {
 public:
  PieceMaking(const CutObject& whole, const PieceBricks& bricks, CutObject& out, bool is_parallel)
      : whole_(whole), baked_(*whole.baked_), bricks_(bricks), out_(out), is_parallel_(is_parallel) {
    for (const auto* list : {&bricks.bricks, &bricks.interior})
      for (std::size_t begin = 0; begin < list->size(); begin += kAtOnce)
        parts_.push_back({std::span(*list).subspan(begin, std::min(kAtOnce, list->size() - begin)), {}, 0});
  }

  void make() {
    takeSlots();
    takeChanged();
    takeValues();
    takeShells();
  }

 private:
  static constexpr std::size_t kAtOnce = 4096;
  struct Part {
    std::span<const Vec3i> bricks;
    std::vector<Vec3i> others;  // that have no slot yet
    std::uint64_t key;
  };

  std::size_t placeOf(const Vec3i& brick) const {
    const Vec3i at = brick - baked_.directoryLow();
    const Vec3i& size = baked_.directorySize();
    return static_cast<std::size_t>((at[0] * size[1] + at[1]) * size[2] + at[2]);
  }
  static Vec3i beside(Vec3i brick, int face) {
    brick[face / 2] += face & 1 ? 1 : -1;
    return brick;
  }
  void takeOver(int slot, const Slot& from) {
    Slot& to = out_.slot(slot);
    to.phi = from.phi;
    to.own = from.own;
    to.materials = from.materials;
    to.own_materials = from.own_materials;
    to.chunks = from.chunks;
    to.shell_count = from.shell_count;
    to.owns_shell = from.owns_shell;
    to.has_one_material = from.has_one_material;
    to.least = from.least;
    // Added where another piece's brick had been: what was loaded there is not what it is made of.
    if (!to.own_materials && to.own && std::memcmp(to.materials, to.baked_materials, kBrickNodes) != 0)
      to.own_materials = const_cast<std::uint8_t*>(to.materials);  // to be copied, as the whole's own are
  }

  void takeSlots() {
    // A blank has a slot for every brick that was loaded, as it was then: only what differs is written.
    const bool is_blank = out_.slotCount() > 0;
    internal::forEach(parts_.size(), is_parallel_, [&](std::size_t p) {
      Part& part = parts_[p];
      for (const Vec3i& brick : part.bricks) {
        const std::size_t place = placeOf(brick);
        assert(whole_.directory_[place] >= 0);
        part.key += (coordKey(brick) + 1) * 0x9e3779b97f4a7c15ull;
        const int slot = is_blank ? baked_.directory()[place] : -1;
        if (slot < 0)
          part.others.push_back(brick);
        else
          out_.directory_[place] = slot;
      }
    });
    std::size_t slots = out_.slots_.size();
    for (const Part& part : parts_) slots += part.others.size();
    if (slots + kMostAdded > out_.slots_.capacity()) out_.reserveSlots(slots);
    for (Part& part : parts_) {
      out_.piece_key_ += part.key;
      for (const Vec3i& brick : part.others) {
        const std::size_t place = placeOf(brick);
        const int loaded = baked_.directory()[place];
        out_.directory_[place] = out_.slotCount();
        out_.addLoaded(loaded < 0 ? baked_.air(brick) : baked_.slots()[static_cast<std::size_t>(loaded)]);
      }
    }
    out_.most_slots_ = slots + kMostAdded;  // firstSlotCount() goes by it
    out_.brick_count_ = bricks_.bricks.size() + bricks_.interior.size();
    is_changed_.resize(slots);
    for (const int from : whole_.touched_) {
      const int slot = out_.find(whole_.slot(from).brick);
      if (slot < 0) continue;
      takeOver(slot, whole_.slot(from));
      out_.touch(slot);
      if (out_.slot(slot).own) own_.push_back(slot);
    }
  }

  void takeChanged() {
    for (const BrickEdit& edit : bricks_.changed) {
      const int s = out_.find(edit.brick);
      is_changed_[static_cast<std::size_t>(s)] = 1;
      if (!out_.slot(s).own) own_.push_back(s);
      out_.touch(s);
      out_.slot(s).phi = edit.phi.data();
    }
  }

  void takeValues() {
    if (out_.freeBricks() < own_.size() + 64 && !out_.reserve(own_.size() + own_.size() / 2 + 64))
      throw std::bad_alloc();
    inLots(own_.size(), [&](std::size_t n) {
      Slot& slot = out_.slot(own_[n]);
      BrickVersion* version;
      {
        const std::lock_guard lock(mutex_);
        version = out_.free_versions_.popFront();
      }
      out_.fillVersion(*version, own_[n], nullptr, 0);
      if (is_changed_[static_cast<std::size_t>(own_[n])])
        slot.least = *std::min_element(slot.own, slot.own + kBrickNodes);
    });
    for (const int s : own_) {
      out_.slot(s).is_hash_stale = true;
      out_.stale_.push_back(s);
    }
  }

  // New ones where values or those of a neighbour are other than the whole's, or a neighbour is no longer there.
  // Gradients are all that a shell has of its neighbours: one without nodes stays as it is.
  void takeShells() {
    const bool is_repaired = whole_.dirtyCount() == 0;
    const auto isNew = [&](int s) {
      if (!is_repaired || is_changed_[static_cast<std::size_t>(s)]) return true;
      for (int face = 0; face < 6; ++face) {
        const Vec3i next = beside(out_.slot(s).brick, face);
        const int here = out_.find(next);
        if (here < 0 ? whole_.find(next) >= 0 : is_changed_[static_cast<std::size_t>(here)] != 0) return true;
      }
      return false;
    };
    // These only can be: each once.
    std::vector<int> shells = out_.touched_;
    const auto add = [&](const Vec3i& brick) {
      const int s = out_.find(brick);
      if (s < 0 || out_.slot(s).is_touched || out_.slot(s).shell_count == 0 || !isNew(s)) return;
      out_.touch(s);
      shells.push_back(s);
    };
    for (const BrickEdit& edit : bricks_.changed)
      for (int face = 0; face < 6; ++face) add(beside(edit.brick, face));
    for (const Vec3i& brick : bricks_.at_edge) add(brick);
    for (std::size_t n = is_repaired ? 0 : shells.size(); n-- > 0;)
      for (int face = 0; face < 6; ++face) add(beside(out_.slot(shells[n]).brick, face));
    std::erase_if(shells, [&](int s) { return !out_.slot(s).owns_shell && !isNew(s); });
    inLots(shells.size(), [&](std::size_t n) {
      Slot& slot = out_.slot(shells[n]);
      std::array<ShellChunk, kShellChunks> scratch;
      const bool is_new = isNew(shells[n]);
      const int count =
          is_new ? shellOfBrick(out_.around(slot), slot.materials, out_.voxel(), scratch.data()) : slot.shell_count;
      std::array<const ShellChunk*, kShellChunks> chunks{};
      {
        const std::lock_guard lock(mutex_);
        for (int c = 0; c < chunkCount(count); ++c) {
          if (out_.free_chunks_.isEmpty() && !out_.reserve(1024)) throw std::bad_alloc();
          chunks[static_cast<std::size_t>(c)] = &out_.free_chunks_.popFront()->chunk;
        }
      }
      for (std::size_t c = 0; c < static_cast<std::size_t>(chunkCount(count)); ++c)
        *const_cast<ShellChunk*>(chunks[c]) = is_new ? scratch[c] : *slot.chunks[c];
      slot.chunks = chunks;
      slot.shell_count = static_cast<std::int16_t>(count);
      slot.owns_shell = true;
    });
  }

  template <class Work>
  void inLots(std::size_t count, const Work& work) {
    constexpr std::size_t kLot = 32;
    internal::forEach((count + kLot - 1) / kLot, is_parallel_, [&](std::size_t lot) {
      for (std::size_t n = lot * kLot; n < std::min(count, (lot + 1) * kLot); ++n) work(n);
    });
  }

  const CutObject& whole_;
  const BakedObject& baked_;
  const PieceBricks& bricks_;
  CutObject& out_;
  bool is_parallel_;
  std::vector<Part> parts_;
  std::vector<int> own_;                   // slots with values other than loaded
  std::vector<unsigned char> is_changed_;  // slots whose values are not the whole's
  std::mutex mutex_;                       // of the lists of room
};

CutObject CutObject::piece(const CutObject& whole, const PieceBricks& bricks, std::unique_ptr<CutObject> made,
                           bool is_parallel) {
  CutObject out = made && made->baked_ == whole.baked_ ? std::move(*made) : CutObject(OfPiece{}, whole.baked_);
  if (out.slots_.empty()) {
    out.is_piece_ = true;
    out.directory_.assign(whole.directory_.size(), -1);
    out.reserveSlots(bricks.bricks.size() + bricks.interior.size());
  }
  out.T_world_object = whole.T_world_object;
  PieceMaking(whole, bricks, out, is_parallel).make();
  return out;
}

}  // namespace kerf
