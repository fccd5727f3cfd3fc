// The list of pieces, and handles that move the chosen one. Shows a workbench and runs its functions.
#pragma once

#include <optional>

#include "ui/app/commands/app_commands.h"
#include "ui/app/view/piece_gizmo.h"
#include "ui/window/frame/panel_column.h"

namespace kerf {

/// A drag of a handle of the chosen piece.
class PieceDrag {
 public:
  /// True: a handle is under the pointer and the drag has begun. @param at  pixels of the picture.
  bool press(AppContext& context, const Pixel& at);
  void move(AppContext& context, const Pixel& at);
  void release(AppContext& context, const Pixel& at);
  bool isOn() const { return handle_.has_value(); }
  void hover(const AppContext& context, const Pixel& at);
  std::optional<GizmoHandle> lit() const { return handle_ ? handle_ : hovered_; }

 private:
  std::optional<GizmoHandle> handle_, hovered_;
  std::uint32_t piece_ = 0;
  Pixel from_ = Pixel::Zero();
  Rigid3 pose_;  // at the press
  std::optional<PieceGizmo> gizmo_;
};

/// Handles of the chosen piece; none without one.
std::optional<PieceGizmo> gizmoOf(const AppContext& context);

/// The list, if there are several pieces or a moved one, and the handles over the picture.
/// @param pixels  of the picture per window unit.
void drawPieces(AppContext& context, const PieceDrag& drag, PanelColumn& column, double pixels);

}  // namespace kerf
