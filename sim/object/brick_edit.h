// The newest values of one brick: the message from the cutting thread to its subscribers.
#pragma once

#include "geometry/field/brick_field.h"

namespace kerf {

struct BrickEdit {
  Vec3i brick = Vec3i::Zero();  ///< brick coordinate; its first node is 8 times that
  BrickValues phi{};            ///< all its nodes, mm, finite, negative inside; z fastest
};

}  // namespace kerf
