#include "ui/app/script/command_palette.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/temporary_folder.h"
#include "ui/app/workbench/strokes.h"

namespace kerf::command_palette_test {
namespace {

class CommandPaletteTest : public testing::Test {
 protected:
  CommandPaletteTest() { palette_.show(); }
  WorkbenchOptions options() const {
    WorkbenchOptions out;
    out.data_folder = folder_.path() / "data";
    out.tools = {"round-014"};
    return out;
  }
  TemporaryFolder folder_;
  Workbench bench_{options()};
  Camera camera_;
  AppContext context_{.bench = bench_, .camera = camera_};
  CommandPalette palette_;
};

TEST(FindAppCommands, AllWordsHaveToOccurAndTheLabelGoesFirst) {
  EXPECT_EQ(findAppCommands("").size(), appCommands().size());
  ASSERT_FALSE(findAppCommands("UNDO").empty());
  EXPECT_EQ(findAppCommands("UNDO")[0]->id, "edit.undo");
  EXPECT_EQ(menuOf(*findAppCommands("view")[0]), "View") << "the menu itself goes before \"edge-on in view\"";
  EXPECT_EQ(findAppCommands("tool next")[0]->id, "tool.next");
  EXPECT_EQ(findAppCommands("occlusal down")[0]->id, "view.top") << "by its description";
  EXPECT_TRUE(findAppCommands("undo elephant").empty());
}

TEST_F(CommandPaletteTest, EnterRunsWhatIsSelected) {
  palette_.type("oblique");
  ASSERT_FALSE(palette_.found().empty());
  EXPECT_EQ(palette_.accept(context_), nullptr);
  EXPECT_FALSE(palette_.isShown());
  EXPECT_GT(std::abs(camera_.azimuth), 0.1);
}

TEST_F(CommandPaletteTest, ParametersAreAskedForInTheSameLine) {
  palette_.type("push pressed");
  ASSERT_EQ(palette_.found()[0]->id, "cut.force");
  palette_.accept(context_);
  ASSERT_TRUE(palette_.asked());
  EXPECT_TRUE(palette_.text().empty());

  palette_.type("90");
  palette_.accept(context_);
  EXPECT_TRUE(palette_.isShown()) << "it is refused";
  EXPECT_NE(palette_.error().find("0.1 to 8"), std::string::npos) << palette_.error();
  palette_.erase();
  palette_.erase();
  palette_.type("2.5");
  palette_.accept(context_);
  EXPECT_FALSE(palette_.isShown());
  EXPECT_EQ(bench_.strokes->force, 2.5);
}

TEST_F(CommandPaletteTest, AnIdMayHaveItsParametersBehindIt) {
  palette_.type("cut.depth 1.5");
  palette_.accept(context_);
  EXPECT_FALSE(palette_.isShown()) << palette_.error();
  EXPECT_EQ(bench_.strokes->depth_mm, 1.5);
}

TEST_F(CommandPaletteTest, AlsoThoseThatMayBeLeftOut) {
  palette_.type("cut.deeper 0.25");
  const double before = bench_.strokes->depth_mm;
  palette_.accept(context_);
  EXPECT_FALSE(palette_.isShown()) << palette_.error();
  EXPECT_NEAR(bench_.strokes->depth_mm, before + 0.25, 1e-12);

  palette_.show();
  palette_.type("cut.deeper");
  palette_.accept(context_);
  EXPECT_FALSE(palette_.isShown()) << palette_.error();
  EXPECT_NEAR(bench_.strokes->depth_mm, before + 0.35, 1e-12) << "left out, it is 0.1 mm";
}

TEST_F(CommandPaletteTest, WhatCannotBeDoneNowIsSaidAndNotDone) {
  palette_.type("edit.undo");
  palette_.accept(context_);
  EXPECT_TRUE(palette_.isShown());
  EXPECT_NE(palette_.error().find("not available now"), std::string::npos);
  palette_.type(" elephant");
  palette_.accept(context_);
  EXPECT_NE(palette_.error().find("no command"), std::string::npos);
}

TEST_F(CommandPaletteTest, ACommandThatNeedsAFileIsHandedBack) {
  palette_.type("import.read");
  const AppCommand* const command = palette_.accept(context_);
  ASSERT_TRUE(command);
  EXPECT_EQ(command->id, "import.read");
  EXPECT_FALSE(palette_.isShown());
}

TEST_F(CommandPaletteTest, KeysMoveEraseAndGoBack) {
  palette_.move(-1);
  EXPECT_EQ(palette_.selected(), 0u);
  palette_.move(2);
  EXPECT_EQ(palette_.selected(), 2u);
  palette_.move(100000);
  EXPECT_EQ(palette_.selected(), palette_.found().size() - 1);

  palette_.type("zahn\xC3\xA4");
  EXPECT_EQ(palette_.selected(), 0u);
  palette_.erase();
  EXPECT_EQ(palette_.text(), "zahn") << "a character, not a byte";
  for (int n = 0; n < 9; ++n) palette_.erase();
  EXPECT_TRUE(palette_.isShown());
  palette_.type("cut.force");
  palette_.accept(context_);
  ASSERT_TRUE(palette_.asked());
  palette_.back();
  EXPECT_FALSE(palette_.asked());
  EXPECT_TRUE(palette_.isShown());
  palette_.back();
  EXPECT_FALSE(palette_.isShown());
}

}  // namespace
}  // namespace kerf::command_palette_test
