#include <algorithm>
#include <string>
#include <variant>

#include "sim/session/command.h"
#include "sim/session/session_format.h"
#include "tests/fuzz/harness.h"

// Any text is either a command that survives printing and parsing, or an error with a reason.
static void requireCommand(const std::string& text) {
  using namespace kerf;
  const Expected<Command> command = parseCommand(text);
  if (!command) {
    fuzz::require(!command.error().found.empty() && !command.error().expected.empty(), "a refusal says what is wrong");
    return;
  }
  const Expected<Command> again = parseCommand(printCommand(*command));
  fuzz::require(again && *again == *command, "a command that is printed is the same when it is read");
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  const Expected<SessionLog> log = parseSessionLog(std::as_bytes(std::span(data, size)), "input.kerflog");
  if (!log) {
    const Error& error = log.error();
    fuzz::require(!error.file.empty() && !error.place.empty() && !error.found.empty(), "an error says where and what");
    fuzz::require(error.message().size() < 4096, "an error can be read");
    return 0;
  }
  for (std::size_t i = 1; i < log->samples.size(); ++i)
    fuzz::require(log->samples[i - 1].tick < log->samples[i].tick, "ticks increase");
  std::size_t before = 0;
  for (const SessionEvent& event : log->events) {
    fuzz::require(event.samples_before >= before && event.samples_before <= log->samples.size(), "events are in order");
    before = event.samples_before;
    if (const auto* snapshot = std::get_if<SessionSnapshot>(&event.what))
      if (const auto bytes = unpackSnapshot(*snapshot); bytes)
        fuzz::require(bytes->size() == snapshot->size, "a snapshot is as large as it says");
    if (const auto* text = std::get_if<SessionCommand>(&event.what)) requireCommand(text->text);
  }
  if (log->damage)
    fuzz::require(log->damage->at_byte < size && log->damage->at_byte + log->damage->lost_bytes == size &&
                      !log->damage->what.empty(),
                  "damage says where it is and what is lost");
  constexpr std::size_t kLeastRecord = internal::kRecordHead + internal::kChecksum;
  const std::size_t packed = log->samples.size() / internal::kMostPackedSamples;
  const std::size_t least = kLeastRecord * (packed + log->events.size() + log->skipped);
  fuzz::require(least <= size, "nothing is read that is not there");
  return 0;
}

// Mutations hardly ever keep a checksum valid. Half of the inputs get valid checksums, so that the code behind the
// check runs.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most) __attribute__((weak));
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  using namespace kerf::internal;
  size = LLVMFuzzerMutate(data, size, most);
  if (seed % 2 == 0) return size;
  auto* const bytes = reinterpret_cast<std::byte*>(data);
  std::uint32_t sum = 0;
  std::size_t at = 0;
  // `length` bytes and their checksum; false where the input ends.
  const auto seal = [&](std::size_t length) {
    if (size - at < kChecksum || size - at - kChecksum < length) return false;
    sum = checksum(sum, {bytes + at, length});
    BytePacker(bytes + at + length).u32(sum);
    at += length + kChecksum;
    return true;
  };
  if (size < kFileHead || !seal(kFileHead + ByteUnpacker(bytes + kFileHead - 4).u32())) return size;
  while (seal(kRecordHead - kChecksum) && seal(ByteUnpacker(bytes + at - kRecordHead + 4).u32())) {
  }
  return size;
}
