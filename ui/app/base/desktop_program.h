// Desktop programs beside the window: found on the PATH, started, never waited for.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

bool isOnPath(const std::string& name);

/// Starts a program with an empty standard input.   @param words  its command line, the program first.
/// @param out  descriptor for its standard output; -1: discards standard output and errors.
/// @return  its process id.   Error kUnsupported, with the system's reason.
Expected<pid_t> startProgram(const std::vector<std::string>& words, int out = -1);

/// Status from waitpid(); -1: unknown. None: it still runs.   @cost  microseconds.
std::optional<int> endOf(pid_t program);

}  // namespace kerf
