#include "ui/app/workbench/tools.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "geometry/case/case_bundle.h"
#include "geometry/tool/tool_file.h"
#include "sim/run/session/watched_run.h"
#include "sim/run/sweep/tool_resolution.h"
#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/import/import_plan.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

namespace fs = std::filesystem;

Tools::Tools(Workbench& bench) : bench_(bench) { readRack(); }

Tools::~Tools() = default;

fs::path Tools::ownFolder() const { return bench_.options().data_folder / "tools"; }

std::vector<SessionTool> Tools::forSession() const {
  std::vector<SessionTool> out;
  for (const Row& row : tools_) out.push_back(row.tool);
  return out;
}

// ---- The tool in hand

std::size_t Tools::count() const {
  if (const WatchedRun* const watched = bench_.document->watched()) return watched->tools().size();
  const LiveRun* const run = bench_.document->run();
  return run ? run->tools().size() : 0;
}

const Tool& Tools::at(std::size_t n) const {
  const WatchedRun* const watched = bench_.document->watched();
  return watched ? watched->tools()[n] : bench_.document->run()->tools()[n].tool;
}

std::size_t Tools::inHand() const {
  const WatchedRun* const watched = bench_.document->watched();
  return watched ? watched->moment().tool : in_hand_;
}

void Tools::opened(Opening how) {
  in_hand_ = 0;
  samples_.clear();
  if (how == Opening::kNew) told_thin_.clear();
  if (!bench_.document->isOpen()) return;
  for (Row& row : tools_) row.is_outdated = false;
  toolChanged();
}

void Tools::select(std::size_t n) {
  if (!bench_.document->isOpen() || n >= count() || n == in_hand_ || bench_.saw->isBusy()) return;
  bench_.strokes->release();
  if (tools_[n].is_outdated && !bench_.jobs->running()) return bench_.sessions->reopen({.tool = tools_[n].tool.file});
  if (!bench_.document->send(SelectTool{n})) return;
  in_hand_ = n;
  bench_.strokes->toolChanged();
  toolChanged();
}

bool Tools::select(const std::string& id_or_file) {
  if (!bench_.document->isOpen()) return false;
  const auto tools = bench_.document->run()->tools();
  const auto isIt = [&](const SessionTool& known) { return known.tool.id == id_or_file || known.file == id_or_file; };
  const auto found = std::find_if(tools.begin(), tools.end(), isIt);
  if (found == tools.end()) return false;
  select(static_cast<std::size_t>(found - tools.begin()));
  return true;
}

std::string Tools::wordFor(std::size_t n) const {
  for (std::size_t before = 0; before < n; ++before)
    if (at(before).id == at(n).id) return bench_.document->run()->tools()[n].file.string();
  return at(n).id;
}

void Tools::selectFile(const fs::path& file) {
  for (std::size_t n = 0; n < tools_.size(); ++n)
    if (tools_[n].tool.file == file) select(n);
}

const ToolSamples& Tools::samples() const {
  const auto known = samples_.find(in_hand_);
  if (known != samples_.end()) return known->second;
  return samples_.emplace(in_hand_, ToolSamples(bench_.document->run()->model().tools[in_hand_].cut, kToolSamples))
      .first->second;
}

// From now on the report gives the heating by this tool. Warns once a session of a tool too thin for the voxels: a
// notice does not interrupt.
void Tools::toolChanged() {
  LiveRun& run = *bench_.document->run();
  run.thread().heatBy(in_hand_, samples(), heatSource(held()));
  const auto coarse = tooCoarseFor(held(), run.original()->voxel(), Held::kByHand);
  if (!coarse || !told_thin_.insert(held().id).second) return;
  bench_.notices->say(shownNumbers("{}. Use voxels of {:.2g} mm.", coarse->what, coarse->finer_mm));
}

std::optional<FinerVoxels> Tools::finerVoxels() const {
  constexpr double kThin = 2, kFine = 0.1, kRounding = 1e-6;  // mm
  const Document& document = *bench_.document;
  if (!document.isOpen() || held().kind != ToolKind::kBur || held().head_diameter_mm >= kThin) return {};
  const double now = document.run()->original()->voxel();
  if (now < kFine + kRounding || !document.prepared() || !document.run()->neighbours().empty()) return {};
  const CaseManifest& manifest = document.run()->caseManifest();
  const Prediction cost = predict(manifest.solid_area_mm2, kFine, closingSeconds(manifest.solid_triangles, false));
  return FinerVoxels{now, kFine, cost.seconds, cost.bytes};
}

// ---- The rack

// Tool times as in the rack, so that the watch each second opens no file. Exception: broken tools may name another
// mesh.
ToolTimes Tools::timesOfRow(const Row& row) const { return row.error ? timesOf(row.tool.file) : timesOf(row.tool); }

const Error* Tools::error(std::size_t n) const {
  return !bench_.document->watched() && n < tools_.size() && tools_[n].error ? &*tools_[n].error : nullptr;
}

void Tools::put(RackTool tool) {
  const auto same = [&](const Row& row) { return row.tool.file == tool.tool.file; };
  const auto at = std::find_if(tools_.begin(), tools_.end(), same);
  std::erase_if(broken_, [&](const BrokenTool& broken) { return broken.file == tool.tool.file; });
  Row row{std::move(tool), {}, bench_.document->isOpen()};
  if (at == tools_.end())
    tools_.push_back(std::move(row));
  else
    *at = std::move(row);
}

// A tool of the rack keeps the error in its row, any other gets a row of its own.
void Tools::keepBroken(const BrokenTool& broken) {
  for (Row& row : tools_)
    if (row.tool.file == broken.file) {
      row.error = broken.error;
      row.times = broken.times;
      return;
    }
  std::erase_if(broken_, [&](const BrokenTool& known) { return known.file == broken.file; });
  broken_.push_back(broken);
}

// Reads in the background: the first frame does not wait for the tools.
void Tools::readRack() {
  const auto tools = std::make_shared<std::promise<std::vector<SessionTool>>>();
  coming_ = tools->get_future().share();
  rack_ = std::make_unique<Job<Rack>>(
      "reading the tools", [names = bench_.options().tools, own = ownFolder(), tools](const Progress& progress) {
        auto rack = kerf::readRack(names, own, progress);
        std::vector<SessionTool> read;
        if (rack)
          for (const RackTool& tool : rack->tools) read.push_back(tool.tool);
        tools->set_value(std::move(read));
        return rack;
      });
}

void Tools::takeRack(bool waits) {
  if (!rack_ || !(waits || rack_->isOver())) return;
  auto read = rack_->take();
  rack_.reset();
  coming_ = {};
  if (!read) return bench_.notices->complain(read.error());

  for (RackTool& tool : read->tools) put(std::move(tool));
  first_look_ = read->first_look;
  for (const BrokenTool& broken : read->broken) keepBroken(broken);
  for (const Error& error : read->errors) bench_.notices->complain(error);
}

void Tools::add(const fs::path& file) {
  if (bench_.jobs->isBusy() || bench_.saw->isBusy()) return;
  takeRack(true);
  std::error_code failed;
  fs::path path = fs::absolute(file, failed);
  if (failed) path = file;
  const ToolTimes times = timesOf(path);
  auto tool = readTool(path);
  if (!tool) {
    keepBroken({path, tool.error(), times, true});
    return bench_.notices->complain(tool.error());
  }
  const std::string id = tool->id;
  put(rackTool({path, std::move(*tool)}, times));
  if (bench_.document->isOpen()) return bench_.sessions->reopen({.tool = path});
  bench_.notices->say(phrase("{} is now in the rack. Open an object to cut with it.", id));
}

void Tools::addMade(std::vector<SessionTool> made) {
  for (SessionTool& one : made) {
    bench_.notices->say(phrase("{} is now in the rack: {}", one.tool.id, one.file.string()));
    const ToolTimes times = timesOf(one.file);
    put(rackTool(std::move(one), times));
  }
}

void Tools::update() { watch(); }

// Rereads a changed tool file or mesh. The tool in hand is replaced at once, others with the next opened document.
void Tools::watch() {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_watch_ || bench_.jobs->running() || bench_.strokes->isPressed() || bench_.saw->isCutting()) return;
  next_watch_ = now + std::chrono::seconds(1);

  for (std::size_t n = 0; n < tools_.size(); ++n) {
    const Row& row = tools_[n];
    const ToolTimes seen = timesOfRow(row);
    const bool is_there = seen.file && (seen.mesh || row.tool.tool.companion.empty() || row.error);
    if (!is_there || seen == row.times) continue;
    const fs::path file = row.tool.file, mesh = row.tool.tool.companion;
    const bool is_mesh = seen.file == row.times.file && !mesh.empty();
    const ToolTimes times = timesOf(file);
    auto tool = readTool(file);
    if (!tool) {
      keepBroken({file, tool.error(), times});
      bench_.notices->complain(tool.error());
      continue;
    }
    bench_.notices->say(phrase("{} changed. Kerf read it again.", (is_mesh ? mesh : file).filename().string()));
    put(rackTool({file, std::move(*tool)}, times));
    if (bench_.document->isOpen() && n == in_hand_) return bench_.sessions->reopen({.tool = file});
  }
  watchBroken();
}

// Takes a dropped tool once it is readable. Any other tool only moves from its broken row into the rack.
void Tools::watchBroken() {
  for (BrokenTool& broken : broken_) {
    const ToolTimes times = timesOf(broken.file);
    if (!times.file || times == broken.times) continue;
    broken.times = times;
    auto tool = readTool(broken.file);
    if (!tool) {
      broken.error = tool.error();
      continue;
    }
    const BrokenTool mended = broken;
    put(rackTool({mended.file, std::move(*tool)}, times));
    bench_.notices->say(phrase("{} is now readable and in the rack.", mended.file.filename().string()));
    if (bench_.document->isOpen() && mended.is_asked_for) bench_.sessions->reopen({.tool = mended.file});
    return;  // the others in a second
  }
}

}  // namespace kerf
