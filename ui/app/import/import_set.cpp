#include "ui/app/import/import_set.h"
#include "ui/app/base/language.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace kerf {
namespace {

namespace fs = std::filesystem;

Box3 boxOf(const ImportEntry& entry) {
  if (entry.scan) return entry.scan->boxMm();
  return entry.labels ? entry.labels->found().box : Box3();
}

// Distance of two boxes, mm; 0: they meet.
double gapBetween(const Box3& a, const Box3& b) {
  const Vec3d apart = (a.min - b.max).cwiseMax(b.min - a.max).cwiseMax(0.0);
  return apart.norm();
}

// Both units are guesses and differ, although files of one frame share a unit.
bool doUnitsDiffer(const ImportEntry* cut, const ImportEntry& beside) {
  if (!cut || !cut->scan || !beside.scan || beside.role != ImportRole::kBeside) return false;
  const bool are_guessed = cut->scan->isUnitGuessed() && beside.scan->isUnitGuessed();
  return are_guessed && cut->scan->unit().scale_to_mm != beside.scan->unit().scale_to_mm;
}

Expected<void> requireFile(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_directory(file, ignored)) return {};
  return fail({.code = Error::Code::kUnsupported,
               .file = file.string(),
               .found = isFolderOfMeshes(file) ? "a folder with meshes"
                                               : "a folder without slices of a CT that is no case, session or recipe",
               .expected = "a folder with only a DICOM series or label slices, or a file",
               .hint = "drop the files in it, several together"});
}

}  // namespace

Expected<ImportRead> readToImport(const fs::path& file, const Progress& progress) {
  ImportRead out;
  out.file = file;
  out.kind = kindOf(file);
  switch (out.kind) {
    case FileKind::kScan: {
      KERF_CHECK(requireFile(file));
      KERF_TRY(scan, readScan(file, progress));
      out.scan = std::move(scan);
      break;
    }
    case FileKind::kLabels: {
      KERF_TRY(labels, readLabels(file, progress));
      out.labels = std::move(labels);
      break;
    }
    case FileKind::kRecipe:
    case FileKind::kCase:
      break;
    case FileKind::kRun:
    case FileKind::kSessionFile:
    case FileKind::kTool:
      return fail({.code = Error::Code::kUnsupported,
                   .file = file.string(),
                   .found = out.kind == FileKind::kTool ? "a tool" : "a session",
                   .expected = "scans, label volumes, recipes and cases",
                   .hint = "open it alone"});
  }
  return out;
}

std::string ImportEntry::what() const {
  switch (kind) {
    case FileKind::kLabels:
      return "labels of a CT";
    case FileKind::kRecipe:
      return "recipe";
    case FileKind::kCase:
      return "case";
    case FileKind::kScan:
    case FileKind::kTool:
    case FileKind::kRun:
    case FileKind::kSessionFile:
      break;
  }
  return "scan";
}

PrepareOptions ImportEntry::decided() const {
  if (scan) return scan->result();
  PrepareOptions out;
  if (labels)
    out.recipe = labels->recipe();
  else
    out = told;
  return out;
}

ImportSet::ImportSet(std::vector<ImportRead> read, const PrepareOptions& defaults, const MaterialTable& materials)
    : defaults_(defaults), materials_(materials) {
  add(std::move(read));
  chosen_ = 0;
}

void ImportSet::add(std::vector<ImportRead> read) {
  const std::size_t first = entries_.size();
  for (ImportRead& one : read) {
    ImportEntry entry;
    entry.file = one.file;
    entry.kind = one.kind;
    entry.told = defaults_;
    entry.role = entries_.empty() ? ImportRole::kCut : ImportRole::kBeside;
    if (one.scan) entry.scan = std::make_unique<ImportPlan>(std::move(*one.scan), defaults_);
    if (one.labels) entry.labels = std::make_unique<LabelPlan>(std::move(*one.labels), materials_, defaults_.voxel_mm);
    entries_.push_back(std::move(entry));
  }
  choose(first);
}

// Suspends the preview of the previous choice.
void ImportSet::choose(std::size_t n) {
  if (n >= entries_.size() || n == chosen_) return;
  if (plan()) plan()->suspendPreview();
  chosen_ = n;
}

const ImportEntry* ImportSet::cut() const {
  const auto at =
      std::find_if(entries_.begin(), entries_.end(), [](const auto& e) { return e.role == ImportRole::kCut; });
  return at == entries_.end() ? nullptr : &*at;
}

ToolPlan* ImportSet::tool() const {
  const ImportEntry& entry = entries_[chosen_];
  if (entry.tool) entry.tool->setScale(entry.scan->unit().scale_to_mm);
  return entry.tool.get();
}

std::vector<MeshToolOrder> ImportSet::toolOrders() const {
  std::vector<MeshToolOrder> out;
  for (const ImportEntry& entry : entries_) {
    if (!entry.tool) continue;
    const UnitOption& unit = entry.scan->unit();
    entry.tool->setScale(unit.scale_to_mm);
    out.push_back({entry.file,
                   entry.scan->found().mesh,
                   unit.scale_to_mm,
                   unit.unit,
                   entry.scan->closing(),
                   entry.tool->way(),
                   entry.tool->cutBelow(),
                   entry.tool->id(),
                   {}});
  }
  return out;
}

void ImportSet::toolsAreMade() {
  for (ImportEntry& entry : entries_) {
    if (!entry.tool) continue;
    entry.tool.reset();
    entry.role = ImportRole::kOut;
  }
}

Expected<void> ImportSet::setRole(std::size_t n, ImportRole role, bool may_lack_cut) {
  if (n >= entries_.size())
    return fail({.code = Error::Code::kBadValue,
                 .found = fmt::format("file {}", n + 1),
                 .expected = fmt::format("1 to {}", entries_.size())});
  ImportEntry& entry = entries_[n];
  if (entry.role == role) return {};
  if (role == ImportRole::kTool && !entry.scan)
    return fail({.code = Error::Code::kUnsupported,
                 .place = entry.file.filename().string(),
                 .found = "a " + entry.what(),
                 .expected = "a mesh for a tool"});
  const bool is_last_cut = cut() == &entry || !cut();
  const bool is_put_beside = role == ImportRole::kBeside || role == ImportRole::kOut;
  if (is_last_cut && is_put_beside && !may_lack_cut)
    return fail({.code = Error::Code::kBadValue,
                 .place = entry.file.filename().string(),
                 .found = "no file with the role cut",
                 .expected = "one file with the role cut",
                 .hint = "give the role cut to another file first"});
  if (role == ImportRole::kCut)
    for (ImportEntry& other : entries_)
      if (other.role == ImportRole::kCut) other.role = ImportRole::kBeside;
  const bool was_cut = entry.role == ImportRole::kCut;
  entry.role = role;
  entry.tool.reset();
  if (role != ImportRole::kTool) return {};

  KERF_CHECK(entry.scan->setTrims({}));  // a tool is the whole mesh
  const ScanFound& found = entry.scan->found();
  entry.tool = std::make_unique<ToolPlan>(entry.file, found.mesh, entry.scan->unit().scale_to_mm);
  const auto next = std::find_if(entries_.begin(), entries_.end(),
                                 [](const ImportEntry& other) { return other.role == ImportRole::kBeside; });
  if (was_cut && !may_lack_cut && next != entries_.end()) next->role = ImportRole::kCut;
  return {};
}

std::vector<Finding> ImportSet::findings() const {
  constexpr double kFar = 20;  // mm: neighbours of one frame are nearer
  std::vector<Finding> out;
  if (!cut()) return out;
  const Box3 first = boxOf(*cut());
  for (const ImportEntry& entry : entries_) {
    if (entry.role != ImportRole::kBeside) continue;
    const std::string name = entry.file.filename().string();
    if (doUnitsDiffer(cut(), entry))
      out.push_back({Finding::Weight::kDoubtful, "Unit",
                     fmt::format("{} is read as {}, {} as {}: choose the unit of one of them", name,
                                 entry.scan->unit().unit, cut()->file.filename().string(), cut()->scan->unit().unit)});
    const Box3 box = boxOf(entry);
    if (box.isEmpty() || first.isEmpty()) continue;
    if (const double gap = gapBetween(first, box); gap > kFar)
      out.push_back(
          {Finding::Weight::kDoubtful, "Frame",
           phrase("{} is {:.0f} mm away: scans of one frame touch or nearly touch. Check that both share a frame", name,
                  gap)});
  }
  return out;
}

Expected<void> ImportSet::requireReady() const {
  for (const ImportEntry& entry : entries_)
    if (entry.role != ImportRole::kOut && entry.labels && entry.labels->isEmpty())
      return fail({.code = Error::Code::kEmpty,
                   .file = entry.file.string(),
                   .found = "no tissue: all labels are skipped",
                   .expected = "a tissue for at least one label",
                   .hint = "import.tissue LABEL TISSUE"});
  for (const ImportEntry& entry : entries_)
    if (doUnitsDiffer(cut(), entry))
      return fail({.code = Error::Code::kBadValue,
                   .file = entry.file.string(),
                   .place = "unit",
                   .found = fmt::format("{} by size, but {} for {}", entry.scan->unit().unit, cut()->scan->unit().unit,
                                        cut()->file.string()),
                   .expected = "one unit for all files of a frame",
                   .hint = "choose the unit of one of them, for example import.unit mm"});
  return {};
}

Prediction ImportSet::prediction() const {
  constexpr double kProgram = 5.5e8;  // bytes of the program itself, in each prediction; counted once
  Prediction out;
  for (const ImportEntry& entry : entries_) {
    const bool is_prepared = entry.role == ImportRole::kCut || entry.role == ImportRole::kBeside;
    if (!is_prepared || !entry.plan()) continue;
    const Prediction one = entry.plan()->prediction();
    out.seconds += one.seconds;
    out.bytes += out.bytes > 0 ? std::max(one.bytes - kProgram, 0.0) : one.bytes;
    out.surface_triangles += one.surface_triangles;
  }
  return out;
}

double ImportSet::freeBytes() const {
  for (const ImportEntry& entry : entries_)
    if (entry.plan()) return entry.plan()->freeBytes();
  return 0;
}

// ---- Previews

PreviewedPlan* ImportEntry::plan() const { return scan ? static_cast<PreviewedPlan*>(scan.get()) : labels.get(); }

void ImportSet::update() {
  for (std::size_t n = 0; n < entries_.size(); ++n)
    // Other files only finish a running preview.
    if (PreviewedPlan* const plan = entries_[n].plan(); plan && (n == chosen_ || plan->previewJob())) plan->update();
}

void ImportSet::suspendPreviews() {
  for (const ImportEntry& entry : entries_)
    if (entry.plan()) entry.plan()->suspendPreview();
}

bool ImportSet::isIdle() const {
  return std::all_of(entries_.begin(), entries_.end(),
                     [](const ImportEntry& entry) { return !entry.plan() || entry.plan()->isIdle(); });
}

ImportPicture ImportSet::picture(bool shows_solid) const {
  ImportPicture out;
  out.of = entries_.front().file.string();
  if (scan()) {
    out.up = scan()->found().up;
    out.of += scan()->unit().unit;
  }
  for (std::size_t n = 0; n < entries_.size(); ++n) {
    const ImportEntry& entry = entries_[n];
    const bool is_chosen = n == chosen_;
    if (entry.role == ImportRole::kOut && !is_chosen) continue;
    const ClosedPreview* const solid = entry.plan() ? entry.plan()->preview() : nullptr;
    if (solid && (entry.labels || shows_solid))
      out.parts.push_back({solid->solid, 1, false, !is_chosen});
    else if (entry.scan)
      out.parts.push_back(
          {entry.scan->mesh(), entry.scan->unit().scale_to_mm, !entry.scan->check().isClosed(), !is_chosen});
    const Box3 box = boxOf(entry);
    if (!box.isEmpty()) {
      out.box.add(box.min);
      out.box.add(box.max);
    }
  }
  return out;
}

}  // namespace kerf
