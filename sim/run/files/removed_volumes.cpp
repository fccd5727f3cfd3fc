#include "sim/run/files/removed_volumes.h"

#include <algorithm>
#include <array>
#include <vector>

#include "sim/object/baked_object.h"
#include "sim/object/node_volumes.h"
#include "sim/pieces/pieces.h"

namespace kerf::internal {
namespace {

// Counts bricks before and after a cut.
class CountedCut {
 public:
  CountedCut(const BrickField& phi0, const BrickField& cut, const MaterialsOf& before, const MaterialsOf& after)
      : phi0_(phi0), cut_(cut), materials_before_(before), materials_after_(after) {
    outside_.fill(phi0.background());
    inside_.fill(phi0.interior());
  }

  // The differing bricks and their neighbours: nodes there may have another neighbour.
  PartsByNumber removed() {
    std::vector<Vec3i> bricks;
    for (std::size_t b = 0; b < cut_.brickCount(); ++b) {
      bricks.push_back(cut_.brickCoord(b));
      for (int face = 0; face < 6; ++face) bricks.push_back(beside(cut_.brickCoord(b), face));
    }
    const auto isBefore = [](const Vec3i& a, const Vec3i& b) { return coordKey(a) < coordKey(b); };
    std::sort(bricks.begin(), bricks.end(), isBefore);
    bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());

    PartsByNumber before{}, after{};
    for (const Vec3i& brick : bricks) count(brick, before, after);
    for (std::size_t m = 0; m < before.size(); ++m) before[m] -= after[m];
    return before;
  }

 private:
  static Vec3i beside(Vec3i brick, int face) {
    brick[face / 2] += face & 1 ? 1 : -1;
    return brick;
  }

  const float* loaded(const Vec3i& brick) const {
    if (const BrickValues* const values = phi0_.valuesAt(brick)) return values->data();
    return phi0_.constantAt(brick) < 0 ? inside_.data() : outside_.data();
  }

  const float* now(const Vec3i& brick) const {
    const BrickValues* const values = cut_.valuesAt(brick);
    return values ? values->data() : loaded(brick);
  }

  void count(const Vec3i& brick, PartsByNumber& before, PartsByNumber& after) {
    BrickNeighborhood was{loaded(brick), {}}, is{now(brick), {}};
    for (int face = 0; face < 6; ++face) {
      const Vec3i other = beside(brick, face);
      was.face[face] = loaded(other);
      is.face[face] = now(other);
    }
    addVolumes(was, materialsAround(brick, materials_before_), phi0_.background(), before);
    const bool is_relabelled = &materials_before_ != &materials_after_;
    const MaterialNeighborhood numbers = is_relabelled ? materialsAround(brick, materials_after_) : neighborhood();
    addVolumes(is, numbers, phi0_.background(), after);
  }

  // The materials last read into numbers_.
  MaterialNeighborhood neighborhood() const {
    MaterialNeighborhood out{numbers_[0].data(), {}, false};
    for (std::size_t face = 0; face < 6; ++face) out.face[face] = numbers_[1 + face].data();
    return out;
  }

  MaterialNeighborhood materialsAround(const Vec3i& brick, const MaterialsOf& materials) {
    materials(brick, numbers_[0]);
    for (int face = 0; face < 6; ++face) materials(beside(brick, face), numbers_[static_cast<std::size_t>(1 + face)]);
    return neighborhood();
  }

  const BrickField& phi0_;
  const BrickField& cut_;
  const MaterialsOf& materials_before_;
  const MaterialsOf& materials_after_;
  BrickValues outside_, inside_;
  std::array<std::array<std::uint8_t, kBrickNodes>, 7> numbers_;
};

}  // namespace

double commonVolume(const BrickField& phi0, const BrickField& one, const BrickField& other) {
  BrickField both(phi0.voxel(), phi0.background(), phi0.interior());
  for (std::size_t b = 0; b < one.brickCount(); ++b) {
    const BrickValues* const second = other.valuesAt(one.brickCoord(b));
    if (!second) continue;
    BrickValues values = one.brick(b);
    for (std::size_t n = 0; n < kBrickNodes; ++n) values[n] = std::min(values[n], (*second)[n]);
    both.add(one.brickCoord(b), values);
  }
  const VolumeByNumber volumes = removedVolumes(phi0, both, [](const Vec3i&, auto out) { std::ranges::fill(out, 0); });
  return volumes[0];
}

double addedVolume(const BrickField& phi0, const BrickField& cut, const MaterialBricks& known) {
  const auto rounding = static_cast<float>(0.01 * phi0.voxel());
  BrickField added(phi0.voxel(), phi0.background(), phi0.interior());
  for (std::size_t b = 0; b < cut.brickCount(); ++b) {
    const Vec3i brick = cut.brickCoord(b);
    if (known.find(brick)) continue;
    const BrickValues* const was = phi0.valuesAt(brick);
    const float constant = phi0.constantAt(brick);
    BrickValues values = cut.brick(b);
    bool is_other = false;
    for (std::size_t n = 0; n < kBrickNodes; ++n) {
      const float before = was ? (*was)[n] : constant;
      const bool is_added = values[n] < before - rounding;
      if (!is_added) values[n] = before;
      is_other |= is_added;
    }
    if (is_other) added.add(brick, values);
  }
  if (added.isEmpty()) return 0;
  const VolumeByNumber volumes = removedVolumes(phi0, added, [](const Vec3i&, auto out) { std::ranges::fill(out, 0); });
  return std::max(0.0, -volumes[0]);
}

PieceCount countPieces(const BrickField& phi0, const BrickField& cut) {
  PieceFinder finder(phi0);
  std::vector<BrickEdit> edits(cut.brickCount());
  for (std::size_t b = 0; b < edits.size(); ++b) edits[b] = {cut.brickCoord(b), cut.brick(b)};
  finder.apply(edits);
  const PieceList& found = finder.find();
  return {found.pieces.size(), found.crumbs.size()};
}

BrickField withoutPlaneFaces(BrickField cut, const BrickField& phi0, std::span<const RunManifest::Piece> pieces) {
  std::vector<CutPlanes> closed;
  for (const RunManifest::Piece& piece : pieces)
    for (const PlaneSide& side : piece.sides) {
      const auto isOther = [&](const PlaneSide& s) { return s.cut == side.cut && !s.is_above; };
      const auto hasOther = [&](const RunManifest::Piece& other) { return std::ranges::any_of(other.sides, isOther); };
      const bool is_new = std::ranges::find(closed, side.planes) == closed.end();
      if (side.is_above && side.planes.kerf_mm == 0 && is_new && std::ranges::any_of(pieces, hasOther))
        closed.push_back(side.planes);
    }
  if (closed.empty()) return cut;

  for (std::size_t b = 0; b < cut.brickCount(); ++b) {
    const Vec3i coord = cut.brickCoord(b);
    const BrickValues* const stored = phi0.valuesAt(coord);
    for (int n = 0; n < kBrickNodes; ++n) {
      const auto i = static_cast<std::size_t>(n);
      const float before = stored ? (*stored)[i] : phi0.constantAt(coord);
      float& now = cut.brick(b)[i];
      if (now == before || now > 0) continue;
      const Vec3d p = phi0.position(coord * kBrickSide + Vec3i{n >> 6, n >> 3 & 7, n & 7});
      for (const CutPlanes& planes : closed)
        if (now == std::max(before, -static_cast<float>(std::abs(planes.heightAtPlanes(p, true))))) now = before;
    }
  }
  return cut;
}

VolumeByNumber removedVolumes(const BrickField& phi0, const BrickField& cut, const MaterialsOf& materials) {
  return removedVolumes(phi0, cut, materials, materials);
}

VolumeByNumber removedVolumes(const BrickField& phi0, const BrickField& cut, const MaterialsOf& before,
                              const MaterialsOf& after) {
  const PartsByNumber parts = CountedCut(phi0, cut, before, after).removed();
  const double part = volumeOfPart(phi0.voxel());
  VolumeByNumber out{};
  for (std::size_t m = 0; m < parts.size(); ++m) out[m] = addParts(0, parts[m], part);
  return out;
}

MaterialsOf materialsOf(const MaterialField& materials, Material fallback) {
  return [&materials, fallback](const Vec3i& brick, std::span<std::uint8_t, kBrickNodes> out) {
    materials.copyBrick(brick, out);
    std::replace(out.begin(), out.end(), std::uint8_t{0}, static_cast<std::uint8_t>(fallback));
  };
}

MaterialsOf materialsOf(const BakedObject& object) {
  return [&object](const Vec3i& brick, std::span<std::uint8_t, kBrickNodes> out) {
    const std::int32_t s = object.directory().find(brick);
    const std::uint8_t* const from =
        s < 0 ? object.fallbackMaterials() : object.slots()[static_cast<std::size_t>(s)].materials;
    std::copy_n(from, kBrickNodes, out.begin());
  };
}

}  // namespace kerf::internal
