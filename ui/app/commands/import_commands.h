// State of the import for scripts. The commands import.* are in import_commands.cpp.
#pragma once

#include <string>

#include "ui/app/commands/app_commands.h"
#include "ui/app/import/import_set.h"

namespace kerf::import_commands {

/// The preview job of the chosen file runs or starts soon; scripts wait for it.
bool isPreviewing(const AppContext& c);

/// Content of the import panel as one JSON object.
std::string importState(const ImportSet& set);

}  // namespace kerf::import_commands
