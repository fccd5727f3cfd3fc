// Options of the window's core, from the command line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/live/realtime.h"

namespace kerf {

struct WorkbenchOptions {
  /// Parent of "cases" and "sessions". Empty: $XDG_DATA_HOME/kerf, or ~/.local/share/kerf.
  std::filesystem::path data_folder;
  std::vector<std::string> tools;  ///< ids or files; empty: the whole rack, defaultTools() first
  std::string unit;                ///< of opened scans: "mm", "inch"; empty: from the file, or by its size
  double voxel_mm = 0;             ///< of opened scans; 0: 0.1, or coarser for a large scan: voxelFor()
  RealTimeRequest real_time;       ///< of the haptic thread
  std::string device;              ///< a force-feedback device to open: ArmLead::open(); empty: none
  bool keeps_recent = false;       ///< adds opened files to the list of recent files
};

}  // namespace kerf
