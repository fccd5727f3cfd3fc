#include "ui/app/commands/app_commands.h"

#include <fmt/format.h>

#include <algorithm>

#include "ui/app/commands/command_tables.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/settings/settings.h"

namespace kerf {
namespace {

// The order matters for keys: the first enabled command of a key runs.
std::vector<AppCommand> allTables() {
  std::vector<AppCommand> out;
  for (const std::span<const AppCommand> table :
       {file_commands::table(), import_commands::table(), export_commands::table(),   replay_commands::table(),
        quit::table(),          edit_commands::table(),   settings_commands::table(), device_commands::table(),
        tool_commands::table(), stroke_commands::table(), piece_commands::table(),    neighbour_commands::table(),
        saw_commands::table(),  die_commands::table(),    drill_commands::table(),    point_commands::table(),
        view_commands::table(), tooth_views::table(),     tissue_commands::table(),   help_commands::table()})
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

Expected<void> switchPanel(AppContext& c, AppWords words, std::string_view panel) {
  bool& is_on = c.panels[panel];
  KERF_TRY(wanted, onOrOff(words, is_on));
  is_on = wanted;
  return {};
}

bool leftButtonCuts(const AppContext& context) {
  return !context.settings || !context.settings->values.left_turns || context.is_tool_taken;
}

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
                 .hint = "list them with kerf-sim --commands"});
  if (!command->is_enabled(context))
    return fail({.code = Error::Code::kUnsupported,
                 .found = fmt::format("{} is not available now", id),
                 .expected = "an open session, and no running job",
                 .hint = "use wait before it in a script"});
  return command->run(context, parameters);
}

void runIfEnabled(AppContext& context, std::string_view id, AppWords parameters) {
  const AppCommand* const command = findAppCommand(id);
  if (!command || !command->is_enabled(context)) return;
  if (const auto done = command->run(context, parameters); !done) context.bench.notices->complain(done.error());
}

std::vector<std::string> wordsOf(std::initializer_list<double> numbers) {
  std::vector<std::string> out;
  for (const double number : numbers) out.push_back(fmt::format("{}", number));
  return out;
}

}  // namespace kerf
