#include "ui/app/hand/space_mouse_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kerf {
namespace {

using Limits = SpaceMouseLimits;

bool isDown(const SpaceMouseState& state, int button) { return state.buttons >> (button - 1) & 1; }

}  // namespace

std::array<double, 6> settledAxes(const std::array<double, 6>& axes, const SpaceMouseSettings& settings) {
  std::array<double, 6> out{};
  for (std::size_t n = 0; n < out.size(); ++n) {
    const double size = std::min(std::abs(axes[n]), 1.0);
    if (!(size > settings.dead_band)) continue;
    const double sign = (axes[n] < 0) != settings.is_inverted[n] ? -1 : 1;
    out[n] = sign * (size - settings.dead_band) / (1 - settings.dead_band);
  }
  if (!settings.is_dominant) return out;

  const auto smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const auto largest = std::max_element(out.begin(), out.end(), smaller);
  const double kept = *largest;
  out.fill(0);
  *largest = kept;
  return out;
}

SpaceMouseWish wishOf(const SpaceMouseState& now, const SpaceMouseState& before, const SpaceMouseSettings& settings,
                      const Camera& camera, int height, double seconds) {
  const std::array<double, 6> axes = settledAxes(now.axes, settings);
  const double time = settings.gain * std::clamp(seconds, 0.0, Limits::kLongest);
  const double pushed = Limits::kViewHeights * time * height;  // pixels, fully

  SpaceMouseWish out;
  if (settings.leads == SpaceMouseLeads::kNothing) return out;
  out.undoes = isDown(now, 2) && !isDown(before, 2);
  out.changes = isDown(now, 1) && !isDown(before, 1);
  out.orbit = Limits::kOrbitSpeed * time * Eigen::Vector2d(axes[5], axes[3]);
  if (settings.leads == SpaceMouseLeads::kView) {
    out.pan = pushed * Eigen::Vector2d(axes[0], -axes[2]);
    out.zoom = std::exp(-Limits::kZoom * time * axes[1]);
    return out;
  }

  out.tool_mm = pushed * camera.mmPerPixel(height) * Eigen::Vector2d(axes[0], axes[1]);
  const double most = Limits::kToolSpeed * std::clamp(seconds, 0.0, Limits::kLongest);
  if (const double size = out.tool_mm.norm(); size > most) out.tool_mm *= most / size;
  out.pedal = std::clamp((-axes[2] - Limits::kPedalRest) / (1 - Limits::kPedalRest), 0.0, 1.0);
  return out;
}

void SpaceMouseHand::update(AppContext& context, StrokePointer& pointer, const SpaceMouseSettings& settings,
                            const std::optional<SpaceMouseState>& now, double seconds) {
  const SpaceMouseState state = now.value_or(SpaceMouseState{});
  const SpaceMouseWish wish =
      wishOf(state, std::exchange(before_, state), settings, context.camera, context.height, seconds);
  const bool views = !wish.orbit.isZero(0) || !wish.pan.isZero(0) || wish.zoom != 1;
  is_used_ = views || !wish.tool_mm.isZero(0) || wish.pedal > 0;

  if (views) {
    orbit(context.camera, wish.orbit[0], wish.orbit[1]);
    pan(context.camera, wish.pan[0], wish.pan[1], context.height);
    zoomBy(context.camera, wish.zoom);
    pointer.viewHasTurned(context);
  }
  if (!wish.tool_mm.isZero(0)) pointer.lead(context, wish.tool_mm);
  pedal_.update(context, pointer, wish.pedal);

  if (wish.undoes) runIfEnabled(context, "edit.undo");
  if (wish.changes) runIfEnabled(context, "device.leads");
}

}  // namespace kerf
