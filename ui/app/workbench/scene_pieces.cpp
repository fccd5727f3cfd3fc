#include "ui/app/workbench/scene_pieces.h"

#include <fmt/format.h>

#include <algorithm>

#include "ui/app/base/language.h"
#include "ui/app/document/document.h"
#include "ui/app/session/timeline.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

void ScenePieces::opened(Opening /*how*/) {
  selected_.clear();
  removing_.reset();
  moving_.clear();
}

// A moved piece takes its pose from the simulation once that has answered.
void ScenePieces::update() {
  if (!bench_.document->isOpen()) return;
  std::erase_if(moving_, [&](const Moving& piece) {
    if (bench_.document->answered() < piece.sent) return false;
    drag(piece.id, std::nullopt);
    return true;
  });
  reportRemoved();
}

// ---- The chosen ones

const SceneObject* ScenePieces::chosen() const {
  for (auto id = selected_.rbegin(); id != selected_.rend(); ++id)
    if (const SceneObject* const piece = bench_.document->scene().find(*id)) return piece;
  return nullptr;
}

std::vector<const SceneObject*> ScenePieces::selected() const {
  std::vector<const SceneObject*> out;
  for (const SceneObject* const piece : bench_.document->scene().shown())
    if (isSelected(piece->id)) out.push_back(piece);
  return out;
}

bool ScenePieces::isSelected(std::uint32_t id) const {
  return std::find(selected_.begin(), selected_.end(), id) != selected_.end();
}

void ScenePieces::choose(std::optional<std::uint32_t> id) {
  selected_.clear();
  if (id) selected_.push_back(*id);
}

void ScenePieces::toggle(std::uint32_t id) {
  if (std::erase(selected_, id) == 0) selected_.push_back(id);
}

void ScenePieces::chooseTo(std::uint32_t id) {
  const SceneObject* const from = chosen();
  if (!from || from->id == id) return choose(id);
  selected_.clear();
  bool is_between = false;
  for (const SceneObject* const piece : bench_.document->scene().shown()) {
    const bool is_end = piece->id == from->id || piece->id == id;
    if ((is_end || is_between) && !piece->isBeside() && piece->id != from->id) selected_.push_back(piece->id);
    is_between ^= is_end;
  }
  selected_.push_back(from->id);
}

// ---- Changes

Expected<void> ScenePieces::remove(std::span<const std::uint32_t> ids) {
  Document& document = *bench_.document;
  const auto refuse = [&](Error::Code code, std::string found, std::string expected, std::string hint) {
    return fail({.code = code,
                 .place = "deleting pieces",
                 .found = std::move(found),
                 .expected = std::move(expected),
                 .hint = std::move(hint)});
  };
  DeleteObjects command;
  std::size_t left = document.isOpen() ? document.scene().pieceCount() : 0;
  for (const std::uint32_t id : ids) {
    const SceneObject* const piece = document.isOpen() ? document.scene().find(id) : nullptr;
    if (!piece || !piece->is_in_scene || command.objects.has(piece->index)) continue;
    if (piece->isBeside())
      return refuse(Error::Code::kUnsupported, fmt::format("\"{}\", a neighbour", piece->name),
                    "pieces of the object you cut", "take it away: neighbour.remove");
    command.objects.bits |= std::uint64_t{1} << piece->index;
    --left;
  }
  if (command.objects.bits == 0)
    return refuse(Error::Code::kEmpty, "no piece is chosen", "one of the pieces", "click a piece in Pieces");
  if (left == 0)
    return refuse(Error::Code::kUnsupported, ids.size() > 1 ? "all pieces" : "the only piece", "a piece that stays",
                  "hide pieces (H), or end the session (Ctrl+W)");
  if (bench_.saw->isCutting() || bench_.steps->isMoving() || !bench_.steps->isSettled() || removing_)
    return refuse(Error::Code::kUnsupported, "the tool is in use", "a tool at rest", "wait for it, then delete again");
  bench_.strokes->release();
  const std::uint64_t refused = document.report().counts.commands_refused;
  if (!document.send(command))
    return refuse(Error::Code::kUnsupported, "the 1 kHz thread is busy", "a free place in its queue", "try again");
  removing_ = Removing{document.sent(), refused};
  return {};
}

void ScenePieces::reportRemoved() {
  const Document& document = *bench_.document;
  if (!removing_ || document.answered() < removing_->sent) return;
  const UndoList& undo = document.report().undo;
  const bool is_refused = document.report().counts.commands_refused > removing_->refused_before;
  removing_.reset();
  if (is_refused || undo.newest_count == 0)
    return bench_.notices->complain({.code = Error::Code::kUnsupported,
                                     .place = "deleting pieces",
                                     .found = "the pieces changed meanwhile",
                                     .expected = "pieces of the scene, and one that stays",
                                     .hint = "choose them again"});
  const UndoStep& step = undo.newest[undo.newest_count - 1];
  bench_.notices->say(phrase("{}; Ctrl+Z undoes it", deletedText(step.deleted, step.removed_mm3)));
}

void ScenePieces::move(std::uint32_t id, const Rigid3& T_world_object) {
  Document& document = *bench_.document;
  if (!document.isOpen()) return;
  SceneObject* const piece = document.scene().find(id);
  if (!piece || !piece->is_in_scene || bench_.neighbours->isNeighbour(id, "be moved")) return;
  if (!T_world_object.isUsable())
    return bench_.notices->complain({.code = Error::Code::kBadValue,
                                     .place = piece->name,
                                     .found = "an unusable position",
                                     .expected = "a position less than 100 m away"});
  if (bench_.saw->isBusy() || bench_.steps->isMoving() || !bench_.steps->isSettled() || removing_)
    return drag(id, std::nullopt);
  bench_.strokes->release();
  const Vec3d& t = T_world_object.translation;
  const Eigen::Quaterniond& q = T_world_object.rotation;
  piece->dragged = T_world_object;
  const bool is_sent = document.send(MoveObject{piece->index, {t[0], t[1], t[2]}, {q.w(), q.x(), q.y(), q.z()}});
  moving_.push_back({id, is_sent ? document.sent() : 0});
}

void ScenePieces::drag(std::uint32_t id, const std::optional<Rigid3>& T_world_object) {
  if (SceneObject* const piece = bench_.document->scene().find(id)) piece->dragged = T_world_object;
}

void ScenePieces::hide(std::uint32_t id, bool is_hidden) {
  if (SceneObject* const piece = bench_.document->scene().find(id)) piece->is_hidden = is_hidden;
}

void ScenePieces::rename(std::uint32_t id, const std::string& name) {
  LiveScene& scene = bench_.document->scene();
  SceneObject* const piece = scene.find(id);
  if (!piece || !bench_.document->isOpen() || name.empty() || name == piece->name ||
      bench_.neighbours->isNeighbour(id, "be renamed"))
    return;
  const bool is_number = std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
  const auto has = [&](const SceneObject* other) { return other != piece && other->name == name; };
  const auto all = scene.shown();
  const bool is_taken = std::any_of(all.begin(), all.end(), has);
  if (is_number || is_taken)
    return bench_.notices->complain(
        {.code = Error::Code::kBadValue,
         .place = piece->name,
         .found = fmt::format("\"{}\"{}", name, is_taken ? ", the name of another piece" : ""),
         .expected = "a unique name that is not a number"});
  piece->name = name;
  bench_.document->run()->namePiece(id, name);
}

void ScenePieces::colour(std::uint32_t id, const std::string& colour) {
  Document& document = *bench_.document;
  SceneObject* const piece = document.scene().find(id);
  if (!piece || !document.isOpen() || colour == piece->colour || bench_.neighbours->isNeighbour(id, "be coloured"))
    return;
  piece->colour = colour;
  document.run()->colourPiece(id, colour);
}

void ScenePieces::passNames() {
  if (!bench_.document->isOpen()) return;
  for (const SceneObject* object : bench_.document->scene().shown())
    bench_.document->run()->namePiece(object->id, object->name);
}

}  // namespace kerf
