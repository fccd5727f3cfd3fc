// Handles Ctrl-C: the command ends its work and writes its files.
#pragma once

#include <array>
#include <csignal>

namespace kerf::cli {

/// During its lifetime the first SIGINT, SIGTERM or SIGHUP sets isInterrupted(); the second one ends the program.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

 private:
  std::array<struct sigaction, 3> before_{};
};

bool isInterrupted();

}  // namespace kerf::cli
