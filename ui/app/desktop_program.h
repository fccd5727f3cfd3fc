// Programs of the desktop that run beside the window: found on the PATH, started, never waited for.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

bool isOnPath(const std::string& name);

/// Starts a program with an empty standard input.   @param words  of its command line, the program first.
/// @param out  a descriptor that gets its standard output; -1: nobody reads what it writes, errors included.
/// @return  its process.   Error kUnsupported, with the system's reason.
Expected<pid_t> startProgram(const std::vector<std::string>& words, int out = -1);

/// How it ended, as waitpid() says; -1: nobody knows. None: it still runs.   @cost  microseconds.
std::optional<int> endOf(pid_t program);

}  // namespace kerf
