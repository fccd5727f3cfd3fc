// The commands of the program kerf. A new command is one file here plus one line in main.cpp.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"

namespace kerf::cli {

/// Exit codes of kerf.
enum ExitCode : int {
  kOk = 0,
  kFailed = 1,  ///< the work failed, or a check says no
  kUsage = 2,   ///< wrong command line
};

/// Adds its sub-command, options and what to run (as CLI11 callback) to the program. `exit_code` is what main returns.
using AddCommand = void (*)(CLI::App& app, int& exit_code);

void addBake(CLI::App& app, int& exit_code);
void addBench(CLI::App& app, int& exit_code);
void addCheck(CLI::App& app, int& exit_code);
void addCut(CLI::App& app, int& exit_code);
void addDemo(CLI::App& app, int& exit_code);
void addDemoMolar(CLI::App& app, int& exit_code);
void addExport(CLI::App& app, int& exit_code);
void addInfo(CLI::App& app, int& exit_code);
void addReplay(CLI::App& app, int& exit_code);
void addTool(CLI::App& app, int& exit_code);

/// Prints "kerf: MESSAGE" on standard error, one line whatever bytes a file name holds; returns kFailed.
int complain(const Error& error);

/// On standard output, indented. Bytes that are no UTF-8 (file names may hold any) become replacement characters.
void printJson(const nlohmann::json& json);

/// A line with bar, step and time left on standard error when that is a terminal; nothing otherwise. The first SIGINT,
/// SIGTERM or SIGHUP makes the callback say no; the second, of either kind, ends the program at once. Where no callback
/// was taken, the first is put off until the destructor: files are written to their end, then the program ends by it.
/// The line is erased by the destructor.
class TerminalProgress {
 public:
  TerminalProgress();
  ~TerminalProgress();
  TerminalProgress(const TerminalProgress&) = delete;
  TerminalProgress& operator=(const TerminalProgress&) = delete;
  Progress callback();

 private:
  bool is_terminal_, is_asked_ = false;
  double start_;
  int last_percent_ = -1;
  std::string last_what_;
};

}  // namespace kerf::cli
