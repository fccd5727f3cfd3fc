// Runs the program kerf, or another, as a user does and keeps the output. Provides a small case and run.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace kerf {

struct Outcome {
  int exit_code = -1, signal = 0;  // signal 0: normal exit
  std::string out, err;
  double seconds = 0, seconds_after_signal = 0;
  double processor_seconds = 0, most_memory_mb = 0;  // of the program, without its children
};

struct RunOptions {
  std::string program = "kerf";
  rlim_t largest_file = RLIM_INFINITY;          // bytes; beyond, writes fail as on a full disk (EFBIG)
  bool one_core = false;                        // the thread pool follows the affinity
  bool as_nobody = false;                       // root may write anywhere
  int signal = 0, second_signal = 0;            // sent in immediate succession after signal_after seconds
  double signal_after = 0, most_seconds = 120;  // after that the program is killed and the test fails
  std::map<std::string, std::string> environment{};
  std::string input = "/dev/null";  // standard input
};

/// Peak memory of a process since its exec, MB; empty if it has ended. wait4() would include the forked process.
inline std::optional<double> peakOf(pid_t process) {
  std::ifstream status(fmt::format("/proc/{}/status", process));
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
  return {};
}

inline Outcome runKerf(const std::vector<std::string>& arguments, const RunOptions& options = {}) {
  TemporaryFolder capture;
  const std::string out = (capture.path() / "out").string(), err = (capture.path() / "err").string();
  std::string program = std::string(kProgramFolder) + "/" + options.program;
  std::vector<std::string> words = arguments;
  std::vector<char*> argv{program.data()};
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const auto since = [&](auto then) { return std::chrono::duration<double>(now() - then).count(); };
  const auto start = now();
  const pid_t child = ::fork();
  if (child == 0) {
    const int o = ::open(out.c_str(), O_WRONLY | O_CREAT, 0600), e = ::open(err.c_str(), O_WRONLY | O_CREAT, 0600);
    const int nothing = ::open(options.input.c_str(), O_RDONLY);
    ::dup2(nothing, 0);
    ::dup2(o, 1);
    ::dup2(e, 2);
    if (options.largest_file != RLIM_INFINITY) {
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit{options.largest_file, options.largest_file};
      ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    if (options.one_core) {
      cpu_set_t all, one;
      CPU_ZERO(&one);
      ::sched_getaffinity(0, sizeof all, &all);
      for (int c = 0; c < CPU_SETSIZE; ++c)
        if (CPU_ISSET(c, &all)) {
          CPU_SET(c, &one);
          break;
        }
      ::sched_setaffinity(0, sizeof one, &one);
    }
    if (options.as_nobody && (::setgroups(0, nullptr) != 0 || ::setgid(65534) != 0 || ::setuid(65534) != 0))
      ::_exit(99);
    for (const auto& [key, value] : options.environment) ::setenv(key.c_str(), value.c_str(), 1);
    ::execv(program.c_str(), argv.data());
    ::_exit(98);
  }
  Outcome outcome;
  int status = 0;
  rusage used{};
  bool signalled = false;
  auto signalled_at = start;
  while (::wait4(child, &status, WNOHANG, &used) == 0) {
    outcome.most_memory_mb = peakOf(child).value_or(outcome.most_memory_mb);
    if (options.signal && !signalled && since(start) >= options.signal_after) {
      ::kill(child, options.signal);
      signalled = true;
      signalled_at = now();
      if (options.second_signal) ::kill(child, options.second_signal);
    }
    if (since(start) > options.most_seconds) {
      ADD_FAILURE() << options.program << " did not end within " << options.most_seconds << " s";
      ::kill(child, SIGKILL);
      ::wait4(child, &status, 0, &used);
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  outcome.seconds = since(start);
  const auto seconds_of = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  outcome.processor_seconds = seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
  outcome.seconds_after_signal = signalled ? since(signalled_at) : 0;
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  outcome.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  outcome.out = contentOf(out);
  outcome.err = contentOf(err);
  return outcome;
}

/// Everything in a folder, with hidden files: relative name -> content (links, folders and pipes: only their
/// existence).
inline std::map<std::string, std::string> snapshot(const std::filesystem::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    all[entry.path().lexically_relative(folder).string()] = entry.is_symlink()        ? "link"
                                                            : entry.is_regular_file() ? contentOf(entry.path())
                                                                                      : "folder or pipe";
  return all;
}

inline std::vector<std::string> names(const std::map<std::string, std::string>& snapshot) {
  std::vector<std::string> out;
  for (const auto& [name, content] : snapshot) out.push_back(name + fmt::format(" ({} bytes)", content.size()));
  return out;
}

/// A box of 6 x 5 x 4 mm as mesh, case and run, in a folder of its own.
class Cli : public ::testing::Test {
 protected:
  std::filesystem::path in(const std::string& name) const { return folder_.path() / name; }
  std::string at(const std::string& name) const { return in(name).string(); }

  static std::string box() {
    std::string off = "OFF\n8 12 0\n";
    for (int c = 0; c < 8; ++c) off += fmt::format("{} {} {}\n", c & 1 ? 3 : -3, c & 2 ? 2.5 : -2.5, c & 4 ? 0 : -4);
    for (const char* t :
         {"0 2 3", "0 3 1", "4 5 7", "4 7 6", "0 1 5", "0 5 4", "2 6 7", "2 7 3", "0 4 6", "0 6 2", "1 3 7", "1 7 5"})
      off += std::string("3 ") + t + "\n";
    return off;
  }
  static std::string groove(double z = -0.5) {
    std::string csv = "t,x,y,z,qw,qx,qy,qz\n";
    for (int n = 0; n <= 8; ++n) csv += fmt::format("{},{},0.3,{},1,0,0,0\n", 0.1 * n, 0.5 * n - 2, z);
    return csv;
  }
  void makeCase() {
    folder_.write("box.off", box());
    folder_.write("groove.csv", groove());
    const Outcome o = runKerf({"bake", at("box.off"), "--unit", "mm", "-o", at("box.case"), "--voxel", "0.2"});
    ASSERT_EQ(o.exit_code, 0) << o.err;
  }
  void makeRun() {
    makeCase();
    const Outcome o =
        runKerf({"cut", at("box.case"), "--tool", "round-014", "--path", at("groove.csv"), "-o", at("box.run")});
    ASSERT_EQ(o.exit_code, 0) << o.err;
  }

  /// Requires one line on standard error with each of `said`, nothing on standard output, and no file made or changed.
  void refuses(const std::vector<std::string>& arguments, const std::vector<std::string>& said, int exit_code = 1,
               const RunOptions& options = {}) {
    std::string command = options.program;
    for (const std::string& a : arguments) command += " " + a;
    SCOPED_TRACE(command);
    const auto before = snapshot(folder_.path());
    const Outcome o = runKerf(arguments, options);
    EXPECT_EQ(o.signal, 0) << o.err;
    EXPECT_EQ(o.exit_code, exit_code) << o.out << o.err;
    EXPECT_EQ(o.err.find("Sanitizer"), o.err.npos) << o.err;
    EXPECT_EQ(o.err.find("unexpected:"), o.err.npos) << o.err;
    if (std::find(arguments.begin(), arguments.end(), "--json") == arguments.end())
      EXPECT_EQ(o.out, "");
    else
      EXPECT_EQ(o.out.find("{\n  \"error\": {"), 0u) << o.out;
    if (exit_code == 1) {
      EXPECT_TRUE(o.err.starts_with(options.program + ": ")) << o.err;
      EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    }
    for (const std::string& text : said)
      EXPECT_NE(o.err.find(text), o.err.npos) << "not said: " << text << "\n" << o.err;
    const auto after = snapshot(folder_.path());
    EXPECT_TRUE(before == after) << "before: " << ::testing::PrintToString(names(before))
                                 << "\nafter: " << ::testing::PrintToString(names(after));
  }

  TemporaryFolder folder_;
};

}  // namespace kerf
