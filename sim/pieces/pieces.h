// The pieces of an object during cutting: connected parts of {phi < 0}, updated soon after every cut.
//
//   node    a point of the grid; inside where phi < 0. Inside nodes are connected when they are neighbours along an
//           axis (6-connectivity): nodes that touch across an edge or a corner are not.
//   part    inside nodes that are connected within one brick
//   group   parts that are connected within one block
//   piece   groups that are connected within the object
//
//   a brick: 8^3 nodes       a block: 8^3 bricks (here two)     the object: all its blocks
//   # inside  . outside      letters are parts                  letters are groups
//
//     # # # . . # # #        +-----------+-----------+          +-----------+-----------+
//     # # # . . # # #        |  a     b==|==c        |          |  P        |  S        |
//     # # # . . # # .        |           |           |          |  Q========|==R        |
//     # # . . . . . .        |           |        d  |          |           |           |
//                            +-----------+-----------+          +-----------+-----------+
//     two parts              four parts, three groups:          four groups, three pieces:
//                            {a}, {b, c}, {d}                   {P}, {Q, R}, {S}
//                            b == c: they meet in the face      Q == R: parts of theirs do
//
// Computed values, and their updates:
//
// for each  value                                       updated when                                    cost
// brick     inside nodes as bits, parts, faces          its values change                              2 us, with
//           outermost nodes, fringe of its measure      ... or the values of its six neighbours        the fringe
// block     groups: parts joined across brick faces     a brick in it changed                          40 ns a brick
//           joins: groups that meet in the next blocks  this block or the next one changed
// object    pieces, sorted by volume                    anything changed                               1 us a block
//
// apply() updates bricks and marks their blocks. find() does the rest. A brick that is stored as the
// constant inside is one part: its nodes are not read.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "geometry/field/brick_directory.h"
#include "sim/object/overlay_field.h"
#include "sim/pieces/brick_parts.h"
#include "sim/pieces/solid_measure.h"

namespace kerf {

struct Piece {
  std::uint32_t id = 0;  ///< value of PieceFinder::pieceAt() for its nodes
  SolidMeasure measure;
  double volume = 0;                 ///< mm^3, of `measure`
  Box3 bounds;                       ///< of its nodes, mm
  Vec3i first_node = Vec3i::Zero();  ///< its node with the smallest (x, y, z): identifies pieces from call to call
};

struct PieceOptions {
  /// Pieces smaller than this are crumbs: chips too small to pick up. 0: no crumbs.
  double crumb_mm3 = 0.1;
};

/// Pieces and crumbs, each largest first (equal ones by first_node). Ids count through: pieces first, then crumbs.
struct PieceList {
  std::vector<Piece> pieces, crumbs;
  SolidMeasure whole;  ///< exact sum of all of them
};

/// Follows a field that changes brick by brick, and finds its pieces: see the picture above. Bricks go by slots: one
/// for each brick that is stored, marked as interior, or was edited. One thread at a time.
class PieceFinder {
 public:
  /// @param phi0  kept by reference, must outlive this and not change.   Parallel inside; 2 us of a core per stored
  ///   brick.
  explicit PieceFinder(const BrickField& phi0, const PieceOptions& options = {});
  /// For a piece: only these bricks of phi0. They must include every brick near its inside nodes. The values near other
  /// pieces follow by apply(), from PieceOrigin.
  PieceFinder(const BrickField& phi0, std::span<const Vec3i> bricks, const PieceOptions& options = {});

  /// Takes the newest values of some bricks (a later edit of the same brick wins; new bricks may appear). 2 us each.
  void apply(std::span<const BrickEdit> edits);
  /// Pieces of the current field. 40 ns a brick of the blocks that changed, and 1 us a block; no work without changes.
  const PieceList& find();

  // Look-up. @pre of all of these: find() was called after the last apply().

  static constexpr std::uint32_t kNoPiece = 0xffffffff, kSeveralPieces = 0xfffffffe;
  /// Piece of a node; kNoPiece outside.
  std::uint32_t pieceAt(const Vec3i& node) const;
  /// Piece of all inside nodes of a brick; kNoPiece when it has none, kSeveralPieces when they differ.
  std::uint32_t pieceOfBrick(const Vec3i& brick) const;
  /// Pieces of all nodes of a brick, as pieceAt() gives them.
  void piecesIn(const Vec3i& brick, std::span<std::uint32_t, kBrickNodes> out) const;
  /// For every slot, as pieceOfBrick().
  void piecesOfSlots(std::vector<std::uint32_t>& out) const;
  /// For every block, the piece of all inside nodes in it and the 26 blocks around it; kSeveralPieces where they
  /// differ.
  std::vector<std::uint32_t> piecesInSight() const;

  /// Calls visit(piece, low, high) for the parts of a brick. low, high: box of a part's nodes, counted in the brick, 0
  /// to 7.
  template <class Visit>
  void forEachPart(std::uint32_t slot, const Visit& visit) const {
    const std::int32_t index = parts_of_[slot];
    const std::uint32_t* const piece = piecesOfBlock(slot);
    if (index == kFull) visit(piece[group_of_full_[slot]], Vec3i(0, 0, 0), Vec3i(7, 7, 7));
    if (index < 0) return;
    for (const internal::BrickPart& part : parts_[static_cast<std::size_t>(index)].parts)
      visit(piece[part.group], Vec3i(part.low[0], part.low[1], part.low[2]),
            Vec3i(part.high[0], part.high[1], part.high[2]));
  }

  /// Calls visit(piece, offset) for those inside nodes of a box, counted in the brick, that have an outside node next
  /// to them along an axis. Stops when it returns true. @return whether it did.
  template <class Visit>
  bool forEachOutermost(std::uint32_t slot, const Vec3i& low, const Vec3i& high, const Visit& visit) const {
    const std::int32_t index = parts_of_[slot];
    if (index < 0) return false;
    const internal::BrickParts& brick = parts_[static_cast<std::size_t>(index)];
    const std::uint32_t* const piece = piecesOfBlock(slot);

    std::uint64_t in_box = 0;
    for (int y = low[1]; y <= high[1]; ++y) in_box |= (0xffull >> (7 - high[2]) & 0xffull << low[2]) << 8 * y;
    for (auto x = static_cast<std::size_t>(low[0]); x <= static_cast<std::size_t>(high[0]); ++x)
      for (std::uint64_t word = brick.outermost[x] & in_box; word; word &= word - 1) {
        const std::size_t n = 64 * x + static_cast<std::size_t>(std::countr_zero(word));
        if (visit(piece[brick.parts[brick.partAt(n)].group], static_cast<int>(n))) return true;
      }
    return false;
  }

  // Slots.

  std::uint32_t slotCount() const { return static_cast<std::uint32_t>(keys_.size()); }
  /// Slot of a brick, or -1: air. O(1), no search.
  std::int32_t slotOf(const Vec3i& brick) const { return directory_.find(brick); }
  /// Calls visit(slot, step) for a brick and the 26 around it, if they have a slot.
  template <class Visit>
  void forEachAround(const Vec3i& brick, const Visit& visit) const {
    directory_.forEachAround(
        brick, [&](std::int32_t slot, const Vec3i& step) { visit(static_cast<std::uint32_t>(slot), step); });
  }
  Vec3i brickOfSlot(std::uint32_t slot) const { return internal::coordOf(keys_[slot]); }
  std::size_t blockOfSlot(std::uint32_t slot) const { return block_of_[slot]; }
  /// Whether phi0 has values there, not a constant.
  bool isBaked(std::uint32_t slot) const { return is_baked_[slot] != 0; }
  /// Whether it was air before an edit. In a piece phi0 may have any value there.
  bool wasAir(std::uint32_t slot) const { return slot >= first_count_; }
  bool hasAdded() const { return slotCount() > first_count_; }

  const OverlayField& field() const { return field_; }

 private:
  struct Group {  // parts connected inside one block
    SolidMeasure measure;
    Vec3i low, high;      // box of its nodes
    std::uint64_t first;  // key of its first node
    void add(const Group& other);
  };
  struct Block {
    std::vector<std::int32_t> slots;
    std::array<std::int32_t, 3> above{kNoSlot, kNoSlot, kNoSlot};  // the next block along each axis
    std::vector<Group> groups;
    std::array<std::vector<std::pair<std::uint32_t, std::uint32_t>>, 3> joins;  // groups of this and the one above
    std::uint32_t first_group = 0;                                              // among the groups of all blocks
    bool is_changed = true;
  };
  static constexpr std::int32_t kOutside = -1, kFull = -2;  // in parts_of_, else an index
  static constexpr std::int32_t kNoSlot = BrickDirectory::kNone;
  static constexpr std::size_t indexOf(std::int32_t number) { return static_cast<std::size_t>(number); }

  // Slots: pieces.cpp.
  void scanAll();  // scans the slots in keys_
  void layDirectory();
  void findNeighbors();
  std::int32_t addSlot(const Vec3i& brick);
  void addToBlock(std::int32_t slot);

  // Bricks: pieces.cpp.
  internal::BrickParts& partsOf(std::int32_t slot);
  std::uint32_t partCount(std::int32_t slot) const;
  std::uint64_t face(std::int32_t slot, std::size_t side) const;
  std::uint64_t faceBeside(std::int32_t slot, std::size_t side) const;
  bool touchesOutside(std::int32_t slot) const;
  void measureFringeOf(std::int32_t slot);

  // Blocks and pieces: piece_groups.cpp.
  template <class Unite>
  void joinBricks(std::int32_t a, std::int32_t b, int axis, const Unite& unite) const;
  void uniteParts(const Block& block);
  void groupParts(Block& block);
  void joinAbove(Block& block, int axis) const;
  void joinBlocks();
  std::vector<Group> mergeGroups();
  void listPieces(const std::vector<Group>& found);

  // Look-up: piece_lookup.cpp.
  std::uint32_t partAt(std::int32_t slot, int offset) const;
  std::uint32_t groupOf(std::int32_t slot, std::uint32_t part) const;
  std::uint32_t pieceOfSlot(std::size_t slot) const;
  const std::uint32_t* piecesOfBlock(std::size_t slot) const {
    return piece_of_group_.data() + blocks_[block_of_[slot]].first_group;
  }

  OverlayField field_;
  PieceOptions options_;

  // Per slot. The first ones are in order of their keys.
  std::vector<std::uint64_t> keys_;
  std::vector<unsigned char> is_baked_;
  std::vector<std::array<std::int32_t, 6>> neighbors_;
  std::vector<std::int32_t> parts_of_;  // index in parts_, or kOutside, or kFull
  std::vector<std::uint32_t> block_of_;
  std::vector<std::uint32_t> group_of_full_;  // for slots that are kFull
  std::size_t first_count_ = 0;               // number of slots before the first edit
  BrickDirectory directory_;

  std::vector<internal::BrickParts> parts_;  // of bricks that are neither all inside nor all outside

  std::vector<Block> blocks_;
  std::unordered_map<std::uint64_t, std::int32_t> block_at_;  // by key of brick / 8

  // Result of the last find().
  bool is_current_ = false;
  PieceList list_;
  std::vector<std::uint32_t> piece_of_group_;  // for the groups of all blocks, one after the other

  // Scratch of groupParts(): for the slots of one block, the number of their first part, and the union-find tree.
  std::vector<std::uint32_t> first_part_, parent_;
};

}  // namespace kerf
