// Shared by the commands of kerf, and by kerf-bench: complaints, JSON, progress. A command is one source; the list of
// all is commands.h.
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
#include "ui/app/command_line.h"

namespace kerf::cli {

/// Prints "PROGRAM: MESSAGE" on standard error, one line whatever bytes a file name holds; returns kFailed. With --json
/// the program also answers {"error": {...}} in the end, unless it has printed other JSON: answerInJson().
int complain(const Error& error);
/// The same about a wrong command line; returns kUsage.
int complainOfUsage(const Error& error);

/// On standard output, indented. Bytes that are no UTF-8 (file names may hold any) become replacement characters.
void printJson(const nlohmann::json& json);

/// Called once, when the command is over and asked for JSON: what was complained of last, if no JSON was printed.
void answerInJson();

/// The end of main(), once all options are declared: parses, which runs the callbacks, answers --json and flushes.
/// Without Kerf's data it only answers --help and --version.
/// @param exit_code  set by the callbacks.    @return what main returns.
int runProgram(CLI::App& app, int argc, const char* const* argv, const int& exit_code);

/// --overwrite, and its old spelling --force, which help does not show: beside --hand force and the forces of devices
/// it was taken for one of them.
void addOverwrite(CLI::App& command, bool& overwrites, const std::string& description);
/// Error kBadValue if a file is there that the user has not said to replace.
Expected<void> requireFree(const std::filesystem::path& file, bool overwrites);
/// --case FOLDER: where the case of a run is that was moved alone; see setPlacesOfCases(). Repeat for cases beside.
void addCasePlaces(CLI::App& command);

/// "3 meshes", "1 piece".
std::string counted(std::size_t count, const std::string& noun);

/// A line with bar, step and time left on standard error when that is a terminal; nothing otherwise. The first SIGINT,
/// SIGTERM or SIGHUP makes the callback say no; the second, of either kind, ends the program at once. After SIGTERM or
/// SIGHUP it also ends, with 128 + the signal, if nobody asks the callback for a second. Where no callback
/// was taken, the first is put off until the destructor: files are written to their end, then the program ends by it.
/// The line is erased by the destructor.
class TerminalProgress {
 public:
  /// @param writes_files  false: there is nothing to clean up, and the first signal ends the program at once.
  explicit TerminalProgress(bool writes_files = true);
  ~TerminalProgress();
  TerminalProgress(const TerminalProgress&) = delete;
  TerminalProgress& operator=(const TerminalProgress&) = delete;
  Progress callback();
  /// Erases the line, before something is printed; the next report draws it again.
  void clear();

 private:
  bool is_terminal_, has_looked_up_ = false;
  double start_;
  std::array<struct sigaction, 3> before_{};  // of each signal: whoever waits for it goes on waiting
  int last_percent_ = -1;
  std::string last_what_;
};

}  // namespace kerf::cli
