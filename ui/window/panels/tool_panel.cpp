#include "ui/window/panels/tool_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/readout/tool_rack.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/tools.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr float kIcon = 30, kRowGap = 2, kStar = 18;
constexpr int kToolRows = 10;

std::string sizeOf(const Tool& tool) {
  if (tool.head_diameter_mm > 0) return shownNumbers("{:.1f} mm", tool.head_diameter_mm);
  if (tool.kind == ToolKind::kBlade) return phrase("kerf {:.2f}", tool.kerfWidth());
  return "";
}

// "Round bur 014": its number, which tells it from its neighbours, and its words.
struct RowName {
  std::string number, words;
};
RowName shownName(const Tool& tool) {
  const std::string_view name = tool.name.empty() ? tool.id : tool.name;
  const std::size_t at = std::min(name.find_first_of("0123456789"), name.size());
  std::string_view words = name.substr(0, at);
  while (words.ends_with(' ')) words.remove_suffix(1);
  return {std::string(name.substr(at)), shownText(words)};
}

void drawIcon(const std::vector<IconTriangle>& icon, ImVec2 at, float side) {
  ImDrawList* const draw = ImGui::GetWindowDrawList();
  const ImDrawListFlags before = draw->Flags;
  draw->Flags &= ~ImDrawListFlags_AntiAliasedFill;  // avoids seams
  draw->PushClipRect(at, {at.x + side, at.y + side}, true);
  for (const IconTriangle& t : icon) {
    const float light = std::clamp(t.shade, 0.2f, 1.0f);
    const ImVec4 base = t.is_cutting ? ImVec4(0.93f, 0.76f, 0.36f, 1) : ImVec4(0.74f, 0.77f, 0.81f, 1);
    const auto corner = [&](std::size_t k) {
      return ImVec2(at.x + side * t.corners[k][0], at.y + side * t.corners[k][1]);
    };
    draw->AddTriangleFilled(corner(0), corner(1), corner(2),
                            ImGui::GetColorU32({base.x * light, base.y * light, base.z * light, 1}));
  }
  draw->PopClipRect();
  draw->Flags = before;
}

// Toggles a favourite on a click.
void drawStar(AppContext& context, const Tool& tool, bool is_favourite) {
  constexpr int kPoints = 5;
  constexpr float kInner = 0.42f;
  const float side = scaled(kIcon), width = scaled(kStar), radius = 0.5f * width - scaled(2);
  const ImVec2 at = ImGui::GetCursorScreenPos(), middle{at.x + 0.5f * width, at.y + 0.5f * side};
  if (ImGui::InvisibleButton("##star", {width, side}))
    if (const auto done = runAppCommand(context, "tool.favourite", std::vector<std::string>{tool.id}); !done)
      context.bench.notices->complain(done.error());
  const bool is_hovered = ImGui::IsItemHovered();
  if (is_hovered) ui::setTooltip(is_favourite ? "Remove from favourites" : "Add to favourites at the top");

  std::array<ImVec2, 2 * kPoints> corners;
  for (std::size_t n = 0; n < corners.size(); ++n) {
    const float angle = static_cast<float>(n) * std::numbers::pi_v<float> / kPoints;
    const float r = n % 2 == 0 ? radius : kInner * radius;
    corners[n] = {middle.x + r * std::sin(angle), middle.y - r * std::cos(angle)};
  }
  ImDrawList* const draw = ImGui::GetWindowDrawList();
  const ImU32 colour = ImGui::GetColorU32(is_favourite || is_hovered ? styleColours().warning : styleColours().quiet);
  if (is_favourite)
    for (std::size_t n = 0; n < corners.size(); ++n)
      draw->AddTriangleFilled(middle, corners[n], corners[(n + 1) % corners.size()], colour);
  draw->AddPolyline(corners.data(), static_cast<int>(corners.size()), colour, ImDrawFlags_Closed, scaled(1));
  ImGui::SameLine(0, scaled(2));
}

/// @return  true on a click.
bool drawRow(AppContext& context, ToolPanelState& state, const RackView& view, std::size_t n) {
  const Workbench& bench = context.bench;
  const Tool& tool = bench.tools->at(n);
  const float side = scaled(kIcon);
  ImGui::PushID(static_cast<int>(n));
  const float right = ImGui::GetCursorScreenPos().x + ImGui::GetContentRegionAvail().x;
  if (context.settings) drawStar(context, tool, isFavourite(view, tool));
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const bool is_clicked = ui::selectable("##tool", n == bench.tools->inHand(), 0, {0, side});
  const Error* const error = bench.tools->error(n);
  if (ImGui::IsItemHovered())
    ui::setTooltip(fmt::format("{}\n{}{}{}{}{}", tool.id, tool.description, tool.iso6360.empty() ? "" : "\nISO 6360 ",
                               tool.iso6360,
                               error ? "\n"
                                       "The rack still has the last readable version: "
                                     : "",
                               error ? error->message() : ""));

  auto icon = state.icons.find(tool.cut.get());
  if (icon == state.icons.end()) icon = state.icons.emplace(tool.cut.get(), toolIcon(tool)).first;
  drawIcon(icon->second, at, side);
  const float line = ImGui::GetTextLineHeight();
  ImDrawList* const draw = ImGui::GetWindowDrawList();
  const std::string size = sizeOf(tool);
  const float size_at = right - ui::textSize(size).x;
  const RowName name = shownName(tool);
  const ImU32 ink = error ? ImGui::GetColorU32(styleColours().warning) : ImGui::GetColorU32(ImGuiCol_Text);
  const float top = at.y + 0.5f * (side - line);
  float left = at.x + side + scaled(8);
  if (!name.number.empty()) {
    ui::addText(*draw, {left, top}, ink, ui::asItIs(name.number));
    left += ui::textSize(ui::asItIs(name.number)).x + scaled(6);
  }
  ui::addText(*draw, {left, top}, name.number.empty() ? ink : ImGui::GetColorU32(styleColours().quiet),
              ui::asItIs(ui::beginThatFits(name.words, size_at - scaled(6) - left)));
  ui::addText(*draw, {size_at, at.y + 0.5f * (side - line)}, ImGui::GetColorU32(styleColours().quiet), size);
  ImGui::PopID();
  return is_clicked;
}

// A tool file with errors.
void drawBroken(const BrokenTool& broken) {
  const float side = scaled(kIcon), line = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImGui::PushID(broken.file.c_str());
  ui::selectable("##broken", false, 0, {0, side});
  if (ImGui::IsItemHovered()) ui::setTooltip(broken.error.message());
  const std::string text = phrase("{}: not readable as a tool", broken.file.filename().string());
  ui::addText(*ImGui::GetWindowDrawList(), {at.x + scaled(8), at.y + 0.5f * (side - line)},
              ImGui::GetColorU32(styleColours().warning), text);
  ImGui::PopID();
}

/// @return  the clicked tool. Taking it may close the document, so draw no part of that afterwards.
std::optional<std::size_t> drawRack(AppContext& context, ToolPanelState& state) {
  Workbench& bench = context.bench;
  ImGui::PushItemWidth(-1);
  const std::string hint = phrase("Search {} tools: round, 1.4, saw...", bench.tools->count());
  ui::inputTextWithHint("##search", ui::asItIs(ui::beginThatFits(hint, ImGui::GetContentRegionAvail().x - scaled(12))),
                        state.search.data(), state.search.size());
  ImGui::PopItemWidth();

  RackView view{.search = state.search.data(), .shows_all = state.shows_all};
  std::vector<std::string> favourites;  // a click on a star changes the settings' favourites
  if (context.settings) favourites = context.settings->values.favourite_tools;
  view.favourites = favourites;
  const std::vector<std::size_t> rows = rackRows(bench, view);
  const std::size_t broken = view.search.empty() ? bench.tools->broken().size() : 0;
  const float row = scaled(kIcon) + scaled(kRowGap);
  const auto shown = static_cast<float>(std::clamp<std::size_t>(rows.size() + broken, 1, kToolRows));
  ImGui::BeginChild("rack", {0, shown * row + scaled(4)});
  if (state.in_hand != bench.tools->inHand()) {
    state.in_hand = bench.tools->inHand();
    const auto at =
        static_cast<std::ptrdiff_t>(broken) + (std::find(rows.begin(), rows.end(), state.in_hand) - rows.begin());
    const float top = static_cast<float>(at) * row;
    if (top < ImGui::GetScrollY() || top + row > ImGui::GetScrollY() + shown * row) ImGui::SetScrollY(top);
  }
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {scaled(8), scaled(kRowGap)});
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(rows.size() + broken), row);
  std::optional<std::size_t> clicked;
  while (clipper.Step())
    for (auto n = static_cast<std::size_t>(clipper.DisplayStart); n < static_cast<std::size_t>(clipper.DisplayEnd); ++n)
      if (n < broken)
        drawBroken(bench.tools->broken()[n]);
      else if (drawRow(context, state, view, rows[n - broken]))
        clicked = rows[n - broken];
  ImGui::PopStyleVar();
  if (rows.empty() && broken == 0) ui::textDisabled("No tool matches");
  ImGui::EndChild();

  if (bench.tools->firstLook() < bench.tools->count() && !state.search[0]) {
    const std::string label = state.shows_all ? shownText("Show fewer") : phrase("Show all {}", bench.tools->count());
    if (ui::smallButton(label + "###all")) state.shows_all = !state.shows_all;
  }
  return clicked;
}

// Shown if there are structures to keep.
void drawStopShort(AppContext& context) {
  const Workbench& bench = context.bench;
  if (bench.document->structures()->isEmpty()) return;
  bool is_on = bench.strokes->stop_short_mm.has_value();
  std::string names;
  for (const Structures::Structure& s : bench.document->structures()->all())
    names += (names.empty() ? "" : ", ") + shownText(bench.document->nameOf(s.material));
  if (ui::checkbox(phrase("Stop short of {}", names) + "###short", &is_on))
    runIfEnabled(context, "cut.stop-short", is_on ? std::vector<std::string>{} : std::vector<std::string>{"off"});
  if (!is_on) return;
  auto short_of = static_cast<float>(*bench.strokes->stop_short_mm);
  if (ui::sliderFloat("##short_of", &short_of, 0, 2, "%.1f mm", ImGuiSliderFlags_AlwaysClamp))
    runIfEnabled(context, "cut.stop-short", wordsOf({0.1 * std::round(10 * static_cast<double>(short_of))}));
}

// Tilt of the tool; shown while it leans.
void drawTilt(AppContext& context) {
  const Tilt& tilt = context.bench.strokes->tilt;
  if (tilt.isUpright()) return;
  constexpr double kDegree = std::numbers::pi / 180;
  ui::text(phrase("Tilt {:.0f} deg, towards {:.0f} deg", tilt.angle / kDegree,
                  azimuthInView(context.camera, tilt) / kDegree));
  ImGui::SameLine();
  if (ui::smallButton("Reset")) runIfEnabled(context, "tool.tilt-reset");
}

// The axis of all strokes, while it is held, and where it can be taken from.
void drawAxis(AppContext& context) {
  const std::optional<Vec3d>& axis = context.bench.strokes->heldAxis();
  bool is_held = axis.has_value();
  const bool is_clicked = ui::checkbox("Hold axis", &is_held), is_hovered = ImGui::IsItemHovered();
  if (const Tool& tool = context.bench.tools->held(); tool.kind == ToolKind::kBur && tool.cuts_end) {
    ui::sameLineFor("Drill holes (D)");
    if (ui::smallButton("Drill holes (D)")) runIfEnabled(context, "drill.plan");
  }
  if (is_clicked) return runIfEnabled(context, "tool.hold-axis", std::vector<std::string>{is_held ? "tool" : "off"});
  if (is_hovered) ui::setTooltip("Keeps the tool's axis for all strokes: one path of insertion (A)");
  if (!axis) return;
  constexpr double kDegree = std::numbers::pi / 180;
  const auto& occlusal = context.bench.document->occlusal().normal;
  const double lean = std::acos(std::clamp(axis->dot(occlusal.value_or(Vec3d::UnitZ())), -1.0, 1.0)) / kDegree;
  const std::string value = shownNumbers("{:.3f}, {:.3f}, {:.3f}", (*axis)[0], (*axis)[1], (*axis)[2]);
  ui::text(occlusal ? phrase("{:.1f} deg from occlusal: {}", lean, value)
                    : phrase("{:.1f} deg from z: {}", lean, value));
  std::optional<std::string> from;
  if (ui::smallButton("Tool axis")) from = "tool";
  ui::sameLineFor("View axis");
  if (ui::smallButton("View axis")) from = "view";
  if (occlusal) ui::sameLineFor("Occlusal axis");
  if (occlusal && ui::smallButton("Occlusal axis")) from = "occlusal";
  if (from) runIfEnabled(context, "tool.hold-axis", std::vector<std::string>{*from});
}

// Shown for a thin bur on coarse voxels.
void drawFinerVoxels(AppContext& context) {
  const auto finer = context.bench.tools->finerVoxels();
  if (!finer) return;
  ImGui::PushStyleColor(ImGuiCol_Text, styleColours().warning);
  ui::textWrapped(phrase("Voxels of {:.2f} mm leave steps at the margin of this bur.", finer->now_mm));
  ImGui::PopStyleColor();
  if (ui::smallButton(ui::asItIs(phrase("Use {:.2g} mm: about {:.0f} s, {:.1f} GB", finer->mm,
                                        std::ceil(finer->seconds), 1e-9 * finer->bytes))))
    runIfEnabled(context, "tool.finer-voxels");
  if (ImGui::IsItemHovered())
    ui::setTooltip("Prepares the scan again and opens it without cuts. This session stays in the list.");
}

void drawToolHand(AppContext& context) {
  const Workbench& bench = context.bench;
  ImGui::PushItemWidth(-1);
  float force = static_cast<float>(bench.strokes->force), depth = static_cast<float>(bench.strokes->depth_mm);
  float speed = static_cast<float>(100 * bench.strokes->speed);
  float spray = static_cast<float>(100 * bench.strokes->irrigation);
  ui::text("Push");
  if (ui::sliderFloat("##force", &force, static_cast<float>(Strokes::kLeastForce), 5, "%.1f N",
                      ImGuiSliderFlags_AlwaysClamp))
    runIfEnabled(context, "cut.force", wordsOf({static_cast<double>(force)}));
  ui::text("Depth below the surface");
  if (ui::sliderFloat("##depth", &depth, 0, static_cast<float>(bench.strokes->mostDepth()), "%.2f mm",
                      ImGuiSliderFlags_AlwaysClamp))
    runIfEnabled(context, "cut.depth", wordsOf({std::min(static_cast<double>(depth), bench.strokes->mostDepth())}));
  drawStopShort(context);
  ui::text("Spindle speed");
  if (ui::sliderFloat("##speed", &speed, 0, 100, "%.0f %%", ImGuiSliderFlags_AlwaysClamp))
    runIfEnabled(context, "cut.speed", wordsOf({static_cast<double>(speed)}));
  bool is_reversed = bench.strokes->isReversed();
  if (bench.strokes->canReverse() && ui::checkbox("Reverse drive", &is_reversed))
    runIfEnabled(context, "cut.reverse", std::vector<std::string>{is_reversed ? "on" : "off"});
  ui::text("Irrigation");
  if (ui::sliderFloat("##spray", &spray, 0, 100, "%.0f %%", ImGuiSliderFlags_AlwaysClamp))
    runIfEnabled(context, "cut.irrigation", wordsOf({static_cast<double>(spray)}));
  ImGui::PopItemWidth();
}

}  // namespace

void drawTools(AppContext& context, ToolPanelState& state) {
  const std::optional<std::size_t> clicked = drawRack(context, state);
  ImGui::Separator();
  drawFinerVoxels(context);
  drawTilt(context);
  drawAxis(context);
  drawToolHand(context);
  if (clicked) runIfEnabled(context, "tool.select", std::vector<std::string>{context.bench.tools->wordFor(*clicked)});
}

}  // namespace kerf
