#include "ui/app/commands/command_tables.h"

#include <fmt/format.h>

#include <algorithm>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/readout/tool_rack.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tools.h"

namespace kerf::tool_commands {
namespace {

// In the order of the rack with all its tools, favourites first.   @param step  1 or -1.
std::size_t toolBeside(const AppContext& c, std::ptrdiff_t step) {
  RackView view{.shows_all = true};
  if (c.settings) view.favourites = c.settings->values.favourite_tools;
  const std::vector<std::size_t> rows = rackRows(c.bench, view);
  const auto at = std::find(rows.begin(), rows.end(), c.bench.tools->inHand());
  if (at == rows.end()) return c.bench.tools->inHand();
  const auto count = static_cast<std::ptrdiff_t>(rows.size());
  return rows[static_cast<std::size_t>((at - rows.begin() + step + count) % count)];
}

Expected<void> selectTool(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no tool", "its id");
  if (c.bench.tools->select(words[0])) {
    c.is_tool_taken = true;
    return {};
  }
  std::string ids;
  for (std::size_t n = 0; n < c.bench.tools->count(); ++n) ids += (n ? ", " : "") + c.bench.tools->at(n).id;
  return wrongWord("\"" + words[0] + "\"", "one of " + ids);
}

bool hasRack(const AppContext& c) { return c.bench.document->isOpen() && c.settings; }

Expected<void> favourite(AppContext& c, AppWords words) {
  const std::string id = words.empty() ? c.bench.tools->at(c.bench.tools->inHand()).id : words[0];
  std::vector<std::string>& favourites = c.settings->values.favourite_tools;
  if (const auto at = std::find(favourites.begin(), favourites.end(), id); at != favourites.end()) {
    favourites.erase(at);
    return c.settings->save();
  }
  bool is_in_rack = false;
  for (std::size_t n = 0; n < c.bench.tools->count(); ++n) is_in_rack |= c.bench.tools->at(n).id == id;
  if (!is_in_rack) return wrongWord("\"" + id + "\"", "the id of a tool of the rack");
  favourites.push_back(id);
  return c.settings->save();
}

Expected<void> addTool(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.tools->add(path);
  return {};
}

Expected<void> nextTool(AppContext& c, AppWords) {
  c.bench.tools->select(toolBeside(c, 1));
  return {};
}

Expected<void> previousTool(AppContext& c, AppWords) {
  c.bench.tools->select(toolBeside(c, -1));
  return {};
}

bool canTake(const AppContext& c) { return when::isOpen(c) && c.settings && c.settings->values.left_turns; }

Expected<void> take(AppContext& c, AppWords words) {
  if (!words.empty() && words[0] != "on" && words[0] != "off") return wrongWord("\"" + words[0] + "\"", "on or off");
  c.is_tool_taken = words.empty() ? !c.is_tool_taken : words[0] == "on";
  return {};
}

bool hasFiner(const AppContext& c) { return when::isOpenAndIdle(c) && c.bench.tools->finerVoxels().has_value(); }

Expected<void> finerVoxels(AppContext& c, AppWords) {
  c.bench.sessions->prepareFiner(c.bench.tools->finerVoxels()->mm);
  return {};
}

constexpr AppCommand kRows[] = {
    {"tool.select", "", "", "", "ID", "Chooses a tool.", when::isOpen, selectTool},
    {"tool.take", "Tool:1", "Take or put down tool", "E", "[on|off]",
     "While the left button turns the view: gives it to the tool, or back.", canTake, take},
    {"tool.add", "Tool:1", "Add tool...", "", "PATH",
     "Adds a tool file to the rack, or reads it again, and chooses the tool.", when::isIdle, addTool},
    {"tool.next", "Tool:1", "Choose next tool", "]", "", "Chooses the next tool of the rack.", when::isOpen, nextTool},
    {"tool.previous", "Tool:1", "Choose previous tool", "[", "", "Chooses the previous tool of the rack.", when::isOpen,
     previousTool},
    {"tool.favourite", "Tool:1", "Toggle favourite", "", "[ID]",
     "Adds a tool to the favourites at the top of the rack, or removes it (default: the current tool).", hasRack,
     favourite},
    {"tool.finer-voxels", "Tool:1", "Prepare with finer voxels", "", "",
     "Prepares the open scan again with voxels of 0.1 mm for a bur under 2 mm, without the cuts. The session is kept.",
     hasFiner, finerVoxels},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::tool_commands
