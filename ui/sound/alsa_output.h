// The sound card, by ALSA's device "default": on a desktop that is its mixer.
#pragma once

#include "ui/sound/sound_output.h"

namespace kerf {

/// Any thread; may take a second. The device buffers about 40 ms of sound.
/// Error kUnsupported: no device, the device is in use, or Kerf was built without ALSA.
Expected<std::unique_ptr<SoundOutput>> openAlsa();

}  // namespace kerf
