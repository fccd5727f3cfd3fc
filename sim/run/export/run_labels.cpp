#include "sim/run/export/run_labels.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "geometry/base/available_memory.h"
#include "geometry/boolean/post_op_mesh.h"
#include "geometry/case/case_bundle.h"
#include "geometry/case/case_materials.h"
#include "sim/pieces/pieces.h"
#include "sim/run/files/removed_volumes.h"
#include "sim/run/files/run_files.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// A case and its cut, both on the case's grid.
struct Labelled {
  CaseManifest manifest;
  MaterialTable table;
  BrickField phi0, cut;  // cut: bricks that differ
  MaterialField labels;  // with added material
  internal::VolumeByNumber removed{};
  bool has_added = false;
  std::vector<RunManifest::Piece> pieces;
  double fine_mm = 0;
  Material fallback = Material::kGeneric;

  float before(const Vec3i& node) const { return phi0.at(node); }
  float now(const Vec3i& node) const {
    const BrickValues* const changed = cut.valuesAt(brickOf(node));
    return changed ? (*changed)[static_cast<std::size_t>(nodeOffset(node[0], node[1], node[2]))] : phi0.at(node);
  }
};

Vec3i nearestNode(const Vec3d& p, double voxel) { return (p / voxel).array().round().cast<int>(); }

// A cut in the fine region, at the nodes of the object's own grid: those that the cut changed.
BrickField resampled(const BrickField& fine_cut, const BrickField& fine0, const BrickField& phi0) {
  BrickField fine = fine0;
  for (std::size_t b = 0; b < fine_cut.brickCount(); ++b)
    fine.brick(fine.touch(fine_cut.brickCoord(b))) = fine_cut.brick(b);

  std::set<std::array<int, 3>> bricks;
  const double ratio = fine_cut.voxel() / phi0.voxel();
  for (std::size_t b = 0; b < fine_cut.brickCount(); ++b) {
    const Vec3d first = ratio * (fine_cut.brickCoord(b) * kBrickSide).cast<double>();
    for (int n = 0; n < 8; ++n) {
      const Vec3d corner = first + ratio * kBrickSide * Vec3d(n & 1, n >> 1 & 1, n >> 2);
      const Vec3i brick = brickOf(corner.array().round().cast<int>());
      bricks.insert({brick[0], brick[1], brick[2]});
    }
  }

  BrickField out(phi0.voxel(), phi0.background(), phi0.interior());
  for (const auto& [x, y, z] : bricks) {
    const Vec3i brick(x, y, z);
    BrickValues values;
    bool is_other = false;
    for (int n = 0; n < kBrickNodes; ++n) {
      const Vec3i node = brick * kBrickSide + Vec3i{n >> 6, n >> 3 & 7, n & 7};
      const Vec3d p = phi0.position(node);
      float& value = values[static_cast<std::size_t>(n)];
      value = phi0.at(node);
      if (!fine_cut.valuesAt(brickOf(nearestNode(p, fine.voxel())))) continue;
      const double was = fine0.sample(p), is = fine.sample(p);
      if (is <= was) continue;
      value = std::max(value, static_cast<float>(is));
      is_other = true;
    }
    if (is_other) out.add(brick, values);
  }
  return out;
}

// Removed volume by material of a cut in the fine region, from its own nodes; materials from the object's grid.
internal::VolumeByNumber removedInRegion(const BrickField& fine0, const BrickField& fine_cut,
                                         const MaterialField& labels, Material fallback) {
  return internal::removedVolumes(fine0, fine_cut, [&](const Vec3i& brick, std::span<std::uint8_t, kBrickNodes> out) {
    for (int n = 0; n < kBrickNodes; ++n) {
      const Vec3d p = fine0.position(brick * kBrickSide + Vec3i{n >> 6, n >> 3 & 7, n & 7});
      const Material here = labels.at(nearestNode(p, labels.voxel()));
      out[static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(here == Material::kNone ? fallback : here);
    }
  });
}

// Pieces of a cut that no session divided, the largest first; none unless the cut made pieces.
std::vector<RunManifest::Piece> piecesFound(const BrickField& phi0, const BrickField& cut) {
  PieceFinder finder(phi0);
  const std::size_t before = finder.find().pieces.size();
  std::vector<BrickEdit> edits(cut.brickCount());
  for (std::size_t b = 0; b < edits.size(); ++b) edits[b] = {cut.brickCoord(b), cut.brick(b)};
  finder.apply(edits);
  const PieceList& found = finder.find();
  if (found.pieces.size() <= before) return {};
  std::vector<RunManifest::Piece> out;
  for (const Piece& piece : found.pieces)
    out.push_back({.name = fmt::format("piece {}", out.size() + 1),
                   .inside = phi0.position(piece.first_node),
                   .volume_mm3 = piece.volume});
  return out;
}

Expected<void> addCut(const fs::path& run_folder, const fs::path& case_folder, std::size_t beside, Labelled& out) {
  KERF_TRY(run, readRunManifest(run_folder));
  KERF_TRY(cut, readRunCutField(run_folder, beside));
  const MaterialField in_case = out.labels;
  if (beside == 0) {
    KERF_TRY(added, readRunMaterials(run_folder));
    KERF_TRY(labels, readRunLabels(case_folder, added));
    out.labels = std::move(labels);
    out.has_added = !added.isEmpty();
    out.pieces = run.pieces;
  }

  if (const auto& region = out.manifest.region; region && cut.voxel() == region->where.voxel_mm) {
    KERF_TRY(fine0, readCaseRegionField(case_folder, out.phi0));
    KERF_CHECK(requireOnlyTaken(run_folder, run, cut, fine0, beside));
    out.removed = removedInRegion(fine0, cut, in_case, out.fallback);
    out.cut = resampled(cut, fine0, out.phi0);
    if (out.pieces.empty()) out.pieces = piecesFound(out.phi0, out.cut);
    out.fine_mm = cut.voxel();
    return {};
  }
  if (cut.voxel() != out.phi0.voxel())
    return fail({.code = Error::Code::kBadValue,
                 .file = run_folder.string(),
                 .found = fmt::format("{} mm voxels", cut.voxel()),
                 .expected = fmt::format("{} mm, as in the case", out.phi0.voxel()),
                 .hint = "cut again"});
  KERF_CHECK(requireOnlyTaken(run_folder, run, cut, out.phi0, beside));
  out.cut = internal::withoutPlaneFaces(std::move(cut), out.phi0, out.pieces);
  if (out.pieces.empty()) out.pieces = piecesFound(out.phi0, out.cut);
  out.removed = internal::removedVolumes(out.phi0, out.cut, internal::materialsOf(in_case, out.fallback),
                                         internal::materialsOf(out.labels, out.fallback));
  return {};
}

Expected<Labelled> load(const fs::path& bundle, std::size_t beside) {
  fs::path case_folder = bundle;
  if (isRun(bundle)) {
    KERF_TRY(run, readRunManifest(bundle));
    KERF_CHECK(requireEnded(bundle, run));
    KERF_CHECK(internal::requireBeside(bundle, run, beside));
    KERF_TRY(located, internal::locateCase(bundle, run, beside));
    case_folder = located;
  } else if (isCase(bundle)) {
    KERF_CHECK(internal::requireBeside(bundle, {}, beside));
  } else {
    return fail({.code = Error::Code::kNotFound,
                 .file = bundle.string(),
                 .found = "neither a run nor a case",
                 .expected = "a folder with run.toml or case.toml",
                 .hint = "kerf bake, then kerf cut"});
  }
  KERF_TRY(manifest, readCaseManifest(case_folder));
  KERF_TRY(table, readDefaultMaterials());
  KERF_CHECK(requireSameMaterials(case_folder, manifest, table));
  KERF_TRY(fields, readCaseFields(case_folder, manifest));
  const Material fallback = fallbackOf(manifest);
  Labelled out{.manifest = std::move(manifest),
               .table = std::move(table),
               .phi0 = std::move(fields.phi0),
               .cut = {},
               .labels = std::move(fields.materials),
               .pieces = {},
               .fallback = fallback};
  if (isRun(bundle)) KERF_CHECK(addCut(bundle, case_folder, beside, out));
  return out;
}

// ---- The nodes of the object's box

struct NodeLabels {
  Vec3i low = Vec3i::Zero();
  std::array<int, 3> size{};
  std::vector<std::uint16_t> numbers;  // x fastest

  bool contains(const Vec3i& node) const {
    for (int axis = 0; axis < 3; ++axis)
      if (node[axis] < low[axis] || node[axis] - low[axis] >= size[static_cast<std::size_t>(axis)]) return false;
    return true;
  }
  std::size_t index(const Vec3i& node) const {
    const auto along = [&](int axis) { return static_cast<std::size_t>(node[axis] - low[axis]); };
    return (along(2) * static_cast<std::size_t>(size[1]) + along(1)) * static_cast<std::size_t>(size[0]) + along(0);
  }
};

// Sets the box: the nodes inside, before or after the cut, and one around them.
Expected<NodeLabels> emptyLabels(const Labelled& of) {
  Vec3i low = Vec3i::Constant(std::numeric_limits<int>::max()), high = Vec3i::Constant(std::numeric_limits<int>::min());
  for (const BrickField* const field : {&of.phi0, &of.cut})
    for (std::size_t b = 0; b < field->brickCount(); ++b) {
      const Vec3i base = field->brickCoord(b) * kBrickSide;
      for (int n = 0; n < kBrickNodes; ++n) {
        if (!(field->brick(b)[static_cast<std::size_t>(n)] < 0)) continue;
        const Vec3i node = base + Vec3i{n >> 6, n >> 3 & 7, n & 7};
        low = low.cwiseMin(node);
        high = high.cwiseMax(node);
      }
    }
  if ((high.array() < low.array()).any())
    return fail({.code = Error::Code::kEmpty,
                 .found = "no node of the field inside the object",
                 .expected = "an object larger than a voxel",
                 .hint = "bake with smaller voxels"});
  NodeLabels out;
  out.low = low - Vec3i::Ones();
  for (int axis = 0; axis < 3; ++axis) out.size[static_cast<std::size_t>(axis)] = high[axis] - low[axis] + 3;
  return out;
}

VoxelGrid gridOf(const NodeLabels& nodes, double voxel) {
  return {nodes.size, voxel * nodes.low.cast<double>(), voxel * Eigen::Matrix3d::Identity()};
}

void labelBrick(const Labelled& of, const Vec3i& brick, NodeLabels& out) {
  std::array<std::uint8_t, kBrickNodes> materials;
  bool has_materials = false;
  const BrickValues *const baked = of.phi0.valuesAt(brick), *const changed = of.cut.valuesAt(brick);
  const float constant = of.phi0.constantAt(brick);
  if (!baked && !changed && constant >= 0) return;
  for (int n = 0; n < kBrickNodes; ++n) {
    const auto at = static_cast<std::size_t>(n);
    const float was = baked ? (*baked)[at] : constant, now = changed ? (*changed)[at] : was;
    const Vec3i node = brick * kBrickSide + Vec3i{n >> 6, n >> 3 & 7, n & 7};
    if (!(was < 0 || now < 0) || !out.contains(node)) continue;
    std::uint16_t& number = out.numbers[out.index(node)];
    number = kRemovedNumber;
    if (!(now < 0)) continue;
    if (!has_materials) of.labels.copyBrick(brick, materials);
    has_materials = true;
    number = materials[at] ? materials[at] : static_cast<std::uint8_t>(of.fallback);
  }
}

void labelNodes(const Labelled& of, NodeLabels& out) {
  out.numbers.assign(static_cast<std::size_t>(gridOf(out, 1).count()), 0);
  const Vec3i first = brickOf(out.low);
  const Vec3i last = brickOf(out.low + Vec3i(out.size[0] - 1, out.size[1] - 1, out.size[2] - 1));
  tbb::parallel_for(first[2], last[2] + 1, [&](int z) {
    for (int y = first[1]; y <= last[1]; ++y)
      for (int x = first[0]; x <= last[0]; ++x) labelBrick(of, {x, y, z}, out);
  });
}

bool isTissue(std::uint16_t number) { return number != 0 && number != kRemovedNumber; }

// Numbers the tissue of each piece: nodes connected to its inner point, on its sides of the plane cuts.
void numberPieces(const Labelled& of, NodeLabels& nodes) {
  for (std::size_t n = 0; n < of.pieces.size(); ++n) {
    const RunManifest::Piece& piece = of.pieces[n];
    const auto isOnItsSides = [&](const Vec3i& node) {
      const Vec3d p = of.phi0.position(node);
      return std::all_of(piece.sides.begin(), piece.sides.end(),
                         [&](const PlaneSide& side) { return side.planes.height(p, side.is_above) >= 0; });
    };
    std::vector<Vec3i> open;
    const auto claim = [&](const Vec3i& node) {
      if (!nodes.contains(node)) return;
      std::uint16_t& number = nodes.numbers[nodes.index(node)];
      if (!isTissue(number) || number >= kPieceNumbers || !isOnItsSides(node)) return;
      number = static_cast<std::uint16_t>(number + kPieceNumbers * (n + 1));
      open.push_back(node);
    };
    claim(nearestNode(piece.inside, of.phi0.voxel()));
    while (!open.empty()) {
      const Vec3i node = open.back();
      open.pop_back();
      for (int axis = 0; axis < 3; ++axis)
        for (const int step : {-1, 1}) {
          Vec3i next = node;
          next[axis] += step;
          claim(next);
        }
    }
  }
}

// ---- Another grid

// Number at a point: by the eight nodes around it.
class NumberAt {
 public:
  NumberAt(const Labelled& of, const NodeLabels& nodes) : of_(of), nodes_(nodes) {}

  std::uint16_t operator()(const Vec3d& p) const {
    const Vec3d at = p / of_.phi0.voxel();
    const Vec3i cell = at.array().floor().cast<int>();
    if (!nodes_.contains(cell) || !nodes_.contains(cell + Vec3i::Ones())) return 0;
    std::array<std::uint16_t, 8> numbers;
    for (int n = 0; n < 8; ++n) numbers[static_cast<std::size_t>(n)] = nodes_.numbers[nodes_.index(cornerOf(cell, n))];
    if (std::all_of(numbers.begin(), numbers.end(), [&](auto number) { return number == numbers[0]; }))
      return numbers[0];

    double was = 0, now = 0, largest = -1;
    std::uint16_t tissue = 0;
    const Vec3d share = at - cell.cast<double>();
    for (int n = 0; n < 8; ++n) {
      double weight = 1;
      for (int axis = 0; axis < 3; ++axis) weight *= n >> axis & 1 ? share[axis] : 1 - share[axis];
      was += weight * static_cast<double>(of_.before(cornerOf(cell, n)));
      now += weight * static_cast<double>(of_.now(cornerOf(cell, n)));
      const std::uint16_t number = numbers[static_cast<std::size_t>(n)];
      if (!isTissue(number) || weight <= largest) continue;
      largest = weight;  // the nearest along the axes
      tissue = number;
    }
    if (now < 0) return tissue;
    return was < 0 ? kRemovedNumber : std::uint16_t{0};
  }

 private:
  static Vec3i cornerOf(const Vec3i& cell, int n) { return cell + Vec3i{n & 1, n >> 1 & 1, n >> 2}; }

  const Labelled& of_;
  const NodeLabels& nodes_;
};

std::vector<std::uint16_t> numbersOn(const VoxelGrid& grid, const Labelled& of, const NodeLabels& nodes) {
  std::vector<std::uint16_t> out(static_cast<std::size_t>(grid.count()), 0);
  // The voxels around the object.
  const Box3 box{of.phi0.position(nodes.low),
                 of.phi0.position(nodes.low + Vec3i(nodes.size[0] - 1, nodes.size[1] - 1, nodes.size[2] - 1))};
  const Eigen::Matrix3d to_index = grid.axes.inverse();
  Box3 within;
  for (int n = 0; n < 8; ++n) within.add(to_index * (box.corner(n) - grid.origin));
  std::array<int, 3> low{}, high{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double most = grid.size[a];
    low[a] = static_cast<int>(std::clamp(std::floor(within.min[axis]), 0.0, most));
    high[a] = static_cast<int>(std::clamp(std::ceil(within.max[axis]) + 1, 0.0, most));
  }

  const NumberAt numberAt(of, nodes);
  const auto x = static_cast<std::size_t>(grid.size[0]), y = static_cast<std::size_t>(grid.size[1]);
  tbb::parallel_for(low[2], std::max(low[2], high[2]), [&](int k) {
    for (int j = low[1]; j < high[1]; ++j)
      for (int i = low[0]; i < high[0]; ++i)
        out[(static_cast<std::size_t>(k) * y + static_cast<std::size_t>(j)) * x + static_cast<std::size_t>(i)] =
            numberAt(grid.origin + grid.axes * Vec3d(i, j, k));
  });
  return out;
}

Expected<void> requireMemory(const fs::path& bundle, const NodeLabels& nodes, const std::optional<VoxelGrid>& grid) {
  const double bytes = 2 * (gridOf(nodes, 1).count() + (grid ? grid->count() : 0));
  const double available = 0.8 * static_cast<double>(internal::availableMemory());
  if (bytes <= available) return {};
  return fail({.code = Error::Code::kUnsupported,
               .file = bundle.string(),
               .found = fmt::format("voxels of {:.1f} GB{}", bytes / 1e9, grid ? ", with those of the scan" : ""),
               .expected = fmt::format("at most {:.1f} GB, 4/5 of the free memory", available / 1e9),
               .hint = grid ? "--grid case, or close other programs" : "bake with larger voxels"});
}

// ---- Segments and volumes

struct Names {
  std::string id, name;
  Rgba8 color{};
};

Names namesOf(std::uint16_t number, const Labelled& of) {
  if (number == kRemovedNumber) return {"removed", "removed", PostOpOptions{}.cut_color};
  const auto material = static_cast<Material>(number % kPieceNumbers);
  const MaterialProperties* const row = of.table.find(material);
  Names out{row ? row->id : fmt::format("material-{}", static_cast<int>(material)), "", row ? row->color : Rgba8{}};
  out.name = row ? row->name : out.id;
  const std::size_t piece = number / kPieceNumbers;
  if (piece == 0) return out;
  out.id = fmt::format("piece-{}-{}", piece, out.id);
  out.name = fmt::format("{}: {}", of.pieces[piece - 1].name, out.name);
  return out;
}

void addVolumes(const Labelled& of, bool is_run, RunLabels& out) {
  std::map<std::uint16_t, std::uint64_t> voxels;
  for (const std::uint16_t number : out.segmentation.numbers) ++voxels[number];
  voxels.erase(0);
  const double each = out.segmentation.grid.voxelVolume();
  const auto volume = [each](std::string name, std::uint64_t count, double ledger_mm3) {
    return RunLabels::Volume{std::move(name), count, each * static_cast<double>(count), ledger_mm3};
  };

  std::map<std::uint16_t, std::uint64_t> of_tissue;
  std::vector<std::uint64_t> of_piece(of.pieces.size(), 0);
  for (const auto& [number, count] : voxels) {
    const Names names = namesOf(number, of);
    out.segmentation.segments.push_back({number, names.id, names.name, names.color});
    if (number == kRemovedNumber) continue;
    of_tissue[number % kPieceNumbers] += count;
    const std::size_t piece = number / kPieceNumbers;
    if (piece > 0) of_piece[piece - 1] += count;
  }

  internal::VolumeByNumber left{};
  for (const CaseMaterial& material : of.manifest.materials)
    left[static_cast<std::size_t>(material.number)] += material.volume_mm3;
  double taken = 0;
  for (std::size_t m = 0; m < left.size(); ++m) {
    left[m] -= of.removed[m];
    if (!of.has_added || of.removed[m] > 0) taken += of.removed[m];
    const auto number = static_cast<std::uint16_t>(m);
    constexpr double kNothing = 1e-6;  // mm^3
    if (of_tissue.contains(number) || left[m] > kNothing)
      out.tissues.push_back(volume(namesOf(number, of).name, of_tissue[number], left[m]));
  }
  if (is_run) out.removed = volume("removed", voxels.contains(kRemovedNumber) ? voxels[kRemovedNumber] : 0, taken);
  for (std::size_t n = 0; n < of.pieces.size(); ++n)
    out.pieces.push_back(volume(of.pieces[n].name, of_piece[n], of.pieces[n].volume_mm3));
  if (!of.pieces.empty())
    for (const auto& [number, count] : voxels)
      if (isTissue(number) && number < kPieceNumbers) out.loose_voxels += count;
}

}  // namespace

Expected<RunLabels> labelsOfBundle(const fs::path& bundle, const std::optional<VoxelGrid>& grid,
                                   const Progress& progress, std::size_t beside) {
  if (!report(progress, 0, "loading")) return cancelledBeforeWriting();
  KERF_TRY(loaded, load(bundle, beside));
  RunLabels out;
  out.fine_mm = loaded.fine_mm;
  out.has_moved = std::any_of(loaded.pieces.begin(), loaded.pieces.end(), [](const auto& p) { return p.isMoved(); });
  constexpr std::size_t kMostPieces = 255;
  if (loaded.pieces.size() < 2 || loaded.pieces.size() > kMostPieces) loaded.pieces.clear();

  if (!report(progress, 0.3, "labelling voxels")) return cancelledBeforeWriting();
  KERF_TRY(nodes, emptyLabels(loaded));
  KERF_CHECK(requireMemory(bundle, nodes, grid));
  labelNodes(loaded, nodes);
  if (!report(progress, 0.5, "labelling pieces")) return cancelledBeforeWriting();
  numberPieces(loaded, nodes);
  if (!report(progress, 0.7, "labelling voxels")) return cancelledBeforeWriting();
  out.segmentation.grid = grid ? *grid : gridOf(nodes, loaded.phi0.voxel());
  out.segmentation.numbers = grid ? numbersOn(*grid, loaded, nodes) : std::move(nodes.numbers);
  addVolumes(loaded, isRun(bundle), out);
  if (!report(progress, 0.9, "writing")) return cancelledBeforeWriting();
  return out;
}

}  // namespace kerf
