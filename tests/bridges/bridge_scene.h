// Shared by the bridge tests: Kerf's side, and a bridge that runs as a program.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "bridges/kerf_link.h"
#include "sim/device/arm/bridge_device.h"
#include "tests/sim/device/force_scene.h"

namespace kerf::test {

/// A program with a pipe as its standard input. SIGTERM ends it.
class Program {
 public:
  explicit Program(const std::vector<std::string>& words) {
    int ends[2] = {-1, -1};
    EXPECT_EQ(::pipe2(ends, O_CLOEXEC), 0);
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    process_ = ::fork();
    if (process_ == 0) {
      ::dup2(ends[0], STDIN_FILENO);
      ::execv(arguments[0], arguments.data());
      ::_exit(127);
    }
    ::close(ends[0]);
    keys_ = ends[1];
  }
  ~Program() {
    end();
    ::close(keys_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void pressEnter() const { EXPECT_EQ(::write(keys_, "\n", 1), 1); }
  void signal(int number) const { ::kill(process_, number); }
  /// @return  its exit code.
  int end(int number = SIGTERM) {
    if (process_ > 0) {
      ::kill(process_, number);
      ::waitpid(process_, &status_, 0);
    }
    process_ = 0;
    return WEXITSTATUS(status_);
  }
  /// Waits until the program ends by itself.
  int wait() {
    ::waitpid(process_, &status_, 0);
    process_ = 0;
    return WEXITSTATUS(status_);
  }

 private:
  pid_t process_ = 0;
  int keys_ = -1, status_ = 0;
};

/// Kerf's side: any port; force starts as soon as a hand leads.
inline std::unique_ptr<BridgeDevice> openKerf() {
  auto kerf = BridgeDevice::open({.limits = {.force = 3, .rate = 500, .ramp_s = 0.1}});
  EXPECT_TRUE(kerf) << kerf.error().message();
  (*kerf)->enable(true);
  return std::move(*kerf);
}

}  // namespace kerf::test
