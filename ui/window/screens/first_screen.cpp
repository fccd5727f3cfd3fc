#include "ui/window/screens/first_screen.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "sim/run/files/run_manifest.h"
#include "ui/app/base/language.h"
#include "ui/app/document/file_history.h"
#include "ui/app/document/jobs.h"
#include "ui/app/import/session_list.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/sessions.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kShown = 6, kColumns = 3;
constexpr const char* kForget = "Delete the log?###forget-session";

// The end of a text, as far as it fits: the last folders tell more than the first.
std::string endThatFits(const std::string& text, float width) {
  if (ui::textSize(ui::asItIs(text)).x <= width) return text;
  for (std::size_t from = 1; from < text.size(); ++from) {
    if ((static_cast<unsigned char>(text[from]) & 0xC0) == 0x80) continue;  // within a character
    std::string end = "..." + text.substr(from);
    if (ui::textSize(ui::asItIs(end)).x <= width) return end;
  }
  return "...";
}

}  // namespace

void FirstScreen::refresh(AppContext& context) {
  pictures_.clear();
  context.bench.history->recent().refresh();
}

void FirstScreen::draw(AppContext& context, const std::function<void(const AppCommand&)>& ask_for_file) {
  Workbench& bench = context.bench;
  if (bench.jobs->running()) {
    was_drawn_ = false;
    return;
  }
  if (!std::exchange(was_drawn_, true)) refresh(context);

  const ImGuiIO& io = ImGui::GetIO();
  const float width = std::min(scaled(780), io.DisplaySize.x - scaled(24));
  const float most = io.DisplaySize.y - ImGui::GetFrameHeight() - scaled(24);
  ImGui::SetNextWindowPos({0.5f * io.DisplaySize.x, 0.5f * (io.DisplaySize.y + ImGui::GetFrameHeight())},
                          ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSizeConstraints({width, 0}, {width, most});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {scaled(24), scaled(20)});
  ui::begin("##first", nullptr,
            ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings);
  ImGui::PopStyleVar();

  ImGui::SetWindowFontScale(1.5f);
  ui::textColored(styleColours().accent, "Drop a scan here");
  ImGui::SetWindowFontScale(1);
  ImGui::PushTextWrapPos(0);
  ui::textColored(
      styleColours().quiet,
      "STL, PLY, OBJ, OFF or 3MF, a recipe, a case, or a session to continue. Kerf never changes the file.");
  ImGui::PopTextWrapPos();
  ImGui::Dummy({0, scaled(2)});
  if (strongButton("Open file...", "Ctrl+O", scaled(230))) ask_for_file(*findAppCommand("import.read"));
  ImGui::SameLine(0, scaled(24));
  float line = ImGui::GetCursorPosY();
  ImGui::SetCursorPosY(line + 0.5f * (scaled(34) - ImGui::GetTextLineHeight()));
  ui::textColored(styleColours().quiet, "or open a demo:");
  for (const char* const name : demoNames()) {
    ImGui::SameLine();
    if (ImGui::GetContentRegionAvail().x < scaled(120)) {  // on the next line
      ImGui::NewLine();
      line = ImGui::GetCursorPosY() + scaled(34) - ImGui::GetTextLineHeight();
    }
    ImGui::SetCursorPosY(line);
    if (plainButton(name, "", scaled(96))) runIfEnabled(context, "file.demo", std::vector<std::string>{name});
  }

  drawLost(context);
  drawRecent(context);
  ImGui::End();
}

void FirstScreen::drawLost(AppContext& context) {
  Workbench& bench = context.bench;
  if (bench.history->lostSessions().empty()) return;
  ImGui::Dummy({0, scaled(6)});
  ui::textColored(styleColours().warning, "A session ended unexpectedly. Recover your cuts from its log.");
  for (std::size_t n = 0; n < std::min<std::size_t>(bench.history->lostSessions().size(), 3); ++n) {
    const std::string name = bench.history->lostSessions()[n].folder.filename().string();
    ImGui::PushID(static_cast<int>(n));
    if (ui::button("Recover", {scaled(100), 0})) bench.history->recover(n);
    ImGui::SameLine();
    if (ui::button("Delete...", {scaled(100), 0})) asks_to_forget_ = n;
    ImGui::SameLine();
    ui::text(ui::asItIs(endThatFits(name, ImGui::GetContentRegionAvail().x)));
    ImGui::PopID();
    if (bench.jobs->running()) return;  // the list changes now
  }

  if (!asks_to_forget_) return;
  if (!ui::isPopupOpen(kForget)) ui::openPopup(kForget);
  ImGui::SetNextWindowSize({scaled(460), 0});
  if (!ui::beginPopupModal(kForget, nullptr, ImGuiWindowFlags_NoResize)) return;
  const std::size_t n = *asks_to_forget_;
  ImGui::PushTextWrapPos(0);
  ui::text(ui::asItIs(bench.history->lostSessions()[n].folder.string()));
  ui::text(
      phrase("Kerf deletes the folder with its log, {:.1f} MB. You cannot recover the cuts of that session afterwards.",
             1e-6 * static_cast<double>(bench.history->bytesOfLost(n))));
  ImGui::PopTextWrapPos();
  ImGui::Dummy({0, scaled(4)});
  bool is_over = strongButton("Keep log", "", scaled(200));
  ImGui::SameLine();
  if (plainButton("Delete log", "", -1)) {
    bench.history->forgetLost(n);
    is_over = true;
  }
  if (is_over) {
    asks_to_forget_.reset();
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

void FirstScreen::drawRecent(AppContext& context) {
  const std::size_t count = std::min(context.bench.history->recent().list().size(), kShown);
  if (count == 0) return;
  heading("Recent files and sessions");
  ImGui::SameLine(ImGui::GetContentRegionMax().x - scaled(130));
  if (ui::button("All sessions...", {scaled(130), 0})) runIfEnabled(context, "session.list");
  const float gap = scaled(12);
  const float width = (ImGui::GetContentRegionAvail().x - (kColumns - 1) * gap) / kColumns;
  for (std::size_t n = 0; n < count && n < context.bench.history->recent().list().size(); ++n) {
    if (n % kColumns) ImGui::SameLine(0, gap);
    drawCard(context, n, width);
  }
}

void FirstScreen::drawCard(AppContext& context, std::size_t n, float width) {
  Workbench& bench = context.bench;
  const RecentFile file = bench.history->recent().list()[n];
  const StyleColours& colours = styleColours();
  const float line = ImGui::GetTextLineHeightWithSpacing(), pad = scaled(8), rounding = scaled(6);
  const float height = width * kCardHeight / kCardWidth, all = height + 2 * line + pad;

  ImGui::PushID(static_cast<int>(n));
  ImGui::BeginGroup();
  const ImVec2 at = ImGui::GetCursorScreenPos(), end{at.x + width, at.y + all};
  const bool is_clicked = ImGui::InvisibleButton("card", {width, all});
  const bool is_hovered = ImGui::IsItemHovered();
  if (is_hovered) ui::setTooltip(ui::asItIs(file.path.string()));
  if (ImGui::BeginPopupContextItem("menu")) {
    if (ui::menuItem("Remove from list"))
      runIfEnabled(context, "recent.forget", std::vector<std::string>{std::to_string(n + 1)});
    ImGui::EndPopup();
  }

  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(at, end, ImGui::GetColorU32(is_hovered ? ImGuiCol_ButtonHovered : ImGuiCol_FrameBg), rounding);
  const ImU32 tint = file.is_there ? IM_COL32_WHITE : IM_COL32(255, 255, 255, 90);
  if (const ImTextureID picture = pictures_.of(bench.history->recent().pictureOf(file.path)))
    list.AddImageRounded(picture, at, {end.x, at.y + height}, {0, 0}, {1, 1}, tint, rounding,
                         ImDrawFlags_RoundCornersTop);
  const float inside = width - 2 * pad;
  const bool is_session = file.is_there && isRun(file.path);
  const std::string title = is_session ? sessionTitle(file.path) : file.path.filename().string();
  const std::string name = endThatFits(title, inside);
  ui::addText(list, {at.x + pad, at.y + height + 0.5f * pad}, ImGui::GetColorU32(ImGuiCol_Text), ui::asItIs(name));
  const ImVec4 quiet = file.is_there ? colours.quiet : colours.warning;
  const std::string folder = is_session      ? sessionDate(file.path)
                             : file.is_there ? endThatFits(file.path.parent_path().string(), inside)
                                             : shownText("file not found");
  ui::addText(list, {at.x + pad, at.y + height + 0.5f * pad + line}, ImGui::ColorConvertFloat4ToU32(quiet),
              ui::asItIs(folder));

  if (!file.is_there) {
    const ImVec2 next = ImGui::GetCursorScreenPos();
    ImGui::SetItemAllowOverlap();
    ImGui::SetCursorScreenPos({end.x - pad - scaled(66), end.y - line - 0.5f * pad});
    if (ui::button("Remove", {scaled(66), 0}))
      runIfEnabled(context, "recent.forget", std::vector<std::string>{std::to_string(n + 1)});
    ImGui::SetCursorScreenPos(next);
  } else if (is_session) {
    drawSessionButtons(context, n, is_clicked, {at.x + pad, at.y + height - scaled(42)}, inside);
  } else if (is_clicked) {
    runIfEnabled(context, "recent.open", std::vector<std::string>{std::to_string(n + 1)});
  }
  ImGui::EndGroup();
  ImGui::PopID();
}

// On the picture. A click beside them continues, too.
void FirstScreen::drawSessionButtons(AppContext& context, std::size_t n, bool is_clicked, const ImVec2& at,
                                     float width) {
  const ImVec2 next = ImGui::GetCursorScreenPos();
  const std::vector<std::string> words{std::to_string(n + 1)};
  ImGui::SetItemAllowOverlap();
  ImGui::SetCursorScreenPos(at);
  const bool continues = strongButton("Continue", "", width - scaled(96));
  ImGui::SameLine(0, scaled(6));
  ImGui::SetCursorScreenPos({at.x + width - scaled(90), at.y + scaled(34) - ImGui::GetFrameHeight()});
  const bool starts_over = ui::button("Start over", {scaled(90), 0});
  ImGui::SetCursorScreenPos(next);
  if (starts_over)
    runIfEnabled(context, "recent.start-over", words);
  else if (continues || is_clicked)
    runIfEnabled(context, "recent.open", words);
}

}  // namespace kerf
