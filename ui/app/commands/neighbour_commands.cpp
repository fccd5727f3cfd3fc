#include "ui/app/commands/neighbour_commands.h"

#include <algorithm>
#include <optional>
#include <string>

#include "ui/app/base/command_words.h"

namespace kerf::neighbour_commands {
namespace {

// The neighbour named by the n-th word. Without that word: the most cut one, or the first.
Expected<const SceneObject*> neighbourOf(const AppContext& c, AppWords words, std::size_t n) {
  const std::vector<Neighbour> all = c.bench.neighbours();
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
  if (const SceneObject* const found = c.bench.findNeighbour(wanted)) return found;
  return wrongWord("\"" + wanted + "\"", names.empty() ? "something that stands beside" : "one of " + names);
}

}  // namespace

bool hasNeighbours(const AppContext& c) { return c.bench.run() && !c.bench.run()->neighbours().empty(); }
bool hasNeighboursAndIdle(const AppContext& c) { return hasNeighbours(c) && !c.bench.job(); }

Expected<void> openBeside(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.openBeside(path);
  return {};
}

Expected<void> workOn(AppContext& c, AppWords words) {
  KERF_TRY(object, neighbourOf(c, words, 0));
  c.bench.workOn(object->loaded);
  return {};
}

Expected<void> look(AppContext& c, AppWords words) {
  if (words.size() < 2) return wrongWord("too few words", "a neighbour, then show, ghost or hide");
  KERF_TRY(object, neighbourOf(c, words, 0));
  if (words[1] != "show" && words[1] != "ghost" && words[1] != "hide")
    return wrongWord("\"" + words[1] + "\"", "show, ghost or hide");
  c.bench.hidePiece(object->id, words[1] == "hide");
  c.bench.ghostNeighbour(object->id, words[1] == "ghost");
  return {};
}

Expected<void> stopShort(AppContext& c, AppWords words) {
  if (!words.empty() && words[0] == "off") {
    c.bench.stopShortBeside(std::nullopt);
    return {};
  }
  KERF_TRY(mm, numberOr(words, 0, Workbench::kUsualShortBeside, "MM", 0, 2));
  c.bench.stopShortBeside(mm);
  return {};
}

Expected<void> exportBeside(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  KERF_TRY(object, neighbourOf(c, words, 1));
  c.bench.exportTo(path, {.beside = object->loaded});
  return {};
}

}  // namespace kerf::neighbour_commands
