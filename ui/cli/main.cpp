// kerf: all functions of Kerf without a window.
#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/base/build_info.h"
#include "ui/app/import/session_file.h"
#include "ui/app/program/manual.h"
#include "ui/app/script/window_help.h"
#include "ui/cli/commands.h"

namespace {

namespace fs = std::filesystem;
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

// Sessions saved as one file, for commands that take a run: unpacked to a temporary folder while the program works.
class UnpackedSessions {
 public:
  ~UnpackedSessions() {
    std::error_code ignored;
    if (!folder_.empty()) fs::remove_all(folder_, ignored);
  }
  /// The words of a command line, with the unpacked run in place of each such file.
  kerf::Expected<std::vector<std::string>> unpack(int argc, char** argv) {
    std::vector<std::string> out(argv, argv + argc);
    // These write a run, which refers to its case.
    const bool writes_run = argc > 1 && (out[1] == "cut" || out[1] == "live");
    for (std::size_t n = 2; n < out.size() && !writes_run; ++n) {
      if (!kerf::isSessionFile(out[n])) continue;
      if (folder_.empty()) {
        std::error_code error;
        std::string name = (fs::temp_directory_path(error) / "kerf-XXXXXX").string();
        if (error || !::mkdtemp(name.data()))
          return kerf::fail({.code = Error::Code::kWriteFailed,
                             .file = name,
                             .place = "folder for " + out[n],
                             .found = error ? error.message() : std::strerror(errno),
                             .expected = "a writable folder",
                             .hint = "set TMPDIR to one"});
        folder_ = name;
      }
      TerminalProgress progress;
      KERF_TRY(run, kerf::unpackSession(out[n], folder_, progress.callback()));
      out[n] = run.string();
    }
    return out;
  }

 private:
  fs::path folder_;
};

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
  UnpackedSessions sessions;
  const auto words = sessions.unpack(argc, argv);
  if (!words) {
    complain(words.error());
    if (std::find(argv, argv + argc, std::string_view("--json")) != argv + argc) answerInJson();
    return kerf::kFailed;
  }
  std::vector<const char*> line;
  for (const std::string& word : *words) line.push_back(word.c_str());
  return runProgram(app, argc, line.data(), exit_code);
}
