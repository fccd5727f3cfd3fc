#include "ui/app/commands/tool_commands.h"

#include <fmt/format.h>

#include <algorithm>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/commands/settings.h"
#include "ui/app/workbench/tool_rack.h"

namespace kerf::tool_commands {
namespace {

// In the order of the rack with all its tools, favourites first.   @param step  1 or -1.
std::size_t toolBeside(const AppContext& c, std::ptrdiff_t step) {
  RackView view{.shows_all = true};
  if (c.settings) view.favourites = c.settings->values.favourite_tools;
  const std::vector<std::size_t> rows = rackRows(c.bench, view);
  const auto at = std::find(rows.begin(), rows.end(), c.bench.toolInHand());
  if (at == rows.end()) return c.bench.toolInHand();
  const auto count = static_cast<std::ptrdiff_t>(rows.size());
  return rows[static_cast<std::size_t>((at - rows.begin() + step + count) % count)];
}

}  // namespace

Expected<void> selectTool(AppContext& c, AppWords words) {
  if (words.empty()) return wrongWord("no tool", "its id");
  if (c.bench.selectTool(words[0])) return {};
  std::string ids;
  for (std::size_t n = 0; n < c.bench.toolCount(); ++n) ids += (n ? ", " : "") + c.bench.tool(n).id;
  return wrongWord("\"" + words[0] + "\"", "one of " + ids);
}

bool hasRack(const AppContext& c) { return c.bench.isOpen() && c.settings; }

Expected<void> favourite(AppContext& c, AppWords words) {
  const std::string id = words.empty() ? c.bench.tool(c.bench.toolInHand()).id : words[0];
  std::vector<std::string>& favourites = c.settings->values.favourite_tools;
  if (const auto at = std::find(favourites.begin(), favourites.end(), id); at != favourites.end()) {
    favourites.erase(at);
    return c.settings->save();
  }
  bool is_in_rack = false;
  for (std::size_t n = 0; n < c.bench.toolCount(); ++n) is_in_rack |= c.bench.tool(n).id == id;
  if (!is_in_rack) return wrongWord("\"" + id + "\"", "the id of a tool of the rack");
  favourites.push_back(id);
  return c.settings->save();
}

Expected<void> addTool(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.addTool(path);
  return {};
}

Expected<void> nextTool(AppContext& c, AppWords) {
  c.bench.selectTool(toolBeside(c, 1));
  return {};
}

Expected<void> previousTool(AppContext& c, AppWords) {
  c.bench.selectTool(toolBeside(c, -1));
  return {};
}

Expected<void> setForce(AppContext& c, AppWords words) {
  KERF_TRY(force, numberOf(words, 0, "NEWTONS", Workbench::kLeastForce, Workbench::kMostForce));
  c.bench.setForce(force);
  return {};
}

Expected<void> setDepth(AppContext& c, AppWords words) {
  KERF_TRY(depth, numberOf(words, 0, "MM", 0, c.bench.mostDepth()));
  c.bench.deepen(depth - c.bench.depth_mm);
  return {};
}

Expected<void> deeper(AppContext& c, AppWords words) {
  KERF_TRY(mm, numberOr(words, 0, 0.1, "MM", 0, c.bench.mostDepth()));
  c.bench.deepen(mm);
  return {};
}

Expected<void> shallower(AppContext& c, AppWords words) {
  KERF_TRY(mm, numberOr(words, 0, 0.1, "MM", 0, c.bench.mostDepth()));
  c.bench.deepen(-mm);
  return {};
}

Expected<void> stopShort(AppContext& c, AppWords words) {
  if (!words.empty() && words[0] == "off") {
    c.bench.stopShort(std::nullopt);
    return {};
  }
  KERF_TRY(mm, numberOr(words, 0, Workbench::kUsualShort, "MM", 0, Workbench::kMostShort));
  c.bench.stopShort(mm);
  return {};
}

Expected<void> press(AppContext& c, AppWords words) {
  KERF_TRY(ray, rayOf(c, words));
  if (c.bench.press(ray)) return {};
  return wrongWord(fmt::format("nothing to cut at {}, {}", words[0], words[1]), "a pixel of the object");
}

Expected<void> drag(AppContext& c, AppWords words) {
  KERF_TRY(ray, rayOf(c, words));
  c.bench.drag(ray);
  return {};
}

Expected<void> release(AppContext& c, AppWords) {
  c.bench.release();
  return {};
}

}  // namespace kerf::tool_commands
