// Files that are looked at before they are prepared. The rest of the workbench: workbench.cpp.
#include <fmt/format.h>

#include <memory>
#include <utility>

#include "ui/app/import_set.h"
#include "ui/app/workbench.h"

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
  readToImports({path}, "reading " + path.filename().string(), false);
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
  // What is gone on with is decided about already.
  if (kindOf(objects.front()) == FileKind::kRun) return openAll(objects);
  if (!isBusy()) readToImports(objects, fmt::format("reading {} files", objects.size()), false);
}

void Workbench::importMore(const std::vector<fs::path>& paths) {
  if (!import_) return beginImports(paths);
  const std::vector<fs::path> objects = takeTools(paths);
  if (!objects.empty() && !isBusy()) readToImports(objects, fmt::format("reading {} more", objects.size()), true);
}

// @param is_more  they come beside what is looked at already.
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

  const ImportEntry& first = import_->cut();
  OpeningOptions options = openingOptions();
  options.prepare = first.decided();
  std::string names;
  for (const ImportEntry& entry : import_->entries()) {
    if (entry.role != ImportRole::kBeside) continue;
    options.beside.push_back({entry.file, {}, entry.decided()});
    names += (names.empty() ? " with " : ", ") + entry.file.filename().string();
  }

  // What was looked at need not be said again.
  std::string as_shown;
  if (const ImportPlan* const scan = first.scan.get(); scan && scan->preview())
    as_shown = fmt::format("prepared as shown: read as {}, {} changes, cut in voxels of {:g} mm", scan->unit().unit,
                           scan->preview()->changes.size(), scan->voxel());
  const bool is_alone = options.beside.empty();
  openBy("preparing " + first.file.filename().string() + names,
         [path = first.file, options, as_shown, is_alone](const Progress& progress) -> Expected<Opened> {
           KERF_TRY(opened, openToCut(path, options, progress));
           if (!as_shown.empty() && is_alone && !opened.notes.empty()) opened.notes = {as_shown};
           if (!is_alone)
             opened.notes.insert(
                 opened.notes.begin(),
                 fmt::format("{} is worked on; to work on another one: neighbour.work-on", opened.name));
           return std::move(opened);
         });
}

void Workbench::cancelImport() {
  if (!isBusy()) putImportAway();
}

// Closing stops at its next report of progress: waiting for that here would hold up the frame.
void Workbench::putImportAway() {
  std::erase_if(ending_imports_, [](const auto& set) { return set->isIdle(); });
  if (!import_) return;
  import_->suspendPreviews();
  if (!import_->isIdle()) ending_imports_.push_back(std::move(import_));
  import_.reset();
}

}  // namespace kerf
