#include "ui/app/commands/command_tables.h"

#include <fmt/format.h>

#include <charconv>
#include <string>

#include "ui/app/document/file_history.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/imports.h"

namespace kerf::file_commands {
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

bool hasRecent(const AppContext& c) { return !c.bench.history->recent().list().empty() && !c.bench.jobs->running(); }
bool hasLostSession(const AppContext& c) {
  return !c.bench.history->lostSessions().empty() && !c.bench.jobs->running();
}

Expected<void> recentOpen(AppContext& c, AppWords words) {
  KERF_TRY(n, indexOf(words, c.bench.history->recent().list().size(), true));
  c.bench.imports->begin(c.bench.history->recent().list()[n].path);
  return {};
}

Expected<void> recentForget(AppContext& c, AppWords words) {
  KERF_TRY(n, indexOf(words, c.bench.history->recent().list().size(), false));
  c.bench.history->forgetRecent(n);
  return {};
}

Expected<void> sessionForget(AppContext& c, AppWords words) {
  KERF_TRY(n, indexOf(words, c.bench.history->lostSessions().size(), false));
  if (words.size() < 2 || words[1] != "delete")
    return fail({.code = Error::Code::kBadValue,
                 .file = c.bench.history->lostSessions()[n].folder.string(),
                 .found = "no confirmation to delete the log",
                 .expected = "the word delete after the number",
                 .hint = "recover its cuts with session.recover"});
  c.bench.history->forgetLost(n);
  return {};
}

bool hasJob(const AppContext& c) { return c.bench.jobs->running() != nullptr; }
bool hasLost(const AppContext& c) { return !c.bench.history->lostSessions().empty() && when::isIdle(c); }

Expected<void> openFile(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.sessions->open(path);
  return {};
}

Expected<void> openDemo(AppContext& c, AppWords words) {
  const auto names = demoNames();
  std::string list;
  for (const char* name : names) {
    list += (list.empty() ? "" : ", ") + std::string(name);
    if (words.empty() || words[0] != name) continue;
    c.bench.sessions->openDemo(name);
    return {};
  }
  return wrongWord(words.empty() ? "no demo" : "\"" + words[0] + "\"", "one of " + list);
}

Expected<void> exportFile(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.results->exportTo(path);
  return {};
}

Expected<void> closeSession(AppContext& c, AppWords) {
  c.bench.sessions->close();
  return {};
}

Expected<void> recover(AppContext& c, AppWords words) {
  KERF_TRY(n, numberOr(words, 0, 1, "N", 1, 1e6));
  c.bench.history->recover(static_cast<std::size_t>(n) - 1);
  return {};
}

Expected<void> cancelJob(AppContext& c, AppWords) {
  c.bench.jobs->cancel();
  return {};
}

constexpr AppCommand kRows[] = {
    // The menu shows a scan first: FileChooser turns its file into import.read. A script takes the defaults.
    {"file.open", "File:1", "Open...", "Ctrl+O", "PATH",
     "Opens a scan, a recipe or a case. Kerf prepares a scan first.", when::isIdle, openFile},
    {"file.demo", "", "", "", "NAME", "Opens a demo: molar, mandible or arch.", when::isIdle, openDemo},
    {"file.export", "", "", "", "PATH", "Writes the cut object as a mesh, reads it back and checks it.",
     when::isOpenAndIdle, exportFile},
    {"file.close", "File:4", "End session", "Ctrl+W", "", "Saves the session as a run for replay and export.",
     when::isOpenAndIdle, closeSession},
    {"session.recover", "File:4", "Recover session", "", "[N]", "Recovers a session after a crash. 1 is the newest.",
     hasLost, recover},
    {"session.forget", "", "", "", "N delete", "Permanently deletes a lost session and its log.", hasLostSession,
     sessionForget},
    {"recent.open", "File:6", "Reopen last file", "Ctrl+Shift+O", "[N]", "Opens a recent file. 1 is the newest.",
     hasRecent, recentOpen},
    {"recent.forget", "", "", "", "N", "Removes a file from the list of recent files. The file itself stays.",
     hasRecent, recentForget},
    {"job.cancel", "File:7", "Cancel job", "", "", "Cancels the running job and discards its result.", hasJob,
     cancelJob},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::file_commands
