// Commands that read and measure the surface; rows of the table in app_commands.cpp.
#pragma once

#include "ui/app/commands/app_commands.h"

namespace kerf::point_commands {

bool hasMeasure(const AppContext& context);  ///< at least one point is set

Expected<void> copyPoint(AppContext& context, AppWords words);    ///< [X Y]
Expected<void> copyPathRow(AppContext& context, AppWords words);  ///< [X Y]

Expected<void> measurePoint(AppContext& context, AppWords words);  ///< [X Y]
Expected<void> copyMeasure(AppContext& context, AppWords words);
Expected<void> clearMeasure(AppContext& context, AppWords words);

}  // namespace kerf::point_commands
