// Erosion rates of a tool, shared by an evaluation's force and its erosion.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "sim/step/contact.h"
#include "sim/step/erode_brick.h"

namespace kerf::internal {

inline Lever leverOf(const ToolModel& tool) {
  constexpr float kEquatorFloor = 0.2f;  // of the equator's speed: the axis of a bur does not stand still
  const LeverForm form = tool.motion == ToolMotion::kSpin    ? LeverForm::kRadius
                         : tool.motion == ToolMotion::kSwing ? LeverForm::kPivot
                                                             : LeverForm::kOne;
  return {form, kEquatorFloor * static_cast<float>(tool.equator_mm), static_cast<float>(tool.pivot_mm)};
}

/// The tool turns backwards, and its edges rub with their backs: nothing erodes.
inline bool onlyRubs(const ContactInput& in) { return in.speed < 0 && !in.tool->cuts_backwards; }

/// For one evaluation of contact. Backwards a drill's point is a rubbing cone.
inline LipLever lipsOf(const ContactInput& in) {
  const DrillLips& lips = in.tool->lips;
  if (!lips.areThere() || onlyRubs(in)) return {};
  const double turns = std::abs(in.speed) / (2 * std::numbers::pi) * in.dt;
  const double along_normal = lips.slope * turns;
  return {static_cast<float>(lips.height), static_cast<float>(along_normal * DrillLips::kRubbing),
          static_cast<float>(along_normal * lips.most_feed)};
}

/// Rate of erosion times time, c dt, over the lever of the tool's own motion, by material number. See erode().
struct ErosionRates {
  std::array<float, 256> value;
  /// The same for a drill's lips, over r^0.75: x = turns slope k_n pi r^0.75 / (1.25 K 2^0.25 q), so that an overlap of
  /// a(r) q f0 / k_n only rubs. Only with lips.
  std::array<float, 256> at_lips;

  explicit ErosionRates(const ContactInput& in) {
    if (onlyRubs(in)) {
      value.fill(0);
      at_lips.fill(0);
      return;
    }
    // Read once: the compiler cannot know that writing a rate does not change them.
    const Tissue* const tissues = in.tissues->data();
    const double speed = std::abs(in.speed), drag = in.tool->drive.drag_factor, energy = in.tool->drive.energy_factor;
    const double dt = in.dt, load_scale = in.load_scale;
    for (std::size_t m = 0; m < value.size(); ++m) {
      const Tissue& t = tissues[m];
      value[m] = static_cast<float>(static_cast<double>(t.friction * t.stiffness * t.inverse_energy) * speed * drag /
                                    energy * dt * load_scale);
    }
    if (in.tool->lips.areThere()) setLips(in);
  }

 private:
  void setLips(const ContactInput& in) {
    const double turns = std::abs(in.speed) / (2 * std::numbers::pi) * in.dt;
    constexpr double kTwoToTheQuarter = 1.189207115002721;
    const double over_pressure =
        turns * in.tool->lips.slope * std::numbers::pi / (1.25 * DrillLips::kThrust * kTwoToTheQuarter);
    const Tissue* const tissues = in.tissues->data();
    for (std::size_t m = 0; m < at_lips.size(); ++m) {
      const Tissue& t = tissues[m];
      const double root = std::sqrt(DrillLips::kReference * static_cast<double>(t.inverse_energy));  // 1 / u_s^0.5
      const double per_hardness = root * std::sqrt(root);                                            // 1 / q
      at_lips[m] = static_cast<float>(over_pressure * static_cast<double>(t.stiffness) * per_hardness * in.load_scale);
    }
  }
};

}  // namespace kerf::internal
