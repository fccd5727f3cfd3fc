#include "ui/app/commands/command_tables.h"

#include <fmt/format.h>

#include <charconv>
#include <string>

#include "sim/run/files/run_manifest.h"
#include "ui/app/document/document.h"
#include "ui/app/document/file_history.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/results.h"
#include "ui/app/workbench/sessions.h"

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

Expected<void> recentStartOver(AppContext& c, AppWords words) {
  KERF_TRY(n, indexOf(words, c.bench.history->recent().list().size(), false));
  const auto& path = c.bench.history->recent().list()[n].path;
  if (!isRun(path))
    return fail({.code = Error::Code::kBadValue,
                 .file = path.string(),
                 .found = "no session",
                 .expected = "a session with cuts",
                 .hint = fmt::format("open the file with recent.open {}", n + 1)});
  c.bench.sessions->startOver(path);
  return {};
}

// ---- Saved sessions

Expected<std::size_t> sessionOf(AppContext& c, AppWords words) {
  c.bench.history->refreshSessions();
  return indexOf(words, c.bench.history->sessions().size(), false);
}

// The open session still needs the folder that it continues.
Expected<std::size_t> unusedSessionOf(AppContext& c, AppWords words) {
  KERF_TRY(n, sessionOf(c, words));
  const auto& folder = c.bench.history->sessions()[n].folder;
  const LiveRun* const run = c.bench.document->run();
  if (!run || run->from() != folder) return n;
  return fail({.code = Error::Code::kUnsupported,
               .file = folder.string(),
               .found = "the open session continues it",
               .expected = "another session",
               .hint = "end the open session first: file.close"});
}

Expected<void> sessionOpen(AppContext& c, AppWords words) {
  KERF_TRY(n, sessionOf(c, words));
  c.bench.sessions->open(c.bench.history->sessions()[n].folder);
  return {};
}

Expected<void> sessionRename(AppContext& c, AppWords words) {
  KERF_TRY(n, unusedSessionOf(c, words));
  std::string name;
  for (std::size_t k = 1; k < words.size(); ++k) name += (k > 1 ? " " : "") + words[k];
  return c.bench.history->renameSession(n, name);
}

Expected<void> sessionDelete(AppContext& c, AppWords words) {
  KERF_TRY(n, unusedSessionOf(c, words));
  if (words.size() >= 2 && words[1] == "delete") return c.bench.history->deleteSession(n);
  return fail({.code = Error::Code::kBadValue,
               .file = c.bench.history->sessions()[n].folder.string(),
               .found = "no confirmation to delete the session",
               .expected = "the word delete after the number"});
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

Expected<void> saveAs(AppContext& c, AppWords words) {
  KERF_TRY(path, pathOf(words));
  c.bench.sessions->saveAs(path);
  return {};
}

Expected<void> save(AppContext& c, AppWords) {
  if (!c.bench.sessions->savedAs().empty()) {
    c.bench.sessions->saveAs(c.bench.sessions->savedAs());
    return {};
  }
  if (!c.ask_for_file)
    return fail({.code = Error::Code::kBadValue,
                 .found = "the session has no file yet",
                 .expected = "a session that was saved to a file",
                 .hint = "file.save-as NAME.kerf"});
  c.ask_for_file("file.save-as");
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
     "Opens a scan, a recipe, a case or a session. Kerf prepares a scan first.", when::isIdle, openFile},
    {"file.demo", "", "", "", "NAME", "Opens a demo: molar, mandible or arch.", when::isIdle, openDemo},
    {"file.export", "", "", "", "PATH", "Writes the cut object as a mesh, reads it back and checks it.",
     when::isOpenAndIdle, exportFile},
    {"file.save", "File:3", "Save", "Ctrl+S", "", "Saves the session to its file. Asks for a name the first time.",
     when::isOpenAndIdle, save},
    {"file.save-as", "File:3", "Save as...", "Ctrl+Shift+S", "PATH",
     "Saves the session with its case to one file, NAME.kerf. The session goes on.", when::isOpenAndIdle, saveAs},
    {"file.close", "File:4", "End session", "Ctrl+W", "", "Saves the session as a run for replay and export.",
     when::isOpenAndIdle, closeSession},
    {"session.list", "File:5", "Sessions...", "", "[on|off]", "Lists the saved sessions.", when::isIdle,
     switchPanel<"sessions">},
    {"session.open", "", "", "", "N", "Continues a session of the list. 1 is the newest.", when::isIdle, sessionOpen},
    {"session.rename", "", "", "", "N NAME", "Renames a session of the list.", when::isIdle, sessionRename},
    {"session.delete", "", "", "", "N delete", "Permanently deletes a session of the list.", when::isIdle,
     sessionDelete},
    {"session.recover", "File:4", "Recover session", "", "[N]", "Recovers a session after a crash. 1 is the newest.",
     hasLost, recover},
    {"session.forget", "", "", "", "N delete", "Permanently deletes a lost session and its log.", hasLostSession,
     sessionForget},
    {"recent.open", "File:6", "Reopen last file", "Ctrl+Shift+O", "[N]",
     "Opens a recent file, or continues a recent session. 1 is the newest.", hasRecent, recentOpen},
    {"recent.start-over", "", "", "", "N", "Opens the case of a recent session without its cuts.", hasRecent,
     recentStartOver},
    {"recent.forget", "", "", "", "N", "Removes a file from the list of recent files. The file itself stays.",
     hasRecent, recentForget},
    {"job.cancel", "File:7", "Cancel job", "", "", "Cancels the running job and discards its result.", hasJob,
     cancelJob},
};

}  // namespace

std::span<const AppCommand> table() { return kRows; }

}  // namespace kerf::file_commands
