#include "ui/app/hand/pedal_hold.h"

#include <utility>

#include "ui/app/document/jobs.h"
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
    if (std::exchange(holds_, false)) bench.strokes->release();
    return;
  }

  if (!holds_ && !is_spent_ && !bench.strokes->isPressed()) holds_ = pointer.pressThere(context);
  if (holds_) bench.strokes->drill(pedal);
}

void runIfItCan(AppContext& context, std::string_view id) {
  const AppCommand* const command = findAppCommand(id);
  if (!command->is_enabled(context)) return;
  if (const auto done = command->run(context, {}); !done) context.bench.notices->complain(done.error());
}

}  // namespace kerf
