// The commands import.* of the table in app_commands.cpp: import choices for files.
#pragma once

#include <string>

#include "geometry/base/error.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/import/import_set.h"

namespace kerf {

bool isImporting(const AppContext& c);         ///< an import is open, and no job runs
bool isImportingScan(const AppContext& c);     ///< and the chosen file is a scan
bool isImportingLabels(const AppContext& c);   ///< and the chosen file is a label volume
bool isImportingSeveral(const AppContext& c);  ///< and it has several files
bool isImportingTool(const AppContext& c);     ///< and the chosen file becomes a tool
/// The preview job of the chosen file runs or starts soon; scripts wait for it.
bool isPreviewing(const AppContext& c);

Expected<void> importRead(AppContext& c, AppWords words);
Expected<void> importAdd(AppContext& c, AppWords words);
Expected<void> importChoose(AppContext& c, AppWords words);
Expected<void> importRole(AppContext& c, AppWords words);
Expected<void> importToolAxis(AppContext& c, AppWords words);  ///< name of a way, or auto
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

/// Content of the import panel as one JSON object, for scripts.
std::string importState(const ImportSet& set);

}  // namespace kerf
