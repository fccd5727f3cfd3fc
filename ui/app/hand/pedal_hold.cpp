#include "ui/app/hand/pedal_hold.h"

#include <algorithm>
#include <utility>

#include "ui/app/workbench/strokes.h"

namespace kerf {

void PedalHold::update(AppContext& context, StrokePointer& pointer, double pedal) {
  Workbench& bench = context.bench;
  if (holds_ && !bench.strokes->isPressed()) {
    holds_ = false;
    is_spent_ = true;
  }
  if (pedal <= 0) {
    is_spent_ = false;
    if (std::exchange(holds_, false)) runIfEnabled(context, "cut.release");
    return;
  }

  if (!holds_ && !is_spent_ && !bench.strokes->isPressed()) holds_ = pointer.pressThere(context);
  if (holds_) runIfEnabled(context, "cut.drill", wordsOf({100 * std::min(pedal, 1.0)}));
}

}  // namespace kerf
