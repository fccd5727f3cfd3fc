#include "sim/live/remesher.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>

namespace kerf {
namespace {

MeshChunkPtr makeChunk(const Vec3i& brick, std::uint64_t version, const BrickSurface& surface,
                       const RemesherOptions& options, const OverlayField& field) {
  auto chunk = std::make_shared<MeshChunk>();
  chunk->brick = brick;
  chunk->version = version;
  chunk->vertices.reserve(surface.positions.size());
  for (const Vec3d& p : surface.positions) chunk->vertices.push_back(p.cast<float>());
  chunk->normals = surface.normals;
  chunk->triangles.reserve(surface.triangles.size());
  for (const Triangle& t : surface.triangles)  // at most 3 edges per node of 9^3 and 4 loops per cell: fits
    chunk->triangles.push_back(
        {static_cast<std::uint16_t>(t[0]), static_cast<std::uint16_t>(t[1]), static_cast<std::uint16_t>(t[2])});
  if (options.finish && !chunk->isEmpty()) options.finish(*chunk, field);
  return chunk;
}

bool isSame(const MeshChunk& chunk, const BrickSurface& surface) {
  if (chunk.vertices.size() != surface.positions.size() || chunk.triangles.size() != surface.triangles.size())
    return false;
  for (std::size_t v = 0; v < chunk.vertices.size(); ++v)
    if (chunk.vertices[v] != Vec3f(surface.positions[v].cast<float>()) || chunk.normals[v] != surface.normals[v])
      return false;
  for (std::size_t t = 0; t < chunk.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      if (chunk.triangles[t][k] != surface.triangles[t][k]) return false;
  return true;
}

}  // namespace

Remesher::Remesher(const BrickField& phi0, const RemesherOptions& options) : field_(phi0), options_(options) {
  // As in marchingCubes(): cells that reach a stored brick belong to it or to one of the seven below.
  std::vector<std::uint64_t> keys;
  keys.reserve(8 * phi0.brickCount());
  for (std::size_t b = 0; b < phi0.brickCount(); ++b)
    for (int n = 0; n < 8; ++n) keys.push_back(coordKey(Vec3i(phi0.brickCoord(b) - Vec3i{n >> 2, n >> 1 & 1, n & 1})));
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  std::vector<MeshChunkPtr> made(keys.size());
  const auto mesh = [&](std::size_t first, std::size_t last) {
    BrickSurface surface;
    for (std::size_t n = first; n != last; ++n) {
      const auto c = coordOfKey(keys[n]);
      const Vec3i brick{c[0], c[1], c[2]};
      marchingCubesOfBrick(neighboursOf(phi0, brick), options_.marching_cubes, true, surface);
      if (!surface.triangles.empty()) made[n] = makeChunk(brick, version_, surface, options_, field_);
    }
  };
  if (options_.is_parallel)
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, keys.size(), 64),
                      [&](const auto& range) { mesh(range.begin(), range.end()); });
  else
    mesh(0, keys.size());

  for (std::size_t n = 0; n < keys.size(); ++n)
    if (made[n]) {
      chunks_.emplace(keys[n], made[n]);
      log_.push_back(std::move(made[n]));
    }
}

bool Remesher::remesh(const Vec3i& brick) {
  marchingCubesOfBrick(neighboursOf(field_, brick), options_.marching_cubes, true, surface_);
  const std::uint64_t key = coordKey(brick);
  const auto it = chunks_.find(key);
  if (it == chunks_.end() ? surface_.triangles.empty() : isSame(*it->second, surface_)) return false;
  MeshChunkPtr chunk = makeChunk(brick, version_ + 1, surface_, options_, field_);
  chunks_[key] = chunk;  // stores an empty chunk too: readers must replace the older one
  log_.push_back(std::move(chunk));
  return true;
}

// The box of changed nodes, in the brick's own coordinates: low, high; high < low: none.
std::pair<Vec3i, Vec3i> Remesher::changedNodes(const BrickEdit& edit) const {
  const BrickValues* const before = field_.valuesAt(edit.brick);
  const float constant = field_.constantAt(edit.brick);
  Vec3i low = Vec3i::Constant(kBrickSide), high = Vec3i::Constant(-1);
  std::size_t at = 0;
  for (int i = 0; i < kBrickSide; ++i)
    for (int j = 0; j < kBrickSide; ++j)
      for (int k = 0; k < kBrickSide; ++k, ++at)
        if (std::bit_cast<std::uint32_t>(edit.phi[at]) !=
            std::bit_cast<std::uint32_t>(before ? (*before)[at] : constant)) {
          low = low.cwiseMin(Vec3i{i, j, k});
          high = high.cwiseMax(Vec3i{i, j, k});
        }
  return {low, high};
}

std::size_t Remesher::apply(std::span<const BrickEdit> edits) {
  dirty_.clear();
  for (const BrickEdit& edit : edits) {
    const auto [low, high] = changedNodes(edit);
    if (high[0] < 0) continue;
    field_.set(edit);

    // A node's value enters the corrected values (and the normals) of its neighbours, one node away; those enter the
    // cells whose lowest corner is up to one node further down.
    const Vec3i first = brickOf(Vec3i(edit.brick * kBrickSide + low - Vec3i::Constant(2)));
    const Vec3i last = brickOf(Vec3i(edit.brick * kBrickSide + high + Vec3i::Constant(1)));
    for (int x = first[0]; x <= last[0]; ++x)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int z = first[2]; z <= last[2]; ++z) dirty_.push_back(coordKey(x, y, z));
  }
  std::sort(dirty_.begin(), dirty_.end());
  dirty_.erase(std::unique(dirty_.begin(), dirty_.end()), dirty_.end());

  bool changed = false;
  for (const std::uint64_t key : dirty_) {
    const auto c = coordOfKey(key);
    changed |= remesh({c[0], c[1], c[2]});
  }
  if (changed) ++version_;
  compactLog();
  return dirty_.size();
}

void Remesher::compactLog() {
  if (log_.size() < 2 * chunks_.size() + 1024) return;
  std::erase_if(log_, [&](const MeshChunkPtr& c) { return chunks_.find(coordKey(c->brick))->second != c; });
}

std::vector<MeshChunkPtr> Remesher::changedSince(std::uint64_t version) const {
  std::vector<MeshChunkPtr> out;
  auto it = std::upper_bound(log_.begin(), log_.end(), version,
                             [](std::uint64_t v, const MeshChunkPtr& c) { return v < c->version; });
  for (; it != log_.end(); ++it)
    if (chunks_.find(coordKey((*it)->brick))->second == *it) out.push_back(*it);
  return out;
}

}  // namespace kerf
