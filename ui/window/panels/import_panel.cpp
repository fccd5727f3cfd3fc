#include "ui/window/panels/import_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "ui/app/base/language.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/import/import_guides.h"
#include "ui/app/import/import_set.h"
#include "ui/app/workbench/imports.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"
#include "ui/window/panels/import_trim.h"

namespace kerf {
namespace {

using Way = ClosingChoice::Way;

struct WayRow {
  Way way;
  const char* name;
  const char* text;
};
constexpr std::array<WayRow, 4> kWays = {{
    {Way::kAutomatic, "Automatic",
     "Fills holes and adds a base if the underside is missing. If this fails, Kerf wraps the scan and reports it."},
    {Way::kBase, "Base", "Adds a base to the longest boundary, whatever its length."},
    {Way::kHolesOnly, "Holes only", "Fills holes. Rejects a scan without an underside."},
    {Way::kWrap, "Shrink-wrap",
     "Lays a new surface around the scan: an approximation, for scans that nothing else closes."},
}};

void runImport(AppContext& context, const char* id, std::vector<std::string> words = {}) {
  if (const auto done = runAppCommand(context, id, words); !done) context.bench.notices->complain(done.error());
}

// ---- Findings

void drawFindings(const std::vector<Finding>& findings) {
  const StyleColours& colours = styleColours();
  for (const Finding& finding : findings) {
    const bool is_doubtful = finding.weight == Finding::Weight::kDoubtful;
    const ImVec4 colour = is_doubtful                                  ? colours.warning
                          : finding.weight == Finding::Weight::kMended ? colours.accent
                                                                       : colours.good;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float radius = scaled(4), half = 0.5f * ImGui::GetTextLineHeight();
    ImGui::GetWindowDrawList()->AddCircleFilled({at.x + radius, at.y + half}, radius,
                                                ImGui::ColorConvertFloat4ToU32(colour), 16);
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + scaled(16));
    ui::textColored(colours.quiet, finding.about);
    ui::sameLineAt(scaled(96));
    ImGui::PushTextWrapPos(0);
    is_doubtful ? ui::textColored(colours.warning, finding.text) : ui::text(finding.text);
    ImGui::PopTextWrapPos();
  }
}

// ---- Choices

void drawUnit(AppContext& context, const ImportPlan& plan, const UnitOption& option) {
  const auto length = [](double mm) {
    return mm < 1 || mm >= 1e4 ? shownNumbers("{:.3g}", mm) : shownNumbers("{:.1f}", mm);
  };
  const std::string label = fmt::format("{}###unit-{}", option.unit, option.unit);
  if (ui::radioButton(label, option.unit == plan.unit().unit)) runImport(context, "import.unit", {option.unit});

  ui::sameLineAt(scaled(96));
  const Vec3d& s = option.size_mm;
  const std::string size = fmt::format("{} x {} x {} mm", length(s[0]), length(s[1]), length(s[2]));
  option.is_plausible ? ui::text(size) : ui::textColored(styleColours().warning, size + shownText(": not dental"));
}

// Likely units; the others are a click away.
void drawUnits(AppContext& context, const ImportPlan& plan) {
  heading("Unit of the file");
  const auto isNear = [&](const UnitOption& option) { return option.is_plausible || option.unit == plan.unit().unit; };
  for (const UnitOption& option : plan.units())
    if (isNear(option)) drawUnit(context, plan, option);
  if (std::all_of(plan.units().begin(), plan.units().end(), isNear) || !ui::treeNode("Other units")) return;
  for (const UnitOption& option : plan.units())
    if (!isNear(option)) drawUnit(context, plan, option);
  ImGui::TreePop();
}

void drawClosing(AppContext& context, ImportPlan& plan) {
  heading("Closing");
  ClosingChoice choice = plan.closing();
  const auto row = std::find_if(kWays.begin(), kWays.end(), [&](const WayRow& r) { return r.way == choice.way; });
  ImGui::SetNextItemWidth(-1);
  if (ui::beginCombo("##way", row->name)) {
    for (const WayRow& r : kWays) {
      if (ui::selectable(r.name, r.way == choice.way)) choice.way = r.way;
      ImGui::PushTextWrapPos(scaled(330));
      ui::textColored(styleColours().quiet, r.text);
      ImGui::PopTextWrapPos();
    }
    ImGui::EndCombo();
  }

  const bool has_base = plan.isWithoutUnderside() && choice.way != Way::kHolesOnly;
  if (has_base) {
    if (ui::radioButton("Horseshoe", !choice.is_full_base)) choice.is_full_base = false;
    if (ImGui::IsItemHovered()) ui::setTooltip("The walls of the base follow the rim of the scan.");
    ImGui::SameLine();
    if (ui::radioButton("Full plate", choice.is_full_base)) choice.is_full_base = true;
    if (ImGui::IsItemHovered()) ui::setTooltip("The arch stands on a plate, with a floor in the tongue area.");
    float base = static_cast<float>(choice.base_mm);
    ImGui::SetNextItemWidth(-1);
    if (ui::sliderFloat("##base", &base, static_cast<float>(ImportPlan::kThinnestBase), 15,
                        "base %.1f mm below the scan", ImGuiSliderFlags_AlwaysClamp))
      choice.base_mm = 0.1 * std::round(10 * static_cast<double>(base));
    if (!choice.is_full_base) {
      float smooth = static_cast<float>(choice.smooth_mm);
      ImGui::SetNextItemWidth(-1);
      if (ui::sliderFloat("##smooth", &smooth, 0, static_cast<float>(ImportPlan::kSmoothest),
                          smooth > 0 ? "walls smooth over %.0f mm" : "walls straight under the rim",
                          ImGuiSliderFlags_AlwaysClamp))
        choice.smooth_mm = std::round(static_cast<double>(smooth));
    }
    float trim = static_cast<float>(choice.trim_rim_mm);
    ImGui::SetNextItemWidth(-1);
    if (ui::sliderFloat("##trim-rim", &trim, 0, static_cast<float>(ImportPlan::kWidestRimTrim),
                        trim > 0 ? "rim trimmed of tongues under %.1f mm" : "rim as scanned",
                        ImGuiSliderFlags_AlwaysClamp))
      choice.trim_rim_mm = 0.1 * std::round(10 * static_cast<double>(trim));
    if (ImGui::IsItemHovered()) ui::setTooltip("Removes tongues and flakes of the rim narrower than this.");
    if (plan.found().has_occlusal_plane)
      ui::checkbox("Base parallel to the occlusal plane", &choice.follows_occlusal_plane);
    else
      ui::textColored(styleColours().quiet, "No occlusal plane found: too few cusp tips.");
  }
  if (choice.way == Way::kWrap) {
    float wrap = static_cast<float>(choice.wrap_mm);
    ImGui::SetNextItemWidth(-1);
    if (ui::sliderFloat("##wrap", &wrap, static_cast<float>(ImportPlan::kFinestWrap),
                        static_cast<float>(ImportPlan::kCoarsestWrap), "bridge gaps up to %.1f mm",
                        ImGuiSliderFlags_AlwaysClamp))
      choice.wrap_mm = 0.1 * std::round(10 * static_cast<double>(wrap));
  }
  if (!plan.check().isClosed() && choice.way != Way::kBase) {
    bool is_given = choice.holes_up_to_mm.has_value();
    if (ui::checkbox("Set the hole size limit", &is_given))
      choice.holes_up_to_mm = is_given ? std::optional(20.0) : std::nullopt;
    if (choice.holes_up_to_mm) {
      float most = static_cast<float>(*choice.holes_up_to_mm);
      ImGui::SetNextItemWidth(-1);
      if (ui::sliderFloat("##holes", &most, 1, 500, "holes up to %.0f mm around",
                          ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic))
        choice.holes_up_to_mm = static_cast<double>(most);
    }
  }
  if (const auto done = plan.setClosing(choice); !done) context.bench.notices->complain(done.error());
}

// For a scan's plan and for a label volume.
template <class Plan>
void drawVoxel(Plan& plan, bool is_own) {
  heading("Voxel size");
  float voxel = static_cast<float>(plan.voxel());
  ImGui::SetNextItemWidth(is_own ? -scaled(90) : -1);
  if (ui::sliderFloat("##voxel", &voxel, 0.05f, 0.3f, "%.2f mm", ImGuiSliderFlags_AlwaysClamp))
    (void)plan.setVoxel(0.01 * std::round(100 * static_cast<double>(voxel)));
  if (is_own) {
    ImGui::SameLine();
    if (ui::button("Suggest", {-1, 0})) (void)plan.setVoxel(0);
  }
}

// For all files together.
void drawPrediction(const ImportSet& set) {
  const Prediction p = set.prediction();
  if (p.bytes <= 0) return;
  const bool is_too_much = set.freeBytes() > 0 && p.bytes > set.freeBytes();
  const std::string text = phrase("about {:.0f} s to prepare{}, {:.1f} GB of memory{}", std::ceil(p.seconds),
                                  shownText(set.isSeveral() ? " all" : ""), 1e-9 * p.bytes,
                                  is_too_much ? phrase(": only {:.1f} GB are free", 1e-9 * set.freeBytes()) : "");
  ImGui::PushTextWrapPos(0);
  ui::textColored(is_too_much ? styleColours().warning : styleColours().quiet, text);
  ImGui::PopTextWrapPos();
}

// ---- Several files

struct RoleRow {
  ImportRole role;
  const char* word;  // of the command
  const char* text;
};
constexpr std::array<RoleRow, 4> kRoles = {{{ImportRole::kCut, "cut", "object to cut"},
                                            {ImportRole::kBeside, "beside", "neighbour"},
                                            {ImportRole::kTool, "tool", "tool"},
                                            {ImportRole::kOut, "out", "skipped"}}};

// Use of a single dropped file.
void drawRole(AppContext& context, const ImportEntry& entry) {
  if (!entry.scan) return;
  const auto choice = [&](ImportRole role, const char* word, const char* text) {
    if (ImportRole now = entry.role; ui::radioButton(text, now == role) && now != role)
      runImport(context, "import.role", {"1", word});
  };
  choice(ImportRole::kCut, "cut", "Cut this");
  ImGui::SameLine();
  if (context.bench.document->isOpen()) {
    choice(ImportRole::kBeside, "beside", "Add as neighbour");
    if (ImGui::IsItemHovered())
      ui::setTooltip(phrase("Neighbour of {}, at its scan position.", context.bench.document->name()));
    ImGui::SameLine();
  }
  choice(ImportRole::kTool, "tool", "Use as tool");
}

// ---- Import of a mesh as a tool

void drawTool(AppContext& context, ToolPlan& plan) {
  heading("Tool");
  drawFindings(plan.findings());
  ImGui::SetNextItemWidth(-1);
  const ToolWay& now = plan.way();
  if (ui::beginCombo("##way", phrase("Shank towards {}", now.name))) {
    for (const ToolWay& way : plan.ways()) {
      const std::string text = phrase("{}: {:.3g} mm wide at the tip", way.name, way.tip_width_mm);
      if (ui::selectable(text, way.name == now.name)) runImport(context, "import.tool-axis", {way.name});
    }
    ImGui::EndCombo();
  }
  auto cut = static_cast<float>(plan.cutBelow());
  ImGui::SetNextItemWidth(-1);
  if (ui::sliderFloat("##cut", &cut, static_cast<float>(ToolPlan::kLeastCut), 20, "cutting part: %.1f mm from tip",
                      ImGuiSliderFlags_AlwaysClamp))
    runImport(context, "import.tool-cut", {fmt::format("{:.1f}", cut)});
}

void drawFiles(AppContext& context, const ImportSet& set) {
  heading("Files");
  for (std::size_t n = 0; n < set.entries().size(); ++n) {
    const ImportEntry& entry = set.entries()[n];
    const std::string number = std::to_string(n + 1);
    ImGui::PushID(static_cast<int>(n));
    const std::string name = entry.file.filename().string();
    const float width = ImGui::GetContentRegionAvail().x - scaled(132);
    if (ui::selectable(ui::asItIs(name), n == set.chosen(), 0, {width, 0}))
      runImport(context, "import.choose", {number});
    if (ImGui::IsItemHovered()) ui::setTooltip(ui::asItIs(shownText(entry.what()) + ": " + entry.file.string()));
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1);
    const auto row = std::find_if(kRoles.begin(), kRoles.end(), [&](const RoleRow& r) { return r.role == entry.role; });
    if (ui::beginCombo("##role", row->text)) {
      for (const RoleRow& r : kRoles)
        if (ui::selectable(r.text, r.role == entry.role)) runImport(context, "import.role", {number, r.word});
      ImGui::EndCombo();
    }
    ImGui::PopID();
  }
  drawFindings(set.findings());
}

// ---- Labels of a CT

ImVec4 importColourOf(const MaterialProperties* material) {
  if (!material) return {0, 0, 0, 0};
  const Rgba8& c = material->color;
  return {static_cast<float>(c[0]) / 255, static_cast<float>(c[1]) / 255, static_cast<float>(c[2]) / 255, 1};
}

void drawLabel(AppContext& context, const LabelPlan& plan, const LabelFound& label) {
  const auto tissue = plan.tissue(label.label);
  const MaterialProperties* const material = tissue ? plan.materials().find(*tissue) : nullptr;
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::ColorButton("##colour", importColourOf(material),
                     ImGuiColorEditFlags_NoTooltip | ImGuiColorEditFlags_AlphaPreview, {scaled(14), scaled(14)});
  ImGui::SameLine();
  ui::text(ui::asItIs(label.called()));
  if (ImGui::IsItemHovered()) ui::setTooltip(phrase("label {}, {}", label.label, label.called()));

  ImGui::TableNextColumn();
  const std::string volume = shownNumbers("{:.4g} mm3", label.volume_mm3);
  ui::text(volume);

  ImGui::TableNextColumn();
  ImGui::SetNextItemWidth(-1);
  const std::string number = std::to_string(label.label);
  if (!ui::beginCombo("##tissue", material ? material->name : std::string("skipped"))) return;
  for (const MaterialProperties& row : plan.materials().rows())
    if (ui::selectable(row.name, &row == material)) runImport(context, "import.tissue", {number, row.id});
  if (ui::selectable("skipped", !material)) runImport(context, "import.tissue", {number, "none"});
  ImGui::EndCombo();
}

void drawLabels(AppContext& context, const LabelPlan& plan) {
  heading("Tissues");
  constexpr std::size_t kMostRows = 9;  // scroll to the others
  const float row = ImGui::GetFrameHeightWithSpacing();
  const float height = row * static_cast<float>(std::min(plan.found().labels.size(), kMostRows)) + scaled(4);
  if (!ImGui::BeginTable("labels", 3, ImGuiTableFlags_ScrollY | ImGuiTableFlags_SizingStretchProp, {0, height})) return;
  ImGui::TableSetupColumn("name", 0, 1.2f);
  ImGui::TableSetupColumn("volume", 0, 0.8f);
  ImGui::TableSetupColumn("tissue", 0, 1.2f);
  for (const LabelFound& label : plan.found().labels) {
    ImGui::PushID(label.label);
    drawLabel(context, plan, label);
    ImGui::PopID();
  }
  ImGui::EndTable();
}

// ---- The closed solid

void drawVerdict(const ImportSet& set, const ClosedPreview& preview) {
  const StyleColours& colours = styleColours();
  if (set.labels())
    ui::textColored(colours.good, phrase("Smooth, {:.0f} mm3 in {:.0f} mm2. Every label keeps its volume.",
                                         preview.volume_mm3, preview.area_mm2));
  else if (preview.is_exact)
    ui::textColored(colours.good,
                    phrase("Closed, {:.0f} mm3. Every scanned point keeps its position.", preview.volume_mm3));
  else
    ui::textColored(colours.warning,
                    phrase("Closed, {:.0f} mm3. Approximation: keeps no scanned point.", preview.volume_mm3));
}

void drawPreview(AppContext& context, ImportSet& set, PreviewedPlan& plan, ImportPanelState& state) {
  const StyleColours& colours = styleColours();
  heading("Preview");
  if (const AnyJob* const job = plan.previewJob()) {
    const JobStatus s = job->status();
    ui::progressBar(static_cast<float>(s.done), {-scaled(90), 0}, s.step);
    ImGui::SameLine();
    if (ui::button("Stop", {-1, 0})) plan.cancelPreview();
    return;
  }
  if (plan.previewError()) {
    ImGui::PushTextWrapPos(0);
    ui::textColored(colours.warning, phrase("Closing failed; try another method: {}", plan.previewError()->message()));
    ImGui::PopTextWrapPos();
    return;
  }
  const ClosedPreview* const preview = plan.preview();
  if (!preview) {
    if (ui::button(set.labels() ? "Show surface" : "Show closed solid", {-1, 0})) runImport(context, "import.preview");
    return;
  }

  if (set.scan()) {
    if (ui::radioButton("Closed solid", state.shows_solid)) state.shows_solid = true;
    ImGui::SameLine();
    if (ui::radioButton(set.scan()->trimmed() ? "Cut scan" : "Scan as read", !state.shows_solid))
      state.shows_solid = false;
    ImGui::SameLine();
  }
  ui::checkbox("Guides", &state.shows_guides);
  ImGui::PushTextWrapPos(0);
  drawVerdict(set, *preview);
  for (const std::string& warning : preview->warnings) ui::textColored(colours.warning, warning);
  ImGui::PopTextWrapPos();
  const std::string about = (set.labels() ? phrase("Smoothing steps: {}", preview->changes.size())
                                          : phrase("Closing steps: {}", preview->changes.size())) +
                            "###changes";
  if (!preview->changes.empty() && ui::treeNode(about)) {
    ImGui::PushTextWrapPos(0);
    for (const std::string& change : preview->changes) ui::bulletText(change);
    ImGui::PopTextWrapPos();
    ImGui::TreePop();
  }
}

// ---- Over the picture

struct Projection {
  const Camera& camera;
  int width, height;
  double pixels;
  ImVec2 operator()(const Vec3d& p) const {
    const auto at = pixelOf(camera, p, width, height);
    return {static_cast<float>(at[0] / pixels), static_cast<float>(at[1] / pixels)};
  }
};

void drawWords(ImDrawList& list, const ImVec2& at, const std::string& text) {
  const ImVec2 size = ui::textSize(text);
  const ImVec2 from{at.x - 0.5f * size.x - 5, at.y - 0.5f * size.y - 2},
      to{at.x + 0.5f * size.x + 5, at.y + 0.5f * size.y + 2};
  ImVec4 back = ImGui::GetStyleColorVec4(ImGuiCol_WindowBg);
  back.w = 0.85f;
  list.AddRectFilled(from, to, ImGui::ColorConvertFloat4ToU32(back), 3);
  ui::addText(list, {at.x - 0.5f * size.x, at.y - 0.5f * size.y}, styleColours().guide_text, text);
}

// A rectangle of the plane, as wide as the box.
void drawPlane(ImDrawList& list, const Projection& at, const Plane& plane, const Box3& box, const char* name,
               ImU32 line) {
  const std::array<Vec3d, 4> rectangle = rectangleOf(plane, box);
  std::array<ImVec2, 4> corners;
  std::transform(rectangle.begin(), rectangle.end(), corners.begin(), at);
  list.AddPolyline(corners.data(), 4, line, ImDrawFlags_Closed, 2);
  const ImVec2 high =
      *std::min_element(corners.begin(), corners.end(), [](const ImVec2& a, const ImVec2& b) { return a.y < b.y; });
  drawWords(list, {high.x, high.y - scaled(14)}, name);
}

}  // namespace

void drawImportPanel(AppContext& context, ImportPanelState& state) {
  ImportSet* const set = context.bench.imports->set();
  if (!set || context.bench.jobs->running()) return;
  const FrameArea at = frameLayout(context).right;
  ImGui::SetNextWindowPos({at.left, at.top}, ImGuiCond_Always);
  ImGui::SetNextWindowSize({at.width(), at.height()}, ImGuiCond_Always);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0);
  ui::begin("##import", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove);
  ImGui::PopStyleVar();

  const ImportEntry& chosen = set->entries()[set->chosen()];
  ImGui::SetWindowFontScale(1.2f);
  ui::text(ui::asItIs(chosen.file.filename().string()));
  ImGui::SetWindowFontScale(1);
  ui::textColored(styleColours().quiet,
                  set->isSeveral() ? "Kerf never changes these files." : "Kerf never changes this file.");
  ImGui::BeginChild("choices", {0, -scaled(46)});
  ImGui::Dummy({0, scaled(2)});
  if (set->isSeveral()) {
    drawFiles(context, *set);
    heading(ui::asItIs(chosen.file.filename().string()));
  }
  ImGui::PushID(static_cast<int>(set->chosen()));
  if (ImportPlan* const plan = set->scan()) {
    drawFindings(plan->findings());
    if (!set->isSeveral()) drawRole(context, chosen);
    drawUnits(context, *plan);
    if (ToolPlan* const tool = set->tool()) drawTool(context, *tool);
    if (!set->tool()) drawTrims(context, *plan);
    drawClosing(context, *plan);
    if (!set->tool()) drawVoxel(*plan, plan->choice().voxel_mm > 0);
  } else if (LabelPlan* const labels = set->labels()) {
    drawFindings(labels->findings());
    drawLabels(context, *labels);
    drawVoxel(*labels, labels->hasOwnVoxel());
  } else {
    ui::textWrapped(phrase("A {}: it has no import settings.", shownText(chosen.what())));
  }
  ImGui::PopID();
  drawPrediction(*set);
  if (set->plan()) drawPreview(context, *set, *set->plan(), state);
  ImGui::EndChild();

  const float width = ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x;
  const char* const go = set->cut() ? "Prepare and cut" : set->tool() ? "Create tool" : "Prepare";
  if (strongButton(go, "Enter", 0.64f * width)) runImport(context, "import.start");
  ImGui::SameLine();
  if (plainButton("Cancel", "Esc", -1)) runImport(context, "import.cancel");
  ImGui::End();
}

void drawImportGuides(const AppContext& context, double pixels) {
  const ImportSet* const set = context.bench.imports->set();
  if (!set) return;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const Projection at{context.camera, context.width, context.height, pixels};
  const StyleColours& colours = styleColours();
  const Box3 box = set->scan() ? set->scan()->boxMm() : set->labels() ? set->labels()->found().box : Box3();
  if (box.isEmpty()) return;

  // The box and its sizes: each at that edge of its direction that is lowest in the picture.
  for (int axis = 0; axis < 3; ++axis) {
    ImVec2 lowest{0, -1e9f};
    for (int n = 0; n < 8; ++n) {
      if (n & (1 << axis)) continue;
      const ImVec2 a = at(box.corner(n)), b = at(box.corner(n | (1 << axis)));
      list.AddLine(a, b, colours.guide, 1);
      const ImVec2 middle{0.5f * (a.x + b.x), 0.5f * (a.y + b.y)};
      if (middle.y > lowest.y) lowest = middle;
    }
    drawWords(list, lowest, shownNumbers("{:.1f} mm", box.size()[axis]));
  }

  if (const ToolPlan* const tool = set->tool()) {
    const ToolWay& way = tool->way();
    const double length = 0.5 * box.size().norm();
    const auto radius = static_cast<float>(scaled(4));
    list.AddLine(at(way.tip), at(way.tip + length * way.axis), colours.guide, 2);
    list.AddCircleFilled(at(way.tip), radius, colours.guide, 16);
    list.AddCircle(at(way.tip + tool->cutBelow() * way.axis), radius, colours.guide, 16, 2);
    const ImVec2 tip = at(way.tip);
    drawWords(list, {tip.x, tip.y + scaled(14)}, "tip");
    return;
  }
  const ClosedPreview* const preview = set->preview();
  if (!preview) return;
  if (preview->occlusal_plane)
    drawPlane(list, at, *preview->occlusal_plane, box, "occlusal plane", IM_COL32(214, 120, 40, 220));
  if (preview->base_direction) {
    const Plane base{*preview->base_direction * preview->base_level_mm, *preview->base_direction};
    drawPlane(list, at, base, box, "base", IM_COL32(30, 110, 170, 220));
  }
}

}  // namespace kerf
