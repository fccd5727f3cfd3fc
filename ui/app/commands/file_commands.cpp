#include "ui/app/commands/file_commands.h"

#include <fmt/format.h>

#include <charconv>
#include <string>

namespace kerf {
namespace {

// Counts from 1.
Expected<std::size_t> indexOf(AppWords words, std::size_t count, bool may_be_left_out) {
  std::size_t n = 0;
  if (words.empty() && may_be_left_out && count > 0) return n;
  const std::string word = words.empty() ? std::string() : words[0];
  const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), n);
  if (failed == std::errc{} && end == word.data() + word.size() && n >= 1 && n <= count) return n - 1;
  return fail({.code = Error::Code::kBadValue,
               .found = word.empty() ? "no number" : "\"" + word + "\"",
               .expected = fmt::format("N: 1 to {}", count)});
}

}  // namespace

bool hasRecent(const AppContext& c) { return !c.bench.recent().list().empty() && !c.bench.job(); }
bool hasLostSession(const AppContext& c) { return !c.bench.lostSessions().empty() && !c.bench.job(); }

Expected<void> recentOpen(AppContext& c, AppWords words) {
  KERF_TRY(n, indexOf(words, c.bench.recent().list().size(), true));
  c.bench.beginImport(c.bench.recent().list()[n].path);
  return {};
}

Expected<void> recentForget(AppContext& c, AppWords words) {
  KERF_TRY(n, indexOf(words, c.bench.recent().list().size(), false));
  c.bench.forgetRecent(n);
  return {};
}

Expected<void> sessionForget(AppContext& c, AppWords words) {
  KERF_TRY(n, indexOf(words, c.bench.lostSessions().size(), false));
  if (words.size() < 2 || words[1] != "delete")
    return fail({.code = Error::Code::kBadValue,
                 .file = c.bench.lostSessions()[n].folder.string(),
                 .found = "a log that would be lost",
                 .expected = "the word delete behind the number",
                 .hint = "session.recover brings back what was cut in it"});
  c.bench.forgetLost(n);
  return {};
}

}  // namespace kerf
