#include "ui/app/program/command_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/text.h"
#include "geometry/base/toml_reader.h"

namespace kerf {
namespace {

// "nan", "-inf", "1e999"; CLI11 itself rejects non-numbers.
std::string notFinite(const std::string& word) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  const bool is_number = end != word.c_str() && *end == '\0';
  return is_number && !std::isfinite(value) ? word + " is not a finite number" : std::string();
}

// The innermost command at the parse error: `kerf tool check`, not `kerf`.
const CLI::App& commandInHand(const CLI::App& app) {
  const std::vector<CLI::App*> begun = app.get_subcommands();
  return begun.empty() ? app : commandInHand(*begun.back());
}

// "kerf tool check", as typed.
std::string typedName(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return parent ? typedName(*parent) + " " + command.get_name() : command.get_name();
}

// Long names of the options that --help lists, without their dashes.
std::vector<std::string> optionsOf(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options([](const CLI::Option* o) { return !o->get_group().empty(); }))
    for (const std::string& name : option->get_lnames()) names.push_back(name);
  return names;
}

bool isOption(const std::string& word) {
  const bool is_number = word.size() > 1 && (word[1] == '.' || (word[1] >= '0' && word[1] <= '9'));
  return word.size() > 1 && word[0] == '-' && !is_number;
}

// Error for words that no option or command takes. CLI11 lists them from the last to the first: the value of an unknown
// option would come before the option.
Error aboutExtras(const CLI::App& command) {
  const std::vector<std::string> extras = command.remaining();
  const std::string name = typedName(command);
  Error error{.code = Error::Code::kBadValue, .hint = name + " --help"};
  const auto option = std::find_if(extras.begin(), extras.end(), isOption);
  if (option == extras.end()) {
    error.place = extras.empty() ? name : extras.front();
    error.found = "one word too many for " + name;
    return error;
  }

  error.place = option->substr(0, option->find('='));
  error.found = "no such option of " + name;
  const std::string word = error.place.substr(error.place.find_first_not_of('-'));
  if (const std::string near = nearestName(word, optionsOf(command)); !near.empty())
    error.found += fmt::format(" (did you mean --{}?)", near);
  return error;
}

// Also true for a missing required option if the line has an unknown one: it may be a misspelling.
bool isAboutExtras(const CLI::ParseError& e, const CLI::App& command) {
  if (dynamic_cast<const CLI::ExtrasError*>(&e)) return true;
  const std::vector<std::string> extras = command.remaining();
  return dynamic_cast<const CLI::RequiredError*>(&e) && std::any_of(extras.begin(), extras.end(), isOption);
}

// "0.005" from "0.005000".
std::string shortNumber(const std::string& digits) { return fmt::format("{:g}", std::strtod(digits.c_str(), nullptr)); }

// Limits in CLI11's spelling, which gives the largest double in full.
std::string rangeInWords(const std::string& low, const std::string& high) {
  const bool is_bounded = std::strtod(high.c_str(), nullptr) < 1e300;
  if (is_bounded) return fmt::format("a number from {} to {}", shortNumber(low), shortNumber(high));
  return "a number of " + shortNumber(low) + " or more";
}

// Error for a non-number or a value out of range. CLI11 reports them in one sentence: "--voxel: Value 7 not in range
// 0.005000 to 5.000000", in version 2.4 "[0.005 - 5]"; or "Could not convert: --push = x".
std::optional<Error> aboutNumber(const CLI::ParseError& e, const CLI::App& command) {
  std::string text = e.what();
  const bool is_bracketed = text.find(" not in range [") != text.npos && text.ends_with(']');
  if (is_bracketed) text.pop_back();
  const auto between = [&](std::size_t begin, std::size_t end) { return text.substr(begin, end - begin); };
  Error error{.code = Error::Code::kBadValue, .hint = typedName(command) + " --help"};

  const std::string unread = "Could not convert: ", is = " = ";
  const std::string value = ": Value ", range = is_bracketed ? " not in range [" : " not in range ",
                    to = is_bracketed ? " - " : " to ";
  const std::size_t at_is = text.find(is), at_value = text.find(value), at_range = text.rfind(range),
                    at_to = text.rfind(to);
  if (text.starts_with(unread) && at_is != text.npos) {
    error.place = between(unread.size(), at_is);
    error.found = text.substr(at_is + is.size());
    const CLI::Option* option = command.get_option_no_throw(error.place);
    const bool is_whole = option && option->get_type_name().find("INT") != std::string::npos;
    error.expected = is_whole ? "a whole number" : "a number";
    return error;
  }
  const bool is_range = at_value != text.npos && at_range != text.npos && at_to != text.npos &&
                        at_value + value.size() <= at_range && at_range + range.size() <= at_to;
  if (!is_range) return std::nullopt;

  error.place = between(0, at_value);
  error.found = between(at_value + value.size(), at_range);
  error.expected = rangeInWords(between(at_range + range.size(), at_to), text.substr(at_to + to.size()));
  const CLI::Option* option = command.get_option_no_throw(error.place);
  if (option && option->get_type_name().find("POSITIVE") != std::string::npos) error.expected = "a number above 0";
  return error;
}

// Best guess, as the line does not parse: the command has --json and the line contains it.
bool asksForJson(const CLI::App& command, int argc, const char* const* argv) {
  const bool is_asked = std::find(argv, argv + argc, std::string_view("--json")) != argv + argc;
  return is_asked && command.get_option_no_throw("--json");
}

const char* nameOfOption(Error::Code code) {
  switch (code) {
    case Error::Code::kNotFound:
      return "not_found";
    case Error::Code::kUnreadable:
      return "unreadable";
    case Error::Code::kBadFormat:
      return "bad_format";
    case Error::Code::kBadValue:
      return "bad_value";
    case Error::Code::kUnsupported:
      return "unsupported";
    case Error::Code::kEmpty:
      return "empty";
    case Error::Code::kGeometry:
      return "geometry";
    case Error::Code::kWriteFailed:
      return "write_failed";
    case Error::Code::kCancelled:
      return "cancelled";
  }
  return "other";
}

}  // namespace

nlohmann::json errorJson(const Error& error, const std::string& message) {
  nlohmann::json out{{"code", nameOfOption(error.code)}, {"message", message}};
  for (const auto& [key, text] :
       {std::pair("file", error.file), std::pair("place", error.place), std::pair("found", error.found),
        std::pair("expected", error.expected), std::pair("hint", error.hint)})
    if (!text.empty()) out[key] = text;
  return {{"error", std::move(out)}};
}

std::string printableJson(const nlohmann::json& json, int indent) {
  std::string out;
  for (const char c : json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace)) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_c1 = out.ends_with('\xc2') && byte < 0xa0;
    if (is_c1) out.pop_back();
    out += is_c1 || byte == 0x7f ? fmt::format("\\u{:04x}", byte) : std::string(1, c);
  }
  return out;
}

void requireFiniteNumbers(CLI::App& app) {
  // CLI11 keeps only the --help text of an option's type: "FLOAT", or "F:FLOAT in [0.001 - 1000]".
  for (CLI::Option* option : app.get_options([](const CLI::Option*) { return true; }))
    if (option->get_type_name().find("FLOAT") != std::string::npos) option->check(CLI::Validator(notFinite, ""));

  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) requireFiniteNumbers(*command);
}

std::optional<ExitCode> parseCommandLine(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const bool is_answer = e.get_exit_code() == 0;  // --help, --version
    const CLI::App& command = commandInHand(app);
    Error error{.code = Error::Code::kBadValue, .found = e.what(), .hint = typedName(command) + " --help"};
    std::string message = e.what();
    if (isAboutExtras(e, command)) {
      error = aboutExtras(command);
      message = error.message();
      printText(stderr, "{}: {}\n", app.get_name(), message);
    } else if (const auto number = aboutNumber(e, command)) {
      error = *number;
      message = error.message();
      printText(stderr, "{}: {}\n", app.get_name(), message);
    } else {
      std::ostringstream out, err;
      app.exit(e, out, err);
      printText("{}", out.str());
      printText(stderr, "{}", err.str());
      if (is_answer) return kOk;
    }
    if (asksForJson(command, argc, argv)) printText("{}\n", printableJson(errorJson(error, message)));
    return kUsage;
  }
  return std::nullopt;
}

}  // namespace kerf
