#include "ui/cli/export_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "geometry/case/case_bundle.h"
#include "preprocess/bake/case_recipe.h"
#include "preprocess/volume/label_volume.h"
#include "sim/run/export/run_labels.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_manifest.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The case of the bundle, or of its neighbour.
Expected<fs::path> caseFolderOf(const LabelExport& wanted) {
  if (!isRun(wanted.bundle)) return fs::path(wanted.bundle);
  KERF_TRY(manifest, readRunManifest(wanted.bundle));
  KERF_CHECK(internal::requireBeside(wanted.bundle, manifest, wanted.beside));
  return internal::locateCase(wanted.bundle, manifest, wanted.beside);
}

// The grid of the first volume among the sources of the case; none: its sources are meshes.
Expected<std::optional<VoxelGrid>> gridOfScan(const fs::path& folder) {
  if (!isCase(folder)) return std::optional<VoxelGrid>{};  // labelsOfBundle() rejects it
  KERF_TRY(manifest, readCaseManifest(folder));
  const auto isVolume = [&](const CaseSource& source) { return isLabelVolume(folder / source.stored_as); };
  const auto source = std::find_if(manifest.sources.begin(), manifest.sources.end(), isVolume);
  if (source == manifest.sources.end()) return std::optional<VoxelGrid>{};

  LabelReadOptions options;
  if (std::error_code ignored; fs::exists(folder / kCaseRecipe, ignored)) {
    KERF_TRY(materials, readDefaultMaterials());
    KERF_TRY(recipe, readCaseRecipe(folder / kCaseRecipe, materials));
    if (recipe.labels) options.spacing_mm = recipe.labels->spacing_mm;
  }
  KERF_TRY(volume, summariseVolume(folder / source->stored_as, options));
  return std::optional(VoxelGrid{volume.grid.size, volume.grid.origin, volume.grid.axes()});
}

Expected<std::optional<VoxelGrid>> chosenGrid(const LabelExport& wanted) {
  if (wanted.grid == "case") return std::optional<VoxelGrid>{};
  KERF_TRY(folder, caseFolderOf(wanted));
  KERF_TRY(grid, gridOfScan(folder));
  if (!grid && wanted.grid == "scan")
    return fail({.code = Error::Code::kUnsupported,
                 .file = folder.string(),
                 .place = "--grid scan",
                 .found = "a case of meshes, which have no voxels",
                 .expected = "a case of a label volume",
                 .hint = "--grid case"});
  return std::move(grid);
}

json volumeJson(const RunLabels::Volume& v) {
  return {{"name", v.name}, {"voxels", v.voxels}, {"voxels_mm3", v.voxels_mm3}, {"ledger_mm3", v.ledger_mm3}};
}

json labelsJson(const LabelExport& wanted, const RunLabels& labels, bool is_of_scan) {
  const auto list = [](const std::vector<RunLabels::Volume>& volumes) {
    json out = json::array();
    for (const RunLabels::Volume& v : volumes) out.push_back(volumeJson(v));
    return out;
  };
  json out{{"files", wanted.outputs},
           {"size", labels.segmentation.grid.size},
           {"voxel_mm3", labels.segmentation.grid.voxelVolume()},
           {"grid", is_of_scan ? "scan" : "case"},
           {"tissues", list(labels.tissues)},
           {"removed", labels.removed ? volumeJson(*labels.removed) : json()},
           {"pieces", list(labels.pieces)},
           {"loose_voxels", labels.loose_voxels},
           {"segments", json::array()}};
  for (const Segment& s : labels.segmentation.segments)
    out["segments"].push_back({{"label", s.number}, {"id", s.id}, {"name", s.name}});
  return out;
}

void printVolume(const RunLabels::Volume& v) {
  const double apart = v.voxels_mm3 - v.ledger_mm3;
  const std::string share = v.ledger_mm3 > 0 ? fmt::format(" ({:+.2f} %)", 100 * apart / v.ledger_mm3) : "";
  printText("{}: {} voxels, {:.3f} mm3; ledger {:.3f} mm3, difference {:+.3f}{}\n", printable(v.name), v.voxels,
            v.voxels_mm3, v.ledger_mm3, apart, share);
}

void printLabels(const LabelExport& wanted, const RunLabels& labels, bool is_of_scan) {
  const VoxelGrid& grid = labels.segmentation.grid;
  printText("{} x {} x {} voxels of {:.4g} x {:.4g} x {:.4g} mm, {}\n", grid.size[0], grid.size[1], grid.size[2],
            grid.axes.col(0).norm(), grid.axes.col(1).norm(), grid.axes.col(2).norm(),
            is_of_scan ? "as in the scan" : "nodes of the case");
  for (const RunLabels::Volume& v : labels.tissues) printVolume(v);
  if (labels.removed) printVolume(*labels.removed);
  for (const RunLabels::Volume& v : labels.pieces) printVolume(v);
  if (labels.loose_voxels > 0) printText("in no piece: {}\n", counted(labels.loose_voxels, "voxel"));
  if (labels.has_moved) printText("moved pieces are at their scan positions\n");
  if (labels.fine_mm > 0)
    printText("cut in the fine region, in voxels of {:g} mm: resampled to those above\n", labels.fine_mm);
  for (const std::string& path : wanted.outputs) printText("written: {}\n", path);
}

}  // namespace

int exportLabels(const LabelExport& wanted) {
  bool is_of_scan = false;
  auto labels = [&]() -> Expected<RunLabels> {
    TerminalProgress progress;
    KERF_TRY(grid, chosenGrid(wanted));
    is_of_scan = grid.has_value();
    return labelsOfBundle(wanted.bundle, grid, progress.callback(), wanted.beside);
  }();
  if (!labels) return complain(labels.error());

  const TerminalProgress guard;  // Ctrl-C waits for complete files
  for (const std::string& path : wanted.outputs)
    if (const auto written = writeSegmentation(path, labels->segmentation); !written) return complain(written.error());
  if (wanted.json)
    printJson(labelsJson(wanted, *labels, is_of_scan));
  else
    printLabels(wanted, *labels, is_of_scan);
  return kOk;
}

}  // namespace kerf::cli
