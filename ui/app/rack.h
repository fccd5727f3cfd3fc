// The tools of the rack as they are read from their files, each with what its strokes need of it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/mesh/mesh.h"
#include "sim/run/session_run.h"
#include "ui/app/stroke.h"
#include "ui/app/tilt.h"

namespace kerf {

/// When a tool's file, and the mesh that it names, were written last; none: it is not there.
struct ToolTimes {
  std::optional<std::filesystem::file_time_type> file, mesh;
  bool operator==(const ToolTimes&) const = default;
};
/// Of a file that need not be right. Taken before it is read: what is written meanwhile is then read again.
ToolTimes timesOf(const std::filesystem::path& tool_file);
/// Of a tool that was read: no file is opened.
ToolTimes timesOf(const SessionTool& tool);

struct RackTool {
  SessionTool tool;
  ToolTimes times;  ///< before it was read
  Mesh head;        ///< vertices near its tip: what has to be free where a stroke starts
  Plunge plunge;
  TouchPoints touches;
};
/// @cost  some ms.
RackTool rackTool(SessionTool tool, const ToolTimes& times);

/// A file that is no tool yet. It is read again when it or its mesh changes, and is then in the rack.
struct BrokenTool {
  std::filesystem::path file;
  Error error;
  ToolTimes times{};          ///< before it was read
  bool is_asked_for = false;  ///< dropped: taken as soon as it can be read
};

struct Rack {
  std::vector<RackTool> tools;
  std::vector<BrokenTool> broken;
  std::vector<Error> errors;   ///< of those, and of ids that nothing is found for
  std::size_t first_look = 0;  ///< so many of the first ones are for a first look; 0: all
};

/// A selection of the rack for a first look: round, pear, taper, cylinder, flame, a disc, a saw.
const std::vector<std::string>& defaultTools();

/// Reads the tools that are named; without names those of defaultTools() and then all others of the folders.
/// @param names  ids or files.   @param own_folder  of the user's tools, beside defaultToolFolders().
/// Errors: kCancelled alone; what is wrong with a tool is in the rack.   @cost  some 100 ms for all; for a job.
Expected<Rack> readRack(const std::vector<std::string>& names, const std::filesystem::path& own_folder,
                        const Progress& progress = {});

}  // namespace kerf
