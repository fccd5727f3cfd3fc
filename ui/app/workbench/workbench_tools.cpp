// The rack and tools added while a document is open. The rest of the workbench: workbench.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <future>
#include <memory>
#include <system_error>
#include <utility>

#include "geometry/tool/tool_file.h"
#include "sim/run/sweep/tool_resolution.h"
#include "ui/app/base/language.h"
#include "ui/app/view/tissue_display.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

namespace fs = std::filesystem;

// Tool times as in the rack, so that the watch each second opens no file. Exception: broken tools may name another
// mesh.
ToolTimes Workbench::toolTimesOf(std::size_t tool) const {
  const SessionTool& known = tools_[tool];
  return tool_errors_[tool] ? timesOf(known.file) : timesOf(known);
}

const Error* Workbench::toolError(std::size_t n) const {
  return !watched_ && n < tool_errors_.size() && tool_errors_[n] ? &*tool_errors_[n] : nullptr;
}

void Workbench::putIntoRack(RackTool tool) {
  const auto same = [&](const SessionTool& known) { return known.file == tool.tool.file; };
  const auto at = static_cast<std::size_t>(std::find_if(tools_.begin(), tools_.end(), same) - tools_.begin());
  if (at == tools_.size()) {
    tools_.emplace_back();
    heads_.emplace_back();
    plunges_.emplace_back();
    touches_.push_back(tool.touches);
    tool_times_.emplace_back();
    tool_errors_.emplace_back();
    is_outdated_.push_back(0);
  }
  std::erase_if(broken_tools_, [&](const BrokenTool& broken) { return broken.file == tool.tool.file; });
  heads_[at] = std::move(tool.head);
  plunges_[at] = tool.plunge;
  touches_[at] = std::move(tool.touches);
  tool_errors_[at].reset();
  is_outdated_[at] = run_ != nullptr;
  tools_[at] = std::move(tool.tool);
  tool_times_[at] = tool.times;
}

// A tool of the rack keeps the error in its row, any other gets a row of its own.
void Workbench::keepBroken(const BrokenTool& broken) {
  for (std::size_t n = 0; n < tools_.size(); ++n)
    if (tools_[n].file == broken.file) {
      tool_errors_[n] = broken.error;
      tool_times_[n] = broken.times;
      return;
    }
  std::erase_if(broken_tools_, [&](const BrokenTool& known) { return known.file == broken.file; });
  broken_tools_.push_back(broken);
}

// Reads in the background: the first frame does not wait for the tools.
void Workbench::readTools() {
  const auto tools = std::make_shared<std::promise<std::vector<SessionTool>>>();
  coming_tools_ = tools->get_future().share();
  rack_ = std::make_unique<Job<Rack>>("reading the tools",
                                      [names = options_.tools, own = ownToolFolder(), tools](const Progress& progress) {
                                        auto rack = readRack(names, own, progress);
                                        std::vector<SessionTool> read;
                                        if (rack)
                                          for (const RackTool& tool : rack->tools) read.push_back(tool.tool);
                                        tools->set_value(std::move(read));
                                        return rack;
                                      });
}

// @param waits  waits for tools still being read.
void Workbench::takeRack(bool waits) {
  if (!rack_ || !(waits || rack_->isOver())) return;
  auto read = rack_->take();
  rack_.reset();
  coming_tools_ = {};
  if (!read) return complain(read.error());

  for (RackTool& tool : read->tools) putIntoRack(std::move(tool));
  first_look_ = read->first_look;
  for (const BrokenTool& broken : read->broken) keepBroken(broken);
  for (const Error& error : read->errors) complain(error);
}

void Workbench::addTool(const fs::path& file) {
  if (isBusy() || isSawing()) return;
  takeRack(true);
  std::error_code failed;
  fs::path path = fs::absolute(file, failed);
  if (failed) path = file;
  const ToolTimes times = timesOf(path);
  auto tool = readTool(path);
  if (!tool) {
    keepBroken({path, tool.error(), times, true});
    return complain(tool.error());
  }
  const std::string id = tool->id;
  putIntoRack(rackTool({path, std::move(*tool)}, times));
  if (run_) return reopenWith(path);
  say(phrase("{} is in the rack: open something to cut with it", id));
}

// The log of a session names its tools and cases at its start. So this session is written, and another continues it.
// @param tool_file  taken in hand; empty: keeps the tool in hand.
// @param branch  is continued, in place of the session.
void Workbench::reopenWith(const fs::path& tool_file, std::vector<CaseBeside> further,
                           const std::optional<Branch>& branch) {
  const fs::path before = run_->from().empty() ? run_->caseFolder() : run_->from(), session = session_;
  const auto plan = std::make_shared<SawPlan>(saw_->plan());
  const fs::path source = source_;
  const std::string name = name_;
  const fs::path tool = tool_file.empty() ? run_->tools()[tool_].file : tool_file;
  std::vector<CaseBeside> kept;  // do not come back with `before`
  for (const LiveNeighbour& other : run_->neighbours())
    if (!other.known.has_begin) kept.push_back({other.known.folder, other.known.name});
  std::vector<fs::path> sources = sources_beside_;
  for (const CaseBeside& other : further) sources.push_back(other.folder);
  const bool is_unexported = hasUnexportedCut();
  const TissueChoices seen = tissues_->choices();
  endRun(branch.has_value());
  auto closing = std::exchange(when_over_, {});
  has_written_ = false;
  when_over_ = [this, closing = std::move(closing), before, session, plan, source, name, tool, kept, further, sources,
                is_unexported, seen, branch] {
    const std::size_t told = notices_.size();
    closing();
    if (has_failed_) return;                             // the log holds the cuts: opens nothing over it
    if (has_written_ && !branch) notices_.resize(told);  // the session continues
    const fs::path next = has_written_ ? session : before;
    OpeningOptions options = openingOptions();
    std::vector<CaseBeside> beside = has_written_ ? std::vector<CaseBeside>{} : kept;
    beside.insert(beside.end(), further.begin(), further.end());
    std::optional<Branch> wanted = branch;
    if (wanted && !has_written_) wanted = savedOf(*wanted, session);
    if (wanted) {
      openBranch(*wanted);
    } else {
      for (const CaseBeside& other : beside) options.beside.push_back({other.folder, other.name, {}});
      openBy(further.empty() ? "taking the tool" : "placing what stands beside",
             [next, options](const Progress& progress) { return openToCut(next, options, progress); });
    }
    if (!job_) return;
    const auto show_it = std::exchange(when_over_, {});
    when_over_ = [this, show_it, plan, source, name, tool, sources, is_unexported, seen, wanted] {
      is_reopening_ = true;
      has_unexported_before_ = is_unexported || wanted;
      show_it();
      is_reopening_ = false;
      if (!run_) return;
      if (wanted) opened_ = Branch{run_->from(), {}, wanted->text};
      tissues_->choose(seen);
      source_ = source;
      name_ = name;
      sources_beside_ = sources;
      saw_->plan() = *plan;
      for (std::size_t n = 0; n < tools_.size(); ++n)
        if (tools_[n].file == tool) selectTool(n);
    };
  };
}

// Rereads a changed tool file or mesh. The tool in hand is replaced at once, others with the next opened document.
void Workbench::watchTools() {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_watch_ || job_ || isPressed() || saw_->isCutting()) return;
  next_watch_ = now + std::chrono::seconds(1);

  for (std::size_t n = 0; n < tools_.size(); ++n) {
    const ToolTimes seen = toolTimesOf(n);
    const bool is_there = seen.file && (seen.mesh || !tools_[n].tool.mesh || tool_errors_[n]);
    if (!is_there || seen == tool_times_[n]) continue;
    const fs::path file = tools_[n].file, mesh = tools_[n].tool.mesh_file;
    const bool is_mesh = seen.file == tool_times_[n].file && !mesh.empty();
    const ToolTimes times = timesOf(file);
    auto tool = readTool(file);
    if (!tool) {
      keepBroken({file, tool.error(), times});
      complain(tool.error());
      continue;
    }
    say(phrase("{} was changed: it is read anew", (is_mesh ? mesh : file).filename().string()));
    putIntoRack(rackTool({file, std::move(*tool)}, times));
    if (run_ && n == tool_) return reopenWith(file);
  }
  watchBrokenTools();
}

// Takes a dropped tool once it is readable. Any other tool only moves from its broken row into the rack.
void Workbench::watchBrokenTools() {
  for (std::size_t n = 0; n < broken_tools_.size(); ++n) {
    BrokenTool& broken = broken_tools_[n];
    const ToolTimes times = timesOf(broken.file);
    if (!times.file || times == broken.times) continue;
    broken.times = times;
    auto tool = readTool(broken.file);
    if (!tool) {
      broken.error = tool.error();
      continue;
    }
    const BrokenTool mended = broken;
    putIntoRack(rackTool({mended.file, std::move(*tool)}, times));
    say(phrase("{} can be read now: it is in the rack", mended.file.filename().string()));
    if (run_ && mended.is_asked_for) reopenWith(mended.file);
    return;  // the others in a second
  }
}

// ---- The tool in hand

void Workbench::selectTool(std::size_t n) {
  if (!run_ || n >= toolCount() || n == tool_) return;
  if (isSawing()) return;
  release();
  if (is_outdated_[n] && !job_) return reopenWith(tools_[n].file);
  if (!send(SelectTool{n})) return;
  tool_ = n;
  is_reversed_ = false;
  heatByToolInHand();
  warnOfThinTool();
}

// Warns once a session: a notice does not interrupt.
void Workbench::warnOfThinTool() {
  const auto coarse = tooCoarseFor(tool(tool_), run_->original()->voxel(), Held::kByHand);
  if (!coarse || !told_thin_.insert(tool(tool_).id).second) return;
  say(fmt::format("{}. Voxels of {:.2g} mm are nearer.", coarse->what, coarse->finer_mm));
}

bool Workbench::selectTool(const std::string& id) {
  for (std::size_t n = 0; n < toolCount(); ++n)
    if (tool(n).id == id) {
      selectTool(n);
      return true;
    }
  return false;
}

}  // namespace kerf
