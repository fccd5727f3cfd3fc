// Recordings of devices.
#include <string_view>

#include "sim/device/device_recording.h"
#include "tests/fuzz/harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto read = kerf::parseRecording({reinterpret_cast<const char*>(data), size}, "x");
  if (!read) {
    kerf::fuzz::require(!read.error().found.empty() && !read.error().expected.empty(), "an error says what is wrong");
    return 0;
  }
  kerf::fuzz::require(read->driver != nullptr, "a recording has a driver");
  kerf::fuzz::require(kerf::replayRecording(*read).size() == read->reports.size(), "a reading for each report");
  return 0;
}
