// kerf replay: a recorded session again, and whether it is the same.
#include "sim/run/replay.h"

#include <fmt/format.h>

#include <memory>

#include "sim/session/command.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct Arguments {
  std::string run;
  double until = std::numeric_limits<double>::infinity(), from = 0;
  bool json = false;
  bool lists_commands = false;
};

int run(const Arguments& a) {
  if (a.lists_commands) {
    fmt::print("{}", commandReference());
    return kOk;
  }
  if (a.run.empty()) throw CLI::RequiredError("RUN");
  if (!(a.from >= 0) || !(a.until > a.from))
    return complain({Error::Code::kBadValue, "", "--from, --until", fmt::format("{} s, {} s", a.from, a.until),
                     "--from 0 or later and --until after it", "leave one of them out"});
  const auto again = [&] {
    TerminalProgress progress;
    return replayRun(a.run, progress.callback(), a.until, a.from);
  }();
  if (!again) return complain(again.error());
  if (a.json) {
    nlohmann::json j{{"ticks", again->ticks},           {"checks", again->checks},
                     {"commands", again->commands},     {"is_same", again->is_same},
                     {"state_hash", again->state_hash}, {"removed_mm3", again->removed_mm3},
                     {"objects", again->objects},       {"note", again->note},
                     {"snapshots", again->snapshots},   {"first_tick", again->first_tick}};
    if (!again->is_same && again->checks > 0) j["differs_at_tick"] = again->differs_at;
    printJson(j);
  } else {
    if (again->first_tick > 0)
      fmt::print("from the snapshot at {:.3f} s\n", static_cast<double>(again->first_tick) * kTick);
    else if (a.from > 0)
      fmt::print("from the beginning: no snapshot up to {:g} s that all of the rest can follow from\n", a.from);
    const std::string of = again->objects > 1 ? fmt::format(" of {} objects", again->objects) : "";
    fmt::print("replayed {} ticks ({:.3f} s), {} commands; removed {:.4f} mm3{}; state {}\n", again->ticks,
               static_cast<double>(again->ticks) * kTick, again->commands, again->removed_mm3, of, again->state_hash);
    if (!again->note.empty()) fmt::print("{}\n", again->note);
    if (again->is_same)
      fmt::print("the same bit for bit at all of {} checks of state and force\n", again->checks);
    else if (again->checks > 0)
      fmt::print("DIFFERS: the first of {} checks that does not hold is that of tick {}\n", again->checks,
                 again->differs_at);
  }
  return again->is_same ? kOk : kFailed;
}

}  // namespace

void addReplay(CLI::App& app, int& exit_code) {
  auto a = std::make_shared<Arguments>();
  CLI::App* c = app.add_subcommand("replay", "Replay the session of a run and compare state and force, bit for bit");
  c->footer("Exit code 0: the same; 1: it differs, or the log can not be read.\nExample: kerf replay molar.run");
  c->add_option("RUN", a->run, "run folder, cut with --hand; REQUIRED without --commands");
  c->add_option("--from", a->from,
                "start from the last snapshot in the log that is no later than this simulated second; what lies before "
                "is not compared");
  c->add_option("--until", a->until, "stop after this many simulated seconds");
  c->add_flag("--json", a->json, "as JSON on standard output");
  c->add_flag("--commands", a->lists_commands, "list the commands that a session log can hold, as Markdown");
  c->callback([a, &exit_code] { exit_code = run(*a); });
}

}  // namespace kerf::cli
