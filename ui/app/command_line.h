// What both programs do with a command line.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "geometry/base/error.h"

namespace kerf {

/// Exit codes of both programs.
enum ExitCode : int {
  kOk = 0,
  kFailed = 1,    ///< the work failed, or a check says no
  kUsage = 2,     ///< wrong command line
  kCutShort = 3,  ///< a log ends before its session did: what is there was done, and is right
};

/// {"error": {"code": ..., "message": ..., ...}}, with the fields that the error has: how both programs answer --json.
nlohmann::json errorJson(const Error& error, const std::string& message);

/// As both programs print JSON: what is no UTF-8 becomes replacement characters, all control characters are escaped.
/// @param indent  -1: on one line.
std::string printableJson(const nlohmann::json& json, int indent = 2);

/// Makes every option that takes numbers refuse those that are not finite, in all commands: CLI::Range and the like let
/// "nan" pass. To be called when all options are declared; --help stays as it is.
void requireFiniteNumbers(CLI::App& app);

/// Parses, which runs the command asked for. Nothing: go on. Otherwise help, version or what is wrong was printed, and
/// this is the exit code: CLI11's own codes, 100 and more, stay inside. What a command throws goes through. An option
/// that the command does not have is answered with the nearest name that it has. With --json on the line of a command
/// that has it, {"error": {...}} is printed on standard output, too.
std::optional<ExitCode> parseCommandLine(CLI::App& app, int argc, const char* const* argv);

}  // namespace kerf
