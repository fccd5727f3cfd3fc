// What both programs do with a command line.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>

namespace kerf {

/// Exit codes of both programs.
enum ExitCode : int {
  kOk = 0,
  kFailed = 1,  ///< the work failed, or a check says no
  kUsage = 2,   ///< wrong command line
};

/// Makes every option that takes numbers refuse those that are not finite, in all commands: CLI::Range and the like let
/// "nan" pass. To be called when all options are declared; --help stays as it is.
void requireFiniteNumbers(CLI::App& app);

/// Parses, which runs the command asked for. Nothing: go on. Otherwise help, version or what is wrong was printed, and
/// this is the exit code: CLI11's own codes, 100 and more, stay inside. What a command throws goes through.
std::optional<ExitCode> parseCommandLine(CLI::App& app, int argc, const char* const* argv);

}  // namespace kerf
