#include "ui/app/command_line.h"

#include <cmath>
#include <cstdlib>
#include <string>

namespace kerf {
namespace {

// "nan", "-inf", "1e999"; what is no number at all CLI11 refuses itself.
std::string notFinite(const std::string& word) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  const bool is_number = end != word.c_str() && *end == '\0';
  return is_number && !std::isfinite(value) ? word + " is not a finite number" : std::string();
}

}  // namespace

void requireFiniteNumbers(CLI::App& app) {
  // CLI11 keeps of an option's type only what --help says of it: "FLOAT", or "F:FLOAT in [0.001 - 1000]".
  for (CLI::Option* option : app.get_options([](const CLI::Option*) { return true; }))
    if (option->get_type_name().find("FLOAT") != std::string::npos) option->check(CLI::Validator(notFinite, ""));

  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) requireFiniteNumbers(*command);
}

std::optional<ExitCode> parseCommandLine(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kOk : kUsage;
  }
  return std::nullopt;
}

}  // namespace kerf
