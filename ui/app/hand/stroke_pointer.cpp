#include "ui/app/hand/stroke_pointer.h"

#include <algorithm>
#include <initializer_list>
#include <numbers>
#include <utility>

#include "ui/app/commands/pointing.h"
#include "ui/app/workbench/strokes.h"

namespace kerf {
namespace {

constexpr double kMostAtOnce = 10;  // mm
constexpr double kPointerDegree = std::numbers::pi / 180;

// A place beside the object is no error.
bool runs(AppContext& context, const char* command, std::initializer_list<double> numbers) {
  return runAppCommand(context, command, wordsOf(numbers)).has_value();
}

}  // namespace

void StrokePointer::move(AppContext& context, const Pixel& cursor, const HeldKeys& held) {
  const Pixel moved = cursor - std::exchange(cursor_, cursor);
  Workbench& bench = context.bench;
  const bool leads = bench.strokes->isPressed() && !bench.strokes->isOnPedal();
  if (leads && held.ctrl) {
    runs(context, "cut.nudge", {0, 0, std::clamp(kAlongAPixel * moved[1], -kMostAtOnce, kMostAtOnce)});
    return;
  }
  if (leads) {
    at_ += moved;
    runs(context, "cut.drag", {at_[0], at_[1]});
    return;
  }
  if (!held.alt || bench.strokes->isPressed()) {
    at_ = cursor;
    return;
  }
  const Tilt tilt = tiltedBy(bench.strokes->tilt, context.camera, moved[0], moved[1]);
  runs(context, "tool.tilt",
       {std::min(tilt.angle, Tilt::kMost) / kPointerDegree, azimuthInView(context.camera, tilt) / kPointerDegree});
  tapped_.reset();
}

bool StrokePointer::press(AppContext& context, const Pixel& cursor) {
  if (cursor != std::exchange(cursor_, cursor)) at_ = cursor;
  return pressThere(context);
}

void StrokePointer::release(AppContext& context) {
  if (!context.bench.strokes->isOnPedal()) runs(context, "cut.release", {});
}

void StrokePointer::nudge(AppContext& context, const Vec3d& direction, const HeldKeys& held) {
  Workbench& bench = context.bench;
  if (!bench.strokes->isPressed()) return;
  const double step = held.ctrl ? 0.01 : held.shift ? 1 : 0.1;
  const Vec3d mm = step * direction;

  runs(context, "cut.nudge", {mm[0], mm[1], mm[2]});
  if (mm[2] == 0) viewHasTurned(context);
}

void StrokePointer::lead(AppContext& context, const Eigen::Vector2d& mm) {
  if (context.bench.strokes->isPressed()) {
    runs(context, "cut.nudge", {mm[0], mm[1], 0});
    return viewHasTurned(context);
  }
  at_ += Pixel(mm[0], -mm[1]) / context.camera.mmPerPixel(context.height);
  at_ = at_.cwiseMax(Pixel::Zero()).cwiseMin(Pixel(context.width, context.height));
}

bool StrokePointer::pressThere(AppContext& context) { return runs(context, "cut.press", {at_[0], at_[1]}); }

void StrokePointer::viewHasTurned(const AppContext& context) {
  const Workbench& bench = context.bench;
  if (!bench.strokes->isPressed() || bench.strokes->isOnPedal()) return;
  const auto at = pixelOf(context.camera, bench.strokes->pointer(), context.width, context.height);
  at_ = {at[0], at[1]};
}

void StrokePointer::tapAlt(AppContext& context, double now) {
  const bool is_second = tapped_ && now - *tapped_ <= kDoubleTap;
  tapped_ = is_second ? std::nullopt : std::optional(now);
  if (is_second) runs(context, "tool.tilt-reset", {});
}

}  // namespace kerf
