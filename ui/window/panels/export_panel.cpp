#include "ui/window/panels/export_panel.h"

#include <imgui.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "geometry/formats/mesh_formats.h"
#include "ui/app/base/language.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/export_plan.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

using Stage = ExportPlan::Stage;

constexpr float kExportWidth = 480, kFindingsHeight = 170;

// ---- Choices

void drawWhat(ExportPlan& plan) {
  const std::vector<ExportOffer> offers = plan.offers();
  const char* chosen = "";
  for (const ExportOffer& offer : offers)
    if (offer.choice == plan.choice()) chosen = offer.label.c_str();
  ImGui::SetNextItemWidth(-1);
  if (!ui::beginCombo("##what", chosen)) return;
  for (const ExportOffer& offer : offers)
    if (ui::selectable(offer.label, offer.choice == plan.choice())) plan.choose(offer.choice);
  ImGui::EndCombo();
}

std::string labelOf(const MeshFormatRow& format) {
  const bool has_colours = format.carries.vertex_colors || format.carries.face_colors;
  return std::string(format.name) + shownText(has_colours ? ", with the colours of the scan" : "");
}

void drawFormat(AppContext& context, ExportPlan& plan) {
  const MeshFormatRow* const now = plan.format();
  ImGui::SetNextItemWidth(-1);
  if (!ui::beginCombo("##format", now ? labelOf(*now) : "unsupported extension")) return;
  for (const MeshFormatRow* format : ExportPlan::formats()) {
    if (!ui::selectable(labelOf(*format), format == now)) continue;
    if (const auto set = plan.setFormat(std::string(format->name)); !set) context.bench.notices->complain(set.error());
  }
  ImGui::EndCombo();
}

void drawWhere(ExportPlan& plan, const std::function<void(const AppCommand&)>& ask_for_file) {
  std::array<char, 256> name{};
  plan.file().filename().string().copy(name.data(), name.size() - 1);
  ImGui::SetNextItemWidth(-scaled(110));
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  static std::filesystem::path before;  // the name was typed: a whole path may stand there meanwhile
  const bool is_typed = ui::inputText("##name", name.data(), name.size(), ImGuiInputTextFlags_AutoSelectAll);
  if (ImGui::IsItemActivated()) before = plan.file();
  if (is_typed) plan.setName(name.data(), before);
  if (plan.isDone() && ImGui::IsItemActive() && !ImGui::IsItemActivated())
    ImGui::SetWindowFocus(nullptr);  // keys again
  if (ImGui::IsItemHovered()) ui::setTooltip("A name, or a whole path");
  ImGui::SameLine();
  if (ui::button("Choose...", {-1, 0})) ask_for_file(*findAppCommand("export.to"));
  ImGui::PushTextWrapPos(0);
  ui::textColored(styleColours().quiet, phrase("in {}", plan.file().parent_path().string()));
  if (!plan.replaced().empty() && !plan.written()) {
    const std::string first = plan.replaced().front().filename().string();
    const std::size_t more = plan.replaced().size() - 1;
    ui::textColored(styleColours().warning,
                    more == 0 ? phrase("{} exists; the export replaces it", first)
                              : phrase("{} and {} more exist; the export replaces them", first, more));
  }
  ImGui::PopTextWrapPos();
}

// ---- Result of the check

void drawExportProgress(AppContext& context) {
  const AnyJob* const job = context.bench.jobs->running();
  if (!job) return ui::textColored(styleColours().quiet, "Checking...");
  const JobStatus s = job->status();
  ui::progressBar(static_cast<float>(s.done), {-scaled(110), 0});
  ImGui::SameLine();
  if (s.is_cancelling)
    ui::text("Cancelling...");
  else if (plainButton("Cancel###cancel-job", "", -1))
    context.bench.jobs->cancel();
  std::string line = shownText(s.title) + (s.step.empty() ? "" : ": " + shownText(s.step));
  if (s.left_s) line += phrase("   about {:.0f} s left", std::ceil(*s.left_s));
  ui::textColored(styleColours().quiet, ui::asItIs(line));
}

void drawExportFindings(ExportPlan& plan) {
  const std::vector<ExportFinding> findings = plan.findings();
  ImGui::BeginChild("findings", {0, scaled(kFindingsHeight)}, true);
  ImGui::PushTextWrapPos(0);
  bool is_first = true;
  for (const ExportFinding& finding : findings) {
    if (finding.is_warning)
      ui::textColored(styleColours().warning, finding.text);
    else if (is_first)
      ui::textColored(styleColours().good, finding.text);
    else
      ui::text(finding.text);
    is_first = false;
  }
  if (plan.isOutdated())
    ui::textColored(styleColours().warning, "The object changed after the check. Kerf checks it again on export.");
  if (plan.written()) ui::text(shownText("\nWritten, read back and checked:\n") + plan.written()->text);
  if (!plan.error().empty()) ui::textColored(styleColours().warning, plan.error());
  if (findings.empty() && plan.error().empty()) ui::textColored(styleColours().quiet, "Not checked yet.");
  ImGui::PopTextWrapPos();
  ImGui::EndChild();
}

// ---- Progress

void runExport(AppContext& context, const char* id) {
  if (const auto done = runAppCommand(context, id); !done) context.bench.notices->complain(done.error());
}

bool writes_when_drawn = false;  // Enter was pressed: after the field has taken the letters before it

void drawExportButtons(AppContext& context, ExportPlan& plan) {
  const Stage stage = plan.stage();
  if (std::exchange(writes_when_drawn, false)) plan.write();
  if (plan.isDone()) {
    if (strongButton("Show in folder", "", scaled(150))) runExport(context, "export.show-in-folder");
  } else {
    const char* const verb = plan.asksToReplace() ? "Replace" : stage == Stage::kDoubtful ? "Export anyway" : "Export";
    if (strongButton(verb, "Enter", scaled(stage == Stage::kDoubtful ? 220 : 150))) plan.write();
  }
  ImGui::SameLine();
  const bool is_idle = !context.bench.jobs->running();
  if (is_idle && (stage == Stage::kUnchecked || stage == Stage::kRefused || plan.isOutdated())) {
    if (plainButton("Check again", "", scaled(120))) plan.check();
    ImGui::SameLine();
  }
  if (plainButton("Close", "Esc", -1)) plan.hide();
}

}  // namespace

void drawExportPanel(AppContext& context, const std::function<void(const AppCommand&)>& ask_for_file) {
  ExportPlan& plan = *context.bench.exporting;
  if (!plan.isShown()) return;
  placeDialog(context, scaled(kExportWidth));
  bool stays = true;
  ui::begin("Export", &stays, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse);
  heading("Content");
  drawWhat(plan);
  heading("Format");
  drawFormat(context, plan);
  heading("Destination");
  drawWhere(plan, ask_for_file);
  heading("Print check");
  const bool is_at_work = plan.stage() == Stage::kChecking || plan.stage() == Stage::kWriting;
  is_at_work ? drawExportProgress(context) : drawExportFindings(plan);
  drawExportButtons(context, plan);
  ImGui::End();
  if (!stays) plan.hide();
}

bool exportPanelKey(AppContext& context, bool is_enter) {
  ExportPlan& plan = *context.bench.exporting;
  if (!plan.isShown()) return false;
  if (is_enter && !plan.isDone())
    writes_when_drawn = true;
  else
    plan.hide();
  return true;
}

}  // namespace kerf
