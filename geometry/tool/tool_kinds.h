// The kinds of tool files: each reads its own keys. Errors stay in `top`; the tool is complete if there are none.
#pragma once

#include "geometry/base/toml_reader.h"
#include "geometry/tool/tool.h"

namespace kerf {

void readBur(TomlTable& top, Tool& tool);
void readBlade(TomlTable& top, Tool& tool);
/// @param folder  of the tool's file: the mesh lies there.
void readMeshTool(TomlTable& top, const std::filesystem::path& folder, Tool& tool);
/// The table [drive], if there is one; the tool's kind and motion have been read.
Expected<void> readDrive(const TomlTable& top, const std::filesystem::path& file, Tool& tool);

/// Calls no key of the kind unknown: for a file that does not say which of them belong.
void allowBurKeys(TomlTable& top);
void allowBladeKeys(TomlTable& top);
void allowMeshKeys(TomlTable& top);

}  // namespace kerf
