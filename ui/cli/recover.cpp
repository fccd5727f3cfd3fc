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
    printText("no lost session in {}\n", (userDataFolder() / "sessions").string());
  else
    printText("kerf recover RUN recovers one, kerf recover RUN --discard deletes it\n");
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
                             {"replayed_from_s", kTick * static_cast<double>(r.first_tick)},
                             {"is_same", r.is_same},
                             {"note", r.note}});
  } else {
    printText("recovered {:.3f} s with {}; removed {:.4f} mm3; state {}\n", recovered->manifest.duration_s,
              recovered->manifest.tool_id, r.removed_mm3, recovered->manifest.state_hash);
    if (r.first_tick > 0)
      printText("replayed from the checkpoint at {:.3f} s\n", kTick * static_cast<double>(r.first_tick));
    if (!r.note.empty()) printText("{}\n", r.note);
    if (!r.is_same && r.checks > 0)
      printText("DIFFERS from the recording, from tick {} on: check the run before you use it\n", r.differs_at);
    printText("run written: {}\n", a.run);
  }
  return r.is_same || r.checks == 0 ? kOk : kFailed;
}

}  // namespace

void addRecover(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<RecoverArguments>();
  command.footer(
      "For a session of the window or of kerf live whose program crashed. The log holds the session up to at most one "
      "second before the end; this command starts from the last checkpoint, replays the rest and writes the run. It "
      "also rebuilds a damaged "
      "run.vdb of an ended session. Without RUN it lists the lost sessions of the window. A killed cut along a path "
      "leaves no files: repeat the command for the same run.\n"
      "Exit code 0: done; 1: failed, or the state differs from the recording.\n"
      "Examples:\n"
      "  kerf recover\n"
      "  kerf recover ~/.local/share/kerf/sessions/molar-1.run");
  command.add_option("RUN", a->run, "run folder of the session");
  command.add_flag("--discard", a->discards, "delete the session with all its cuts instead of recovering it");
  addCasePlaces(command);
  command.add_flag("--json", a->json, "print JSON on standard output");
  command.callback([a, &exit_code] { exit_code = runRecover(*a); });
}

}  // namespace kerf::cli
