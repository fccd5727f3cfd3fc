// kerf-bench: timed scenes for any machine. Times vary, the state hash does not.
#include <fmt/format.h>

#include "bench/report.h"
#include "geometry/base/build_info.h"
#include "ui/cli/command.h"

namespace kerf::cli {
namespace {

struct Arguments {
  std::string scene, mesh, case_folder;
  double seconds = 20;
  std::vector<std::string> limits;
  bool json = false, list = false, no_goals = false;
};

Expected<std::vector<const Scene*>> askedFor(const Arguments& a) {
  std::vector<const Scene*> asked;
  if (a.scene.empty()) {
    for (const Scene& scene : scenes())
      if (scene.when == Scene::When::kAlways) asked.push_back(&scene);
  } else {
    KERF_TRY(scene, findScene(a.scene));
    asked.push_back(scene);
  }
  return asked;
}

// "points: 50k nodes, p99 is 0.7 ms, not at most 0.5; ..."
Error missedError(const std::vector<std::string>& missed) {
  std::string all;
  for (const std::string& one : missed) all += (all.empty() ? "" : "; ") + one;
  return {.code = Error::Code::kBadValue,
          .place = fmt::format("{} goal{} missed", missed.size(), missed.size() == 1 ? "" : "s"),
          .found = all,
          .hint = "kerf-bench --no-goals to time without goals"};
}

// Runs the scenes in sequence and prints each at its end.   @return the exit code.
Expected<int> runScenes(const Arguments& a) {
  KERF_TRY(asked, askedFor(a));
  const Scratch scratch;
  nlohmann::json all = nlohmann::json::array();
  std::vector<std::string> missed;
  for (const Scene* scene : asked) {
    std::vector<Goal> goals;
    if (a.mesh.empty()) goals.assign(scene->goals.begin(), scene->goals.end());  // they apply to the demo molar
    KERF_CHECK(changeLimits(goals, a.limits));
    const auto run = [&] {
      TerminalProgress progress;
      return scene->run({scratch, progress.callback(), a.mesh, a.case_folder, a.seconds});
    };
    KERF_TRY(result, run());

    const Verdict verdict = judge(goals, result.measured);
    const Verdict* const shown = a.no_goals ? nullptr : &verdict;
    for (const std::string& one : verdict.missed) missed.push_back(fmt::format("{}: {}", scene->name, one));
    if (a.json)
      all.push_back(jsonOf(result, shown));
    else
      printResult(result, shown);
  }
  if (a.json) printJson(all);
  if (a.no_goals || missed.empty()) return kOk;
  return complain(missedError(missed));
}

void addOptions(CLI::App& app, Arguments& a) {
  std::string rows = "Scenes:";
  for (const Scene& scene : scenes()) rows += fmt::format("\n  {:<15} {}", scene.name, scene.what);
  app.footer(rows +
             "\nExit code: 1 when a goal is missed."
             "\nExample: kerf-bench bake --mesh scan.stl");
  app.add_option("SCENE", a.scene, "one scene; default: all but those that only run by name");
  app.add_option("--mesh", a.mesh, "mesh for bake and export (default: the demo molar)");
  app.add_option("--case", a.case_folder, "case for open (default: the demo mandible at 0.1 mm)");
  app.add_option("--seconds", a.seconds, "length of realtime")->check(CLI::Range(1.0, 3600.0))->capture_default_str();
  app.add_option_function<double>(
         "--minutes", [&a](double minutes) { a.seconds = 60 * minutes; }, "the same in minutes, of window-memory")
      ->check(CLI::Range(0.1, 600.0))
      ->excludes("--seconds");
  app.add_flag("--no-goals", a.no_goals, "print the numbers and judge none of them");
  app.add_option("--limit", a.limits, "GOAL=NUMBER: judge SCENE by a limit of your own")->allow_extra_args(false);
  app.add_flag("--list", a.list, "print the scenes and their goals, and run none");
  app.add_flag("--json", a.json, "print JSON on standard output");
}

int run(const Arguments& a) {
  if (!a.limits.empty() && a.scene.empty()) throw CLI::ValidationError("--limit", "needs a SCENE");
  if (a.list) {
    if (a.json)
      printJson(jsonOfScenes());
    else
      printScenes();
    return kOk;
  }
  const auto done = runScenes(a);
  return done ? *done : complain(done.error());
}

}  // namespace
}  // namespace kerf::cli

int main(int argc, char** argv) {
  using namespace kerf::cli;
  CLI::App app{"Times Kerf on shared scenes: p50, p99, max and the state hash.", "kerf-bench"};
  app.set_version_flag("--version", kerf::versionText("kerf-bench"));
  app.get_formatter()->column_width(34);
  Arguments arguments;
  int exit_code = kerf::kOk;
  addOptions(app, arguments);
  app.callback([&] { exit_code = run(arguments); });
  return runProgram(app, argc, argv, exit_code);
}
