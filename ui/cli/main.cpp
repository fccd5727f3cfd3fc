// kerf: everything Kerf does, without a window.
#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "geometry/base/build_info.h"
#include "ui/app/manual.h"
#include "ui/cli/command.h"

int main(int argc, char** argv) {
  using namespace kerf::cli;
  CLI::App app{"Kerf: dental scans in, real cuts, printable meshes out. A training and lab tool, not a medical device.",
               "kerf"};
  app.set_version_flag("--version", kerf::versionText("kerf"));
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  int exit_code = kOk;
  constexpr AddCommand kCommands[] = {addBake, addCut,  addReplay, addExport, addCheck,
                                      addInfo, addTool, addBench,  addDemo,   addDemoMolar};
  for (const AddCommand add : kCommands) add(app, exit_code);
  if (kerf::isManualRequest(argc, argv)) return kerf::answerManualRequest(app, argv[2]);
  if (argc < 2) {
    std::fputs(app.help().c_str(), stderr);
    return kUsage;
  }
  // Of a command it does not know CLI11 only says that one is required.
  std::string known;
  bool is_known = argv[1][0] == '-';
  for (const CLI::App* c : app.get_subcommands([](const CLI::App*) { return true; })) {
    known += (known.empty() ? "" : ", ") + c->get_name();
    is_known |= c->get_name() == argv[1];
  }
  if (!is_known) {
    complain({kerf::Error::Code::kBadValue, "", "", fmt::format("no command \"{}\"", argv[1]), "one of " + known,
              "kerf --help"});
    return kUsage;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kOk : kUsage;
  } catch (const std::exception& e) {
    return complain({kerf::Error::Code::kBadValue, "", "", fmt::format("unexpected: {}", e.what()), "", "report this"});
  }
  // A report that did not arrive (full disk behind a redirection) is no success.
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    return complain({kerf::Error::Code::kWriteFailed, "", "standard output", "could not be written", "", ""});
  return exit_code;
}
