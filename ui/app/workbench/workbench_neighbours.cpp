// Neighbours of the object in work. The rest of the workbench: workbench.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "ui/app/base/language.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

namespace fs = std::filesystem;

// ---- Opening

void Workbench::openAll(const std::vector<fs::path>& paths) {
  const std::vector<fs::path> objects = takeTools(paths);
  if (objects.empty()) return;
  if (objects.size() == 1) return beginImport(objects.front());

  OpeningOptions options = openingOptions();
  std::string names;
  for (std::size_t n = 1; n < objects.size(); ++n) {
    options.beside.push_back({objects[n], {}, options.prepare});
    names += (n > 1 ? ", " : "") + objects[n].filename().string();
  }
  const fs::path first = objects.front();
  openBy(phrase("opening {} with {} beside", first.filename().string(), names),
         [first, options](const Progress& progress) -> Expected<Opened> {
           KERF_TRY(opened, openToCut(first, options, progress));
           opened.notes.insert(opened.notes.begin(),
                               phrase("{} is worked on; to work on another one: neighbour.work-on", opened.name));
           return std::move(opened);
         });
}

void Workbench::openBeside(const fs::path& path) {
  if (isBusy() || isSawing()) return;
  if (!run_) return open(path);
  const std::string name = (path.has_filename() ? path : path.parent_path()).stem().string();
  placeBeside({{path, name, openingOptions().prepare}}, phrase("preparing {}", path.filename().string()));
}

// The import stays until this is done, for another remedy.
void Workbench::placeBeside(std::vector<OpenBeside> asked, const std::string& title) {
  if (!run_ || isSawing()) return;
  struct Prepared {
    std::vector<CaseBeside> beside;
    std::vector<std::string> notes;
  };
  std::vector<std::string> known{run_->caseManifest().id};
  for (const LiveNeighbour& other : run_->neighbours()) known.push_back(other.known.manifest.id);
  std::vector<fs::path> paths;
  for (const OpenBeside& one : asked) paths.push_back(one.path);
  auto job = std::make_unique<Job<Prepared>>(
      title,
      [asked = std::move(asked), known, options = openingOptions()](const Progress& progress) -> Expected<Prepared> {
        Prepared out;
        std::vector<std::string> ids = known;
        for (const OpenBeside& one : asked) {
          KERF_TRY(folder, prepareToStandBeside(one, options, out.notes, progress));
          KERF_TRY(manifest, readCaseManifest(folder));
          if (std::find(ids.begin(), ids.end(), manifest.id) != ids.end())
            return fail({.code = Error::Code::kBadValue,
                         .file = one.path.string(),
                         .found = "it is in the scene already: two solids in one place",
                         .expected = "another tooth or jaw of the same scan frame",
                         .hint = "open each once"});
          ids.push_back(manifest.id);
          out.beside.push_back({folder, one.name});
        }
        return out;
      });
  job_writes_ = false;
  when_over_ = [this, job = job.get(), paths] {
    auto prepared = job->take();
    if (!prepared) return complain(prepared.error());
    for (std::string& note : prepared->notes) say(std::move(note));
    if (!run_) return;
    putImportAway();
    // Protects the opened files from overwriting, wherever their cases are.
    sources_beside_.insert(sources_beside_.end(), paths.begin(), paths.end());
    reopenWith({}, std::move(prepared->beside));
  };
  job_ = std::move(job);
}

void Workbench::workOn(std::size_t number) {
  if (isBusy() || isSawing() || !run_ || number < 1 || number > run_->neighbours().size()) return;
  OpeningOptions options = openingOptions();
  options.beside.push_back({run_->caseFolder(), name_, {}});
  for (std::size_t n = 0; n < run_->neighbours().size(); ++n)
    if (const SessionNeighbour& other = run_->neighbours()[n].known; n + 1 != number)
      options.beside.push_back({other.folder, other.name, {}});
  const SessionNeighbour& wanted = run_->neighbours()[number - 1].known;
  openBy(phrase("opening {}", wanted.name),
         [folder = wanted.folder, name = wanted.name, options](const Progress& progress) -> Expected<Opened> {
           KERF_TRY(opened, openToCut(folder, options, progress));
           opened.notes.insert(opened.notes.begin(), phrase("{} is worked on, as in its case", name));
           opened.name = name;
           return std::move(opened);
         });
}

// ---- Poses and removed volume of neighbours

std::vector<Neighbour> Workbench::neighbours() const {
  std::vector<Neighbour> out;
  if (!run_) return out;
  for (const LiveNeighbour& other : run_->neighbours()) {
    const std::size_t n = out.size();
    out.push_back({n + 1, other.known.name, cut_off_[n].now_mm3, other.known.removed_mm3});
  }
  return out;
}

const SceneObject* Workbench::findNeighbour(const std::string& name) const {
  for (const SceneObject* object : scene_.shown())
    if (object->isBeside() && (object->name == name || std::to_string(object->loaded) == name)) return object;
  return nullptr;
}

void Workbench::ghostNeighbour(std::uint32_t id, bool is_ghost) {
  if (SceneObject* const object = scene_.find(id); object && object->isBeside()) object->is_ghost = is_ghost;
}

// Warns if a command that needs the object in work names a neighbour.
bool Workbench::isNeighbour(std::uint32_t id, const std::string& what) {
  const SceneObject* const object = scene_.find(id);
  if (!object || !object->isBeside()) return false;
  std::string text = fmt::format("{} stands beside and is not there {}", object->name, what);
  if (notices_.empty() || notices_.back().text != text) say(std::move(text));
  return true;
}

// Warns once a stroke has ended and cutting stops. During the cut the readings show the volume.
void Workbench::warnOfNeighbours() {
  constexpr std::uint64_t kTicks = 100;
  constexpr double kLeast = 1e-5;  // mm^3
  for (std::size_t n = 0; n < cut_off_.size(); ++n) {
    double now = 0;
    for (std::size_t m = 0; m < report_.object_count; ++m)
      if (report_.objects[m].loaded == n + 1) now += report_.objects[m].removed_mm3;

    CutOff& known = cut_off_[n];
    if (now != known.now_mm3) known.tick = report_.tick;
    known.now_mm3 = now;
    known.told_mm3 = std::min(known.told_mm3, now);  // an undo reduced it
    const bool is_at_work = stroke_ || saw_->isCutting() || report_.tick < known.tick + kTicks;
    if (is_at_work || now < known.told_mm3 + kLeast) continue;
    known.told_mm3 = now;
    say(phrase("you have cut the neighbour {}: {:.4f} mm3. Undo takes it back", run_->neighbours()[n].known.name, now));
  }
}

std::optional<NearNeighbour> Workbench::nearNeighbour(const std::optional<ToolOverSurface>& over) const {
  constexpr double kStopped = 0.03;  // mm: the closest approach of a held button to its limit
  if (!run_ || neighbour_fields_.empty() || (!stroke_ && !over && !saw_->isCutting())) return {};
  const bool is_at_work = stroke_ || saw_->isCutting();
  const Rigid3 tool = is_at_work ? report_.output.T_world_tool : over->T_world_tool;

  std::optional<NearNeighbour> out;
  for (std::size_t n = 0; n < neighbour_fields_.size(); ++n) {
    const KeepOut::Reading reading = neighbour_fields_[n]->read(samplesOf(tool_), tool);
    if (out && reading.distance >= out->distance_mm) continue;
    out = NearNeighbour{run_->neighbours()[n].known.name, reading.distance, reading.is_far};
  }
  out->is_stopped =
      stroke_ && stop_short_beside_mm && !out->is_far && out->distance_mm <= *stop_short_beside_mm + kStopped;
  return out;
}

void Workbench::stopShortBeside(std::optional<double> mm) {
  stop_short_beside_mm = mm;
  if (stroke_) sendAim();
}

}  // namespace kerf
