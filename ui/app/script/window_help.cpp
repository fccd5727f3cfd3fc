#include "ui/app/script/window_help.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "ui/app/commands/app_commands.h"

namespace kerf {
namespace {

// "view" of "view.roll".
std::string_view topicOf(const AppCommand& command) { return command.id.substr(0, command.id.find('.')); }

// Menus in the order of the table.
std::vector<std::string_view> menus() {
  std::vector<std::string_view> out;
  for (const AppCommand& command : appCommands())
    if (!command.menu.empty() && std::find(out.begin(), out.end(), kerf::menuOf(command)) == out.end())
      out.push_back(kerf::menuOf(command));
  return out;
}

// The menu of a command. Of a command without one: the menu with most commands of its topic; empty if none.
std::string_view menuOf(const AppCommand& command, const std::vector<std::string_view>& all) {
  if (!command.menu.empty()) return kerf::menuOf(command);

  std::string_view best;
  std::ptrdiff_t most = 0;
  for (const std::string_view menu : all) {
    const std::ptrdiff_t count = std::count_if(
        appCommands().begin(), appCommands().end(),
        [&](const AppCommand& other) { return kerf::menuOf(other) == menu && topicOf(other) == topicOf(command); });
    if (count <= most) continue;
    most = count;
    best = menu;
  }
  return best;
}

HelpEntry entryOf(const AppCommand& command) {
  std::string term(command.id);
  if (!command.parameters.empty()) term += " " + std::string(command.parameters);
  const bool has_no_place = command.menu.empty() && command.key.empty();
  return {term, std::string(has_no_place ? "no menu item" : command.key), std::string(command.description)};
}

HelpPage commandsPage() {
  HelpPage out{.name = "window", .summary = "Commands of the window, by menu, with parameters and key", .sections = {}};
  out.sections.push_back({"Use",
                          "Run a command by its menu item, its key, the palette (Ctrl+Shift+P) or a script (kerf help "
                          "script). X and Y are pixels of the picture; Y points down. Brackets mark optional "
                          "parameters.",
                          {}});

  const std::vector<std::string_view> all = menus();
  std::vector<HelpSection> sections(all.size() + 1);
  for (std::size_t n = 0; n < all.size(); ++n) sections[n].title = "Menu " + std::string(all[n]);
  sections.back().title = "Other";

  for (const AppCommand& command : appCommands()) {
    const auto menu = std::find(all.begin(), all.end(), menuOf(command, all));
    sections[static_cast<std::size_t>(menu - all.begin())].entries.push_back(entryOf(command));
  }
  for (HelpSection& section : sections)
    if (!section.entries.empty()) out.sections.push_back(std::move(section));
  return out;
}

HelpPage scriptPage() {
  const HelpSection use{
      "Use",
      "kerf-sim --script FILE runs the lines of a file without a display. A line holds a command of the window (kerf "
      "help window) or one of the commands below. Blanks separate words, double quotes group them, # begins a "
      "comment. The first error ends the script with exit code 1 and the number of its line.",
      {}};

  const HelpSection commands{
      "Commands",
      "",
      {{"wait", "", "Waits until no job runs, no plane is being sawn, and a replay has reached its target."},
       {"wait SECONDS", "", "Waits in simulation time."},
       {"wait device [SECONDS]", "", "Waits until a force-feedback device leads the tool. Default: at most 10 s."},
       {"print", "", "Prints the state as one line of JSON."},
       {"expect VALUE LOW HIGH", "", "Ends the script with an error if the value is outside LOW to HIGH."}}};

  const HelpSection values{
      "Values of expect",
      "",
      {{"removed", "", "Removed volume, mm3."},
       {"depth", "", "Depth of the tool in the current stroke, mm."},
       {"tip", "", "Depth of the tip below the surface as loaded, mm."},
       {"loop", "", "Ticks of the 1 kHz loop in the last second."},
       {"near", "", "Distance from the cutting tool to pulp or nerve canal, mm; far away: 1000."},
       {"hindered", "", "1 while the tool rests on its neck or the drive stalls, else 0."},
       {"warm", "", "Temperature of the tissue under the tool, C."},
       {"sawn", "", "Finished part of the last plane, percent."},
       {"triangles", "", "Number of triangles."},
       {"pieces", "", "Number of pieces."},
       {"beside", "", "Number of neighbours."},
       {"beside-near", "", "Distance from the cutting tool to the neighbours, mm; far away: 1000."},
       {"beside-removed", "", "Volume removed from the neighbours, mm3."},
       {"steps", "", "Steps done since the session began; finished steps of a replay."},
       {"ahead", "", "Steps that redo can repeat."},
       {"branches", "", "Number of branches."},
       {"time", "", "Current time of the replay, s."},
       {"same", "", "1 if the replay ended as recorded, 0 if not, -1 before its end."},
       {"verdict", "", "1 if the export panel says ready to print, 0 if not, -1 before its check."},
       {"device", "",
        "Force-feedback device: 0 none, 1 silent, 2 hand present, 3 leads the tool, 4 leads and is armed."},
       {"device-force", "", "Force that the user feels, N."}}};

  return {"script", "Scripts of kerf-sim: wait, print, expect", {use, commands, values}};
}

}  // namespace

std::vector<HelpPage> windowHelp() { return {commandsPage(), scriptPage()}; }

}  // namespace kerf
