// Command line handling of both programs.
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
  kFailed = 1,    ///< the work or a check failed
  kUsage = 2,     ///< wrong command line
  kCutShort = 3,  ///< the log is incomplete; the part up to its end was processed correctly
};

/// The exit codes in help texts and manual pages, a line each.
inline constexpr const char* kExitCodes =
    "  0  done\n"
    "  1  failure: also a missing file or tool, and a check that says no\n"
    "  2  wrong command line: an unknown option, or a wrong number or word\n"
    "  3  kerf replay: incomplete log, replayed up to its end";

/// The --json answer of both programs: {"error": {"code": ..., "message": ..., ...}}, with the error's other fields.
nlohmann::json errorJson(const Error& error, const std::string& message);

/// JSON text of both programs: replacement characters for invalid UTF-8, escapes for all control characters.
/// @param indent  -1: on one line.
std::string printableJson(const nlohmann::json& json, int indent = 2);

/// Makes all numeric options of all commands reject non-finite numbers: CLI::Range and the like accept "nan". Call it
/// after the declaration of all options. --help stays the same.
void requireFiniteNumbers(CLI::App& app);

/// Parses the line, which runs its command. @return  none: continue; else the exit code, after printing help, version
/// or the error. CLI11's own codes, 100 and more, stay inside. Exceptions of a command pass through. The error for an
/// unknown option suggests the nearest known name. If the command has --json and the line contains it, standard output
/// also gets {"error": {...}}.
std::optional<ExitCode> parseCommandLine(CLI::App& app, int argc, const char* const* argv);

}  // namespace kerf
