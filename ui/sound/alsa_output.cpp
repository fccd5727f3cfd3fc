#include "ui/sound/alsa_output.h"

#include <alsa/asoundlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace kerf {
namespace {

constexpr unsigned kLatencyUs = 40000;
constexpr int kWaitMs = 100, kMostTries = 10;  // for one block

tl::unexpected<Error> refuse(int code) {
  return fail({.code = Error::Code::kUnsupported,
               .place = "sound",
               .found = std::string("ALSA's device \"default\": ") + snd_strerror(code),
               .expected = "a sound card",
               .hint = "aplay -l lists the devices"});
}

void ignoreMessage(const char*, int, const char*, int, const char*, ...) {}

// Non-blocking: Kerf gives up a hanging device, and its thread can end.
class AlsaOutput final : public SoundOutput {
 public:
  explicit AlsaOutput(snd_pcm_t* pcm) : pcm_(pcm) {}
  ~AlsaOutput() override { snd_pcm_close(pcm_); }
  AlsaOutput(const AlsaOutput&) = delete;
  AlsaOutput& operator=(const AlsaOutput&) = delete;

  Expected<void> write(std::span<const float> samples) override {
    frames_.resize(samples.size());
    for (std::size_t n = 0; n < samples.size(); ++n)
      frames_[n] = static_cast<std::int16_t>(std::lround(32767 * std::clamp(samples[n], -1.0f, 1.0f)));

    int tries = 0;
    for (std::size_t done = 0; done < frames_.size();) {
      const snd_pcm_sframes_t written = snd_pcm_writei(pcm_, frames_.data() + done, frames_.size() - done);
      if (written >= 0) {
        done += static_cast<std::size_t>(written);
      } else if (++tries > kMostTries) {
        return refuse(-EIO);
      } else if (written == -EAGAIN) {
        snd_pcm_wait(pcm_, kWaitMs);
      } else if (const int failed = snd_pcm_recover(pcm_, static_cast<int>(written), 1); failed < 0) {
        return refuse(failed);
      }
    }
    return {};
  }

 private:
  snd_pcm_t* pcm_;
  std::vector<std::int16_t> frames_;
};

}  // namespace

Expected<std::unique_ptr<SoundOutput>> openAlsa() {
  // Kerf reports a failure itself, once.
  snd_lib_error_set_handler(ignoreMessage);

  snd_pcm_t* pcm = nullptr;
  const int opened = snd_pcm_open(&pcm, "default", SND_PCM_STREAM_PLAYBACK, SND_PCM_NONBLOCK);
  if (opened < 0) return refuse(opened);
  auto output = std::make_unique<AlsaOutput>(pcm);

  constexpr int kResample = 1, kChannels = 1;
  const int set = snd_pcm_set_params(pcm, SND_PCM_FORMAT_S16, SND_PCM_ACCESS_RW_INTERLEAVED, kChannels,
                                     static_cast<unsigned>(SoundOutput::kRate), kResample, kLatencyUs);
  if (set < 0) return refuse(set);
  return output;
}

}  // namespace kerf
