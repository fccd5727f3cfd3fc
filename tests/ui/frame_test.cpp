// The frame of the window: columns, strip and the free area, in every size of window and type.
#include <gtest/gtest.h>
#include <imgui_internal.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tests/ui/block_on_bench.h"
#include "tests/ui/imgui_nowhere.h"
#include "ui/app/base/language.h"
#include "ui/app/document/jobs.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/sessions.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/frame/notices.h"
#include "ui/window/panels/panels.h"

namespace kerf::frame_test {
namespace {

FrameSizes sizesOf(float width, float height, float scale) {
  return {.width = width,
          .height = height,
          .menu = 20 * scale,
          .strip = 40 * scale,
          .left = 250 * scale,
          .right = 250 * scale,
          .import = 400 * scale,
          .scale = scale};
}

TEST(FrameLayout, AreasNeverOverlapAndLeaveRoomForTheObject) {
  for (const float scale : {0.75f, 1.0f, 1.5f, 2.0f, 3.0f})
    for (const auto& [width, height] : {std::pair(800.0f, 600.0f), {1280, 800}, {1920, 1080}, {2560, 1440}})
      for (const Screen screen : {Screen::kFirst, Screen::kImport, Screen::kCut, Screen::kReplay}) {
        const FrameLayout at = layoutOf(screen, sizesOf(width, height, scale));
        EXPECT_GE(at.left.right, 0);
        EXPECT_LE(at.left.right, at.free.left);
        EXPECT_LE(at.free.right, at.right.left);
        EXPECT_LE(at.right.right, width);
        EXPECT_EQ(at.free.bottom, at.strip.top);
        if (screen == Screen::kReplay) {
          EXPECT_LE(at.right.bottom, at.strip.top);
        }
        if (screen != Screen::kImport && width / scale >= 800) {
          EXPECT_GE(at.free.width(), 240 * scale) << width << ' ' << scale;
        }
      }
}

TEST(FrameLayout, ANarrowWindowHasOneColumn) {
  EXPECT_FALSE(layoutOf(Screen::kCut, sizesOf(1280, 800, 1)).is_single);
  const FrameLayout narrow = layoutOf(Screen::kCut, sizesOf(1280, 800, 2));
  EXPECT_TRUE(narrow.is_single);
  EXPECT_EQ(narrow.left.width(), 0);
  EXPECT_GT(narrow.right.width(), 2 * 219);
}

class Frame : public test::OnABlock {
 protected:
  void TearDown() override {
    setShownLanguage(nullptr);
    OnABlock::TearDown();
  }
  TemporaryFolder config_;
  SettingsFile settings_{config_.path()};
};

bool overlap(const ImRect& a, const ImRect& b) {
  constexpr float kTouch = 1;
  return a.Min.x < b.Max.x - kTouch && b.Min.x < a.Max.x - kTouch && a.Min.y < b.Max.y - kTouch &&
         b.Min.y < a.Max.y - kTouch;
}

// Windows of the last frame that are not parts of others. Handles of columns lie over an edge.
std::vector<const ImGuiWindow*> windows() {
  std::vector<const ImGuiWindow*> out;
  for (const ImGuiWindow* const window : ImGui::GetCurrentContext()->Windows) {
    const std::string_view name = window->Name;
    if (!window->WasActive || window->Hidden || (window->Flags & ImGuiWindowFlags_ChildWindow)) continue;
    if (name == "Debug##Default" || name.ends_with("-edge")) continue;
    out.push_back(window);
  }
  return out;
}

// The largest content: pieces, a plan, tissues or a map, plots, details, a tour and notices.
TEST_F(Frame, NothingOverlapsAndNoTextIsCutOff) {
  context_.settings = &settings_;
  const Vec3d middle = bench_.document->scene().bounds().center();
  ASSERT_TRUE(runAppCommand(context_, "saw.plane", wordsOf({middle[0], middle[1], middle[2], 1, 0, 0})));
  ASSERT_TRUE(runAppCommand(context_, "plane.cut", std::vector<std::string>{"both"}));
  until([&] { return bench_.document->scene().pieceCount() == 2; });
  bench_.pieces->choose(bench_.document->scene().shown().front()->id);
  ASSERT_TRUE(runAppCommand(context_, "view.colours", std::vector<std::string>{"depth"}));
  context_.panels["plots"] = context_.panels["details"] = true;

  for (const char* const language : {"en", "de"})
    for (const auto& [size, scale] : {std::pair(ImVec2(1280, 800), 1.0f),
                                      {ImVec2(1600, 900), 1.0f},
                                      {ImVec2(2560, 1440), 1.0f},
                                      {ImVec2(1280, 800), 2.0f},
                                      {ImVec2(2560, 1440), 2.0f},
                                      {ImVec2(800, 600), 1.0f}}) {
      SCOPED_TRACE(std::string(language) + " " + std::to_string(size.x) + " at " + std::to_string(scale));
      ASSERT_TRUE(showLanguage(language, config_.path()));
      test::ImGuiNowhere imgui(size, scale);
      PanelState panels;
      bench_.notices->say("It is said while the frame is looked at.");
      bench_.notices->complain({.code = Error::Code::kBadValue, .found = "an error", .expected = "none"});
      context_.width = static_cast<int>(size.x);
      context_.height = static_cast<int>(size.y);
      for (int frame = 0; frame < 4; ++frame) imgui.draw([&] { drawPanels(context_, panels, {}); });
      EXPECT_EQ(imgui.cutLetters(), "");

      const auto all = windows();
      EXPECT_GE(all.size(), 5u);
      for (std::size_t a = 0; a < all.size(); ++a) {
        EXPECT_LE(all[a]->ContentSize.x, all[a]->WorkRect.GetWidth() + 1) << all[a]->Name;
        if (!all[a]->ScrollbarY) {
          EXPECT_LE(all[a]->ContentSize.y, all[a]->InnerRect.GetHeight()) << all[a]->Name;
        }
        for (std::size_t b = 0; b < a; ++b)
          EXPECT_FALSE(overlap(all[a]->Rect(), all[b]->Rect())) << all[a]->Name << " and " << all[b]->Name;
      }
    }
}

TEST_F(Frame, InformationFadesAndAnErrorStays) {
  test::ImGuiNowhere imgui;
  NoticesState state;
  bench_.notices->say("soon gone");
  bench_.notices->complain({.code = Error::Code::kBadValue, .found = "a fault", .expected = "none"});
  const auto draw = [&] { return imgui.draw([&] { drawNotices(context_, state); }); };
  draw();
  EXPECT_EQ(state.shown.size(), bench_.notices->list().size());
  const auto frames = static_cast<int>(60 * (kNoticeSeconds + 1));
  for (int n = 0; n < frames; ++n) draw();
  ASSERT_EQ(state.shown.size(), 1u);
  EXPECT_TRUE(bench_.notices->list()[state.shown.front().index].is_error);
}

}  // namespace
}  // namespace kerf::frame_test
