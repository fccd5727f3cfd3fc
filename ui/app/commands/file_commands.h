// The commands recent.* and session.forget of the table in app_commands.cpp.
#pragma once

#include "geometry/base/error.h"
#include "ui/app/commands/app_commands.h"

namespace kerf {

bool hasRecent(const AppContext& c);
bool hasLostSession(const AppContext& c);

Expected<void> recentOpen(AppContext& c, AppWords words);
Expected<void> recentForget(AppContext& c, AppWords words);
Expected<void> sessionForget(AppContext& c, AppWords words);

}  // namespace kerf
