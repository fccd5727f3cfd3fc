// A hand pushes a tool that does not turn into something hard: how deep it gets, and whether the force ever falls.
#pragma once

#include <memory>

#include "sim/object/baked_object.h"
#include "sim/step/step.h"

namespace kerf::scenes {

struct SinkScene {
  std::shared_ptr<const BakedObject> object;  ///< its surface is z = 0 of `frame`, the outside above
  Rigid3 frame;                               ///< T_world_surface
  Vec3d first = -Vec3d::UnitZ();              ///< what of the tool goes first, tool frame, unit
  double lean = 0;                            ///< rad, of the tool
  double hand_mm = 4;                         ///< where the hand ends up, below the surface
  double speed = 20;                          ///< of the hand, mm/s
  double rest_s = 0.1;                        ///< how long it stays there
  double turns = 0;                           ///< of its free speed, as it runs down
};

struct Sink {
  double deepest = 0;  ///< mm, of the tool's foremost point, below the surface
  double force = 0;    ///< N, against the push, at the end
  /// N: how far the force fell below what it was since the tool first touched, while the hand went deeper
  double fall = 0;
  int untold = 0;           ///< ticks in which contact pressed, but no object was said to be touched
  std::uint64_t state = 0;  ///< State::hash
};

/// From 0.2 mm above the surface straight down. The pedal is up.
Sink sink(const Model& model, std::size_t tool, const SinkScene& scene);

struct Dig {
  double removed = 0;  ///< mm^3
  double work = 0;     ///< of the drive, N mm
  double depth = 0;    ///< mm, of the tool's foremost point, at the end
  double seconds = 0;  ///< from the first that is removed, until 3 mm deep or all of them
};

/// The same with the drive running, pressed down with a constant force: what it removes. `hand_mm` and `speed` of the
/// scene do not count. Gives up after 2 s.
Dig dig(const Model& model, std::size_t tool, const SinkScene& scene, double force, double seconds);

/// The foremost point of a tool in a direction (unit), tool frame, mm; good to 0.01.
Vec3d foremost(const ToolModel& tool, const Vec3d& direction);

/// Twice the radius of the largest ball inside the tool that touches the plane `behind_mm` behind the foremost point
/// from the side of the shank, mm.
double widthBehind(const ToolModel& tool, const Vec3d& direction, double behind_mm);

}  // namespace kerf::scenes
