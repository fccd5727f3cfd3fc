#include "preprocess/bake/bake_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "geometry/base/hash.h"
#include "geometry/base/version.h"
#include "geometry/formats/mesh_writer.h"
#include "preprocess/bake/trim_file.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

// Raise it with every change of the result for the same inputs.
constexpr int kBakeRevision = 7;

const char* nameOf(CloseMode mode) {
  switch (mode) {
    case CloseMode::kAuto:
      return "auto";
    case CloseMode::kBase:
      return "base";
    case CloseMode::kRepair:
      return "repair";
    case CloseMode::kWrap:
      return "wrap";
  }
  return "?";
}

std::string caseId(std::span<const std::string> hashes, const BakeOptions& o, const std::string& more) {
  std::string text = fmt::format("kerf-case {} {}\n", kBakeRevision, kVersion);
  for (const std::string& hash : hashes) text += hash + '\n';
  text += more;
  text += fmt::format("{} {} {}\n", o.unit, nameOf(o.close.mode), canonicalText(o.close));
  text += fmt::format("{} {} {} {} {}\n", o.voxelize.voxel_mm, o.voxelize.exterior_voxels, o.voxelize.interior_voxels,
                      o.voxelize.interior_mm, static_cast<int>(o.voxelize.material));
  if (o.region) {
    text += fmt::format("region {} {}", o.region->radius_mm, o.region->voxel_mm);
    for (const Vec3d& p : o.region->line) text += fmt::format(" {} {} {}", p[0], p[1], p[2]);
    text += '\n';
  }
  if (o.pair) text += fmt::format("{} {}\n", o.pair->frame, o.pair->partner);
  return sha256(std::as_bytes(std::span(text.data(), text.size())));
}

// The existing case, if it is the same one and undamaged.
std::optional<CaseManifest> existing(const fs::path& case_folder, const std::string& id) {
  if (!isCase(case_folder)) return {};
  auto manifest = readCaseManifest(case_folder);
  if (!manifest || manifest->id != id || !requireSha256(case_folder / kCaseSolid, manifest->solid_sha256, "") ||
      !requireSha256(case_folder / kCaseAnatomy, manifest->field_sha256, ""))
    return {};
  return std::move(*manifest);
}

// Where the object's volume went: per part, per material, and into gaps.
void describeMaterials(const BakeObject& object, const AnatomyStats& stats, Material fallback,
                       const MaterialTable& materials, CaseManifest& m) {
  std::map<Material, double> volumes;
  for (std::size_t n = 0; n < object.claims.size(); ++n) {
    volumes[object.claims[n].material] += stats.materials.claimed_mm3[n];
    m.parts[n].volume_mm3 = stats.materials.claimed_mm3[n];
  }
  if (object.claims.empty()) volumes[fallback] = stats.volume_mm3;
  if (!object.claims.empty()) m.gaps = CaseGaps{stats.materials.unclaimed_mm3, stats.materials.forgotten_mm3};
  if (stats.materials.forgotten_mm3 > 0) volumes[fallback] += stats.materials.forgotten_mm3;

  for (const auto& [material, volume] : volumes) {
    const MaterialProperties* row = materials.find(material);
    m.materials.push_back({row ? row->id : "?", static_cast<int>(material), volume});
  }
}

// Fills the manifest, except the hashes of files not yet written.
void describeCase(const BakeObject& object, const AnatomyStats& stats, const BakeOptions& options,
                  const MaterialTable& materials, CaseManifest& m) {
  m.kerf_version = kVersion;
  m.close_mode = options.close.only.empty() ? nameOf(options.close.mode) : namesOf(options.close.only);
  m.pair = options.pair;
  m.voxel_mm = options.voxelize.voxel_mm;
  describeMaterials(object, stats, options.voxelize.material, materials, m);
  m.solid_vertices = object.solid.vertices.size();
  m.solid_triangles = object.solid.triangles.size();
  m.solid_volume_mm3 = signedVolume(object.solid);
  m.solid_area_mm2 = surfaceArea(object.solid);
  m.box = bounds(object.solid);
  m.field_voxels = stats.active_voxels;
  m.shell_points = stats.shell_points;
  m.shell_area_mm2 = stats.shell_area_mm2;
}

}  // namespace

Expected<void> settleSizes(BakeOptions& o) {
  KERF_CHECK(checkVoxelSize(o.voxelize.voxel_mm));
  o.close.cleanup_length_mm = std::min(0.01 * o.voxelize.voxel_mm, 0.1);
  if (!o.region) return {};

  if (o.region->voxel_mm == 0) o.region->voxel_mm = o.voxelize.voxel_mm / 2;
  KERF_CHECK(checkVoxelSize(o.region->voxel_mm));
  if (o.region->voxel_mm < o.voxelize.voxel_mm) return {};
  return fail({.code = Error::Code::kBadValue,
               .place = "voxel size of the fine region",
               .found = fmt::format("{} mm", o.region->voxel_mm),
               .expected = fmt::format("less than the object's, {} mm", o.voxelize.voxel_mm),
               .hint = fmt::format("{}", o.voxelize.voxel_mm / 2)});
}

Expected<std::optional<AtomicFolder>> openCase(const fs::path& case_folder, std::span<const std::string> hashes,
                                               const std::string& more, BakeJob& job) {
  job.report.manifest.id = caseId(hashes, job.options, more);
  if (!job.options.overwrite)
    if (auto manifest = existing(case_folder, job.report.manifest.id)) {
      job.report.manifest = std::move(*manifest);
      job.report.was_up_to_date = true;
      KERF_TRY(solid, readCaseSolid(case_folder));
      job.report.pieces = countPieces(solid);
      return std::optional<AtomicFolder>();
    }
  KERF_TRY(staging, AtomicFolder::create(case_folder, job.options.overwrite, kCaseManifest));
  job.report.times.write += job.watch.lap();
  return std::optional<AtomicFolder>(std::move(staging));
}

MeshChecks checkAside(const std::vector<Mesh>& sources) {
  return std::async(std::launch::async, [&sources] {
    std::vector<MeshReport> reports;
    for (const Mesh& mesh : sources) reports.push_back(checkMesh(mesh));
    return reports;
  });
}

void finishClosing(MeshChecks& checks, BakeJob& job) {
  job.report.times.close = job.watch.lap();
  job.report.source_checks = checks.get();
  job.report.times.check = job.watch.lap();
}

Expected<BakedGrids> voxelizeObject(const BakeObject& object, const MaterialTable& materials, BakeJob& job) {
  VoxelizeOptions options = job.options.voxelize;
  for (const MaterialProperties& m : materials.rows())
    options.material_names +=
        fmt::format("{}{} {}", options.material_names.empty() ? "" : ", ", static_cast<int>(m.material), m.id);

  const std::optional<FineRegion>& region = job.options.region;
  const double coarse_done = region ? 0.6 : 0.85;
  KERF_TRY(anatomy, voxelize(object.solid, options, partOf(job.progress, 0.3, coarse_done), object.claims));
  BakedGrids grids{std::move(anatomy), {}};

  if (region) {
    KERF_TRY(fine,
             voxelizeRegion(object.solid, *region, options, partOf(job.progress, coarse_done, 0.85), object.claims));
    const AnatomyStats& stats = fine.stats();
    job.report.manifest.region = CaseRegion{*region, stats.active_voxels, stats.shell_points, stats.shell_area_mm2};
    grids.fine = std::move(fine);
  }
  job.report.times.voxelize = job.watch.lap();
  return grids;
}

Expected<void> writeCase(const BakeObject& object, const BakedGrids& grids, const MaterialTable& materials,
                         AtomicFolder& staging, BakeJob& job) {
  CaseManifest& manifest = job.report.manifest;
  describeCase(object, grids.anatomy.stats(), job.options, materials, manifest);
  job.report.pieces = countPieces(object.solid);

  if (!report(job.progress, 0.85, "writing")) return cancelledBeforeWriting();
  const fs::path& folder = staging.staging();
  if (const auto& trims = job.options.close.trims; !trims.empty()) KERF_CHECK(writeTrims(folder / kCaseTrim, trims));
  KERF_CHECK(writeMesh(folder / kCaseSolid, object.solid));
  KERF_CHECK(grids.anatomy.write(folder / kCaseAnatomy, grids.fine ? &*grids.fine : nullptr));
  KERF_TRY(solid_hash, sha256OfFile(folder / kCaseSolid));
  KERF_TRY(field_hash, sha256OfFile(folder / kCaseAnatomy));
  manifest.solid_sha256 = solid_hash;
  manifest.field_sha256 = field_hash;
  manifest.warnings = warningsOf(job.report);
  for (std::string& doubt : doubtsOfUnits(job.report)) manifest.warnings->push_back(std::move(doubt));
  KERF_CHECK(writeCaseManifest(folder, manifest));

  if (!report(job.progress, 0.95, "syncing")) return cancelledBeforeWriting();
  if (const auto committed = staging.commit(); !committed) {
    // Another program baked the same meanwhile.
    if (job.options.overwrite || !existing(staging.target(), manifest.id)) return fail(committed.error());
    job.report.was_up_to_date = true;
  }
  job.report.times.write += job.watch.lap();
  report(job.progress, 1.0, "done");
  return {};
}

}  // namespace kerf::internal
