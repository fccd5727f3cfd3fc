// The menu Help.
#include "ui/app/commands/command_tables.h"

namespace kerf::help_commands {
namespace {

Expected<void> tour(AppContext& c, AppWords) { return runAppCommand(c, "view.hints", std::vector<std::string>{"on"}); }

constexpr AppCommand kRows[] = {
    {"help.keys", "Help", "Keys...", "F1", "[on|off]", "Shows or hides the list of all keys.", when::always,
     switchPanel<"keys">},
    {"help.tour", "Help", "Tour", "", "", "Shows the four steps of the tour.", when::hasSettings, tour},
    {"help.messages", "Help", "Messages...", "", "[on|off]", "Shows or hides the list of all messages.", when::always,
     switchPanel<"messages">},
    {"help.about", "Help", "About Kerf...", "", "[on|off]", "Shows or hides version and licence.", when::always,
     switchPanel<"about">},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::help_commands
