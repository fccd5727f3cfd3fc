#include "ui/app/commands/app_commands.h"

#include <fmt/format.h>

#include <algorithm>

#include "ui/app/commands/command_tables.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"

namespace kerf {
namespace {

// The order matters for keys: the first enabled command of a key runs.
std::vector<AppCommand> allTables() {
  std::vector<AppCommand> out;
  for (const std::span<const AppCommand> table :
       {file_commands::table(), import_commands::table(), export_commands::table(), replay_commands::table(),
        quit::table(), edit_commands::table(), settings_commands::table(), device_commands::table(),
        tool_commands::table(), stroke_commands::table(), piece_commands::table(), neighbour_commands::table(),
        saw_commands::table(), point_commands::table(), view_commands::table(), tooth_views::table(),
        tissue_commands::table()})
    out.insert(out.end(), table.begin(), table.end());
  return out;
}

}  // namespace

namespace when {

bool always(const AppContext&) { return true; }
bool isOpen(const AppContext& c) { return c.bench.document->isOpen(); }
bool isShown(const AppContext& c) { return c.bench.document->isShown(); }
bool isIdle(const AppContext& c) { return !c.bench.jobs->running(); }
bool isOpenAndIdle(const AppContext& c) { return isOpen(c) && isIdle(c); }
bool hasSettings(const AppContext& c) { return c.settings != nullptr; }

}  // namespace when

std::span<const AppCommand> appCommands() {
  static const std::vector<AppCommand> kAll = allTables();
  return kAll;
}

std::vector<const AppCommand*> commandsOfMenu(std::string_view heading) {
  std::vector<const AppCommand*> out;
  for (const AppCommand& command : appCommands())
    if (menuOf(command) == heading) out.push_back(&command);
  std::stable_sort(out.begin(), out.end(), [](const auto* a, const auto* b) { return a->menu < b->menu; });
  return out;
}

const AppCommand* findAppCommand(std::string_view id) {
  for (const AppCommand& command : appCommands())
    if (command.id == id) return &command;
  return nullptr;
}

Expected<void> runAppCommand(AppContext& context, std::string_view id, AppWords parameters) {
  const AppCommand* const command = findAppCommand(id);
  if (!command)
    return fail({.code = Error::Code::kNotFound,
                 .found = fmt::format("\"{}\"", id),
                 .expected = "a command of the window",
                 .hint = "kerf-sim --commands lists them"});
  if (!command->is_enabled(context))
    return fail({.code = Error::Code::kUnsupported,
                 .found = fmt::format("{} can not be done now", id),
                 .expected = "an open case, and no job under way",
                 .hint = "in a script: wait"});
  return command->run(context, parameters);
}

std::string appCommandReference() {
  std::string out =
      "# Commands of the window\n\n<!-- Written by scripts/reference from kerf-sim --commands. Do not edit: change "
      "ui/app/commands/app_commands.cpp and run it again. -->\n\n"
      "Menus, keys and scripts (`kerf-sim --script FILE`) run these. A script holds one a line; # begins a comment, "
      "words in "
      "double quotes may hold blanks. X and Y are pixels of the picture, Y downwards. Beside them a script has `wait` "
      "(until "
      "no job runs, no plane is sawn and no replay jumps), `wait SECONDS` (of the simulation), `wait device [SECONDS]` "
      "(until a force-feedback device leads the tool; 10 s at most), `print` (the state, as "
      "JSON) and `expect "
      "removed|depth|tip|loop|near|hindered|warm|sawn|triangles|pieces|beside|beside-near|beside-removed|steps|ahead|"
      "time|same|"
      "verdict|device|device-force LOW HIGH`: `tip` is the depth of the tip below the surface as loaded, `loop` the "
      "ticks "
      "of the 1 kHz loop in the last second, `hindered` 1 while the tool rests on its neck or its drive stands still, "
      "`verdict` 1 when the export panel says ready to print, 0 when not, -1 "
      "before "
      "its check; `device` is 0 without a force-feedback device, 1 when it is silent, 2 when its hand is there, 3 when "
      "it "
      "leads, 4 when it is armed; `time` is the second that is watched, "
      "`same` "
      "1 when a replay ended as recorded, 0 when not, -1 before its end. The first error ends it, "
      "with "
      "exit code 1 and the line.\n\n| command | parameters | key | what it does |\n|---|---|---|---|\n";
  for (const AppCommand& c : appCommands())
    out += fmt::format("| `{}` | {} | {} | {} |\n", c.id, c.parameters.empty() ? "" : fmt::format("`{}`", c.parameters),
                       c.key.empty() ? "" : fmt::format("`{}`", c.key), c.description);
  return out;
}

}  // namespace kerf
