#include "library/workpiece.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <fstream>
#include <mutex>
#include <utility>

#include "geometry/base/atomic_file.h"
#include "geometry/field/brick_field.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/tool/tool_file.h"
#include "sim/run/cut/geometry_cut.h"
#include "sim/run/files/run_manifest.h"
#include "sim/run/files/run_output.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// A folder for temporary files, deleted with its last owner.
class ScratchFolder {
 public:
  static Expected<std::shared_ptr<ScratchFolder>> make() {
    std::error_code failed;
    std::string name = (fs::temp_directory_path(failed) / "kerf-XXXXXX").string();
    if (failed || !::mkdtemp(name.data()))
      return fail({.code = Error::Code::kWriteFailed,
                   .file = name,
                   .found = "no folder for temporary files",
                   .expected = "a folder that can be written",
                   .hint = "set TMPDIR to one with room for the case: 100 MB for a jaw"});
    return std::make_shared<ScratchFolder>(name);
  }
  explicit ScratchFolder(fs::path path) : path_(std::move(path)) {}
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

Expected<void> copyTree(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  for (fs::recursive_directory_iterator it(from, failed), end; !failed && it != end; it.increment(failed)) {
    const fs::path target = to / it->path().lexically_relative(from);
    if (it->is_directory()) {
      std::error_code ignored;
      fs::create_directories(target, ignored);  // the copies in it report the error
    } else {
      KERF_CHECK(copyFile(it->path(), target));
    }
  }
  if (!failed) return {};
  return fail({.code = Error::Code::kUnreadable, .file = from.string(), .found = failed.message()});
}

Expected<void> writeText(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (out) return {};
  return fail({.code = Error::Code::kWriteFailed,
               .file = file.string(),
               .found = "it can not be written",
               .expected = "room for temporary files",
               .hint = "set TMPDIR to a folder with more room"});
}

Expected<fs::path> fileOf(const ToolChoice& tool, const fs::path& folder) {
  if (!tool.id_or_file.empty()) return findToolFile(tool.id_or_file, defaultToolFolders());
  const fs::path file = folder / "tool.toml";
  KERF_CHECK(writeText(file, tool.text));
  return file;
}

Expected<fs::path> fileOf(const PathChoice& path, const fs::path& folder) {
  if (!path.path.empty()) return path.path;
  std::string text = "t,x,y,z,qw,qx,qy,qz\n";
  for (const PathPose& pose : path.poses) {
    const Vec3d& p = pose.T_object_tool.translation;
    const auto& q = pose.T_object_tool.rotation;
    text += fmt::format("{},{},{},{},{},{},{},{}\n", pose.t, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z());
  }
  const fs::path file = folder / "path.csv";
  KERF_CHECK(writeText(file, text));
  return file;
}

}  // namespace

struct Workpiece::State {
  std::shared_ptr<ScratchFolder> scratch;  // null: opened
  CaseManifest manifest;
  std::optional<BakeReport> report;

  std::mutex mutex;
  fs::path folder;                          // guarded
  bool is_kept = false;                     // guarded: `folder` stays
  std::shared_ptr<const BrickField> field;  // guarded; null: not read yet
};

struct WorkpieceCut::State {
  std::shared_ptr<Workpiece::State> model;
  std::shared_ptr<ScratchFolder> scratch;
  fs::path run;
};

// ---- Workpiece

Expected<Workpiece> Workpiece::open(const fs::path& case_folder) {
  Workpiece out;
  out.state_ = std::make_shared<State>();
  KERF_TRY(manifest, readCaseManifest(case_folder));
  out.state_->manifest = std::move(manifest);
  out.state_->folder = case_folder;
  out.state_->is_kept = true;
  return out;
}

Expected<Workpiece> Workpiece::bake(const Mesh& mesh, const BakeOptions& options, const Progress& progress) {
  Workpiece out;
  out.state_ = std::make_shared<State>();
  KERF_TRY(scratch, ScratchFolder::make());
  const fs::path file = scratch->path() / "mesh.ply";
  KERF_CHECK(writeMesh(file, mesh, {.double_positions = true}));
  out.state_->folder = scratch->path() / "model.case";
  out.state_->scratch = scratch;
  KERF_TRY(report, kerf::bake({file}, out.state_->folder, options, progress));
  out.state_->manifest = report.manifest;
  out.state_->report = std::move(report);
  std::error_code ignored;
  fs::remove(file, ignored);
  return out;
}

const CaseManifest& Workpiece::manifest() const { return state_->manifest; }

const BakeReport* Workpiece::report() const { return state_->report ? &*state_->report : nullptr; }

std::vector<std::string> Workpiece::warnings() const {
  if (!state_->report) return state_->manifest.warnings.value_or(std::vector<std::string>{});
  std::vector<std::string> out = doubtsOfUnits(*state_->report);
  for (std::string& warning : warningsOf(*state_->report)) out.push_back(std::move(warning));
  return out;
}

fs::path Workpiece::folder() const {
  const std::lock_guard lock(state_->mutex);
  return state_->folder;
}

Expected<Mesh> Workpiece::solid() const { return readCaseSolid(folder()); }

Expected<std::vector<double>> Workpiece::distance(std::span<const Vec3d> points) const {
  std::shared_ptr<const BrickField> field;
  {
    const std::lock_guard lock(state_->mutex);
    if (!state_->field) {
      KERF_TRY(read, readCaseField(state_->folder));
      state_->field = std::make_shared<const BrickField>(std::move(read));
    }
    field = state_->field;
  }
  std::vector<double> out;
  out.reserve(points.size());
  for (const Vec3d& point : points) out.push_back(field->sample(point));
  return out;
}

Expected<void> Workpiece::save(const fs::path& case_folder) {
  KERF_TRY(copy, AtomicFolder::create(case_folder, false));
  KERF_CHECK(copyTree(folder(), copy.staging()));
  KERF_CHECK(copy.commit());
  const std::lock_guard lock(state_->mutex);
  state_->folder = case_folder;
  state_->is_kept = true;
  return {};
}

Expected<WorkpieceCut> Workpiece::cut(const ToolChoice& tool, const PathChoice& path, const CutRequest& request,
                                      const Progress& progress) const {
  WorkpieceCut out;
  out.state_ = std::make_shared<WorkpieceCut::State>();
  out.state_->model = state_;
  KERF_TRY(scratch, ScratchFolder::make());
  out.state_->scratch = scratch;
  out.state_->run = scratch->path() / "cut.run";
  KERF_TRY(tool_file, fileOf(tool, scratch->path()));
  KERF_TRY(path_file, fileOf(path, scratch->path()));
  KERF_TRY(used, readTool(tool_file));

  constexpr double kOfCut = 0.6;
  const Progress cutting = partOf(progress, 0, kOfCut);
  if (request.hand) {
    KERF_CHECK(checkOptions(*request.hand));
    KERF_TRY(made, cutCaseByHand(folder(), tool_file, path_file, out.state_->run, *request.hand, cutting));
    out.remarks = remarksOf(made, *request.hand, used);
    out.summary = std::move(made.summary);
  } else {
    KERF_TRY(made, cutCase(folder(), tool_file, path_file, out.state_->run, {}, cutting));
    out.remarks = remarksOf(made, used);
  }
  KERF_TRY(exported, exportBundle(out.state_->run, {}, partOf(progress, kOfCut, 1)));
  out.post_op = std::move(exported.post_op);
  out.accuracy = exported.accuracy;
  out.removed_mm3 = out.post_op.report.removed_volume_mm3;
  return out;
}

// ---- WorkpieceCut

Expected<RunSeries> WorkpieceCut::series(const Progress& progress) const {
  return readRunSeries(state_->run, progress);
}

Expected<void> WorkpieceCut::save(const fs::path& run_folder) const {
  fs::path case_folder;
  {
    const std::lock_guard lock(state_->model->mutex);
    if (state_->model->is_kept) case_folder = state_->model->folder;
  }
  if (case_folder.empty())
    return fail({.code = Error::Code::kUnsupported,
                 .file = run_folder.string(),
                 .found = "a run of a case that is in no folder yet",
                 .expected = "a saved case: a run refers to it",
                 .hint = "save the case first"});
  KERF_TRY(manifest, readRunManifest(state_->run));
  KERF_TRY(case_path, internal::relativeCasePath(case_folder, run_folder));
  manifest.case_path = case_path;
  KERF_TRY(copy, AtomicFolder::create(run_folder, false, kRunManifest));
  KERF_CHECK(copyTree(state_->run, copy.staging()));
  KERF_CHECK(writeRunManifest(copy.staging(), manifest));
  return copy.commit();
}

}  // namespace kerf
