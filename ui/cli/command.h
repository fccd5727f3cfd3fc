// Shared by the commands of kerf, and by kerf-bench: error output, JSON, progress. Each command is one source;
// commands.h lists them.
#pragma once

#include <signal.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/base/text.h"
#include "ui/app/program/command_line.h"

namespace kerf::cli {

/// Prints "PROGRAM: MESSAGE" on standard error, in one line whichever bytes a file name holds; returns kFailed. With
/// --json the program also prints {"error": {...}} at its end, unless it has printed other JSON: answerInJson().
int complain(const Error& error);
/// The same for a wrong command line; returns kUsage.
int complainOfUsage(const Error& error);

/// Prints on standard output, indented. Replaces bytes that are no UTF-8 (possible in file names).
void printJson(const nlohmann::json& json);

/// Called once at the end of a command with --json: prints the last error if no JSON was printed.
void answerInJson();

/// The end of main(), once every option is declared: parses, which runs the callbacks, answers --json and flushes.
/// Without Kerf's data it only answers help, --help and --version.
/// @param exit_code  set by the callbacks.    @return  exit code for main.
int runProgram(CLI::App& app, int argc, const char* const* argv, const int& exit_code);

/// Adds --overwrite, and its old spelling --force, hidden from help: users confused it with --hand force and the forces
/// of devices.
void addOverwrite(CLI::App& command, bool& overwrites, const std::string& description);
/// Error kBadValue if the file exists and the user did not allow to replace it.
Expected<void> requireFree(const std::filesystem::path& file, bool overwrites);
/// --case FOLDER: place of a run's case after the run was moved alone; see setPlacesOfCases(). Repeat for neighbours.
void addCasePlaces(CLI::App& command);

/// "3 meshes", "1 piece".
std::string counted(std::size_t count, const std::string& noun);

/// Shows bar, step and time left in a line on standard error if that is a terminal. The first SIGINT, SIGTERM or SIGHUP
/// makes the callback return false. The second, of any kind, ends the program at once. After SIGTERM or SIGHUP the
/// program also ends, with 128 + the signal, if the work does not call the callback for a second. If no callback was
/// taken, the destructor handles the first signal: files are complete before the program ends. The destructor erases
/// the line.
class TerminalProgress {
 public:
  /// @param writes_files  false: no clean-up is needed, and the first signal ends the program at once.
  explicit TerminalProgress(bool writes_files = true);
  ~TerminalProgress();
  TerminalProgress(const TerminalProgress&) = delete;
  TerminalProgress& operator=(const TerminalProgress&) = delete;
  Progress callback();
  /// Erases the line before other output; the next report draws it again.
  void clear();

 private:
  bool is_terminal_, has_looked_up_ = false;
  double start_;
  std::array<struct sigaction, 3> before_{};  // of each signal: restored, so that outer handlers work
  int last_percent_ = -1;
  std::string last_what_;
};

}  // namespace kerf::cli
