// Replaces alsa_output.cpp if ALSA's headers are missing.
#include "ui/sound/alsa_output.h"

namespace kerf {

Expected<std::unique_ptr<SoundOutput>> openAlsa() {
  return fail({.code = Error::Code::kUnsupported,
               .place = "sound",
               .found = "this Kerf was built without ALSA",
               .expected = "libasound2-dev when it is built",
               .hint = "scripts/setup, then build again"});
}

}  // namespace kerf
