#include "ui/app/workbench/scene_neighbours.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

struct Prepared {
  std::vector<CaseBeside> beside;
  std::vector<std::string> notes;
};

// @param known  ids of the cases in the scene.
Expected<Prepared> prepare(const std::vector<OpenBeside>& asked, std::vector<std::string> known,
                           const OpeningOptions& options, const Progress& progress) {
  Prepared out;
  for (const OpenBeside& one : asked) {
    KERF_TRY(folder, prepareToStandBeside(one, options, out.notes, progress));
    KERF_TRY(manifest, readCaseManifest(folder));
    if (std::find(known.begin(), known.end(), manifest.id) != known.end())
      return fail({.code = Error::Code::kBadValue,
                   .file = one.path.string(),
                   .found = "already in the scene: two solids in one place",
                   .expected = "another tooth or jaw of the same scan frame",
                   .hint = "open each file once"});
    known.push_back(manifest.id);
    out.beside.push_back({folder, one.name});
  }
  return out;
}

}  // namespace

void SceneNeighbours::opened(Opening /*how*/) {
  const LiveRun* const run = bench_.document->run();
  cut_off_.assign(run ? run->neighbours().size() : 0, {});
}

// ---- Opening

void SceneNeighbours::openBeside(const fs::path& path) {
  if (bench_.jobs->isBusy() || bench_.saw->isBusy()) return;
  if (!bench_.document->isOpen()) return bench_.sessions->open(path);
  const std::string name = (path.has_filename() ? path : path.parent_path()).stem().string();
  place({{path, name, bench_.sessions->openingOptions().prepare}}, phrase("preparing {}", path.filename().string()));
}

void SceneNeighbours::place(std::vector<OpenBeside> asked, const std::string& title) {
  const LiveRun* const run = bench_.document->run();
  if (!run || bench_.saw->isBusy()) return;
  std::vector<std::string> known{run->caseManifest().id};
  for (const LiveNeighbour& other : run->neighbours()) known.push_back(other.known.manifest.id);
  std::vector<fs::path> paths;
  for (const OpenBeside& one : asked) paths.push_back(one.path);

  const auto work = [asked = std::move(asked), known, options = bench_.sessions->openingOptions()](
                        const Progress& progress) { return prepare(asked, known, options, progress); };
  const auto take = [this, paths](Expected<Prepared> prepared) {
    if (!prepared) return bench_.notices->complain(prepared.error());
    for (std::string& note : prepared->notes) bench_.notices->say(std::move(note));
    if (!bench_.document->isOpen()) return;
    bench_.imports->putAway();
    bench_.sessions->reopen({.further = std::move(prepared->beside), .further_sources = paths});
  };
  bench_.jobs->start<Prepared>(Jobs::Kind::kReads, title, work, take);
}

void SceneNeighbours::workOn(std::size_t number) {
  if (bench_.jobs->isBusy() || bench_.saw->isBusy() || !bench_.document->isOpen()) return;
  const LiveRun& run = *bench_.document->run();
  if (number < 1 || number > run.neighbours().size()) return;
  OpeningOptions options = bench_.sessions->openingOptions();
  options.beside.push_back({run.caseFolder(), bench_.document->name(), {}});
  for (std::size_t n = 0; n < run.neighbours().size(); ++n)
    if (const SessionNeighbour& other = run.neighbours()[n].known; n + 1 != number)
      options.beside.push_back({other.folder, other.name, {}});
  const SessionNeighbour& wanted = run.neighbours()[number - 1].known;
  bench_.sessions->openBy(
      phrase("opening {}", wanted.name),
      [folder = wanted.folder, name = wanted.name, options](const Progress& progress) -> Expected<Opened> {
        KERF_TRY(opened, openToCut(folder, options, progress));
        opened.notes.insert(opened.notes.begin(), phrase("You now cut {}, as stored in its case.", name));
        opened.name = name;
        return std::move(opened);
      });
}

Expected<void> SceneNeighbours::remove(std::size_t number) {
  if (bench_.jobs->isBusy() || bench_.saw->isBusy() || !bench_.document->isOpen()) return {};
  const LiveRun& run = *bench_.document->run();
  if (number < 1 || number > run.neighbours().size()) return {};
  const SessionNeighbour& wanted = run.neighbours()[number - 1].known;
  if (!run.from().empty() || bench_.steps->done() > 0 || !bench_.document->isAnswered())
    return fail({.code = Error::Code::kUnsupported,
                 .place = wanted.name,
                 .found = "a session with cuts, which keeps its neighbours",
                 .expected = "an object without cuts",
                 .hint = "undo all steps (edit.begin), or open the object again without this neighbour"});
  bench_.sessions->reopen({.without = wanted.manifest.id});
  return {};
}

// ---- Poses and removed volume

std::vector<Neighbour> SceneNeighbours::list() const {
  std::vector<Neighbour> out;
  if (!bench_.document->isOpen()) return out;
  for (const LiveNeighbour& other : bench_.document->run()->neighbours()) {
    const std::size_t n = out.size();
    out.push_back({n + 1, other.known.name, cut_off_[n].now_mm3, other.known.removed_mm3});
  }
  return out;
}

const SceneObject* SceneNeighbours::find(const std::string& name) const {
  const SceneObject* by_number = nullptr;
  for (const SceneObject* object : bench_.document->scene().shown()) {
    if (!object->isBeside()) continue;
    if (object->name == name) return object;
    if (!by_number && std::to_string(object->loaded) == name) by_number = object;
  }
  return by_number;
}

void SceneNeighbours::makeGhost(std::uint32_t id, bool is_ghost) {
  if (SceneObject* const object = bench_.document->scene().find(id); object && object->isBeside())
    object->is_ghost = is_ghost;
}

bool SceneNeighbours::isNeighbour(std::uint32_t id, const std::string& use) {
  const SceneObject* const object = bench_.document->scene().find(id);
  if (!object || !object->isBeside()) return false;
  std::string text = fmt::format("{} is a neighbour and cannot {}", object->name, use);
  const std::vector<Notice>& notices = bench_.notices->list();
  if (notices.empty() || notices.back().text != text) bench_.notices->say(std::move(text));
  return true;
}

// Warns once a stroke has ended and cutting stops. During the cut the readings show the volume.
void SceneNeighbours::update() {
  constexpr std::uint64_t kTicks = 100;
  constexpr double kLeast = 1e-5;  // mm^3
  if (!bench_.document->isOpen() || !bench_.document->hasNews()) return;
  const HapticReport& report = bench_.document->report();
  for (std::size_t n = 0; n < cut_off_.size(); ++n) {
    double now = 0;
    for (std::size_t m = 0; m < report.object_count; ++m)
      if (report.objects[m].loaded == n + 1) now += report.objects[m].removed_mm3;

    CutOff& known = cut_off_[n];
    if (now != known.now_mm3) known.tick = report.tick;
    known.now_mm3 = now;
    known.told_mm3 = std::min(known.told_mm3, now);  // an undo reduced it
    const bool is_at_work = bench_.strokes->isPressed() || bench_.saw->isCutting() || report.tick < known.tick + kTicks;
    if (is_at_work || now < known.told_mm3 + kLeast) continue;
    known.told_mm3 = now;
    bench_.notices->say(phrase("You cut the neighbour {}: {:.4f} mm3 removed. Undo reverts this.",
                               bench_.document->run()->neighbours()[n].known.name, now));
  }
}

}  // namespace kerf
