// Commands to take a tool and cut with it by mouse; rows of the table in app_commands.cpp.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf::tool_commands {

Expected<void> selectTool(AppContext& context, AppWords words);  ///< ID
Expected<void> addTool(AppContext& context, AppWords words);     ///< PATH
bool hasRack(const AppContext& context);                         ///< and settings, which keep favourites
Expected<void> favourite(AppContext& context, AppWords words);   ///< [ID]
Expected<void> nextTool(AppContext& context, AppWords words);
Expected<void> previousTool(AppContext& context, AppWords words);

Expected<void> setForce(AppContext& context, AppWords words);   ///< NEWTONS
Expected<void> setDepth(AppContext& context, AppWords words);   ///< MM
Expected<void> deeper(AppContext& context, AppWords words);     ///< [MM]
Expected<void> shallower(AppContext& context, AppWords words);  ///< [MM]

Expected<void> stopShort(AppContext& context, AppWords words);  ///< [MM|off]

Expected<void> press(AppContext& context, AppWords words);  ///< X Y
Expected<void> drag(AppContext& context, AppWords words);   ///< X Y
Expected<void> release(AppContext& context, AppWords words);

}  // namespace kerf::tool_commands
