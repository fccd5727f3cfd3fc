// The window in another language: text of its panels, drawn by Dear ImGui without a display.
#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "tests/ui/block_on_bench.h"
#include "tests/ui/imgui_nowhere.h"
#include "ui/app/base/language.h"
#include "ui/app/document/jobs.h"
#include "ui/app/settings/settings.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"
#include "ui/window/panels/panels.h"

namespace kerf::language_window_test {
namespace {

namespace fs = std::filesystem;
using test::ImGuiNowhere;

// Pairs of texts.
std::shared_ptr<const Language> languageOf(const std::map<std::string, std::string>& texts) {
  std::string rows = "msgid \"\"\nmsgstr \"text/plain; charset=UTF-8\\nX-Language-Name: Test\\n\"\n";
  for (const auto& [english, translated] : texts) rows += "msgid \"" + english + "\"\nmsgstr \"" + translated + "\"\n";
  const TemporaryFolder folder;
  auto out = Language::read(folder.write("test.po", rows));
  EXPECT_TRUE(out) << out.error().message();
  return std::make_shared<const Language>(std::move(*out));
}

void holdCtrl(bool is_down) {
#if IMGUI_VERSION_NUM >= 18900
  ImGui::GetIO().AddKeyEvent(ImGuiMod_Ctrl, is_down);
#else
  ImGui::GetIO().KeyCtrl = is_down;
#endif
}

class LanguageWindow : public test::OnABlock {
 protected:
  void TearDown() override {
    setShownLanguage(nullptr);
    OnABlock::TearDown();
  }
  // Menus cannot be open without a mouse; all panels are.
  std::string drawAll() {
    context_.settings = &settings_;
    context_.panels["settings"] = context_.panels["device"] = context_.panels["plots"] = context_.panels["details"] =
        true;
    context_.width = 1280;
    context_.height = 800;
    std::string out;
    for (int frame = 0; frame < 3; ++frame)  // a window is laid out in its second one
      out = imgui_.draw([&] { drawPanels(context_, panels_, {}); });
    return out;
  }
  ImGuiNowhere imgui_;
  TemporaryFolder config_;
  SettingsFile settings_{config_.path()};
  PanelState panels_;
};

std::string withoutBlanks(std::string text) {
  std::erase(text, ' ');
  return text;
}

// The text outside all «». A text clipped at a panel's edge ends at the next «.
std::string unmarked(const std::string& words) {
  std::string out;
  bool is_inside = false;
  for (std::size_t at = 0; at < words.size(); ++at) {
    const bool begins = words.compare(at, 2, "«") == 0, ends = words.compare(at, 2, "»") == 0;
    if (begins || ends) {
      is_inside = begins;
      ++at;
    } else if (!is_inside) {
      out += words[at];
    }
  }
  return out;
}

TEST_F(LanguageWindow, ASliderShowsAndTakesADecimalComma) {
  ASSERT_TRUE(showLanguage("de", config_.path()));
  float value = 1.25f;
  const auto draw = [&] {
    return imgui_.draw([&] {
      ImGui::SetNextWindowPos({0, 0});
      ImGui::SetNextWindowSize({300, 100});
      ui::begin("w");
      ui::sliderFloat("##mm", &value, 0, 5, "%.2f mm");
      ImGui::End();
    });
  };
  ImGuiIO& io = ImGui::GetIO();
  draw();
  EXPECT_NE(draw().find("1,25mm"), std::string::npos);
  io.MousePos = {100, 40};
  holdCtrl(true);
  draw();
  io.MouseDown[0] = true;  // types instead of dragging
  draw();
  io.MouseDown[0] = false;
  holdCtrl(false);
  draw();
  for (const char letter : {'3', ',', '5'}) {
    io.AddInputCharacter(static_cast<unsigned char>(letter));
    draw();
  }
  EXPECT_FLOAT_EQ(value, 3.5f);
}

// As a row of the menu does.
TEST_F(LanguageWindow, APanelThatEndsTheSessionLeavesTheOthersNothingToRead) {
  static const Panel kEnds = {"end", "", Screen::kAny, PanelPlace::kOwn,
                              [](PanelFrame& frame) { frame.context.bench.sessions->close(); }};
  std::vector<Panel> rows{kEnds};
  rows.insert(rows.end(), panelRows().begin(), panelRows().end());
  ASSERT_TRUE(bench_.document->isOpen());
  drawAll();
  imgui_.draw([&] { drawPanels(context_, panels_, {}, rows); });
  EXPECT_FALSE(bench_.document->isOpen());
  while (bench_.jobs->running()) bench_.update();
}

TEST_F(LanguageWindow, EveryTextOfThePanelsGoesThroughTheOneFunction) {
  setShownLanguage(std::make_shared<const Language>(Language::marking()));
  bench_.notices->say("something was said");
  const std::string words = drawAll();
  for (const char* const text : {"«Cut»", "«Tool»", "«Force»", "«Devices»", "«Settings»", "«Next»", "«Language»",
                                 "«Last 20 s»", "«push 1.0 N»", "«something was said»"})
    EXPECT_NE(words.find(withoutBlanks(text)), words.npos) << text << '\n' << words;

  std::istringstream lines(unmarked(words));
  for (std::string line; std::getline(lines, line);)
    EXPECT_TRUE(std::none_of(line.begin(), line.end(), [](unsigned char c) { return std::isalpha(c); })) << line;
}

TEST_F(LanguageWindow, InEnglishNothingIsMarked) {
  const std::string words = drawAll();
  EXPECT_EQ(words.find("«"), words.npos);
  EXPECT_NE(words.find("Settings"), words.npos) << words;
  EXPECT_EQ(words.find('#'), words.npos) << "an id is never shown";
}

// All text of a session's panels, except names and earlier notices. New text must be added to the file.
TEST_F(LanguageWindow, InGermanNearlyAllOfItIsGerman) {
  std::set<std::string> english;
  std::istringstream before(drawAll());
  for (std::string line; std::getline(before, line);) english.insert(line);
  ASSERT_TRUE(showLanguage("de", config_.path()));
  const std::string words = drawAll();
  for (const char* const text : {"Werkzeug", "Kraft", "Einstellungen", "Weiter"})
    EXPECT_NE(words.find(text), words.npos) << text << '\n' << words;
  std::set<std::string> left;
  std::istringstream after(words);
  for (std::string line; std::getline(after, line);)
    if (english.contains(line) &&
        std::count_if(line.begin(), line.end(), [](unsigned char c) { return std::isalpha(c); }) > 3)
      left.insert(line);
  constexpr std::size_t kMost = 6;
  EXPECT_LE(left.size(), kMost) << testing::PrintToString(left);
}

// Pressed in one language, released in another: the same button.
TEST(Widgets, AButtonStaysTheSameWhenTheLanguageChangesUnderTheMouse) {
  ImGuiNowhere imgui;
  ImGuiIO& io = ImGui::GetIO();
  ImVec2 middle{0, 0};
  bool is_pressed = false, is_ticked = false;
  const auto draw = [&] {
    imgui.draw([&] {
      ImGui::SetNextWindowPos({0, 0});
      ui::begin("Questions");
      is_pressed |= ui::button("Cancel");
      const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
      middle = {0.5f * (low.x + high.x), 0.5f * (low.y + high.y)};
      ui::checkbox("Cancel##all", &is_ticked);
      ImGui::End();
    });
  };
  const auto german = languageOf({{"Cancel", "Abbrechen"}, {"Questions", "Fragen"}});
  for (int n = 0; n < 3; ++n) draw();
  io.MousePos = middle;
  draw();
  io.MouseDown[0] = true;
  draw();
  EXPECT_FALSE(is_pressed);
  setShownLanguage(german);
  draw();
  io.MouseDown[0] = false;
  draw();
  setShownLanguage(nullptr);
  EXPECT_TRUE(is_pressed);
  EXPECT_FALSE(is_ticked) << "another id";
}

TEST(Widgets, AButtonIsAsWideAsItsWords) {
  ImGuiNowhere imgui;
  float english = 0, german = 0, words = 0;
  const auto widthNow = [&] {
    float out = 0;
    imgui.draw([&] {
      ui::begin("w");
      (void)ui::button("OK", {60, 0});
      out = ImGui::GetItemRectSize().x;
      words = ui::textSize("OK").x;
      ImGui::End();
    });
    return out;
  };
  english = widthNow();
  setShownLanguage(languageOf({{"OK", "Ich habe es gelesen"}}));
  german = widthNow();
  setShownLanguage(nullptr);
  EXPECT_EQ(english, 60);
  EXPECT_GT(german, words);
  EXPECT_GT(words, 60);
}

TEST(Widgets, AValueStandsBehindALongName) {
  ImGuiNowhere imgui;
  float begin = 0, end = 0;
  const auto draw = [&](const char* name) {
    imgui.draw([&] {
      ImGui::SetNextWindowSize({600, 200});
      ui::begin("w");
      ui::text(name);
      end = ImGui::GetItemRectMax().x;
      ui::sameLineAt(118);
      ui::text("3");
      begin = ImGui::GetItemRectMin().x - ImGui::GetWindowPos().x;
      end -= ImGui::GetWindowPos().x;
      ImGui::End();
    });
  };
  draw("Depth");
  EXPECT_EQ(begin, 118);
  draw("Tiefe der Spitze unter der Oberfläche");
  EXPECT_GT(begin, end);
}

}  // namespace
}  // namespace kerf::language_window_test
