#include "sim/live/tissue_colours.h"

#include <algorithm>
#include <cmath>

#include "sim/live/label_reader.h"

namespace kerf {
namespace {

constexpr double kEnamelDepth = 0.6;  ///< mm, after which a third of the colour below is left; chosen
constexpr double kStep = 0.2;         ///< mm, between looks through enamel
constexpr int kSteps = 8;             ///< 1.6 mm: a fifteenth is left
constexpr float kCutShade = 0.92f;    ///< of the sRGB values of a cut face
constexpr float kCutGloss = 0.3f;     ///< of the gloss of its tissue

Vec3f linearOf(const Rgba8& c) {
  const auto one = [](std::uint8_t v) { return std::pow(static_cast<float>(v) / 255, 2.2f); };
  return {one(c[0]), one(c[1]), one(c[2])};
}

Rgba8 encoded(const Vec3f& linear, float shade, float gloss) {
  const auto byte = [](float v) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(v, 0.0f, 1.0f))); };
  const auto one = [&](float v) { return byte(shade * std::pow(std::max(v, 0.0f), 1 / 2.2f)); };
  return {one(linear[0]), one(linear[1]), one(linear[2]), byte(gloss)};
}

float glossOf(Material material) {
  switch (material) {
    case Material::kEnamel:
      return 1;
    case Material::kPulp:
    case Material::kGingiva:
      return 0.8f;  // wet
    case Material::kPdl:
    case Material::kNerveCanal:
    case Material::kComposite:
      return 0.6f;
    case Material::kDentin:
    case Material::kGeneric:
      return 0.35f;
    default:
      return 0.15f;
  }
}

/// At one place: the mean colour of the labelled nodes around it, and the share of translucent ones.
struct Mixed {
  Vec3f colour = Vec3f::Zero();
  float labelled = 0;     ///< weight of the nodes with a label, 0 to 1
  float translucent = 0;  ///< of those
  float gloss = 0;
};

class Labels {
 public:
  Labels(const TissueLabels& labels, const TissuePalette& palette)
      : reader_(labels), palette_(palette), nodes_per_mm_(1 / labels.baked->voxel()) {}

  /// Over the eight nodes around.
  Mixed at(const Vec3d& p) { return mixed<2>(p); }
  /// Over 27: where vertices stand on nodes, eight would give the colour of one node, and stairs at borders.
  Mixed smoothAt(const Vec3d& p) { return mixed<3>(p); }

 private:
  /// Weights of B-splines: linear over 2 nodes an axis, quadratic over 3.
  template <int kNodes>
  Mixed mixed(const Vec3d& p) {
    const Vec3d q = nodes_per_mm_ * p - Vec3d::Constant(kNodes == 2 ? 0 : 0.5);
    const Vec3i low = q.array().floor().cast<int>().matrix();
    float weights[3][3];
    for (int axis = 0; axis < 3; ++axis) {
      const auto t = static_cast<float>(q[axis] - low[axis]);
      float* const w = weights[axis];
      if constexpr (kNodes == 2) {
        w[0] = 1 - t;
        w[1] = t;
      } else {
        w[0] = 0.5f * (1 - t) * (1 - t);
        w[1] = 0.75f - (t - 0.5f) * (t - 0.5f);
        w[2] = 0.5f * t * t;
      }
    }

    Mixed sum;
    for (int i = 0; i < kNodes; ++i)
      for (int j = 0; j < kNodes; ++j)
        for (int k = 0; k < kNodes; ++k) {
          const std::uint8_t material = reader_.at(low + Vec3i{i, j, k});
          if (material == 0) continue;
          const float weight = weights[0][i] * weights[1][j] * weights[2][k];
          sum.colour += weight * palette_.colour(material);
          sum.gloss += weight * palette_.gloss(material);
          sum.labelled += weight;
          if (palette_.isTranslucent(material)) sum.translucent += weight;
        }
    if (sum.labelled > 1e-3f) {
      sum.colour /= sum.labelled;
      sum.gloss /= sum.labelled;
      sum.translucent /= sum.labelled;
    }
    return sum;
  }

  LabelReader reader_;
  const TissuePalette& palette_;
  double nodes_per_mm_;
};

/// The colour seen at a place, through translucent tissue. @param inward  unit.
Vec3f seenThrough(Labels& labels, const Vec3d& start, const Vec3d& inward, const Mixed& first) {
  const float pass = static_cast<float>(std::exp(-kStep / kEnamelDepth));
  Vec3f sum = Vec3f::Zero();
  Mixed here = first;
  float left = 1;  // share of light that got here
  for (int n = 1; n <= kSteps && left > 0.02f; ++n) {
    const float stays = left * (1 - here.translucent * pass);
    sum += stays * here.colour;
    left -= stays;
    const Mixed next = labels.at(start + n * kStep * inward);
    if (next.labelled < 0.5f) break;  // out at the other side
    here = next;
  }
  return sum + left * here.colour;
}

}  // namespace

TissuePalette::TissuePalette(const MaterialTable& table) {
  colours_.fill(linearOf(MaterialProperties{}.color));
  shown_.fill(MaterialProperties{}.color);
  for (std::size_t number = 0; number < gloss_.size(); ++number)
    gloss_[number] = glossOf(static_cast<Material>(static_cast<int>(number)));
  for (const MaterialProperties& row : table.rows()) {
    const int number = static_cast<int>(row.material);
    if (number < 0 || number > 255) continue;
    colours_[static_cast<std::size_t>(number)] = linearOf(row.color);
    shown_[static_cast<std::size_t>(number)] = row.color;
  }
}

TissueLabels TissueLabels::of(const BakedObject& object) {
  const auto brick = [&object](const Vec3i& at) -> const std::uint8_t* {
    const std::int32_t slot = object.directory().find(at);
    return slot < 0 ? nullptr : object.slots()[static_cast<std::size_t>(slot)].materials;
  };
  return {.brick = brick, .baked = &object.phi0(), .fallback = object.fallback()};
}

float cutShare(const BrickField& baked, const Vec3d& p) {
  const double depth = -baked.sample(p) / baked.voxel();
  return static_cast<float>(std::clamp(depth - 0.3, 0.0, 1.0));
}

std::vector<Rgba8> tissueColours(const MeshChunk& chunk, const TissueLabels& from, const TissuePalette& palette) {
  Labels labels(from, palette);
  const double voxel = from.baked->voxel();
  const auto fallback = static_cast<std::uint8_t>(from.fallback);
  std::vector<Rgba8> colours;
  colours.reserve(chunk.vertices.size());

  for (std::size_t v = 0; v < chunk.vertices.size(); ++v) {
    const Vec3d p = chunk.vertices[v].cast<double>();
    const Vec3d inward = -chunk.normals[v].cast<double>();

    // The first place below the surface where most nodes have a label.
    Vec3d below = p;
    Mixed mixed;
    for (const double depth : {0.6, 1.2, 2.0}) {
      below = p + depth * voxel * inward;
      mixed = labels.smoothAt(below);
      if (mixed.labelled > 0.5f) break;
    }
    if (mixed.labelled <= 1e-3f) {
      colours.push_back(encoded(palette.colour(fallback), 1, palette.gloss(fallback)));
      continue;
    }

    const float cut = cutShare(*from.baked, p);
    Vec3f colour = mixed.colour;
    if (cut < 1 && mixed.translucent > 0) {
      const Vec3f whole = seenThrough(labels, below, inward, mixed);
      colour = whole + cut * (colour - whole);
    }
    colours.push_back(encoded(colour, 1 + cut * (kCutShade - 1), mixed.gloss * (1 + cut * (kCutGloss - 1))));
  }
  return colours;
}

void asNeighbour(std::vector<Rgba8>& colours) {
  constexpr std::array<int, 3> kTint = {188, 200, 216};  // sRGB
  for (Rgba8& colour : colours) {
    const int grey = (colour[0] + 2 * colour[1] + colour[2]) / 4;
    for (std::size_t k = 0; k < 3; ++k)
      colour[k] = static_cast<std::uint8_t>((colour[k] + grey) / 2 * kTint[k] / 210 * 9 / 10);
  }
}

}  // namespace kerf
