#include "ui/app/script/app_script.h"

#include <fmt/format.h>

#include <malloc.h>
#include <unistd.h>

#include <cctype>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <thread>

#include "geometry/base/text.h"
#include "sim/run/session/watched_run.h"
#include "ui/app/base/command_words.h"
#include "ui/app/commands/device_commands.h"
#include "ui/app/commands/import_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/document/view_state.h"
#include "ui/app/readout/point_readout.h"
#include "ui/app/session/arm_lead.h"
#include "ui/app/session/session_result.h"
#include "ui/app/view/tissue_display.h"
#include "ui/app/workbench/drilling.h"
#include "ui/app/workbench/export_plan.h"
#include "ui/app/workbench/force_device.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/replays.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tool_monitor.h"
#include "ui/app/workbench/tools.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

// Runs a frame. False if the program must end.
bool goesOn(const AppContext& c, const std::function<void()>& frame) {
  frame();
  std::this_thread::sleep_for(std::chrono::milliseconds(16));
  return !c.wants_quit;
}

// A pause or a jump is pending; playing does not count.
bool isReplayBusy(const AppContext& c) {
  const WatchedRun* const run = c.bench.document->watched();
  return run && !run->isSettled() && !run->moment().is_playing;
}

// Waits in the time of the watched session, at most to its end.
Expected<void> waitForReplay(AppContext& c, double seconds, const std::function<void()>& frame) {
  const std::size_t until = c.bench.document->watched()->moment().sample + static_cast<std::size_t>(seconds / kTick);
  while (goesOn(c, frame) && isReplayBusy(c)) {
  }  // the last request is pending
  while (c.bench.replays->isPlaying() && c.bench.document->watched()->moment().sample < until && goesOn(c, frame)) {
  }
  while (isReplayBusy(c) && goesOn(c, frame)) {
  }
  return {};
}

// Waits until a force-feedback device leads the tool.
Expected<void> waitForDevice(AppContext& c, AppWords words, const std::function<void()>& frame) {
  KERF_TRY(seconds, numberOr(words, 1, 10, "SECONDS", 0, 36000));
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!c.bench.device->isLed() && std::chrono::steady_clock::now() < until && goesOn(c, frame)) {
  }
  if (c.bench.device->isLed()) return {};
  return wrongWord(fmt::format("no device controls the tool after {:g} s", seconds), "one",
                   c.bench.device->arm().view().missing);
}

// 0: no device open; 1: silent; 2: hand present; 3: leads the tool; 4: leads and is armed.
int stageOfDevice(const AppContext& c) {
  const ArmView now = c.bench.device->arm().view();
  if (now.what.empty()) return 0;
  if (!now.is_there) return 1;
  if (!now.is_leading) return 2;
  return now.is_armed ? 4 : 3;
}

Expected<void> wait(AppContext& c, AppWords words, const std::function<void()>& frame) {
  if (words.empty()) {
    while (goesOn(c, frame) &&
           (c.bench.jobs->running() || isReplayBusy(c) || import_commands::isPreviewing(c) ||
            c.bench.saw->isCutting() || c.bench.views->tissues().isBusy() || c.bench.exporting->isBusy() ||
            (c.bench.document->isShown() && c.bench.document->scene().triangleCount() == 0))) {
    }
    if (c.bench.document->watched()) frame();  // takes newly meshed chunks
    return {};
  }
  if (words[0] == "device") return waitForDevice(c, words, frame);
  KERF_TRY(seconds, numberOf(words, 0, "SECONDS", 0, 36000));
  if (c.bench.document->watched()) return waitForReplay(c, seconds, frame);
  if (!c.bench.document->isOpen()) return wrongWord("nothing is open", "an open session");
  frame();
  const auto until = c.bench.document->report().tick + static_cast<std::uint64_t>(seconds / kTick);
  while (c.bench.document->isOpen() && c.bench.document->report().tick < until && goesOn(c, frame)) {
  }
  return {};
}

nlohmann::json loopState(const Workbench& bench) {
  const HapticCounts& counts = bench.document->report().counts;
  nlohmann::json out{{"ticks", counts.ticks}, {"overruns", counts.overruns}};
  if (const auto hz = bench.monitor->loopHz()) out["hz"] = *hz;
  if (bench.document->times().cost.count() > 0) out["p99_ms"] = bench.document->times().cost.percentileMs(0.99);
  return out;
}

// Memory of the program, MB: resident, heap in use, heap freed but kept. Of the session: pools for changed bricks, and
// the log on disk.
nlohmann::json memoryState(const Workbench& bench) {
  constexpr double kMb = 1e6;
  nlohmann::json out;
  std::ifstream statm("/proc/self/statm");
  if (double all = 0, resident = 0; statm >> all >> resident)
    out["resident_MB"] = resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / kMb;
  const struct mallinfo2 heap = ::mallinfo2();
  out["heap_in_use_MB"] = static_cast<double>(heap.uordblks + heap.hblkhd) / kMb;
  out["heap_kept_MB"] = static_cast<double>(heap.fordblks) / kMb;
  if (!bench.document->isOpen()) return out;

  out["brick_pools"] = bench.document->report().counts.pools_taken;
  std::error_code failed;
  const auto log = fs::file_size(bench.document->sessionFolder() / "session.kerflog", failed);
  if (!failed) out["log_MB"] = static_cast<double>(log) / kMb;
  return out;
}

void printState(const AppContext& c) {
  nlohmann::json j{{"open", c.bench.document->isOpen()},
                   {"name", c.bench.document->name()},
                   {"removed_mm3", c.bench.document->removedMm3()},
                   {"force_N", c.bench.strokes->force},
                   {"depth_mm", c.bench.strokes->depth_mm},
                   {"speed_percent", 100 * c.bench.strokes->speed},
                   {"tilt_deg", c.bench.strokes->tilt.angle * 180 / std::numbers::pi},
                   {"ticks", c.bench.document->report().tick},
                   {"pieces", c.bench.document->scene().pieceCount()},
                   {"triangles", c.bench.document->scene().triangleCount()},
                   {"steps", c.bench.steps->timeline().done()},
                   {"steps_ahead", c.bench.steps->timeline().steps().size() - c.bench.steps->timeline().done()},
                   {"planes", c.bench.saw->plan().planes().size()},
                   {"sawn_percent", 100 * c.bench.saw->lastShare()}};
  if (const auto hole = c.bench.drill->readout(c.camera)) {
    j["hole"] = {{"place_mm", {hole->place[0], hole->place[1], hole->place[2]}},
                 {"depth_mm", c.bench.drill->hole()->depth},
                 {"diameter_mm", hole->diameter}};
    if (hole->walls.edge) j["hole"]["edge_mm"] = *hole->walls.edge;
    if (hole->walls.beside) j["hole"]["beside_mm"] = *hole->walls.beside;
    if (hole->walls.beneath) j["hole"]["beneath_mm"] = *hole->walls.beneath;
  }
  j["drilled_mm"] = c.bench.drill->lastDepth();
  for (const Branch& branch : c.bench.steps->branches()) j["branches"].push_back(branch.text);
  if (c.bench.exporting->isShown()) j["export"] = nlohmann::json::parse(exportState(*c.bench.exporting));
  const HeatReport& heat = c.bench.document->report().heat;
  if (heat.is_known) {
    j["surface_C"] = heat.surface;
    j["pulp_rise_K"] = heat.pulp_rise;
    j["nerve_rise_K"] = heat.nerve_rise;
  }
  if (c.bench.device->arm().isOpen()) j["device"] = nlohmann::json::parse(device_commands::deviceState(c));
  if (c.bench.imports->isImporting())
    j["import"] = nlohmann::json::parse(import_commands::importState(*c.bench.imports->set()));
  if (const WatchedRun* const run = c.bench.document->watched()) {
    const WatchMoment& now = run->moment();
    j["replay"] = {{"seconds", kTick * static_cast<double>(now.sample)},
                   {"of_seconds", run->seconds()},
                   {"step", now.steps},
                   {"of_steps", run->steps().size()},
                   {"speed", now.speed},
                   {"is_playing", now.is_playing}};
    if (now.verdict) j["replay"]["verdict"] = now.verdict->text;
  }
  if (c.bench.document->isShown()) j["tool"] = c.bench.tools->at(c.bench.tools->inHand()).id;
  if (const auto depth = c.bench.strokes->depthNow()) j["depth_now_mm"] = *depth;
  if (const auto depth = c.bench.monitor->tipDepth()) j["depth_tip_mm"] = *depth;
  if (const auto under = readoutOfTool(c.bench)) {
    j["point_mm"] = {under->point[0], under->point[1], under->point[2]};
    j["tissue"] = under->tissue;
  }
  if (c.bench.monitor->hindrance()[0]) j["hindrance"] = c.bench.monitor->hindrance();
  if (const auto& result = c.bench.sessions->lastResult()) j["last_session"] = resultJson(*result);
  if (const auto near = c.bench.monitor->nearStructure({}); near && !near->is_far) {
    j["near"] = near->name;
    j["near_mm"] = near->distance_mm;
  }
  if (c.bench.document->isOpen()) j["loop"] = loopState(c.bench);
  j["memory"] = memoryState(c.bench);
  for (const SceneObject* object : c.bench.document->scene().shown())
    if (!object->isBeside())
      j["piece_list"].push_back({{"name", object->name},
                                 {"volume_mm3", object->surface.volume()},
                                 {"removed_mm3", object->removed_mm3},
                                 {"is_moved", object->isMoved()}});
  for (const Neighbour& other : c.bench.neighbours->list())
    j["beside"].push_back({{"name", other.name}, {"removed_mm3", other.removed_mm3}});
  if (const auto near = c.bench.monitor->nearNeighbour({}); near && !near->is_far) {
    j["near_beside"] = near->name;
    j["near_beside_mm"] = near->distance_mm;
  }
  constexpr bool kEscapesAll = true;  // control characters too
  printText("{}\n", j.dump(-1, ' ', kEscapesAll, nlohmann::json::error_handler_t::replace));
  std::fflush(stdout);
}

// Distance from the cutting tool to pulp or nerve canal, mm; far: 1000.
double nearestOf(const AppContext& c) {
  constexpr double kFar = 1000;
  const auto near = c.bench.monitor->nearStructure({});
  return near && !near->is_far ? near->distance_mm : kFar;
}

// Distance from the cutting tool to the neighbours, mm; far: 1000.
double nearestBeside(const AppContext& c) {
  constexpr double kFar = 1000;
  const auto near = c.bench.monitor->nearNeighbour({});
  return near && !near->is_far ? near->distance_mm : kFar;
}

double removedBeside(const AppContext& c) {
  double out = 0;
  for (const Neighbour& other : c.bench.neighbours->list()) out += other.removed_mm3;
  return out;
}

const std::string kExpected =
    "removed, depth, tip, loop, near, hindered, warm, sawn, triangles, pieces, beside, beside-near, beside-removed, "
    "steps, "
    "ahead, branches, time, "
    "same, verdict, device or device-force";

double secondWatched(const AppContext& c) {
  return c.bench.document->watched() ? kTick * static_cast<double>(c.bench.document->watched()->moment().sample) : 0;
}

double sameness(const AppContext& c) {
  if (!c.bench.document->watched() || !c.bench.document->watched()->moment().verdict) return -1;
  return c.bench.document->watched()->moment().verdict->is_same ? 1 : 0;
}

// Print check of the export panel: 1: ready; 0: not ready; -1: unknown.
double verdictOf(const AppContext& c) {
  using Stage = ExportPlan::Stage;
  const Stage now = c.bench.exporting->stage();
  if (now == Stage::kWritten) return c.bench.exporting->written()->is_ready ? 1 : 0;
  if (now == Stage::kReady) return 1;
  return now == Stage::kDoubtful || now == Stage::kRefused ? 0 : -1;
}

Expected<void> expect(const AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("nothing", kExpected + ", and a range");
  KERF_TRY(low, numberOf(words, 1, "LOW", -1e12, 1e12));
  KERF_TRY(high, numberOf(words, 2, "HIGH", -1e12, 1e12));
  double value = 0;
  if (words[0] == "removed")
    value = c.bench.document->removedMm3();
  else if (words[0] == "depth")
    value = c.bench.strokes->depthNow().value_or(0);
  else if (words[0] == "tip")
    value = c.bench.monitor->tipDepth().value_or(0);
  else if (words[0] == "loop")
    value = c.bench.monitor->loopHz().value_or(0);
  else if (words[0] == "near")
    value = nearestOf(c);
  else if (words[0] == "hindered")
    value = c.bench.monitor->hindrance()[0] ? 1 : 0;
  else if (words[0] == "warm")
    value = c.bench.document->report().heat.surface;
  else if (words[0] == "sawn")
    value = 100 * c.bench.saw->lastShare();
  else if (words[0] == "triangles")
    value = static_cast<double>(c.bench.document->scene().triangleCount());
  else if (words[0] == "pieces")
    value = static_cast<double>(c.bench.document->scene().pieceCount());
  else if (words[0] == "beside")
    value = static_cast<double>(c.bench.neighbours->list().size());
  else if (words[0] == "beside-near")
    value = nearestBeside(c);
  else if (words[0] == "beside-removed")
    value = removedBeside(c);
  else if (words[0] == "steps" && c.bench.document->watched())
    value = static_cast<double>(c.bench.document->watched()->moment().steps);
  else if (words[0] == "steps")
    value = static_cast<double>(c.bench.steps->timeline().older() + c.bench.steps->timeline().done());
  else if (words[0] == "branches")
    value = static_cast<double>(c.bench.steps->branchCount());
  else if (words[0] == "time")
    value = secondWatched(c);
  else if (words[0] == "same")
    value = sameness(c);
  else if (words[0] == "verdict")
    value = verdictOf(c);
  else if (words[0] == "device")
    value = stageOfDevice(c);
  else if (words[0] == "device-force")
    value = c.bench.device->arm().view().felt.force.norm();
  else if (words[0] == "ahead")
    value = static_cast<double>(c.bench.steps->timeline().steps().size() - c.bench.steps->timeline().done());
  else
    return wrongWord("\"" + words[0] + "\"", kExpected);
  if (value >= low && value <= high) return {};
  return wrongWord(fmt::format("{} {:g}", words[0], value), fmt::format("{:g} to {:g}", low, high));
}

// Fails on the first error notice.
Expected<void> failOnError(const AppContext& c, std::size_t& seen) {
  for (; seen < c.bench.notices->list().size(); ++seen)
    if (const Notice& notice = c.bench.notices->list()[seen]; notice.is_error)
      return fail({.code = Error::Code::kBadValue, .found = notice.text});
  return {};
}

}  // namespace

Expected<std::vector<std::string>> wordsOfLine(const std::string& line) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at < line.size();) {
    if (std::isspace(static_cast<unsigned char>(line[at]))) {
      ++at;
      continue;
    }
    if (line[at] == '#') break;
    if (line[at] == '"') {
      const std::size_t end = line.find('"', at + 1);
      if (end == line.npos) return wrongWord(line, "a closing quote");
      out.push_back(line.substr(at + 1, end - at - 1));
      at = end + 1;
      continue;
    }
    std::size_t end = at;
    while (end < line.size() && !std::isspace(static_cast<unsigned char>(line[end]))) ++end;
    out.push_back(line.substr(at, end - at));
    at = end;
  }
  return out;
}

Expected<void> waitUntilSettled(AppContext& context, const std::function<void()>& frame) {
  return wait(context, {}, frame);
}

Expected<void> runScript(AppContext& context, const fs::path& script, const std::function<void()>& frame) {
  std::error_code ignored;
  std::ifstream in;
  if (!fs::is_directory(script, ignored)) in.open(script);
  if (!in.is_open())
    return fail({.code = Error::Code::kNotFound,
                 .file = script.string(),
                 .found = "cannot be read",
                 .expected = "lines of commands",
                 .hint = "list them with kerf-sim --commands"});
  std::size_t seen = 0;
  std::string line;
  for (int n = 1; std::getline(in, line) && !context.wants_quit; ++n) {
    const auto done = [&]() -> Expected<void> {
      KERF_TRY(words, wordsOfLine(line));
      if (words.empty()) return {};
      const AppWords parameters = AppWords(words).subspan(1);
      if (words[0] == "wait")
        KERF_CHECK(wait(context, parameters, frame));
      else if (words[0] == "expect")
        KERF_CHECK(expect(context, parameters));
      else if (words[0] == "print")
        printState(context);
      else
        KERF_CHECK(runAppCommand(context, words[0], parameters));
      frame();
      return failOnError(context, seen);
    }();
    if (done) continue;
    Error error = done.error();
    error.file = script.string();
    error.place = fmt::format("line {}: {}", n, line);
    return fail(std::move(error));
  }
  return {};
}

}  // namespace kerf
