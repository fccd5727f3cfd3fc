#include "sim/run/export/export_bundle.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/base/hash.h"
#include "geometry/boolean/removed_solid.h"
#include "geometry/case/case_bundle.h"
#include "geometry/tool/tool_file.h"
#include "sim/hand/path.h"
#include "sim/run/export/plane_parts_mesh.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_output.h"
#include "sim/run/sweep/swept_path.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// Vertices of cut triangles only; at most about `most` of them, evenly chosen.
std::vector<Vec3d> wallVertices(const PostOpMesh& result, std::size_t most) {
  std::vector<char> wall(result.mesh.vertices.size(), 1);
  for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
    if (!result.is_cut[t])
      for (const std::uint32_t v : result.mesh.triangles[t]) wall[v] = 0;

  std::vector<Vec3d> points;
  for (std::size_t v = 0; v < wall.size(); ++v)
    if (wall[v]) points.push_back(result.mesh.vertices[v]);
  const std::size_t stride = points.size() / most + 1;
  std::vector<Vec3d> sampled;
  for (std::size_t i = 0; i < points.size(); i += stride) sampled.push_back(points[i]);
  return sampled;
}

// Distance of wall vertices to the exact sweep along the path itself, not its merged motions. Cancelled: kCancelled.
Expected<WallAccuracy> measureWalls(const fs::path& run_folder, const RunManifest& m, const PostOpMesh& result,
                                    const Progress& progress) {
  constexpr std::size_t kSamples = 4000, kAtOnce = 256;
  constexpr double kTolerance = 1e-6;  // mm
  std::vector<RunManifest::EarlierCut> cuts = m.earlier;
  cuts.push_back({m.tool_id, internal::kRunToolCopy, m.tool_sha256, m.path_file, m.path_sha256});
  std::vector<Tool> tools;
  std::vector<CutPath> paths;
  for (const RunManifest::EarlierCut& cut : cuts) {
    KERF_TRY(tool, readTool(run_folder / cut.tool_file));
    KERF_TRY(path, readPath(run_folder / cut.path_file));
    tools.push_back(std::move(tool));
    paths.push_back(std::move(path));
  }
  const std::vector<Vec3d> points = wallVertices(result, kSamples);

  const double far = 4 * m.voxel_mm;
  std::vector<SweptPath> swept;
  for (std::size_t n = 0; n < cuts.size(); ++n) swept.emplace_back(*tools[n].cut, paths[n]);
  std::vector<double> nearest(points.size());
  for (std::size_t begin = 0; begin < points.size(); begin += kAtOnce) {
    if (!report(progress, 1.0, "measuring the cut walls")) return internal::nothingWritten();
    tbb::parallel_for(begin, std::min(begin + kAtOnce, points.size()), [&](std::size_t i) {
      nearest[i] = far;
      for (const SweptPath& one : swept)
        nearest[i] = std::min(nearest[i], one.nearest(points[i], far, kTolerance).distance_mm);
    });
  }

  WallAccuracy out;
  double squares = 0;
  for (const double d : nearest) {
    squares += d * d;
    out.max_mm = std::max(out.max_mm, std::abs(d));
  }
  out.vertices = nearest.size();
  out.rms_mm = nearest.empty() ? 0 : std::sqrt(squares / static_cast<double>(nearest.size()));
  return out;
}

// Whether phi < phi0 anywhere: material was added.
bool liesDeeper(const BrickField& phi, const BrickField& phi0) {
  for (std::size_t b = 0; b < phi.brickCount(); ++b) {
    const BrickValues* const before = phi0.valuesAt(phi.brickCoord(b));
    const float constant = phi0.constantAt(phi.brickCoord(b));
    for (std::size_t n = 0; n < kBrickNodes; ++n)
      if (phi.brick(b)[n] < (before ? (*before)[n] : constant)) return true;
  }
  return false;
}

// A case and its cut by a run.
struct CutCase {
  CaseManifest manifest;
  Mesh solid;
  BrickField phi0;  // on the grid of `cut`
  BrickField cut;   // the sweep of a geometry-only run, else the cut field
};

Expected<CutCase> loadCut(const fs::path& run_folder, const RunManifest& manifest, const fs::path& case_folder,
                          std::size_t beside) {
  KERF_TRY(in_case, readCaseManifest(case_folder));
  KERF_TRY(solid, readCaseSolid(case_folder));
  KERF_TRY(phi0, readCaseField(case_folder));
  const bool is_geometry = manifest.hasSweep();
  KERF_TRY(cut, is_geometry ? readRunSweep(run_folder) : readRunCutField(run_folder, beside));
  const char* const advice = "cut again; runs must not be edited";
  // For a session: the tools that were in hand.
  for (const RunManifest::ToolFile& tool : manifest.tools)
    if ((", " + manifest.tool_id + ", ").find(", " + tool.id + ", ") != std::string::npos)
      KERF_CHECK(requireSha256(run_folder / tool.file, tool.sha256, advice));
  if (manifest.mode != kModeSession) {
    KERF_CHECK(requireSha256(run_folder / internal::kRunToolCopy, manifest.tool_sha256, advice));
    KERF_CHECK(requireSha256(run_folder / manifest.path_file, manifest.path_sha256, advice));
  }
  for (const RunManifest::EarlierCut& earlier : manifest.earlier) {
    KERF_CHECK(requireSha256(run_folder / earlier.tool_file, earlier.tool_sha256, advice));
    KERF_CHECK(requireSha256(run_folder / earlier.path_file, earlier.path_sha256, advice));
  }

  if (const auto& region = in_case.region; region && cut.voxel() == region->where.voxel_mm) {
    KERF_TRY(fine, readCaseRegionField(case_folder, phi0));
    phi0 = std::move(fine);
  }
  if (cut.voxel() != phi0.voxel())
    return fail({.code = Error::Code::kBadValue,
                 .file = (run_folder / internal::kRunField).string(),
                 .place = is_geometry ? "grid sweep" : "grid phi",
                 .found = fmt::format("{} mm voxels", cut.voxel()),
                 .expected = fmt::format("{} mm, as in the case", phi0.voxel()),
                 .hint = "cut again"});
  if (!is_geometry) KERF_CHECK(requireOnlyTaken(run_folder, manifest, cut, phi0, beside));
  return CutCase{std::move(in_case), std::move(solid), std::move(phi0), std::move(cut)};
}

Expected<PostOpMesh> meshOf(const CutCase& loaded, bool is_geometry, std::span<const RunManifest::Piece> pieces,
                            const PostOpOptions& options, const Progress& progress) {
  if (areCutByPlanes(pieces)) return planePartsMesh(loaded.solid, loaded.phi0, loaded.cut, pieces, options, progress);
  if (!is_geometry) return postOperativeMeshOf(loaded.solid, loaded.phi0, loaded.cut, options, progress);
  return postOperativeMesh(loaded.solid, removedFieldFromSweep(loaded.phi0, loaded.cut), options, progress);
}

Expected<Export> exportCase(const fs::path& folder, const PostOpOptions& options, const Progress& progress) {
  KERF_TRY(manifest, readCaseManifest(folder));
  KERF_TRY(solid, readCaseSolid(folder));
  const BrickField nothing(manifest.voxel_mm, static_cast<float>(4 * manifest.voxel_mm));
  KERF_TRY(mesh, postOperativeMesh(solid, nothing, options, progress));
  Export out;
  out.post_op = std::move(mesh);
  out.names = ObjectNames::ofCase(folder, manifest);
  return out;
}

Expected<Export> exportRun(const fs::path& folder, const PostOpOptions& options, const Progress& progress,
                           std::size_t beside) {
  KERF_TRY(manifest, readRunManifest(folder));
  KERF_CHECK(internal::requireBeside(folder, manifest, beside));
  KERF_TRY(case_folder, internal::locateCase(folder, manifest, beside));
  if (!report(progress, 0.0, "loading")) return internal::nothingWritten();
  KERF_TRY(loaded, loadCut(folder, manifest, case_folder, beside));

  const bool is_geometry = manifest.hasSweep();
  std::span<const RunManifest::Piece> pieces;
  if (beside == 0) pieces = manifest.pieces;
  auto result = meshOf(loaded, is_geometry, pieces, options, progress);
  if (!result) {
    result.error().file = folder.string();
    return fail(result.error());
  }
  Export out;
  out.post_op = std::move(*result);
  if (beside == 0) out.pieces = manifest.pieces;
  out.names = ObjectNames::ofCase(case_folder, loaded.manifest);

  // The mesh is made and verified: a failed measurement does not discard it.
  if (manifest.mode == kModeGeometry && !is_geometry)
    out.accuracy_missing = "continues a run cut against resistance, which has no exact sweep";
  else if (!is_geometry)
    out.accuracy_missing = "cut against resistance: there is no exact sweep";
  else if (const auto accuracy = measureWalls(folder, manifest, out.post_op, progress))
    out.accuracy = *accuracy;
  else if (accuracy.error().code == Error::Code::kCancelled)
    return fail(accuracy.error());
  else
    out.accuracy_missing = accuracy.error().message();
  return out;
}

// A mesher also knows bricks that undo restored; a run's file does not, and each has an order of its own. Without those
// bricks, and in one order, a session exports the same bits as its run: the triangles of the cut, their later
// processing and the repair after rounding follow the order of the bricks.
BrickField withoutRestored(const BrickField& known, const BrickField& phi0) {
  const auto isRestored = [&](std::size_t b) {
    const BrickValues& now = known.brick(b);
    if (const BrickValues* const loaded = phi0.valuesAt(known.brickCoord(b))) return now == *loaded;
    const float constant = phi0.constantAt(known.brickCoord(b));
    return std::all_of(now.begin(), now.end(), [constant](float value) { return value == constant; });
  };
  std::vector<std::size_t> changed;
  for (std::size_t b = 0; b < known.brickCount(); ++b)
    if (!isRestored(b)) changed.push_back(b);
  std::sort(changed.begin(), changed.end(), [&](std::size_t a, std::size_t b) {
    return coordKey(known.brickCoord(a)) < coordKey(known.brickCoord(b));
  });

  BrickField out(known.voxel(), known.background(), known.interior());
  out.reserve(changed.size());
  for (const std::size_t b : changed) out.add(known.brickCoord(b), known.brick(b));
  return out;
}

}  // namespace

Expected<PostOpMesh> postOperativeMeshOf(const Mesh& solid, const BrickField& phi0, const BrickField& known,
                                         const PostOpOptions& options, const Progress& progress) {
  const BrickField changed = withoutRestored(known, phi0);
  BrickField removed = removedFieldFromCut(phi0, changed);
  if (!liesDeeper(changed, phi0)) return postOperativeMesh(solid, removed, options, progress);

  BrickField added = addedFieldFromFill(phi0, changed);
  clearAwayFromInside(removed);
  clearAwayFromInside(added);
  return postOperativeMesh(solid, removed, options, progress, &added);
}

Expected<Export> exportBundle(const fs::path& bundle, const PostOpOptions& options, const Progress& progress,
                              std::size_t beside) {
  if (isCase(bundle)) {
    KERF_CHECK(internal::requireBeside(bundle, {}, beside));
    return exportCase(bundle, options, progress);
  }
  if (isRun(bundle)) return exportRun(bundle, options, progress, beside);
  return fail({.code = Error::Code::kNotFound,
               .file = bundle.string(),
               .found = "neither a run nor a case",
               .expected = "a folder with run.toml or case.toml",
               .hint = "kerf bake, then kerf cut"});
}

}  // namespace kerf
