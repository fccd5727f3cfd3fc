// A carved field, deterministic or random, as edits of bricks.
#pragma once

#include <random>
#include <vector>

#include "sim/object/overlay_field.h"

namespace kerf::scenes {

/// A ball of radius r (mm) with a hole, of voxel h: stored bricks at its surface, marked bricks inside.
BrickField ballWithAHole(double r, double h);

/// phi <- max(phi, -tau) (or min(phi, tau), adding) with a ball tau, in every stored or unstored brick near the ball.
/// Changes `field` and returns the changed bricks.
std::vector<BrickEdit> carve(OverlayField& field, const Vec3d& center, double radius, bool add = false);

/// A random edit: mostly cuts at the surface, some inside, some additions, some in unstored bricks.
std::vector<BrickEdit> carveAtRandom(OverlayField& field, double r, std::mt19937& random);

}  // namespace kerf::scenes
