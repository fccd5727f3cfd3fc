// Imports: files shown before they are prepared. The rest of the workbench: workbench.cpp.
#include <algorithm>
#include <memory>
#include <system_error>
#include <utility>

#include "geometry/tool/tool_file.h"
#include "ui/app/base/language.h"
#include "ui/app/import/import_set.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

namespace fs = std::filesystem;

ImportPlan* Workbench::importPlan() const { return import_ ? import_->scan() : nullptr; }

void Workbench::beginImport(const fs::path& path) {
  if (isBusy()) return;
  const FileKind kind = kindOf(path);
  if (kind == FileKind::kRun && options_.asks_about_runs) {
    asked_run_ = path;
    return;
  }
  if (kind != FileKind::kScan && kind != FileKind::kLabels) return open(path);
  readToImports({path}, phrase("reading {}", path.filename().string()), false);
}

std::vector<fs::path> Workbench::takeTools(const std::vector<fs::path>& paths) {
  std::vector<fs::path> objects;
  for (const fs::path& path : paths)
    if (kindOf(path) == FileKind::kTool)
      addTool(path);
    else
      objects.push_back(path);
  return objects;
}

void Workbench::beginImports(const std::vector<fs::path>& paths) {
  const std::vector<fs::path> objects = takeTools(paths);
  if (objects.empty()) return;
  if (objects.size() == 1) return beginImport(objects.front());
  // A continued run needs no decisions.
  if (kindOf(objects.front()) == FileKind::kRun) return openAll(objects);
  if (!isBusy()) readToImports(objects, phrase("reading {} files", objects.size()), false);
}

void Workbench::importMore(const std::vector<fs::path>& paths) {
  if (!import_) return beginImports(paths);
  const std::vector<fs::path> objects = takeTools(paths);
  if (!objects.empty() && !isBusy()) readToImports(objects, phrase("reading {} more", objects.size()), true);
}

// @param is_more  adds them to the current import.
void Workbench::readToImports(std::vector<fs::path> paths, const std::string& title, bool is_more) {
  using Read = std::vector<ImportRead>;
  auto job = std::make_unique<Job<Read>>(title, [paths = std::move(paths)](const Progress& progress) -> Expected<Read> {
    Read out;
    const double all = static_cast<double>(paths.size());
    for (const fs::path& path : paths) {
      const double before = static_cast<double>(out.size());
      const Progress its_part = [&](double done, std::string_view step) {
        return kerf::report(progress, (before + done) / all, step);
      };
      KERF_TRY(read, readToImport(path, its_part));
      out.push_back(std::move(read));
    }
    return out;
  });
  job_writes_ = false;
  if (import_) import_->suspendPreviews();
  when_over_ = [this, job = job.get(), is_more] {
    auto read = job->take();
    if (!read) return complain(read.error());
    if (is_more && import_) return import_->add(std::move(*read));
    release();
    putImportAway();
    import_ = std::make_unique<ImportSet>(std::move(*read), PrepareOptions{options_.unit, options_.voxel_mm, {}, {}},
                                          materials_);
  };
  job_ = std::move(job);
}

void Workbench::startImport() {
  if (!import_ || isBusy()) return;
  if (const auto ready = import_->requireReady(); !ready) return complain(ready.error());
  import_->suspendPreviews();
  takeRack(true);  // keeps tool ids unique
  std::vector<MeshToolOrder> orders = import_->toolOrders();
  for (MeshToolOrder& order : orders) {
    for (const SessionTool& known : tools_) order.ids_taken.push_back(known.tool.id);
    for (const BrokenTool& broken : broken_tools_) order.ids_taken.push_back(broken.file.stem().string());
  }
  orders.empty() ? openImported() : makeTools(std::move(orders));
}

// Tools first: the session of the other files opens with them in its rack.
void Workbench::makeTools(std::vector<MeshToolOrder> orders) {
  using Made = std::vector<SessionTool>;
  const std::string title = orders.size() == 1 ? phrase("making a tool of {}", orders.front().file.filename().string())
                                               : phrase("making {} tools", orders.size());
  auto job = std::make_unique<Job<Made>>(
      title, [orders = std::move(orders), folder = ownToolFolder()](const Progress& progress) -> Expected<Made> {
        Made out;
        std::vector<fs::path> files;
        const auto made = [&]() -> Expected<void> {
          for (const MeshToolOrder& order : orders) {
            KERF_TRY(file, writeMeshTool(order, folder, progress));
            files.push_back(file);
            KERF_TRY(tool, readTool(file));
            out.push_back({file, std::move(tool)});
          }
          return {};
        }();
        if (made) return out;
        // All or none: another try would find the ids of the first tools taken.
        std::error_code ignored;
        for (fs::path& file : files) {
          fs::remove(file, ignored);
          fs::remove(file.replace_extension(".ply"), ignored);
        }
        return fail(made.error());
      });
  job_writes_ = false;
  when_over_ = [this, job = job.get()] {
    auto made = job->take();
    if (!made) return complain(made.error());
    takeMadeTools(std::move(*made));
  };
  job_ = std::move(job);
}

void Workbench::takeMadeTools(std::vector<SessionTool> made) {
  const fs::path first = made.front().file;
  for (SessionTool& one : made) {
    say(phrase("{} is in the rack: {}", one.tool.id, one.file.string()));
    const ToolTimes times = timesOf(one.file);
    putIntoRack(rackTool(std::move(one), times));
  }
  if (!import_) return;
  import_->toolsAreMade();
  const auto& entries = import_->entries();
  if (std::any_of(entries.begin(), entries.end(), [](const auto& e) { return e.role != ImportRole::kOut; }))
    return openImported();
  putImportAway();
  if (run_ && !isSawing()) reopenWith(first);
}

void Workbench::openImported() {
  if (!import_->cut()) {
    if (!run_)
      return complain({.code = Error::Code::kBadValue,
                       .found = "nothing that would be cut, and nothing open",
                       .expected = "one file that is cut",
                       .hint = "import.role 1 cut"});
    std::vector<OpenBeside> asked;
    for (const ImportEntry& entry : import_->entries())
      if (entry.role == ImportRole::kBeside) asked.push_back({entry.file, entry.file.stem().string(), entry.decided()});
    if (asked.empty()) {  // the open document stays
      say("nothing was imported: all files were left out");
      return putImportAway();
    }
    const std::string title =
        asked.size() == 1 ? asked.front().path.filename().string() : phrase("{} files", asked.size());
    return placeBeside(std::move(asked), phrase("preparing {}", title));
  }

  const ImportEntry& first = *import_->cut();
  OpeningOptions options = openingOptions();
  options.prepare = first.decided();
  std::string names;
  for (const ImportEntry& entry : import_->entries()) {
    if (entry.role != ImportRole::kBeside) continue;
    options.beside.push_back({entry.file, {}, entry.decided()});
    names += (names.empty() ? "" : ", ") + entry.file.filename().string();
  }

  // The preview has shown these changes: no need to repeat them.
  std::string as_shown;
  if (const ImportPlan* const scan = first.scan.get(); scan && scan->preview())
    as_shown = phrase("prepared as shown: read as {}, {} changes, cut in voxels of {:g} mm", scan->unit().unit,
                      scan->preview()->changes.size(), scan->voxel());
  const bool is_alone = options.beside.empty();
  openBy(names.empty() ? phrase("preparing {}", first.file.filename().string())
                       : phrase("preparing {} with {}", first.file.filename().string(), names),
         [path = first.file, options, as_shown, is_alone](const Progress& progress) -> Expected<Opened> {
           KERF_TRY(opened, openToCut(path, options, progress));
           if (!as_shown.empty() && is_alone && !opened.notes.empty()) opened.notes = {as_shown};
           if (!is_alone)
             opened.notes.insert(opened.notes.begin(),
                                 phrase("{} is worked on; to work on another one: neighbour.work-on", opened.name));
           return std::move(opened);
         });
}

void Workbench::cancelImport() {
  if (!isBusy()) putImportAway();
}

// A preview stops at its next progress report: waiting for that here would hold up the frame.
void Workbench::putImportAway() {
  std::erase_if(ending_imports_, [](const auto& set) { return set->isIdle(); });
  if (!import_) return;
  import_->suspendPreviews();
  if (!import_->isIdle()) ending_imports_.push_back(std::move(import_));
  import_.reset();
}

}  // namespace kerf
