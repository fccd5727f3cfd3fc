// The tools of the rack as read from their files, each with data for its strokes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"
#include "sim/run/session/session_run.h"
#include "ui/app/tool/stroke.h"
#include "ui/app/tool/tilt.h"

namespace kerf {

/// Last write times of a tool's file and of its mesh; none: the file is missing.
struct ToolTimes {
  std::optional<std::filesystem::file_time_type> file, mesh;
  bool operator==(const ToolTimes&) const = default;
};
/// For a file that may be invalid. Taken before reading, so that a write meanwhile causes another read.
ToolTimes timesOf(const std::filesystem::path& tool_file);
/// For a tool already read: opens no file.
ToolTimes timesOf(const SessionTool& tool);

struct RackTool {
  SessionTool tool;
  ToolTimes times;  ///< before reading
  Mesh head;        ///< vertices near its tip: clearance test at the start of a stroke
  Plunge plunge;
  TouchPoints touches;
};
/// @cost  some ms.
RackTool rackTool(SessionTool tool, const ToolTimes& times);

/// A file that is no valid tool yet. When it or its mesh changes, Kerf rereads it for the rack.
struct BrokenTool {
  std::filesystem::path file;
  Error error;
  ToolTimes times{};          ///< before reading
  bool is_asked_for = false;  ///< dropped by the user: taken in hand as soon as it is readable
};

struct Rack {
  std::vector<RackTool> tools;
  std::vector<BrokenTool> broken;
  std::vector<Error> errors;   ///< of those, and of unknown ids
  std::size_t first_look = 0;  ///< number of leading tools for a first look; 0: all
};

/// A selection of the rack for a first look: round, pear, taper, cylinder, flame, a disc, a saw.
const std::vector<std::string>& defaultTools();

/// Reads the named tools; without names those of defaultTools() and then all others of the folders.
/// @param names  ids or files.   @param own_folder  of the user's tools, beside defaultToolFolders().
/// Errors: only kCancelled; errors of tools are in the rack.   @cost  some 100 ms for all; for a job.
Expected<Rack> readRack(const std::vector<std::string>& names, const std::filesystem::path& own_folder,
                        const Progress& progress = {});

}  // namespace kerf
