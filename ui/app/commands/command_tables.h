// The command tables: one per part of the workbench, each beside the functions of its rows.
//
// A new command is one row beside its function. A new table is its source and one line here and in app_commands.cpp.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <string_view>

#include "ui/app/base/command_words.h"
#include "ui/app/commands/app_commands.h"

namespace kerf {

namespace file_commands {
std::span<const AppCommand> table();
}
namespace import_commands {
std::span<const AppCommand> table();
}
namespace export_commands {
std::span<const AppCommand> table();
}
namespace replay_commands {
std::span<const AppCommand> table();
}
namespace quit {
std::span<const AppCommand> table();
}
namespace edit_commands {
std::span<const AppCommand> table();
}
namespace settings_commands {
std::span<const AppCommand> table();
}
namespace device_commands {
std::span<const AppCommand> table();
}
namespace tool_commands {
std::span<const AppCommand> table();
}
namespace stroke_commands {
std::span<const AppCommand> table();
}
namespace piece_commands {
std::span<const AppCommand> table();
}
namespace neighbour_commands {
std::span<const AppCommand> table();
}
namespace drill_commands {
std::span<const AppCommand> table();
}
namespace saw_commands {
std::span<const AppCommand> table();
}
namespace die_commands {
std::span<const AppCommand> table();
}
namespace point_commands {
std::span<const AppCommand> table();
}
namespace view_commands {
std::span<const AppCommand> table();
}
namespace tooth_views {
std::span<const AppCommand> table();
}
namespace tissue_commands {
std::span<const AppCommand> table();
}
namespace help_commands {
std::span<const AppCommand> table();
}

/// Conditions that several tables share.
namespace when {

bool always(const AppContext& c);
bool isOpen(const AppContext& c);   ///< for cutting
bool isShown(const AppContext& c);  ///< for cutting or in replay
bool isIdle(const AppContext& c);   ///< no job runs
bool isOpenAndIdle(const AppContext& c);
bool hasSettings(const AppContext& c);  ///< settings are saved

}  // namespace when

/// [on|off]: shows or hides a panel; without a word the other one.
Expected<void> switchPanel(AppContext& c, AppWords words, std::string_view panel);

/// For a row of a table: switchPanel<"plots">.
template <std::size_t kSize>
struct PanelId {
  char text[kSize];
  constexpr PanelId(const char (&id)[kSize]) { std::copy_n(id, kSize, text); }
};
template <PanelId kId>
Expected<void> switchPanel(AppContext& c, AppWords words) {
  return switchPanel(c, words, kId.text);
}

}  // namespace kerf
