#include "sim/run/live_run.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "sim/live/chunk_occlusion.h"
#include "sim/live/tissue_colours.h"
#include "sim/run/export_bundle.h"
#include "sim/run/load_scene.h"
#include "sim/run/run_output.h"

namespace kerf {
namespace fs = std::filesystem;

LiveRun::LiveRun(LiveRunOptions options, fs::path case_folder, fs::path run_folder)
    : options_(std::move(options)), case_folder_(std::move(case_folder)), folder_(std::move(run_folder)) {}

LiveRun::~LiveRun() {
  if (is_finished_ || !recorder_) return;
  if (is_started_) {
    (void)finish();
    return;
  }
  // Never started: nobody has worked in its folder.
  (void)recorder_->close();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

Expected<std::unique_ptr<LiveRun>> LiveRun::open(const fs::path& case_folder, const fs::path& run_folder,
                                                 LiveRunOptions options, const Progress& progress) {
  if (options.tools.empty())
    return fail({.code = Error::Code::kBadValue,
                 .place = "tools",
                 .found = "none",
                 .expected = "at least one",
                 .hint = "kerf tool list"});
  std::unique_ptr<LiveRun> out(new LiveRun(std::move(options), case_folder, run_folder));
  KERF_CHECK(out->load(progress));
  KERF_CHECK(out->makeFolder());
  return out;
}

// All that may take long, and that can be cancelled.
Expected<void> LiveRun::load(const Progress& progress) {
  options_.haptic.pieces.is_wanted = false;
  if (!report(progress, 0, "loading the case")) return internal::nothingWritten();
  KERF_TRY(manifest, readCaseManifest(case_folder_));
  case_ = std::move(manifest);
  KERF_TRY(object, loadObject(case_folder_));
  object_ = std::move(object);

  if (!report(progress, 0.6, "preparing the tools")) return internal::nothingWritten();
  std::vector<Tool> tools;
  for (const SessionTool& tool : options_.tools) tools.push_back(tool.tool);
  KERF_TRY(model, makeModel(tools, options_.step, widestBand({&object_, 1})));
  if (options_.is_felt)
    for (std::size_t n = 0; n < tools.size(); ++n)
      options_.haptic.felt.push_back(feltSource(tools[n], model.tools[n].drive));

  if (options_.is_looked_at) {
    KERF_TRY(materials, readDefaultMaterials());
    options_.mesher.remesher.finish = [labels = TissueLabels::of(*object_), palette = TissuePalette(materials)](
                                          MeshChunk& chunk, const OverlayField& field) {
      chunk.colours = tissueColours(chunk, labels, palette);
      chunk.occlusion = occlusionOf(chunk, field);
    };
  }
  if (!report(progress, 0.8, "meshing the surface")) return internal::nothingWritten();
  haptic_ = std::make_unique<HapticThread>(std::move(model), LoadedObjects{object_}, options_.start, options_.haptic);
  mesher_ = std::make_unique<MesherThread>(object_->phi0(), feed_, options_.mesher);
  return {};
}

Expected<void> LiveRun::makeFolder() {
  std::error_code ignored;
  if (folder_.has_parent_path()) fs::create_directories(folder_.parent_path(), ignored);
  KERF_TRY(opened, openSessionRun(folder_, case_folder_, case_, options_.tools));
  manifest_ = std::move(opened.manifest);
  lock_.emplace(std::move(opened.lock));

  SessionHeader header = sessionHeader(manifest_);
  const SessionHeader settings = describe(haptic_->session());
  header.insert(header.end(), settings.begin(), settings.end());
  auto recorder = SessionRecorder::start(folder_ / internal::kRunLog, header, options_.recorder);
  if (recorder) {
    recorder_.emplace(std::move(*recorder));
    return {};
  }
  fs::remove_all(folder_, ignored);  // nobody has worked in it
  return fail(std::move(recorder).error());
}

Expected<void> LiveRun::start(DeviceSource& device) {
  BrickFeed* const feeds[] = {&feed_};
  KERF_CHECK(haptic_->start(device, feeds, &*recorder_));
  is_started_ = true;
  return {};
}

bool LiveRun::send(const Command& command) {
  if (!haptic_->send(command)) return false;
  const auto* const select = std::get_if<SelectTool>(&command);
  if (!select || select->tool >= manifest_.tools.size()) return true;

  const std::string& id = manifest_.tools[select->tool].id;
  if ((", " + manifest_.tool_id + ", ").find(", " + id + ", ") == std::string::npos) manifest_.tool_id += ", " + id;
  return true;
}

Expected<PostOpMesh> LiveRun::postOperative(const BrickField& changed, const PostOpOptions& options,
                                            const Progress& progress) const {
  KERF_TRY(solid, readCaseSolid(case_folder_));
  return postOperativeMeshOf(solid, object_->phi0(), changed, options, progress);
}

Expected<RunManifest> LiveRun::finish() {
  is_finished_ = true;
  haptic_->stop();
  mesher_->stop();
  const auto closed = recorder_->close();
  auto ended = endSessionRun(folder_, haptic_->session(), manifest_);
  if (ended && closed) return manifest_;
  // The cut is worth more than its log.
  if (ended) {
    Error error = closed.error();
    error.hint = "what was cut is whole, and can be exported; the log is not, and the session can not be replayed";
    return fail(std::move(error));
  }

  // A session without a cut is none: its folder holds nothing that anybody made.
  if (ended.error().code == Error::Code::kEmpty) {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  return fail(std::move(ended).error());
}

}  // namespace kerf
