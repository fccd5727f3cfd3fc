#include "sim/run/session_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/pieces/joined_field.h"

namespace kerf::internal {
namespace {

// At the node that is nearest.
bool isInside(const CutObject& object, const Vec3d& point) {
  const Vec3d nodes = point / object.voxel();
  const Vec3i node(static_cast<int>(std::lround(nodes[0])), static_cast<int>(std::lround(nodes[1])),
                   static_cast<int>(std::lround(nodes[2])));
  const int slot = object.find(brickOf(node));
  return slot >= 0 && object.slot(slot).phi[nodeOffset(node[0], node[1], node[2])] < 0;
}

bool isMoved(const CutObject& object) {
  const Rigid3& pose = object.T_world_object;
  return pose.translation != Vec3d::Zero() || pose.rotation.vec() != Vec3d::Zero();
}

}  // namespace

Objects objectsOf(const Session& session, std::size_t loaded) {
  Objects out;
  for (const CutObject& object : session.state().objects)
    if (session.loadedIndexOf(object) == loaded) out.push_back(&object);
  return out;
}

bool isInPieces(const Objects& objects) { return objects.size() > 1 || objects.front()->bricks().isPiece(); }

std::vector<BrickField> fieldsOf(const Objects& objects) {
  std::vector<BrickField> out;
  out.reserve(objects.size());
  for (const CutObject* object : objects) out.push_back(fieldOf(*object));
  return out;
}

std::vector<RunManifest::Piece> piecesOf(const Objects& objects, const std::vector<BrickField>& fields,
                                         const PieceLabels& labels) {
  std::vector<RunManifest::Piece> out;
  for (const BrickField& field : fields) {
    const CutObject& object = *objects[out.size()];
    RunManifest::Piece piece;
    piece.id = object.id;
    const auto known = labels.find(object.id);
    const PieceLabel label = known == labels.end() ? PieceLabel{} : known->second;
    piece.name = label.name.empty() ? fmt::format("piece {}", out.size() + 1) : label.name;
    piece.colour = label.colour;
    piece.inside = deepestPoint({.begin = &field});
    for (const double volume : object.bricks().countVolumes()) piece.volume_mm3 += volume;
    piece.T_case_piece = object.T_world_object;
    out.push_back(std::move(piece));
  }
  return out;
}

Bodies bodiesOf(const Session& session) {
  Bodies out;
  const Objects objects = objectsOf(session, 0);
  if (!isInPieces(objects) && !isMoved(*objects.front())) {
    out.all.push_back({&objects.front()->baked().phi0(), Rigid3{}});
    return out;
  }
  out.fields = fieldsOf(objects);
  for (std::size_t n = 0; n < objects.size(); ++n) out.all.push_back({&out.fields[n], objects[n]->T_world_object});
  return out;
}

CutPath pathInFrame(const CutPath& path, const Rigid3& T_world_body) {
  CutPath out = path;
  const Rigid3 T_body_world = T_world_body.inverse();
  for (auto& pose : out.poses) pose.T_object_tool = T_body_world * pose.T_object_tool;
  return out;
}

PiecesPutBack putPiecesBack(Session& session, std::span<const RunManifest::Piece> before) {
  PiecesPutBack out;
  const auto apply = [&](const Command& command) {
    if (session.apply(command)) out.done.push_back(command);
  };
  if (before.size() > 1) apply(SplitObject{0});

  for (const RunManifest::Piece& piece : before) {
    const std::vector<CutObject>& objects = session.state().objects;
    const auto at = std::find_if(objects.begin(), objects.end(), [&](const CutObject& object) {
      return session.loadedIndexOf(object) == 0 && isInside(object, piece.inside);
    });
    if (at == objects.end()) {
      out.missing.push_back(piece.name);
      continue;
    }
    out.labels[at->id] = {piece.name, piece.colour};
    if (!piece.isMoved()) continue;
    const Vec3d& t = piece.T_case_piece.translation;
    const Eigen::Quaterniond& q = piece.T_case_piece.rotation;
    apply(MoveObject{static_cast<std::size_t>(at - objects.begin()), {t[0], t[1], t[2]}, {q.w(), q.x(), q.y(), q.z()}});
  }
  return out;
}

}  // namespace kerf::internal
