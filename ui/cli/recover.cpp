// kerf recover: lists sessions of programs that have died, and completes or discards one.
#include <fmt/format.h>

#include <memory>

#include "sim/run/session/session_run.h"
#include "ui/app/base/user_files.h"
#include "ui/app/import/lost_sessions.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct RecoverArguments {
  std::string run;
  bool discards = false;
  bool json = false;
};

int list(const RecoverArguments& a) {
  const std::vector<LostSession> lost = findLostSessions(userDataFolder());
  if (a.json) {
    auto rows = nlohmann::json::array();
    for (const LostSession& session : lost)
      rows.push_back({{"run", session.folder.string()}, {"case", session.case_name}, {"bytes", bytesOf(session)}});
    printJson(rows);
    return kOk;
  }
  for (const LostSession& session : lost)
    printText("{}  {:.1f} MB, case {}\n", session.folder.string(), 1e-6 * static_cast<double>(bytesOf(session)),
              session.case_name);
  if (lost.empty())
    printText("no session whose program is gone in {}\n", (userDataFolder() / "sessions").string());
  else
    printText("kerf recover RUN finishes one, kerf recover RUN --discard deletes it\n");
  return kOk;
}

int discard(const RecoverArguments& a) {
  if (const auto done = discardSession(a.run); !done) return complain(done.error());
  if (a.json)
    printJson(nlohmann::json{{"run", a.run}, {"discarded", true}});
  else
    printText("deleted: {}\n", a.run);
  return kOk;
}

int runRecover(const RecoverArguments& a) {
  if (a.run.empty()) {
    if (a.discards) throw CLI::RequiredError("RUN");
    return list(a);
  }
  if (a.discards) return discard(a);

  const auto recovered = [&] {
    TerminalProgress progress;
    return recoverRun(a.run, progress.callback());
  }();
  if (!recovered) return complain(recovered.error());

  const Replay& r = recovered->replay;
  if (a.json) {
    printJson(nlohmann::json{{"run", a.run},
                             {"seconds", recovered->manifest.duration_s},
                             {"removed_mm3", r.removed_mm3},
                             {"state_hash", recovered->manifest.state_hash},
                             {"is_same", r.is_same},
                             {"note", r.note}});
  } else {
    printText("recovered {:.3f} s with {}; removed {:.4f} mm3; state {}\n", recovered->manifest.duration_s,
              recovered->manifest.tool_id, r.removed_mm3, recovered->manifest.state_hash);
    if (!r.note.empty()) printText("{}\n", r.note);
    if (!r.is_same && r.checks > 0)
      printText("DIFFERS from what was recorded, from tick {} on: look at it before you use it\n", r.differs_at);
    printText("run written: {}\n", a.run);
  }
  return r.is_same || r.checks == 0 ? kOk : kFailed;
}

}  // namespace

void addRecover(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<RecoverArguments>();
  command.footer(
      "The session was cut by hand in the window or by kerf live, and its program was killed or the power failed. What "
      "was done is in the log, to a second before the end at most; this does it again and writes the rest of the "
      "run. A damaged run.vdb of a session that has ended is rebuilt from its log. Without RUN the sessions of the "
      "window that wait for it are listed. A cut along a path that was killed "
      "leaves nothing: the same command gives the same run.\nExit code 0: done; 1: it could not be done, or the state "
      "differs from what was recorded.\nExamples:\n  kerf recover\n  kerf recover "
      "~/.local/share/kerf/sessions/molar-1.run");
  command.add_option("RUN", a->run, "run folder of the session");
  command.add_flag("--discard", a->discards, "delete it, with all that was cut in it, instead of finishing it");
  addCasePlaces(command);
  command.add_flag("--json", a->json, "as JSON on standard output");
  command.callback([a, &exit_code] { exit_code = runRecover(*a); });
}

}  // namespace kerf::cli
