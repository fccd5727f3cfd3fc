// The colour of each vertex of a chunk, from what the object is made of just below its surface.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "geometry/field/material.h"
#include "sim/live/remesher.h"
#include "sim/object/baked_object.h"

namespace kerf {

/// What a table of materials says about colours, by material number: linear light, as colours are mixed.
class TissuePalette {
 public:
  /// Materials that the table lacks are light grey.
  explicit TissuePalette(const MaterialTable& table);

  const Vec3f& colour(std::uint8_t material) const { return colours_[material]; }
  /// The same in sRGB, as the table says.
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

/// What an object is made of, where its colours come from.
struct TissueLabels {
  /// 512 material numbers of a brick, in the order of its nodes; null: none. For an object to which material was added,
  /// its own.
  std::function<const std::uint8_t*(const Vec3i& brick)> brick;
  const BrickField* baked = nullptr;       ///< as it was before it was cut; its voxel is that of the labels
  Material fallback = Material::kGeneric;  ///< where there is no label

  /// As loaded. Keeps a reference to the object.
  static TissueLabels of(const BakedObject& object);
};

/// How much of a place was cut: 0 on the surface as baked, 1 from 1.3 voxels below it; between them a slope of a voxel,
/// so that the rim of a cavity is no row of teeth.
float cutShare(const BrickField& baked, const Vec3d& p);

/// One colour per vertex of the chunk: sRGB, and in the place of alpha how glossy it is, 0 to 255. Materials are read
/// within two voxels below the surface and mixed over three of them, so that borders of tissues are soft, not stairs.
/// Sound enamel takes the colour of what lies below it by exp(-thickness / 0.6 mm), so that a crown is ivory at the
/// cusps and warmer at the neck. Where the surface was cut (the baked field is about a voxel inside) tissue has its own
/// colour, a shade darker, and less gloss.
/// Pure: the same chunk, the same bytes. Any thread; about 0.7 µs per vertex.
std::vector<Rgba8> tissueColours(const MeshChunk& chunk, const TissueLabels& labels, const TissuePalette& palette);

/// The same for an object that stands beside the one that is worked on: half as colourful, a shade bluer and darker.
void asNeighbour(std::vector<Rgba8>& colours);

}  // namespace kerf
