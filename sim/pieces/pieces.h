// The pieces of an object that is being cut: connected parts of {phi < 0}, known again soon after every cut.
//
// Two inside nodes are connected when they are neighbours along an axis (6-connectivity): parts that touch at an edge
// or a corner of the grid only are two pieces.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "sim/object/overlay_field.h"

namespace kerf {

/// How much inside there is, in whole numbers, so that sums over pieces do not depend on their order and the ledger
/// balances to the last bit.
///
/// The cubes of h^3 around the inside nodes are a staircase that follows the surface; between both lies a gap of either
/// sign. Seen along an axis it is (t - 1/2) h deep at every edge that leaves the solid, t the place of the surface on
/// the edge by linear interpolation. Each axis sees the whole gap as far as the surface faces it, so the edges of one
/// inside node are weighted by the squares of the normal's components there (central differences): exact for planes
/// along the axes, second order for others. All of it is booked on inside nodes, and read from them and their six
/// neighbours alone. So every bit of volume belongs to exactly one piece, and to the same one whatever happens to the
/// other pieces.
struct SolidMeasure {
  std::uint64_t nodes = 0;  ///< inside nodes
  std::int64_t fringe = 0;  ///< sum of weight * (t - 1/2) over all crossed edges, in units of 2^-32, each rounded once

  void add(const SolidMeasure& o) {
    nodes += o.nodes;
    fringe += o.fringe;
  }
  bool operator==(const SolidMeasure&) const = default;
  /// mm^3. @param voxel mm. A ball of n voxels' radius comes out short by 0.5 / n^2 at most.
  double volume(double voxel) const {
    return voxel * voxel * voxel * (static_cast<double>(nodes) + static_cast<double>(fringe) * 0x1p-32);
  }
};

struct Piece {
  std::uint32_t id = 0;  ///< what PieceFinder::pieceAt() gives for its nodes
  SolidMeasure measure;
  double volume = 0;                 ///< mm^3, of `measure`
  Box3 bounds;                       ///< of its nodes, mm
  Vec3i first_node = Vec3i::Zero();  ///< its node with the smallest (x, y, z): tells pieces apart from call to call
};

struct PieceOptions {
  /// Pieces smaller than this are crumbs: chips that no one will pick up. 0: there are none.
  double crumb_mm3 = 0.1;
};

/// Pieces and crumbs, each largest first (equal ones by first_node). Ids count through: pieces first, then crumbs.
struct PieceList {
  std::vector<Piece> pieces, crumbs;
  SolidMeasure whole;  ///< the sum of all of them, exactly
};

/// Follows a field that changes brick by brick. Every brick's own parts are found once and again when the brick
/// changes; they are joined across faces, by one look at two masks of 64 bits where bricks have one part each, as
/// nearly all do. That is done block by block of 8^3 bricks, for those where something changed, and then with what the
/// blocks have in one part each. A brick inside that is stored as a constant is one part without being looked at. One
/// thread at a time.
class PieceFinder {
 public:
  /// @param phi0  kept by reference, must outlive this and not change.   Parallel inside; 2 us of a core per
  /// stored brick.
  explicit PieceFinder(const BrickField& phi0, const PieceOptions& options = {});
  /// Of a piece: these bricks of phi0 alone, which must be all that are near its inside nodes. What is near other
  /// pieces follows by apply(), as PieceOrigin has it.
  PieceFinder(const BrickField& phi0, std::span<const Vec3i> bricks, const PieceOptions& options = {});

  /// Takes the newest values of some bricks (a later edit of the same brick wins; new bricks may appear). 2 us each.
  void apply(std::span<const BrickEdit> edits);
  /// Pieces of the field as it is now. 40 ns a brick of the blocks that changed, and 1 us a block; no work when nothing
  /// has changed.
  const PieceList& find();

  static constexpr std::uint32_t kNoPiece = 0xffffffff, kSeveralPieces = 0xfffffffe;
  /// Piece of a node; kNoPiece outside. @pre find() was called after the last apply().
  std::uint32_t pieceAt(const Vec3i& node) const;
  /// Piece of all inside nodes of a brick; kNoPiece when it has none, kSeveralPieces when they differ. @pre as above.
  std::uint32_t pieceOfBrick(const Vec3i& brick) const;
  /// Pieces of all nodes of a brick, as pieceAt() gives them. @pre as above.
  void piecesIn(const Vec3i& brick, std::span<std::uint32_t, kBrickNodes> out) const;
  /// Calls visit(piece, low, high) for the connected parts of a brick, with the box of a part's nodes, counted in the
  /// brick: 0 to 7. @pre as above.
  template <class Visit>
  void forEachPart(std::uint32_t slot, const Visit& visit) const {
    const std::int32_t index = detail_of_[slot];
    const std::uint32_t* const piece = piecesOfBlock(slot);
    if (index == kFull) visit(piece[group_of_full_[slot]], Vec3i(0, 0, 0), Vec3i(7, 7, 7));
    if (index < 0) return;
    for (const Part& part : details_[static_cast<std::size_t>(index)].parts)
      visit(piece[part.group], Vec3i(part.low[0], part.low[1], part.low[2]),
            Vec3i(part.high[0], part.high[1], part.high[2]));
  }
  /// Calls visit(piece, offset) for the inside nodes of a box, counted in the brick, that have an outside node next to
  /// them along an axis, until it returns true; whether it did. @pre as above.
  template <class Visit>
  bool forEachOutermost(std::uint32_t slot, const Vec3i& low, const Vec3i& high, const Visit& visit) const {
    const std::int32_t index = detail_of_[slot];
    if (index < 0) return false;
    const Detail& d = details_[static_cast<std::size_t>(index)];
    const std::uint32_t* const piece = piecesOfBlock(slot);
    std::uint64_t in_box = 0;
    for (int y = low[1]; y <= high[1]; ++y) in_box |= (0xffull >> (7 - high[2]) & 0xffull << low[2]) << 8 * y;
    for (auto x = static_cast<std::size_t>(low[0]); x <= static_cast<std::size_t>(high[0]); ++x)
      for (std::uint64_t word = d.outermost[x] & in_box; word; word &= word - 1) {
        const std::size_t n = 64 * x + static_cast<std::size_t>(std::countr_zero(word));
        if (visit(piece[d.parts[d.label.empty() ? 0 : d.label[n]].group], static_cast<int>(n))) return true;
      }
    return false;
  }

  /// Slot of a brick, or -1: air. O(1), no search.
  std::int32_t slotOf(const Vec3i& brick) const {
    const Vec3i at = brick - low_;
    if ((at.array() < 0).any() || (at.array() >= size_.array()).any()) return kNoSlot;
    return directory_[static_cast<std::size_t>((at[0] * size_[1] + at[1]) * size_[2] + at[2])];
  }
  /// Calls visit(slot, step) for a brick and the 26 around it, those that have a slot.
  template <class Visit>
  void forEachAround(const Vec3i& brick, const Visit& visit) const {
    const Vec3i at = brick - low_;
    const Vec3i low = (-at).cwiseMax(-1), high = (size_ - Vec3i::Ones() - at).cwiseMin(1);
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y) {
        const std::int32_t* const row = directory_.data() + ((at[0] + x) * size_[1] + at[1] + y) * size_[2] + at[2];
        for (int z = low[2]; z <= high[2]; ++z)
          if (row[z] != kNoSlot) visit(static_cast<std::uint32_t>(row[z]), Vec3i(x, y, z));
      }
  }
  Vec3i brickOfSlot(std::uint32_t slot) const {
    const auto c = coordOfKey(keys_[slot]);
    return {c[0], c[1], c[2]};
  }
  std::uint32_t slotCount() const { return static_cast<std::uint32_t>(keys_.size()); }
  /// Whether phi0 has values there, not a constant.
  bool isBaked(std::uint32_t slot) const { return is_baked_[slot] != 0; }
  /// Whether it was air until it was edited: of a piece, whatever phi0 has there.
  bool wasAir(std::uint32_t slot) const { return slot >= first_count_; }
  bool hasAdded() const { return slotCount() > first_count_; }
  /// Of every slot, as pieceOfBrick(). @pre as above.
  void piecesOfSlots(std::vector<std::uint32_t>& out) const;
  /// Of every block of 8^3 bricks, the piece of all that is inside in it and the 26 around it; kSeveralPieces where
  /// they differ. @pre as above.
  std::vector<std::uint32_t> piecesInSight() const;
  std::size_t blockOfSlot(std::uint32_t slot) const { return block_of_[slot]; }

  const OverlayField& field() const { return field_; }

 private:
  using Bits = std::array<std::uint64_t, kBrickSide>;  // word x, bit 8 y + z: one per node
  using Faces = std::array<std::uint64_t, 6>;          // inside nodes of the faces -x, +x, -y, +y, -z, +z
  struct Part {                                        // connected inside one brick
    SolidMeasure measure;
    std::array<std::uint8_t, 3> low{}, high{};  // box of its nodes
    std::uint16_t first = 0;                    // offset of its first node
    std::uint32_t group = 0;                    // of its block
  };
  struct Detail {      // of a brick that is not all inside or all outside
    Bits bits{};       // inside nodes
    Bits outermost{};  // of them, those next to an outside node
    Faces faces{};
    std::vector<Part> parts;
    std::vector<std::uint16_t> label;  // part of each node (anything outside) when there are two parts or more
  };
  struct Group {  // parts connected inside one block
    SolidMeasure measure;
    Vec3i low, high;      // box of its nodes
    std::uint64_t first;  // key of its first node
  };
  struct Block {
    std::vector<std::int32_t> slots;
    std::array<std::int32_t, 3> above{kNoSlot, kNoSlot, kNoSlot};  // the next block along each axis
    std::vector<Group> groups;
    std::array<std::vector<std::pair<std::uint32_t, std::uint32_t>>, 3> joins;  // groups of this and the one above
    std::uint32_t first_group = 0;                                              // among those of all blocks
    bool is_changed = true;
  };
  static constexpr std::int32_t kOutside = -1, kFull = -2;  // in detail_of_, else an index
  static constexpr std::int32_t kNoSlot = -1;

  void scanAll();  // what keys_ has
  void layDirectory();
  std::uint32_t pieceOfSlot(std::size_t slot) const;
  const std::uint32_t* piecesOfBlock(std::size_t slot) const {
    return piece_of_group_.data() + blocks_[block_of_[slot]].first_group;
  }
  std::uint32_t groupOf(std::int32_t slot, std::uint32_t part) const;
  void addToBlock(std::int32_t slot);
  void group(Block& block);
  void joinAbove(Block& block, int axis) const;
  std::int32_t addSlot(const Vec3i& brick);
  static void labelParts(const BrickValues& phi, Detail& out);
  void measureFringe(std::int32_t slot);
  bool touchesOutside(std::int32_t slot) const;
  Detail& detailOf(std::int32_t slot);
  std::uint32_t partCount(std::int32_t slot) const;
  std::uint64_t face(std::int32_t slot, std::size_t side) const;
  std::uint32_t partAt(std::int32_t slot, int offset) const;
  template <class Unite>
  void joinBricks(std::int32_t a, std::int32_t b, int axis, const Unite& unite) const;

  OverlayField field_;
  PieceOptions options_;
  // Slots: one per brick that is stored, marked as interior, or was edited. The first ones are in order of their keys.
  std::vector<std::uint64_t> keys_;
  std::vector<unsigned char> is_baked_;
  std::size_t first_count_ = 0;                       // slots there were before the first edit
  Vec3i low_ = Vec3i::Zero(), size_ = Vec3i::Zero();  // of the directory: a box of bricks, z fastest
  std::vector<std::int32_t> directory_;
  std::vector<std::array<std::int32_t, 6>> neighbours_;
  std::vector<std::int32_t> detail_of_;
  std::vector<Detail> details_;
  // Of the last find().
  bool is_current_ = false;
  PieceList list_;
  std::vector<Block> blocks_;
  std::unordered_map<std::uint64_t, std::int32_t> block_at_;  // by key of brick / 8
  std::vector<std::uint32_t> block_of_;                       // per slot
  std::vector<std::uint32_t> group_of_full_;                  // per slot that is kFull
  std::vector<std::uint32_t> piece_of_group_;                 // of all blocks, one after the other
  // Scratch.
  std::vector<std::uint32_t> first_part_, parent_;
};

}  // namespace kerf
