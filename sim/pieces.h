// The pieces of an object that is being cut: connected parts of {phi < 0}, known again soon after every cut.
//
// Two inside nodes are connected when they are neighbours along an axis (6-connectivity): parts that touch at an edge
// or a corner of the grid only are two pieces.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "sim/overlay_field.h"

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

  void add(const SolidMeasure& o) { nodes += o.nodes, fringe += o.fringe; }
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
/// changes; finding the pieces joins them across faces: one look at two masks of 64 bits where bricks have one part
/// each, as nearly all do. A brick inside that is stored as a constant is one part without being looked at. One thread
/// at a time.
class PieceFinder {
 public:
  /// @param phi0  kept by reference, must outlive this and not change.   Parallel inside; 2 us of a core per
  /// stored brick.
  explicit PieceFinder(const BrickField& phi0, const PieceOptions& options = {});

  /// Takes the newest values of some bricks (a later edit of the same brick wins; new bricks may appear). 2 us each.
  void apply(std::span<const BrickEdit> edits);
  /// Pieces of the field as it is now. O(bricks with inside nodes), about 40 ns each; no work when nothing has changed.
  const PieceList& find();

  static constexpr std::uint32_t kNoPiece = 0xffffffff, kSeveralPieces = 0xfffffffe;
  /// Piece of a node; kNoPiece outside. @pre find() was called after the last apply().
  std::uint32_t pieceAt(const Vec3i& node) const;
  /// Piece of all inside nodes of a brick; kNoPiece when it has none, kSeveralPieces when they differ. @pre as above.
  std::uint32_t pieceOfBrick(const Vec3i& brick) const;
  /// Pieces of all nodes of a brick, as pieceAt() gives them. @pre as above.
  void piecesIn(const Vec3i& brick, std::span<std::uint32_t, kBrickNodes> out) const;
  /// Inside nodes of another piece may lie within so many nodes of a brick, along each axis. False: none does. @pre as
  /// above.
  bool hasOthersWithin(const Vec3i& brick, int reach, std::uint32_t piece) const;
  struct InsideBrick {
    Vec3i brick;
    std::uint32_t piece;  ///< as pieceOfBrick()
  };
  /// The bricks that hold inside nodes, each once. @pre as above.
  std::vector<InsideBrick> insideBricks() const;

  const OverlayField& field() const { return field_; }

 private:
  using Bits = std::array<std::uint64_t, kBrickSide>;  // word x, bit 8 y + z: one per node
  using Faces = std::array<std::uint64_t, 6>;          // inside nodes of the faces -x, +x, -y, +y, -z, +z
  struct Part {                                        // connected inside one brick
    SolidMeasure measure;
    std::array<std::uint8_t, 3> low{}, high{};  // box of its nodes
    std::uint16_t first = 0;                    // offset of its first node
  };
  struct Detail {  // of a brick that is not all inside or all outside
    Bits bits{};
    Faces faces{};
    std::vector<Part> parts;
    std::vector<std::uint16_t> label;  // part of each node (anything outside) when there are two parts or more
  };
  static constexpr std::int32_t kOutside = -1, kFull = -2;  // in detail_of_, else an index
  static constexpr std::int32_t kNoSlot = -1;

  std::int32_t slotOf(const Vec3i& brick) const;
  std::uint32_t pieceOfSlot(std::size_t slot) const;
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
  std::size_t sorted_ = 0;
  std::unordered_map<std::uint64_t, std::int32_t> later_;
  std::vector<std::array<std::int32_t, 6>> neighbours_;
  std::vector<std::int32_t> detail_of_;
  std::vector<Detail> details_;
  // Of the last find().
  bool is_current_ = false;
  PieceList list_;
  std::vector<std::uint32_t> first_part_;  // per slot, into piece_of_part_
  std::vector<std::uint32_t> piece_of_part_;
};

}  // namespace kerf
