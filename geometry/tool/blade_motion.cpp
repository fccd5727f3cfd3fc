#include "geometry/tool/blade_motion.h"

namespace kerf {

// One source each, which defines the row.
extern const BladeMotion kReciprocatingBlade, kPiezoBlade, kSagittalBlade, kDiscBlade;

namespace {
constexpr const BladeMotion* kMotions[] = {&kReciprocatingBlade, &kPiezoBlade, &kSagittalBlade, &kDiscBlade};
}  // namespace

std::span<const BladeMotion* const> bladeMotions() { return kMotions; }

const BladeMotion* findBladeMotion(const std::string& name) {
  for (const BladeMotion* motion : kMotions)
    if (name == motion->name) return motion;
  return nullptr;
}

}  // namespace kerf
