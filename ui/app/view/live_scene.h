// All objects of a session in the window: loaded objects and pieces.
//
// The picture changes to new pieces when every object in the scene has a mesh. Until then, some tenths of a second, it
// shows their parent.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/live/haptic_thread.h"
#include "sim/run/session/live_run.h"
#include "ui/app/view/live_surface.h"

namespace kerf {

struct SceneObject {
  std::uint32_t id = 0;           ///< CutObject::id
  std::uint32_t loaded = 0;       ///< ObjectReport::loaded: 0 is worked on, the others stand beside it
  std::string name;               ///< "piece 2", or the user's name
  std::string colour;             ///< of pieceColours(), set by the user; empty: tissue colours
  Rigid3 T_world_object;          ///< pose in the simulation
  std::optional<Rigid3> dragged;  ///< pose while the user drags it
  LiveSurface surface;            ///< in its own frame, the frame of loading
  double removed_mm3 = 0;         ///< from it; the first piece includes the parent's removed volume
  std::size_t index = 0;          ///< in the simulation, for commands
  bool is_in_scene = false;       ///< false after an undo or a split removed it
  bool is_hidden = false;         ///< by the user: neither drawn nor pickable
  bool is_ghost = false;          ///< a neighbour, by the user: translucent, not pickable

  bool isBeside() const { return loaded > 0; }
  bool isPointedAt() const { return !is_hidden && !is_ghost; }

  Rigid3 pose() const { return dragged.value_or(T_world_object); }
  bool isMoved() const;
};

struct SceneHit {
  std::uint32_t id = 0;
  SurfaceHit on_surface;  ///< world frame
};

/// Not thread-safe.
class LiveScene {
 public:
  void clear();
  /// Labels of coming objects, by id; the others are "piece 1", "piece 2", ...
  void setLabels(PieceLabels labels) { labels_ = std::move(labels); }
  void update(std::span<const ObjectChunks> chunks, const HapticReport& report);

  /// Objects in the picture, including hidden ones, in the order of the simulation: pieces of a split by size.
  std::span<SceneObject* const> shown() const { return shown_; }
  /// Number of shown pieces of the worked-on object; 1 if it is whole.
  std::size_t pieceCount() const;
  /// Null if not in the picture.
  SceneObject* find(std::uint32_t id) const;

  std::size_t triangleCount() const;
  Box3 bounds() const;  ///< world frame, without hidden objects
  /// Nearest hit on an object that is neither hidden nor a ghost.
  std::optional<SceneHit> hit(const Ray& ray) const;
  /// LiveSurface::contour() of all objects not hidden, at their poses; world frame.
  std::vector<std::array<Vec3d, 2>> contour(const Plane& plane, const Box3& within) const;

 private:
  SceneObject& objectOf(std::uint32_t id);

  std::vector<std::unique_ptr<SceneObject>> objects_;
  std::vector<SceneObject*> shown_;
  PieceLabels labels_;  // of objects still to come
};

/// A ray in the frame of an object.
Ray inFrame(const Rigid3& T_world_object, const Ray& ray);

}  // namespace kerf
