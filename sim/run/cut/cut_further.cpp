#include "sim/run/cut/cut_further.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "geometry/base/atomic_file.h"
#include "geometry/field/vdb_io.h"
#include "geometry/tool/sweep.h"
#include "sim/monitor/monitor.h"
#include "sim/pieces/joined_field.h"
#include "sim/run/files/run_output.h"
#include "sim/run/scene/cut_scene.h"
#include "sim/run/session/session_pieces.h"
#include "sim/run/sweep/path_watch.h"
#include "sim/run/sweep/sweep_cutter.h"

namespace kerf::internal {
namespace {

namespace fs = std::filesystem;

// An object that the tool sweeps: a piece of the case, all of it, or a neighbour.
struct Target {
  const BrickField* begin = nullptr;
  CutPath path;  // short motions merged, in the object's frame
  std::unique_ptr<SweepCutter> cutter;
  BrickField cut;  // bricks that changed
};

std::vector<Target> targetsOf(const CutScene& scene, const Bodies& bodies, const CutPath& path) {
  std::vector<Target> out;
  for (const Bodies::Body& body : bodies.all)
    out.push_back({body.begin, pathInFrame(path, body.T_world_body), std::make_unique<SweepCutter>(*body.begin), {}});
  for (std::size_t n = 1; n < scene.objects.size(); ++n) {
    const BrickField& begin = scene.objects[n]->phi0();
    out.push_back({&begin, path, std::make_unique<SweepCutter>(begin), {}});
  }
  return out;
}

struct SweptFurther {
  PathFindings findings;
  bool is_case_cut = false;  // a piece of it, or all
};

// Sweeps the tool through all bodies, motion by motion.   @param bodies  the first ones belong to the case.
Expected<SweptFurther> sweepFurther(std::vector<Target>& targets, std::size_t bodies, const CutScene& scene,
                                    const CutPath& path, const Progress& progress) {
  SweptFurther out;
  PathWatch watch(scene.object().phi0());
  const ToolShape& cut = *scene.inputs.tool.cut;
  const std::size_t segments = path.poses.empty() ? 0 : path.poses.size() - 1;
  for (std::size_t s = 0; s < segments; ++s) {
    const double done = 0.1 + 0.8 * static_cast<double>(s) / static_cast<double>(segments);
    if (s % 16 == 0 && !report(progress, done, "cutting")) return nothingWritten();
    if (!path.cuts[s]) {
      watch.moveInAir();
      continue;
    }
    bool removes = false;
    for (std::size_t n = 0; n < targets.size(); ++n) {
      const std::vector<PathPose>& poses = targets[n].path.poses;
      if (!targets[n].cutter->advance(SweptTool(cut, poses[s].T_object_tool, poses[s + 1].T_object_tool))) continue;
      removes = true;
      out.is_case_cut |= n < bodies;
    }
    watch.cut(path.poses[s].T_object_tool, path.poses[s + 1].T_object_tool, removes);
  }
  for (Target& target : targets) target.cut = target.cutter->cutField();
  out.findings = watch.take();
  return out;
}

RunManifest furtherManifest(const CutScene& scene, const MergedPath& merged) {
  const CutInputs& inputs = scene.inputs;
  const CutPath& path = inputs.path;
  RunManifest m;
  addMotions(path, m);
  m.case_path = inputs.paths.front();
  m.case_id = inputs.manifests.front().id;
  m.duration_s = path.poses.empty() ? 0 : path.poses.back().t - path.poses.front().t;
  m.voxel_mm = scene.object().voxel();
  m.merged_motions = merged.merged;
  m.swept_motions = static_cast<std::size_t>(std::count(merged.path.cuts.begin(), merged.path.cuts.end(), 1));
  m.merge_tolerance_mm = kMergeTolerance * m.voxel_mm;
  return m;
}

// The fields of the case and its neighbours, as differences from their state before any run.
std::vector<BrickField> furtherFields(const CutScene& scene, const std::vector<Target>& targets, std::size_t bodies) {
  std::vector<FieldPart> parts;
  for (std::size_t n = 0; n < bodies; ++n) parts.push_back({.begin = targets[n].begin, .changed = &targets[n].cut});
  std::vector<BrickField> out{joinedChanges(scene.originals.front(), parts)};
  for (std::size_t n = 1; n < scene.objects.size(); ++n) {
    const Target& target = targets[bodies + n - 1];
    const FieldPart all{.begin = target.begin, .changed = &target.cut};
    out.push_back(joinedChanges(scene.originals[n], {&all, 1}));
  }
  return out;
}

}  // namespace

Expected<RunManifest> cutFurther(const fs::path& run, const fs::path& tool_file, const fs::path& path_file,
                                 const fs::path& run_folder, const CutOptions& options, const Progress& progress) {
  KERF_TRY(inputs, readInputs(run, {}, tool_file, path_file, run_folder));
  KERF_TRY(staging, AtomicFolder::create(run_folder, options.overwrite, kRunManifest));
  if (!report(progress, 0.0, "loading the case")) return nothingWritten();
  KERF_TRY(scene, loadScene(std::move(inputs), {}));
  Session session(scene.model, scene.objects, scene.start());
  const PiecesPutBack back = putPiecesBack(session, scene.inputs.before.pieces);
  const Bodies bodies = bodiesOf(session);

  // Cut.
  const MergedPath merged = mergedFor(*scene.inputs.tool.cut, scene.inputs.path, scene.object().voxel());
  std::vector<Target> targets = targetsOf(scene, bodies, merged.path);
  KERF_TRY(swept, sweepFurther(targets, bodies.all.size(), scene, merged.path, progress));
  if (!swept.is_case_cut)
    return fail({.code = Error::Code::kEmpty,
                 .file = path_file.string(),
                 .found = fmt::format("tool {} does not touch the remaining object", scene.inputs.tool.id),
                 .expected = throughBodies(bodies, scene.inputs.manifests.front().box),
                 .hint = "check the path's frame and unit"});

  // Count.
  RunManifest m = furtherManifest(scene, merged);
  m.findings = swept.findings;
  m.missing_pieces = back.missing;
  m.added_before_mm3 = scene.added_before_mm3;
  const std::vector<BrickField> changed = furtherFields(scene, targets, bodies.all.size());
  m.state_hash = fmt::format("{:016x}", changed.front().stateHash());
  if (bodies.isInPieces()) {
    const std::vector<RunManifest::Piece> put_back = piecesOf(objectsOf(session, 0), bodies.fields, back.labels);
    std::vector<FieldPart> parts;
    for (std::size_t n = 0; n < bodies.all.size(); ++n)
      parts.push_back({.begin = targets[n].begin, .changed = &targets[n].cut});
    KERF_TRY(left, piecesLeft(scene, changed.front(), put_back, parts));
    m.pieces = std::move(left.pieces);
    m.pieces_cut_away = std::move(left.cut_away);
    m.findings.comes_out_at.reset();  // valid only for a case in one piece
  }
  VolumeByNumber removed{};
  for (std::size_t n = 0; n < bodies.all.size(); ++n) {
    const auto of_body = removedVolumes(*targets[n].begin, targets[n].cut, materialsOf(scene.object()));
    for (std::size_t k = 0; k < removed.size(); ++k) removed[k] += of_body[k];
  }
  m.removed_by_material = byMaterial(removed, scene.materials);
  for (std::size_t n = 1; n < scene.objects.size(); ++n) {
    const Target& target = targets[bodies.all.size() + n - 1];
    RunManifest::Beside other = scene.inputs.before.beside[n - 1];
    other.case_path = scene.inputs.paths[n];
    other.has_begin = true;
    other.removed_now_mm3 =
        std::max(0.0, sumOf(removedVolumes(*target.begin, target.cut, materialsOf(*scene.objects[n]))));
    other.removed_mm3 += other.removed_now_mm3;
    m.beside.push_back(std::move(other));
  }

  // Write.
  if (!report(progress, 0.92, "writing")) return nothingWritten();
  std::vector<NamedField> grids{{"phi", &changed.front()}};
  for (std::size_t n = 1; n < changed.size(); ++n) grids.push_back({neighbourId(n), &changed[n]});
  KERF_CHECK(writeVdb(staging.staging() / kRunField, grids, {{"case_id", m.case_id}}, &scene.added));
  KERF_TRY(begin_sha256, storeBegin(run, staging.staging()));
  m.begin_sha256 = begin_sha256;
  KERF_CHECK(writeGeometrySummary(staging.staging() / kRunSummary,
                                  byMaterial(scene.object().volumes(), scene.materials), m.removed_by_material,
                                  countPieces(scene.originals.front(), changed.front())));
  KERF_CHECK(finishRun(staging.staging(), scene.inputs.tool, tool_file, path_file, m));
  KERF_CHECK(staging.commit());
  report(progress, 1.0, "done");
  return m;
}

Expected<void> writeGeometrySummary(const fs::path& file, const std::map<std::string, double>& initial,
                                    const std::map<std::string, double>& removed, const PieceCount& left) {
  const auto sum = [](const std::map<std::string, double>& volumes) {
    double out = 0;
    for (const auto& [id, volume] : volumes) out += volume;
    return out;
  };
  KERF_TRY(out, AtomicFile::create(file));
  out.stream() << nlohmann::json{{"initial_mm3", sum(initial)}, {"initial_by_material_mm3", initial},
                                 {"removed_mm3", sum(removed)}, {"removed_by_material_mm3", removed},
                                 {"pieces", left.pieces},       {"crumbs", left.crumbs}}
                      .dump(2)
               << "\n";
  return out.commit();
}

}  // namespace kerf::internal
