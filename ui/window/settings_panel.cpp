#include "ui/window/settings_panel.h"

#include <imgui.h>

#include <cmath>
#include <numbers>

#include "ui/app/settings.h"
#include "ui/app/system_dialog.h"
#include "ui/window/style.h"

namespace kerf {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

void save(AppContext& context) {
  if (const auto done = context.settings->save(); !done) context.bench.complain(done.error());
}

// A broken file stays as it is until the user says otherwise.
void drawBroken(AppContext& context) {
  ImGui::PushTextWrapPos(0);
  ImGui::TextColored(styleColours().warning, "The file of settings can not be read, and nothing is kept: %s",
                     context.settings->error()->message().c_str());
  ImGui::PopTextWrapPos();
  if (!plainButton("Set it aside and begin anew", "", -1)) return;
  if (const auto done = context.settings->setAside(); !done) return context.bench.complain(done.error());
  save(context);
}

}  // namespace

void drawSettings(AppContext& context) {
  if (!context.shows_settings || !context.settings) return;
  Settings& values = context.settings->values;
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos({0.5f * io.DisplaySize.x, 0.45f * io.DisplaySize.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({scaled(420), 0}, ImGuiCond_Always);
  ImGui::Begin("Settings", &context.shows_settings,
               ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse);
  if (context.settings->error()) drawBroken(context);
  static const bool has_system_dialog = SystemDialog::program().has_value();  // not to be looked for in each frame
  bool is_set = false;

  heading("Looks");
  if (ImGui::RadioButton("Light", values.theme == Theme::kLight)) {
    values.theme = Theme::kLight;
    is_set = true;
  }
  ImGui::SameLine();
  if (ImGui::RadioButton("Dark", values.theme == Theme::kDark)) {
    values.theme = Theme::kDark;
    is_set = true;
  }
  // The window is laid out anew with each size: by steps, so that a slider does not run away from the mouse.
  ImGui::AlignTextToFramePadding();
  ImGui::Text("Size of type and panels: %.0f %%", 100 * values.ui_scale);
  ImGui::SameLine(scaled(270));
  if (ImGui::Button("-##smaller", {scaled(36), 0})) (void)runAppCommand(context, "view.smaller");
  ImGui::SameLine();
  if (ImGui::Button("+##larger", {scaled(36), 0})) (void)runAppCommand(context, "view.larger");
  bool has_hints = !values.are_hints_dismissed;
  if (ImGui::Checkbox("Show the hints for the mouse", &has_hints)) {
    values.are_hints_dismissed = !has_hints;
    is_set = true;
  }

  heading("Perspective");
  bool is_perspective = context.camera.isPerspective();
  if (ImGui::Checkbox("Near things are larger", &is_perspective)) (void)runAppCommand(context, "view.perspective");
  float field = static_cast<float>(values.perspective_deg);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##field", &field, static_cast<float>(Camera::kLeastField),
                         static_cast<float>(Camera::kMostField), "field of view %.0f deg",
                         ImGuiSliderFlags_AlwaysClamp)) {
    values.perspective_deg = std::round(static_cast<double>(field));
    if (is_perspective) setFieldOfView(context.camera, values.perspective_deg * kDegree);
  }
  is_set |= ImGui::IsItemDeactivatedAfterEdit();

  heading("Files");
  bool is_system = !values.has_own_dialog;
  if (ImGui::Checkbox("Ask by the system's dialog", &is_system)) {
    values.has_own_dialog = !is_system;
    is_set = true;
  }
  if (!has_system_dialog) {
    ImGui::SameLine();
    ImGui::TextColored(styleColours().quiet, "there is none");
  }

  heading("Sound of the drill");
  float volume = static_cast<float>(values.sound_volume);
  ImGui::SetNextItemWidth(-scaled(90));
  if (ImGui::SliderFloat("##volume", &volume, 0, 100, "%.0f %%", ImGuiSliderFlags_AlwaysClamp))
    values.sound_volume = std::round(static_cast<double>(volume));
  is_set |= ImGui::IsItemDeactivatedAfterEdit();
  ImGui::SameLine();
  is_set |= ImGui::Checkbox("Mute", &values.is_muted);

  heading("At the beginning of a session");
  float force = static_cast<float>(values.force_N), depth = static_cast<float>(values.depth_mm);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##force", &force, static_cast<float>(Workbench::kLeastForce), 5, "push %.1f N",
                         ImGuiSliderFlags_AlwaysClamp))
    values.force_N = 0.1 * std::round(10 * static_cast<double>(force));
  is_set |= ImGui::IsItemDeactivatedAfterEdit();
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderFloat("##depth", &depth, 0, static_cast<float>(Workbench::kMostDepth), "depth %.2f mm",
                         ImGuiSliderFlags_AlwaysClamp))
    values.depth_mm = 0.05 * std::round(20 * static_cast<double>(depth));
  is_set |= ImGui::IsItemDeactivatedAfterEdit();
  if (plainButton("Take those of now", "", -1)) (void)runAppCommand(context, "settings.push");

  ImGui::PushTextWrapPos(0);
  ImGui::TextColored(styleColours().quiet, "Kept in %s", context.settings->path().c_str());
  ImGui::PopTextWrapPos();
  ImGui::End();
  if (is_set) save(context);
}

}  // namespace kerf
