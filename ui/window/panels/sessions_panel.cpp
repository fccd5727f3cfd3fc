#include "ui/window/panels/sessions_panel.h"

#include <imgui.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "ui/app/base/language.h"
#include "ui/app/document/file_history.h"
#include "ui/app/document/jobs.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr const char* kRename = "Rename session###rename-session";
constexpr const char* kDelete = "Delete the session?###delete-session";

// Its number in the list, as a parameter. The list may have changed since the question.
std::vector<std::string> numberOfSession(const Workbench& bench, const std::filesystem::path& folder) {
  const auto& all = bench.history->sessions();
  const auto at = std::find_if(all.begin(), all.end(), [&](const SavedSession& s) { return s.folder == folder; });
  return {std::to_string(at - all.begin() + 1)};
}

bool beginQuestion(const char* title) {
  if (!ui::isPopupOpen(title)) ui::openPopup(title);
  ImGui::SetNextWindowSize({scaled(460), 0});
  return ui::beginPopupModal(title, nullptr, ImGuiWindowFlags_NoResize);
}

// Esc took its reason away.
void endQuestion(const char* title) {
  if (!ui::isPopupOpen(title) || !ui::beginPopupModal(title)) return;
  ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

void drawRename(AppContext& context, SessionsPanelState& state) {
  if (!state.renamed) return endQuestion(kRename);
  if (!beginQuestion(kRename)) return;
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(-1);
  const bool is_entered = ui::inputText("##name", state.name, sizeof(state.name), ImGuiInputTextFlags_EnterReturnsTrue);
  ImGui::Dummy({0, scaled(4)});
  bool is_over = false;
  if (strongButton("Rename", "", scaled(200)) || is_entered) {
    std::vector<std::string> words = numberOfSession(context.bench, *state.renamed);
    words.emplace_back(state.name);
    runIfEnabled(context, "session.rename", words);
    state.pictures.clear();
    is_over = true;
  }
  ImGui::SameLine();
  is_over |= plainButton("Cancel", "Esc", -1);
  if (is_over) {
    state.renamed.reset();
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

void drawDelete(AppContext& context, SessionsPanelState& state) {
  if (!state.deleted) return endQuestion(kDelete);
  if (!beginQuestion(kDelete)) return;
  ImGui::PushTextWrapPos(0);
  ui::text(ui::asItIs(state.deleted->string()));
  ui::text("Kerf deletes the folder with all cuts of that session. You cannot undo this.");
  ImGui::PopTextWrapPos();
  ImGui::Dummy({0, scaled(4)});
  bool is_over = strongButton("Keep session", "Esc", scaled(200));
  ImGui::SameLine();
  if (plainButton("Delete session", "", -1)) {
    std::vector<std::string> words = numberOfSession(context.bench, *state.deleted);
    words.emplace_back("delete");
    runIfEnabled(context, "session.delete", words);
    is_over = true;
  }
  if (is_over) {
    state.deleted.reset();
    ImGui::CloseCurrentPopup();
  }
  ImGui::EndPopup();
}

// True: a command has changed the list.
bool drawRow(AppContext& context, SessionsPanelState& state, std::size_t n) {
  const SavedSession session = context.bench.history->sessions()[n];
  const float height = scaled(50), width = scaled(80), top = ImGui::GetCursorPosY();
  ImGui::PushID(static_cast<int>(n));
  if (const ImTextureID picture = state.pictures.of(session.folder / kSessionPicture))
    ImGui::Image(picture, {width, height});
  else
    ImGui::Dummy({width, height});
  ImGui::SameLine();
  ImGui::BeginGroup();
  ui::text(ui::asItIs(session.title));
  if (ImGui::IsItemHovered()) ui::setTooltip(ui::asItIs(session.folder.string()));
  const std::string size = phrase("{:.1f} MB", 1e-6 * static_cast<double>(session.bytes));
  ui::textColored(styleColours().quiet, ui::asItIs(session.date + "   " + size));
  ImGui::EndGroup();

  const bool is_idle = !context.bench.jobs->running();
  ui::sameLineAt(ImGui::GetContentRegionMax().x - scaled(290));
  ImGui::SetCursorPosY(top + 0.5f * (height - ImGui::GetFrameHeight()));
  ImGui::BeginDisabled(!is_idle || !session.has_ended);
  const bool continues = ui::button("Continue", {scaled(90), 0});
  ImGui::SameLine();
  if (ui::button("Rename...", {scaled(90), 0})) {
    state.renamed = session.folder;
    std::snprintf(state.name, sizeof(state.name), "%s", session.title.c_str());
  }
  ImGui::EndDisabled();
  ImGui::SameLine();
  ImGui::BeginDisabled(!is_idle);
  if (ui::button("Delete...", {scaled(90), 0})) state.deleted = session.folder;
  ImGui::EndDisabled();
  ImGui::SetCursorPosY(top + height + scaled(6));
  ImGui::PopID();
  if (!continues) return false;
  runIfEnabled(context, "session.open", numberOfSession(context.bench, session.folder));
  context.panels["sessions"] = false;
  return true;
}

}  // namespace

void drawSessions(AppContext& context, SessionsPanelState& state) {
  if (!context.panels["sessions"]) {
    state.was_drawn = false;
    return;
  }
  Workbench& bench = context.bench;
  if (!std::exchange(state.was_drawn, true)) {
    bench.history->refreshSessions();
    state.pictures.clear();
  }
  placeDialog(context, scaled(640), scaled(460));
  ImGui::SetNextWindowBgAlpha(1);
  ui::begin("Sessions", &context.panels["sessions"],
            ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse);
  if (bench.history->sessions().empty()) ui::textColored(styleColours().quiet, "No saved sessions.");
  for (std::size_t n = 0; n < bench.history->sessions().size(); ++n)
    if (drawRow(context, state, n)) break;
  drawRename(context, state);
  drawDelete(context, state);
  ImGui::End();
}

}  // namespace kerf
