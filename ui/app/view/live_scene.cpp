#include "ui/app/view/live_scene.h"

#include <fmt/format.h>

#include <algorithm>

namespace kerf {
namespace {

// The first unused name of "piece 1", "piece 2", ...
std::string freePieceName(std::span<SceneObject* const> objects) {
  for (std::size_t n = 1;; ++n) {
    std::string name = fmt::format("piece {}", n);
    const auto has = [&](const SceneObject* object) { return object->name == name; };
    if (std::none_of(objects.begin(), objects.end(), has)) return name;
  }
}

}  // namespace

bool SceneObject::isMoved() const {
  return T_world_object.translation != Vec3d::Zero() || T_world_object.rotation.vec() != Vec3d::Zero();
}

Ray inFrame(const Rigid3& T_world_object, const Ray& ray) {
  const Rigid3 to_object = T_world_object.inverse();
  return {to_object * ray.origin, to_object.rotation * ray.direction};
}

void LiveScene::clear() {
  shown_.clear();
  objects_.clear();
  labels_.clear();
}

SceneObject& LiveScene::objectOf(std::uint32_t id) {
  for (const auto& object : objects_)
    if (object->id == id) return *object;
  SceneObject& out = *objects_.emplace_back(std::make_unique<SceneObject>());
  out.id = id;
  return out;
}

void LiveScene::update(std::span<const ObjectChunks> chunks, const HapticReport& report) {
  for (const ObjectChunks& object : chunks) objectOf(object.id).surface.update(object.chunks);

  for (const auto& object : objects_) object->is_in_scene = false;
  std::vector<SceneObject*> in_scene;
  bool is_meshed = report.object_count > 0;
  for (std::size_t n = 0; n < report.object_count; ++n) {
    const ObjectReport& known = report.objects[n];
    SceneObject& object = objectOf(known.id);
    object.is_in_scene = true;
    object.index = n;
    object.loaded = known.loaded;
    object.T_world_object = known.T_world_object;
    object.removed_mm3 = known.removed_mm3;
    is_meshed &= object.surface.triangleCount() > 0;
    in_scene.push_back(&object);
  }
  for (SceneObject* object : in_scene) {
    const auto known = labels_.find(object->id);
    if (known == labels_.end()) continue;
    object->name = known->second.name;
    object->colour = known->second.colour;
    labels_.erase(known);
  }
  for (SceneObject* object : in_scene)
    if (object->name.empty()) object->name = freePieceName(in_scene);
  if (is_meshed) shown_ = std::move(in_scene);
  if (shown_.empty())  // no report from the session yet
    for (const auto& object : objects_) shown_.push_back(object.get());
}

SceneObject* LiveScene::find(std::uint32_t id) const {
  const auto at = std::find_if(shown_.begin(), shown_.end(), [&](const SceneObject* o) { return o->id == id; });
  return at == shown_.end() ? nullptr : *at;
}

std::size_t LiveScene::pieceCount() const {
  return static_cast<std::size_t>(
      std::count_if(shown_.begin(), shown_.end(), [](const SceneObject* object) { return !object->isBeside(); }));
}

std::size_t LiveScene::triangleCount() const {
  std::size_t out = 0;
  for (const SceneObject* object : shown_) out += object->surface.triangleCount();
  return out;
}

Box3 LiveScene::bounds() const {
  Box3 out;
  for (const SceneObject* object : shown_) {
    const Box3 box = object->surface.bounds();
    if (object->is_hidden || box.isEmpty()) continue;
    for (int n = 0; n < 8; ++n) out.add(object->pose() * box.corner(n));
  }
  return out;
}

std::optional<SceneHit> LiveScene::hit(const Ray& ray) const {
  std::optional<SceneHit> best;
  for (const SceneObject* object : shown_) {
    if (!object->isPointedAt()) continue;
    const Rigid3 pose = object->pose();
    const auto hit = object->surface.hit(inFrame(pose, ray));
    if (!hit || (best && hit->way >= best->on_surface.way)) continue;
    best = SceneHit{object->id, {pose * hit->point, pose.rotation * hit->normal, hit->way}};
  }
  return best;
}

std::vector<std::array<Vec3d, 2>> LiveScene::contour(const Plane& plane, const Box3& within) const {
  std::vector<std::array<Vec3d, 2>> out;
  for (const SceneObject* object : shown_) {
    if (object->is_hidden) continue;
    const Rigid3 pose = object->pose(), to_object = pose.inverse();
    Box3 box;
    for (int n = 0; n < 8; ++n) box.add(to_object * within.corner(n));
    const Plane local{to_object * plane.point, to_object.rotation * plane.normal};
    for (const auto& line : object->surface.contour(local, box)) out.push_back({pose * line[0], pose * line[1]});
  }
  return out;
}

}  // namespace kerf
