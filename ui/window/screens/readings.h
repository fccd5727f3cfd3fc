// Readings that several panels show: a name, a number, a unit.
#pragma once

#include <string>

#include "ui/app/workbench/workbench.h"

namespace kerf {

void reading(const char* name, const std::string& value, const char* unit, bool is_warning = false);

/// Temperature under the tool, of pulp and nerve canal; in the warning colour from their limits on.
void drawHeat(const Workbench& bench);

}  // namespace kerf
