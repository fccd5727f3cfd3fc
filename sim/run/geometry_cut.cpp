#include "sim/run/geometry_cut.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "geometry/base/atomic_file.h"
#include "geometry/case/case_bundle.h"
#include "geometry/case/case_materials.h"
#include "geometry/field/vdb_io.h"
#include "geometry/tool/sweep.h"
#include "geometry/tool/tool_file.h"
#include "sim/hand/path.h"
#include "sim/run/removed_volumes.h"
#include "sim/run/run_output.h"
#include "sim/run/sweep_cutter.h"
#include "sim/run/tip_exit.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using internal::nothingWritten;

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

// The field that was cut, and what the tool swept of it. The cutter refers to the field: neither moves.
struct Swept {
  std::unique_ptr<BrickField> phi0;
  std::unique_ptr<SweepCutter> cutter;
  double beyond_region_mm = 0;  // RunManifest::beyond_region_mm
  std::size_t merged_motions = 0, swept_motions = 0;
  std::map<std::string, double> removed_by_material;
  internal::PieceCount left;
  PathFindings findings;
};

// Told of every motion of a path through a whole object.
class Findings {
 public:
  explicit Findings(const BrickField& loaded) : exit_(loaded) {}

  void moveInAir() {
    endStroke();
    exit_.lift();
  }
  void cut(const Rigid3& from, const Rigid3& to, bool removes) {
    if (!is_cutting_) {
      ++found_.strokes;
      is_cutting_ = true;
      has_removed_ = false;
      exit_.moveTo(from);
    }
    has_removed_ |= removes;
    exit_.moveTo(to);
  }
  PathFindings take() {
    endStroke();
    found_.comes_out_at = exit_.place();
    return std::move(found_);
  }

 private:
  void endStroke() {
    if (is_cutting_ && !has_removed_) found_.idle.push_back(found_.strokes);
    is_cutting_ = false;
  }

  internal::TipExit exit_;
  PathFindings found_;
  bool is_cutting_ = false, has_removed_ = false;
};

// Sweeps the tool along the path through `swept.phi0`.   @param from, to  of the progress.
Expected<void> sweepAlong(Swept& swept, const Tool& tool, const CutPath& whole, double from, double to,
                          const Progress& progress) {
  const MergedPath merged = mergedFor(*tool.cut, whole, swept.phi0->voxel());
  const CutPath& path = merged.path;
  swept.merged_motions = merged.merged;
  swept.swept_motions = static_cast<std::size_t>(std::count(path.cuts.begin(), path.cuts.end(), 1));
  swept.cutter = std::make_unique<SweepCutter>(*swept.phi0);
  Findings findings(*swept.phi0);
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

// Of the sweep through the object's own grid.
Expected<std::map<std::string, double>> removedByMaterial(const fs::path& case_folder, const CaseManifest& in_case,
                                                          const Swept& swept) {
  KERF_TRY(labels, readCaseMaterials(case_folder));
  KERF_TRY(table, readDefaultMaterials());
  const Material fallback =
      in_case.materials.empty() ? Material::kGeneric : static_cast<Material>(in_case.materials.front().number);
  return internal::byMaterial(
      internal::removedVolumes(*swept.phi0, swept.cutter->cutField(), internal::materialsOf(labels, fallback)), table);
}

// On the object's own grid; once more on the fine region's if the case has one and the cut stays in it.
Expected<Swept> sweepCase(const fs::path& case_folder, const CaseManifest& in_case, const Tool& tool,
                          const CutPath& path, const Progress& progress) {
  KERF_TRY(phi0, readCaseField(case_folder));
  Swept out;
  out.phi0 = std::make_unique<BrickField>(std::move(phi0));
  KERF_CHECK(sweepAlong(out, tool, path, 0.1, in_case.region ? 0.25 : 0.9, progress));
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
  KERF_CHECK(sweepAlong(out, tool, path, 0.25, 0.9, progress));
  out.findings.comes_out_at = comes_out_at;
  return out;
}

// What no other file of the run says: volumes, and what the object is in now.
Expected<void> writeSummary(const fs::path& file, const CaseManifest& in_case, const Swept& swept) {
  double initial = 0, removed = 0;
  nlohmann::json loaded = nlohmann::json::object();
  for (const CaseMaterial& material : in_case.materials) {
    loaded[material.id] = material.volume_mm3;
    initial += material.volume_mm3;
  }
  for (const auto& [id, volume] : swept.removed_by_material) removed += volume;
  KERF_TRY(out, AtomicFile::create(file));
  out.stream() << nlohmann::json{{"initial_mm3", initial},      {"initial_by_material_mm3", loaded},
                                 {"removed_mm3", removed},      {"removed_by_material_mm3", swept.removed_by_material},
                                 {"pieces", swept.left.pieces}, {"crumbs", swept.left.crumbs}}
                      .dump(2)
               << "\n";
  return out.commit();
}

}  // namespace

Expected<RunManifest> cutCase(const fs::path& case_folder, const fs::path& tool_file, const fs::path& path_file,
                              const fs::path& run_folder, const CutOptions& options, const Progress& progress) {
  if (isRun(case_folder))
    return fail({.code = Error::Code::kUnsupported,
                 .file = case_folder.string(),
                 .found = "a run, not a case: a cut of geometry alone does not go on from one",
                 .expected = "the case that it was cut from",
                 .hint = "--hand force goes on from a run; or cut the case, with both paths in one file"});
  KERF_TRY(in_case, readCaseManifest(case_folder));
  KERF_TRY(table, readDefaultMaterials());
  KERF_CHECK(requireSameMaterials(case_folder, in_case, table));
  KERF_TRY(case_path, internal::relativeCasePath(case_folder, run_folder));
  KERF_TRY(tool, readTool(tool_file));
  KERF_TRY(path, readPath(path_file));
  KERF_TRY(staging, AtomicFolder::create(run_folder, options.overwrite, kRunManifest));
  if (!report(progress, 0.0, "loading the case")) return nothingWritten();

  KERF_TRY(swept, sweepCase(case_folder, in_case, tool, path, progress));
  const BrickField& sweep = swept.cutter->sweep();
  const BrickField cut = swept.cutter->cutField();
  if (cut.isEmpty())
    return fail({.code = Error::Code::kEmpty,
                 .file = path_file.string(),
                 .found = fmt::format("tool {} never meets the object", tool.id),
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
  m.removed_by_material = swept.removed_by_material;
  m.findings = swept.findings;
  m.merged_motions = swept.merged_motions;
  m.swept_motions = swept.swept_motions;
  m.merge_tolerance_mm = kMergeTolerance * m.voxel_mm;

  if (!report(progress, 0.92, "writing")) return nothingWritten();
  KERF_CHECK(
      writeVdb(staging.staging() / internal::kRunField, {{"sweep", &sweep}, {"phi", &cut}}, {{"case_id", m.case_id}}));
  KERF_CHECK(writeSummary(staging.staging() / internal::kRunSummary, in_case, swept));
  KERF_CHECK(internal::finishRun(staging.staging(), tool, tool_file, path_file, m));
  KERF_CHECK(staging.commit());
  report(progress, 1.0, "done");
  return m;
}

}  // namespace kerf
