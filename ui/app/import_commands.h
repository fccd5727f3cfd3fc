// The commands import.* of the table in app_commands.cpp: a scan is looked at, and what to do about it is decided.
#pragma once

#include <string>

#include "geometry/base/error.h"
#include "ui/app/app_commands.h"
#include "ui/app/import_plan.h"

namespace kerf {

bool isImporting(const AppContext& c);  ///< a scan is looked at, and no job runs
/// The closed solid is being computed, or will be in a moment: a script waits for it.
bool isPreviewing(const AppContext& c);

Expected<void> importRead(AppContext& c, AppWords words);
Expected<void> importUnit(AppContext& c, AppWords words);
Expected<void> importClose(AppContext& c, AppWords words);
Expected<void> importBase(AppContext& c, AppWords words);
Expected<void> importSmooth(AppContext& c, AppWords words);
Expected<void> importPlane(AppContext& c, AppWords words);
Expected<void> importHoles(AppContext& c, AppWords words);
Expected<void> importWrap(AppContext& c, AppWords words);
Expected<void> importVoxel(AppContext& c, AppWords words);
Expected<void> importPreview(AppContext& c, AppWords words);
Expected<void> importStart(AppContext& c, AppWords words);
Expected<void> importCancel(AppContext& c, AppWords words);

/// What the panel shows, as one JSON object: for scripts.
std::string importState(const ImportPlan& plan);

}  // namespace kerf
