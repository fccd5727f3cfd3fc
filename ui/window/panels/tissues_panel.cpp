#include "ui/window/panels/tissues_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/document/view_state.h"
#include "ui/app/view/tissue_display.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr float kLegendHeight = 14;
constexpr int kLegendSteps = 50;

void runTissues(AppContext& context, const char* id, const std::vector<std::string>& words) {
  if (const auto done = runAppCommand(context, id, words); !done) context.bench.notices->complain(done.error());
}

ImVec4 shownTissues(const Rgba8& c) {
  const auto one = [](std::uint8_t v) { return static_cast<float>(v) / 255; };
  return {one(c[0]), one(c[1]), one(c[2]), 1};
}

// Removed share of the volume as loaded.
void drawRemovedTissues(double whole_mm3, double removed_mm3) {
  constexpr double kLeast = 0.005;  // mm^3
  if (removed_mm3 < kLeast || whole_mm3 <= 0) return;
  ui::textColored(styleColours().quiet, phrase("    {:.2f} of {:.1f} mm3 cut ({:.1f} %)", removed_mm3, whole_mm3,
                                               100 * removed_mm3 / whole_mm3));
}

void drawTissueRow(AppContext& context, const SeenTissue& tissue) {
  ImGui::PushID(tissue.id.c_str());
  bool is_seen = tissue.look != TissueLook::kHide;
  if (ui::checkbox("##seen", &is_seen)) runTissues(context, "view.tissue", {tissue.id, is_seen ? "show" : "hide"});
  if (ImGui::IsItemHovered()) ui::setTooltip("Show or hide");
  ImGui::SameLine();
  ImGui::ColorButton("##colour", shownTissues(tissue.colour),
                     ImGuiColorEditFlags_NoTooltip | ImGuiColorEditFlags_NoPicker, {scaled(16), scaled(16)});
  ImGui::SameLine();
  const float ghost = ImGui::GetFrameHeight() + ImGui::GetStyle().ItemInnerSpacing.x + ui::textSize("ghost").x;
  const float room = ImGui::GetContentRegionAvail().x - ghost - scaled(6);
  ui::text(ui::asItIs(ui::beginThatFits(shownText(tissue.name), room)));
  if (ImGui::IsItemHovered()) ui::setTooltip(tissue.name);

  ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - ghost);
  bool is_ghost = tissue.look == TissueLook::kGhost;
  if (ui::checkbox("ghost", &is_ghost)) runTissues(context, "view.tissue", {tissue.id, is_ghost ? "ghost" : "show"});
  if (ImGui::IsItemHovered()) ui::setTooltip("Make translucent");
  drawRemovedTissues(tissue.mm3, context.bench.document->removedOf(tissue.material));
  ImGui::PopID();
}

struct ColoursRow {
  SurfaceColours colours;
  const char* word;  // of the command
  const char* text;
};
constexpr std::array<ColoursRow, 5> kColours = {{{SurfaceColours::kTissue, "tissue", "tissue"},
                                                 {SurfaceColours::kScan, "scan", "scan colours"},
                                                 {SurfaceColours::kDepth, "depth", "depth"},
                                                 {SurfaceColours::kDistance, "distance", "distance to pulp and nerve"},
                                                 {SurfaceColours::kContact, "contact", "contact with neighbours"}}};

bool isPossible(const AppContext& context, SurfaceColours colours) {
  if (colours == SurfaceColours::kScan) return findAppCommand("view.colours-scan")->is_enabled(context);
  if (colours == SurfaceColours::kContact) return context.bench.views->tissues().hasNeighbours();
  return colours != SurfaceColours::kDistance || findAppCommand("view.colours-distance")->is_enabled(context);
}

void drawTissueColours(AppContext& context) {
  const SurfaceColours now = context.bench.views->tissues().colours();
  const auto chosen =
      std::find_if(kColours.begin(), kColours.end(), [&](const ColoursRow& row) { return row.colours == now; });
  ImGui::PushItemWidth(-1);
  if (ui::beginCombo("##colours", phrase("Colours: {}", shownText(chosen->word)))) {
    for (const ColoursRow& row : kColours) {
      const auto flags = isPossible(context, row.colours) ? ImGuiSelectableFlags_None : ImGuiSelectableFlags_Disabled;
      if (ui::selectable(row.text, row.colours == now, flags)) runTissues(context, "view.colours", {row.word});
    }
    ImGui::EndCombo();
  }
  ImGui::PopItemWidth();
}

// From 0 at the left to the reach of the map, in the colours of the surface.
void drawLegend(AppContext& context) {
  const TissueDisplay& tissues = context.bench.views->tissues();
  const std::optional<MapLegend> legend = legendOf(tissues.colours(), tissues.mapScale());
  if (!legend) return;
  const MapScale& scale = legend->scale;
  const bool is_contact = legend->of == SurfaceColours::kContact;
  const auto set = [&context](double reach, bool has_bands) {
    runTissues(context, "view.map-range", {fmt::format("{:.1f}", reach), has_bands ? "bands" : "smooth"});
  };
  auto reach = static_cast<float>(scale.reach_mm);
  ImGui::SetNextItemWidth(-1);
  if (ui::sliderFloat("##reach", &reach, static_cast<float>(is_contact ? kLeastContactReach : MapScale::kLeast),
                      static_cast<float>(is_contact ? kMostContactReach : MapScale::kMost), "range %.1f mm",
                      ImGuiSliderFlags_AlwaysClamp))
    set(static_cast<double>(reach), scale.has_bands);
  if (bool has_bands = scale.has_bands; ui::checkbox("Bands of 0.5 mm", &has_bands)) set(scale.reach_mm, has_bands);
  ui::textColored(styleColours().quiet, legend->title);
  const ImVec2 from = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x, height = scaled(kLegendHeight);
  for (int n = 0; n < kLegendSteps; ++n) {
    const double share = (n + 0.5) / kLegendSteps;
    const Rgba8 c = legend->colourAt(share);
    const float left = from.x + width * static_cast<float>(n) / kLegendSteps;
    ImGui::GetWindowDrawList()->AddRectFilled({left, from.y}, {left + width / kLegendSteps + 1, from.y + height},
                                              IM_COL32(c[0], c[1], c[2], 255));
  }
  ImGui::Dummy({width, height});
  ui::text(legend->low);
  const float left = ImGui::GetCursorPosX();
  for (const MapLegend::Tick& tick : legend->ticks) {
    ImGui::SameLine(left + width * static_cast<float>(tick.share) - 0.5f * ui::textSize(tick.text).x);
    ui::text(tick.text);
  }
  ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - ui::textSize(legend->high).x);
  ui::text(legend->high);
  if (is_contact) ui::textColored(styleColours().quiet, "Below 0: overlap. To 0.2 mm: contact.");
}

}  // namespace

bool areTissuesNeeded(const AppContext& context) {
  const TissueDisplay& tissues = context.bench.views->tissues();
  return tissues.all().size() > 1 || tissues.hasScanColours() || tissues.hasNeighbours() ||
         tissues.colours() != SurfaceColours::kTissue;
}

void drawTissues(AppContext& context) {
  const TissueDisplay& tissues = context.bench.views->tissues();
  if (tissues.all().size() > 1)
    for (const SeenTissue& tissue : tissues.all()) drawTissueRow(context, tissue);
  drawTissueColours(context);
  drawLegend(context);
  if (tissues.isBusy()) ui::textColored(styleColours().quiet, "working...");
}

}  // namespace kerf
