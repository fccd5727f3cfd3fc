#include "preprocess/volume/label_surface.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/field/marching_cubes.h"
#include "preprocess/volume/label_memberships.h"
#include "preprocess/volume/slot_grid.h"

namespace kerf {
namespace {

using internal::Kernel;
using internal::Memberships;
using internal::Slot;
using internal::SlotGrid;
using internal::SlotSurvey;

constexpr double kMostSigma = 4;  // voxels

tl::unexpected<Error> refuse(std::string place, std::string found, std::string expected) {
  return fail({.code = Error::Code::kBadValue,
               .place = std::move(place),
               .found = std::move(found),
               .expected = std::move(expected)});
}

// A slot for each tissue label.
struct SlotTable {
  std::vector<Slot> of_label = std::vector<Slot>(65536, 0);
  std::vector<std::uint16_t> label = {0};  // per slot
};

Expected<SlotTable> numberLabels(std::span<const std::uint16_t> tissue_labels) {
  if (tissue_labels.empty() || tissue_labels.size() > internal::kMostTissues)
    return refuse("labels", fmt::format("{} tissue labels", tissue_labels.size()),
                  fmt::format("1 to {}", internal::kMostTissues));
  SlotTable table;
  for (const std::uint16_t l : tissue_labels) {
    if (l == 0) return refuse("labels", "label 0", "labels of tissue: 0 is nothing");
    if (table.of_label[l]) return refuse("labels", fmt::format("label {} twice", l), "every label once");
    table.of_label[l] = static_cast<Slot>(table.label.size());
    table.label.push_back(l);
  }
  return table;
}

// Voxels along each axis.
Expected<Vec3d> sigmaOf(const LabelVolume& volume, const SmoothLabelOptions& options) {
  Vec3d sigma = Vec3d::Constant(options.smoothing_voxels);
  if (options.smoothing_mm) sigma = *options.smoothing_mm * volume.spacing.cwiseInverse();
  if (!((sigma.array() >= 0).all() && (sigma.array() <= kMostSigma).all()))
    return refuse("smoothing",
                  options.smoothing_mm ? fmt::format("{} mm, {:.2f} voxels", *options.smoothing_mm, sigma.maxCoeff())
                                       : fmt::format("{} voxels", options.smoothing_voxels),
                  fmt::format("0 to {} voxels", kMostSigma));
  if (!(options.volume_tolerance > 0)) return refuse("volume tolerance", "not above 0", "0.002, say");
  return sigma;
}

Expected<void> requireAllLabels(const LabelVolume& volume, const SlotSurvey& survey, const SlotTable& table) {
  for (std::size_t s = 1; s < table.label.size(); ++s) {
    if (survey.voxels[s] != 0) continue;
    std::string there;
    for (const LabelCount& c : countLabels(volume)) there += fmt::format("{}{}", there.empty() ? "" : ", ", c.label);
    return fail({.code = Error::Code::kEmpty,
                 .place = "labels",
                 .found = fmt::format("no voxel of label {}", table.label[s]),
                 .expected = "labels that are in the volume: " + there.substr(0, 200),
                 .hint = "kerf info lists them"});
  }
  return {};
}

// The grid around the tissue, with a margin of rest that the kernels do not reach beyond.
Expected<SlotGrid> gridAround(const SlotSurvey& survey, const std::array<Kernel, 3>& kernel, std::uint64_t max_bytes) {
  SlotGrid grid;
  const Vec3i margin = Vec3i{kernel[0].reach, kernel[1].reach, kernel[2].reach} + Vec3i::Ones();
  grid.corner = survey.low - margin;
  for (int a = 0; a < 3; ++a) grid.bricks[a] = (survey.high[a] + margin[a] - grid.corner[a]) / kBrickSide + 1;

  const Vec3i n = grid.nodes();
  const double nodes = static_cast<double>(n[0]) * n[1] * n[2];
  // The slots; walls fill a third of the bricks of a head, with two and a bit memberships each.
  const double bytes = nodes * (1 + 4 * 2.3 / 3);
  if (bytes > static_cast<double>(max_bytes))
    return fail(
        {.code = Error::Code::kUnsupported,
         .found = fmt::format("{} x {} x {} voxels around the labels, {:.1f} GB", n[0], n[1], n[2], bytes / 1e9),
         .expected = fmt::format("at most {:.1f} GB", static_cast<double>(max_bytes) / 1e9),
         .hint = "ask for fewer labels, or crop or resample the volume"});
  return grid;
}

// Gives every node to the slot that has it now.
void assignWinners(const Memberships& memberships, SlotGrid& grid) {
  tbb::parallel_for(std::size_t{0}, memberships.mixed.size(), [&](std::size_t m) {
    for (int i = 0; i < kBrickNodes; ++i) {
      const Vec3i node = memberships.place[m] * kBrickSide + Vec3i{i >> 6, i >> 3 & 7, i & 7};
      grid.slot[grid.offset(node[0], node[1], node[2])] =
          memberships.winner(memberships.mixed[m], static_cast<std::size_t>(i));
    }
  });
}

}  // namespace

struct SmoothLabels::Data {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  // mm per node
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Identity();
  Vec3d origin = Vec3d::Zero();      // of node 0, mm
  double sigma = 0;                  // voxels, the smallest of the axes: for the scale of surface()
  std::vector<std::uint16_t> label;  // per slot
  Memberships memberships;
  std::vector<LabelVolumeReport> reports;

  BrickField wall(float outwards) const;
};

// Positive in the rest, about in voxels near the wall, less `outwards`.
BrickField SmoothLabels::Data::wall(float outwards) const {
  const Memberships& all = memberships;
  // Leads converted to voxels, the unit of marching cubes' limits: a lead of one is sigma sqrt(pi / 2) voxels.
  const auto scale = static_cast<float>(std::max(0.4, sigma) * std::sqrt(std::acos(-1.0) / 2));

  BrickField field(1.0, 10.0f);
  field.reserve(all.mixed.size());
  for (std::size_t m = 0; m < all.mixed.size(); ++m) {
    const Memberships::Brick& brick = all.mixed[m];
    BrickValues values;
    for (std::size_t i = 0; i < kBrickNodes; ++i) {
      float tissue = -1, rest = -1;
      for (std::size_t s = 0; s < brick.slots.size(); ++s) {
        const float v = brick.value[s * kBrickNodes + i];
        if (v <= 0) continue;
        float& best = brick.slots[s] == 0 ? rest : tissue;
        best = std::max(best, v * all.weight[brick.slots[s]]);
      }
      values[i] = scale * (rest - tissue) - outwards;
    }
    field.add(all.place[m], values);
  }

  for (std::size_t b = 0; b < all.index.size(); ++b)
    if (all.index[b] < -1) field.markInterior(internal::brickPlace(b, all.bricks));
  return field;
}

SmoothLabels::SmoothLabels(std::unique_ptr<const Data> data) : data_(std::move(data)) {}
SmoothLabels::SmoothLabels(SmoothLabels&&) noexcept = default;
SmoothLabels& SmoothLabels::operator=(SmoothLabels&&) noexcept = default;
SmoothLabels::~SmoothLabels() = default;

const std::vector<LabelVolumeReport>& SmoothLabels::reports() const { return data_->reports; }

Expected<SmoothLabels> SmoothLabels::create(const LabelVolume& volume, std::span<const std::uint16_t> tissue_labels,
                                            const SmoothLabelOptions& options, const Progress& progress) {
  KERF_TRY(table, numberLabels(tissue_labels));
  KERF_TRY(sigma, sigmaOf(volume, options));
  const std::array<Kernel, 3> kernel{internal::gaussian(sigma[0]), internal::gaussian(sigma[1]),
                                     internal::gaussian(sigma[2])};
  const std::size_t slots = table.label.size();

  if (!report(progress, 0.0, "finding labels")) return cancelled();
  const SlotSurvey survey = internal::surveySlots(volume, table.of_label, slots);
  KERF_CHECK(requireAllLabels(volume, survey, table));
  KERF_TRY(grid, gridAround(survey, kernel, options.max_bytes));
  internal::fillSlots(volume, table.of_label, grid);
  const std::vector<std::uint32_t> pieces = internal::countPieces(grid, slots);

  auto data = std::make_unique<Data>();
  data->axes = volume.axes();
  data->inverse = data->axes.inverse();
  data->origin = volume.toWorld(grid.corner.cast<double>());
  data->sigma = sigma.minCoeff();
  data->label = table.label;
  if (!report(progress, 0.1, "smoothing labels")) return cancelled();
  data->memberships = internal::blurSlots(grid, slots, kernel);
  if (!report(progress, 0.4, "keeping thin parts")) return cancelled();
  internal::keepThin(grid, data->memberships);
  std::vector<std::uint64_t> samples;
  if (!internal::fitVolumes(data->memberships, data->sigma, survey.voxels, options.volume_tolerance, progress, samples))
    return cancelled();

  if (!report(progress, 0.95, "counting pieces")) return cancelled();
  assignWinners(data->memberships, grid);
  const std::vector<std::uint32_t> pieces_now = internal::countPieces(grid, slots);
  const double v = volume.voxelVolume();
  for (std::size_t s = 1; s < slots; ++s)
    data->reports.push_back(
        {.label = data->label[s],
         .voxels = survey.voxels[s],
         .counted_mm3 = static_cast<double>(survey.voxels[s]) * v,
         .smoothed_mm3 = static_cast<double>(samples[s]) / static_cast<double>(internal::kCellSamples) * v,
         .pieces = pieces[s],
         .pieces_now = pieces_now[s]});
  report(progress, 1.0, "labels are smooth");
  return SmoothLabels(std::move(data));
}

Expected<Mesh> SmoothLabels::surface(const Progress& progress) const {
  const Data& d = *data_;
  if (!report(progress, 0.0, "meshing labels")) return cancelled();
  const auto meshed = [&](float outwards) {
    MarchingCubesOptions options;
    options.chord_balance = 0;  // could undo the lead of thin walls; the fit keeps the volume
    return marchingCubes(d.wall(outwards), options);
  };
  Mesh mesh = meshed(0);

  // Chords cut into sheets of a voxel or two from both sides: the surface moves out until its volume is that of the
  // labels, by some hundredths of a voxel. It never moves in, which could break a thin wall.
  constexpr float kMostOutwards = 0.2f;
  constexpr double kTolerance = 0.002;
  double voxels = 0;
  for (const LabelVolumeReport& r : d.reports) voxels += static_cast<double>(r.voxels);
  float outwards = 0;
  for (int round = 0; round < 6 && !mesh.triangles.empty(); ++round) {
    if (!report(progress, 0.3 + 0.1 * round, "meshing labels")) return cancelled();
    const double missing = voxels - signedVolume(mesh);
    const float before = outwards;
    outwards = std::clamp(outwards + static_cast<float>(missing / surfaceArea(mesh)), 0.0f, kMostOutwards);
    if (std::abs(missing) < kTolerance * voxels || outwards == before) break;
    mesh = meshed(outwards);
  }
  if (mesh.triangles.empty())
    return fail({.code = Error::Code::kEmpty,
                 .place = "labels",
                 .found = "smoothing left nothing of them",
                 .expected = "labels of several voxels",
                 .hint = "a smaller smoothing"});

  for (Vec3d& p : mesh.vertices) p = roundedToFloat(Vec3d(d.origin + d.axes * p));
  if (d.axes.determinant() < 0)
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

std::uint16_t SmoothLabels::labelAt(const Vec3d& world_mm) const {
  const Data& d = *data_;
  const Memberships& all = d.memberships;
  const Vec3d p = d.inverse * (world_mm - d.origin);
  const Vec3d most = (all.bricks * kBrickSide).cast<double>();
  if (!(p.array() >= 0).all() || !(p.array() < most.array()).all()) return 0;  // the margin is rest; catches NaN
  const Vec3i low = p.array().floor().cast<int>();
  const Vec3d t = p - low.cast<double>();

  // The memberships of the slots around, interpolated.
  std::array<float, internal::kMostSlots> score;
  std::array<Slot, internal::kMostSlots> present;
  std::size_t count = 0;
  for (int c = 0; c < 8; ++c) {
    const Vec3i node = low + Vec3i{c >> 2, c >> 1 & 1, c & 1};
    const auto w =
        static_cast<float>((c & 4 ? t[0] : 1 - t[0]) * (c & 2 ? t[1] : 1 - t[1]) * (c & 1 ? t[2] : 1 - t[2]));
    if (w <= 0) continue;
    const auto add = [&](Slot slot, float v) {
      if (v <= 0) return;
      std::size_t s = 0;
      while (s < count && present[s] != slot) ++s;
      if (s == count) {
        present[count] = slot;
        score[count++] = 0;
      }
      score[s] += w * v;
    };

    const std::int32_t b = all.find(brickOf(node));
    if (b < 0) {
      add(static_cast<Slot>(-1 - b), 1.0f);
      continue;
    }
    const Memberships::Brick& brick = all.mixed[static_cast<std::size_t>(b)];
    const auto at = static_cast<std::size_t>(nodeOffset(node[0], node[1], node[2]));
    for (std::size_t s = 0; s < brick.slots.size(); ++s) add(brick.slots[s], brick.value[s * kBrickNodes + at]);
  }

  // The largest, once weighted.
  std::uint16_t best = 0;
  float most_score = -1;
  for (std::size_t s = 0; s < count; ++s) {
    const float v = score[s] * all.weight[present[s]];
    const std::uint16_t l = present[s] == 0 ? std::uint16_t{0} : d.label[present[s]];
    if (v > most_score || (v == most_score && l < best)) {
      best = l;
      most_score = v;
    }
  }
  return best;
}

}  // namespace kerf
