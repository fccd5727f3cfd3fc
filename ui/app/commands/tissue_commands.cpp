#include "ui/app/commands/command_tables.h"

#include <array>
#include <utility>

#include "ui/app/base/command_words.h"
#include "ui/app/document/document.h"
#include "ui/app/document/view_state.h"

namespace kerf::tissue_commands {
namespace {

constexpr std::array<std::pair<const char*, TissueLook>, 3> kLooks = {
    {{"show", TissueLook::kShow}, {"hide", TissueLook::kHide}, {"ghost", TissueLook::kGhost}}};
constexpr std::array<std::pair<const char*, SurfaceColours>, 5> kTissueColours = {
    {{"tissue", SurfaceColours::kTissue},
     {"scan", SurfaceColours::kScan},
     {"depth", SurfaceColours::kDepth},
     {"distance", SurfaceColours::kDistance},
     {"contact", SurfaceColours::kContact}}};

std::string quoted(AppWords words, std::size_t n) {
  return n < words.size() ? "\"" + words[n] + "\"" : std::string("nothing");
}

bool hasTissues(const AppContext& c) { return c.bench.document->isShown() && !c.bench.views->tissues().all().empty(); }
bool isAnyHidden(const AppContext& c) { return c.bench.document->isShown() && !c.bench.views->tissues().areAllShown(); }
bool hasScanColours(const AppContext& c) {
  return c.bench.document->isShown() && c.bench.views->tissues().hasScanColours();
}
bool hasNeighbours(const AppContext& c) {
  return c.bench.document->isShown() && c.bench.views->tissues().hasNeighbours();
}
bool hasStructures(const AppContext& c) {
  return c.bench.document->isShown() && c.bench.document->structures() && !c.bench.document->structures()->isEmpty();
}

Expected<void> look(AppContext& c, AppWords words) {
  for (const auto& [word, look] : kLooks)
    if (words.size() > 1 && words[1] == word) return c.bench.views->tissues().set(words[0], look);
  return wrongWord(quoted(words, 1), "a tissue, and show, hide or ghost");
}

Expected<void> showAll(AppContext& c, AppWords) {
  c.bench.views->tissues().showAll();
  return {};
}

Expected<void> colours(AppContext& c, AppWords words) {
  for (const auto& [word, colours] : kTissueColours)
    if (!words.empty() && words[0] == word) return c.bench.views->tissues().setColours(colours);
  return wrongWord(quoted(words, 0), "tissue, scan, depth, distance or contact");
}

Expected<void> mapRange(AppContext& c, AppWords words) {
  KERF_TRY(reach, numberOf(words, 0, "MM", MapScale::kLeast, MapScale::kMost));
  if (words.size() > 1 && words[1] != "bands" && words[1] != "smooth")
    return wrongWord("\"" + words[1] + "\"", "bands or smooth");
  TissueDisplay& tissues = c.bench.views->tissues();
  tissues.setMapScale({reach, words.size() > 1 ? words[1] == "bands" : tissues.mapScale().has_bands});
  return {};
}

Expected<void> asLoaded(AppContext& c, AppWords words) {
  TissueDisplay& tissues = c.bench.views->tissues();
  KERF_TRY(is_on, onOrOff(words, tissues.isAsLoadedShown()));
  tissues.showAsLoaded(is_on);
  return {};
}

template <SurfaceColours kOf>
Expected<void> coloursOf(AppContext& context, AppWords) {
  return context.bench.views->tissues().setColours(kOf);
}

constexpr AppCommand kRows[] = {
    {"view.tissue", "", "", "", "NAME show|hide|ghost", "Shows a tissue, hides it, or makes it translucent.",
     hasTissues, look},
    {"view.tissues-all", "View:5", "Show all tissues", "", "", "Shows all tissues.", isAnyHidden, showAll},
    {"view.as-loaded", "View:5", "Show as loaded (hold key)", "V", "[on|off]",
     "Shows the object as loaded, without its cuts, while the key is held; from the menu until the next call.",
     when::isShown, asLoaded},
    {"view.colours", "", "", "", "tissue|scan|depth|distance|contact",
     "Colours the surface by tissue, by scan, by depth below the original surface, by distance to pulp and nerve "
     "canal, or by contact with neighbours. A scan with colours starts with them; its cut areas show the tissue.",
     when::isShown, colours},
    {"view.map-range", "", "", "", "MM [bands|smooth]",
     "Sets the range of the maps of depth and distance, 0.5 to 5 mm, of the contact map 1 to 2 mm; bands: one colour "
     "every 0.5 mm.",
     when::isShown, mapRange},
    {"view.colours-tissue", "View:4>Colours", "Colour by tissue", "", "", "Colours the surface by tissue.",
     when::isShown, coloursOf<SurfaceColours::kTissue>},
    {"view.colours-scan", "View:4>Colours", "Colour by scan", "", "", "Shows the colours of the scan.", hasScanColours,
     coloursOf<SurfaceColours::kScan>},
    {"view.colours-depth", "View:4>Colours", "Colour by depth", "", "",
     "Colours the surface by depth below the original surface.", when::isShown, coloursOf<SurfaceColours::kDepth>},
    {"view.colours-distance", "View:4>Colours", "Colour by pulp and nerve distance", "", "",
     "Colours the surface by distance to pulp and nerve canal.", hasStructures, coloursOf<SurfaceColours::kDistance>},
    {"view.colours-contact", "View:4>Colours", "Contact with neighbours", "", "",
     "Colours the surface by distance to the neighbours as loaded, such as the other jaw: overlap red, contact to "
     "0.2 mm orange, then blue.",
     hasNeighbours, coloursOf<SurfaceColours::kContact>},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::tissue_commands
