#include "ui/window/export_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "geometry/formats/mesh_formats.h"
#include "ui/app/export_plan.h"
#include "ui/window/style.h"

namespace kerf {
namespace {

using Stage = ExportPlan::Stage;

constexpr float kWidth = 480, kFindingsHeight = 170;

// ---- What is decided

void drawWhat(ExportPlan& plan) {
  const std::vector<ExportOffer> offers = plan.offers();
  const char* chosen = "";
  for (const ExportOffer& offer : offers)
    if (offer.choice == plan.choice()) chosen = offer.label.c_str();
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::BeginCombo("##what", chosen)) return;
  for (const ExportOffer& offer : offers)
    if (ImGui::Selectable(offer.label.c_str(), offer.choice == plan.choice())) plan.choose(offer.choice);
  ImGui::EndCombo();
}

std::string labelOf(const MeshFormatRow& format) {
  const bool has_colours = format.carries.vertex_colors || format.carries.face_colors;
  return std::string(format.name) + (has_colours ? ", with the colours of the scan" : "");
}

void drawFormat(AppContext& context, ExportPlan& plan) {
  const MeshFormatRow* const now = plan.format();
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::BeginCombo("##format", now ? labelOf(*now).c_str() : "an ending that is not written")) return;
  for (const MeshFormatRow* format : ExportPlan::formats()) {
    if (!ImGui::Selectable(labelOf(*format).c_str(), format == now)) continue;
    if (const auto set = plan.setFormat(std::string(format->name)); !set) context.bench.complain(set.error());
  }
  ImGui::EndCombo();
}

void drawWhere(ExportPlan& plan, const std::function<void(const AppCommand&)>& ask_for_file) {
  std::array<char, 256> name{};
  plan.file().filename().string().copy(name.data(), name.size() - 1);
  ImGui::SetNextItemWidth(-scaled(110));
  if (ImGui::InputText("##name", name.data(), name.size())) plan.setName(name.data());
  ImGui::SameLine();
  if (ImGui::Button("Choose...", {-1, 0})) ask_for_file(*findAppCommand("export.to"));
  ImGui::PushTextWrapPos(0);
  ImGui::TextColored(styleColours().quiet, "in %s", plan.file().parent_path().c_str());
  if (!plan.replaced().empty() && !plan.written()) {
    const std::string more = plan.replaced().size() > 1 ? fmt::format(" and {} more", plan.replaced().size() - 1) : "";
    ImGui::TextColored(styleColours().warning, "%s%s: there already, would be replaced",
                       plan.replaced().front().filename().c_str(), more.c_str());
  }
  ImGui::PopTextWrapPos();
}

// ---- What the check says

void drawProgress(AppContext& context) {
  const AnyJob* const job = context.bench.job();
  if (!job) return ImGui::TextColored(styleColours().quiet, "Checking...");
  const JobStatus s = job->status();
  ImGui::ProgressBar(static_cast<float>(s.done), {-scaled(110), 0});
  ImGui::SameLine();
  if (s.is_cancelling)
    ImGui::TextUnformatted("Cancelling...");
  else if (plainButton("Cancel###cancel-job", "", -1))
    context.bench.cancelJob();
  std::string line = s.title + (s.step.empty() ? "" : ": " + s.step);
  if (s.left_s) line += fmt::format("   about {:.0f} s left", std::ceil(*s.left_s));
  ImGui::TextColored(styleColours().quiet, "%s", line.c_str());
}

void drawFindings(ExportPlan& plan) {
  const std::vector<ExportFinding> findings = plan.findings();
  ImGui::BeginChild("findings", {0, scaled(kFindingsHeight)}, true);
  ImGui::PushTextWrapPos(0);
  bool is_first = true;
  for (const ExportFinding& finding : findings) {
    if (finding.is_warning)
      ImGui::TextColored(styleColours().warning, "%s", finding.text.c_str());
    else if (is_first)
      ImGui::TextColored(styleColours().good, "%s", finding.text.c_str());
    else
      ImGui::TextUnformatted(finding.text.c_str());
    is_first = false;
  }
  if (plan.isOutdated())
    ImGui::TextColored(styleColours().warning, "Something was cut or moved since: it is checked again when written.");
  if (plan.written()) ImGui::TextUnformatted(("\nWritten, read back and checked:\n" + plan.written()->text).c_str());
  if (!plan.error().empty()) ImGui::TextColored(styleColours().warning, "%s", plan.error().c_str());
  if (findings.empty() && plan.error().empty()) ImGui::TextColored(styleColours().quiet, "Not checked yet.");
  ImGui::PopTextWrapPos();
  ImGui::EndChild();
}

// ---- What goes on

void run(AppContext& context, const char* id) {
  if (const auto done = runAppCommand(context, id); !done) context.bench.complain(done.error());
}

void drawButtons(AppContext& context, ExportPlan& plan) {
  const Stage stage = plan.stage();
  if (plan.isDone()) {
    if (strongButton("Show in folder", "", scaled(150))) run(context, "export.show-in-folder");
  } else {
    const char* const verb = plan.asksToReplace()        ? "Replace"
                             : stage == Stage::kDoubtful ? "Export all the same"
                                                         : "Export";
    if (strongButton(verb, "Enter", scaled(stage == Stage::kDoubtful ? 220 : 150))) plan.write();
  }
  ImGui::SameLine();
  const bool is_idle = !context.bench.job();
  if (is_idle && (stage == Stage::kUnchecked || stage == Stage::kRefused || plan.isOutdated())) {
    if (plainButton("Check again", "", scaled(120))) plan.check();
    ImGui::SameLine();
  }
  if (plainButton("Close", "Esc", -1)) plan.hide();
}

}  // namespace

void drawExportPanel(AppContext& context, const std::function<void(const AppCommand&)>& ask_for_file) {
  ExportPlan& plan = context.bench.exporting();
  if (!plan.isShown()) return;
  const ImGuiIO& io = ImGui::GetIO();
  ImGui::SetNextWindowPos({0.5f * io.DisplaySize.x, 0.45f * io.DisplaySize.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({scaled(kWidth), 0}, ImGuiCond_Always);
  bool stays = true;
  ImGui::Begin("Export", &stays, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse);
  heading("What");
  drawWhat(plan);
  heading("Format");
  drawFormat(context, plan);
  heading("Where to");
  drawWhere(plan, ask_for_file);
  heading("As kerf check sees it");
  const bool is_at_work = plan.stage() == Stage::kChecking || plan.stage() == Stage::kWriting;
  is_at_work ? drawProgress(context) : drawFindings(plan);
  drawButtons(context, plan);
  ImGui::End();
  if (!stays) plan.hide();
}

bool exportPanelKey(AppContext& context, bool is_enter) {
  ExportPlan& plan = context.bench.exporting();
  if (!plan.isShown()) return false;
  if (!is_enter)
    plan.hide();
  else if (!plan.isDone())
    plan.write();
  return true;
}

}  // namespace kerf
