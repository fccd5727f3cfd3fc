// What both programs do with a command line.
#pragma once

#include <CLI/CLI.hpp>

namespace kerf {

/// Makes every option that takes numbers refuse those that are not finite, in all commands: CLI::Range and the like let
/// "nan" pass. To be called when all options are declared; --help stays as it is.
void requireFiniteNumbers(CLI::App& app);

}  // namespace kerf
