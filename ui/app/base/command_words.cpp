#include "ui/app/base/command_words.h"

#include <fmt/format.h>

#include <charconv>

namespace kerf {

tl::unexpected<Error> wrongWord(std::string found, std::string expected, std::string hint) {
  return fail({.code = Error::Code::kBadValue,
               .found = std::move(found),
               .expected = std::move(expected),
               .hint = std::move(hint)});
}

Expected<double> numberOf(AppWords words, std::size_t n, const char* name, double low, double high) {
  if (n >= words.size()) return wrongWord("too few parameters", name);
  double value = 0;
  const std::string& word = words[n];
  const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (failed == std::errc{} && end == word.data() + word.size() && value >= low && value <= high) return value;
  return wrongWord("\"" + word + "\"", fmt::format("{}: a number of {:g} to {:g}", name, low, high));
}

Expected<double> numberOr(AppWords words, std::size_t n, double fallback, const char* name, double low, double high) {
  if (n >= words.size()) return fallback;
  return numberOf(words, n, name, low, high);
}

Expected<bool> onOrOff(AppWords words, bool now) {
  if (words.empty()) return !now;
  if (words[0] == "on" || words[0] == "off") return words[0] == "on";
  return wrongWord("\"" + words[0] + "\"", "on or off");
}

Expected<std::filesystem::path> pathOf(AppWords words) {
  if (words.empty() || words[0].empty()) return wrongWord("no file", "its path");
  return std::filesystem::path(words[0]);
}

}  // namespace kerf
