#include "ui/window/frame/notices.h"

#include <gtest/gtest.h>

#include "ui/window/gl/theme.h"
#include "ui/window/panels/import_panel.h"

namespace kerf::notices_test {
namespace {

constexpr float kMenu = 25;

// 800 x 600 is the smallest supported window, and the size of the click tests.
TEST(Notices, TheyStandBetweenThePanelsAndLeaveTheMiddleOfThePicture) {
  for (const float width : {800.0f, 1024.0f, 1280.0f, 2560.0f})
    for (const float scale : {0.75f, 1.0f, 1.25f}) {
      const float height = 0.75f * width;
      const NoticePlace at = noticePlace(width, height, kMenu, scale, SidePanels::kBoth);
      EXPECT_GT(at.middle - 0.5f * at.width, scale * kPanelWidth + 8) << width << ' ' << scale;
      EXPECT_LT(at.middle + 0.5f * at.width, width - scale * kPanelWidth - 8) << width << ' ' << scale;
      EXPECT_TRUE(at.hangs);
      EXPECT_LT(at.edge + at.most_height, 0.45f * height) << width << ' ' << scale;
      EXPECT_GT(at.width, 120) << width << ' ' << scale;

      const NoticePlace import = noticePlace(width, height, kMenu, scale, SidePanels::kImport);
      EXPECT_LT(import.middle + 0.5f * import.width, width - scale * kImportPanelWidth) << width << ' ' << scale;
      EXPECT_GT(import.middle - 0.5f * import.width, 0) << width << ' ' << scale;
      EXPECT_FALSE(import.hangs);
    }
}

TEST(Notices, WithoutPanelsTheyAreInTheMiddleAndTooNarrowWindowsGiveThemAll) {
  EXPECT_EQ(noticePlace(800, 600, kMenu, 1, SidePanels::kNone).middle, 400);
  EXPECT_EQ(noticePlace(2000, 1000, kMenu, 1, SidePanels::kNone).width, 720);
  const NoticePlace narrow = noticePlace(600, 600, kMenu, 1, SidePanels::kBoth);
  EXPECT_EQ(narrow.middle, 300);
  EXPECT_GT(narrow.width, 500);
}

}  // namespace
}  // namespace kerf::notices_test
