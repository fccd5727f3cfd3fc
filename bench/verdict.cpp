#include "bench/verdict.h"

#include <fmt/format.h>

#include <charconv>

namespace kerf::cli {
namespace {

// Whether `text` matches `pattern`, where each {} stands for a text that is not empty.
bool matches(std::string_view pattern, std::string_view text) {
  const std::size_t gap = pattern.find("{}");
  if (gap == pattern.npos) return text == pattern;
  if (!text.starts_with(pattern.substr(0, gap))) return false;

  const std::string_view rest = pattern.substr(gap + 2);
  for (std::size_t end = gap + 1; end <= text.size(); ++end)
    if (matches(rest, text.substr(end))) return true;
  return false;
}

}  // namespace

std::string_view wordsOf(Sense sense) {
  switch (sense) {
    case Sense::kAtMost:
      return "at most";
    case Sense::kAtLeast:
      return "at least";
    case Sense::kExactly:
      return "exactly";
  }
  return "";
}

bool Goal::isAbout(const Measured& number) const { return unit == number.unit && matches(name, number.name); }

bool Goal::isMetBy(double value) const {
  switch (sense) {
    case Sense::kAtMost:
      return value <= limit;
    case Sense::kAtLeast:
      return value >= limit;
    case Sense::kExactly:
      return value == limit;
  }
  return false;
}

std::string Goal::requirement() const { return fmt::format("{} {:g}", wordsOf(sense), limit); }

std::string_view Goal::verdictOn(double value) const {
  if (isMetBy(value)) return "met";
  return weight == Weight::kGoal ? "MISSED" : "MISSED, an aim";
}

Verdict judge(std::span<const Goal> goals, std::span<const Measured> numbers) {
  Verdict verdict;
  std::vector<bool> is_measured(goals.size(), false);
  for (const Measured& number : numbers) {
    const Goal* goal = nullptr;
    for (std::size_t g = 0; g < goals.size() && !goal; ++g)
      if (goals[g].isAbout(number)) {
        goal = &goals[g];
        is_measured[g] = true;
      }
    verdict.goal_of.push_back(goal);
    if (goal && goal->weight == Weight::kGoal && !goal->isMetBy(number.value))
      verdict.missed.push_back(fmt::format("{} is {:.4g}{}{}, not {}", number.name, number.value,
                                           number.unit.empty() ? "" : " ", number.unit, goal->requirement()));
  }

  for (std::size_t g = 0; g < goals.size(); ++g) {
    if (is_measured[g]) continue;
    verdict.not_measured.push_back(&goals[g]);
    verdict.missed.push_back(fmt::format("{} was not measured", goals[g].name));
  }
  return verdict;
}

Expected<void> changeLimits(std::vector<Goal>& goals, std::span<const std::string> limits) {
  for (const std::string& text : limits) {
    const std::size_t equals = text.rfind('=');
    const std::string name = text.substr(0, equals);
    double limit = 0;
    const char* const begin = equals == text.npos ? nullptr : text.data() + equals + 1;
    const char* const end = text.data() + text.size();
    if (!begin || begin == end)
      return fail({.code = Error::Code::kBadValue, .place = "--limit", .found = text, .expected = "GOAL=NUMBER"});
    if (const auto [stop, error] = std::from_chars(begin, end, limit); error != std::errc() || stop != end)
      return fail({.code = Error::Code::kBadValue, .place = "--limit", .found = text, .expected = "GOAL=NUMBER"});

    bool is_known = false;
    std::string known;
    for (Goal& goal : goals) {
      known += (known.empty() ? "\"" : ", \"") + std::string(goal.name) + "\"";
      if (goal.name != name && !matches(goal.name, name)) continue;
      goal.limit = limit;
      is_known = true;
    }
    if (!is_known)
      return fail({.code = Error::Code::kBadValue,
                   .place = "--limit",
                   .found = "\"" + name + "\"",
                   .expected = goals.empty() ? "a scene that has goals" : "one of " + known,
                   .hint = "kerf-bench --list"});
  }
  return {};
}

}  // namespace kerf::cli
