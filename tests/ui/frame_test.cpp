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
#include "ui/app/view/tissue_display.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/sessions.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/frame/notices.h"
#include "ui/window/gl/double_click.h"
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
  void lookEverywhere();
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

// Numbers with a decimal point among drawn texts.
std::string pointsIn(const std::string& words) {
  const auto isDigit = [&](std::size_t n) { return n < words.size() && words[n] >= '0' && words[n] <= '9'; };
  std::string out;
  for (std::size_t at = words.find('.'); at != words.npos; at = words.find('.', at + 1))
    if (at > 0 && isDigit(at - 1) && isDigit(at + 1)) out += words.substr(at > 20 ? at - 20 : 0, 40) + "\n";
  return out;
}

// In every size and language: no window overlaps another one, no text is cut off, tall content scrolls.
void Frame::lookEverywhere() {
  context_.settings = &settings_;
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
      bench_.notices->say("A notice stands over the picture.");
      bench_.notices->complain({.code = Error::Code::kBadValue, .found = "an error", .expected = "none"});
      context_.width = static_cast<int>(size.x);
      context_.height = static_cast<int>(size.y);
      std::string words;
      for (int frame = 0; frame < 4; ++frame) words = imgui.draw([&] { drawPanels(context_, panels, {}); });
      EXPECT_EQ(imgui.cutLetters(), "");
      if (shownDecimalSign() == ',') {
        EXPECT_EQ(pointsIn(words), "");
      } else if (scale == 1) {
        EXPECT_NE(pointsIn(words), "") << "there are numbers to look at";
      }

      const auto all = windows();
      EXPECT_GE(all.size(), 3u);
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

// Pieces, a plan, a map, plots, details, the tour and notices.
TEST_F(Frame, NothingOverlapsAndNoTextIsCutOff) {
  const Vec3d middle = bench_.document->scene().bounds().center();
  ASSERT_TRUE(runAppCommand(context_, "saw.plane", wordsOf({middle[0], middle[1], middle[2], 1, 0, 0})));
  ASSERT_TRUE(runAppCommand(context_, "plane.cut", std::vector<std::string>{"both"}));
  until([&] { return bench_.document->scene().pieceCount() == 2; });
  bench_.pieces->choose(bench_.document->scene().shown().front()->id);
  ASSERT_TRUE(runAppCommand(context_, "view.colours", std::vector<std::string>{"depth"}));
  context_.panels["plots"] = context_.panels["details"] = true;
  lookEverywhere();
}

TEST_F(Frame, NorWhileAHoleIsPlanned) {
  ASSERT_TRUE(runAppCommand(context_, "drill.plan"));
  ASSERT_TRUE(runAppCommand(context_, "drill.click", wordsOf({200, 150})));
  ASSERT_TRUE(runAppCommand(context_, "tool.hold-axis"));
  ASSERT_TRUE(runAppCommand(context_, "view.as-loaded"));
  lookEverywhere();
}

TEST_F(Frame, NorInTheImport) {
  Mesh open = block();
  open.triangles.resize(open.triangles.size() - 2);
  const std::filesystem::path file = folder_.path() / "open.ply";
  ASSERT_TRUE(writeMesh(file, open));
  bench_.imports->begin(file);
  until([&] { return bench_.imports->set() && !bench_.jobs->running(); });
  lookEverywhere();
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

// Esc: a list within a menu first, then the menu.
TEST(Popups, TheTopmostClosesFirst) {
  test::ImGuiNowhere imgui;
  bool is_outer = false, is_inner = false, opens = true, closes = false, has_closed = false;
  const auto draw = [&] {
    imgui.draw([&] {
      if (closes) has_closed = ui::closeTopmostPopup();
      ImGui::SetNextWindowPos({0, 0});
      ui::begin("w");
      if (opens) ui::openPopup("outer");
      is_outer = ui::beginPopup("outer");
      if (is_outer) {
        if (opens) ui::openPopup("inner");
        is_inner = ui::beginPopup("inner");
        if (is_inner) ImGui::EndPopup();
        ImGui::EndPopup();
      } else {
        is_inner = false;
      }
      opens = false;
      ImGui::End();
    });
  };
  for (int n = 0; n < 3; ++n) draw();
  ASSERT_TRUE(is_outer && is_inner);
  closes = true;
  draw();
  EXPECT_TRUE(has_closed && is_outer);
  EXPECT_FALSE(is_inner);
  draw();
  EXPECT_TRUE(has_closed);
  EXPECT_FALSE(is_outer);
  draw();
  EXPECT_FALSE(has_closed);
}

TEST(DoubleClick, IsJudgedByTheTimesOfItsEvents) {
  DoubleClick clicks;
  clicks.press(1.0, 10, 10);
  EXPECT_FALSE(clicks.take());
  clicks.press(1.3, 12, 11);
  EXPECT_TRUE(clicks.take());
  EXPECT_FALSE(clicks.take());
  clicks.press(1.4, 12, 11);
  EXPECT_FALSE(clicks.take()) << "the third begins anew";
  clicks.press(2.0, 12, 11);
  EXPECT_FALSE(clicks.take()) << "too late";
  clicks.press(2.1, 30, 11);
  EXPECT_FALSE(clicks.take()) << "too far";
}

TEST_F(Frame, FitUsesTheFreeAreaOfThePicture) {
  context_.width = 1280;
  context_.height = 800;
  context_.margins = {.left = 250, .top = 22, .right = 400, .bottom = 38};
  for (const char* const view : {"front", "top", "iso"}) {
    ASSERT_TRUE(runAppCommand(context_, "view.from", std::vector<std::string>{view}));
    const Box3 box = bench_.document->scene().bounds();
    for (int n = 0; n < 8; ++n) {
      const auto at = pixelOf(context_.camera, box.corner(n), 1280, 800);
      EXPECT_GT(at[0], 250);
      EXPECT_LT(at[0], 1280 - 400);
      EXPECT_GT(at[1], 22);
      EXPECT_LT(at[1], 800 - 38);
    }
    const auto middle = pixelOf(context_.camera, box.center(), 1280, 800);
    EXPECT_NEAR(middle[0], 0.5 * (250 + 880), 1);
    EXPECT_NEAR(middle[1], 0.5 * (22 + 762), 1);
  }
}

TEST_F(Frame, TheLeftButtonTurnsTheViewUntilTheToolIsTaken) {
  EXPECT_TRUE(leftButtonCuts(context_));
  context_.settings = &settings_;
  EXPECT_FALSE(findAppCommand("tool.take")->is_enabled(context_));
  ASSERT_TRUE(runAppCommand(context_, "settings.left-button", std::vector<std::string>{"turn"}));
  EXPECT_FALSE(leftButtonCuts(context_));
  ASSERT_TRUE(runAppCommand(context_, "tool.take"));
  EXPECT_TRUE(leftButtonCuts(context_));
  ASSERT_TRUE(runAppCommand(context_, "tool.take"));
  EXPECT_FALSE(leftButtonCuts(context_));
  ASSERT_TRUE(runAppCommand(context_, "tool.select", std::vector<std::string>{"round-014"}));
  EXPECT_TRUE(leftButtonCuts(context_)) << "a tool of the rack is in hand";
  EXPECT_TRUE(SettingsFile(config_.path()).values.left_turns);
}

TEST(MapScale, StepsEveryHalfMillimetreWithBands) {
  const MapScale smooth{2, false}, bands{2, true};
  EXPECT_DOUBLE_EQ(smooth.shareOf(0.7), 0.35);
  EXPECT_DOUBLE_EQ(bands.shareOf(0.7), 0.25);
  EXPECT_DOUBLE_EQ(bands.shareOf(0.49), 0);
  EXPECT_DOUBLE_EQ(bands.shareOf(7), 1);
  EXPECT_EQ(bands.shareOf(-1), 0);
}

}  // namespace
}  // namespace kerf::frame_test
