// A scan that is looked at before it is prepared. The rest of the workbench: workbench.cpp.
#include <fmt/format.h>

#include <memory>
#include <utility>

#include "ui/app/import_plan.h"
#include "ui/app/workbench.h"

namespace kerf {

void Workbench::beginImport(const std::filesystem::path& path) {
  if (isBusy()) return;
  const FileKind kind = kindOf(path);
  if (kind == FileKind::kRun && options_.asks_about_runs) {
    asked_run_ = path;
    return;
  }
  if (kind != FileKind::kScan) return open(path);

  auto job = std::make_unique<Job<ScanFound>>("reading " + path.filename().string(),
                                              [path](const Progress& progress) { return readScan(path, progress); });
  job_writes_ = false;
  when_over_ = [this, job = job.get()] {
    auto found = job->take();
    if (!found) return complain(found.error());
    release();
    putImportAway();
    import_ = std::make_unique<ImportPlan>(std::move(*found), PrepareOptions{options_.unit, options_.voxel_mm, {}});
  };
  job_ = std::move(job);
}

void Workbench::startImport() {
  if (!import_ || isBusy()) return;
  import_->suspendPreview();
  OpeningOptions options = openingOptions();
  options.prepare = import_->result();
  const std::filesystem::path path = import_->found().file;
  const std::string as_shown =
      fmt::format("prepared as shown: read as {}, {} changes, cut in voxels of {:g} mm", import_->unit().unit,
                  import_->preview() ? import_->preview()->changes.size() : 0, import_->voxel());
  const bool was_shown = import_->preview() != nullptr;
  openBy("preparing " + path.filename().string(), [=](const Progress& progress) -> Expected<Opened> {
    KERF_TRY(opened, openToCut(path, options, progress));
    if (was_shown && !opened.notes.empty()) opened.notes = {as_shown};
    return std::move(opened);
  });
}

void Workbench::cancelImport() {
  if (!isBusy()) putImportAway();
}

// Closing stops at its next report of progress: waiting for that here would hold up the frame.
void Workbench::putImportAway() {
  std::erase_if(ending_imports_, [](const auto& plan) { return plan->isIdle(); });
  if (!import_) return;
  import_->suspendPreview();
  if (!import_->isIdle()) ending_imports_.push_back(std::move(import_));
  import_.reset();
}

}  // namespace kerf
