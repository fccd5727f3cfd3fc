// Pieces: poses and names. The rest of the workbench: workbench.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "ui/app/workbench/workbench.h"

namespace kerf {

const SceneObject* Workbench::chosenPiece() const { return chosen_ ? scene_.find(*chosen_) : nullptr; }

void Workbench::movePiece(std::uint32_t id, const Rigid3& T_world_object) {
  SceneObject* const piece = scene_.find(id);
  if (!piece || !piece->is_in_scene || isNeighbour(id, "to be moved")) return;
  if (!T_world_object.isUsable())
    return complain({.code = Error::Code::kBadValue,
                     .place = piece->name,
                     .found = "a place that can not be computed with",
                     .expected = "less than 100 m away"});
  if (isSawing() || undos_left_ != 0 || wish_) return dragPiece(id, std::nullopt);
  release();
  const Vec3d& t = T_world_object.translation;
  const Eigen::Quaterniond& q = T_world_object.rotation;
  piece->dragged = T_world_object;
  const bool is_sent = send(MoveObject{piece->index, {t[0], t[1], t[2]}, {q.w(), q.x(), q.y(), q.z()}});
  moving_.push_back({id, is_sent ? sent_ : 0});
}

void Workbench::dragPiece(std::uint32_t id, const std::optional<Rigid3>& T_world_object) {
  if (SceneObject* const piece = scene_.find(id)) piece->dragged = T_world_object;
}

void Workbench::hidePiece(std::uint32_t id, bool is_hidden) {
  if (SceneObject* const piece = scene_.find(id)) piece->is_hidden = is_hidden;
}

void Workbench::namePiece(std::uint32_t id, const std::string& name) {
  SceneObject* const piece = scene_.find(id);
  if (!piece || name.empty() || name == piece->name || isNeighbour(id, "to be renamed")) return;
  const bool is_number = std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
  const auto has = [&](const SceneObject* other) { return other != piece && other->name == name; };
  const bool is_taken = std::any_of(scene_.shown().begin(), scene_.shown().end(), has);
  if (is_number || is_taken)
    return complain({.code = Error::Code::kBadValue,
                     .place = piece->name,
                     .found = fmt::format("\"{}\"{}", name, is_taken ? ", which another piece is called" : ""),
                     .expected = "a name of its own, not a number"});
  piece->name = name;
  run_->namePiece(id, name);
}

void Workbench::colourPiece(std::uint32_t id, const std::string& colour) {
  SceneObject* const piece = scene_.find(id);
  if (!piece || !run_ || colour == piece->colour || isNeighbour(id, "to be coloured")) return;
  piece->colour = colour;
  run_->colourPiece(id, colour);
}

// Gives written files the names shown in the window.
void Workbench::namePieces() {
  for (const SceneObject* object : scene_.shown()) run_->namePiece(object->id, object->name);
}

}  // namespace kerf
