#include "ui/app/base/system_dialog.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"

namespace kerf::system_dialog_test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// A PATH with only the programs of a test, and sh.
class SystemDialogTest : public testing::Test {
 protected:
  void SetUp() override {
    old_path_ = std::getenv("PATH");
    fs::create_directories(bin());
    ::setenv("PATH", bin().c_str(), 1);
  }
  void TearDown() override { ::setenv("PATH", old_path_.c_str(), 1); }

  fs::path bin() const { return folder_.path() / "bin"; }
  // Installs a program that writes its words to words.txt and then runs the commands `does`.
  void install(const std::string& name, const std::string& does) {
    const fs::path file = bin() / name;
    std::ofstream(file) << "#!/bin/sh\nfor word in \"$@\"; do printf '%s\\n' \"$word\"; done >'"
                        << (folder_.path() / "words.txt").string() << "'\n"
                        << does << "\n";
    fs::permissions(file, fs::perms::owner_all);
  }
  std::string words() const {
    std::ifstream in(folder_.path() / "words.txt");
    return {std::istreambuf_iterator<char>(in), {}};
  }
  Expected<FileAnswer> answer(const FileQuestion& question) {
    SystemDialog dialog;
    if (const auto asked = dialog.ask(question); !asked) return fail(asked.error());
    for (int n = 0; n < 2000; ++n) {
      if (auto got = dialog.poll()) {
        EXPECT_FALSE(dialog.isShown());
        EXPECT_FALSE(dialog.poll()) << "an answer is given once";
        return *got;
      }
      EXPECT_TRUE(dialog.isShown());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return fail({.code = Error::Code::kUnsupported, .found = "no answer within 10 s"});
  }

  TemporaryFolder folder_;
  std::string old_path_;
};

TEST_F(SystemDialogTest, WithoutAProgramThereIsNone) {
  EXPECT_FALSE(SystemDialog::program());
  std::ofstream(bin() / "zenity") << "not a program";
  EXPECT_FALSE(SystemDialog::program()) << "a file that can not be run";
  SystemDialog dialog;
  const auto asked = dialog.ask({});
  ASSERT_FALSE(asked);
  EXPECT_EQ(asked.error().code, Error::Code::kNotFound);
  EXPECT_FALSE(dialog.isShown());
  install("kdialog", "");
  EXPECT_EQ(SystemDialog::program(), "kdialog");
  install("zenity", "");
  EXPECT_EQ(SystemDialog::program(), "zenity");
}

TEST_F(SystemDialogTest, WhatIsChosenIsGivenBack) {
  install("zenity", "echo '/scans/tooth 36.stl'");
  const auto one = answer({.what = FileQuestion::What::kOpen, .title = "Open...", .folder = "/scans", .name = {}});
  ASSERT_TRUE(one) << one.error().message();
  EXPECT_EQ(*one, FileAnswer{"/scans/tooth 36.stl"});
  EXPECT_EQ(words().find("--file-selection\n--title=Open...\n--filename=/scans/\n"), 0u) << words();
  EXPECT_NE(words().find(" *.stl *.STL "), std::string::npos) << words();

  install("zenity", "printf '/a/36.stl\\n/a/35 b.ply\\n'");
  const auto two = answer({.what = FileQuestion::What::kOpenSeveral});
  ASSERT_TRUE(two) << two.error().message();
  EXPECT_EQ(*two, (FileAnswer{"/a/36.stl", "/a/35 b.ply"}));
  EXPECT_NE(words().find("--multiple"), std::string::npos) << words();

  install("zenity", "printf '/a/two\\nlines.stl\\n'");
  EXPECT_EQ(answer({}).value(), FileAnswer{"/a/two\nlines.stl"});

  install("zenity", "echo /a/out.stl");
  const auto saved = answer({.what = FileQuestion::What::kSave, .folder = "/a", .name = "tooth-cut.stl"});
  ASSERT_TRUE(saved) << saved.error().message();
  EXPECT_EQ(*saved, FileAnswer{"/a/out.stl"});
  EXPECT_NE(words().find("--filename=/a/tooth-cut.stl\n--save\n"), std::string::npos) << words();
}

TEST_F(SystemDialogTest, OfACaseItsFolderIsMeant) {
  const fs::path folder = folder_.path() / "molar.case";
  fs::create_directories(folder);
  std::ofstream(folder / "case.toml") << "format = \"kerf-case\"\n";
  std::ofstream(folder_.path() / "case.toml") << "mine = 1\n";
  install("zenity", "echo '" + (folder / "case.toml").string() + "'");
  EXPECT_EQ(answer({}).value(), FileAnswer{folder});
}

TEST_F(SystemDialogTest, ACancelledOneGivesNothingAndABrokenOneSaysSo) {
  install("zenity", "exit 1");
  const auto cancelled = answer({});
  ASSERT_TRUE(cancelled);
  EXPECT_TRUE(cancelled->empty());

  install("zenity", "echo /half/a/name; exit 5");
  const auto broken = answer({});
  ASSERT_FALSE(broken);
  EXPECT_NE(broken.error().found.find("exit code 5"), std::string::npos) << broken.error().message();
  EXPECT_NE(broken.error().hint.find("settings.dialog own"), std::string::npos);

  install("zenity", "kill -9 $$");
  const auto killed = answer({});
  ASSERT_FALSE(killed);
  EXPECT_NE(killed.error().found.find("signal 9"), std::string::npos) << killed.error().message();
}

// Waiting for the person would take a minute.
TEST_F(SystemDialogTest, NobodyWaitsForAPersonWhoThinks) {
  install("zenity", "echo $$ >'" + (folder_.path() / "pid").string() + "'\nexec /bin/sleep 60");
  Clock::duration longest{};
  pid_t child = 0;
  {
    SystemDialog dialog;
    ASSERT_TRUE(dialog.ask({}));
    for (int n = 0; n < 2000 && child == 0; ++n) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      std::ifstream(folder_.path() / "pid") >> child;
    }
    for (int n = 0; n < 50; ++n) {
      const auto before = Clock::now();
      EXPECT_FALSE(dialog.poll());
      longest = std::max(longest, Clock::now() - before);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ASSERT_GT(child, 0) << "it began within 20 s";
    EXPECT_EQ(::kill(child, 0), 0) << "it is open";
  }
  EXPECT_NE(::kill(child, 0), 0) << "it goes with the window";
  EXPECT_LT(longest, std::chrono::seconds(20)) << "a busy machine counted in";
}

TEST_F(SystemDialogTest, KdialogIsAskedInItsOwnWords) {
  const FileQuestion several{.what = FileQuestion::What::kOpenSeveral, .title = "Open...", .folder = "/s", .name = {}};
  EXPECT_EQ(commandOf("kdialog", several), (std::vector<std::string>{"kdialog", "--title", "Open...", "--multiple",
                                                                     "--separate-output", "--getopenfilename", "/s/"}));
  const FileQuestion folder{.what = FileQuestion::What::kOpenFolder, .title = "Watch", .folder = "/s", .name = {}};
  EXPECT_EQ(commandOf("kdialog", folder),
            (std::vector<std::string>{"kdialog", "--title", "Watch", "--getexistingdirectory", "/s/"}));
}

// A menu has no room for words: a command that needs a path gets a chosen path.
TEST(FileCommands, EachThatTakesAPathAsksForIt) {
  std::size_t asking = 0;
  for (const AppCommand& command : appCommands()) {
    EXPECT_EQ(asksForFile(command), command.parameters.find("PATH") != command.parameters.npos) << command.id;
    asking += asksForFile(command) && !command.menu.empty() ? 1 : 0;
  }
  EXPECT_GE(asking, 5u);
  EXPECT_TRUE(asksForFile(*findAppCommand("export.to"))) << "of the export panel";
  EXPECT_TRUE(asksForFile(*findAppCommand("file.export-beside"))) << "PATH, and then the neighbour";
}

}  // namespace
}  // namespace kerf::system_dialog_test
