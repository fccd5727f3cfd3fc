// kerf: everything Kerf does, without a window.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string_view>
#include <vector>

#include "geometry/base/assets.h"
#include "geometry/base/build_info.h"
#include "ui/app/command_line.h"
#include "ui/app/manual.h"
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

// Of a command it does not know CLI11 only says that one is required.
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
  app.get_formatter()->column_width(34);
  int exit_code = kOk;
  addCommands(app, exit_code);
  kerf::requireFiniteNumbers(app);
  if (kerf::isManualRequest(argc, argv)) return kerf::answerManualRequest(app, argv[2]);

  if (argc < 2) {
    std::fputs(app.help().c_str(), stderr);
    return kUsage;
  }

  const std::vector<std::string_view> words(argv + 1, argv + argc);
  const auto has = [&words](std::string_view word) {
    return std::find(words.begin(), words.end(), word) != words.end();
  };
  const auto answered = [&has](int code) {
    if (has("--json")) answerInJson();
    return code;
  };
  if (!isKnown(argv[1])) return answered(kUsage);
  if (!has("--help") && !has("-h") && !has("--version"))
    if (const auto assets = kerf::requireAssets(); !assets) return answered(complain(assets.error()));

  try {
    if (const auto end = kerf::parseCommandLine(app, argc, argv)) return *end;
  } catch (const std::exception& e) {
    return complain(
        {.code = Error::Code::kBadValue, .found = fmt::format("unexpected: {}", e.what()), .hint = "report this"});
  }

  answered(exit_code);

  // A report that did not arrive (full disk behind a redirection) is no success.
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    return complain({.code = Error::Code::kWriteFailed, .place = "standard output", .found = "could not be written"});
  return exit_code;
}
