#include "ui/window/frame/notices.h"

#include <imgui.h>

#include <algorithm>
#include <limits>

#include "ui/app/base/language.h"
#include "ui/app/document/jobs.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr float kGap = 16, kWidest = 720;
constexpr float kBelowMenu = 48;        // below the hint for picking
constexpr float kMostOfHeight = 0.24f;  // of the area: the middle of the picture stays free to be cut
constexpr float kTallest = 260;

// Adds new notices, drops faded ones.
void update(const std::vector<Notice>& notices, NoticesState& state) {
  const double now = ImGui::GetTime();
  state.seen = std::min(state.seen, notices.size());
  for (; state.seen < notices.size(); ++state.seen) {
    std::erase_if(state.shown, [&](const NoticesState::Shown& s) {
      return notices[s.index].is_error && notices[s.index].text == notices[state.seen].text;
    });
    state.shown.push_back(
        {state.seen, notices[state.seen].is_error ? std::numeric_limits<double>::infinity() : now + kNoticeSeconds});
  }
  std::erase_if(state.shown, [now](const NoticesState::Shown& s) { return s.until < now; });
}

}  // namespace

bool NoticesState::hasError(const std::vector<Notice>& notices) const {
  return std::any_of(shown.begin(), shown.end(), [&](const Shown& s) { return notices[s.index].is_error; });
}

NoticePlace noticePlace(const FrameArea& free, bool hangs, float scale) {
  NoticePlace out;
  out.middle = free.middle();
  out.width = std::min(free.width() - kGap, scale * kWidest);
  out.hangs = hangs;
  out.edge = hangs ? free.top + scale * kBelowMenu : free.bottom - kGap;
  out.most_height = std::min(scale * kTallest, kMostOfHeight * free.height());
  return out;
}

void drawNotices(AppContext& context, NoticesState& state) {
  const auto& notices = context.bench.notices->list();
  const std::size_t before = state.seen;
  update(notices, state);
  if (state.shown.empty()) return;
  const Screen screen = screenOf(context.bench);
  const FrameArea free = frameLayout(context).free;
  const NoticePlace at = noticePlace(free, screen == Screen::kCut || screen == Screen::kReplay, scaled(1));
  ImGui::SetNextWindowPos({at.middle, at.edge}, ImGuiCond_Always, {0.5f, at.hangs ? 0.0f : 1.0f});
  ImGui::SetNextWindowSizeConstraints({std::min(at.width, scaled(240)), 0}, {at.width, at.most_height});
  ui::begin("##notices", nullptr,
            ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                ImGuiWindowFlags_NoSavedSettings);

  // Only the newest: a long list would hide the object.
  constexpr std::size_t kMost = 3;
  const std::size_t first = state.shown.size() - std::min(state.shown.size(), kMost);
  if (first > 0) ui::textColored(styleColours().quiet, phrase("{} earlier", first));
  const ImGuiStyle& style = ImGui::GetStyle();
  bool has_error = false;
  ImGui::PushTextWrapPos(at.width - style.WindowPadding.x - style.ScrollbarSize);
  for (std::size_t n = first; n < state.shown.size(); ++n) {
    const Notice& notice = notices[state.shown[n].index];
    has_error |= notice.is_error;
    notice.is_error ? ui::textColored(styleColours().warning, notice.text) : ui::text(notice.text);
  }
  ImGui::PopTextWrapPos();
  const bool is_read = (has_error && ui::button("OK", {scaled(90), 0})) ||
                       (!has_error && ImGui::IsWindowHovered() && ImGui::IsMouseClicked(0));
  if (before != state.seen) ImGui::SetScrollHereY(1);
  if (is_read) state.shown.clear();
  ImGui::End();
}

}  // namespace kerf
