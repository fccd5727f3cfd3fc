#include "sim/run/session/live_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

#include "sim/pieces/joined_field.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/export/placed_pieces.h"
#include "sim/run/export/plane_parts_mesh.h"
#include "sim/run/files/removed_volumes.h"
#include "sim/run/files/run_files.h"
#include "sim/run/files/run_output.h"
#include "sim/run/report/run_report.h"
#include "sim/run/scene/chunk_look.h"
#include "sim/run/scene/load_scene.h"
#include "sim/run/session/session_pieces.h"
#include "sim/session/checkpoint.h"

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
  // Never started: nothing was done in its folder.
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

// All work that may take long, and that the user can cancel.
Expected<void> LiveRun::load(const Progress& progress) {
  if (!report(progress, 0, "loading the case")) return internal::nothingWritten();
  KERF_TRY(manifest, readCaseManifest(case_folder_));
  case_ = std::move(manifest);
  KERF_CHECK(loadWhatIsCut());
  KERF_CHECK(loadNeighbours());

  if (!report(progress, 0.6, "preparing the tools")) return internal::nothingWritten();
  std::vector<Tool> tools;
  for (const SessionTool& tool : options_.tools) tools.push_back(tool.tool);
  KERF_TRY(model, makeModel(tools, options_.step, widestBand(loaded())));
  if (options_.is_felt)
    for (std::size_t n = 0; n < tools.size(); ++n)
      options_.haptic.felt.push_back(feltSource(tools[n], model.tools[n].drive));

  KERF_CHECK(chooseColours());
  if (!report(progress, 0.8, "meshing the surface")) return internal::nothingWritten();
  options_.haptic.pieces.on_piece = [this](std::shared_ptr<const PieceOrigin> origin, std::shared_ptr<BrickFeed> feed) {
    const std::lock_guard lock(mutex_);
    came_off_.push_back({std::move(origin), std::move(feed)});
  };
  const LoadedObjects objects = loaded();
  haptic_ = std::make_unique<HapticThread>(std::move(model), objects, options_.start, options_.haptic);
  for (std::size_t n = 0; n < objects.size(); ++n) {
    const CutObject& object = haptic_->session().state().objects[n];  // loaded objects come before all pieces
    BrickFeed& feed = feeds_.emplace_back();
    if (n > 0) labels_[object.id].name = neighbours_[n - 1].known.name;
    if (!object.bricks().isPiece())  // on_piece reports pieces
      shown_.push_back({object.id, static_cast<std::uint32_t>(n),
                        std::make_shared<MesherThread>(objects[n]->phi0(), feed, mesher_options_[n])});
  }
  return {};
}

LoadedObjects LiveRun::loaded() const {
  LoadedObjects out{object_};
  for (const LiveNeighbour& other : neighbours_) out.push_back(other.object);
  return out;
}

std::uint32_t LiveRun::loadedIndexOf(const BakedObject* object) const {
  for (std::size_t n = 0; n < neighbours_.size(); ++n)
    if (neighbours_[n].object.get() == object) return static_cast<std::uint32_t>(n + 1);
  return 0;
}

bool LiveRun::isBeside(std::uint32_t id) const {
  const auto at = std::find_if(shown_.begin(), shown_.end(), [&](const Shown& object) { return object.id == id; });
  return at != shown_.end() && at->loaded > 0;
}

// Sets the colours of each loaded object's surface.
Expected<void> LiveRun::chooseColours() {
  mesher_options_.assign(1 + neighbours_.size(), options_.mesher);
  if (!options_.is_looked_at) return {};

  const LoadedObjects objects = loaded();
  for (std::size_t n = 0; n < objects.size(); ++n) {
    const LiveNeighbour* const beside = n > 0 ? &neighbours_[n - 1] : nullptr;
    KERF_TRY(scan, internal::scanColoursOf(beside ? beside->known.folder : case_folder_));
    has_scan_colours_ |= scan != nullptr;
    if (!beside) scan_colours_ = scan;
    KERF_TRY(look, internal::chunkLook({.object = objects[n],
                                        .scan = std::move(scan),
                                        .original = beside ? beside->original : original_,
                                        .is_beside = beside != nullptr}));
    mesher_options_[n].remesher.finish = std::move(look);
  }
  return {};
}

// Loads the neighbours of the continued run in their last state, then the new ones.
Expected<void> LiveRun::loadNeighbours() {
  if (!options_.from.empty()) {
    KERF_TRY(before, readRunManifest(options_.from));
    KERF_TRY(folders, casesBesideRun(options_.from));
    for (std::size_t n = 0; n < folders.size(); ++n) {
      const RunManifest::Beside& row = before.beside[n];
      KERF_TRY(manifest, readCaseManifest(folders[n]));
      KERF_TRY(begin, readRunCutField(options_.from, n + 1));
      const std::string name = row.name.empty() ? fs::path(row.case_path).stem().string() : row.name;
      KERF_CHECK(loadNeighbour({folders[n], std::move(manifest), name, true, row.removed_mm3}, &begin));
    }
  }
  for (const CaseBeside& other : options_.beside) {
    KERF_TRY(manifest, readCaseManifest(other.folder));
    KERF_CHECK(loadNeighbour({other.folder, std::move(manifest), other.name}, nullptr));
  }
  return {};
}

Expected<void> LiveRun::loadNeighbour(SessionNeighbour known, const BrickField* begin) {
  const auto isSame = [&](const LiveNeighbour& other) { return other.known.manifest.id == known.manifest.id; };
  if (known.manifest.id == case_.id || std::any_of(neighbours_.begin(), neighbours_.end(), isSame))
    return fail({.code = Error::Code::kBadValue,
                 .file = known.folder.string(),
                 .place = "neighbour " + known.name,
                 .found = "a case that is already in the scene: two solids in one place",
                 .expected = "another tooth or jaw of the same scan frame",
                 .hint = "open each file once"});
  if (neighbours_.size() >= kMostNeighbours)
    return fail({.code = Error::Code::kBadValue,
                 .file = known.folder.string(),
                 .place = "neighbours",
                 .found = fmt::format("more than {}", kMostNeighbours),
                 .expected = fmt::format("at most {}", kMostNeighbours),
                 .hint = "open the nearest ones"});

  LiveNeighbour out;
  KERF_TRY(object, loadObject(known.folder, begin));
  out.object = std::move(object);
  out.original = {out.object, &out.object->phi0()};
  if (begin) {
    KERF_TRY(original, readCaseField(known.folder));
    out.original = std::make_shared<const BrickField>(std::move(original));
  }
  out.known = std::move(known);
  neighbours_.push_back(std::move(out));
  return {};
}

namespace {

// mm^3 that a run removed from its case. Materials with a gain, after material was added, count as 0.
Expected<double> takenOff(const fs::path& case_folder, const BrickField& original, const BrickField& begin,
                          const BakedObject& object, const MaterialBricks& added) {
  const internal::MaterialsOf now = internal::materialsOf(object);
  if (added.isEmpty()) return internal::sumOf(internal::removedVolumes(original, begin, now));

  KERF_TRY(in_case, readCaseMaterials(case_folder));
  const auto volumes =
      internal::removedVolumes(original, begin, internal::materialsOf(in_case, object.fallback()), now);
  double out = 0;
  for (const double volume : volumes) out += std::max(0.0, volume);
  return out;
}

}  // namespace

Expected<void> LiveRun::loadWhatIsCut() {
  if (options_.from.empty()) {
    KERF_TRY(object, loadObject(case_folder_));
    object_ = std::move(object);
    original_ = {object_, &object_->phi0()};
    return {};
  }
  KERF_TRY(before, readRunManifest(options_.from));
  KERF_TRY(begin, readRunCutField(options_.from));
  KERF_TRY(added, readRunMaterials(options_.from));
  KERF_TRY(object, loadObject(case_folder_, &begin, &added));
  object_ = std::move(object);
  KERF_TRY(original, readCaseField(case_folder_));
  KERF_CHECK(requireOnlyTaken(options_.from, before, begin, original));
  original_ = std::make_shared<const BrickField>(std::move(original));
  KERF_TRY(removed, takenOff(case_folder_, *original_, internal::withoutPlaneFaces(begin, *original_, before.pieces),
                             *object_, added));
  removed_before_ = removed;
  added_before_ = internal::addedVolume(*original_, begin, added);
  pieces_before_ = before.pieces;
  if (!pieces_before_.empty()) options_.haptic.begin = [this](Session& session) { return putPiecesBack(session); };
  return {};
}

// Gives the earlier run's pieces their names and places again. Lists those not found in missing_.
std::vector<Command> LiveRun::putPiecesBack(Session& session) {
  internal::PiecesPutBack back = internal::putPiecesBack(session, pieces_before_);
  for (const auto& [id, label] : back.labels) labels_[id] = label;
  missing_ = std::move(back.missing);
  return std::move(back.done);
}

Expected<void> LiveRun::makeFolder() {
  std::error_code ignored;
  if (folder_.has_parent_path()) fs::create_directories(folder_.parent_path(), ignored);
  std::vector<SessionNeighbour> beside;
  for (const LiveNeighbour& other : neighbours_) beside.push_back(other.known);
  KERF_TRY(opened, openSessionRun(folder_, case_folder_, case_, options_.tools, options_.from, beside));
  manifest_ = std::move(opened.manifest);
  lock_.emplace(std::move(opened.lock));
  // The manifest has no entry for an object in one piece.
  if (!options_.from.empty() && pieces_before_.empty()) {
    const std::uint32_t whole = haptic_->session().state().objects.front().id;
    const PieceLabels before = readPieceLabels(options_.from);
    if (const auto known = before.find(whole); known != before.end()) labels_.insert(*known);
  }
  if (!labels_.empty()) (void)writePieceLabels(folder_, labels_);

  SessionHeader header = sessionHeader(manifest_);
  const SessionHeader settings = describe(haptic_->session());
  header.insert(header.end(), settings.begin(), settings.end());
  if (options_.checkpoints.is_wanted) {
    checkpoints_ = std::make_unique<CheckpointMaker>(folder_, haptic_->session().model(), loaded(), options_.start,
                                                     options_.checkpoints);
    options_.recorder.on_written = [maker = checkpoints_.get()](std::vector<RecordedEntry> records) {
      maker->add(std::move(records));
    };
  }
  auto recorder = SessionRecorder::start(folder_ / internal::kRunLog, header, options_.recorder);
  if (recorder) {
    recorder_.emplace(std::move(*recorder));
    return {};
  }
  fs::remove_all(folder_, ignored);  // nothing was done in it
  return fail(std::move(recorder).error());
}

Expected<void> LiveRun::start(DeviceSource& device) {
  std::vector<BrickFeed*> feeds;
  for (BrickFeed& feed : feeds_)
    feeds.push_back(haptic_->session().state().objects[feeds.size()].bricks().isPiece() ? nullptr : &feed);
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

// ---- Display

void LiveRun::showNewPieces() {
  std::vector<CameOff> fresh;
  {
    const std::lock_guard lock(mutex_);
    fresh.swap(came_off_);
  }
  for (CameOff& piece : fresh) {
    const std::uint32_t id = piece.origin->id;
    const std::uint32_t loaded = loadedIndexOf(piece.origin->baked.get());
    PlaneSides sides = piece.origin->plane_sides;
    shown_.push_back(
        {id, loaded,
         std::make_shared<MesherThread>(std::move(piece.origin), std::move(piece.feed), mesher_options_[loaded]),
         std::move(sides)});
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

const LiveRun::Shown* LiveRun::shownOf(std::uint32_t id) const {
  for (const Shown& object : shown_)
    if (object.id == id) return &object;
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
    seen.loaded = object.loaded;
    const auto known = labels_.find(object.id);
    const bool is_named = known != labels_.end() && !known->second.name.empty();
    seen.name = is_named ? known->second.name : fmt::format("piece {}", n + 1);
    seen.T_world_object = object.T_world_object;
    const Shown* const shown = shownOf(object.id);
    if (!shown) return {};  // pieces appear some ms before their meshers
    seen.mesher = shown->mesher;
    seen.plane_sides = shown->plane_sides;
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
                   .found = "undo merged it again",
                   .expected = "an unchanged scene",
                   .hint = "try again"});
    out.objects.push_back({object.id, object.loaded, object.name, object.T_world_object, object.mesher->pieceField(),
                           std::move(*changed), object.plane_sides});
  }
  return out;
}

void LiveRun::namePiece(std::uint32_t id, const std::string& name) { label(id, {name, labels_[id].colour}); }

void LiveRun::colourPiece(std::uint32_t id, const std::string& colour) { label(id, {labels_[id].name, colour}); }

void LiveRun::label(std::uint32_t id, const PieceLabel& label) {
  PieceLabel& known = labels_[id];
  if (known == label) return;
  known = label;
  (void)writePieceLabels(folder_, labels_);  // the manifest has them at the end
}

Expected<LiveResult> LiveRun::postOperative(const SceneCopy& scene, const PostOpOptions& options,
                                            const Progress& progress, std::size_t beside) const {
  const LiveNeighbour* const other = beside > 0 && beside <= neighbours_.size() ? &neighbours_[beside - 1] : nullptr;
  const BrickField& begun = other ? other->object->phi0() : object_->phi0();
  LiveResult out;
  std::vector<FieldPart> parts;
  const SceneCopy::Object* first = nullptr;
  for (const SceneCopy::Object& object : scene.objects) {
    if (object.loaded != beside) continue;
    if (!first) first = &object;
    const BrickField* const begin = object.begin ? object.begin.get() : &begun;
    parts.push_back({.begin = begin, .changed = &object.changed});
    RunManifest::Piece piece;
    piece.id = object.id;
    piece.name = object.name;
    piece.T_case_piece = object.T_world_object;
    if (object.plane_sides) piece.sides = *object.plane_sides;
    out.pieces.push_back(std::move(piece));
  }
  if (!first)
    return fail({.code = Error::Code::kNotFound,
                 .place = other ? other->known.name : "the scene",
                 .found = "it is not in the scene",
                 .expected = "an object that is open"});
  const bool was_cut_before = other ? other->known.has_begin : !options_.from.empty();
  const bool is_whole = parts.size() == 1 && !first->begin && !was_cut_before;
  const bool is_cut = !other && areCutByPlanes(out.pieces);
  if (other ||
      (parts.size() == 1 && !is_cut && !out.pieces.front().isMoved() && !isNamedByUser(out.pieces.front().name)))
    out.pieces.clear();
  else
    for (std::size_t n = 0; n < parts.size(); ++n) out.pieces[n].inside = deepestPoint(parts[n]);

  const BrickField& loaded = other ? *other->original : *original_;
  const BrickField joined = is_whole ? BrickField() : joinedChanges(loaded, parts);
  KERF_TRY(solid, readCaseSolid(other ? other->known.folder : case_folder_));
  const BrickField& changed = is_whole ? first->changed : joined;
  KERF_TRY(mesh, is_cut ? planePartsMesh(solid, loaded, changed, out.pieces, options, progress)
                        : postOperativeMeshOf(solid, loaded, changed, options, progress));
  out.post_op = std::move(mesh);
  return out;
}

Expected<RunManifest> LiveRun::finish(bool keeps_log) {
  is_finished_ = true;
  haptic_->stop();
  showNewPieces();
  for (const Shown& object : shown_) object.mesher->stop();
  const auto closed = recorder_->close();
  if (checkpoints_) checkpoints_->stop();
  std::vector<const BrickField*> beside;  // null: as loaded by the session
  for (const LiveNeighbour& other : neighbours_)
    beside.push_back(other.known.has_begin ? other.original.get() : nullptr);
  // Without it, for example on a full disk, the log has its numbers.
  manifest_.summary_sha256 = internal::writeSessionSummary(folder_, haptic_->peaks()).value_or("");
  auto ended = endSessionRun(folder_, haptic_->session(), manifest_, labels_,
                             options_.from.empty() ? nullptr : original_.get(), beside);
  if (ended) removeCheckpoints(folder_);
  if (ended && closed) return manifest_;
  // The cut is worth more than its log.
  if (ended) {
    Error error = closed.error();
    error.hint = "the cut is complete and can be exported; the log is incomplete, so the session cannot be replayed";
    return fail(std::move(error));
  }

  // A session without a cut leaves no folder.
  if (ended.error().code == Error::Code::kEmpty && !keeps_log) {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  return fail(std::move(ended).error());
}

}  // namespace kerf
