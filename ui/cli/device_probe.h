// `kerf devices --probe`, `--record` and `--replay`: reports of a device, live or recorded. Never arms a device: a
// probed arm receives only frames without force.
#pragma once

#include <string>

namespace kerf::cli {

struct ProbeOptions {
  std::string device;  ///< path or serial; for an arm a name for openArm(); empty: the only one
  bool prints = false;
  std::string record;  ///< file; empty: none
  double seconds = 0;  ///< 0: until an interrupt
  bool json = false;
};

/// @return  the exit code.
int probeDevice(const ProbeOptions& options);

/// Prints the reports of a recording.
int printRecording(const std::string& file, bool json);

}  // namespace kerf::cli
