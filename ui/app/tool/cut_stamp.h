// The state of a session as a value: equal stamps export the same mesh.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/live/haptic_thread.h"
#include "ui/app/view/live_scene.h"

namespace kerf {

struct CutStamp {
  struct Object {
    std::uint32_t id = 0;
    Rigid3 T_world_object;
    std::string name;  ///< part of file names

    bool operator==(const Object& other) const;
  };
  std::uint64_t generation = 0;  ///< of the workbench
  std::uint64_t edits = 0;       ///< changed bricks so far; never falls
  std::vector<Object> objects;   ///< in the scene

  bool operator==(const CutStamp&) const = default;
};

CutStamp cutStampOf(std::uint64_t generation, const HapticReport& report, const LiveScene& scene);

}  // namespace kerf
