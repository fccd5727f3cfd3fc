// The commands import.* of the table in app_commands.cpp: files are looked at, and what to do about them is decided.
#pragma once

#include <string>

#include "geometry/base/error.h"
#include "ui/app/app_commands.h"
#include "ui/app/import_set.h"

namespace kerf {

bool isImporting(const AppContext& c);         ///< files are looked at, and no job runs
bool isImportingScan(const AppContext& c);     ///< and a scan is chosen among them
bool isImportingLabels(const AppContext& c);   ///< and a label volume is
bool isImportingSeveral(const AppContext& c);  ///< and there are several
bool isImportingTool(const AppContext& c);     ///< and the chosen one is to be a tool
/// The closed solid is being computed, or will be in a moment: a script waits for it.
bool isPreviewing(const AppContext& c);

Expected<void> importRead(AppContext& c, AppWords words);
Expected<void> importAdd(AppContext& c, AppWords words);
Expected<void> importChoose(AppContext& c, AppWords words);
Expected<void> importRole(AppContext& c, AppWords words);
Expected<void> importToolAxis(AppContext& c, AppWords words);  ///< a way's name, or auto
Expected<void> importToolCut(AppContext& c, AppWords words);   ///< MM
Expected<void> importTissue(AppContext& c, AppWords words);
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
std::string importState(const ImportSet& set);

}  // namespace kerf
