// How fast a tool erodes: what the force of this evaluation and the erosion after it must agree on.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "sim/step/contact.h"
#include "sim/step/erode_brick.h"

namespace kerf::internal {

inline Lever leverOf(const ToolModel& tool) {
  constexpr float kEquatorFloor = 0.2f;  // the axis of a bur does not stand still: of the equator's speed
  const LeverForm form = tool.motion == ToolMotion::kSpin    ? LeverForm::kRadius
                         : tool.motion == ToolMotion::kSwing ? LeverForm::kPivot
                                                             : LeverForm::kOne;
  return {form, kEquatorFloor * static_cast<float>(tool.equator_mm), static_cast<float>(tool.pivot_mm)};
}

/// Rate of erosion times time, c dt, over the lever of the tool's own motion: by the number of a material. See erode().
struct ErosionRates {
  std::array<float, 256> value;

  explicit ErosionRates(const ContactInput& in) {
    // Read once: the compiler cannot know that writing a rate does not change them.
    const Tissue* const tissues = in.tissues->data();
    const double speed = std::abs(in.speed), drag = in.tool->drive.drag_factor, energy = in.tool->drive.energy_factor;
    const double dt = in.dt, load_scale = in.load_scale;
    for (std::size_t m = 0; m < value.size(); ++m) {
      const Tissue& t = tissues[m];
      value[m] = static_cast<float>(static_cast<double>(t.friction * t.stiffness * t.inverse_energy) * speed * drag /
                                    energy * dt * load_scale);
    }
  }
};

}  // namespace kerf::internal
