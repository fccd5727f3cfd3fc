#include "ui/window/frame/timeline_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/tools.h"
#include "ui/window/frame/frame_layout.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr float kStripHeight = 38, kBlockHeight = 18, kWidestBlock = 26;  // before scaled()

bool hasSteps(const AppContext& context) {
  const Workbench& bench = context.bench;
  if (!bench.document->isOpen() || bench.imports->isImporting()) return false;
  return !bench.steps->timeline().steps().empty() || bench.steps->branchCount() > 0;
}

ImVec4 colourOf(TimelineStep::Kind kind) {
  const StyleColours& colours = styleColours();
  switch (kind) {
    case TimelineStep::Kind::kStroke:
      return colours.accent;
    case TimelineStep::Kind::kMove:
    case TimelineStep::Kind::kDelete:
      return colours.quiet;
    case TimelineStep::Kind::kPlannedCut:
    case TimelineStep::Kind::kHole:
    case TimelineStep::Kind::kPlaneCut:
      return colours.good;
  }
  return colours.quiet;
}

// Undone steps are pale.
void drawBlocks(const Timeline& timeline, std::size_t done, const ImVec2& corner, float width) {
  const float height = scaled(kBlockHeight), gap = width > 4 ? 1.0f : 0.0f;
  ImDrawList* const list = ImGui::GetWindowDrawList();
  for (std::size_t n = 0; n < timeline.steps().size(); ++n) {
    ImVec4 colour = colourOf(timeline.steps()[n].kind);
    if (n >= done) colour.w *= 0.35f;
    const float x = corner.x + width * static_cast<float>(n);
    list->AddRectFilled({x + gap, corner.y}, {x + width - gap, corner.y + height}, ImGui::GetColorU32(colour), 2);
  }

  // Below the end of a step with dropped successors.
  const float side = scaled(4);
  for (const TimelineBranch& branch : timeline.branches()) {
    if (branch.from < timeline.older()) continue;
    const float x = corner.x + width * static_cast<float>(branch.from - timeline.older()), y = corner.y + height;
    list->AddTriangleFilled({x, y}, {x + side, y + side}, {x - side, y + side},
                            ImGui::GetColorU32(styleColours().warning));
  }

  const float now = corner.x + width * static_cast<float>(done);
  list->AddLine({now, corner.y - 3}, {now, corner.y + height + 3}, ImGui::GetColorU32(ImGuiCol_Text), 2);
}

// Above the strip, to keep it readable.
void drawHover(const Workbench& bench, std::size_t block, float top) {
  const Timeline& timeline = bench.steps->timeline();
  const std::size_t n = std::min(block, timeline.steps().size() - 1);
  const TimelineStep& step = timeline.steps()[n];
  const std::string text = describeStep(step, timeline.older() + n + 1, bench.tools->at(step.tool).id);
  const std::string loss = lossOf(timeline.steps().size() - n - 1);
  ImGui::SetNextWindowPos({ImGui::GetIO().MousePos.x, top - 8}, ImGuiCond_Always, {0.5f, 1});
  ImGui::BeginTooltip();
  ui::text(text);
  ui::textColored(styleColours().quiet, ui::asItIs(shownText("Click or drag to go there. ") + shownText(loss)));
  ImGui::EndTooltip();
}

// One line, to keep the picture above the strip visible.   @return its width, the same for any `done`: it must not move
// under a mouse that drags the blocks.
float drawSummary(const Workbench& bench, std::size_t done) {
  const Timeline& timeline = bench.steps->timeline();
  const std::uint64_t older = timeline.older(), all = older + timeline.steps().size();
  const auto textOf = [&](std::uint64_t now) {
    const std::string text = phrase("Step {} of {}", now, all);
    return older > 0 ? text + phrase(" (undo to {} at most)", older) : text;
  };
  const std::string text = textOf(older + done), loss = lossOf(timeline.steps().size() - done);
  ImGui::AlignTextToFramePadding();
  loss.empty() ? ui::text(text) : ui::textColored(styleColours().warning, text);
  if (!loss.empty() && ImGui::IsItemHovered()) ui::setTooltip(loss);
  return ui::textSize(textOf(all)).x;
}

// A button, and the list that it opens.   @return its width.
float drawBranches(AppContext& context) {
  const std::size_t count = context.bench.steps->branchCount();
  const std::string label = count == 1 ? shownText("1 branch") : phrase("{} branches", count);
  if (ui::button(label + "###branches")) ui::openPopup("##branches");
  const float width = ImGui::GetItemRectSize().x;
  if (ImGui::IsItemHovered()) ui::setTooltip("Undone steps that later cuts replaced");
  if (!ui::beginPopup("##branches")) return width;

  ui::textColored(styleColours().quiet, "Continue in a new session:");
  const std::vector<Branch> branches = context.bench.steps->branches();
  for (std::size_t n = 0; n < branches.size(); ++n) {
    const std::string row = fmt::format("{}: {}", n + 1, branches[n].text);
    if (!ui::selectable(row)) continue;
    const std::vector<std::string> words{fmt::format("{}", n + 1)};
    if (const auto taken = runAppCommand(context, "edit.branch", words); !taken)
      context.bench.notices->complain(taken.error());
  }
  ImGui::EndPopup();
  return width;
}

// At the right end, if there is room.
void drawLoss(const Timeline& timeline, std::size_t done, float blocks_end) {
  const std::string loss = lossOf(timeline.steps().size() - done);
  const float begin = ImGui::GetWindowContentRegionMax().x - ui::textSize(loss).x;
  if (loss.empty() || ImGui::GetWindowPos().x + begin < blocks_end + scaled(12)) return;
  ImGui::SameLine(begin);
  ui::textColored(styleColours().quiet, loss);
}

}  // namespace

float timelineHeight(const AppContext& context) {
  constexpr float kReplayHeight = 96;  // of the strip of a replay
  if (context.bench.document->watched()) return scaled(kReplayHeight);
  return hasSteps(context) ? scaled(kStripHeight) : 0;
}

void drawTimeline(AppContext& context) {
  if (!hasSteps(context)) return;
  const Workbench& bench = context.bench;
  const Timeline& timeline = bench.steps->timeline();
  const ImGuiIO& io = ImGui::GetIO();
  const FrameArea area = frameLayout(context).strip;
  ImGui::SetNextWindowPos({area.left, area.top}, ImGuiCond_Always);
  ImGui::SetNextWindowSize({area.width(), area.height()}, ImGuiCond_Always);
  ui::begin("##timeline", nullptr,
            ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  const std::size_t count = timeline.steps().size(), done = bench.steps->done();
  float left = ImGui::GetStyle().WindowPadding.x + drawSummary(bench, done) + scaled(12);
  if (bench.steps->branchCount() > 0) {
    ImGui::SameLine(left);
    left += drawBranches(context) + scaled(12);
  }
  if (count == 0 || !bench.document->isOpen()) return ImGui::End();  // no steps, or a branch was taken
  ImGui::SameLine(left);

  const float space = ImGui::GetContentRegionAvail().x;
  const float width = std::min(scaled(kWidestBlock), space / static_cast<float>(count));
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float blocks = width * static_cast<float>(count);
  ImGui::InvisibleButton("##steps", {blocks, scaled(kBlockHeight)});
  const float at = std::clamp((io.MousePos.x - corner.x) / width, 0.0f, static_cast<float>(count));
  if (ImGui::IsItemHovered() && at < static_cast<float>(count))
    drawHover(bench, static_cast<std::size_t>(at), ImGui::GetWindowPos().y);
  drawBlocks(timeline, done, corner, width);

  // Left of the first block is the beginning; on a block its end.
  const bool is_before = io.MousePos.x < corner.x + 0.3f * width;
  const auto there = is_before ? 0 : std::min(count, static_cast<std::size_t>(at) + 1);
  // Shows an error once, not in each frame of a drag.
  const bool is_asked = bench.saw->isCutting() ? ImGui::IsItemActivated() : ImGui::IsItemActive();
  if (is_asked && there != done) {
    const std::vector<std::string> words{fmt::format("{}", timeline.older() + there)};
    if (const auto gone = runAppCommand(context, "edit.go", words); !gone)
      context.bench.notices->complain(gone.error());
  }
  drawLoss(timeline, done, corner.x + blocks);
  ImGui::End();
}

}  // namespace kerf
