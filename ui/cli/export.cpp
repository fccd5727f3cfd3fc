#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "geometry/case/case_bundle.h"
#include "geometry/formats/mesh_formats.h"
#include "geometry/formats/mesh_writer.h"
#include "sim/run/export_bundle.h"
#include "sim/run/run_manifest.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct Arguments {
  std::string bundle;
  std::vector<std::string> outputs;
  std::size_t beside = 0;
  bool json = false;
};

// What the cut took off the other teeth of the scene is in no mesh yet.
Expected<void> warnOfNeighbours(const std::string& bundle) {
  KERF_TRY(manifest, readRunManifest(bundle));
  for (std::size_t n = 1; n <= manifest.beside.size(); ++n)
    if (const RunManifest::Beside& other = manifest.beside[n - 1]; other.removed_mm3 > 0)
      fmt::print(stderr,
                 "kerf: {:.4f} mm3 were cut off {}, too; not in this mesh: kerf export {} --beside {} -o FILE\n",
                 other.removed_mm3, other.case_path, bundle, n);
  return {};
}

nlohmann::json jsonOf(const Arguments& a, const Export& result) {
  const PostOpReport& r = result.post_op.report;
  const WallAccuracy& w = result.accuracy;
  return {{"files", a.outputs},
          {"vertices", result.post_op.mesh.vertices.size()},
          {"triangles", result.post_op.mesh.triangles.size()},
          {"source_vertices_kept", r.source_vertices_kept},
          {"source_vertices_removed", r.source_vertices_removed},
          {"cut_triangles", r.cut_triangles},
          {"pieces", r.pieces},
          {"source_volume_mm3", r.source_volume_mm3},
          {"result_volume_mm3", r.result_volume_mm3},
          {"removed_volume_mm3", r.removed_volume_mm3},
          {"added_volume_mm3", r.added_volume_mm3},
          {"crumbs_dropped", r.crumbs_dropped},
          {"source_vertices_in_crumbs", r.source_vertices_in_crumbs},
          {"crumbs_volume_mm3", r.crumbs_volume_mm3},
          {"largest_move_mm", r.largest_move_mm},
          {"attempts", r.attempts},
          {"wall", {{"vertices", w.vertices}, {"rms_mm", w.rms_mm}, {"max_mm", w.max_mm}}}};
}

void printVolumes(const PostOpMesh& result, bool is_case) {
  const PostOpReport& r = result.report;
  const std::string pieces = counted(r.pieces, "piece");
  if (is_case) {
    fmt::print("solid of the case, nothing cut: {} vertices, {} triangles, {:.4f} mm3; {}\n",
               result.mesh.vertices.size(), result.mesh.triangles.size(), r.result_volume_mm3, pieces);
    return;
  }
  const bool has_added = r.added_volume_mm3 != 0;
  fmt::print("removed {:.4f} mm3 of {:.4f} mm3; {}\n", r.removed_volume_mm3, r.source_volume_mm3, pieces);
  if (has_added) fmt::print("added {:.4f} mm3\n", r.added_volume_mm3);
  fmt::print("vertices of the solid: {} kept bit for bit, {} inside {}; {} of {} triangles are {}\n",
             r.source_vertices_kept, r.source_vertices_removed, has_added ? "what was cut or added" : "the cut",
             r.cut_triangles, result.mesh.triangles.size(), has_added ? "new" : "cut faces");
}

void print(const Arguments& a, const Export& result) {
  printVolumes(result.post_op, isCase(a.bundle));

  const WallAccuracy& w = result.accuracy;
  if (w.vertices)
    fmt::print(
        "cut walls lie {:.1f} um rms, {:.1f} um at most from the exact sweep of the tool ({} vertices measured)\n",
        1e3 * w.rms_mm, 1e3 * w.max_mm, w.vertices);
  if (!result.accuracy_missing.empty())
    fmt::print("the cut walls could not be measured: {}\n", result.accuracy_missing);

  const PostOpReport& r = result.post_op.report;
  if (r.crumbs_dropped) fmt::print("dropped {} crumbs, {:.6f} mm3 together\n", r.crumbs_dropped, r.crumbs_volume_mm3);
  if (r.attempts > 1)
    fmt::print("took {} attempts: the cut was shifted by a few thousandths of a voxel to survive float32\n",
               r.attempts);
  for (const std::string& path : a.outputs) fmt::print("written: {}\n", path);
}

int run(const Arguments& a) {
  // A name that cannot be written costs seconds now, not minutes later, and no file beside it gets written alone.
  for (const std::string& path : a.outputs)
    if (const auto possible = canWriteMesh(path); !possible) return complain(possible.error());
  auto result = [&] {
    TerminalProgress progress;
    return exportBundle(a.bundle, {}, progress.callback(), a.beside);
  }();
  if (!result) return complain(result.error());

  const TerminalProgress guard;  // Ctrl-C waits until no file is half written
  for (const std::string& path : a.outputs)
    if (const auto written = writeMesh(path, result->post_op.mesh); !written) return complain(written.error());

  if (a.beside == 0 && isRun(a.bundle))
    if (const auto warned = warnOfNeighbours(a.bundle); !warned) return complain(warned.error());
  if (a.json)
    printJson(jsonOf(a, *result));
  else
    print(a, *result);
  return kOk;
}

}  // namespace

void addExport(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  command.footer("Example: kerf export molar.run -o molar.stl -o molar.ply");
  command.add_option("RUN|CASE", a->bundle, "run or case folder")->required();
  command
      .add_option("-o,--output", a->outputs,
                  writableFormats() + "; colours in " + colorFormats() + ". Repeat for several")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      .add_option("--beside", a->beside,
                  "instead of the case that was cut: the N-th case that stood beside it (kerf cut --beside)")
      ->check(CLI::PositiveNumber);
  command.add_flag("--json", a->json, "summary as JSON on standard output");
  command.callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace kerf::cli
