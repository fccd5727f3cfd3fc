#include "ui/app/base/user_files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <cstdlib>

#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/settings/settings.h"

namespace kerf::user_files_test {
namespace {

namespace fs = std::filesystem;

TEST(UserFolders, AreThoseOfXdg) {
  ::setenv("XDG_CONFIG_HOME", "/a/config", 1);
  ::setenv("XDG_DATA_HOME", "not absolute", 1);
  EXPECT_EQ(userConfigFolder(), "/a/config/kerf");
  EXPECT_TRUE(userDataFolder().string().ends_with("/.local/share/kerf")) << "a relative one is ignored, as XDG says";
  ::unsetenv("XDG_CONFIG_HOME");
  ::unsetenv("XDG_DATA_HOME");
  EXPECT_TRUE(userConfigFolder().string().ends_with("/.config/kerf"));
}

TEST(RecentFiles, TheNewestIsFirstAndOnlyOnce) {
  const TemporaryFolder folder;
  const fs::path a = folder.write("a scan.stl", ""), b = folder.write("b.stl", "");
  RecentFiles files(folder.path() / "data");
  EXPECT_TRUE(files.list().empty());
  ASSERT_TRUE(files.add(a));
  ASSERT_TRUE(files.add(b));
  ASSERT_TRUE(files.add(a));

  const RecentFiles again(folder.path() / "data");
  ASSERT_EQ(again.list().size(), 2u);
  EXPECT_EQ(again.list()[0].path, a);
  EXPECT_EQ(again.list()[1].path, b);
  EXPECT_TRUE(again.list()[0].is_there);
  EXPECT_NE(again.pictureOf(a), again.pictureOf(b));
}

TEST(RecentFiles, WhatIsGoneIsShownAsSuchAndCanBeForgotten) {
  const TemporaryFolder folder;
  const fs::path a = folder.write("a.stl", ""), b = folder.write("b.stl", "");
  RecentFiles files(folder.path() / "data");
  ASSERT_TRUE(files.add(a) && files.add(b));
  const fs::path picture = files.pictureOf(a);
  std::ofstream(picture) << "picture";
  fs::remove(a);
  files.refresh();
  ASSERT_EQ(files.list().size(), 2u);
  EXPECT_FALSE(files.list()[1].is_there);

  ASSERT_TRUE(files.forget(1));
  EXPECT_EQ(files.list().size(), 1u);
  EXPECT_FALSE(fs::exists(picture));
  EXPECT_TRUE(fs::exists(b));
  ASSERT_TRUE(files.forget(0));
  EXPECT_TRUE(fs::exists(b)) << "forgetting a file never deletes it";
  EXPECT_TRUE(RecentFiles(folder.path() / "data").list().empty());
}

TEST(RecentFiles, OnlyTheLastDozenIsKept) {
  const TemporaryFolder folder;
  RecentFiles files(folder.path());
  for (int n = 0; n < 20; ++n) ASSERT_TRUE(files.add("/scan-" + std::to_string(n)));
  ASSERT_EQ(files.list().size(), RecentFiles::kMost);
  EXPECT_EQ(files.list()[0].path, "/scan-19");
}

// A window reads it before its first frame.
TEST(RecentFiles, AListThatIsNoSmallFileIsAnEmptyOneAndIsReplaced) {
  const TemporaryFolder folder;
  const fs::path list = folder.path() / "recent.txt";
  const std::function<void()> kinds[] = {
      [&] { ASSERT_EQ(::mkfifo(list.c_str(), 0600), 0); },
      [&] { fs::create_symlink("/dev/zero", list); },
      [&] { fs::resize_file(folder.write("recent.txt", ""), std::uintmax_t{16} << 30); },
      [&] { folder.write("recent.txt", "/" + std::string(50 << 20, 'x')); },
  };
  for (const auto& make : kinds) {
    make();
    const auto began = std::chrono::steady_clock::now();
    const RecentFiles files(folder.path());
    EXPECT_TRUE(files.list().empty());
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(1));
    fs::remove(list);
  }
}

TEST(SettingsFile, ComesBackAsItWasSaved) {
  const TemporaryFolder folder;
  const fs::path config = folder.path() / "not there yet";
  SettingsFile file(config);
  EXPECT_FALSE(file.error());
  EXPECT_EQ(file.values, Settings{});
  ASSERT_TRUE(file.save());
  EXPECT_FALSE(fs::exists(file.path())) << "nothing was set";

  file.values = {Theme::kDark, 1.25, true, "/scans of \"today\"", 2.5, 0.8, 20, true};
  file.values.space_mouse = {SpaceMouseLeads::kTool, 2.5, 0.1, true, {true, false, true, false, false, false}};
  file.values.perspective_deg = 45;
  file.values.is_perspective = true;
  ASSERT_TRUE(file.save());
  const SettingsFile again(config);
  EXPECT_FALSE(again.error());
  EXPECT_EQ(again.values, file.values);
}

TEST(SettingsFile, PerspectiveIsKeptAsItWasChosen) {
  const TemporaryFolder folder;
  WorkbenchOptions options;
  options.data_folder = folder.path() / "data";
  options.tools = {"round-014"};
  Workbench bench(options);
  Camera camera;
  SettingsFile file(folder.path());
  AppContext context{.bench = bench, .camera = camera, .settings = &file};
  const auto choose = [&](const std::string& word) {
    ASSERT_TRUE(runAppCommand(context, "view.perspective", std::vector<std::string>{word}));
  };
  choose("40");
  EXPECT_TRUE(camera.isPerspective());
  EXPECT_TRUE(SettingsFile(folder.path()).values.is_perspective);
  EXPECT_EQ(SettingsFile(folder.path()).values.perspective_deg, 40);
  choose("off");
  EXPECT_FALSE(SettingsFile(folder.path()).values.is_perspective);
  EXPECT_EQ(SettingsFile(folder.path()).values.perspective_deg, 40) << "for the next time";
}

TEST(SettingsFile, LinesItDoesNotKnowStay) {
  const TemporaryFolder folder;
  folder.write("settings.toml", "# mine\nfuture_key = 3\ntheme = \"light\"  # by day\n\n[window]\ntheme = 7\n");
  SettingsFile file(folder.path());
  ASSERT_FALSE(file.error()) << file.error()->message();
  file.values.theme = Theme::kDark;
  file.values.ui_scale = 2;
  ASSERT_TRUE(file.save());
  EXPECT_EQ(contentOf(file.path()),
            "# mine\nfuture_key = 3\ntheme = \"dark\"\n\nui_scale = 2.00\n[window]\ntheme = 7\n");
  EXPECT_EQ(SettingsFile(folder.path()).values, file.values);
}

TEST(SettingsFile, ABrokenOneIsReportedAndNeverWrittenOver) {
  for (const char* const text :
       {"theme = ", "theme = \"pink\"", "ui_scale = 99", "ui_scale = nan", "force_N = \"much\"",
        "hints_dismissed = \"yes\"", "sound_volume = 130", "space_mouse = \"both\"", "space_mouse_gain = 0",
        "space_mouse_inverted = \"sideways\""}) {
    const TemporaryFolder folder;
    folder.write("settings.toml", text);
    SettingsFile file(folder.path());
    ASSERT_TRUE(file.error()) << text;
    EXPECT_NE(file.error()->message().find("settings.toml"), std::string::npos) << file.error()->message();
    EXPECT_EQ(file.values, Settings{});
    file.values.theme = Theme::kDark;
    EXPECT_FALSE(file.save());
    EXPECT_EQ(contentOf(file.path()), text);

    ASSERT_TRUE(file.setAside());
    EXPECT_EQ(contentOf(folder.path() / "settings.toml.broken"), text);
    ASSERT_TRUE(file.save());
    EXPECT_EQ(SettingsFile(folder.path()).values.theme, Theme::kDark);
  }
}

TEST(SettingsFile, OneThatWasBrokenMeanwhileStaysToo) {
  const TemporaryFolder folder;
  SettingsFile file(folder.path());
  file.values.depth_mm = 1;
  folder.write("settings.toml", "theme = ");
  EXPECT_FALSE(file.save());
  EXPECT_EQ(contentOf(file.path()), "theme = ");
}

}  // namespace
}  // namespace kerf::user_files_test
