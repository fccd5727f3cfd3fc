// All objects of a session as the window knows them: what was loaded, and the pieces that came off.
//
// A piece is shown when its mesher has meshed all that is in the scene; until then what it came off stays in the
// picture, some tenths of a second.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/live/haptic_thread.h"
#include "sim/run/live_run.h"
#include "ui/app/live_surface.h"

namespace kerf {

struct SceneObject {
  std::uint32_t id = 0;           ///< CutObject::id
  std::uint32_t loaded = 0;       ///< ObjectReport::loaded: 0 is worked on, the others stand beside it
  std::string name;               ///< "piece 2", or what a person called it
  std::string colour;             ///< of pieceColours(), by a person; empty: as its tissues are
  Rigid3 T_world_object;          ///< as the simulation has it
  std::optional<Rigid3> dragged;  ///< where a person is about to put it
  LiveSurface surface;            ///< in its own frame: where it was loaded
  double removed_mm3 = 0;         ///< from it; the first of the pieces has what was removed before, too
  std::size_t index = 0;          ///< in the simulation, for commands
  bool is_in_scene = false;       ///< now; an undo or a split takes it out
  bool is_hidden = false;         ///< by a person: neither drawn nor pointed at
  bool is_ghost = false;          ///< a neighbour, by a person: translucent, and not pointed at

  bool isBeside() const { return loaded > 0; }
  bool isPointedAt() const { return !is_hidden && !is_ghost; }

  Rigid3 pose() const { return dragged.value_or(T_world_object); }
  bool isMoved() const;
};

struct SceneHit {
  std::uint32_t id = 0;
  SurfaceHit on_surface;  ///< world frame
};

/// One thread.
class LiveScene {
 public:
  void clear();
  /// Of objects that come, by their id; the others are "piece 1", "piece 2", ...
  void setLabels(PieceLabels labels) { labels_ = std::move(labels); }
  void update(std::span<const ObjectChunks> chunks, const HapticReport& report);

  /// Those in the picture, hidden ones among them: in the order of the simulation, which is by size when they came off.
  std::span<SceneObject* const> shown() const { return shown_; }
  /// Of them, how many are of the object that is worked on: 1, or its pieces.
  std::size_t pieceCount() const;
  /// Null: it is not in the picture.
  SceneObject* find(std::uint32_t id) const;

  std::size_t triangleCount() const;
  Box3 bounds() const;  ///< world frame, of those not hidden
  /// The nearest of those not hidden.
  std::optional<SceneHit> hit(const Ray& ray) const;
  /// LiveSurface::contour() of those not hidden, each where it is; world frame.
  std::vector<std::array<Vec3d, 2>> contour(const Plane& plane, const Box3& within) const;

 private:
  SceneObject& objectOf(std::uint32_t id);

  std::vector<std::unique_ptr<SceneObject>> objects_;
  std::vector<SceneObject*> shown_;
  PieceLabels labels_;  // of those that have not come yet
};

/// A ray as an object sees it.
Ray inFrame(const Rigid3& T_world_object, const Ray& ray);

}  // namespace kerf
