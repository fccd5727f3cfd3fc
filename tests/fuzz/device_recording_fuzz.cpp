// Recordings of devices.
#include <string_view>

#include "sim/device/record/device_recording.h"
#include "tests/fuzz/harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto read = kerf::parseRecording({reinterpret_cast<const char*>(data), size}, "x");
  if (!read) {
    kerf::fuzz::require(!read.error().found.empty() && !read.error().expected.empty(), "an error says what is wrong");
    return 0;
  }
  const bool is_arm = !read->arm.empty();
  kerf::fuzz::require((read->driver != nullptr) != is_arm, "a recording is of axes or of an arm");
  if (!is_arm)
    kerf::fuzz::require(kerf::replayRecording(*read).size() == read->reports.size(), "a reading for each report");
  const kerf::RecordedHands replayed = kerf::replayHands(*read);
  kerf::fuzz::require(replayed.hands.size() + replayed.refused <= read->reports.size(), "a hand is of a report");
  for (const kerf::RecordedHand& hand : replayed.hands)
    kerf::fuzz::require(hand.hand.pose.isUsable(), "a pose that is taken can be computed with");
  return 0;
}
