// The sound card, by ALSA's device "default": on a desktop that is its mixer.
#pragma once

#include "ui/sound/sound_output.h"

namespace kerf {

/// Any thread; may take a second. About 40 ms of sound wait in the device.
/// Error kUnsupported: there is no device, it is taken, or Kerf was built without ALSA.
Expected<std::unique_ptr<SoundOutput>> openAlsa();

}  // namespace kerf
