// Commands that change user settings. Each is saved at once.
#pragma once

#include "geometry/base/error.h"
#include "ui/app/commands/app_commands.h"

namespace kerf {

bool hasSettings(const AppContext& c);

Expected<void> setTheme(AppContext& c, AppWords words);
Expected<void> setScale(AppContext& c, AppWords words);
Expected<void> makeLarger(AppContext& c, AppWords words);
Expected<void> makeSmaller(AppContext& c, AppWords words);
Expected<void> setHints(AppContext& c, AppWords words);
Expected<void> keepPush(AppContext& c, AppWords words);
Expected<void> setVolume(AppContext& c, AppWords words);    ///< PERCENT
Expected<void> mute(AppContext& c, AppWords words);         ///< [on|off]
Expected<void> setDialog(AppContext& c, AppWords words);    ///< own|system
Expected<void> setLanguage(AppContext& c, AppWords words);  ///< ID of language.h
Expected<void> showSettings(AppContext& c, AppWords words);

}  // namespace kerf
