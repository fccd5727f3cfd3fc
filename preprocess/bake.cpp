#include "preprocess/bake.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>

#include "geometry/atomic_file.h"
#include "geometry/hash.h"
#include "geometry/mesh_io.h"
#include "geometry/mesh_writer.h"
#include "geometry/version.h"
#include "preprocess/unit.h"

namespace kerf {
namespace {

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

// The extension to store a source under. A name may hold any byte, a manifest only text: odd ones are dropped.
std::string safeExtension(const std::filesystem::path& path) {
  const std::string e = path.extension().string();
  const auto plain = [](char c) {
    return c == '.' || (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  };
  return std::all_of(e.begin(), e.end(), plain) ? e : std::string();
}

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double s = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return s;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

// A part of the whole job's progress.
Progress part(const Progress& whole, double from, double to) {
  if (!whole) return {};
  return [whole, from, to](double f, std::string_view what) { return whole(from + f * (to - from), what); };
}

std::string caseId(const CaseManifest& m, const BakeOptions& o) {
  std::string text = "kerf-case 1\n";
  for (const CaseSource& s : m.sources) text += fmt::format("{} {}\n", s.sha256, s.scale_to_mm);
  text += fmt::format("{} {} {}\n", nameOf(o.close.mode), canonicalText(o.close), kVersion);
  text += fmt::format("{} {} {} {} {}\n", o.voxelize.voxel_mm, o.voxelize.exterior_voxels, o.voxelize.interior_voxels,
                      o.voxelize.interior_mm, static_cast<int>(o.voxelize.material));
  if (o.pair) text += fmt::format("{} {}\n", o.pair->frame, o.pair->partner);
  return sha256(std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace

Expected<BakeReport> bake(const std::vector<std::filesystem::path>& meshes, const std::filesystem::path& case_folder,
                          const BakeOptions& options, const Progress& progress) {
  const auto cancelError = [] {
    return fail({Error::Code::kCancelled, "", "", "cancelled; nothing was written", "", ""});
  };
  BakeReport out;
  Stopwatch watch;
  KERF_CHECK(checkVoxelSize(options.voxelize.voxel_mm));  // before the minutes of closing, not after
  KERF_TRY(staging, AtomicFolder::create(case_folder, options.overwrite, kCaseManifest));
  const std::filesystem::path& folder = staging.staging();
  out.times.write += watch.lap();

  std::vector<Mesh> sources;
  for (const auto& path : meshes) {
    if (!report(progress, 0.0, "reading " + path.filename().string())) return cancelError();
    KERF_TRY(file, readMesh(path));
    auto unit = chooseUnit(bounds(file.mesh), options.unit, file.declared_unit);
    if (!unit) {
      unit.error().file = path.string();
      return fail(unit.error());
    }
    CaseSource source;
    source.stored_as = fmt::format("source-{}{}", out.manifest.sources.size() + 1, safeExtension(path));
    source.format = name(file.format);
    KERF_TRY(hash, sha256OfFile(path));
    source.sha256 = hash;
    source.unit = unit->unit, source.unit_reason = unit->reason, source.scale_to_mm = unit->scale_to_mm;
    source.vertices = file.mesh.vertices.size(), source.triangles = file.mesh.triangles.size();
    std::error_code failed;
    std::filesystem::copy_file(path, folder / source.stored_as, failed);
    if (failed)
      return fail({Error::Code::kWriteFailed, (folder / source.stored_as).string(), "", failed.message(), "",
                   "free some space"});
    if (unit->scale_to_mm != 1)
      for (Vec3d& p : file.mesh.vertices) p *= unit->scale_to_mm;
    out.unit_is_doubtful.push_back(unit->is_doubtful);
    out.notes.push_back(file.notes);
    out.manifest.sources.push_back(source);
    sources.push_back(std::move(file.mesh));
  }
  out.times.read = watch.lap();

  if (!report(progress, 0.05, "checking")) return cancelError();
  for (const Mesh& mesh : sources) out.source_checks.push_back(checkMesh(mesh));
  out.times.check = watch.lap();

  if (!report(progress, 0.1, "closing")) return cancelError();
  auto solid = closeMeshes(sources, options.close, part(progress, 0.1, 0.3));
  if (!solid) {
    if (solid.error().file.empty() && meshes.size() == 1) solid.error().file = meshes[0].string();
    return fail(solid.error());
  }
  out.close = solid->report;
  out.times.close = watch.lap();

  KERF_TRY(anatomy, voxelize(solid->mesh, options.voxelize, part(progress, 0.3, 0.85)));
  out.times.voxelize = watch.lap();

  CaseManifest& m = out.manifest;
  m.kerf_version = kVersion;
  m.pair = options.pair;
  m.close_mode = options.close.only.empty() ? nameOf(options.close.mode) : namesOf(options.close.only);
  m.changes = out.close.changes;
  m.exact = out.close.exact;
  m.voxel_mm = options.voxelize.voxel_mm;
  m.material = "generic";
  m.solid_vertices = solid->mesh.vertices.size(), m.solid_triangles = solid->mesh.triangles.size();
  m.solid_volume_mm3 = signedVolume(solid->mesh), m.solid_area_mm2 = surfaceArea(solid->mesh);
  m.box = bounds(solid->mesh);
  m.field_voxels = anatomy.stats().active_voxels, m.shell_points = anatomy.stats().shell_points;
  m.shell_area_mm2 = anatomy.stats().shell_area_mm2;
  m.id = caseId(m, options);
  if (!report(progress, 0.85, "writing")) return cancelError();
  KERF_CHECK(writeMesh(folder / kCaseSolid, solid->mesh));
  KERF_CHECK(anatomy.write(folder / kCaseAnatomy));
  KERF_TRY(solid_hash, sha256OfFile(folder / kCaseSolid));
  KERF_TRY(field_hash, sha256OfFile(folder / kCaseAnatomy));
  m.solid_sha256 = solid_hash, m.field_sha256 = field_hash;
  KERF_CHECK(writeCaseManifest(folder, m));
  if (!report(progress, 0.95, "syncing")) return cancelError();
  KERF_CHECK(staging.commit());
  out.times.write += watch.lap();
  report(progress, 1.0, "done");
  return out;
}

std::string describe(const BakeReport& r) {
  std::string text;
  const auto line = [&text](const std::string& s) { text += s + "\n"; };
  for (std::size_t i = 0; i < r.manifest.sources.size(); ++i) {
    const CaseSource& s = r.manifest.sources[i];
    const MeshReport& c = r.source_checks[i];
    line(fmt::format("source {}: {}, {} vertices, {} triangles", i + 1, s.format, s.vertices, s.triangles));
    line(fmt::format("  unit     {}{}: {}", r.unit_is_doubtful[i] ? "CHECK THIS: " : "", s.unit, s.unit_reason));
    line(fmt::format("  size     {:.2f} x {:.2f} x {:.2f} mm", c.box.size()[0], c.box.size()[1], c.box.size()[2]));
    line(
        fmt::format("  defects  {} boundary loops ({} edges), {} non-manifold edges, {} flipped, {} degenerate, {} "
                    "repeated, {} pieces, "
                    "{} self-intersections",
                    c.boundary_loops.size(), c.boundary_edges, c.non_manifold_edges, c.flipped_edges,
                    c.degenerate_triangles, c.duplicate_triangles, c.pieces, c.self_intersections));
    for (const std::string& note : r.notes[i]) line("  note     " + note);
  }
  if (r.manifest.changes.empty()) line("closing: nothing had to be changed");
  for (const std::string& change : r.manifest.changes) line("closing: " + change);
  if (!r.manifest.exact)
    line("WARNING: the surface is a shrink-wrap, an approximation of the scan: no source vertex is preserved");
  const CaseManifest& m = r.manifest;
  if (m.pair) line(fmt::format("pair: one frame with {}; nothing was moved", m.pair->partner));
  line(fmt::format("solid: {} vertices, {} triangles, {:.2f} mm3, {:.2f} mm2", m.solid_vertices, m.solid_triangles,
                   m.solid_volume_mm3, m.solid_area_mm2));
  line(fmt::format("field: {} mm voxels, {:.2f} M in the band; shell: {:.2f} M points standing for {:.2f} mm2",
                   m.voxel_mm, static_cast<double>(m.field_voxels) / 1e6, static_cast<double>(m.shell_points) / 1e6,
                   m.shell_area_mm2));
  if (m.shell_area_mm2 < 0.98 * m.solid_area_mm2)
    line(
        fmt::format("WARNING: the field holds {:.1f} % less surface than the solid: slots and fins thinner than a "
                    "voxel are lost in it "
                    "(export is exact all the same). A finer --voxel keeps more",
                    100 * (1 - m.shell_area_mm2 / m.solid_area_mm2)));
  line(fmt::format("time: read {:.2f}, check {:.2f}, close {:.2f}, voxelize {:.2f}, write {:.2f} s", r.times.read,
                   r.times.check, r.times.close, r.times.voxelize, r.times.write));
  return text;
}

}  // namespace kerf
