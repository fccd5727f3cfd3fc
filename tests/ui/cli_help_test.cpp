// kerf help, and the manual that the build writes from the same texts.
#include <sstream>

#include "tests/ui/cli_runner.h"

namespace kerf::cli_help_test {
namespace {

using Words = std::vector<std::string>;

class CliHelp : public Cli {
 protected:
  // Commands in a help text: the names below "Subcommands:" and "Commands ...:".
  static Words commandsIn(const std::string& help) {
    Words out;
    bool is_listed = false;
    std::istringstream lines(help);
    for (std::string line; std::getline(lines, line);) {
      if (line.ends_with(":")) is_listed = line.find("ommands") != line.npos;
      if (line.empty()) is_listed = false;
      if (is_listed && line.starts_with("  ") && line[2] != ' ') out.push_back(line.substr(2, line.find(' ', 2) - 2));
    }
    return out;
  }
  // `kerf help COMMAND...` is `kerf COMMAND... --help`, also for the commands within.
  void helpIsThatOf(const Words& command, std::size_t& count) {
    Words help = command, own = command;
    help.insert(help.begin(), "help");
    own.push_back("--help");
    const Outcome asked = runKerf(help), expected = runKerf(own);
    EXPECT_EQ(asked.exit_code, 0) << asked.err;
    EXPECT_EQ(asked.out, expected.out);
    ++count;

    for (const std::string& name : commandsIn(asked.out)) {
      Words inner = command;
      inner.push_back(name);
      helpIsThatOf(inner, count);
    }
  }
};

TEST_F(CliHelp, OfACommandIsTheTextOfItsOption) {
  std::size_t count = 0;
  helpIsThatOf({}, count);
  EXPECT_GE(count, 20u);
}

TEST_F(CliHelp, ListsItsTopicsAndTheExitCodes) {
  const std::string help = runKerf({"help"}).out;
  for (const char* text : {"\n  help ", "\n  window ", "\n  script ", "Exit codes:\n  0  done\n", "--json"})
    EXPECT_NE(help.find(text), help.npos) << text << "\n" << help;
}

TEST_F(CliHelp, ExplainsTheWindowItsScriptsAndASingleCommand) {
  const Outcome window = runKerf({"help", "window"}), script = runKerf({"help", "script"});
  for (const char* text : {"\nMenu File\n", "\n  file.open PATH ", "Ctrl+O\n", "\n  view.tissue NAME show|hide|ghost"})
    EXPECT_NE(window.out.find(text), window.out.npos) << text;
  for (const char* text : {"\n  wait SECONDS\n", "\n  print\n", "\n  expect VALUE LOW HIGH\n"})
    EXPECT_NE(script.out.find(text), script.out.npos) << text;

  const Outcome roll = runKerf({"help", "view.roll"});
  EXPECT_EQ(roll.exit_code, 0) << roll.err;
  EXPECT_TRUE(roll.out.starts_with("  view.roll [DEG]")) << roll.out;
  EXPECT_NE(window.out.find(roll.out), window.out.npos);
}

TEST_F(CliHelp, SuggestsTopicsForAnUnknownOne) {
  refuses({"help", "tol"}, {"no help topic \"tol\"", "did you mean tool?", "kerf help"}, 2);
  refuses({"help", "windw"}, {"did you mean window"}, 2);
  refuses({"help", "view.rol"}, {"view.roll"}, 2);
  refuses({"help", "tool", "chek"}, {"kerf tool has no command \"chek\"", "did you mean check?", "kerf help tool"}, 2);
  refuses({"help", "bake", "fast"}, {"kerf bake has no command \"fast\""}, 2);
  refuses({"help", "window", "file"}, {"no help topic \"window file\""}, 2);
}

TEST_F(CliHelp, NeedsNoDataOfKerf) {
  RunOptions options;
  options.environment["KERF_ASSETS"] = at("missing");
  EXPECT_EQ(runKerf({"help"}, options).exit_code, 0);
  EXPECT_EQ(runKerf({"help", "window"}, options).exit_code, 0);
}

TEST_F(CliHelp, IsInTheManualAndInTheCompletion) {
  ASSERT_EQ(runKerf({"--write-manual", at("share")}).exit_code, 0);
  const std::string window = contentOf(at("share/man/man7/kerf-window.7"));
  EXPECT_NE(window.find(".SH MENU FILE\n"), window.npos);
  EXPECT_NE(window.find("\\fBfile.open PATH\\fR (Ctrl+O)\n"), window.npos) << window;
  EXPECT_NE(contentOf(at("share/man/man7/kerf-script.7")).find("\\fBexpect VALUE LOW HIGH\\fR"), std::string::npos);
  EXPECT_NE(contentOf(at("share/man/man1/kerf.1")).find("Topics of kerf help:"), std::string::npos);
  EXPECT_NE(contentOf(at("share/man/man1/kerf-help.1")).find("KERF\\-HELP"), std::string::npos);

  const std::string bash = contentOf(at("share/bash-completion/completions/kerf"));
  const std::size_t words = bash.find("\"help\"*) words=\"bake cut ");
  ASSERT_NE(words, bash.npos) << bash;
  EXPECT_LT(bash.find(" window script ", words), bash.find('\n', words));
}

}  // namespace
}  // namespace kerf::cli_help_test
