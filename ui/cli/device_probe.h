// `kerf devices --probe`, `--record` and `--replay`: what a device says, now or when it was recorded. No device is
// armed for it: an arm that is probed is told at all times that there is no force.
#pragma once

#include <string>

namespace kerf::cli {

struct ProbeOptions {
  std::string device;  ///< path or serial; of an arm what openArm() takes; empty: the only one
  bool prints = false;
  std::string record;  ///< file; empty: none
  double seconds = 0;  ///< 0: until it is interrupted
  bool json = false;
};

/// @return  the exit code.
int probeDevice(const ProbeOptions& options);

/// What the reports of a recording say.
int printRecording(const std::string& file, bool json);

}  // namespace kerf::cli
