// kerf recover: a session whose program is gone, brought to its end.
#include <fmt/format.h>

#include <memory>

#include "sim/run/session_run.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct Arguments {
  std::string run;
  bool json = false;
};

int run(const Arguments& a) {
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
    fmt::print("recovered {:.3f} s with {}; removed {:.4f} mm3; state {}\n", recovered->manifest.duration_s,
               recovered->manifest.tool_id, r.removed_mm3, recovered->manifest.state_hash);
    if (!r.note.empty()) fmt::print("{}\n", r.note);
    if (!r.is_same && r.checks > 0)
      fmt::print("DIFFERS from what was recorded, from tick {} on: look at it before you use it\n", r.differs_at);
    fmt::print("run written: {}\n", a.run);
  }
  return r.is_same || r.checks == 0 ? kOk : kFailed;
}

}  // namespace

void addRecover(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  command.footer(
      "The session was cut by hand in the window, and its program was killed or the power failed. What was done is in "
      "the log, to a second before the end at most; this does it again and writes the rest of the run.\nExit code 0: "
      "done; 1: it could not be done, or the state differs from what was recorded.\nExample: kerf recover "
      "molar-1.run");
  command.add_option("RUN", a->run, "run folder of the session")->required();
  command.add_flag("--json", a->json, "as JSON on standard output");
  command.callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace kerf::cli
