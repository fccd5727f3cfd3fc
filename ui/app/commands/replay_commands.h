// Commands to watch an ended session.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf::replay_commands {

bool isWatching(const AppContext& c);
bool isWatchingAndIdle(const AppContext& c);

Expected<void> open(AppContext& c, AppWords words);
Expected<void> play(AppContext& c, AppWords words);
Expected<void> pause(AppContext& c, AppWords words);
Expected<void> toggle(AppContext& c, AppWords words);
Expected<void> speed(AppContext& c, AppWords words);
Expected<void> jump(AppContext& c, AppWords words);
Expected<void> time(AppContext& c, AppWords words);
Expected<void> next(AppContext& c, AppWords words);
Expected<void> previous(AppContext& c, AppWords words);
Expected<void> begin(AppContext& c, AppWords words);
Expected<void> end(AppContext& c, AppWords words);
Expected<void> goOn(AppContext& c, AppWords words);
Expected<void> close(AppContext& c, AppWords words);

}  // namespace kerf::replay_commands
