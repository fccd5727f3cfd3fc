#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "geometry/case/case_bundle.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/formats/segmentation_file.h"
#include "geometry/mesh/solids.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/export/placed_pieces.h"
#include "sim/run/export/plane_parts_mesh.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_manifest.h"
#include "sim/run/files/small_cut.h"
#include "sim/run/report/run_report.h"
#include "ui/cli/command.h"
#include "ui/cli/export_labels.h"
#include "ui/cli/solid_source.h"

namespace kerf::cli {
namespace {

struct ExportArguments {
  std::string bundle;
  std::vector<std::string> outputs;
  std::size_t beside = 0;
  std::string piece;
  std::string grid;  // of a segmentation
  bool is_put_back = false, overwrites = false, json = false;
};

// A mesh and its file.
struct Output {
  std::string path;
  NamedMesh what;
};

std::string listOf(const std::vector<PlacedPiece>& pieces) {
  constexpr std::size_t kMost = 40;
  std::string names;
  for (std::size_t n = 0; n < std::min(kMost, pieces.size()); ++n)
    names += fmt::format("{}{} ({})", n ? ", " : "", n + 1, pieces[n].name);
  return pieces.size() > kMost ? fmt::format("{} and {} more", names, pieces.size() - kMost) : names;
}

Error noSuchPiece(const ExportArguments& a, const std::vector<PlacedPiece>& pieces) {
  return {.code = Error::Code::kNotFound,
          .file = a.bundle,
          .place = "--piece",
          .found = "\"" + a.piece + "\"",
          .expected = "all, or one of " + listOf(pieces),
          .hint = "its number or its name"};
}

// By number or name. Teeth may have numbers as names: exactly one piece must fit.
Expected<std::size_t> chosenPiece(const ExportArguments& a, const std::vector<PlacedPiece>& pieces) {
  std::vector<std::size_t> fit;
  for (std::size_t n = 0; n < pieces.size(); ++n)
    if (a.piece == std::to_string(n + 1) || a.piece == pieces[n].name) fit.push_back(n);
  if (fit.empty()) return fail(noSuchPiece(a, pieces));
  if (fit.size() == 1) return fit[0];
  return fail({.code = Error::Code::kBadValue,
               .file = a.bundle,
               .place = "--piece",
               .found = fmt::format("\"{}\", the number of one piece and the name of another", a.piece),
               .expected = "a word for one piece of " + listOf(pieces),
               .hint = "the number of the one, or the name of the other"});
}

NamedMesh namedPiece(const PlacedPiece& piece) { return {piece.mesh, objectsOf({&piece, 1})}; }

// Pieces at their moved poses, or at their original ones on request.
Expected<std::vector<Output>> outputsOf(const ExportArguments& a, const Export& result) {
  std::vector<Output> out;
  const bool is_as_in_case = std::none_of(result.pieces.begin(), result.pieces.end(), [&](const RunManifest::Piece& p) {
    return isNamedByUser(p.name) || (p.isMoved() && !a.is_put_back);
  });
  if (a.piece.empty() && is_as_in_case) {
    for (const std::string& path : a.outputs) out.push_back({path, result.names.grouped(result.post_op.mesh, path)});
    return out;
  }

  auto placed = result.pieces.empty()
                    ? Expected<std::vector<PlacedPiece>>(solidPieces(result.post_op.mesh, result.names))
                    : placedPieces(result.post_op.mesh, result.pieces, a.is_put_back, result.names);
  KERF_TRY(pieces, std::move(placed));
  for (const std::string& path : a.outputs) {
    if (a.piece.empty()) {
      out.push_back({path, {together(pieces), objectsOf(pieces)}});
    } else if (a.piece == "all") {
      const auto files = filesOfPieces(path, pieces);
      for (std::size_t n = 0; n < pieces.size(); ++n) out.push_back({files[n].string(), namedPiece(pieces[n])});
    } else {
      KERF_TRY(chosen, chosenPiece(a, pieces));
      out.push_back({path, namedPiece(pieces[chosen])});
    }
  }
  return out;
}

// Warns that this mesh lacks the cuts in other teeth of the scene.
Expected<void> warnOfExportNeighbours(const std::string& bundle) {
  KERF_TRY(manifest, readRunManifest(bundle));
  for (std::size_t n = 1; n <= manifest.beside.size(); ++n)
    if (const RunManifest::Beside& other = manifest.beside[n - 1]; other.removed_mm3 > 0)
      printText(stderr,
                "kerf: {:.4f} mm3 were also removed from {}, which this mesh does not include. Export it: kerf export "
                "{} --beside {} -o FILE\n",
                other.removed_mm3, other.case_path, bundle, n);
  return {};
}

// The ledger counts shares of voxels, the mesh has a surface: a disagreement means that one is wrong. `kerf info`
// reports unreadable numbers of a run. Dropped crumbs were not cut.
void warnOfLedger(const std::string& bundle, const PostOpReport& mesh) {
  constexpr double kMostApart = 0.02;  // of the volume
  const auto manifest = readRunManifest(bundle);
  if (!manifest || manifest->mode != kModeHaptic || !manifest->begin_sha256.empty()) return;
  const auto report = readRunSummary(bundle);
  if (!report || report->added_mm3.value_or(0) > 0) return;
  const double in_mesh_mm3 = mesh.removed_volume_mm3 - mesh.crumbs_volume_mm3;
  const double counted_mm3 = report->removed_mm3.value_or(0), apart = in_mesh_mm3 - counted_mm3;
  const double of_grid_mm3 =
      2 * volumeUncertainty(manifest->voxel_mm);  // half a voxel each of the mesh and of the ledger
  if (counted_mm3 > 0 && std::abs(apart) > std::max(of_grid_mm3, kMostApart * counted_mm3))
    printText(stderr,
              "kerf: WARNING: the run counted {:.4f} mm3, the mesh lacks {:.4f} ({:+.0f} %): the cutting part of {} is "
              "too thin for voxels of {:g} mm, or the feed was too fast. Bake with smaller voxels, or feed slower\n",
              counted_mm3, in_mesh_mm3, 100 * apart / counted_mm3, manifest->tool_id, manifest->voxel_mm);
}

void warnOfSmallCut(const std::string& bundle, const PostOpReport& mesh) {
  const auto manifest = readRunManifest(bundle);
  if (!manifest || mesh.added_volume_mm3 > 0) return;
  // The mesh lacks parts smaller than a voxel.
  const auto report = readRunSummary(bundle);
  const double counted = report ? report->removed_mm3.value_or(0) : 0;
  if (const auto small = smallCut(counted > 0 ? counted : mesh.removed_volume_mm3, manifest->voxel_mm))
    printText(stderr, "kerf: WARNING: {}\n", *small);
}

// Without a kerf both parts of a plane cut share its face.
void warnOfTouching(const ExportArguments& a, const Export& result) {
  const std::size_t touching = a.piece.empty() ? countTouching(result.pieces, a.is_put_back) : 0;
  if (touching > 0)
    printText(stderr,
              "kerf: WARNING: {} pieces touch along a cut without kerf: in one file they fail the print check. Export "
              "one file per piece: --piece all\n",
              touching);
}

nlohmann::json piecesOf(const Export& result) {
  nlohmann::json out = nlohmann::json::array();
  for (const RunManifest::Piece& p : result.pieces)
    out.push_back({{"name", p.name}, {"volume_mm3", p.volume_mm3}, {"is_moved", p.isMoved()}});
  return out;
}

nlohmann::json exportJson(const std::vector<Output>& outputs, const Export& result) {
  const PostOpReport& r = result.post_op.report;
  const WallAccuracy& w = result.accuracy;
  std::vector<std::string> files;
  for (const Output& output : outputs) files.push_back(output.path);
  return {{"files", files},
          {"session_pieces", piecesOf(result)},
          {"vertices", result.post_op.mesh.vertices.size()},
          {"triangles", result.post_op.mesh.triangles.size()},
          {"source_vertices_kept", r.source_vertices_kept},
          {"source_vertices_removed", r.source_vertices_removed},
          {"cut_triangles", r.cut_triangles},
          {"pieces", r.pieces},
          {"cavities", r.cavities},
          {"source_volume_mm3", r.source_volume_mm3},
          {"result_volume_mm3", r.result_volume_mm3},
          {"removed_volume_mm3", r.removed_volume_mm3},
          {"added_volume_mm3", r.added_volume_mm3},
          {"crumbs_dropped", r.crumbs_dropped},
          {"source_vertices_in_crumbs", r.source_vertices_in_crumbs},
          {"crumbs_volume_mm3", r.crumbs_volume_mm3},
          {"crumbs_below_mm3", r.crumb_mm3},
          {"largest_move_mm", r.largest_move_mm},
          {"boolean_triangles", r.boolean_triangles},
          {"attempts", r.attempts},
          {"wall", {{"vertices", w.vertices}, {"rms_mm", w.rms_mm}, {"max_mm", w.max_mm}}}};
}

void printExportVolumes(const PostOpMesh& result, bool is_case) {
  const PostOpReport& r = result.report;
  const std::string pieces = describe(PieceCount{.pieces = r.pieces, .cavities = r.cavities});
  if (is_case) {
    printText("solid of the case, nothing cut: {} vertices, {} triangles, {:.4f} mm3; {}\n",
              result.mesh.vertices.size(), result.mesh.triangles.size(), r.result_volume_mm3, pieces);
    return;
  }
  const bool has_added = r.added_volume_mm3 != 0;
  printText("removed {:.4f} mm3 of {:.4f} mm3; {}\n", r.removed_volume_mm3, r.source_volume_mm3, pieces);
  if (has_added) printText("added {:.4f} mm3\n", r.added_volume_mm3);
  printText("vertices of the solid: {} kept bit for bit, {} inside {}; {} of {} triangles are {}\n",
            r.source_vertices_kept, r.source_vertices_removed, has_added ? "the cut and the added volume" : "the cut",
            r.cut_triangles, result.mesh.triangles.size(), has_added ? "new" : "cut faces");
}

void printExport(const ExportArguments& a, const std::vector<Output>& outputs, const Export& result) {
  printExportVolumes(result.post_op, isCase(a.bundle));

  const WallAccuracy& w = result.accuracy;
  if (w.vertices)
    printText(
        "cut walls lie {:.1f} um rms, {:.1f} um at most from the exact sweep of the tool ({} vertices measured)\n",
        1e3 * w.rms_mm, 1e3 * w.max_mm, w.vertices);
  if (!result.accuracy_missing.empty()) printText("cannot measure the cut walls: {}\n", result.accuracy_missing);

  const PostOpReport& r = result.post_op.report;
  if (r.cavities > 0) printText("Closed cavities: a resin or powder printer leaves material in them.\n");
  if (r.crumbs_dropped)
    printText("dropped {} below {:.2g} mm3, {:.6f} mm3 together\n", counted(r.crumbs_dropped, "crumb"), r.crumb_mm3,
              r.crumbs_volume_mm3);
  if (r.attempts > 1)
    printText("took {} attempts: the cut was shifted by a few thousandths of a voxel to survive float32\n", r.attempts);
  for (const RunManifest::Piece& p : result.pieces)
    if (p.isMoved())
      printText("{} {}: {:.2f} mm off its place in the scan\n", printable(p.name), a.is_put_back ? "put back" : "moved",
                (p.T_case_piece * p.inside - p.inside).norm());
  for (const Output& output : outputs) printText("written: {}\n", output.path);
}

// Rejects paths of Kerf's scans and, unless the user allows it, existing files.
Expected<void> requireWritable(const ExportArguments& a, const std::string& path) {
  KERF_CHECK(requireNotInput(a.bundle, path));
  return requireFree(path, a.overwrites);
}

// One file per piece may go into a folder, made if missing: NAME.run gives FOLDER/NAME-PIECE.stl.
Expected<std::vector<std::string>> namesOfOutputs(const ExportArguments& a) {
  namespace fs = std::filesystem;
  std::vector<std::string> out;
  for (const std::string& path : a.outputs) {
    std::error_code failed;
    const bool is_folder =
        fs::is_directory(path, failed) || (!fs::exists(path, failed) && !fs::path(path).has_extension());
    if (a.piece != "all" || !is_folder) {
      out.push_back(path);
      continue;
    }
    fs::create_directories(path, failed);
    if (failed)
      return fail({.code = Error::Code::kWriteFailed,
                   .file = path,
                   .found = failed.message(),
                   .expected = "a folder that Kerf can create",
                   .hint = "choose another path for -o"});
    const fs::path bundle = (fs::path(a.bundle) / ".").lexically_normal().parent_path();
    out.push_back((fs::path(path) / bundle.stem().concat(".stl")).string());
  }
  return out;
}

// Segmentations instead of meshes.
int runLabels(const ExportArguments& a) {
  const auto isMesh = [](const std::string& path) { return !isSegmentationFile(path); };
  const auto mesh = std::find_if(a.outputs.begin(), a.outputs.end(), isMesh);
  if (mesh != a.outputs.end())
    return complain({.code = Error::Code::kBadValue,
                     .file = *mesh,
                     .place = "-o",
                     .found = "a mesh beside a segmentation",
                     .expected = "meshes alone, or segmentations alone",
                     .hint = "kerf export twice"});
  if (!a.piece.empty())
    return complain({.code = Error::Code::kUnsupported,
                     .file = a.outputs.front(),
                     .place = "--piece",
                     .found = "a segmentation of one piece",
                     .expected = "all pieces: each has segments of its own in the file",
                     .hint = "leave out --piece"});
  for (const std::string& path : a.outputs) {
    if (const auto possible = canWriteFile(path); !possible) return complain(possible.error());
    if (const auto checked = requireWritable(a, path); !checked) return complain(checked.error());
  }
  return exportLabels({a.bundle, a.outputs, a.grid, a.beside, a.json});
}

int runExport(const ExportArguments& given) {
  ExportArguments a = given;
  if (std::any_of(a.outputs.begin(), a.outputs.end(), isSegmentationFile)) return runLabels(a);
  if (!a.grid.empty())
    return complain({.code = Error::Code::kBadValue,
                     .file = a.outputs.front(),
                     .place = "--grid",
                     .found = "a mesh, which has no voxels",
                     .expected = "a name that ends in .seg.nrrd",
                     .hint = "leave out --grid"});
  const auto names = namesOfOutputs(a);
  if (!names) return complain(names.error());
  a.outputs = *names;

  // Checks names before the long work, and before any file of the set is written.
  for (const std::string& path : a.outputs) {
    if (const auto possible = canWriteMesh(path); !possible) return complain(possible.error());
    if (a.piece == "all") continue;  // files have other names
    if (const auto free = requireFree(path, a.overwrites); !free) return complain(free.error());
  }
  auto result = [&] {
    TerminalProgress progress;
    return exportBundle(a.bundle, {}, progress.callback(), a.beside);
  }();
  if (!result) return complain(result.error());

  const TerminalProgress guard;  // Ctrl-C waits for complete files
  const auto outputs = outputsOf(a, *result);
  if (!outputs) return complain(outputs.error());
  for (const Output& output : *outputs)
    if (const auto checked = requireWritable(a, output.path); !checked) return complain(checked.error());
  for (const Output& output : *outputs)
    if (const auto written = writeMesh(output.path, output.what.mesh, {.objects = output.what.objects}); !written)
      return complain(written.error());

  if (a.beside == 0 && isRun(a.bundle))
    if (const auto warned = warnOfExportNeighbours(a.bundle); !warned) return complain(warned.error());
  if (a.beside == 0 && isRun(a.bundle)) warnOfLedger(a.bundle, result->post_op.report);
  if (a.beside == 0 && isRun(a.bundle)) warnOfSmallCut(a.bundle, result->post_op.report);
  warnOfTouching(a, *result);
  if (a.json)
    printJson(exportJson(*outputs, *result));
  else
    printExport(a, *outputs, *result);
  return kOk;
}

}  // namespace

void addExport(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<ExportArguments>();
  command.footer("Example: kerf export molar.run -o molar.stl -o molar.ply");
  command.add_option("RUN|CASE", a->bundle, "run or case folder, or a session file (.kerf)")->required();
  command
      .add_option("-o,--output", a->outputs,
                  writableFormats() + "; colours in " + colorFormats() +
                      ". NAME.seg.nrrd: the tissues as voxels, for 3D Slicer. Repeat for several")
      ->required()
      ->expected(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_option("--beside", a->beside, "export the N-th neighbour (kerf cut --beside) instead of the case")
      ->check(CLI::PositiveNumber);
  command
      .add_option("--piece", a->piece,
                  "export one piece of a split object, by number or name; all: one file per piece, NAME-PIECE.stl, in "
                  "the folder of NAME.stl or in the folder of -o")
      ->type_name("N|NAME|all");
  command.add_flag("--put-back", a->is_put_back, "export pieces at their scan positions, not where they were moved");
  command
      .add_option(
          "--grid", a->grid,
          "voxels of a .seg.nrrd: those of the scan if it was a volume (scan, the default), or of the case (case)")
      ->check(CLI::IsMember({"scan", "case"}));
  addOverwrite(command, a->overwrites, "replace existing files");
  command.add_flag("--json", a->json, "print the summary as JSON on standard output");
  addCasePlaces(command);
  command.callback([a, &exit_code] { exit_code = runExport(*a); });
}

}  // namespace kerf::cli
