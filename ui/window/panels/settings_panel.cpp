#include "ui/window/panels/settings_panel.h"

#include <imgui.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "ui/app/base/language.h"
#include "ui/app/base/system_dialog.h"
#include "ui/app/document/jobs.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/strokes.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"
#include "ui/window/panels/help_panel.h"

namespace kerf {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

void save(AppContext& context) {
  if (const auto done = context.settings->save(); !done) context.bench.notices->complain(done.error());
}

// Keeps a broken file until the user decides.
void drawBrokenSettings(AppContext& context) {
  ImGui::PushTextWrapPos(0);
  ui::textColored(styleColours().warning, phrase("Cannot read the settings file; changes are not saved. {}",
                                                 context.settings->error()->message()));
  ImGui::PopTextWrapPos();
  if (!plainButton("Set aside and start new file", "", -1)) return;
  if (const auto done = context.settings->setAside(); !done) return context.bench.notices->complain(done.error());
  save(context);
}

// Files of the user's folder and Kerf's own, searched when the list opens.
void drawLanguage(AppContext& context) {
  struct Row {
    std::string id, name;
  };
  static std::vector<Row> rows;
  const std::string& now = context.settings->values.language;
  heading("Language");
  ImGui::SetNextItemWidth(-1);
  const auto shown = shownLanguage();
  if (!ui::beginCombo("##language", ui::asItIs(shown ? shown->name() : "English"))) return rows.clear();
  if (rows.empty()) {
    rows.push_back({"en", "English"});
    for (const auto& [id, file] : findLanguages(context.settings->path().parent_path())) {
      const auto read = Language::read(file);
      rows.push_back({id, read ? read->name() : file.filename().string()});  // if chosen, it reports its error
    }
  }
  for (const Row& row : rows) {
    if (!ui::selectable(ui::asItIs(row.name + "###" + row.id), row.id == now)) continue;
    const auto done = runAppCommand(context, "settings.language", std::vector<std::string>{row.id});
    if (!done) context.bench.notices->complain(done.error());
  }
  ImGui::EndCombo();
}

}  // namespace

void drawSettings(AppContext& context) {
  if (!context.panels["settings"] || !context.settings) return;
  Settings& values = context.settings->values;
  placeDialog(context, scaled(420));
  ui::begin("Settings", &context.panels["settings"],
            ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse);
  if (context.settings->error()) drawBrokenSettings(context);
  static const bool has_system_dialog = SystemDialog::program().has_value();  // avoids a search in each frame
  bool is_set = false;

  heading("Appearance");
  if (ui::radioButton("Light", values.theme == Theme::kLight)) {
    values.theme = Theme::kLight;
    is_set = true;
  }
  ImGui::SameLine();
  if (ui::radioButton("Dark", values.theme == Theme::kDark)) {
    values.theme = Theme::kDark;
    is_set = true;
  }
  // Each size changes the layout of the window: in steps, so that a slider does not run away from the mouse.
  ImGui::AlignTextToFramePadding();
  ui::text(phrase("Text and panel size: {:.0f} %", 100 * values.ui_scale));
  ui::sameLineAt(scaled(270));
  if (ui::button("-##smaller", {scaled(36), 0})) (void)runAppCommand(context, "view.smaller");
  ImGui::SameLine();
  if (ui::button("+##larger", {scaled(36), 0})) (void)runAppCommand(context, "view.larger");
  drawLeftButton(context);
  bool has_hints = !values.are_hints_dismissed;
  if (ui::checkbox("Show mouse hints", &has_hints)) {
    values.are_hints_dismissed = !has_hints;
    is_set = true;
  }

  drawLanguage(context);
  heading("Perspective");
  bool is_perspective = context.camera.isPerspective();
  if (ui::checkbox("Use perspective", &is_perspective)) (void)runAppCommand(context, "view.perspective");
  float field = static_cast<float>(values.perspective_deg);
  ImGui::SetNextItemWidth(-1);
  if (ui::sliderFloat("##field", &field, static_cast<float>(Camera::kLeastField),
                      static_cast<float>(Camera::kMostField), "field of view %.0f deg", ImGuiSliderFlags_AlwaysClamp)) {
    values.perspective_deg = std::round(static_cast<double>(field));
    if (is_perspective) setFieldOfView(context.camera, values.perspective_deg * kDegree);
  }
  is_set |= ImGui::IsItemDeactivatedAfterEdit();

  heading("Files");
  bool is_system = !values.has_own_dialog;
  if (ui::checkbox("Use the system file dialog", &is_system)) {
    values.has_own_dialog = !is_system;
    is_set = true;
  }
  if (!has_system_dialog) {
    ImGui::SameLine();
    ui::textColored(styleColours().quiet, "none installed");
  }

  heading("Drill sound");
  float volume = static_cast<float>(values.sound_volume);
  ImGui::SetNextItemWidth(-scaled(90));
  if (ui::sliderFloat("##volume", &volume, 0, 100, "%.0f %%", ImGuiSliderFlags_AlwaysClamp))
    values.sound_volume = std::round(static_cast<double>(volume));
  is_set |= ImGui::IsItemDeactivatedAfterEdit();
  ImGui::SameLine();
  is_set |= ui::checkbox("Mute", &values.is_muted);

  heading("Session defaults");
  float force = static_cast<float>(values.force_N), depth = static_cast<float>(values.depth_mm);
  ImGui::SetNextItemWidth(-1);
  if (ui::sliderFloat("##force", &force, static_cast<float>(Strokes::kLeastForce), 5, "push %.1f N",
                      ImGuiSliderFlags_AlwaysClamp))
    values.force_N = 0.1 * std::round(10 * static_cast<double>(force));
  is_set |= ImGui::IsItemDeactivatedAfterEdit();
  ImGui::SetNextItemWidth(-1);
  if (ui::sliderFloat("##depth", &depth, 0, static_cast<float>(Strokes::kMostDepth), "depth %.2f mm",
                      ImGuiSliderFlags_AlwaysClamp))
    values.depth_mm = 0.05 * std::round(20 * static_cast<double>(depth));
  is_set |= ImGui::IsItemDeactivatedAfterEdit();
  if (plainButton("Use current values", "", -1)) (void)runAppCommand(context, "settings.push");

  ImGui::PushTextWrapPos(0);
  ui::textColored(styleColours().quiet, phrase("Saved in {}", context.settings->path().string()));
  ImGui::PopTextWrapPos();
  ImGui::End();
  if (is_set) save(context);
}

}  // namespace kerf
