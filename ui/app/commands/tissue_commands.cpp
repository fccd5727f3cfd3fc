#include "ui/app/commands/tissue_commands.h"

#include <array>
#include <utility>

#include "ui/app/base/command_words.h"

namespace kerf::tissue_commands {
namespace {

constexpr std::array<std::pair<const char*, TissueLook>, 3> kLooks = {
    {{"show", TissueLook::kShow}, {"hide", TissueLook::kHide}, {"ghost", TissueLook::kGhost}}};
constexpr std::array<std::pair<const char*, SurfaceColours>, 4> kTissueColours = {
    {{"tissue", SurfaceColours::kTissue},
     {"scan", SurfaceColours::kScan},
     {"depth", SurfaceColours::kDepth},
     {"distance", SurfaceColours::kDistance}}};

std::string quoted(AppWords words, std::size_t n) {
  return n < words.size() ? "\"" + words[n] + "\"" : std::string("nothing");
}

}  // namespace

bool hasTissues(const AppContext& c) { return c.bench.isShown() && !c.bench.tissues().all().empty(); }
bool isAnyHidden(const AppContext& c) { return c.bench.isShown() && !c.bench.tissues().areAllShown(); }
bool hasScanColours(const AppContext& c) { return c.bench.isShown() && c.bench.tissues().hasScanColours(); }
bool hasStructures(const AppContext& c) {
  return c.bench.isShown() && c.bench.structures() && !c.bench.structures()->isEmpty();
}

Expected<void> look(AppContext& c, AppWords words) {
  for (const auto& [word, look] : kLooks)
    if (words.size() > 1 && words[1] == word) return c.bench.tissues().set(words[0], look);
  return wrongWord(quoted(words, 1), "a tissue, and show, hide or ghost");
}

Expected<void> showAll(AppContext& c, AppWords) {
  c.bench.tissues().showAll();
  return {};
}

Expected<void> colours(AppContext& c, AppWords words) {
  for (const auto& [word, colours] : kTissueColours)
    if (!words.empty() && words[0] == word) return c.bench.tissues().setColours(colours);
  return wrongWord(quoted(words, 0), "tissue, scan, depth or distance");
}

}  // namespace kerf::tissue_commands
