// The visible surface during the cut: marching cubes of changed bricks only.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "geometry/field/marching_cubes.h"
#include "sim/object/overlay_field.h"

namespace kerf {

/// The surface in the cells of one brick, in the graphics card's format. A chunk never changes: a newer one replaces
/// it.
struct MeshChunk {
  Vec3i brick = Vec3i::Zero();  ///< brick coordinate, names the chunk
  std::uint64_t version = 0;    ///< the Remesher's version at creation; newer chunks have higher ones
  std::vector<Vec3f> vertices;  ///< mm, object frame: the positions of marchingCubes(), rounded to float32
  std::vector<Vec3f> normals;   ///< one per vertex: unit, outward, gradient of the field; seamless across chunks
  std::vector<std::array<std::uint16_t, 3>> triangles;  ///< counter-clockwise seen from outside
  std::vector<Rgba8> colours;                           ///< one per vertex, or none: see RemesherOptions::finish
  std::vector<std::uint8_t> occlusion;                  ///< like colours
  /// One per vertex, or none: like `colours`, but with the scanner's colours where the scan's own surface is left.
  std::vector<Rgba8> scan_colours;

  bool isEmpty() const { return triangles.empty(); }
};
using MeshChunkPtr = std::shared_ptr<const MeshChunk>;

struct RemesherOptions {
  MarchingCubesOptions marching_cubes{};
  /// All cores mesh the baked surface; false: the calling thread alone, so that no core is taken from others, and under
  /// ThreadSanitizer, which cannot see into Debian's TBB. The chunks are the same.
  bool is_parallel = true;
  /// Adds colours and occlusion to a new chunk, from the current field. Called by the meshing threads, several at once
  /// in the beginning. Empty: chunks have neither.
  std::function<void(MeshChunk& chunk, const OverlayField& field)> finish{};
};

/// Keeps the mesh of a field that changes brick by brick.
///
/// After every call of apply() the chunks together, welded where positions are bit-equal, are the triangles that
/// marchingCubes() would give for the whole current field: closed and 2-manifold, for any edits in any order. For that
/// every brick whose cells read a changed node is meshed again: the node's own brick, and up to seven or 26 around it
/// when the node, or the box of all changed nodes, comes near to their faces.
/// One thread at a time. Any thread may read chunks; they do not change.
class Remesher {
 public:
  /// Meshes the whole baked field: 20 µs of one core per brick with surface in it.
  /// @param phi0  kept by reference, must outlive this and not change.
  explicit Remesher(const BrickField& phi0, const RemesherOptions& options = {});

  /// Takes the newest values of some bricks (a later edit of the same brick wins; new bricks may appear) and remeshes
  /// the bricks that they affect. Runs on the calling thread alone, to leave the haptic thread its core: 12 µs per
  /// remeshed brick, 2 ms for 60 bricks changed by a bur. Returns the number of remeshed bricks.
  std::size_t apply(std::span<const BrickEdit> edits);

  /// Rises with every apply() that changed the mesh; 1 after construction.
  std::uint64_t version() const { return version_; }
  /// Chunks newer than a version, oldest first, each brick once; an empty chunk means that no surface is left there. 0
  /// gives everything. O(changed chunks).
  std::vector<MeshChunkPtr> changedSince(std::uint64_t version) const;

  /// This replica of phi.
  const OverlayField& field() const { return field_; }

 private:
  std::pair<Vec3i, Vec3i> changedNodes(const BrickEdit& edit) const;
  bool remesh(const Vec3i& brick);  // true: the chunk changed
  void compactLog();

  OverlayField field_;
  RemesherOptions options_;
  std::uint64_t version_ = 1;
  std::unordered_map<std::uint64_t, MeshChunkPtr> chunks_;  // by key of the brick; never iterated
  std::vector<MeshChunkPtr> log_;  // in order of version; outdated ones are skipped, and dropped now and then
  BrickSurface surface_;           // scratch
  std::vector<std::uint64_t> dirty_;
};

}  // namespace kerf
