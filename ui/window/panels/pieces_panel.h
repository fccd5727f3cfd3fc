// The lists of pieces and of neighbours, and handles that move the chosen piece. Shows a workbench and runs its
// functions.
#pragma once

#include <optional>

#include "ui/app/commands/app_commands.h"
#include "ui/app/saw/saw_plan.h"
#include "ui/app/view/piece_gizmo.h"

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
  std::optional<SawPlane> plane_;  ///< dragged instead of a piece: as it was at the press
  Pixel from_ = Pixel::Zero();
  Rigid3 pose_;  // at the press
  std::optional<PieceGizmo> gizmo_;
};

/// Handles of the chosen piece, else of the chosen plane if Sawing::has_handles; none without one.
std::optional<PieceGizmo> gizmoOf(const AppContext& context);

/// The list. Needed with several pieces or a moved one.
bool arePiecesNeeded(const AppContext& context);
void drawPieces(AppContext& context);
/// The handles over the picture.   @param pixels  of the picture per window unit.
void drawPieceHandles(const AppContext& context, const PieceDrag& drag, double pixels);

/// Other objects of the session.
bool areNeighboursNeeded(const AppContext& context);
void drawNeighbourList(AppContext& context);

}  // namespace kerf
