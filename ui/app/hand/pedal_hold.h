// A trigger or a knob as the foot pedal: begins, leads and ends a stroke.
#pragma once

#include "ui/app/hand/stroke_pointer.h"

namespace kerf {

class PedalHold {
 public:
  /// Once a frame.   @param pedal  0 (rest) to 1. Above rest a stroke begins at the tool; at rest it ends. If something
  /// else ended the stroke, the pedal must return to rest first.
  void update(AppContext& context, StrokePointer& pointer, double pedal);
  bool holds() const { return holds_; }

 private:
  bool holds_ = false;
  bool is_spent_ = false;
};

}  // namespace kerf
