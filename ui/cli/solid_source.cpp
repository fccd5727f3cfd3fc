#include "ui/cli/solid_source.h"

#include <fmt/format.h>

#include <utility>

#include "geometry/mesh/mesh_check.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/export/placed_pieces.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_manifest.h"
#include "ui/app/view/mesh_in_mm.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;

// "arch" of "arch.stl", "arch.case" and "arch.case/".
std::string stemOf(const fs::path& what) {
  const fs::path file = what.has_filename() ? what : what.parent_path();
  return file.stem().string();
}

// kerf bake closes open meshes and reports its changes.
Expected<SolidSource> readSolidMesh(const std::string& what, const std::string& unit) {
  KERF_TRY(read, readMeshInMm(what, unit));
  SolidSource out;
  out.solid = std::move(read.mesh);
  out.name = stemOf(what);
  out.note = std::move(read.note);
  if (read.unit != "mm")  // output is in single precision
    for (Vec3d& p : out.solid.vertices) p = p.cast<float>().cast<double>();
  out.names = ObjectNames::ofMesh(out.solid, read.objects);
  const MeshReport report = checkMesh(out.solid);
  if (report.print_ready) return out;
  return fail({.code = Error::Code::kGeometry,
               .file = what,
               .found = report.reasons.empty() ? "not a solid" : report.reasons.front(),
               .expected = "a solid: closed, without crossings",
               .hint = fmt::format("kerf bake {} -o {}.case, then the case in its place", what, out.name)});
}

}  // namespace

Expected<SolidSource> readSolid(const std::string& what, const std::string& unit) {
  const bool is_run = isRun(what);
  if (!is_run && !isCase(what)) return readSolidMesh(what, unit);

  KERF_TRY(exported, [&] {
    TerminalProgress progress;
    return exportBundle(what, {}, progress.callback());
  }());
  SolidSource out;
  out.name = stemOf(what);
  out.solid = std::move(exported.post_op.mesh);
  out.names = std::move(exported.names);
  fs::path folder = what;
  if (is_run) {
    KERF_TRY(of_run, caseOfRun(what));
    folder = of_run;
  }
  KERF_TRY(manifest, readCaseManifest(folder));
  out.of_case = std::move(manifest);
  for (const RunManifest::Piece& piece : exported.pieces)
    if (piece.isMoved()) out.note = "pieces are taken at their scan positions, not where they were moved";
  return out;
}

Expected<void> requireNotInput(const std::string& what, const SolidSource& source, const fs::path& output) {
  if (source.of_case) return requireNoSource(output, *source.of_case);
  std::error_code ignored;
  if (!fs::equivalent(output, what, ignored)) return {};
  return fail({.code = Error::Code::kBadValue,
               .file = output.string(),
               .found = "the input file",
               .expected = "another name: Kerf never overwrites a scan",
               .hint = "another name or folder"});
}

}  // namespace kerf::cli
