#include "sim/run/run_bundle.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <optional>

#include "geometry/base/atomic_file.h"
#include "geometry/base/hash.h"
#include "geometry/base/toml_reader.h"
#include "geometry/boolean/removed_solid.h"
#include "geometry/field/vdb_io.h"
#include "geometry/tool/sweep.h"
#include "geometry/tool/tool_file.h"
#include "sim/hand/path.h"
#include "sim/monitor/monitor.h"
#include "sim/run/run_files.h"
#include "sim/run/sweep_cutter.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using internal::kRunField;
using internal::kRunToolCopy;

// Which case of a run: the one that was cut, or a neighbour of it.
struct CaseRef {
  const std::string& path;
  const std::string& id;
  std::string keys, role;  // in front of the manifest's keys; for people
};
CaseRef caseRef(const RunManifest& m) { return {m.case_path, m.case_id, "", "the case this run was cut from"}; }
CaseRef caseRef(const RunManifest& m, std::size_t beside) {
  const RunManifest::Beside& b = m.beside[beside - 1];
  return {b.case_path, b.case_id, neighbourId(beside) + ", ", "the case that stood beside it"};
}

Expected<fs::path> locateCase(const fs::path& run_folder, const CaseRef& m) {
  // As named first, then with symbolic links resolved: a run may be reached through one.
  std::error_code ignored;
  fs::path wanted = (fs::absolute(run_folder, ignored) / m.path).lexically_normal();
  if (!isCase(wanted)) wanted = (fs::weakly_canonical(run_folder, ignored) / m.path).lexically_normal();
  if (!isCase(wanted))
    return fail({Error::Code::kNotFound, run_folder.string(), m.keys + "key case_path", "no case at " + m.path, m.role,
                 "move the case back beside the run, or cut again"});
  KERF_TRY(manifest, readCaseManifest(wanted));
  if (manifest.id != m.id)
    return fail({Error::Code::kBadValue, run_folder.string(), m.keys + "key case_id",
                 "the case there was baked anew since this run was cut", "case " + m.id.substr(0, 12), "cut again"});
  return wanted;
}

// Distance of wall vertices to the exact sweep. Wall: touching cut triangles only. At most kSamples, evenly chosen.
Expected<WallAccuracy> measureWalls(const fs::path& run_folder, const RunManifest& m, const PostOpMesh& result) {
  constexpr std::size_t kSamples = 4000;
  KERF_TRY(tool, readTool(run_folder / kRunToolCopy));
  KERF_TRY(path, readPath(run_folder / m.path_file));
  std::vector<char> wall(result.mesh.vertices.size(), 1);
  for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
    if (!result.is_cut[t])
      for (const std::uint32_t v : result.mesh.triangles[t]) wall[v] = 0;
  std::vector<Vec3d> points;
  for (std::size_t v = 0; v < wall.size(); ++v)
    if (wall[v]) points.push_back(result.mesh.vertices[v]);
  const std::size_t stride = points.size() / kSamples + 1;
  WallAccuracy out;
  std::vector<double> nearest;
  std::vector<Vec3d> sampled;
  for (std::size_t i = 0; i < points.size(); i += stride) sampled.push_back(points[i]);
  const double far = 4 * m.voxel_mm;
  nearest.assign(sampled.size(), far);
  for (std::size_t s = 0; s + 1 < path.poses.size(); ++s) {
    if (!path.cuts[s]) continue;
    const SweptTool sweep(*tool.cut, path.poses[s].T_object_tool, path.poses[s + 1].T_object_tool);
    Box3 box = sweep.bounds();
    box.grow(far);
    for (std::size_t i = 0; i < sampled.size(); ++i)
      if (box.contains(sampled[i]))
        nearest[i] = std::min(nearest[i], sweep.distance(sampled[i], nearest[i], 1e-6, -far));
  }
  double squares = 0;
  for (const double d : nearest) {
    squares += d * d;
    out.max_mm = std::max(out.max_mm, std::abs(d));
  }
  out.vertices = nearest.size();
  out.rms_mm = nearest.empty() ? 0 : std::sqrt(squares / static_cast<double>(nearest.size()));
  return out;
}

// How far what a sweep cuts of the object reaches out of a region, mm; <= 0: it stays inside.
double reachBeyond(const FineRegion& region, const BrickField& phi0, const BrickField& sweep) {
  // The removed solid's surface lies where the sweep is 0 and phi0 below 2 fine voxels; the finer field must be there
  // as far around as its own sweep is kept.
  const auto near = static_cast<float>(std::max(phi0.voxel(), 4 * region.voxel_mm));
  double farthest = -region.radius_mm;
  for (std::size_t b = 0; b < sweep.brickCount(); ++b) {
    const int found = phi0.find(sweep.brickCoord(b));
    const float constant = phi0.constantAt(sweep.brickCoord(b));
    const Vec3i base = sweep.brickCoord(b) * kBrickSide;
    for (int n = 0; n < kBrickNodes; ++n) {
      const auto at = static_cast<std::size_t>(n);
      if (sweep.brick(b)[at] > near) continue;
      if ((found < 0 ? constant : phi0.brick(static_cast<std::size_t>(found))[at]) > near) continue;
      farthest = std::max(farthest, -region.depth(sweep.position(base + Vec3i{n >> 6, n >> 3 & 7, n & 7})));
    }
  }
  return farthest;
}

// Somewhere phi < phi0: material was added.
bool liesDeeper(const BrickField& phi, const BrickField& phi0) {
  for (std::size_t b = 0; b < phi.brickCount(); ++b) {
    const BrickValues* const before = phi0.valuesAt(phi.brickCoord(b));
    const float constant = phi0.constantAt(phi.brickCoord(b));
    for (std::size_t n = 0; n < kBrickNodes; ++n)
      if (phi.brick(b)[n] < (before ? (*before)[n] : constant)) return true;
  }
  return false;
}

Expected<void> requireBeside(const fs::path& run_folder, const RunManifest& m, std::size_t beside) {
  if (beside <= m.beside.size()) return {};
  return fail({Error::Code::kNotFound, run_folder.string(), neighbourId(beside), "there is none",
               m.beside.empty() ? "a run cut with other cases beside it" : fmt::format("1 to {}", m.beside.size()),
               m.beside.empty() ? "kerf cut CASE --hand ... --beside OTHER.case" : "kerf info tells them"});
}

}  // namespace

bool isRun(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_regular_file(folder / kRunManifest, ignored);
}

Expected<RunManifest> readRunManifest(const fs::path& folder) {
  const fs::path path = folder / kRunManifest;
  if (!isRun(folder))
    return fail({Error::Code::kNotFound, folder.string(), "", "not a run bundle", "a folder with run.toml",
                 "kerf cut CASE ... -o " + folder.string()});
  KERF_TRY(root, parseToml(path));
  TomlTable top(root, path, "");
  RunManifest m;
  const auto format = top.get<std::string>("format", "\"kerf-run\"");
  const auto version = top.get<std::int64_t>("version", "1");
  if (format != "kerf-run" || version != internal::kRunFormatVersion)
    return fail({Error::Code::kUnsupported, path.string(), "key format / version",
                 fmt::format("{} version {}", format, version),
                 fmt::format("kerf-run version {}", internal::kRunFormatVersion), "cut again with this Kerf"});
  m.kerf_version = top.get<std::string>("kerf_version", "a string");
  m.case_path = top.get<std::string>("case_path", "a path");
  m.case_id = top.get<std::string>("case_id", "64 hexadecimal digits");
  m.mode = top.get<std::string>("mode", "\"geometry\" or \"haptic\"");
  if (m.mode != kModeGeometry && m.mode != kModeHaptic)
    top.reject("mode", "\"" + m.mode + "\"", "\"geometry\" or \"haptic\"");
  m.tool_id = top.get<std::string>("tool_id", "a tool");
  m.tool_sha256 = top.get<std::string>("tool_sha256", "64 hexadecimal digits");
  m.path_file = top.get<std::string>("path_file", "\"path.csv\" or \"path.toml\"");
  if (m.path_file != "path.csv" && m.path_file != "path.toml")
    top.reject("path_file", "\"" + m.path_file + "\"", "\"path.csv\" or \"path.toml\"");
  m.path_sha256 = top.get<std::string>("path_sha256", "64 hexadecimal digits");
  m.segments = static_cast<std::size_t>(top.get<std::int64_t>("segments", "a count"));
  m.path_length_mm = top.get<double>("path_length_mm", "mm");
  m.duration_s = top.get<double>("duration_s", "s");
  m.voxel_mm = top.number("voxel_mm", 0.001, 100);
  m.state_hash = top.get<std::string>("state_hash", "16 hexadecimal digits");
  m.field_sha256 = top.get<std::string>("field_sha256", "64 hexadecimal digits");
  if (const toml::array* beside = top.has("beside") ? top.tables("beside") : nullptr)
    for (const toml::node& node : *beside) {
      if (!node.is_table()) continue;
      TomlTable t(*node.as_table(), path, neighbourId(m.beside.size() + 1));
      RunManifest::Beside b;
      b.case_path = t.get<std::string>("case_path", "a path");
      b.case_id = t.get<std::string>("case_id", "64 hexadecimal digits");
      b.voxel_mm = t.number("voxel_mm", 0.001, 100);
      b.removed_mm3 = t.number("removed_mm3", 0, 1e12, "mm3");
      KERF_CHECK(t.finish());
      m.beside.push_back(std::move(b));
    }
  if (!m.beside.empty() && m.mode != kModeHaptic) top.reject("beside", "in mode " + m.mode, "mode haptic");
  if (m.beside.size() >= kMostObjects)
    top.reject("beside", fmt::format("{} cases", m.beside.size()), fmt::format("at most {}", kMostObjects - 1));
  KERF_CHECK(top.finish());
  return m;
}

Expected<fs::path> caseOfRun(const fs::path& run_folder) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  return locateCase(run_folder, caseRef(manifest));
}

Expected<std::vector<fs::path>> casesBesideRun(const fs::path& run_folder) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  std::vector<fs::path> out;
  for (std::size_t n = 1; n <= manifest.beside.size(); ++n) {
    KERF_TRY(folder, locateCase(run_folder, caseRef(manifest, n)));
    out.push_back(std::move(folder));
  }
  return out;
}

Expected<BrickField> readRunSweep(const fs::path& run_folder) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  KERF_CHECK(requireSha256(run_folder / kRunField, manifest.field_sha256, "cut again"));
  if (manifest.mode != kModeGeometry)
    return fail({Error::Code::kUnsupported, run_folder.string(), "mode " + manifest.mode, "no sweep",
                 "a run cut geometry-only", ""});
  return readVdb(run_folder / kRunField, "sweep");
}

Expected<BrickField> readRunCutField(const fs::path& run_folder, std::size_t beside) {
  KERF_TRY(manifest, readRunManifest(run_folder));
  KERF_CHECK(requireBeside(run_folder, manifest, beside));
  KERF_CHECK(requireSha256(run_folder / kRunField, manifest.field_sha256, "cut again"));
  return readVdb(run_folder / kRunField, beside == 0 ? "phi" : neighbourId(beside));
}

Expected<RunManifest> cutCase(const fs::path& case_folder, const fs::path& tool_file, const fs::path& path_file,
                              const fs::path& run_folder, const CutOptions& options, const Progress& progress) {
  const auto cancelError = [] {
    return fail({Error::Code::kCancelled, "", "", "cancelled; nothing was written", "", ""});
  };
  KERF_TRY(manifest, readCaseManifest(case_folder));
  KERF_TRY(case_path, internal::relativeCasePath(case_folder, run_folder));
  KERF_TRY(tool, readTool(tool_file));
  KERF_TRY(path, readPath(path_file));
  KERF_TRY(staging, AtomicFolder::create(run_folder, options.overwrite, kRunManifest));
  if (!report(progress, 0.0, "loading the case")) return cancelError();
  KERF_TRY(phi0, readCaseField(case_folder));

  RunManifest m;
  const std::size_t segments = path.poses.empty() ? 0 : path.poses.size() - 1;
  for (std::size_t s = 0; s < segments; ++s) {
    if (!path.cuts[s]) continue;
    m.path_length_mm += (path.poses[s + 1].T_object_tool.translation - path.poses[s].T_object_tool.translation).norm();
    ++m.segments;
  }
  std::optional<SweepCutter> cutter;
  const auto cutOn = [&](const BrickField& field, double from, double to) {
    cutter.emplace(field);
    for (std::size_t s = 0; s < segments; ++s) {
      const double done = from + (to - from) * static_cast<double>(s) / static_cast<double>(segments);
      if (s % 16 == 0 && !report(progress, done, "cutting")) return false;
      if (path.cuts[s])
        cutter->advance(SweptTool(*tool.cut, path.poses[s].T_object_tool, path.poses[s + 1].T_object_tool));
    }
    return true;
  };
  if (!cutOn(phi0, 0.1, manifest.region ? 0.25 : 0.9)) return cancelError();
  if (manifest.region) {
    const double beyond = reachBeyond(manifest.region->where, phi0, cutter->sweep());
    if (beyond <= 0) {
      KERF_TRY(fine, readCaseRegionField(case_folder));
      phi0 = std::move(fine);
      if (!cutOn(phi0, 0.25, 0.9)) return cancelError();
    } else if (beyond < manifest.region->where.radius_mm) {
      m.beyond_region_mm = beyond;
    }
  }
  const BrickField cut = cutter->cutField();
  if (cut.isEmpty()) {
    const Vec3d &low = manifest.box.min, &high = manifest.box.max;
    return fail({Error::Code::kEmpty, path_file.string(), "", fmt::format("tool {} never meets the object", tool.id),
                 fmt::format("a path through the box ({:.2f}, {:.2f}, {:.2f}) to ({:.2f}, {:.2f}, {:.2f}) mm", low[0],
                             low[1], low[2], high[0], high[1], high[2]),
                 "check the path's frame and unit"});
  }
  m.case_path = case_path;
  m.case_id = manifest.id;
  m.duration_s = path.poses.empty() ? 0 : path.poses.back().t - path.poses.front().t;
  m.voxel_mm = phi0.voxel();
  m.state_hash = fmt::format("{:016x}", cutter->sweep().stateHash());
  if (!report(progress, 0.92, "writing")) return cancelError();
  KERF_CHECK(
      writeVdb(staging.staging() / kRunField, {{"sweep", &cutter->sweep()}, {"phi", &cut}}, {{"case_id", m.case_id}}));
  KERF_CHECK(internal::finishRun(staging.staging(), tool, tool_file, path_file, m));
  KERF_CHECK(staging.commit());
  report(progress, 1.0, "done");
  return m;
}

Expected<Export> exportBundle(const fs::path& bundle, const PostOpOptions& options, const Progress& progress,
                              std::size_t beside) {
  const auto cancelError = [] {
    return fail({Error::Code::kCancelled, "", "", "cancelled; nothing was written", "", ""});
  };
  Export out;
  if (isCase(bundle)) {
    if (beside > 0) return fail(requireBeside(bundle, {}, beside).error());
    KERF_TRY(manifest, readCaseManifest(bundle));
    KERF_TRY(solid, readCaseSolid(bundle));
    auto result = postOperativeMesh(solid, BrickField(manifest.voxel_mm, static_cast<float>(4 * manifest.voxel_mm)),
                                    options, progress);
    if (!result) return fail(result.error());
    out.post_op = std::move(*result);
    return out;
  }
  if (!isRun(bundle))
    return fail({Error::Code::kNotFound, bundle.string(), "", "neither a run nor a case",
                 "a folder with run.toml or case.toml", "kerf bake, then kerf cut"});
  KERF_TRY(manifest, readRunManifest(bundle));
  KERF_CHECK(requireBeside(bundle, manifest, beside));
  KERF_TRY(case_folder, locateCase(bundle, beside == 0 ? caseRef(manifest) : caseRef(manifest, beside)));
  if (!report(progress, 0.0, "loading")) return cancelError();
  KERF_TRY(in_case, readCaseManifest(case_folder));
  KERF_TRY(solid, readCaseSolid(case_folder));
  KERF_TRY(phi0, readCaseField(case_folder));
  const bool is_geometry = manifest.mode == kModeGeometry;
  KERF_TRY(cut, is_geometry ? readRunSweep(bundle) : readRunCutField(bundle, beside));
  KERF_CHECK(requireSha256(bundle / kRunToolCopy, manifest.tool_sha256, "cut again; a run is never edited"));
  KERF_CHECK(requireSha256(bundle / manifest.path_file, manifest.path_sha256, "cut again; a run is never edited"));
  if (const auto& region = in_case.region; region && cut.voxel() == region->where.voxel_mm) {
    KERF_TRY(fine, readCaseRegionField(case_folder));
    phi0 = std::move(fine);
  }
  if (cut.voxel() != phi0.voxel())
    return fail({Error::Code::kBadValue, (bundle / kRunField).string(), is_geometry ? "grid sweep" : "grid phi",
                 fmt::format("{} mm voxels", cut.voxel()), fmt::format("{} mm, as in the case", phi0.voxel()),
                 "cut again"});
  const bool has_added = !is_geometry && liesDeeper(cut, phi0);
  BrickField removed = is_geometry ? removedFieldFromSweep(phi0, cut) : removedFieldFromCut(phi0, cut), added;
  if (has_added) {
    added = addedFieldFromFill(phi0, cut);
    clearAwayFromInside(removed);
    clearAwayFromInside(added);
  }
  auto result = postOperativeMesh(solid, removed, options, progress, has_added ? &added : nullptr);
  if (!result) {
    result.error().file = bundle.string();
    return fail(result.error());
  }
  out.post_op = std::move(*result);
  // The mesh is made and verified: a measurement that fails does not take it away.
  if (!is_geometry)
    out.accuracy_missing = "cut against resistance: the tool went where force let it, there is no exact sweep";
  else if (const auto accuracy = measureWalls(bundle, manifest, out.post_op))
    out.accuracy = *accuracy;
  else
    out.accuracy_missing = accuracy.error().message();
  return out;
}

}  // namespace kerf
