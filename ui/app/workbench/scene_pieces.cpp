#include "ui/app/workbench/scene_pieces.h"

#include <fmt/format.h>

#include <algorithm>

#include "ui/app/document/document.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/steps.h"
#include "ui/app/workbench/strokes.h"
#include "ui/app/workbench/workbench.h"

namespace kerf {

void ScenePieces::opened(Opening /*how*/) {
  chosen_.reset();
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
}

const SceneObject* ScenePieces::chosen() const { return chosen_ ? bench_.document->scene().find(*chosen_) : nullptr; }

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
  if (bench_.saw->isBusy() || bench_.steps->isMoving()) return drag(id, std::nullopt);
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
