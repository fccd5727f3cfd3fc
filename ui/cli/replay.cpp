// kerf replay: repeats a recorded session and compares the results.
#include "sim/run/report/replay.h"

#include <fmt/format.h>

#include <memory>

#include "sim/session/command.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct ReplayArguments {
  std::string run;
  double until = std::numeric_limits<double>::infinity(), from = 0;
  bool json = false;
  bool lists_commands = false;
};

nlohmann::json replayJson(const Replay& r) {
  nlohmann::json j{
      {"ticks", r.ticks},       {"checks", r.checks},         {"commands", r.commands},       {"is_same", r.is_same},
      {"is_whole", r.is_whole}, {"state_hash", r.state_hash}, {"removed_mm3", r.removed_mm3}, {"objects", r.objects},
      {"note", r.note},         {"snapshots", r.snapshots},   {"first_tick", r.first_tick}};
  if (!r.is_same && r.checks > 0) j["differs_at_tick"] = r.differs_at;
  return j;
}

void printReplay(const Replay& r, double from_s) {
  if (r.first_tick > 0)
    printText("from the snapshot at {:.3f} s\n", static_cast<double>(r.first_tick) * kTick);
  else if (from_s > 0)
    printText("from the beginning: no usable snapshot up to {:g} s\n", from_s);

  const std::string of = r.objects > 1 ? fmt::format(" of {} objects", r.objects) : "";
  printText("replayed {} ticks ({:.3f} s), {} commands; removed {:.4f} mm3{}; state {}\n", r.ticks,
            static_cast<double>(r.ticks) * kTick, r.commands, r.removed_mm3, of, r.state_hash);
  if (!r.note.empty()) printText("{}\n", r.note);

  if (r.is_same && r.is_whole)
    printText("the same bit for bit at all of {} checks of state and force\n", r.checks);
  else if (r.is_same)
    printText("INCOMPLETE: the same bit for bit at all of {} checks up to there; the rest cannot be compared\n",
              r.checks);
  else if (r.checks > 0)
    printText("DIFFERS: of {} checks, the first failed at tick {}\n", r.checks, r.differs_at);
}

int runReplay(const ReplayArguments& a) {
  if (a.lists_commands) {
    printText("{}", commandReference());
    return kOk;
  }
  if (a.run.empty()) throw CLI::RequiredError("RUN");
  if (!(a.from >= 0) || !(a.until > a.from))
    return complainOfUsage({.code = Error::Code::kBadValue,
                            .place = "--from, --until",
                            .found = fmt::format("{} s, {} s", a.from, a.until),
                            .expected = "--from 0 or later and --until after it",
                            .hint = "omit one of them"});
  const auto again = [&] {
    TerminalProgress progress;
    return replayRun(a.run, progress.callback(), a.until, a.from);
  }();
  if (!again) return complain(again.error());

  if (a.json)
    printJson(replayJson(*again));
  else
    printReplay(*again, a.from);
  const bool differs = !again->is_same && again->checks > 0;
  if (!again->is_whole && !differs) return kCutShort;
  return again->is_same ? kOk : kFailed;
}

}  // namespace

void addReplay(CLI::App& command, int& exit_code) {
  auto a = std::make_shared<ReplayArguments>();
  command.footer(
      "Exit code 0: the same; 1: it differs, or the log cannot be read; 3: the log is cut short, the same up to "
      "there.\n"
      "Example: kerf replay molar.run");
  command.add_option("RUN", a->run,
                     "run folder, cut with --hand, or a session file (.kerf); REQUIRED without --commands");
  command.add_option("--from", a->from,
                     "start from the last snapshot at or before this simulated second; earlier ticks are not compared");
  command.add_option("--until", a->until, "stop after this many simulated seconds");
  command.add_flag("--json", a->json, "print JSON on standard output");
  command.add_flag("--commands", a->lists_commands, "list the commands of a session log, as Markdown");
  addCasePlaces(command);
  command.callback([a, &exit_code] { exit_code = runReplay(*a); });
}

}  // namespace kerf::cli
