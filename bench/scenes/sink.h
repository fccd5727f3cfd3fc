// A hand pushes a tool at rest into a hard object: its depth, and whether the force ever falls.
#pragma once

#include <memory>

#include "sim/object/baked_object.h"
#include "sim/step/step.h"

namespace kerf::scenes {

struct SinkScene {
  std::shared_ptr<const BakedObject> object;  ///< its surface is z = 0 of `frame`, its outside above
  Rigid3 frame;                               ///< T_world_surface
  Vec3d first = -Vec3d::UnitZ();              ///< foremost direction of the tool, tool frame, unit
  double lean = 0;                            ///< rad, tilt of the tool
  double hand_mm = 4;                         ///< end of the hand's path, below the surface
  double speed = 20;                          ///< of the hand, mm/s
  double rest_s = 0.1;                        ///< rest at the end
  double turns = 0;                           ///< share of its free speed, running down
};

struct Sink {
  double deepest = 0;  ///< mm, depth of the tool's foremost point below the surface
  double force = 0;    ///< N, against the push, at the end
  /// N: largest drop of the force below its maximum since first contact, while the hand goes deeper
  double fall = 0;
  int untold = 0;           ///< ticks with contact force but no reported object
  std::uint64_t state = 0;  ///< State::hash
};

/// Straight down from 0.2 mm above the surface. The pedal is up.
Sink sink(const Model& model, std::size_t tool, const SinkScene& scene);

struct Dig {
  double removed = 0;  ///< mm^3
  double work = 0;     ///< of the drive, N mm
  double depth = 0;    ///< mm, of the tool's foremost point, at the end
  double seconds = 0;  ///< from the first removal, until 3 mm deep or the time limit
};

/// The same with the drive running under a constant force: its removal. Ignores `hand_mm` and `speed` of the scene.
/// Gives up after 2 s.
Dig dig(const Model& model, std::size_t tool, const SinkScene& scene, double force, double seconds);

/// The foremost point of a tool in a direction (unit), tool frame, mm; good to 0.01.
Vec3d foremost(const ToolModel& tool, const Vec3d& direction);

/// Twice the radius of the largest ball inside the tool that touches the plane `behind_mm` behind the foremost point
/// from the side of the shank, mm.
double widthBehind(const ToolModel& tool, const Vec3d& direction, double behind_mm);

}  // namespace kerf::scenes
