#include "ui/app/workbench/imports.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "geometry/tool/tool_file.h"
#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/import/import_set.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tools.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

Expected<std::vector<ImportRead>> readAll(const std::vector<fs::path>& paths, const Progress& progress) {
  std::vector<ImportRead> out;
  const double all = static_cast<double>(paths.size());
  for (const fs::path& path : paths) {
    const double before = static_cast<double>(out.size());
    const Progress its_part = [&](double done, std::string_view step) {
      return report(progress, (before + done) / all, step);
    };
    KERF_TRY(read, readToImport(path, its_part));
    out.push_back(std::move(read));
  }
  return out;
}

// All or none: another try would find the ids of the first tools taken.
Expected<std::vector<SessionTool>> writeTools(const std::vector<MeshToolOrder>& orders, const fs::path& folder,
                                              const Progress& progress) {
  std::vector<SessionTool> out;
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
  std::error_code ignored;
  for (fs::path& file : files) {
    fs::remove(file, ignored);
    fs::remove(file.replace_extension(".ply"), ignored);
  }
  return fail(made.error());
}

}  // namespace

Imports::Imports(Workbench& bench) : bench_(bench) {}

Imports::~Imports() = default;

ImportPlan* Imports::plan() const { return import_ ? import_->scan() : nullptr; }

void Imports::update() {
  if (import_ && !bench_.jobs->running()) import_->update();
}

// ---- Reading

void Imports::begin(const fs::path& path) {
  if (bench_.jobs->isBusy()) return;
  const FileKind kind = kindOf(path);
  if (kind != FileKind::kScan && kind != FileKind::kLabels) return bench_.sessions->open(path);
  read({path}, phrase("reading {}", path.filename().string()), false);
}

std::vector<fs::path> Imports::takeTools(const std::vector<fs::path>& paths) {
  std::vector<fs::path> objects;
  for (const fs::path& path : paths)
    if (kindOf(path) == FileKind::kTool)
      bench_.tools->add(path);
    else
      objects.push_back(path);
  return objects;
}

void Imports::beginAll(const std::vector<fs::path>& paths) {
  const std::vector<fs::path> objects = takeTools(paths);
  if (objects.empty()) return;
  if (objects.size() == 1) return begin(objects.front());
  // A continued run needs no decisions.
  const FileKind first = kindOf(objects.front());
  if (first == FileKind::kRun || first == FileKind::kSessionFile) return bench_.sessions->openAll(objects);
  if (!bench_.jobs->isBusy()) read(objects, phrase("reading {} files", objects.size()), false);
}

void Imports::addMore(const std::vector<fs::path>& paths) {
  if (!import_) return beginAll(paths);
  const std::vector<fs::path> objects = takeTools(paths);
  if (!objects.empty() && !bench_.jobs->isBusy()) read(objects, phrase("reading {} more", objects.size()), true);
}

// @param is_more  adds them to the current import.
void Imports::read(std::vector<fs::path> paths, const std::string& title, bool is_more) {
  using Read = std::vector<ImportRead>;
  if (import_) import_->suspendPreviews();
  const auto work = [paths = std::move(paths)](const Progress& progress) { return readAll(paths, progress); };
  const auto take = [this, is_more](Expected<Read> read) {
    if (!read) return bench_.notices->complain(read.error());
    if (is_more && import_) return import_->add(std::move(*read));
    bench_.strokes->release();
    putAway();
    const WorkbenchOptions& options = bench_.options();
    import_ = std::make_unique<ImportSet>(std::move(*read), PrepareOptions{options.unit, options.voxel_mm, {}, {}},
                                          bench_.document->materials());
  };
  bench_.jobs->start<Read>(Jobs::Kind::kReads, title, work, take);
}

// ---- Opening

void Imports::start() {
  if (!import_ || bench_.jobs->isBusy()) return;
  if (const auto ready = import_->requireReady(); !ready) return bench_.notices->complain(ready.error());
  import_->suspendPreviews();
  bench_.tools->takeRack(true);  // keeps tool ids unique
  std::vector<MeshToolOrder> orders = import_->toolOrders();
  for (MeshToolOrder& order : orders) {
    for (const SessionTool& known : bench_.tools->forSession()) order.ids_taken.push_back(known.tool.id);
    for (const BrokenTool& broken : bench_.tools->broken()) order.ids_taken.push_back(broken.file.stem().string());
  }
  orders.empty() ? open() : makeTools(std::move(orders));
}

// Tools first: the session of the other files opens with them in its rack.
void Imports::makeTools(std::vector<MeshToolOrder> orders) {
  using Made = std::vector<SessionTool>;
  const std::string title = orders.size() == 1 ? phrase("making a tool of {}", orders.front().file.filename().string())
                                               : phrase("making {} tools", orders.size());
  const auto work = [orders = std::move(orders), folder = bench_.tools->ownFolder()](const Progress& progress) {
    return writeTools(orders, folder, progress);
  };
  const auto take = [this](Expected<Made> made) {
    if (!made) return bench_.notices->complain(made.error());
    takeMadeTools(std::move(*made));
  };
  bench_.jobs->start<Made>(Jobs::Kind::kReads, title, work, take);
}

void Imports::takeMadeTools(std::vector<SessionTool> made) {
  const fs::path first = made.front().file;
  bench_.tools->addMade(std::move(made));
  if (!import_) return;
  import_->toolsAreMade();
  const auto& entries = import_->entries();
  if (std::any_of(entries.begin(), entries.end(), [](const auto& e) { return e.role != ImportRole::kOut; }))
    return open();
  putAway();
  if (bench_.document->isOpen() && !bench_.saw->isBusy()) bench_.sessions->reopen({.tool = first});
}

void Imports::open() {
  if (!import_->cut()) return openBeside();

  const ImportEntry& first = *import_->cut();
  OpeningOptions options = bench_.sessions->openingOptions();
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
    as_shown = phrase("Scan prepared: unit {}, {} repairs, voxel size {:g} mm", scan->unit().unit,
                      scan->preview()->changes.size(), scan->voxel());
  const bool is_alone = options.beside.empty();
  bench_.sessions->openBy(
      names.empty() ? phrase("preparing {}", first.file.filename().string())
                    : phrase("preparing {} with {}", first.file.filename().string(), names),
      [path = first.file, options, as_shown, is_alone](const Progress& progress) -> Expected<Opened> {
        KERF_TRY(opened, openToCut(path, options, progress));
        if (!as_shown.empty() && is_alone && !opened.notes.empty()) opened.notes = {as_shown};
        if (!is_alone)
          opened.notes.insert(opened.notes.begin(),
                              phrase("You cut {}. Switch to a neighbour with neighbour.work-on.", opened.name));
        return std::move(opened);
      });
}

// All entries become neighbours of the open document.
void Imports::openBeside() {
  if (!bench_.document->isOpen())
    return bench_.notices->complain({.code = Error::Code::kBadValue,
                                     .found = "no file with the role cut, and no open session",
                                     .expected = "one file with the role cut",
                                     .hint = "import.role 1 cut"});
  std::vector<OpenBeside> asked;
  for (const ImportEntry& entry : import_->entries())
    if (entry.role == ImportRole::kBeside) asked.push_back({entry.file, entry.file.stem().string(), entry.decided()});
  if (asked.empty()) {  // the open document stays
    bench_.notices->say("Nothing imported: all files are skipped.");
    return putAway();
  }
  const std::string title =
      asked.size() == 1 ? asked.front().path.filename().string() : phrase("{} files", asked.size());
  bench_.neighbours->place(std::move(asked), phrase("preparing {}", title));
}

void Imports::cancel() {
  if (!bench_.jobs->isBusy()) putAway();
}

// A preview stops at its next progress report: waiting for that here would hold up the frame.
void Imports::putAway() {
  drawing.begin(TrimDrawing::What::kNothing);
  std::erase_if(ending_, [](const auto& set) { return set->isIdle(); });
  if (!import_) return;
  import_->suspendPreviews();
  if (!import_->isIdle()) ending_.push_back(std::move(import_));
  import_.reset();
}

}  // namespace kerf
