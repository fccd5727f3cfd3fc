#include "ui/window/frame/notices.h"

#include <imgui.h>

#include <algorithm>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/imports.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr float kGap = 16, kWidest = 720, kNarrowest = 128;
constexpr float kBelowMenu = 48;       // below the hint for picking
constexpr float kMostOfHeight = 0.24;  // of the window: the middle of the picture stays free to be cut
constexpr float kTallest = 260;

}  // namespace

NoticePlace noticePlace(float width, float height, float menu, float scale, SidePanels panels) {
  float left = 0, right = width;
  if (panels == SidePanels::kBoth) {
    left = scale * kPanelWidth + kGap;
    right = width - left;
  } else if (panels == SidePanels::kImport) {
    right = width - scale * kImportPanelWidth;
  }
  if (right - left < kNarrowest) {
    left = 0;
    right = width;
  }

  NoticePlace out;
  out.middle = 0.5f * (left + right);
  out.width = std::min(right - left - kGap, scale * kWidest);
  out.hangs = panels == SidePanels::kBoth;  // hints, timeline and plan stand below
  out.edge = out.hangs ? menu + scale * kBelowMenu : height - kGap;
  out.most_height = std::min(scale * kTallest, kMostOfHeight * height);
  return out;
}

void drawNotices(AppContext& context, std::size_t& seen, std::size_t& drawn) {
  const auto& notices = context.bench.notices->list();
  if (seen >= notices.size()) return;
  const ImGuiIO& io = ImGui::GetIO();
  const SidePanels panels = context.bench.imports->isImporting() ? SidePanels::kImport
                            : context.bench.document->isShown()  ? SidePanels::kBoth
                                                                 : SidePanels::kNone;
  const NoticePlace at = noticePlace(io.DisplaySize.x, io.DisplaySize.y, ImGui::GetFrameHeight(), scaled(1), panels);
  ImGui::SetNextWindowPos({at.middle, at.edge}, ImGuiCond_Always, {0.5f, at.hangs ? 0.0f : 1.0f});
  ImGui::SetNextWindowSizeConstraints({std::min(at.width, scaled(240)), 0}, {at.width, at.most_height});
  ui::begin("##notices", nullptr,
            ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove);

  // Only the newest: a long list would hide the object.
  constexpr std::size_t kMost = 3;
  const std::size_t first = std::max(seen, notices.size() - std::min(notices.size(), kMost));
  if (first > seen) ui::textColored(styleColours().quiet, phrase("{} earlier", first - seen));
  const ImGuiStyle& style = ImGui::GetStyle();
  ImGui::PushTextWrapPos(at.width - style.WindowPadding.x - style.ScrollbarSize);
  for (std::size_t n = first; n < notices.size(); ++n)
    notices[n].is_error ? ui::textColored(styleColours().warning, notices[n].text) : ui::text(notices[n].text);
  ImGui::PopTextWrapPos();
  const bool is_read = ui::button("OK", {scaled(90), 0});
  if (drawn != notices.size()) ImGui::SetScrollHereY(1);
  drawn = notices.size();
  if (is_read) seen = notices.size();
  ImGui::End();
}

}  // namespace kerf
