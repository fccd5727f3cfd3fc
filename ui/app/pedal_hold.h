// A trigger or a knob as the foot pedal: how a stroke begins, is led and ends by it.
#pragma once

#include <string_view>

#include "ui/app/stroke_pointer.h"

namespace kerf {

class PedalHold {
 public:
  /// Once a frame.   @param pedal  0: at rest; to 1. Above rest a stroke begins where the tool is, and ends with it.
  /// After something else has ended the stroke the pedal has to go to rest first.
  void update(AppContext& context, StrokePointer& pointer, double pedal);
  bool holds() const { return holds_; }

 private:
  bool holds_ = false;
  bool is_spent_ = false;
};

/// As runAppCommand(), for a button: nothing happens when the command can not be given now. Its errors are notices.
void runIfItCan(AppContext& context, std::string_view id);

}  // namespace kerf
