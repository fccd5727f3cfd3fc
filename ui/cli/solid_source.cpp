#include "ui/cli/solid_source.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>
#include <vector>

#include "geometry/case/case_bundle.h"
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
  std::error_code ignored;
  const fs::path file = fs::weakly_canonical(what, ignored);
  return (file.has_filename() ? file : file.parent_path()).stem().string();
}

// kerf bake closes open meshes and reports its changes.
Expected<SolidSource> readSolidMesh(const std::string& what, const std::string& unit) {
  KERF_TRY(read, readMeshInMm(what, unit));
  SolidSource out;
  out.solid = std::move(read.mesh);
  out.name = stemOf(what);
  out.note = std::move(read.note);
  for (Vec3d& p : out.solid.vertices) p = p.cast<float>().cast<double>();  // output is in single precision
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
  for (const RunManifest::Piece& piece : exported.pieces)
    if (piece.isMoved()) out.note = "pieces are taken at their scan positions, not where they were moved";
  return out;
}

Expected<void> requireNotInput(const fs::path& input, const fs::path& output) {
  const auto refuse = [&](const char* found) {
    return fail({.code = Error::Code::kBadValue,
                 .file = output.string(),
                 .found = found,
                 .expected = "another name: Kerf never overwrites a scan",
                 .hint = "another name or folder"});
  };
  std::error_code ignored;
  if (!isRun(input) && !isCase(input))
    return fs::equivalent(output, input, ignored) ? refuse("an input file") : Expected<void>();

  std::vector<fs::path> folders{input};
  if (isRun(input)) {
    KERF_TRY(of_run, caseOfRun(input));
    folders.push_back(of_run);
    if (const auto beside = casesBesideRun(input))  // those that are there
      folders.insert(folders.end(), beside->begin(), beside->end());
  }
  for (const fs::path& folder : folders) {
    const fs::path in = fs::weakly_canonical(output, ignored).lexically_relative(fs::canonical(folder, ignored));
    if (!in.empty() && *in.begin() != ".." && fs::exists(output, ignored))
      return refuse("a file in the folder of an input");
    if (!isCase(folder)) continue;
    KERF_TRY(manifest, readCaseManifest(folder));
    KERF_CHECK(requireNoSource(output, manifest));
  }
  return {};
}

}  // namespace kerf::cli
