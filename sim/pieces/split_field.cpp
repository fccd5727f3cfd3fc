#include "sim/pieces/split_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "sim/object/for_each.h"
#include "sim/object/huge_pages.h"
#include "sim/pieces/cut_size.h"
#include "sim/pieces/near_balls.h"

namespace kerf {
namespace {

// As PieceBricks, without values.
struct Bricks {
  std::vector<Vec3i> bricks, interior, changed, at_edge;
};

// One of `changed`, whose values are wanted.
struct Wanted {
  std::uint64_t brick;
  std::size_t piece, edit;
};

constexpr std::uint32_t kSlotsAtOnce = 4096;

std::uint32_t lotsOf(const PieceFinder& pieces) { return (pieces.slotCount() + kSlotsAtOnce - 1) / kSlotsAtOnce; }

}  // namespace

struct SplitPool::Lists {
  std::vector<std::uint32_t> piece_of;  // see Split
  std::vector<unsigned char> is_stored;
  std::vector<Bricks> parts;  // of lots of bricks, for each piece
  std::vector<Wanted> wanted;
  std::vector<std::size_t> begin;  // of what is wanted of one brick
  std::vector<PieceBricks> out;
};

SplitPool::SplitPool() : lists_(std::make_unique<Lists>()) {}
SplitPool::~SplitPool() = default;
SplitPool::SplitPool(SplitPool&&) noexcept = default;
SplitPool& SplitPool::operator=(SplitPool&&) noexcept = default;

void SplitPool::reserve(const PieceFinder& finder, std::size_t pieces) {
  const std::size_t slots = finder.slotCount(), edited = finder.field().changed().brickCount();
  // As many are near another piece as were cut, or fewer. More than is wanted now, and once for a whole cut: it must
  // not be made anew while one goes through.
  const std::size_t changed = edited + 512, more_changed = std::max(2 * changed, internal::bricksOfACut(slots));
  const std::size_t added = slots + 512, more = slots + slots / 16 + 4096;
  Lists& to = *lists_;
  internal::reserveTouched(to.piece_of, added, more);
  internal::reserveTouched(to.is_stored, added, more);
  internal::reserveTouched(to.wanted, pieces * changed, pieces * more_changed);
  internal::reserveTouched(to.begin, pieces * changed, pieces * more_changed);
  to.parts.resize(pieces * lotsOf(finder));
  for (Bricks& part : to.parts) {
    for (auto* list : {&part.bricks, &part.interior}) internal::reserveTouched(*list, kSlotsAtOnce, kSlotsAtOnce);
    for (auto* list : {&part.changed, &part.at_edge})
      internal::reserveTouched(*list, kSlotsAtOnce / 8, kSlotsAtOnce / 8);
  }
  to.out.resize(std::max(to.out.size(), pieces));
  for (PieceBricks& piece : std::span(to.out).first(pieces)) {
    for (auto* list : {&piece.bricks, &piece.interior}) internal::reserveTouched(*list, added, more);
    internal::reserveTouched(piece.at_edge, changed, more_changed);
    internal::reserveTouched(piece.changed, changed, more_changed);
  }
}

void SplitPool::takeBack(PieceBricks&& bricks) {
  for (PieceBricks& piece : lists_->out)
    if (piece.bricks.capacity() == 0) {
      piece = std::move(bricks);
      piece.bricks.clear();
      piece.interior.clear();
      piece.changed.clear();
      piece.at_edge.clear();
      return;
    }
}

namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

/// What is common to the pieces that are made at a time. Bricks go by their slots in the finder; -1 is air.
struct Split {
  Split(const PieceFinder& finder, bool is_parallel, SplitPool::Lists& lists)
      : pieces(finder), piece_of(lists.piece_of), is_stored(lists.is_stored) {
    internal::forEach(3, is_parallel, [&](std::size_t n) {
      if (n == 0) finder.piecesOfSlots(lists.piece_of);
      if (n == 1) in_sight = finder.piecesInSight();
      if (n == 2) findStored(lists.is_stored);
    });
    // A ball's radius is a voxel at most: no farther than the band and that, and than the bricks around.
    const OverlayField& field = finder.field();
    const int reach = static_cast<int>(std::ceil(double{field.background()} / field.voxel()));
    steps = internal::NodeSteps(std::clamp(reach, 1, kBrickSide - 1), static_cast<float>(field.voxel()));
  }
  void findStored(std::vector<unsigned char>& out) {
    const OverlayField& field = pieces.field();
    out.resize(pieces.slotCount());
    for (std::uint32_t s = 0; s < pieces.slotCount(); ++s) out[s] = pieces.isBaked(s);
    // What was taken back is as if it had never been: the result depends on the values, not on how they came about.
    for (std::size_t b = 0; b < field.changed().brickCount(); ++b) {
      const Vec3i& c = field.changed().brickCoord(b);
      const auto s = static_cast<std::size_t>(pieces.slotOf(c));
      if (out[s]) continue;
      const float constant = pieces.wasAir(static_cast<std::uint32_t>(s)) ? field.background() : field.constantAt(c);
      const BrickValues& values = field.changed().brick(b);
      out[s] = std::any_of(values.begin(), values.end(), [&](float v) { return v != constant; });
    }
  }
  /// Calls visit(slot, step) for the bricks around one, and itself, that hold something inside.
  template <class Visit>
  void forEachAround(const Vec3i& brick, const Visit& visit) const {
    pieces.forEachAround(brick, [&](std::uint32_t slot, const Vec3i& step) {
      if (piece_of[slot] != PieceFinder::kNoPiece) visit(slot, step);
    });
  }
  /// Of them, and kSeveralPieces or kNoPiece.
  std::uint32_t onlyPieceAround(const Vec3i& brick) const {
    std::uint32_t out = PieceFinder::kNoPiece;
    pieces.forEachAround(brick, [&](std::uint32_t slot, const Vec3i&) {
      const std::uint32_t its = piece_of[slot];
      if (its != PieceFinder::kNoPiece && its != out)
        out = out == PieceFinder::kNoPiece ? its : PieceFinder::kSeveralPieces;
    });
    return out;
  }
  /// As forEachAround(), with the box of the nodes of each that are within reach of the brick, counted in their own.
  template <class Visit>
  void forEachWithinReach(const Vec3i& brick, const Visit& visit) const {
    constexpr int kLast = kBrickSide - 1;
    forEachAround(brick, [&](std::uint32_t slot, const Vec3i& step) {
      const Vec3i shift = step * kBrickSide;
      visit(slot, step, (Vec3i::Constant(-steps.reach()) - shift).cwiseMax(0),
            (Vec3i::Constant(kLast + steps.reach()) - shift).cwiseMin(kLast));
    });
  }
  /// Whether the brick is in a piece, or an outermost node of it is within reach.
  bool isWithinReach(const Vec3i& brick, std::uint32_t id) const {
    const std::int32_t own = pieces.slotOf(brick);
    if (own >= 0 && piece_of[static_cast<std::size_t>(own)] == id) return true;
    bool out = false;
    forEachWithinReach(brick, [&](std::uint32_t slot, const Vec3i&, const Vec3i& low, const Vec3i& high) {
      if (out || (piece_of[slot] != id && piece_of[slot] != PieceFinder::kSeveralPieces)) return;
      out = pieces.forEachOutermost(slot, low, high, [&](std::uint32_t piece, int) { return piece == id; });
    });
    return out;
  }

  const PieceFinder& pieces;
  const std::vector<std::uint32_t>& piece_of;   // per slot: as PieceFinder::pieceOfBrick()
  std::vector<std::uint32_t> in_sight;          // per block: PieceFinder::piecesInSight()
  const std::vector<unsigned char>& is_stored;  // per slot: whether it has values, not a constant
  internal::NodeSteps steps{1, 1};
};

// Some bricks one after the other, and which pieces have them.
class LayOut {
 public:
  LayOut(const Split& split, std::uint32_t first, std::span<Bricks> out) : split_(split), first_(first), out_(out) {}

  void add(std::uint32_t slot) {
    const std::uint32_t id = split_.in_sight[split_.pieces.blockOfSlot(slot)];
    if (id != PieceFinder::kSeveralPieces) {
      if (!isWanted(id)) return;
      Bricks& to = out_[id - first_];
      if (split_.is_stored[slot]) {
        to.bricks.push_back(split_.pieces.brickOfSlot(slot));
        if (split_.piece_of[slot] != id) to.at_edge.push_back(to.bricks.back());
      } else if (split_.piece_of[slot] == id) {
        to.interior.push_back(split_.pieces.brickOfSlot(slot));
      }
      return;
    }
    // Its own, and those around them; a constant that is nobody's is air.
    const bool is_stored = split_.is_stored[slot] != 0;
    const std::uint32_t its = split_.piece_of[slot];
    if (!is_stored && its == PieceFinder::kNoPiece) return;
    const Vec3i brick = split_.pieces.brickOfSlot(slot);
    if (const std::uint32_t near = split_.onlyPieceAround(brick); near != PieceFinder::kSeveralPieces)
      near_.assign(near == PieceFinder::kNoPiece ? 0 : 1, near);
    else
      lookAround(brick);
    for (const std::uint32_t near : near_) {
      if (!isWanted(near)) continue;
      Bricks& to = out_[near - first_];
      if (!is_stored && its == near) {
        to.interior.push_back(brick);
        continue;
      }
      to.bricks.push_back(brick);
      if (its != near) to.at_edge.push_back(brick);
      if (near_.size() > 1 && hasOthersWithinReach(near)) to.changed.push_back(brick);
    }
  }

 private:
  struct Around {
    std::uint32_t slot;
    Vec3i shift;  // of its nodes
  };
  bool isWanted(std::uint32_t id) const { return id >= first_ && id - first_ < out_.size(); }
  // The bricks with something inside, and whose that is.
  void lookAround(const Vec3i& brick) {
    around_.clear();
    near_.clear();
    const auto add = [&](std::uint32_t piece) {
      if (std::find(near_.begin(), near_.end(), piece) == near_.end()) near_.push_back(piece);
    };
    split_.forEachAround(brick, [&](std::uint32_t slot, const Vec3i& step) {
      around_.push_back({slot, step * kBrickSide});
      if (split_.piece_of[slot] != PieceFinder::kSeveralPieces)
        add(split_.piece_of[slot]);
      else
        split_.pieces.forEachPart(slot, [&](std::uint32_t piece, const Vec3i&, const Vec3i&) { add(piece); });
    });
  }
  // Whether inside nodes of another piece may be, along each axis.
  bool hasOthersWithinReach(std::uint32_t id) const {
    const int reach = split_.steps.reach();
    const Vec3i low = Vec3i::Constant(-reach), high = Vec3i::Constant(kBrickSide - 1 + reach);
    return std::any_of(around_.begin(), around_.end(), [&](const Around& at) {
      bool out = false;
      if (split_.piece_of[at.slot] != id)
        split_.pieces.forEachPart(at.slot, [&](std::uint32_t piece, const Vec3i& part_low, const Vec3i& part_high) {
          out |= piece != id && ((part_low + at.shift).array() <= high.array()).all() &&
                 ((part_high + at.shift).array() >= low.array()).all();
        });
      return out;
    });
  }

  const Split& split_;
  std::uint32_t first_;
  std::span<Bricks> out_;
  std::vector<Around> around_;
  std::vector<std::uint32_t> near_;
};

// Which bricks the pieces have; those of `changed` without their values.
std::vector<PieceBricks> layOut(const Split& split, std::uint32_t first, std::size_t count, bool is_parallel,
                                SplitPool::Lists& lists) {
  const std::uint32_t slots = split.pieces.slotCount(), lots = lotsOf(split.pieces);
  std::vector<Bricks>& parts = lists.parts;
  if (parts.size() < lots * count) parts.resize(lots * count);
  internal::forEach(lots, is_parallel, [&](std::size_t lot) {
    const std::span<Bricks> to = std::span(parts).subspan(lot * count, count);
    for (Bricks& part : to) {
      part.bricks.clear();
      part.interior.clear();
      part.changed.clear();
      part.at_edge.clear();
    }
    LayOut lay(split, first, to);
    const auto begin = static_cast<std::uint32_t>(lot) * kSlotsAtOnce;
    for (std::uint32_t s = begin; s < std::min(slots, begin + kSlotsAtOnce); ++s) lay.add(s);
  });
  const auto isBefore = [](const Vec3i& a, const Vec3i& b) { return coordKey(a) < coordKey(b); };
  std::vector<PieceBricks> out(count);
  for (std::size_t n = 0; n < std::min(count, lists.out.size()); ++n) out[n] = std::move(lists.out[n]);
  internal::forEach(count, is_parallel, [&](std::size_t n) {
    const auto join = [&](std::vector<Vec3i> Bricks::*list, std::vector<Vec3i>& to) {
      std::size_t size = 0;
      for (std::size_t lot = 0; lot < lots; ++lot) size += (parts[lot * count + n].*list).size();
      to.reserve(size);
      for (std::size_t lot = 0; lot < lots; ++lot) {
        const std::vector<Vec3i>& from = parts[lot * count + n].*list;
        to.insert(to.end(), from.begin(), from.end());
      }
      if (!split.pieces.hasAdded()) return;  // what was added after the finder's first look comes last
      const auto added = std::is_sorted_until(to.begin(), to.end(), isBefore);
      std::sort(added, to.end(), isBefore);
      std::inplace_merge(to.begin(), added, to.end(), isBefore);
    };
    join(&Bricks::bricks, out[n].bricks);
    join(&Bricks::interior, out[n].interior);
    join(&Bricks::at_edge, out[n].at_edge);
    std::vector<Vec3i> changed;
    join(&Bricks::changed, changed);
    out[n].changed.resize(changed.size());
    for (std::size_t e = 0; e < changed.size(); ++e) out[n].changed[e].brick = changed[e];
  });
  return out;
}

// Distances of the nodes of one brick to the pieces near it. Looks at one after the other.
class NearPieces {
 public:
  /// As the union of balls of radius |phi| about a piece's outermost nodes: |p - a| + phi(a).
  void look(const Split& split, const Vec3i& brick) {
    const OverlayField& field = split.pieces.field();
    const BrickValues* const values = field.valuesAt(brick);
    values_ = values ? *values : BrickValues{};
    if (!values) values_.fill(field.constantAt(brick));
    split.pieces.piecesIn(brick, piece_of_);
    count_ = 0;
    split.forEachWithinReach(brick, [&](std::uint32_t slot, const Vec3i& step, const Vec3i& low, const Vec3i& high) {
      const Vec3i shift = step * kBrickSide;
      const BrickValues* phi = nullptr;
      bool is_known = false;
      Piece* last = nullptr;
      split.pieces.forEachOutermost(slot, low, high, [&](std::uint32_t id, int n) {
        const int i = shift[0] + (n >> 6), j = shift[1] + (n >> 3 & 7), k = shift[2] + (n & 7);
        if (!last || last->id != id) last = &piece(id);
        Piece& to = *last;
        markAround(to, i, j, k);
        if (!is_known) {
          is_known = true;
          phi = field.valuesAt(brick + step);
        }
        to.balls.push_back({i, j, k, phi ? (*phi)[static_cast<std::size_t>(n)] : field.interior()});
        return false;
      });
    });
    for (Piece& p : used()) internal::nearBalls(p.balls, split.steps, p.distance);
  }
  /// Of the brick.
  const BrickValues& values() const { return values_; }
  const std::array<std::uint32_t, kBrickNodes>& pieceOf() const { return piece_of_; }
  /// Distance of every node to the piece, mm, infinite beyond reach; null: it is nowhere near.
  const BrickValues* to(std::uint32_t id) const {
    const Piece* p = find(id);
    return p ? &p->distance : nullptr;
  }
  /// To the nearest other one.
  void toOthers(std::uint32_t id, BrickValues& out) const {
    out.fill(kFar);
    for (const Piece& p : used())
      if (p.id != id)
        for (std::size_t n = 0; n < out.size(); ++n) out[n] = std::min(out[n], p.distance[n]);
  }
  /// Of every node, whether an inside node of the piece is next to it; null: it is nowhere near.
  const std::array<unsigned char, kBrickNodes>* isNextTo(std::uint32_t id) const {
    const Piece* p = find(id);
    return p ? &p->is_next : nullptr;
  }

 private:
  struct Piece {
    std::uint32_t id;
    std::vector<internal::NodeBall> balls;
    BrickValues distance;
    std::array<unsigned char, kBrickNodes> is_next;
  };
  std::span<Piece> used() { return std::span(pieces_).first(count_); }
  std::span<const Piece> used() const { return std::span(pieces_).first(count_); }
  const Piece* find(std::uint32_t id) const {
    for (const Piece& p : used())
      if (p.id == id) return &p;
    return nullptr;
  }
  Piece& piece(std::uint32_t id) {
    for (Piece& p : used())
      if (p.id == id) return p;
    if (count_ == pieces_.size()) pieces_.emplace_back();
    Piece& p = pieces_[count_++];
    p.id = id;
    p.distance.fill(kFar);
    p.is_next.fill(0);
    p.balls.clear();
    return p;
  }
  static void markAround(Piece& piece, int i, int j, int k) {
    if (std::min({i, j, k}) < -1 || std::max({i, j, k}) > kBrickSide) return;
    const auto mark = [&](int x, int y, int z) {
      if (((x | y | z) & ~(kBrickSide - 1)) == 0) piece.is_next[static_cast<std::size_t>(nodeOffset(x, y, z))] = 1;
    };
    mark(i - 1, j, k);
    mark(i + 1, j, k);
    mark(i, j - 1, k);
    mark(i, j + 1, k);
    mark(i, j, k - 1);
    mark(i, j, k + 1);
  }
  BrickValues values_;
  std::array<std::uint32_t, kBrickNodes> piece_of_;
  std::vector<Piece> pieces_;  // kept, for their memory: the first count_ are in use
  std::size_t count_ = 0;
};

// The values of one brick of a piece.
void separate(const Split& split, const NearPieces& near, std::uint32_t id, BrickValues& out) {
  const OverlayField& field = split.pieces.field();
  const float h = static_cast<float>(field.voxel()), background = field.background();
  const auto& piece_of = near.pieceOf();
  const BrickValues* const own = near.to(id);
  const auto* const is_next = near.isNextTo(id);
  BrickValues others;
  near.toOthers(id, others);
  out = near.values();
  for (std::size_t n = 0; n < kBrickNodes; ++n) {
    if (piece_of[n] == id) continue;
    const bool is_outside = piece_of[n] == PieceFinder::kNoPiece;
    if (is_outside && ((is_next && (*is_next)[n]) || others[n] == kFar)) continue;
    // Nearer to this piece: the value stays, unless it must be another's after all (balls miss sharp corners).
    const float to_own = own ? (*own)[n] : kFar;
    const float distance_to_own = is_outside && to_own <= others[n] ? to_own - 0.5f * h : to_own;
    out[n] = std::min(background, std::max(std::abs(out[n]), distance_to_own));
  }
}

std::vector<PieceBricks> bricksOf(const PieceFinder& pieces, std::uint32_t first, std::size_t count, bool is_parallel,
                                  SplitPool::Lists& lists) {
  const Split split(pieces, is_parallel, lists);
  std::vector<PieceBricks> out = layOut(split, first, count, is_parallel, lists);
  // What two pieces have near each other is looked at once.
  std::vector<Wanted>& wanted = lists.wanted;
  wanted.clear();
  for (std::size_t p = 0; p < count; ++p)
    for (std::size_t e = 0; e < out[p].changed.size(); ++e) wanted.push_back({coordKey(out[p].changed[e].brick), p, e});
  std::sort(wanted.begin(), wanted.end(), [](const Wanted& a, const Wanted& b) {
    return a.brick != b.brick ? a.brick < b.brick : a.piece < b.piece;
  });
  std::vector<std::size_t>& begin = lists.begin;
  begin.clear();
  for (std::size_t n = 0; n < wanted.size(); ++n)
    if (n == 0 || wanted[n].brick != wanted[n - 1].brick) begin.push_back(n);
  begin.push_back(wanted.size());
  constexpr std::size_t kAtOnce = 16;
  const std::size_t groups = begin.size() - 1;
  internal::forEach((groups + kAtOnce - 1) / kAtOnce, is_parallel, [&](std::size_t lot) {
    NearPieces beside;
    for (std::size_t g = lot * kAtOnce; g < std::min(groups, (lot + 1) * kAtOnce); ++g) {
      bool has_searched = false;
      for (std::size_t n = begin[g]; n < begin[g + 1]; ++n) {
        const std::uint32_t id = first + static_cast<std::uint32_t>(wanted[n].piece);
        BrickEdit& edit = out[wanted[n].piece].changed[wanted[n].edit];
        if (!split.isWithinReach(edit.brick, id)) {  // as most: they are another piece's alone
          edit.phi.fill(pieces.field().background());
          continue;
        }
        if (!has_searched) beside.look(split, edit.brick);
        has_searched = true;
        separate(split, beside, id, edit.phi);
      }
    }
  });
  return out;
}

}  // namespace

std::vector<PieceBricks> bricksOfPieces(const PieceFinder& pieces, std::size_t count, bool is_parallel,
                                        SplitPool* room) {
  SplitPool fresh;
  return bricksOf(pieces, 0, count, is_parallel, *(room ? *room : fresh).lists_);
}

BrickField splitField(const PieceFinder& pieces, std::uint32_t id) {
  const OverlayField& field = pieces.field();
  SplitPool::Lists lists;
  const PieceBricks piece = std::move(bricksOf(pieces, id, 1, true, lists).front());
  BrickField out(field.voxel(), field.background(), field.interior());
  for (const Vec3i& c : piece.interior) out.markInterior(c);
  out.reserve(piece.bricks.size());
  std::size_t next = 0;
  for (const Vec3i& c : piece.bricks) {
    const bool is_changed = next < piece.changed.size() && piece.changed[next].brick == c;
    out.add(c, is_changed ? piece.changed[next++].phi : *field.valuesAt(c));
  }
  return out;
}

}  // namespace kerf
