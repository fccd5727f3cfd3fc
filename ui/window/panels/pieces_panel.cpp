#include "ui/window/panels/pieces_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/view/piece_colours.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/strokes.h"
#include "ui/window/gl/theme.h"
#include "ui/window/gl/widgets.h"

namespace kerf {
namespace {

constexpr std::array<ImU32, 3> kAxisColours = {IM_COL32(214, 66, 56, 255), IM_COL32(54, 150, 60, 255),
                                               IM_COL32(48, 104, 214, 255)};
constexpr ImU32 kLit = IM_COL32(250, 176, 20, 255), kDiscColour = IM_COL32(250, 250, 250, 230),
                kPieceEdge = IM_COL32(30, 34, 40, 220);

// ---- Handles

void drawGizmo(const PieceGizmo& gizmo, std::optional<GizmoHandle> lit, double pixels) {
  ImDrawList* const draw = ImGui::GetBackgroundDrawList();
  const auto at = [pixels](const Pixel& p) {
    return ImVec2(static_cast<float>(p[0] / pixels), static_cast<float>(p[1] / pixels));
  };
  const auto colour = [&](int handle, int axis) {
    return lit == static_cast<GizmoHandle>(handle) ? kLit : kAxisColours[static_cast<std::size_t>(axis)];
  };

  for (int axis = 0; axis < 3; ++axis) {
    std::vector<ImVec2> points;
    for (const Pixel& p : gizmo.ring(axis)) points.push_back(at(p));
    draw->AddPolyline(points.data(), static_cast<int>(points.size()), colour(3 + axis, axis), ImDrawFlags_Closed, 2);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const Pixel from = gizmo.center(), tip = gizmo.arrowTip(axis), along = tip - from;
    if (along.norm() < 4) continue;
    const Pixel unit = along.normalized(), side(-unit[1], unit[0]);
    draw->AddLine(at(from), at(tip), colour(axis, axis), 3);
    draw->AddTriangleFilled(at(tip + 12 * unit), at(tip + 6 * side), at(tip - 6 * side), colour(axis, axis));
    static constexpr const char* kNames[] = {"x", "y", "z"};
    ui::addText(*draw, at(tip + 22 * unit - Pixel(4, 8)), colour(axis, axis), kNames[axis]);
  }
  const auto radius = static_cast<float>(PieceGizmo::kDisc / pixels);
  draw->AddCircleFilled(at(gizmo.center()), radius, lit == GizmoHandle::kMoveInView ? kLit : kDiscColour);
  draw->AddCircle(at(gizmo.center()), radius, kPieceEdge, 0, 1.5f);
}

// ---- The list

void drawMove(AppContext& context, const SceneObject& piece) {
  Rigid3 pose = piece.pose();
  std::array<float, 3> mm{};
  for (int axis = 0; axis < 3; ++axis) mm[static_cast<std::size_t>(axis)] = static_cast<float>(pose.translation[axis]);
  ui::text("Moved by x, y, z, mm");
  ImGui::PushItemWidth(-1);
  const bool is_changed = ui::inputFloat3("##mm", mm.data(), "%.2f", ImGuiInputTextFlags_EnterReturnsTrue);
  ImGui::PopItemWidth();
  if (is_changed) {
    for (int axis = 0; axis < 3; ++axis)
      pose.translation[axis] = static_cast<double>(mm[static_cast<std::size_t>(axis)]);
    context.bench.pieces->move(piece.id, pose);
  }
  const double degrees = 2 * std::acos(std::clamp(std::abs(pose.rotation.w()), 0.0, 1.0)) * 180 / std::numbers::pi;
  ui::text(phrase("Turned by {:.1f} degrees", degrees));
  if (ui::button("Put back", {-1, 0})) runIfEnabled(context, "piece.put-back", std::vector<std::string>{piece.name});
}

// Below its name and volume. The first piece also counts the volume removed before the split.
void drawRemoved(const SceneObject& piece) {
  constexpr double kLeast = 0.005;  // mm^3: less would show as zero
  if (piece.removed_mm3 < kLeast) return;
  ImGui::Indent(scaled(30));
  ui::textDisabled(phrase("{:.2f} mm3 removed", piece.removed_mm3));
  ImGui::Unindent(scaled(30));
}

ImVec4 shown(const Rgba8& c) {
  const auto one = [](std::uint8_t v) { return static_cast<float>(v) / 255; };
  return {one(c[0]), one(c[1]), one(c[2]), 1};
}

void giveColour(AppContext& context, const char* name) {
  const auto done = runAppCommand(context, "piece.colour", std::vector<std::string>{name});
  if (!done) context.bench.notices->complain(done.error());
}

// The palette; the current colour has a frame.
void drawColours(AppContext& context, const SceneObject& piece) {
  constexpr auto kFlags = ImGuiColorEditFlags_NoTooltip | ImGuiColorEditFlags_NoPicker | ImGuiColorEditFlags_NoDragDrop;
  for (const PieceColour& colour : pieceColours()) {
    ImGui::PushStyleVar(ImGuiStyleVar_FrameBorderSize, piece.colour == colour.name ? scaled(2) : 0);
    if (ImGui::ColorButton(colour.name, shown(colour.colour), kFlags, {scaled(20), scaled(20)}))
      giveColour(context, colour.name);
    ImGui::PopStyleVar();
    if (ImGui::IsItemHovered()) ui::setTooltip(colour.name);
    ImGui::SameLine(0, scaled(4));
  }
  if (ui::smallButton("None")) giveColour(context, "none");
}

constexpr const char* kPieceMenu = "###piece-menu";

// Of the row that opened it.
void drawPieceMenu(AppContext& context) {
  if (!ui::beginPopup(kPieceMenu)) return;
  for (const char* const id : {"piece.hide", "piece.show-all", "piece.put-back", "piece.delete"}) {
    const AppCommand& command = *findAppCommand(id);
    if (ui::menuItem(command.label, ui::asItIs(shownKey(command.key)), command.is_enabled(context)))
      runIfEnabled(context, id);
  }
  ImGui::EndPopup();
}

// Ctrl adds, Shift takes all up to the piece.
void chooseByClick(ScenePieces& pieces, const SceneObject& piece) {
  if (ImGui::GetIO().KeyCtrl) return pieces.toggle(piece.id);
  if (ImGui::GetIO().KeyShift) return pieces.chooseTo(piece.id);
  const bool is_alone = pieces.chosen() == &piece && pieces.selected().size() == 1;
  pieces.choose(is_alone ? std::nullopt : std::optional(piece.id));
}

// The others beside the chosen piece, whose handles show it.
void drawSelected(const AppContext& context, double pixels) {
  const ScenePieces& pieces = *context.bench.pieces;
  for (const SceneObject* const piece : pieces.selected()) {
    if (piece == pieces.chosen() || piece->is_hidden || piece->isBeside()) continue;
    const PieceGizmo at(context.camera, context.width, context.height,
                        piece->pose() * piece->surface.bounds().center());
    const ImVec2 center(static_cast<float>(at.center()[0] / pixels), static_cast<float>(at.center()[1] / pixels));
    ImGui::GetBackgroundDrawList()->AddCircleFilled(center, static_cast<float>(PieceGizmo::kDisc / pixels), kLit);
  }
}

}  // namespace

void drawPieces(AppContext& context) {
  Workbench& bench = context.bench;
  const SceneObject* const chosen = bench.pieces->chosen();
  for (SceneObject* piece : bench.document->scene().shown()) {
    if (piece->isBeside()) continue;
    ImGui::PushID(static_cast<int>(piece->id));
    bool is_shown = !piece->is_hidden;
    if (ui::checkbox("##shown", &is_shown)) bench.pieces->hide(piece->id, !is_shown);
    if (ImGui::IsItemHovered()) ui::setTooltip("Show or hide");
    ImGui::SameLine();
    if (const PieceColour* const colour = findPieceColour(piece->colour)) {
      const ImVec2 at = ImGui::GetCursorScreenPos();
      const float half = 0.5f * ImGui::GetFrameHeight();
      ImGui::GetWindowDrawList()->AddCircleFilled({at.x + scaled(4), at.y + half}, scaled(4),
                                                  ImGui::ColorConvertFloat4ToU32(shown(colour->colour)), 16);
      ImGui::SetCursorPosX(ImGui::GetCursorPosX() + scaled(12));
    }
    const std::string volume =
        shownNumbers("{:.{}f} mm3{}", piece->surface.volume(), piece->surface.volume() < 100 ? 1 : 0,
                     shownText(piece->isMoved() ? ", moved" : ""));
    if (ui::selectable(ui::asItIs(piece->name), bench.pieces->isSelected(piece->id), 0, {scaled(90), 0}))
      chooseByClick(*bench.pieces, *piece);
    if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) {
      if (!bench.pieces->isSelected(piece->id)) bench.pieces->choose(piece->id);
      ui::openPopup(kPieceMenu);
    }
    drawPieceMenu(context);
    ImGui::SameLine();
    ui::textDisabled(volume);
    drawRemoved(*piece);
    ImGui::PopID();
  }
  const std::size_t count = bench.pieces->selected().size();
  if (chosen && count > 1) {
    ImGui::Separator();
    double mm3 = 0;
    for (const SceneObject* const piece : bench.pieces->selected()) mm3 += piece->surface.volume();
    ui::text(phrase("{} pieces chosen, {:.0f} mm3", count, mm3));
    if (ui::button("Hide", {-1, 0})) runIfEnabled(context, "piece.hide");
    if (ui::button("Delete", {-1, 0})) runIfEnabled(context, "piece.delete");
  } else if (chosen) {
    ImGui::Separator();
    std::array<char, 64> name{};
    chosen->name.copy(name.data(), name.size() - 1);
    ImGui::PushItemWidth(-1);
    if (ui::inputText("##name", name.data(), name.size(), ImGuiInputTextFlags_EnterReturnsTrue) && name[0] != '\0')
      runIfEnabled(context, "piece.rename", std::vector<std::string>{name.data()});
    ImGui::PopItemWidth();
    drawColours(context, *chosen);
    drawMove(context, *chosen);
  } else {
    ImGui::PushTextWrapPos(0);
    ui::textDisabled("Click a piece to move or name it; Ctrl or Shift for several");
    ImGui::PopTextWrapPos();
  }
}

// By id: two may have one name.
void drawNeighbourList(AppContext& context) {
  Workbench& bench = context.bench;
  for (const SceneObject* object : bench.document->scene().shown()) {
    if (!object->isBeside()) continue;
    ImGui::PushID(static_cast<int>(object->id));
    bool is_shown = !object->is_hidden, is_ghost = object->is_ghost;
    if (ui::checkbox("##shown", &is_shown)) bench.pieces->hide(object->id, !is_shown);
    if (ImGui::IsItemHovered()) ui::setTooltip("Show or hide; the tool still touches it");
    ImGui::SameLine();
    if (ui::checkbox("##ghost", &is_ghost)) bench.neighbours->makeGhost(object->id, is_ghost);
    if (ImGui::IsItemHovered()) ui::setTooltip("Ghost: translucent and not clickable");
    ImGui::SameLine();
    ui::text(ui::asItIs(object->name));
    ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - scaled(70));
    if (ui::button("Remove", {scaled(70), 0}))
      runIfEnabled(context, "neighbour.remove", std::vector<std::string>{object->name});
    if (ImGui::IsItemHovered()) ui::setTooltip("The tool no longer touches it; its file stays");
    ImGui::PopID();
  }
  bool stops = bench.strokes->stop_short_beside_mm.has_value();
  if (ui::checkbox("Stop short of neighbours", &stops))
    runIfEnabled(context, "cut.spare-neighbours", stops ? std::vector<std::string>{} : std::vector<std::string>{"off"});
}

std::optional<PieceGizmo> gizmoOf(const AppContext& context) {
  const SceneObject* const piece = context.bench.pieces->chosen();
  const SawPlane* const plane = context.bench.saw->plan().chosen();
  const auto at = [&](const Vec3d& center) {
    return PieceGizmo(context.camera, context.width, context.height, center);
  };
  if (!piece && plane && context.bench.saw->has_handles) return at(plane->fromPlane(0, 0.5 * plane->depth));
  if (!piece || piece->is_hidden || piece->isBeside()) return {};
  return at(piece->pose() * piece->surface.bounds().center());
}

bool PieceDrag::press(AppContext& context, const Pixel& at) {
  const SceneObject* const piece = context.bench.pieces->chosen();
  gizmo_ = gizmoOf(context);
  handle_ = gizmo_ ? gizmo_->handleAt(at) : std::nullopt;
  if (!handle_) return false;
  plane_.reset();
  if (!piece) plane_ = *context.bench.saw->plan().chosen();
  if (piece) piece_ = piece->id;
  pose_ = piece ? piece->pose() : Rigid3{};
  from_ = at;
  return true;
}

void PieceDrag::move(AppContext& context, const Pixel& at) {
  if (!handle_) return;
  const Rigid3 to = gizmo_->dragged(*handle_, from_, at, pose_);
  if (plane_)
    context.bench.saw->plan().replaceChosen(movedPlane(*plane_, to));
  else
    context.bench.pieces->drag(piece_, to);
}

void PieceDrag::release(AppContext& context, const Pixel& at) {
  if (!handle_) return;
  if (plane_)
    context.bench.saw->plan().replaceChosen(
        at == from_ ? *plane_ : movedPlane(*plane_, gizmo_->dragged(*handle_, from_, at, pose_)));
  else if (at == from_)
    context.bench.pieces->drag(piece_, std::nullopt);
  else
    context.bench.pieces->move(piece_, gizmo_->dragged(*handle_, from_, at, pose_));
  handle_.reset();
}

void PieceDrag::hover(const AppContext& context, const Pixel& at) {
  const auto gizmo = gizmoOf(context);
  hovered_ = gizmo ? gizmo->handleAt(at) : std::nullopt;
}

bool arePiecesNeeded(const AppContext& context) {
  const auto shown = context.bench.document->scene().shown();
  return context.bench.document->scene().pieceCount() > 1 ||
         std::any_of(shown.begin(), shown.end(), [](const auto* piece) { return piece->isMoved(); });
}

bool areNeighboursNeeded(const AppContext& context) {
  return context.bench.document->scene().pieceCount() < context.bench.document->scene().shown().size();
}

void drawPieceHandles(const AppContext& context, const PieceDrag& drag, double pixels) {
  drawSelected(context, pixels);
  if (const auto gizmo = gizmoOf(context)) drawGizmo(*gizmo, drag.lit(), pixels);
}

}  // namespace kerf
