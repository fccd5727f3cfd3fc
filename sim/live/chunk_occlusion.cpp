#include "sim/live/chunk_occlusion.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kerf {
namespace {

/// The field at any point. Caches bricks: neighbouring vertices need the same few.
template <class Field>
class Sampler {
 public:
  explicit Sampler(const Field& field) : field_(field), nodes_per_mm_(1 / field.voxel()) {}

  /// Trilinear, mm.
  double at(const Vec3d& p) {
    const Vec3d q = nodes_per_mm_ * p;
    const Vec3i low = q.array().floor().cast<int>().matrix();
    const Vec3d t = q - low.cast<double>();
    double along_z[2][2];
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) {
        const double a = node(low[0] + i, low[1] + j, low[2]);
        const double b = node(low[0] + i, low[1] + j, low[2] + 1);
        along_z[i][j] = a + t[2] * (b - a);
      }
    const double near_x = along_z[0][0] + t[1] * (along_z[0][1] - along_z[0][0]);
    const double far_x = along_z[1][0] + t[1] * (along_z[1][1] - along_z[1][0]);
    return near_x + t[0] * (far_x - near_x);
  }

 private:
  struct Entry {
    std::uint64_t key = ~std::uint64_t{0};
    const BrickValues* values = nullptr;
    float constant = 0;
  };

  double node(int i, int j, int k) {
    const Vec3i brick{i >> kBrickLog, j >> kBrickLog, k >> kBrickLog};
    Entry& entry = entries_[static_cast<std::size_t>((brick[0] & 3) << 4 | (brick[1] & 3) << 2 | (brick[2] & 3))];
    if (const std::uint64_t key = coordKey(brick); entry.key != key) {
      entry.key = key;
      entry.values = field_.valuesAt(brick);
      entry.constant = entry.values ? 0 : field_.constantAt(brick);
    }
    return entry.values ? (*entry.values)[static_cast<std::size_t>(nodeOffset(i, j, k))] : entry.constant;
  }

  const Field& field_;
  double nodes_per_mm_;
  std::array<Entry, 64> entries_;  // by the two lowest bits of the brick coordinate
};

/// Towards the faces and the corners of a cube. Fixed in the object's frame and weighted by the cosine to the normal:
/// the result is continuous in the normal, so that no seam shows where a frame of tangents would turn.
const std::array<Vec3d, 14>& directions() {
  static const std::array<Vec3d, 14> all = [] {
    std::array<Vec3d, 14> made;
    std::size_t n = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-1.0, 1.0}) made[n++] = sign * Vec3d::Unit(axis);
    for (int corner = 0; corner < 8; ++corner)
      made[n++] = Vec3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1).normalized();
    return made;
  }();
  return all;
}

// mm along a direction; the farther, with the cell it is read from, within kOcclusionReach.
constexpr std::array<double, 2> kOcclusionSteps = {0.5, 1.5};
constexpr double kLeastCosine = 0.15;  ///< grazing directions see the surface itself

template <class Field>
std::vector<std::uint8_t> occlusion(const MeshChunk& chunk, const Field& field) {
  Sampler<Field> sampler(field);
  const double band = field.background();
  std::vector<std::uint8_t> light(chunk.vertices.size());

  for (std::size_t v = 0; v < chunk.vertices.size(); ++v) {
    const Vec3d p = chunk.vertices[v].cast<double>();
    const Vec3d n = chunk.normals[v].cast<double>();
    double blocked = 0, total = 0;
    for (const Vec3d& direction : directions()) {
      const double cosine = n.dot(direction) - kLeastCosine;
      if (cosine <= 0) continue;
      for (const double step : kOcclusionSteps) {
        // Over a flat wall the distance is the height; far from everything it is the field's constant.
        const double open = 0.9 * std::min(step * n.dot(direction), band);
        blocked += cosine * std::clamp(1 - sampler.at(p + step * direction) / open, 0.0, 1.0);
        total += cosine;
      }
    }
    light[v] = static_cast<std::uint8_t>(std::lround(255 * (1 - blocked / total)));
  }
  return light;
}

}  // namespace

std::vector<std::uint8_t> occlusionOf(const MeshChunk& chunk, const BrickField& field) {
  return occlusion(chunk, field);
}
std::vector<std::uint8_t> occlusionOf(const MeshChunk& chunk, const OverlayField& field) {
  return occlusion(chunk, field);
}

}  // namespace kerf
