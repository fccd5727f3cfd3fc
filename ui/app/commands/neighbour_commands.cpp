#include "ui/app/commands/command_tables.h"

#include <algorithm>
#include <optional>
#include <string>

#include "ui/app/base/command_words.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/results.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/strokes.h"

namespace kerf::neighbour_commands {
namespace {

// The neighbour named by the n-th word. Without that word: the most cut one, or the first.
Expected<const SceneObject*> neighbourOf(const AppContext& c, AppWords words, std::size_t n) {
  const std::vector<Neighbour> all = c.bench.neighbours->list();
  std::string wanted, names;
  const Neighbour* most = nullptr;
  for (const Neighbour& other : all) {
    names += (names.empty() ? "" : ", ") + other.name;
    if (!most || other.removed_mm3 > most->removed_mm3) most = &other;
  }
  if (n < words.size())
    wanted = words[n];
  else if (most)
    wanted = most->name;
  if (const SceneObject* const found = c.bench.neighbours->find(wanted)) return found;
  return wrongWord("\"" + wanted + "\"", names.empty() ? "a neighbour" : "one of " + names);
}

bool hasNeighbours(const AppContext& c) {
  return c.bench.document->run() && !c.bench.document->run()->neighbours().empty();
}
bool hasNeighboursAndIdle(const AppContext& c) { return hasNeighbours(c) && !c.bench.jobs->running(); }

Expected<void> openBeside(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.neighbours->openBeside(path);
  return {};
}

Expected<void> workOn(AppContext& c, AppWords words) {
  KERF_TRY(object, neighbourOf(c, words, 0));
  c.bench.neighbours->workOn(object->loaded);
  return {};
}

Expected<void> removeNeighbour(AppContext& c, AppWords words) {
  KERF_TRY(object, neighbourOf(c, words, 0));
  return c.bench.neighbours->remove(object->loaded);
}

Expected<void> look(AppContext& c, AppWords words) {
  if (words.size() < 2) return wrongWord("too few words", "a neighbour, then show, ghost or hide");
  KERF_TRY(object, neighbourOf(c, words, 0));
  if (words[1] != "show" && words[1] != "ghost" && words[1] != "hide")
    return wrongWord("\"" + words[1] + "\"", "show, ghost or hide");
  c.bench.pieces->hide(object->id, words[1] == "hide");
  if (words[1] != "hide") c.bench.neighbours->makeGhost(object->id, words[1] == "ghost");
  return {};
}

Expected<void> stopShort(AppContext& c, AppWords words) {
  if (!words.empty() && words[0] == "off") {
    c.bench.strokes->stopShortBeside(std::nullopt);
    return {};
  }
  KERF_TRY(mm, numberOr(words, 0, Strokes::kUsualShortBeside, "MM", 0, 2));
  c.bench.strokes->stopShortBeside(mm);
  return {};
}

Expected<void> exportBeside(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  KERF_TRY(object, neighbourOf(c, words, 1));
  c.bench.results->exportTo(path, {.beside = object->loaded});
  return {};
}

constexpr AppCommand kRows[] = {
    {"file.open-beside", "File:1", "Open as neighbour...", "", "PATH",
     "Adds a scan, a recipe or a case as a neighbour at its scan position: an adjacent tooth, the other jaw.",
     when::isIdle, openBeside},
    {"file.export-beside", "", "", "", "PATH [NEIGHBOUR]",
     "Writes a neighbour with its cuts (default: the neighbour with the largest removed volume).", hasNeighboursAndIdle,
     exportBeside},
    {"cut.spare-neighbours", "", "", "", "[MM|off]", "Stops strokes at this distance from neighbours (default 0.2 mm).",
     when::always, stopShort},
    {"neighbour.look", "", "", "", "NEIGHBOUR show|ghost|hide",
     "Shows a neighbour, hides it, or makes it a ghost: translucent and not clickable. The tool still touches it.",
     hasNeighbours, look},
    {"neighbour.work-on", "Piece", "Switch to neighbour", "", "[NEIGHBOUR]",
     "Ends the session and opens the case of the neighbour. The previous object becomes its neighbour.",
     hasNeighboursAndIdle, workOn},
    {"neighbour.remove", "Piece", "Remove neighbour", "", "[NEIGHBOUR]",
     "Takes a neighbour away from an object without cuts: the tool no longer touches it. Its file stays.",
     hasNeighboursAndIdle, removeNeighbour},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::neighbour_commands
