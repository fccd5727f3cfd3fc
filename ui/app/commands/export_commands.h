// The commands export.*: the actions of the export panel, for menus, keys and scripts.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf::export_commands {

bool canShow(const AppContext& c);  ///< or hide
bool isShown(const AppContext& c);
bool isWritten(const AppContext& c);

Expected<void> show(AppContext& c, AppWords words);    ///< [on|off]
Expected<void> choose(AppContext& c, AppWords words);  ///< all|each|put-back|piece NAME|beside NAME
Expected<void> format(AppContext& c, AppWords words);  ///< NAME
Expected<void> to(AppContext& c, AppWords words);      ///< PATH
Expected<void> check(AppContext& c, AppWords words);
Expected<void> write(AppContext& c, AppWords words);  ///< [replace] [anyway]
Expected<void> showInFolder(AppContext& c, AppWords words);

}  // namespace kerf::export_commands
