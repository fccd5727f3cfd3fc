#include "ui/app/hand/stroke_pointer.h"

#include <utility>

#include "ui/app/commands/pointing.h"
#include "ui/app/workbench/strokes.h"

namespace kerf {
namespace {

Ray rayAt(const AppContext& context, const Pixel& at) {
  return rayUnder(context.camera, at[0], at[1], context.width, context.height);
}

}  // namespace

void StrokePointer::move(AppContext& context, const Pixel& cursor, const HeldKeys& held) {
  const Pixel moved = cursor - std::exchange(cursor_, cursor);
  Workbench& bench = context.bench;
  const bool leads = bench.strokes->isPressed() && !bench.strokes->isOnPedal();
  if (leads && held.ctrl) return bench.strokes->moveAlong(kAlongAPixel * moved[1]);
  if (leads) {
    at_ += moved;
    return bench.strokes->drag(rayAt(context, at_));
  }
  if (!held.alt || bench.strokes->isPressed()) {
    at_ = cursor;
    return;
  }
  bench.strokes->tilt = tiltedBy(bench.strokes->tilt, context.camera, moved[0], moved[1]);
  tapped_.reset();
}

bool StrokePointer::press(AppContext& context, const Pixel& cursor) {
  if (cursor != std::exchange(cursor_, cursor)) at_ = cursor;
  return pressThere(context);
}

void StrokePointer::release(AppContext& context) {
  if (!context.bench.strokes->isOnPedal()) context.bench.strokes->release();
}

void StrokePointer::nudge(AppContext& context, const Vec3d& direction, const HeldKeys& held) {
  Workbench& bench = context.bench;
  if (!bench.strokes->isPressed()) return;
  const double step = held.ctrl ? 0.01 : held.shift ? 1 : 0.1;
  const Vec3d mm = step * direction;

  if (mm[2] != 0) return bench.strokes->moveAlong(mm[2]);
  bench.strokes->nudge(context.camera, mm[0], mm[1]);
  viewHasTurned(context);
}

void StrokePointer::lead(AppContext& context, const Eigen::Vector2d& mm) {
  if (context.bench.strokes->isPressed()) {
    context.bench.strokes->nudge(context.camera, mm[0], mm[1]);
    return viewHasTurned(context);
  }
  at_ += Pixel(mm[0], -mm[1]) / context.camera.mmPerPixel(context.height);
  at_ = at_.cwiseMax(Pixel::Zero()).cwiseMin(Pixel(context.width, context.height));
}

bool StrokePointer::pressThere(AppContext& context) { return context.bench.strokes->press(rayAt(context, at_)); }

void StrokePointer::viewHasTurned(const AppContext& context) {
  const Workbench& bench = context.bench;
  if (!bench.strokes->isPressed() || bench.strokes->isOnPedal()) return;
  const auto at = pixelOf(context.camera, bench.strokes->pointer(), context.width, context.height);
  at_ = {at[0], at[1]};
}

void StrokePointer::tapAlt(AppContext& context, double now) {
  const bool is_second = tapped_ && now - *tapped_ <= kDoubleTap;
  tapped_ = is_second ? std::nullopt : std::optional(now);
  if (is_second) context.bench.strokes->tilt = {};
}

}  // namespace kerf
