#include "ui/app/stroke_pointer.h"

#include <utility>

#include "ui/app/pointing.h"

namespace kerf {
namespace {

Ray rayAt(const AppContext& context, const Pixel& at) {
  return rayUnder(context.camera, at[0], at[1], context.width, context.height);
}

}  // namespace

void StrokePointer::move(AppContext& context, const Pixel& cursor, const HeldKeys& held) {
  const Pixel moved = cursor - std::exchange(cursor_, cursor);
  Workbench& bench = context.bench;
  if (bench.isPressed()) {
    at_ += moved;
    return bench.drag(rayAt(context, at_));
  }
  if (!held.alt) {
    at_ = cursor;
    return;
  }
  bench.tilt = tiltedBy(bench.tilt, context.camera, moved[0], moved[1]);
  tapped_.reset();
}

bool StrokePointer::press(AppContext& context, const Pixel& cursor) {
  if (cursor != std::exchange(cursor_, cursor)) at_ = cursor;
  return context.bench.press(rayAt(context, at_));
}

void StrokePointer::tapAlt(AppContext& context, double now) {
  const bool is_second = tapped_ && now - *tapped_ <= kDoubleTap;
  tapped_ = is_second ? std::nullopt : std::optional(now);
  if (is_second) context.bench.tilt = {};
}

}  // namespace kerf
