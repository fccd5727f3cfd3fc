// A field that is carved, by plan or at random, as edits of bricks.
#pragma once

#include <random>
#include <vector>

#include "sim/object/overlay_field.h"

namespace kerf::scenes {

/// A ball of radius r (mm) with a hole, of voxel h: stored bricks at its surface, marked ones inside.
BrickField ballWithAHole(double r, double h);

/// phi <- max(phi, -tau) (or min(phi, tau), adding) with a ball tau, in every brick the ball comes near to, stored or
/// not. Returns the bricks that changed, and changes `field`.
std::vector<BrickEdit> carve(OverlayField& field, const Vec3d& center, double radius, bool add = false);

/// One of many: mostly cuts at the surface, some inside, some additions, some that go where nothing was stored.
std::vector<BrickEdit> carveAtRandom(OverlayField& field, double r, std::mt19937& random);

}  // namespace kerf::scenes
