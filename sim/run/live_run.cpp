#include "sim/run/live_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

#include "sim/live/chunk_occlusion.h"
#include "sim/live/tissue_colours.h"
#include "sim/pieces/joined_field.h"
#include "sim/run/export_bundle.h"
#include "sim/run/load_scene.h"
#include "sim/run/removed_volumes.h"
#include "sim/run/run_files.h"
#include "sim/run/run_output.h"

namespace kerf {
namespace fs = std::filesystem;

namespace {

// At the node that is nearest.
bool isInside(const CutObject& object, const Vec3d& point) {
  const Vec3d nodes = point / object.voxel();
  const Vec3i node(static_cast<int>(std::lround(nodes[0])), static_cast<int>(std::lround(nodes[1])),
                   static_cast<int>(std::lround(nodes[2])));
  const int slot = object.find(brickOf(node));
  return slot >= 0 && object.slot(slot).phi[nodeOffset(node[0], node[1], node[2])] < 0;
}

}  // namespace

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
  if (!report(progress, 0, "loading the case")) return internal::nothingWritten();
  KERF_TRY(manifest, readCaseManifest(case_folder_));
  case_ = std::move(manifest);
  KERF_CHECK(loadWhatIsCut());

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
  options_.haptic.pieces.on_piece = [this](std::shared_ptr<const PieceOrigin> origin, std::shared_ptr<BrickFeed> feed) {
    const std::lock_guard lock(mutex_);
    came_off_.push_back({std::move(origin), std::move(feed)});
  };
  haptic_ = std::make_unique<HapticThread>(std::move(model), LoadedObjects{object_}, options_.start, options_.haptic);
  const CutObject& first = haptic_->session().state().objects.front();
  if (!first.bricks().isPiece())  // else on_piece tells of all
    shown_.push_back({first.id, std::make_shared<MesherThread>(object_->phi0(), feed_, options_.mesher)});
  return {};
}

Expected<void> LiveRun::loadWhatIsCut() {
  if (options_.from.empty()) {
    KERF_TRY(object, loadObject(case_folder_));
    object_ = std::move(object);
    original_ = {object_, &object_->phi0()};
    return {};
  }
  KERF_TRY(before, readRunManifest(options_.from));
  KERF_TRY(begin, readRunCutField(options_.from));
  KERF_TRY(object, loadObject(case_folder_, &begin));
  object_ = std::move(object);
  KERF_TRY(original, readCaseField(case_folder_));
  original_ = std::make_shared<const BrickField>(std::move(original));
  for (const double volume : internal::removedVolumes(*original_, begin, internal::materialsOf(*object_)))
    removed_before_ += volume;
  pieces_before_ = before.pieces;
  if (!pieces_before_.empty()) options_.haptic.begin = [this](Session& session) { return putPiecesBack(session); };
  return {};
}

// Of the run before: its pieces get their names and places again. What cannot be found again is in missing_.
std::vector<Command> LiveRun::putPiecesBack(Session& session) {
  std::vector<Command> done;
  const auto apply = [&](const Command& command) {
    if (session.apply(command)) done.push_back(command);
  };
  if (pieces_before_.size() > 1) apply(SplitObject{0});

  for (const RunManifest::Piece& before : pieces_before_) {
    const std::vector<CutObject>& objects = session.state().objects;
    const auto at = std::find_if(objects.begin(), objects.end(),
                                 [&](const CutObject& object) { return isInside(object, before.inside); });
    if (at == objects.end()) {
      missing_.push_back(before.name);
      continue;
    }
    names_[at->id] = before.name;
    if (!before.isMoved()) continue;
    const Vec3d& t = before.T_case_piece.translation;
    const Eigen::Quaterniond& q = before.T_case_piece.rotation;
    apply(MoveObject{static_cast<std::size_t>(at - objects.begin()), {t[0], t[1], t[2]}, {q.w(), q.x(), q.y(), q.z()}});
  }
  return done;
}

Expected<void> LiveRun::makeFolder() {
  std::error_code ignored;
  if (folder_.has_parent_path()) fs::create_directories(folder_.parent_path(), ignored);
  KERF_TRY(opened, openSessionRun(folder_, case_folder_, case_, options_.tools, options_.from));
  manifest_ = std::move(opened.manifest);
  lock_.emplace(std::move(opened.lock));
  if (!names_.empty()) (void)writePieceNames(folder_, names_);

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
  BrickFeed* const feeds[] = {haptic_->session().state().objects.front().bricks().isPiece() ? nullptr : &feed_};
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

// ---- What there is to see

void LiveRun::showNewPieces() {
  std::vector<CameOff> fresh;
  {
    const std::lock_guard lock(mutex_);
    fresh.swap(came_off_);
  }
  for (CameOff& piece : fresh) {
    const std::uint32_t id = piece.origin->id;
    shown_.push_back(
        {id, std::make_shared<MesherThread>(std::move(piece.origin), std::move(piece.feed), options_.mesher)});
  }
  std::erase_if(shown_, [this](const Shown& object) {
    if (!object.mesher->isForgotten()) return false;
    object.mesher->stop();
    edits_of_forgotten_ += object.mesher->editsDone();
    return true;
  });
}

std::vector<ObjectChunks> LiveRun::takeChunks() {
  showNewPieces();
  std::vector<ObjectChunks> out;
  for (const Shown& object : shown_) {
    std::vector<MeshChunkPtr> chunks = object.mesher->take();
    if (!chunks.empty()) out.push_back({object.id, std::move(chunks)});
  }
  return out;
}

std::uint64_t LiveRun::editsDone() const noexcept {
  std::uint64_t out = edits_of_forgotten_;
  for (const Shown& object : shown_) out += object.mesher->editsDone();
  return out;
}

std::shared_ptr<MesherThread> LiveRun::mesherOf(std::uint32_t id) {
  for (const Shown& object : shown_)
    if (object.id == id) return object.mesher;
  return nullptr;
}

std::optional<SceneView> LiveRun::viewScene() {
  showNewPieces();
  haptic_->update();
  const HapticReport& report = haptic_->report();
  if (report.object_count == 0) return {};
  SceneView out;
  for (std::size_t n = 0; n < report.object_count; ++n) {
    const ObjectReport& object = report.objects[n];
    SceneView::Object& seen = out.objects.emplace_back();
    seen.id = object.id;
    const auto name = names_.find(object.id);
    seen.name = name == names_.end() ? fmt::format("piece {}", n + 1) : name->second;
    seen.T_world_object = object.T_world_object;
    seen.mesher = mesherOf(object.id);
    if (!seen.mesher) return {};  // pieces are in the scene some ms before their meshers are
  }
  return out;
}

Expected<SceneCopy> LiveRun::copyOf(const SceneView& view) {
  SceneCopy out;
  for (const SceneView::Object& object : view.objects) {
    auto changed = object.mesher->changedField();
    if (!changed)
      return fail({.code = Error::Code::kNotFound,
                   .place = object.name,
                   .found = "it was put together again meanwhile",
                   .expected = "a scene that stays as it is",
                   .hint = "try again"});
    out.objects.push_back(
        {object.id, object.name, object.T_world_object, object.mesher->pieceField(), std::move(*changed)});
  }
  return out;
}

void LiveRun::namePiece(std::uint32_t id, const std::string& name) {
  std::string& known = names_[id];
  if (known == name) return;
  known = name;
  (void)writePieceNames(folder_, names_);  // the manifest has them at the end
}

Expected<LiveResult> LiveRun::postOperative(const SceneCopy& scene, const PostOpOptions& options,
                                            const Progress& progress) const {
  LiveResult out;
  std::vector<FieldPart> parts;
  for (const SceneCopy::Object& object : scene.objects) {
    const BrickField* const begin = object.begin ? object.begin.get() : &object_->phi0();
    parts.push_back({.begin = begin, .changed = &object.changed});
    RunManifest::Piece piece;
    piece.id = object.id;
    piece.name = object.name;
    piece.T_case_piece = object.T_world_object;
    out.pieces.push_back(std::move(piece));
  }
  const bool is_whole = parts.size() == 1 && !scene.objects.front().begin && options_.from.empty();
  if (parts.size() == 1 && !out.pieces.front().isMoved())
    out.pieces.clear();
  else
    for (std::size_t n = 0; n < parts.size(); ++n) out.pieces[n].inside = deepestPoint(parts[n]);

  const BrickField& loaded = *original_;
  const BrickField joined = is_whole ? BrickField() : joinedChanges(loaded, parts);
  KERF_TRY(solid, readCaseSolid(case_folder_));
  const BrickField& changed = is_whole ? scene.objects.front().changed : joined;
  KERF_TRY(mesh, postOperativeMeshOf(solid, loaded, changed, options, progress));
  out.post_op = std::move(mesh);
  return out;
}

Expected<RunManifest> LiveRun::finish() {
  is_finished_ = true;
  haptic_->stop();
  showNewPieces();
  for (const Shown& object : shown_) object.mesher->stop();
  const auto closed = recorder_->close();
  auto ended =
      endSessionRun(folder_, haptic_->session(), manifest_, names_, options_.from.empty() ? nullptr : original_.get());
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
