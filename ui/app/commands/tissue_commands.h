// Commands for tissue looks and colours; rows of the table in app_commands.cpp.
#pragma once

#include "ui/app/commands/app_commands.h"
#include "ui/app/view/tissue_display.h"

namespace kerf::tissue_commands {

bool hasTissues(const AppContext& context);
bool isAnyHidden(const AppContext& context);  ///< or a ghost
bool hasScanColours(const AppContext& context);
bool hasStructures(const AppContext& context);

Expected<void> look(AppContext& context, AppWords words);  ///< NAME show|hide|ghost
Expected<void> showAll(AppContext& context, AppWords words);

Expected<void> colours(AppContext& context, AppWords words);  ///< tissue|scan|depth|distance
template <SurfaceColours kOf>
Expected<void> coloursOf(AppContext& context, AppWords) {
  return context.bench.tissues().setColours(kOf);
}

}  // namespace kerf::tissue_commands
