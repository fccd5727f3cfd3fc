#include "ui/app/workbench.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "geometry/formats/mesh_formats.h"
#include "sim/run/watched_run.h"
#include "ui/app/arm_lead.h"
#include "ui/app/exporting.h"
#include "ui/app/import_set.h"
#include "ui/app/sawing.h"
#include "ui/app/tissue_display.h"
#include "ui/app/user_files.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

fs::path dataFolderOf(const WorkbenchOptions& options) {
  return options.data_folder.empty() ? userDataFolder() : options.data_folder;
}

Expected<std::string> exportWhenGiven(const LiveRun& run, std::future<SceneView>& given, const fs::path& file,
                                      const ExportChoice& choice, const Progress& progress) {
  constexpr auto kPoll = std::chrono::milliseconds(5);
  while (given.wait_for(kPoll) != std::future_status::ready)
    if (!report(progress, 0, "waiting for the last stroke")) return cancelled(file.string());
  KERF_TRY(scene, LiveRun::copyOf(given.get()));
  return exportScene(run, scene, file, choice, progress);
}

// Before a session ends: undo or redo that is still to be sent, and all that was sent answered; a minute at most.
void sendTheRest(LiveRun& run, std::ptrdiff_t undos, std::uint64_t sent) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  const auto answered = [&] {
    (void)run.thread().update();
    const HapticCounts& counts = run.thread().report().counts;
    return counts.commands_done + counts.commands_refused;
  };
  while ((undos != 0 || answered() < sent) && std::chrono::steady_clock::now() < until) {
    const bool is_sent = undos != 0 && run.send(undos < 0 ? Command(Undo{}) : Command(Redo{}));
    if (!is_sent) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      continue;
    }
    undos += undos < 0 ? 1 : -1;
    ++sent;
  }
}

}  // namespace

Workbench::Workbench(WorkbenchOptions options)
    : options_(std::move(options)),
      recent_(dataFolderOf(options_)),
      arm_(std::make_unique<ArmLead>()),
      tissues_(std::make_unique<TissueDisplay>()),
      saw_(std::make_unique<Sawing>(*this)) {
  options_.data_folder = dataFolderOf(options_);
  fillRack();
  if (auto materials = readDefaultMaterials())
    materials_ = std::move(*materials);
  else
    complain(materials.error());
  findLostSessions();
  if (options_.device.empty()) return;
  if (const auto opened = arm_->open(options_.device); !opened) complain(opened.error());
}

Workbench::~Workbench() {
  job_.reset();
  if (!run_) return;
  tissues_->closing();
  namePieces();
  saw_->closing();
  arm_->closing();
  sendTheRest(*run_, undos_left_, sent_);
  (void)run_->finish();
}

std::string Workbench::nameOf(Material material) const {
  const MaterialProperties* const known = materials_.find(material);
  return known ? known->name : fmt::format("material {}", static_cast<int>(material));
}

// ---- Once a frame

std::vector<ObjectChunks> Workbench::update() {
  if (job_ && job_->isOver()) {
    const auto over = std::move(job_);  // what follows may start another one
    const auto done = std::exchange(when_over_, {});
    if (done) done();
  }
  if (import_ && !job_) import_->update();
  takeNews();
  if (!run_) (void)arm_->update(report_, false);  // its panel shows it
  handOverScene();
  if (const auto done = tissues_->update(); !done) complain(done.error());
  saw_->update();
  watchTools();
  return std::exchange(fresh_, {});
}

void Workbench::takeNews() {
  if (watched_) return takeWatched();
  if (!run_) return;
  if (run_->thread().update()) {
    report_ = run_->thread().report();
    removed_mm3_ = run_->removedBefore();
    for (std::size_t n = 0; n < report_.object_count; ++n)
      if (report_.objects[n].loaded == 0) removed_mm3_ += report_.objects[n].removed_mm3;
    warnOfNeighbours();
    addToTrace();
    warnOfHeat();
  }
  timeline_.update(report_.undo);
  goWhereWished();
  sendUndos();
  followDevice();
  if (run_->thread().updateTimes()) times_ = run_->thread().times();
  const auto chunks = run_->takeChunks();
  scene_.update(chunks, report_);
  // A piece that was moved is where the simulation has it as soon as that has answered.
  std::erase_if(moving_, [&](const Moving& piece) {
    if (answered() < piece.sent) return false;
    dragPiece(piece.id, std::nullopt);
    return true;
  });
  fresh_.insert(fresh_.end(), chunks.begin(), chunks.end());

  const RecorderStatus log = run_->recorderStatus();
  if (!log.error || std::exchange(has_told_of_log_, true)) return;
  Error error = *log.error;
  error.hint = "free some space and end the session: what was cut is kept, the log ends here";
  complain(error);
}

double Workbench::driveShare() const {
  if (!isShown()) return 0;
  const Model& model = run_ ? run_->model() : watched_->model();
  const double free_speed = model.tools[tool_].drive.speed;
  return free_speed > 0 ? report_.output.speed / free_speed : 0;
}

double Workbench::driveLoadShare() const {
  if (!run_) return 0;
  const double stall_load = run_->model().tools[tool_].drive.stall_load;
  return stall_load > 0 ? report_.output.drive_load / stall_load : 0;
}

void Workbench::addToTrace() {
  trace_.add({.tick = report_.tick,
              .force = report_.output.force.force.norm(),
              .torque = report_.output.force.torque.norm(),
              .load = 100 * driveLoadShare(),
              .spindle = 100 * driveShare(),
              .depth = depthNow().value_or(0),
              .penetration = 1000 * report_.output.deepest,
              .temperature = report_.heat.surface,
              .removed_mm3 = removed_mm3_,
              .jumps = report_.counts.pauses});
}

// Once each: a notice does not interrupt.
void Workbench::warnOfHeat() {
  const HeatAlarms& alarms = report_.heat.alarms;
  if (alarms.pulp >= 0 && !std::exchange(has_told_of_pulp_, true))
    say(
        fmt::format("The pulp is {:.1f} C warmer than the body: not every pulp recovers from that (Zach & Cohen 1965). "
                    "More spray, less force, or a pause.",
                    kPulpLimitRise));
  if (alarms.bone_warm >= 0 && !std::exchange(has_told_of_bone_, true))
    say(fmt::format(
        "The bone under the tool has {:.0f} C: after a minute it dies (Eriksson & Albrektsson). More spray, "
        "less force, or a pause.",
        kBodyCelsius + kBoneLimitRise));
  if (alarms.bone_dead >= 0 && !std::exchange(has_told_of_dead_bone_, true))
    say(fmt::format("Bone half a millimetre beside the cut had {:.0f} C or more for {:.0f} s together: it would die.",
                    kBodyCelsius + kBoneLimitRise, kBoneLimitSeconds));
}

double Workbench::removedOf(Material material) const {
  const auto number = static_cast<std::size_t>(material);
  return isShown() && number < report_.removed_by_material.size() ? report_.removed_by_material[number] : 0;
}

// What was asked for is done, and the meshers know of it.
bool Workbench::isSettled() {
  constexpr std::uint64_t kTicks = 3;  // after a command: what it changed is counted in the next tick
  const HapticCounts& c = report_.counts;
  const bool is_done = undos_left_ == 0 && answered() >= sent_ && report_.output.touching == 0;
  if (is_done && !handover_->done_at) handover_->done_at = report_.tick;
  const bool is_counted = handover_->done_at && report_.tick >= *handover_->done_at + kTicks;
  return is_counted && c.edits_waiting == 0 && run_->editsDone() >= c.edits_pushed;
}

// To the job that exports it: when the last stroke is meshed, or after a second, for somebody who goes on cutting.
void Workbench::handOverScene() {
  constexpr auto kMost = std::chrono::seconds(1);
  if (!handover_) return;
  if (!run_ || !job_) return handover_.reset();
  if (undos_left_ != 0 || wish_) handover_->sent = sent_;
  if (undos_left_ != 0 || wish_ || answered() < handover_->sent) {
    handover_->began = std::chrono::steady_clock::now();
    return;
  }
  if (!isSettled() && std::chrono::steady_clock::now() < handover_->began + kMost) return;
  auto view = run_->viewScene();
  if (!view) return;
  handover_->scene.set_value(std::move(*view));
  handover_.reset();
}

void Workbench::cancelJob() {
  if (job_) job_->cancel();
}

bool Workbench::isBusy() {
  if (!job_) return false;
  complain({.code = Error::Code::kUnsupported,
            .found = "still at work: " + job_->status().title,
            .hint = "wait for it, or cancel it"});
  return true;
}

bool Workbench::isSawing() {
  if (!saw_->isCutting()) return false;
  complain({.code = Error::Code::kUnsupported,
            .found = "a plane is being sawn",
            .expected = "a tool at rest",
            .hint = "wait for it, or stop it (saw.stop)"});
  return true;
}

// ---- Opening

void Workbench::open(const fs::path& path) {
  if (kindOf(path) == FileKind::kTool) return addTool(path);
  openBy("opening " + path.filename().string(),
         [path, options = openingOptions()](const Progress& progress) { return openToCut(path, options, progress); });
}

void Workbench::openDemo(const std::string& name) {
  openBy("opening the demo " + name, [name, options = openingOptions()](const Progress& progress) {
    return openDemoToCut(name, options, progress);
  });
}

OpeningOptions Workbench::openingOptions() const {
  return {options_.data_folder, {options_.unit, options_.voxel_mm, {}}, tools_, options_.real_time, arm_->coupling()};
}

void Workbench::openBy(const std::string& title, Load load) {
  if (isBusy()) return;
  auto job = std::make_unique<Job<Opened>>(title, std::move(load));
  job_writes_ = false;
  when_over_ = [this, job = job.get()] {
    auto loaded = job->take();
    if (!loaded) return complain(loaded.error());
    const auto next = std::make_shared<Opened>(std::move(*loaded));
    if (!run_) return show(*next);

    // What was open is written only now that there is something in its place.
    close();
    const auto closing = std::exchange(when_over_, {});
    when_over_ = [this, closing, next] {
      closing();
      show(*next);
    };
  };
  job_ = std::move(job);
}

void Workbench::show(Opened& loaded) {
  const CouplingSettings& coupling = loaded.run->model().settings.coupling;
  auto hand = std::make_unique<MouseHand>(loaded.run->original(), loaded.run->thread().session().state().body.pose,
                                          coupling.stiffness, coupling.turn_stiffness);
  auto hands = std::make_shared<HandSwitch>(*hand);
  auto guided = std::make_unique<GuidedHand>(*hands, coupling.stiffness, coupling.turn_stiffness);
  hand->keepAwayFrom(loaded.structures);
  hand->keepAwayFromBeside(loaded.neighbours);
  const auto started = loaded.run->start(*guided);
  if (!started) {
    (void)loaded.run->finish();
    return complain(started.error());
  }
  putImportAway();
  tissues_->closing();  // before what it is told of is gone
  watched_.reset();
  asked_run_.reset();
  hand_ = std::move(hand);
  hands_ = std::move(hands);
  guided_ = std::move(guided);
  run_ = std::move(loaded.run);
  arm_->opened(*run_, hands_);
  structures_ = std::move(loaded.structures);
  neighbour_fields_ = std::move(loaded.neighbours);
  sources_beside_ = std::move(loaded.sources_beside);
  cut_off_.assign(run_->neighbours().size(), {});
  tissues_->opened(tissueSourceOf(*run_, structures_), materials_);
  samples_.clear();
  name_ = loaded.name;
  source_ = loaded.source;
  sent_ = 0;
  report_ = {};
  timeline_.clear();
  trace_.clear();
  undos_left_ = 0;
  undos_answered_at_ = 0;
  wish_.reset();
  has_told_of_log_ = has_told_of_pulp_ = has_told_of_bone_ = has_told_of_dead_bone_ = false;
  fresh_.clear();
  occlusal_ = loaded.occlusal;
  session_ = run_->folder();
  scene_.clear();
  tool_ = 0;
  aim_ = {};
  stroke_.reset();
  pointed_.reset();
  is_on_pedal_ = is_reversed_ = false;
  chosen_.reset();
  if (!is_reopening_) {
    section.reset();
    measure.clear();
    told_sides.reset();
    tilt = {};  // a way to lean in the other scan
    speed = 1;
  }
  moving_.clear();
  scene_.setNames(run_->names());
  for (const std::string& name : run_->missingPieces())
    say("not found again, and so where it was in the scan: " + name);
  removed_mm3_ = 0;
  saw_->opened();
  heatByToolInHand();
  ++generation_;
  keeps_view_ = is_reopening_;
  std::fill(is_outdated_.begin(), is_outdated_.end(), 0);
  for (std::string& note : loaded.notes) say(std::move(note));
  if (!is_reopening_) remember(source_);
}

// For what is written: names as the window shows them.
void Workbench::namePieces() {
  for (const SceneObject* object : scene_.shown()) run_->namePiece(object->id, object->name);
}

void Workbench::close() {
  if (isBusy() || !run_) return;
  release();
  namePieces();
  saw_->closing();
  tissues_->closing();
  arm_->closing();
  std::shared_ptr<LiveRun> ending = std::move(run_);
  std::shared_ptr<MouseHand> hand = std::move(hand_);
  std::shared_ptr<HandSwitch> hands = std::move(hands_);
  std::shared_ptr<GuidedHand> guided = std::move(guided_);
  const std::string name = name_;
  scene_.clear();
  ++generation_;
  auto job = std::make_unique<Job<RunManifest>>(
      "writing the session of " + name,
      [ending, guided, hands, hand, left = std::exchange(undos_left_, 0), sent = sent_](const Progress&) {
        sendTheRest(*ending, left, sent);
        return ending->finish();
      },
      false);
  job_writes_ = true;
  when_over_ = [this, job = job.get(), folder = session_] {
    auto written = job->take();
    has_written_ = written.has_value();
    has_failed_ = !written && written.error().code != Error::Code::kEmpty;
    if (written) {
      say(fmt::format("session written: {}\nas a mesh again: kerf export {} -o OUT.stl", folder.string(),
                      folder.string()));
      for (std::size_t n = 0; n < written->beside.size(); ++n)
        if (const RunManifest::Beside& other = written->beside[n]; other.removed_mm3 > 0)
          say(fmt::format("{:.4f} mm3 were cut off the neighbour {}: kerf export {} --beside {} -o OUT.stl",
                          other.removed_mm3, other.name, folder.string(), n + 1));
    } else if (written.error().code != Error::Code::kEmpty)
      complain(written.error());
  };
  job_ = std::move(job);
}

// ---- By mouse

std::optional<Ray> Workbench::behindSection(const Ray& ray) const {
  if (!section || section->height(ray.origin) <= 0) return ray;
  const double falls = -section->normal.dot(ray.direction);
  if (falls < 1e-6) return {};  // it never comes out
  const Ray out{ray.at(section->height(ray.origin) / falls), ray.direction};

  for (const SceneObject* object : scene_.shown()) {
    if (object->is_hidden) continue;
    // As often as a surface turns towards the ray it turns away again, unless it begins inside.
    const Ray local = inFrame(object->pose(), out);
    const auto in = object->surface.hit(local);
    const auto leaves = object->surface.exit(local, 0);
    if (leaves && (!in || *leaves < in->way)) return {};
  }
  return out;
}

std::optional<ToolOverSurface> Workbench::over(const Ray& ray) const {
  if (!run_) return {};
  const auto seen = behindSection(ray);
  if (!seen) return {};
  if (saw_->isGuiding()) return saw_->over(*seen);
  auto at = toolOver(scene_, *run_->original(), *seen, plunges_[tool_]);
  if (at) tiltTool(*at, tilt, touches_[tool_]);
  return at;
}

bool Workbench::press(const Ray& ray) {
  if (import_ || saw_->isCutting() || undos_left_ != 0 || wish_) return false;  // a session behind an import rests
  if (isLed()) {
    warnThatItIsLed();
    return false;
  }
  const auto at = over(ray);
  if (!at) {
    const auto seen = behindSection(ray);
    if (const auto hit = seen ? scene_.hit(*seen) : std::nullopt) (void)isNeighbour(hit->id, "to be cut");
    return false;
  }
  release();
  pointed_ = ray;
  // A mouse is no arm that could be struck: after a late clock it goes on at once.
  if (report_.is_latched) send(ClearLatch{});
  const bool is_guided = saw_->isGuiding();
  aim_.guide = is_guided ? saw_->plan().chosen()->normal : Vec3d(Vec3d::Zero());
  stroke_.emplace(*run_->original(), *at, heads_[tool_]);
  stroke_->begin(aim_);
  aim_.samples = structures_->isEmpty() && neighbour_fields_.empty() ? nullptr : &samplesOf(tool_);
  sendAim();

  const Rigid3& start = stroke_->start();
  const Eigen::Quaterniond& q = start.rotation;
  send(PlaceTool{{start.translation[0], start.translation[1], start.translation[2]}, {q.w(), q.x(), q.y(), q.z()}});
  return true;
}

bool Workbench::send(const Command& command) {
  if (!run_->send(command)) return false;
  ++sent_;
  return true;
}

void Workbench::drag(const Ray& ray) {
  if (!stroke_) return;
  pointed_ = ray;
  aim_.pointer = stroke_->pointerOf(ray);
  sendAim();
}

void Workbench::deepen(double mm) {
  depth_mm = std::clamp(depth_mm + mm, 0.0, mostDepth());
  along_.reset();
  if (stroke_) sendAim();
}

double Workbench::mostDepth() const { return saw_->isGuiding() ? saw_->plan().chosen()->depth : kMostDepth; }

void Workbench::setForce(double newtons) {
  force = std::clamp(newtons, kLeastForce, kMostForce);
  if (stroke_) sendAim();
}

void Workbench::pushHarder(double factor) {
  push_factor_ = factor;
  if (stroke_) sendAim();
}

void Workbench::release() {
  if (!stroke_) return;
  stroke_.reset();
  along_.reset();
  is_on_pedal_ = false;
  drill_ = 1;
  aim_.is_pressed = false;
  sendAim();
}

void Workbench::sendAim() {
  aim_.force = std::min(force * push_factor_, kMostForce);
  aim_.depth = std::min({depth_mm, mostDepth(), along_.value_or(depth_mm)});
  aim_.pedal = (is_reversed_ ? -1 : 1) * speed * drill_;
  aim_.irrigation = irrigation;
  aim_.keep = stop_short_mm.value_or(-1);
  aim_.keep_beside = stop_short_beside_mm.value_or(-1);
  hand_->aim(aim_);
}

std::optional<double> Workbench::depthNow() const {
  if (!stroke_) return {};
  return stroke_->depthOf(report_.output.T_world_tool.translation);
}

void Workbench::stopShort(std::optional<double> mm) {
  stop_short_mm = mm;
  if (stroke_) sendAim();
}

// From now on the report tells how warm it makes what it cuts.
void Workbench::heatByToolInHand() { run_->thread().heatBy(tool_, samplesOf(tool_), heatSource(tool(tool_))); }

const ToolSamples& Workbench::samplesOf(std::size_t tool) const {
  const auto known = samples_.find(tool);
  if (known != samples_.end()) return known->second;
  return samples_.emplace(tool, ToolSamples(run_->model().tools[tool].cut, kToolSamples)).first->second;
}

std::optional<NearStructure> Workbench::nearStructure(const std::optional<ToolOverSurface>& over) const {
  constexpr double kStopped = 0.03;  // mm: as near as a held button comes to its limit
  if (!run_ || structures_->isEmpty() || (!stroke_ && !over && !isLed())) return {};
  const Rigid3 tool = stroke_ || isLed() ? report_.output.T_world_tool : over->T_world_tool;
  const Rigid3 object = stroke_   ? aim_.T_world_surface
                        : isLed() ? report_.objects[0].T_world_object
                                  : over->T_world_object;
  const Structures::Nearest nearest = structures_->nearest(samplesOf(tool_), object.inverse() * tool);

  NearStructure out;
  out.name = nameOf(structures_->all()[nearest.structure].material);
  out.distance_mm = nearest.reading.distance;
  out.is_far = nearest.reading.is_far;
  out.is_stopped = stroke_ && stop_short_mm && !out.is_far && out.distance_mm <= *stop_short_mm + kStopped;
  return out;
}

void Workbench::undo() {
  if (!run_) return;
  if (saw_->isCutting()) return saw_->stopAndUndo();
  release();
  // What was cut since the last report is a stroke that the timeline does not know yet.
  const std::size_t done = stepsDone(), strokes = strokesDone();
  undoOrRedo(done > 0 ? -static_cast<std::ptrdiff_t>(strokes - timeline_.strokesAt(done - 1)) : -1);
}

void Workbench::redo() {
  if (!run_) return;
  if (isSawing()) return;
  release();
  const std::size_t done = stepsDone(), strokes = strokesDone();
  const bool is_known = done < timeline_.steps().size();
  undoOrRedo(is_known ? static_cast<std::ptrdiff_t>(timeline_.strokesAt(done + 1) - strokes) : 1);
}

Expected<void> Workbench::goToStep(std::uint64_t step) {
  if (!run_) return fail({.code = Error::Code::kEmpty, .found = "nothing is open", .hint = "open a scan first"});
  KERF_TRY(strokes, timeline_.strokesAfter(step));
  if (saw_->isCutting())
    return fail({.code = Error::Code::kUnsupported,
                 .found = "a plane is being sawn",
                 .expected = "a tool at rest",
                 .hint = "wait for it, or stop it (saw.stop)"});
  // A stroke or a move that is on its way to the simulation is a step that nobody has counted yet.
  const bool is_counted = !stroke_ && !wish_ && (answered() >= sent_ || undos_answered_at_ == sent_);
  release();
  if (is_counted) {
    undoOrRedo(static_cast<std::ptrdiff_t>(strokes) - static_cast<std::ptrdiff_t>(strokesDone()));
    return {};
  }
  constexpr std::uint64_t kTicks = 5;  // until a stroke that is let go of has ended
  (void)run_->thread().update();
  wish_ = Wish{step, run_->thread().report().tick + kTicks};
  return {};
}

void Workbench::goWhereWished() {
  if (!wish_ || undos_left_ != 0 || answered() < sent_ || report_.tick < wish_->tick) return;
  const std::uint64_t step = std::exchange(wish_, std::nullopt)->step;
  if (const auto gone = goToStep(step); !gone) complain(gone.error());
}

std::size_t Workbench::stepsDone() const { return timeline_.doneAt(strokesDone()); }

// As far as is known: when all that was asked for is done.
std::size_t Workbench::strokesDone() const {
  const bool is_over = undos_left_ == 0 && answered() >= undos_answered_at_;
  return is_over ? timeline_.strokesDone() : static_cast<std::size_t>(std::max<std::ptrdiff_t>(strokes_then_, 0));
}

void Workbench::undoOrRedo(std::ptrdiff_t strokes) {
  if (strokes == 0) return;
  strokes_then_ = static_cast<std::ptrdiff_t>(strokesDone()) + strokes;
  undos_left_ += strokes;
  sendUndos();
}

// So many at a time that the queue has places left for other commands.
void Workbench::sendUndos() {
  constexpr std::uint64_t kMost = HapticThread::kMostCommands / 2;
  while (undos_left_ != 0 && sent_ < answered() + kMost) {
    const bool is_undo = undos_left_ < 0;
    if (!send(is_undo ? Command(Undo{}) : Command(Redo{}))) return;
    undos_left_ += is_undo ? 1 : -1;
    undos_answered_at_ = sent_;
  }
}

// ---- Pieces

const SceneObject* Workbench::chosenPiece() const { return chosen_ ? scene_.find(*chosen_) : nullptr; }

void Workbench::movePiece(std::uint32_t id, const Rigid3& T_world_object) {
  SceneObject* const piece = scene_.find(id);
  if (!piece || !piece->is_in_scene || isNeighbour(id, "to be moved")) return;
  if (!T_world_object.isUsable())
    return complain({.code = Error::Code::kBadValue,
                     .place = piece->name,
                     .found = "a place that can not be computed with",
                     .expected = "less than 100 m away"});
  if (isSawing() || undos_left_ != 0 || wish_) return dragPiece(id, std::nullopt);
  release();
  const Vec3d& t = T_world_object.translation;
  const Eigen::Quaterniond& q = T_world_object.rotation;
  piece->dragged = T_world_object;
  const bool is_sent = send(MoveObject{piece->index, {t[0], t[1], t[2]}, {q.w(), q.x(), q.y(), q.z()}});
  moving_.push_back({id, is_sent ? sent_ : 0});
}

void Workbench::dragPiece(std::uint32_t id, const std::optional<Rigid3>& T_world_object) {
  if (SceneObject* const piece = scene_.find(id)) piece->dragged = T_world_object;
}

void Workbench::hidePiece(std::uint32_t id, bool is_hidden) {
  if (SceneObject* const piece = scene_.find(id)) piece->is_hidden = is_hidden;
}

void Workbench::namePiece(std::uint32_t id, const std::string& name) {
  SceneObject* const piece = scene_.find(id);
  if (!piece || name.empty() || name == piece->name || isNeighbour(id, "to be renamed")) return;
  const bool is_number = std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
  const auto has = [&](const SceneObject* other) { return other != piece && other->name == name; };
  const bool is_taken = std::any_of(scene_.shown().begin(), scene_.shown().end(), has);
  if (is_number || is_taken)
    return complain({.code = Error::Code::kBadValue,
                     .place = piece->name,
                     .found = fmt::format("\"{}\"{}", name, is_taken ? ", which another piece is called" : ""),
                     .expected = "a name of its own, not a number"});
  piece->name = name;
  run_->namePiece(id, name);
}

// ---- Results

void Workbench::exportTo(const fs::path& file, const ExportChoice& choice) {
  if (isBusy()) return;
  if (!run_) return complain({.code = Error::Code::kEmpty, .found = "nothing is open", .hint = "open a scan first"});
  if (const auto possible = canWriteMesh(file); !possible) return complain(possible.error());

  std::error_code ignored;
  const auto isSource = [&](const fs::path& source) { return fs::equivalent(file, source, ignored); };
  if (isSource(source_) || std::any_of(sources_beside_.begin(), sources_beside_.end(), isSource))
    return complain({.code = Error::Code::kBadValue,
                     .file = file.string(),
                     .found = "the file that was opened",
                     .expected = "another one: a scan is never written over",
                     .hint = "another name"});
  if (isSawing()) return;
  release();
  namePieces();

  // The job works on a copy: the cut may go on.
  job_writes_ = true;
  handover_.emplace();
  handover_->sent = sent_;
  auto scene = std::make_shared<std::future<SceneView>>(handover_->scene.get_future());
  const LiveRun* const run = run_.get();
  auto job = std::make_unique<Job<std::string>>("exporting " + file.filename().string(),
                                                [run, scene, file, choice](const Progress& progress) {
                                                  return exportWhenGiven(*run, *scene, file, choice, progress);
                                                });
  when_over_ = [this, job = job.get()] {
    auto written = job->take();
    written ? say(std::move(*written)) : complain(written.error());
  };
  job_ = std::move(job);
}

// ---- After a crash

void Workbench::findLostSessions() {
  lost_.clear();
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(options_.data_folder / "sessions", failed)) {
    const auto manifest = readRunManifest(entry.path());
    if (!manifest || !manifest->is_open || !RunLock::take(entry.path())) continue;
    lost_.push_back({entry.path(), fs::path(manifest->case_path).stem().string()});
  }
  const auto timeOf = [](const LostSession& lost) {
    std::error_code none;
    return fs::last_write_time(lost.folder / "session.kerflog", none);
  };
  std::sort(lost_.begin(), lost_.end(),
            [&](const LostSession& a, const LostSession& b) { return timeOf(a) > timeOf(b); });
}

void Workbench::recover(std::size_t n) {
  if (isBusy() || n >= lost_.size()) return;
  job_writes_ = true;
  const fs::path folder = lost_[n].folder;
  auto job =
      std::make_unique<Job<Recovery>>("recovering " + folder.filename().string(),
                                      [folder](const Progress& progress) { return recoverRun(folder, progress); });
  when_over_ = [this, job = job.get(), folder] {
    auto recovered = job->take();
    if (recovered) {
      const Replay& replay = recovered->replay;
      const bool differs = !replay.is_same && replay.checks > 0;
      notices_.push_back({differs, fmt::format("recovered {:.1f} s, {:.3f} mm3 removed: {}\n{}{}",
                                               recovered->manifest.duration_s, replay.removed_mm3, folder.string(),
                                               replay.note, differs ? "; it DIFFERS from what was recorded" : "")});
    } else if (recovered.error().code == Error::Code::kEmpty) {
      // A session without a cut is none: its folder holds nothing that anybody made.
      std::error_code ignored;
      fs::remove_all(folder, ignored);
      say("nothing had been cut in that session");
    } else {
      complain(recovered.error());
    }
    findLostSessions();
  };
  job_ = std::move(job);
}

}  // namespace kerf
