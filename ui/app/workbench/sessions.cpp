#include "ui/app/workbench/sessions.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>

#include "sim/run/files/run_files.h"
#include "sim/run/files/run_manifest.h"
#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/file_history.h"
#include "ui/app/document/view_state.h"
#include "ui/app/import/session_file.h"
#include "ui/app/import/session_list.h"
#include "ui/app/session/arm_lead.h"
#include "ui/app/session/session_result.h"
#include "ui/app/workbench/force_device.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/replays.h"
#include "ui/app/workbench/results.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tools.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

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

// Deletes a session without steps. Its undone steps become separate runs first.
// @param dropped  its undone steps: BranchPoint::step_began.
EndedSession endSession(LiveRun& run, const std::vector<std::uint64_t>& dropped, const fs::path& data_folder,
                        const std::string& name) {
  EndedSession out{.run = run.finish(!dropped.empty())};
  const bool is_empty = !out.run && out.run.error().code == Error::Code::kEmpty;
  if (!is_empty || dropped.empty()) return out;

  DroppedRuns kept = keepDropped(run.folder(), dropped, data_folder, name);
  out.saved = std::move(kept.runs);
  out.failed = std::move(kept.failed);
  return out;
}

}  // namespace

struct Sessions::Kept {
  fs::path case_or_run, session;  // to open again: without a cut, and with cuts
  fs::path source, tool;
  std::string name;
  std::vector<fs::path> sources_beside;
  std::vector<CaseBeside> beside;    // do not come back with `case_or_run`
  std::vector<std::string> without;  // nor do these
  SawPlan plan;
  TissueChoices tissues;
  bool is_unexported = false;
  Reopening wanted;
};

// ---- Opening

void Sessions::open(const fs::path& path) {
  if (kindOf(path) == FileKind::kTool) return bench_.tools->add(path);
  openBy(phrase("opening {}", path.filename().string()),
         [path, options = openingOptions()](const Progress& progress) { return openToCut(path, options, progress); });
}

void Sessions::openDemo(const std::string& name) {
  openBy(phrase("opening the demo {}", shownText(name)), [name, options = openingOptions()](const Progress& progress) {
    return openDemoToCut(name, options, progress);
  });
}

void Sessions::startOver(const fs::path& run_folder) {
  const auto load = [run_folder, options = openingOptions()](const Progress& progress) -> Expected<Opened> {
    KERF_TRY(manifest, readRunManifest(run_folder));
    KERF_TRY(case_folder, caseOfRun(run_folder));
    KERF_TRY(others, casesBesideRun(run_folder));
    OpeningOptions with_others = options;
    for (std::size_t n = 0; n < others.size(); ++n)
      with_others.beside.push_back({others[n], manifest.beside[n].name, {}});
    KERF_TRY(opened, openToCut(case_folder, with_others, progress));
    opened.name = sessionTitle(run_folder);
    return std::move(opened);
  };
  openBy(phrase("starting over: {}", sessionTitle(run_folder)), load);
}

void Sessions::openAll(const std::vector<fs::path>& paths) {
  const std::vector<fs::path> objects = bench_.imports->takeTools(paths);
  if (objects.empty()) return;
  if (objects.size() == 1) return bench_.imports->begin(objects.front());

  OpeningOptions options = openingOptions();
  std::string names;
  for (std::size_t n = 1; n < objects.size(); ++n) {
    options.beside.push_back({objects[n], {}, options.prepare});
    names += (n > 1 ? ", " : "") + objects[n].filename().string();
  }
  const fs::path first = objects.front();
  openBy(phrase("opening {} with neighbour {}", first.filename().string(), names),
         [first, options](const Progress& progress) -> Expected<Opened> {
           KERF_TRY(opened, openToCut(first, options, progress));
           opened.notes.insert(opened.notes.begin(),
                               phrase("You cut {}. Switch to a neighbour with neighbour.work-on.", opened.name));
           return std::move(opened);
         });
}

void Sessions::prepareFiner(double voxel_mm) {
  if (!bench_.tools->finerVoxels()) return;
  OpeningOptions options = openingOptions();
  options.prepare = *bench_.document->prepared();
  options.prepare.voxel_mm = voxel_mm;
  const fs::path tool = bench_.document->run()->tools()[bench_.tools->inHand()].file;
  openBy(phrase("preparing {} with voxels of {:g} mm", bench_.document->source().filename().string(), voxel_mm),
         [source = bench_.document->source(), options, tool](const Progress& progress) -> Expected<Opened> {
           KERF_TRY(opened, openToCut(source, options, progress));
           opened.tool = tool;
           return std::move(opened);
         });
}

OpeningOptions Sessions::openingOptions() const {
  const WorkbenchOptions& options = bench_.options();
  OpeningOptions out{options.data_folder,
                     {options.unit, options.voxel_mm, {}},
                     bench_.tools->forSession(),
                     options.real_time,
                     bench_.device->arm().coupling()};
  out.coming_tools = bench_.tools->coming();
  return out;
}

void Sessions::openBranch(const Branch& branch) { openBranch(branch, nullptr); }

void Sessions::openBranch(const Branch& branch, std::shared_ptr<const Kept> kept) {
  const bool is_end = !branch.point.sample && !branch.point.step_began;
  const auto load = [branch, is_end, options = openingOptions()](const Progress& progress) {
    return is_end ? openToCut(branch.run, options, progress)
                  : openBranchToCut(branch.run, branch.point, options, progress);
  };
  openBy(phrase("continuing: {}", branch.text), load, std::move(kept));
}

void Sessions::openBy(const std::string& title, Load load) { openBy(title, std::move(load), nullptr); }

void Sessions::openBy(const std::string& title, Load load, std::shared_ptr<const Kept> kept) {
  if (bench_.jobs->isBusy()) return;
  const auto take = [this, kept](Expected<Opened> loaded) {
    if (!loaded) return bench_.notices->complain(loaded.error());
    const auto next = std::make_shared<Opened>(std::move(*loaded));
    // Writes the previous session only once its replacement is loaded.
    afterClose([this, next, kept] { show(*next, kept.get()); });
  };
  bench_.jobs->start<Opened>(Jobs::Kind::kReads, title, std::move(load), take);
}

void Sessions::afterClose(std::function<void()> next) {
  if (!bench_.document->isOpen()) return next();
  close();
  bench_.jobs->then(std::move(next));
}

void Sessions::show(Opened& loaded, const Kept* kept) {
  bench_.tools->takeRack(true);  // its tools are ready: the loading job waited for them
  const CouplingSettings& coupling = loaded.run->model().settings.coupling;
  Hands hands;
  hands.mouse =
      std::make_unique<MouseHand>(loaded.run->original(), loaded.run->thread().session().state().body.pose, coupling);
  hands.leading = std::make_shared<HandSwitch>(*hands.mouse);
  hands.guided = std::make_unique<GuidedHand>(*hands.leading, coupling.stiffness, coupling.turn_stiffness);
  hands.mouse->keepAwayFrom(loaded.structures);
  hands.mouse->keepAwayFromBeside(loaded.neighbours);
  if (const auto started = loaded.run->start(*hands.guided); !started) {
    (void)loaded.run->finish();
    return bench_.notices->complain(started.error());
  }

  bench_.imports->putAway();
  debrief_.reset();
  if (bench_.document->watched()) bench_.closing();
  if (kept) {
    loaded.source = kept->source;
    loaded.name = kept->name;
    loaded.sources_beside = kept->sources_beside;
  }
  const std::vector<std::string> notes = std::move(loaded.notes);
  const fs::path tool = loaded.tool;
  const Opening how = kept ? Opening::kReopened : Opening::kNew;
  bench_.document->open(std::move(loaded), std::move(hands), how);
  const LiveRun& run = *bench_.document->run();
  for (const std::string& name : run.missingPieces())
    bench_.notices->say(phrase("Piece not found; it stays at its scan position: {}", name));
  constexpr double kWorthSaying = 0.01;  // mm^3
  if (run.addedBefore() > kWorthSaying)
    bench_.notices->say(
        phrase("WARNING: {:.2f} mm3 of added material now count as the tissue around them. The run is from an older "
               "Kerf, which did not save the material.",
               run.addedBefore()));
  if (!kept) saved_as_ = isSessionFile(bench_.document->source()) ? bench_.document->source() : fs::path();
  bench_.opened(how);
  for (const std::string& note : notes) bench_.notices->say(note);
  if (!tool.empty()) bench_.tools->selectFile(tool);
  if (kept)
    restore(*kept);
  else
    bench_.history->remember(bench_.document->source());
}

void Sessions::restore(const Kept& kept) {
  if (kept.wanted.branch) bench_.steps->continuesBranch(kept.wanted.branch->text);
  if (kept.is_unexported) bench_.results->markUnexported();
  bench_.views->tissues().choose(kept.tissues);
  bench_.saw->plan() = kept.plan;
  bench_.tools->selectFile(kept.tool);
}

void Sessions::reopen(Reopening wanted) {
  const LiveRun* const run = bench_.document->run();
  if (!run || bench_.jobs->isBusy()) return;
  const Document& document = *bench_.document;
  const auto kept = std::make_shared<Kept>();
  kept->case_or_run = run->from().empty() ? run->caseFolder() : run->from();
  kept->session = document.sessionFolder();
  kept->source = document.source();
  kept->tool = wanted.tool.empty() ? run->tools()[bench_.tools->inHand()].file : wanted.tool;
  kept->name = document.name();
  kept->sources_beside = document.sourcesBeside();
  for (const fs::path& file : wanted.further_sources) kept->sources_beside.push_back(file);
  for (const CaseBeside& other : wanted.further) kept->sources_beside.push_back(other.folder);
  for (const LiveNeighbour& other : run->neighbours())
    if (!other.known.has_begin && other.known.manifest.id != wanted.without)
      kept->beside.push_back({other.known.folder, other.known.name});
  kept->without = run->without();
  if (!wanted.without.empty()) kept->without.push_back(wanted.without);
  kept->plan = bench_.saw->plan();
  kept->tissues = bench_.views->tissues().choices();
  kept->is_unexported = bench_.results->hasUnexportedCut() || wanted.branch;
  kept->wanted = std::move(wanted);

  endRun(kept->wanted.branch.has_value(), kept->wanted.branch ? Tells::kAll : Tells::kFaults);
  bench_.jobs->then([this, kept] {
    if (has_failed_) return;  // the log holds the cuts: opens nothing over it
    if (kept->wanted.branch) {
      const Branch& branch = *kept->wanted.branch;
      return openBranch(has_written_ ? branch : bench_.steps->savedOf(branch, kept->session), kept);
    }
    OpeningOptions options = openingOptions();
    std::vector<CaseBeside> beside = has_written_ ? std::vector<CaseBeside>{} : kept->beside;
    beside.insert(beside.end(), kept->wanted.further.begin(), kept->wanted.further.end());
    for (const CaseBeside& other : beside) options.beside.push_back({other.folder, other.name, {}});
    options.without = kept->without;
    const auto load = [next = has_written_ ? kept->session : kept->case_or_run, options](const Progress& progress) {
      return openToCut(next, options, progress);
    };
    const bool is_neighbour = !kept->wanted.further.empty() || !kept->wanted.without.empty();
    openBy(is_neighbour ? "placing neighbours" : "loading the tool", load, kept);
  });
}

// ---- Saving and ending

void Sessions::saveAs(const fs::path& path) {
  if (bench_.jobs->isBusy() || !bench_.document->isOpen()) return;
  fs::path file = path;
  std::error_code ignored;
  if (file.extension() != ".kerf") {
    file += ".kerf";
    // The dialog asked about another name.
    if (file != saved_as_ && fs::exists(file, ignored))
      return bench_.notices->complain({.code = Error::Code::kBadValue,
                                       .file = file.string(),
                                       .found = "the file exists already",
                                       .expected = "a new name",
                                       .hint = "type the whole name to replace it"});
  }
  if (const auto& sources = bench_.document->sourcesBeside();
      std::find(sources.begin(), sources.end(), file) != sources.end())
    return bench_.notices->complain({.code = Error::Code::kBadValue,
                                     .file = file.string(),
                                     .found = "the file of a neighbour",
                                     .expected = "another name"});
  const LiveRun& run = *bench_.document->run();
  auto work = [file, live = run.folder(), from = run.from(),
               data = bench_.options().data_folder](const Progress& progress) -> Expected<void> {
    std::this_thread::sleep_for(4 * RecorderOptions{}.write_every);  // the last samples are in the log
    return saveSession(live, from, data, file, progress);
  };
  const auto take = [this, file, generation = bench_.document->generation()](Expected<void> saved) {
    if (!saved) return bench_.notices->complain(saved.error());
    if (bench_.document->generation() == generation) saved_as_ = file;
    bench_.notices->say(phrase("Session saved as one file: {}", file.string()));
  };
  bench_.jobs->start<void>(Jobs::Kind::kWrites, phrase("saving {}", file.filename().string()), std::move(work), take);
}

void Sessions::close() { endRun(false, Tells::kAll); }

// @param keeps_ahead  also keeps the undone steps ahead if the session holds no other steps.
void Sessions::endRun(bool keeps_ahead, Tells tells) {
  if (bench_.jobs->isBusy() || !bench_.document->isOpen()) return;
  has_written_ = has_failed_ = false;
  bench_.strokes->release();
  const std::vector<std::uint64_t> dropped = bench_.steps->droppedSteps(keeps_ahead);
  const std::ptrdiff_t left = bench_.steps->undosLeft();
  bench_.closing();
  const auto ending = std::make_shared<EndingRun>(bench_.document->end());
  const fs::path folder = ending->folder;
  const std::string title = phrase("writing the session of {}", ending->name);
  auto work = [ending, left, dropped, data = bench_.options().data_folder](const Progress&) -> Expected<EndedSession> {
    sendTheRest(*ending->run, left, ending->sent);
    EndedSession out = endSession(*ending->run, dropped, data, ending->name);
    if (out.run)
      if (auto report = readRunReport(ending->folder)) out.report = std::move(*report);
    return out;
  };
  const auto take = [this, folder, tells](Expected<EndedSession> ended) { takeEnded(std::move(ended), folder, tells); };
  constexpr bool kCanBeCancelled = false;
  bench_.jobs->start<EndedSession>(Jobs::Kind::kWrites, title, std::move(work), take, kCanBeCancelled);
}

void Sessions::takeEnded(Expected<EndedSession> ended, const fs::path& folder, Tells tells) {
  has_failed_ = !ended || ended->hasFailed();
  has_written_ = ended && ended->isWritten();
  if (!ended) return bench_.notices->complain(ended.error());
  if (ended->failed) bench_.notices->complain(*ended->failed);
  bench_.steps->sessionEnded(*ended, folder);
  if (has_written_) bench_.history->sessionWritten(folder);
  last_result_ = ended->report;
  if (ended->run && tells == Tells::kAll) tellEnd(*ended, folder);
  if (!ended->run && ended->run.error().code != Error::Code::kEmpty) bench_.notices->complain(ended->run.error());
}

void Sessions::tellEnd(const EndedSession& ended, const fs::path& folder) {
  const std::string numbers = ended.report ? resultText(*ended.report, bench_.document->materials()) : "";
  debrief_ = Debrief{numbers, folder};
  bench_.notices->say(numbers + phrase("Session saved: {}", folder.string()));
  for (const RunManifest::Beside& other : ended.run->beside)
    if (other.removed_mm3 > 0)
      bench_.notices->say(phrase("{:.4f} mm3 removed from the neighbour {}", other.removed_mm3, other.name));
}

void Sessions::endNow() {
  if (!bench_.document->isOpen()) return;
  const std::vector<std::uint64_t> dropped = bench_.steps->droppedSteps(false);
  const std::ptrdiff_t left = bench_.steps->undosLeft();
  bench_.closing();
  const EndingRun ending = bench_.document->end();
  sendTheRest(*ending.run, left, ending.sent);
  if (endSession(*ending.run, dropped, bench_.options().data_folder, ending.name).isWritten())
    bench_.history->sessionWritten(ending.folder);
}

}  // namespace kerf
