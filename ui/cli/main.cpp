// kerf: all functions of Kerf without a window.
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/build_info.h"
#include "ui/app/program/manual.h"
#include "ui/app/script/window_help.h"
#include "ui/cli/commands.h"

namespace {

using namespace kerf::cli;
using kerf::Error;
using kerf::kOk;
using kerf::kUsage;

void addCommands(CLI::App& app, int& exit_code) {
  for (const CommandRow& row : kCommands)
    row.add(*app.add_subcommand(row.name, row.summary)->group(row.group), exit_code);
}

// Below the commands in `kerf --help`; `column` is the place of their summaries.
std::string footer(const std::vector<kerf::HelpPage>& pages, std::size_t column) {
  std::string out = "Topics of kerf help:\n";
  for (const kerf::HelpPage& page : pages) out += fmt::format("  {:<{}}{}\n", page.name, column - 2, page.summary);
  return out + fmt::format(
                   "\n\"kerf help cut\" prints the options of kerf cut,\n"
                   "\"kerf help view.roll\" explains one command of the window.\n\n"
                   "Exit codes:\n{}\n\n"
                   "--json prints the report on standard output. Messages go to standard error.",
                   kerf::kExitCodes);
}

// For an unknown command CLI11 only reports that one is required.
bool isKnown(const std::string& word) {
  if (word.starts_with("-")) return true;
  std::string known;
  for (const CommandRow& row : kCommands) {
    if (word == row.name) return true;
    known += (known.empty() ? "" : ", ") + std::string(row.name);
  }
  complain({.code = Error::Code::kBadValue,
            .found = fmt::format("no command \"{}\"", word),
            .expected = "one of " + known,
            .hint = "kerf --help"});
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Kerf: dental scans in, real cuts, printable meshes out. A training and lab tool, not a medical device.",
               "kerf"};
  app.set_version_flag("--version", kerf::versionText("kerf"));
  app.require_subcommand(1);
  constexpr std::size_t kColumn = 34;
  app.get_formatter()->column_width(kColumn);
  const std::vector<kerf::HelpPage> pages = kerf::windowHelp();
  app.footer(footer(pages, kColumn));
  int exit_code = kOk;
  addCommands(app, exit_code);
  if (kerf::isManualRequest(argc, argv)) return kerf::answerManualRequest(app, argv[2], pages);

  if (argc < 2) {
    std::fputs(app.help().c_str(), stderr);
    return kUsage;
  }
  if (!isKnown(argv[1])) {
    if (std::find(argv, argv + argc, std::string_view("--json")) != argv + argc) answerInJson();
    return kUsage;
  }
  return runProgram(app, argc, argv, exit_code);
}
