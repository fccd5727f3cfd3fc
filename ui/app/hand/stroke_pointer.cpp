#include "ui/app/hand/stroke_pointer.h"

#include <utility>

#include "ui/app/commands/pointing.h"

namespace kerf {
namespace {

Ray rayAt(const AppContext& context, const Pixel& at) {
  return rayUnder(context.camera, at[0], at[1], context.width, context.height);
}

}  // namespace

void StrokePointer::move(AppContext& context, const Pixel& cursor, const HeldKeys& held) {
  const Pixel moved = cursor - std::exchange(cursor_, cursor);
  Workbench& bench = context.bench;
  const bool leads = bench.isPressed() && !bench.isOnPedal();
  if (leads && held.ctrl) return bench.moveAlong(kAlongAPixel * moved[1]);
  if (leads) {
    at_ += moved;
    return bench.drag(rayAt(context, at_));
  }
  if (!held.alt || bench.isPressed()) {
    at_ = cursor;
    return;
  }
  bench.tilt = tiltedBy(bench.tilt, context.camera, moved[0], moved[1]);
  tapped_.reset();
}

bool StrokePointer::press(AppContext& context, const Pixel& cursor) {
  if (cursor != std::exchange(cursor_, cursor)) at_ = cursor;
  return pressThere(context);
}

void StrokePointer::release(AppContext& context) {
  if (!context.bench.isOnPedal()) context.bench.release();
}

void StrokePointer::nudge(AppContext& context, const Vec3d& direction, const HeldKeys& held) {
  Workbench& bench = context.bench;
  if (!bench.isPressed()) return;
  const double step = held.ctrl ? 0.01 : held.shift ? 1 : 0.1;
  const Vec3d mm = step * direction;

  if (mm[2] != 0) return bench.moveAlong(mm[2]);
  bench.nudge(context.camera, mm[0], mm[1]);
  viewHasTurned(context);
}

void StrokePointer::lead(AppContext& context, const Eigen::Vector2d& mm) {
  if (context.bench.isPressed()) {
    context.bench.nudge(context.camera, mm[0], mm[1]);
    return viewHasTurned(context);
  }
  at_ += Pixel(mm[0], -mm[1]) / context.camera.mmPerPixel(context.height);
  at_ = at_.cwiseMax(Pixel::Zero()).cwiseMin(Pixel(context.width, context.height));
}

bool StrokePointer::pressThere(AppContext& context) { return context.bench.press(rayAt(context, at_)); }

void StrokePointer::viewHasTurned(const AppContext& context) {
  const Workbench& bench = context.bench;
  if (!bench.isPressed() || bench.isOnPedal()) return;
  const auto at = pixelOf(context.camera, bench.strokePointer(), context.width, context.height);
  at_ = {at[0], at[1]};
}

void StrokePointer::tapAlt(AppContext& context, double now) {
  const bool is_second = tapped_ && now - *tapped_ <= kDoubleTap;
  tapped_ = is_second ? std::nullopt : std::optional(now);
  if (is_second) context.bench.tilt = {};
}

}  // namespace kerf
