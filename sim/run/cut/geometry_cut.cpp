#include "sim/run/cut/geometry_cut.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <span>
#include <utility>

#include "geometry/base/atomic_file.h"
#include "geometry/base/hash.h"
#include "geometry/boolean/removed_solid.h"
#include "geometry/case/case_bundle.h"
#include "geometry/case/case_materials.h"
#include "geometry/field/vdb_io.h"
#include "geometry/tool/sweep.h"
#include "geometry/tool/tool_file.h"
#include "sim/hand/path.h"
#include "sim/run/cut/cut_further.h"
#include "sim/run/files/removed_volumes.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_output.h"
#include "sim/run/files/small_cut.h"
#include "sim/run/sweep/path_watch.h"
#include "sim/run/sweep/sweep_cutter.h"
#include "sim/run/sweep/thin_cut.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using internal::nothingWritten;

// How far a sweep's cut of the object reaches out of a region, mm; <= 0: it stays inside.
double reachBeyond(const FineRegion& region, const BrickField& phi0, const BrickField& sweep) {
  // The removed solid's surface lies where the sweep is 0 and phi0 below 2 fine voxels. The finer field must reach as
  // far around as its own sweep is kept.
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

// The cut field, and the tool's sweep through it. The cutter refers to the field: neither moves.
struct Swept {
  std::unique_ptr<BrickField> phi0;
  std::unique_ptr<SweepCutter> cutter;
  double beyond_region_mm = 0;  // RunManifest::beyond_region_mm
  std::size_t merged_motions = 0, swept_motions = 0;
  std::map<std::string, double> removed_by_material;
  internal::PieceCount left;
  PathFindings findings;                // of the last pass
  std::uint64_t hash_before_last = 0;   // of the cut field; with several passes
  std::uint64_t sweep_before_last = 0;  // hash of the union of all sweeps but the last; with several passes
};

// A tool along a path. A run that continues another one has several, one after the other.
struct Pass {
  Tool tool;
  CutPath path;
};

// Sweeps the tool along the path.   @param from, to  range of the progress.
Expected<void> sweepAlong(Swept& swept, const Pass& pass, double from, double to, const Progress& progress) {
  const Tool& tool = pass.tool;
  const MergedPath merged = mergedFor(*tool.cut, pass.path, swept.phi0->voxel());
  const CutPath& path = merged.path;
  swept.merged_motions = merged.merged;
  swept.swept_motions = static_cast<std::size_t>(std::count(path.cuts.begin(), path.cuts.end(), 1));
  internal::PathWatch findings(*swept.phi0);
  const std::size_t segments = path.poses.empty() ? 0 : path.poses.size() - 1;
  for (std::size_t s = 0; s < segments; ++s) {
    const double done = from + (to - from) * static_cast<double>(s) / static_cast<double>(segments);
    if (s % 16 == 0 && !report(progress, done, "cutting")) return nothingWritten();
    if (!path.cuts[s]) {
      findings.moveInAir();
      continue;
    }
    const Rigid3 &begin = path.poses[s].T_object_tool, &end = path.poses[s + 1].T_object_tool;
    findings.cut(begin, end, swept.cutter->advance(SweptTool(*tool.cut, begin, end)));
  }
  swept.findings = findings.take();
  return {};
}

// Sweeps all passes through a fresh `swept.phi0`.
Expected<void> sweepAll(Swept& swept, std::span<const Pass> passes, double from, double to, const Progress& progress) {
  swept.cutter = std::make_unique<SweepCutter>(*swept.phi0);
  const double share = (to - from) / static_cast<double>(passes.size());
  for (std::size_t n = 0; n < passes.size(); ++n) {
    if (n > 0 && n + 1 == passes.size()) {
      swept.hash_before_last = swept.cutter->cutField().stateHash();
      swept.sweep_before_last = swept.cutter->sweep().stateHash();
    }
    const double begin = from + share * static_cast<double>(n);
    KERF_CHECK(sweepAlong(swept, passes[n], begin, begin + share, progress));
  }
  return {};
}

// Values of the sweep through the object's own grid.
Expected<std::map<std::string, double>> removedByMaterial(const fs::path& case_folder, const CaseManifest& in_case,
                                                          const Swept& swept) {
  KERF_TRY(labels, readCaseMaterials(case_folder));
  KERF_TRY(table, readDefaultMaterials());
  const Material fallback = fallbackOf(in_case);
  return internal::byMaterial(
      internal::removedVolumes(*swept.phi0, swept.cutter->cutField(), internal::materialsOf(labels, fallback)), table);
}

// Sweeps the object's own grid, then the fine region's if the case has one and the cut stays in it.
Expected<Swept> sweepCase(const fs::path& case_folder, const CaseManifest& in_case, std::span<const Pass> passes,
                          const Progress& progress) {
  KERF_TRY(phi0, readCaseField(case_folder));
  Swept out;
  out.phi0 = std::make_unique<BrickField>(std::move(phi0));
  KERF_CHECK(sweepAll(out, passes, 0.1, in_case.region ? 0.25 : 0.9, progress));
  KERF_TRY(removed, removedByMaterial(case_folder, in_case, out));
  out.removed_by_material = removed;
  out.left = internal::countPieces(*out.phi0, out.cutter->cutField());
  if (!in_case.region) return out;

  const FineRegion& region = in_case.region->where;
  const double beyond = reachBeyond(region, *out.phi0, out.cutter->sweep());
  if (beyond > 0) {
    if (beyond < region.radius_mm) out.beyond_region_mm = beyond;
    return out;
  }
  KERF_TRY(fine, readCaseRegionField(case_folder, *out.phi0));
  const auto comes_out_at = out.findings.comes_out_at;  // a region ends in the middle of the object
  out.cutter.reset();
  out.phi0 = std::make_unique<BrickField>(std::move(fine));
  KERF_CHECK(sweepAll(out, passes, 0.25, 0.9, progress));
  out.findings.comes_out_at = comes_out_at;
  return out;
}

// ---- Cuts between nodes

// The cutting motions of a path, by stroke.
std::vector<std::vector<SweptTool>> strokesOf(const Pass& pass, double voxel) {
  const CutPath path = mergedFor(*pass.tool.cut, pass.path, voxel).path;
  std::vector<std::vector<SweptTool>> out;
  bool is_cutting = false;
  for (std::size_t s = 0; s + 1 < path.poses.size(); ++s) {
    if (path.cuts[s] && !std::exchange(is_cutting, true)) out.emplace_back();
    is_cutting = path.cuts[s];
    if (is_cutting)
      out.back().emplace_back(*pass.tool.cut, path.poses[s].T_object_tool, path.poses[s + 1].T_object_tool);
  }
  return out;
}

// Among the strokes of the last pass that no node counts, finds those that remove nothing between the nodes either.
// @param idle  their numbers, from 1.   @cost  for a stroke that does remove something: that of all passes.
std::vector<std::size_t> idleBetweenNodes(const BrickField& phi0, std::span<const Pass> passes,
                                          const std::vector<std::size_t>& idle) {
  const auto sweepOf = [&](const std::vector<SweptTool>& stroke) {
    auto out = std::make_unique<SweepCutter>(phi0);
    for (const SweptTool& motion : stroke) out->advance(motion);
    return out;
  };
  const auto strokes = strokesOf(passes.back(), phi0.voxel());
  const BrickField nothing(phi0.voxel(), static_cast<float>(4 * phi0.voxel()));
  std::map<std::size_t, std::unique_ptr<SweepCutter>> thin;
  for (const std::size_t n : idle)
    if (auto sweep = sweepOf(strokes[n - 1]); strokeVolume(phi0, nothing, sweep->sweep()) >= kUnchanged)
      thin[n] = std::move(sweep);
  if (thin.empty()) return idle;

  // Excludes the volume of earlier strokes.
  SweepCutter before(phi0);
  for (const Pass& pass : passes.first(passes.size() - 1))
    for (const auto& stroke : strokesOf(pass, phi0.voxel()))
      for (const SweptTool& motion : stroke) before.advance(motion);
  std::vector<std::size_t> out;
  for (std::size_t n = 1; n <= strokes.size(); ++n) {
    const auto found = thin.find(n);
    const bool is_thin =
        found != thin.end() && strokeVolume(phi0, before.sweep(), found->second->sweep()) >= kUnchanged;
    if (!is_thin && std::find(idle.begin(), idle.end(), n) != idle.end()) out.push_back(n);
    for (const SweptTool& motion : strokes[n - 1]) before.advance(motion);
  }
  return out;
}

// If no node counts the cut, the field between the nodes decides, as in the export.
// @param on_own_grid  the volumes were counted on the swept nodes.
void judgeBetweenNodes(const Swept& swept, std::span<const Pass> passes, bool on_own_grid, RunManifest& m) {
  double counted_mm3 = 0;
  for (const auto& [id, volume] : m.removed_by_material) counted_mm3 += volume;
  const bool is_idle = m.findings.idle.size() == m.findings.strokes;
  if (counted_mm3 < kUnchanged && (is_idle || on_own_grid)) {
    m.thin_mm3 = thinCutVolume(*swept.phi0, swept.cutter->sweep());
    if (m.thin_mm3 < kUnchanged) m.thin_mm3 = 0;
    if (m.thin_mm3 == 0) return;
  }
  if (!m.findings.idle.empty()) m.findings.idle = idleBetweenNodes(*swept.phi0, passes, m.findings.idle);
}

// Values that no other file of the run has: volumes and pieces.
Expected<void> writeSummary(const fs::path& file, const CaseManifest& in_case, const Swept& swept) {
  std::map<std::string, double> loaded;
  for (const CaseMaterial& material : in_case.materials) loaded[material.id] = material.volume_mm3;
  return internal::writeGeometrySummary(file, loaded, swept.removed_by_material, swept.left);
}

// ---- Earlier cuts of a run

constexpr const char* kEarlierFolder = "earlier";

// The cuts of a run, from the first path on.
std::vector<RunManifest::EarlierCut> cutsOf(const RunManifest& run) {
  std::vector<RunManifest::EarlierCut> out = run.earlier;
  out.push_back({run.tool_id, internal::kRunToolCopy, run.tool_sha256, run.path_file, run.path_sha256});
  return out;
}

Expected<Pass> readPass(const fs::path& run_folder, const RunManifest::EarlierCut& cut) {
  const char* const advice = "runs must not be edited: restore it from a copy";
  KERF_CHECK(requireSha256(run_folder / cut.tool_file, cut.tool_sha256, advice));
  KERF_CHECK(requireSha256(run_folder / cut.path_file, cut.path_sha256, advice));
  KERF_TRY(tool, readTool(run_folder / cut.tool_file));
  KERF_TRY(path, readPath(run_folder / cut.path_file));
  return Pass{std::move(tool), std::move(path)};
}

// Copies tool and path of an earlier cut into a folder of their own.   @param n  of the cut.
Expected<RunManifest::EarlierCut> storeEarlier(const fs::path& from, const RunManifest::EarlierCut& cut,
                                               const Tool& tool, std::size_t n, const fs::path& staging) {
  const fs::path folder = fs::path(kEarlierFolder) / fmt::format("{:02}", n + 1);
  RunManifest::EarlierCut out = cut;
  out.tool_file = (folder / internal::kRunToolCopy).string();
  out.path_file = (folder / fs::path(cut.path_file).filename()).string();
  std::error_code ignored;
  fs::create_directories(staging / folder, ignored);  // the copy reports the error
  KERF_CHECK(copyFile(from / cut.tool_file, staging / out.tool_file));
  KERF_CHECK(copyFile(from / cut.path_file, staging / out.path_file));
  if (!tool.companion.empty()) KERF_CHECK(copyFile(tool.companion, staging / folder / tool.companion.filename()));
  return out;
}

// The subject of the cut: a case, or a run with all its earlier cuts.
struct Begin {
  fs::path case_folder;
  fs::path run{};  // empty: none
  std::vector<RunManifest::EarlierCut> cuts{};
  std::vector<Pass> passes{};
  double voxel_mm = 0;       // of that run
  std::string state_hash{};  // of that run
};
Expected<Begin> beginWithRun(const fs::path& run, const RunManifest& manifest) {
  Begin out;
  KERF_CHECK(requireSha256(run / internal::kRunField, manifest.field_sha256,
                           "runs must not be edited: restore it from a copy"));
  out.voxel_mm = manifest.voxel_mm;
  out.state_hash = manifest.state_hash;
  KERF_TRY(case_folder, caseOfRun(run));
  out.case_folder = case_folder;
  out.run = run;
  out.cuts = cutsOf(manifest);
  for (const RunManifest::EarlierCut& cut : out.cuts) {
    KERF_TRY(pass, readPass(run, cut));
    out.passes.push_back(std::move(pass));
  }
  return out;
}

// The sweep of the earlier tools and paths must reproduce the run's state. On other voxels this cannot be checked.
Expected<void> requireSameBefore(const Begin& begin, const Swept& swept) {
  if (begin.cuts.empty() || begin.voxel_mm != swept.phi0->voxel()) return {};
  const std::string again = fmt::format("{:016x}", swept.sweep_before_last);
  if (again == begin.state_hash) return {};
  return fail({.code = Error::Code::kBadValue,
               .file = (begin.run / kRunManifest).string(),
               .place = "key state_hash",
               .found = begin.state_hash,
               .expected = again + ", as its tools and paths give when they are swept again",
               .hint = "it was edited, or is from another version of Kerf: cut its paths again from the case"});
}

Expected<RunManifest> cutFrom(Begin begin, const fs::path& tool_file, const fs::path& path_file,
                              const fs::path& run_folder, const CutOptions& options, const Progress& progress) {
  const fs::path& case_folder = begin.case_folder;
  KERF_TRY(in_case, readCaseManifest(case_folder));
  KERF_TRY(table, readDefaultMaterials());
  KERF_CHECK(requireSameMaterials(case_folder, in_case, table));
  KERF_TRY(case_path, internal::relativeCasePath(case_folder, run_folder));
  KERF_TRY(tool, readTool(tool_file));
  KERF_TRY(path, readPath(path_file));
  KERF_TRY(staging, AtomicFolder::create(run_folder, options.overwrite, kRunManifest));
  if (!report(progress, 0.0, "loading the case")) return nothingWritten();

  begin.passes.push_back({tool, path});
  KERF_TRY(swept, sweepCase(case_folder, in_case, begin.passes, progress));
  KERF_CHECK(requireSameBefore(begin, swept));
  const BrickField& sweep = swept.cutter->sweep();
  const BrickField cut = swept.cutter->cutField();
  const bool is_cut = begin.cuts.empty() ? !cut.isEmpty() : cut.stateHash() != swept.hash_before_last;
  if (!is_cut)
    return fail({.code = Error::Code::kEmpty,
                 .file = path_file.string(),
                 .found = begin.cuts.empty() ? fmt::format("tool {} does not touch the object", tool.id)
                                             : fmt::format("tool {} does not touch the remaining object", tool.id),
                 .expected = internal::throughBox(in_case.box),
                 .hint = "check the path's frame and unit"});

  RunManifest m;
  internal::addMotions(path, m);
  m.case_path = case_path;
  m.case_id = in_case.id;
  m.duration_s = path.poses.empty() ? 0 : path.poses.back().t - path.poses.front().t;
  m.voxel_mm = swept.phi0->voxel();
  m.state_hash = fmt::format("{:016x}", sweep.stateHash());
  m.beyond_region_mm = swept.beyond_region_mm;
  if (!begin.cuts.empty() && begin.voxel_mm < m.voxel_mm) m.finer_before_mm = begin.voxel_mm;
  m.removed_by_material = swept.removed_by_material;
  m.findings = swept.findings;
  judgeBetweenNodes(swept, begin.passes, m.voxel_mm == in_case.voxel_mm, m);
  m.merged_motions = swept.merged_motions;
  m.swept_motions = swept.swept_motions;
  m.merge_tolerance_mm = kMergeTolerance * m.voxel_mm;
  for (std::size_t n = 0; n < begin.cuts.size(); ++n) {
    KERF_TRY(stored, storeEarlier(begin.run, begin.cuts[n], begin.passes[n].tool, n, staging.staging()));
    m.earlier.push_back(std::move(stored));
  }

  if (!report(progress, 0.92, "writing")) return nothingWritten();
  KERF_CHECK(
      writeVdb(staging.staging() / internal::kRunField, {{"sweep", &sweep}, {"phi", &cut}}, {{"case_id", m.case_id}}));
  KERF_CHECK(writeSummary(staging.staging() / internal::kRunSummary, in_case, swept));
  KERF_CHECK(internal::finishRun(staging.staging(), tool, tool_file, path_file, m));
  KERF_CHECK(staging.commit());
  report(progress, 1.0, "done");
  return m;
}

}  // namespace

Expected<RunManifest> cutCase(const fs::path& case_or_run, const fs::path& tool_file, const fs::path& path_file,
                              const fs::path& run_folder, const CutOptions& options, const Progress& progress) {
  if (!isRun(case_or_run))
    return cutFrom({.case_folder = case_or_run}, tool_file, path_file, run_folder, options, progress);

  KERF_CHECK(internal::requireAnother(case_or_run, run_folder));
  KERF_TRY(before, readRunManifest(case_or_run));
  KERF_CHECK(requireEnded(case_or_run, before));
  if (before.mode != kModeGeometry || !before.begin_sha256.empty())
    return internal::cutFurther(case_or_run, tool_file, path_file, run_folder, options, progress);
  KERF_TRY(begin, beginWithRun(case_or_run, before));
  return cutFrom(std::move(begin), tool_file, path_file, run_folder, options, progress);
}

}  // namespace kerf
