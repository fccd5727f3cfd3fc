#include "ui/app/workbench/workbench.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include "sim/run/session/watched_run.h"
#include "ui/app/base/language.h"
#include "ui/app/base/user_files.h"
#include "ui/app/import/import_set.h"
#include "ui/app/session/arm_lead.h"
#include "ui/app/session/session_result.h"
#include "ui/app/view/tissue_display.h"
#include "ui/app/workbench/export_plan.h"
#include "ui/app/workbench/sawing.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

fs::path dataFolderOf(const WorkbenchOptions& options) {
  return options.data_folder.empty() ? userDataFolder() : options.data_folder;
}

// Before a session ends: sends pending undo or redo and waits for all answers, a minute at most.
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
      saw_(std::make_unique<Sawing>(*this)),
      exporting_(std::make_unique<ExportPlan>(*this)) {
  options_.data_folder = dataFolderOf(options_);
  readTools();
  if (auto materials = readDefaultMaterials())
    materials_ = std::move(*materials);
  else
    complain(materials.error());
  lost_ = findLostSessions(options_.data_folder);
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
  const std::vector<std::uint64_t> dropped = droppedSteps(false);
  sendTheRest(*run_, undos_left_, sent_);
  (void)endSession(*run_, dropped, options_.data_folder, name_);
}

std::string Workbench::nameOf(Material material) const {
  const MaterialProperties* const known = materials_.find(material);
  return known ? known->name : fmt::format("material {}", static_cast<int>(material));
}

// ---- Once a frame

std::vector<ObjectChunks> Workbench::update() {
  takeRack(false);
  if (job_ && job_->isOver()) {
    const auto over = std::move(job_);  // the next lines may start another job
    const auto done = std::exchange(when_over_, {});
    if (done) done();
  }
  if (import_ && !job_) import_->update();
  takeNews();
  if (!run_) (void)arm_->update(report_, false);  // its panel shows it
  handOverScene();
  if (const auto done = tissues_->update(); !done) complain(done.error());
  saw_->update();
  exporting_->update();
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
    const bool cuts_by_hand = isLed() && std::abs(report_.output.speed) > 0;
    hindrance_.update(report_, stroke_ || saw_->isCutting() || cuts_by_hand, driveShare());
    warnOfHeat();
  }
  loop_rate_.add(report_.counts.ticks, LoopRate::Clock::now());
  timeline_.update(report_.undo);
  goWhereWished();
  sendUndos();
  followDevice();
  if (run_->thread().updateTimes()) times_ = run_->thread().times();
  const auto chunks = run_->takeChunks();
  scene_.update(chunks, report_);
  // A moved piece takes its pose from the simulation once that has answered.
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

// Warns once each: a notice does not interrupt.
void Workbench::warnOfHeat() {
  const HeatAlarms& alarms = report_.heat.alarms;
  if (alarms.pulp >= 0 && !std::exchange(has_told_of_pulp_, true))
    say(
        phrase("The pulp is {:.1f} C warmer than the body: not every pulp recovers from that (Zach & Cohen 1965). "
               "More spray, less force, or a pause.",
               kPulpLimitRise));
  if (alarms.bone_warm >= 0 && !std::exchange(has_told_of_bone_, true))
    say(
        phrase("The bone under the tool has {:.0f} C: after a minute it dies (Eriksson & Albrektsson). More spray, "
               "less force, or a pause.",
               kBodyCelsius + kBoneLimitRise));
  if (alarms.bone_dead >= 0 && !std::exchange(has_told_of_dead_bone_, true))
    say(phrase("Bone half a millimetre beside the cut had {:.0f} C or more for {:.0f} s together: it would die.",
               kBodyCelsius + kBoneLimitRise, kBoneLimitSeconds));
}

double Workbench::removedOf(Material material) const {
  const auto number = static_cast<std::size_t>(material);
  return isShown() && number < report_.removed_by_material.size() ? report_.removed_by_material[number] : 0;
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
  openBy(phrase("opening {}", path.filename().string()),
         [path, options = openingOptions()](const Progress& progress) { return openToCut(path, options, progress); });
}

void Workbench::openDemo(const std::string& name) {
  openBy(phrase("opening the demo {}", shownText(name)), [name, options = openingOptions()](const Progress& progress) {
    return openDemoToCut(name, options, progress);
  });
}

OpeningOptions Workbench::openingOptions() const {
  OpeningOptions out{
      options_.data_folder, {options_.unit, options_.voxel_mm, {}}, tools_, options_.real_time, arm_->coupling()};
  out.coming_tools = coming_tools_;
  return out;
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

    // Writes the previous session only once its replacement is loaded.
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
  takeRack(true);  // the rack's tools are ready: its job waited for them
  const CouplingSettings& coupling = loaded.run->model().settings.coupling;
  auto hand =
      std::make_unique<MouseHand>(loaded.run->original(), loaded.run->thread().session().state().body.pose, coupling);
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
  tissues_->closing();  // before its sources are gone
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
  times_ = {};
  loop_rate_.clear();
  exported_.reset();
  has_unexported_before_ = is_reopening_ && has_unexported_before_;
  if (!is_reopening_) left_.clear();
  opened_.reset();
  timeline_.clear();
  trace_.clear();
  hindrance_ = {};
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
    tilt = {};  // the tilt belonged to the other scan
    speed = 1;
    told_thin_.clear();
  }
  moving_.clear();
  scene_.setLabels(run_->labels());
  for (const std::string& name : run_->missingPieces())
    say(phrase("not found again, and so where it was in the scan: {}", name));
  constexpr double kWorthSaying = 0.01;  // mm^3
  if (run_->addedBefore() > kWorthSaying)
    say(
        phrase("WARNING: {:.2f} mm3 that were added before count and cut as the tissue around them from here on: the "
               "run is of an older Kerf, which did not keep their material",
               run_->addedBefore()));
  removed_mm3_ = 0;
  saw_->opened();
  heatByToolInHand();
  warnOfThinTool();
  ++generation_;
  keeps_view_ = is_reopening_;
  std::fill(is_outdated_.begin(), is_outdated_.end(), 0);
  for (std::string& note : loaded.notes) say(std::move(note));
  if (!is_reopening_) remember(source_);
}

void Workbench::close() { endRun(false); }

// @param keeps_ahead  also keeps the undone steps ahead if the session holds no other steps.
void Workbench::endRun(bool keeps_ahead) {
  if (isBusy() || !run_) return;
  release();
  const std::vector<std::uint64_t> dropped = droppedSteps(keeps_ahead);
  leaveBranches();
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
  auto job = std::make_unique<Job<EndedSession>>(
      phrase("writing the session of {}", name),
      [ending, guided, hands, hand, left = std::exchange(undos_left_, 0), sent = sent_, dropped,
       data = options_.data_folder, name](const Progress&) {
        sendTheRest(*ending, left, sent);
        EndedSession out = endSession(*ending, dropped, data, name);
        if (auto report = out.run ? readRunReport(ending->folder()) : fail({})) out.report = std::move(*report);
        return out;
      },
      false);
  job_writes_ = true;
  when_over_ = [this, job = job.get(), folder = session_] {
    auto ended = job->take();
    if (!ended) {
      has_written_ = false;
      has_failed_ = true;
      return complain(ended.error());
    }
    takeEnded(*ended, folder);
    const Expected<RunManifest>& written = ended->run;
    last_result_ = ended->report;
    if (written) {
      say((last_result_ ? resultText(*last_result_, materials_) : "") +
          phrase("session written: {}\nas a mesh again: kerf export {} -o OUT.stl", folder.string(), folder.string()));
      for (std::size_t n = 0; n < written->beside.size(); ++n)
        if (const RunManifest::Beside& other = written->beside[n]; other.removed_mm3 > 0)
          say(phrase("{:.4f} mm3 were cut off the neighbour {}: kerf export {} --beside {} -o OUT.stl",
                     other.removed_mm3, other.name, folder.string(), n + 1));
    } else if (written.error().code != Error::Code::kEmpty)
      complain(written.error());
  };
  job_ = std::move(job);
}

}  // namespace kerf
