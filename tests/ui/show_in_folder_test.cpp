#include "ui/app/base/show_in_folder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

#include "tests/support/temporary_folder.h"

namespace kerf::show_in_folder_test {
namespace {

namespace fs = std::filesystem;

// A PATH with only the programs of a test.
class ShowInFolderTest : public testing::Test {
 protected:
  void SetUp() override {
    old_path_ = std::getenv("PATH");
    fs::create_directories(bin());
    ::setenv("PATH", bin().c_str(), 1);
  }
  void TearDown() override { ::setenv("PATH", old_path_.c_str(), 1); }

  fs::path bin() const { return folder_.path() / "bin"; }
  // Installs a program that writes its words to NAME.txt and then runs the commands `does`.
  void install(const std::string& name, const std::string& does) {
    const fs::path file = bin() / name;
    std::ofstream(file) << "#!/bin/sh\nfor word in \"$@\"; do printf '%s\\n' \"$word\"; done >'"
                        << (folder_.path() / (name + ".txt")).string() << "'\n"
                        << does << "\n";
    fs::permissions(file, fs::perms::owner_all);
  }
  std::string wordsOf(const std::string& name) const {
    std::ifstream in(folder_.path() / (name + ".txt"));
    return {std::istreambuf_iterator<char>(in), {}};
  }
  Expected<void> show(const std::vector<fs::path>& files) {
    ShowInFolder shown;
    if (const auto begun = shown.begin(files); !begun) return fail(begun.error());
    for (int n = 0; n < 4000; ++n) {
      if (auto ended = shown.poll()) {
        EXPECT_FALSE(shown.isUnderWay());
        EXPECT_FALSE(shown.poll()) << "told once";
        return *ended;
      }
      EXPECT_TRUE(shown.isUnderWay());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return fail({.code = Error::Code::kUnsupported, .found = "no end within 20 s"});
  }

  TemporaryFolder folder_;
  std::string old_path_;
};

TEST_F(ShowInFolderTest, TheFileManagerMarksTheFiles) {
  install("dbus-send", "exit 0");
  install("xdg-open", "exit 0");
  const auto shown = show({"/scans/tooth 36, cut.stl", "/scans/tooth-b.stl"});
  ASSERT_TRUE(shown) << shown.error().message();
  const std::string words = wordsOf("dbus-send");
  EXPECT_NE(words.find("--dest=org.freedesktop.FileManager1\n"), std::string::npos) << words;
  EXPECT_NE(words.find("org.freedesktop.FileManager1.ShowItems\n"), std::string::npos) << words;
  EXPECT_NE(words.find("array:string:file:///scans/tooth%2036%2C%20cut.stl,file:///scans/tooth-b.stl\n"),
            std::string::npos)
      << words;
  EXPECT_TRUE(wordsOf("xdg-open").empty()) << "it is shown once";
}

TEST_F(ShowInFolderTest, WhereNoFileManagerAnswersTheFolderIsOpened) {
  install("dbus-send", "exit 1");
  install("xdg-open", "exit 0");
  ASSERT_TRUE(show({"/scans/of today/a.stl"}));
  EXPECT_EQ(wordsOf("xdg-open"), "/scans/of today\n");

  fs::remove(bin() / "dbus-send");
  fs::remove(folder_.path() / "xdg-open.txt");
  ASSERT_TRUE(show({"/scans/b.stl"}));
  EXPECT_EQ(wordsOf("xdg-open"), "/scans\n");
}

TEST_F(ShowInFolderTest, WhereNothingCanShowItTheFolderIsSaid) {
  const auto none = show({"/scans/a.stl"});
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message().find("/scans"), std::string::npos) << none.error().message();
  install("dbus-send", "exit 1");
  EXPECT_FALSE(show({"/scans/a.stl"}));
  install("xdg-open", "exit 3");
  const auto broken = show({"/scans/a.stl"});
  ASSERT_FALSE(broken);
  EXPECT_NE(broken.error().message().find("exit code 3"), std::string::npos) << broken.error().message();
}

TEST_F(ShowInFolderTest, AFileManagerThatStaysHasShownIt) {
  install("xdg-open", "exec /bin/sleep 20");
  const auto began = std::chrono::steady_clock::now();
  EXPECT_TRUE(show({"/scans/a.stl"}));
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(15));
}

TEST(UriOf, OnlyUnreservedLettersAreWrittenAsTheyAre) {
  EXPECT_EQ(uriOf("/a b/ü#1.stl"), "file:///a%20b/%C3%BC%231.stl");
  EXPECT_EQ(uriOf("/a/../b-c_d.e~f"), "file:///b-c_d.e~f");
}

}  // namespace
}  // namespace kerf::show_in_folder_test
