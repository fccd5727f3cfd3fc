#include "sim/run/session/session_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "sim/pieces/joined_field.h"
#include "sim/pieces/plane_parts.h"
#include "sim/run/files/run_output.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::internal {
namespace {

// Tests the nearest node.
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

bool isSamePose(const Rigid3& a, const Rigid3& b) {
  return a.translation == b.translation && a.rotation.coeffs() == b.rotation.coeffs();
}

// Tests the nearest node.
bool isInside(const FieldPart& part, const Vec3d& point) {
  const Vec3i node = (point / part.begin->voxel()).array().round().cast<int>();
  const BrickValues* const changed = part.changed ? part.changed->valuesAt(brickOf(node)) : nullptr;
  const float value =
      changed ? (*changed)[static_cast<std::size_t>(nodeOffset(node[0], node[1], node[2]))] : part.begin->at(node);
  return value < 0;
}

// The first free "piece N", from this N on.
std::string unusedName(std::size_t n, std::set<std::string>& taken) {
  while (true) {
    std::string name = fmt::format("piece {}", n++);
    if (taken.insert(name).second) return name;
  }
}

// Box of the inside nodes.
Box3 boxOf(const BrickField& field) {
  Box3 out;
  for (std::size_t b = 0; b < field.brickCount(); ++b) {
    const BrickValues& values = field.brick(b);
    const Vec3i base = field.brickCoord(b) * kBrickSide;
    for (int n = 0; n < kBrickNodes; ++n)
      if (values[static_cast<std::size_t>(n)] < 0) out.add(field.position(base + Vec3i{n >> 6, n >> 3 & 7, n & 7}));
  }
  return out;
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
  std::set<std::string> taken;
  for (const CutObject* const object : objects)
    if (const auto known = labels.find(object->id); known != labels.end()) taken.insert(known->second.name);

  std::vector<RunManifest::Piece> out;
  for (const BrickField& field : fields) {
    const CutObject& object = *objects[out.size()];
    RunManifest::Piece piece;
    piece.id = object.id;
    const auto known = labels.find(object.id);
    const PieceLabel label = known == labels.end() ? PieceLabel{} : known->second;
    piece.name = label.name.empty() ? unusedName(out.size() + 1, taken) : label.name;
    piece.colour = label.colour;
    piece.inside = deepestPoint({.begin = &field});
    for (const double volume : object.bricks().countVolumes()) piece.volume_mm3 += volume;
    piece.T_case_piece = object.T_world_object;
    if (object.plane_sides) piece.sides = *object.plane_sides;
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

std::string throughBodies(const Bodies& bodies, const Box3& box_of_case) {
  if (!bodies.isInPieces()) return throughBox(box_of_case);
  constexpr std::size_t kMostNamed = 3;
  std::string out;
  for (std::size_t n = 0; n < std::min(bodies.all.size(), kMostNamed); ++n) {
    const Box3 box = boxOf(*bodies.all[n].begin).transformed(bodies.all[n].T_world_body);
    out += fmt::format("{}{}", n > 0 ? ", or " : "", throughBox(box));
  }
  if (bodies.all.size() > kMostNamed) out += fmt::format(", or one of {} more", bodies.all.size() - kMostNamed);
  return out + ": positions of the pieces";
}

CutPath pathInFrame(const CutPath& path, const Rigid3& T_world_body) {
  CutPath out = path;
  const Rigid3 T_body_world = T_world_body.inverse();
  for (auto& pose : out.poses) pose.T_object_tool = T_body_world * pose.T_object_tool;
  return out;
}

namespace {

// Cuts again what planes had cut: both parts touch in the stored field. Parts that had left the scene are not in it.
template <class Apply>
void cutAgain(const Session& session, std::span<const RunManifest::Piece> before, const Apply& apply) {
  std::vector<PlaneSide> cuts;
  for (const RunManifest::Piece& piece : before)
    for (const PlaneSide& side : piece.sides)
      if (std::none_of(cuts.begin(), cuts.end(), [&](const PlaneSide& known) { return known.cut == side.cut; }))
        cuts.push_back(side);
  std::stable_sort(cuts.begin(), cuts.end(), [](const auto& a, const auto& b) { return a.cut < b.cut; });

  for (const PlaneSide& cut : cuts)
    for (std::size_t n = session.state().objects.size(); n-- > 0;) {
      bool is_above = false, is_below = false;
      for (const RunManifest::Piece& piece : before)
        for (const PlaneSide& side : piece.sides)
          if (side.cut == cut.cut && session.loadedIndexOf(session.state().objects[n]) == 0 &&
              isInside(session.state().objects[n], piece.inside))
            (side.is_above ? is_above : is_below) = true;
      if (!is_above && !is_below) continue;
      const PlaneKeep keep = !is_below ? PlaneKeep::kAbove : !is_above ? PlaneKeep::kBelow : PlaneKeep::kBoth;
      apply(CutByPlanes{n, static_cast<std::uint8_t>(keep), cut.planes});
    }
}

}  // namespace

PiecesPutBack putPiecesBack(Session& session, std::span<const RunManifest::Piece> before) {
  PiecesPutBack out;
  const auto apply = [&](const Command& command) {
    if (session.apply(command)) out.done.push_back(command);
  };
  if (before.size() > 1) apply(SplitObject{0});
  cutAgain(session, before, apply);
  if (before.size() > 1)
    for (std::size_t n = session.state().objects.size(); n-- > 0;)
      if (session.state().objects[n].plane_sides) apply(SplitObject{n});

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

  // The run may have named two parts separated by its path as one piece.
  const bool is_any_moved =
      std::any_of(before.begin(), before.end(), [](const auto& piece) { return piece.isMoved(); });
  if (!is_any_moved) return out;
  for (const CutObject* const object : objectsOf(session, 0)) {
    if (out.labels.contains(object->id)) continue;
    double volume = 0;
    for (const double of_tissue : object->bricks().countVolumes()) volume += of_tissue;
    out.missing.push_back(fmt::format("a part of {:.1f} mm3 without an entry in the run", volume));
  }
  return out;
}

Expected<PiecesLeft> piecesLeft(const CutScene& scene, const BrickField& changed,
                                std::span<const RunManifest::Piece> pieces, std::span<const FieldPart> parts) {
  // Splits the case as the next run will.
  LoadedObjects loaded = scene.objects;
  KERF_TRY(object, loadObject(scene.inputs.folders.front(), &changed));
  loaded.front() = std::move(object);
  Session session(scene.model, loaded, scene.start());
  session.apply(SplitObject{0});
  cutAgain(session, pieces, [&](const Command& command) { session.apply(command); });
  Objects objects = objectsOf(session, 0);
  std::vector<BrickField> fields = fieldsOf(objects);

  // The original piece of each part.
  std::vector<std::size_t> piece_of;
  std::vector<std::size_t> parts_of(pieces.size(), 0);
  PieceLabels labels;
  for (std::size_t n = 0; n < objects.size(); ++n) {
    const Vec3d inside = deepestPoint({.begin = &fields[n]});
    std::optional<std::size_t> of;
    for (std::size_t k = 0; k < pieces.size(); ++k)
      if (!of && isInside(parts[k], inside)) of = k;
    if (!of) {  // air
      objects.erase(objects.begin() + static_cast<std::ptrdiff_t>(n));
      fields.erase(fields.begin() + static_cast<std::ptrdiff_t>(n));
      --n;
      continue;
    }
    piece_of.push_back(*of);
    const PieceLabel kept{parts_of[*of] == 0 ? pieces[*of].name : "", pieces[*of].colour};
    labels[objects[n]->id] = kept;
    ++parts_of[*of];
  }

  PiecesLeft out;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    if (parts_of[k] > 0) continue;
    const Vec3d inside = deepestPoint(parts[k]);
    for (std::size_t n = 0; n < objects.size(); ++n) {
      const bool is_joined = isInside(FieldPart{.begin = &fields[n]}, inside);
      const RunManifest::Piece& other = pieces[piece_of[n]];
      if (is_joined && !isSamePose(other.T_case_piece, pieces[k].T_case_piece))
        return fail({.code = Error::Code::kGeometry,
                     .place = "pieces",
                     .found = fmt::format("\"{}\" and \"{}\" have grown together at their loaded positions", other.name,
                                          pieces[k].name),
                     .expected = "separate pieces: a run stores all pieces at their loaded positions",
                     .hint = "add less there"});
    }
    out.cut_away.push_back(pieces[k].name);
  }
  out.pieces = piecesOf(objects, fields, labels);

  // The run's log knows each piece by its number. A new piece gets one of its own.
  std::uint32_t next_id = 0;
  for (const RunManifest::Piece& piece : pieces) next_id = std::max(next_id, piece.id + 1);
  std::set<std::size_t> has_kept;
  for (std::size_t n = 0; n < out.pieces.size(); ++n) {
    const RunManifest::Piece& of = pieces[piece_of[n]];
    out.pieces[n].T_case_piece = of.T_case_piece;
    out.pieces[n].id = has_kept.insert(piece_of[n]).second ? of.id : next_id++;
  }
  return out;
}

}  // namespace kerf::internal
