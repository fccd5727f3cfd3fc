// The colour of each vertex of a chunk, from the materials just below its surface.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "geometry/field/material.h"
#include "sim/live/remesher.h"
#include "sim/object/baked_object.h"

namespace kerf {

/// Colours of a table of materials, by material number: linear light, for mixing.
class TissuePalette {
 public:
  /// Materials missing in the table are light grey.
  explicit TissuePalette(const MaterialTable& table);

  const Vec3f& colour(std::uint8_t material) const { return colours_[material]; }
  /// The same in sRGB, as in the table.
  const Rgba8& shown(std::uint8_t material) const { return shown_[material]; }
  /// 0 matte to 1 as if wet.
  float gloss(std::uint8_t material) const { return gloss_[material]; }
  /// Enamel lets dentin show through where it is thin.
  bool isTranslucent(std::uint8_t material) const { return material == static_cast<std::uint8_t>(Material::kEnamel); }

 private:
  std::array<Vec3f, 256> colours_;
  std::array<Rgba8, 256> shown_;
  std::array<float, 256> gloss_{};
};

/// Materials of an object, the source of its colours.
struct TissueLabels {
  /// 512 material numbers of a brick, in the order of its nodes; null: none. An object with added material has its own.
  std::function<const std::uint8_t*(const Vec3i& brick)> brick;
  const BrickField* baked = nullptr;       ///< before the cut; its voxel is that of the labels
  Material fallback = Material::kGeneric;  ///< for nodes without a label

  /// Labels as loaded. Keeps a reference to the object.
  static TissueLabels of(const BakedObject& object);
};

/// Cut share of a place: 0 on the surface as baked, 1 from 1.3 voxels below it. Between them it rises over a voxel, so
/// that the rim of a cavity is not serrated.
float cutShare(const BrickField& baked, const Vec3d& p);

/// One colour per vertex of the chunk: sRGB; alpha holds the gloss, 0 to 255. Materials are read within two voxels
/// below the surface and mixed over three of them, so that borders of tissues are soft, not stairs. Sound enamel takes
/// the colour of the tissue below it by exp(-thickness / 0.6 mm), so that a crown is ivory at the cusps and warmer at
/// the neck. Where the surface was cut (the baked field is about a voxel inside) tissue has its own colour, a shade
/// darker, and less gloss.
/// Pure: the same chunk, the same bytes. Any thread; about 0.7 µs per vertex.
std::vector<Rgba8> tissueColours(const MeshChunk& chunk, const TissueLabels& labels, const TissuePalette& palette);

/// The same for a neighbour: half as colourful, a shade bluer and darker.
void asNeighbour(std::vector<Rgba8>& colours);

}  // namespace kerf
