#include "sim/run/files/log_sink.h"

#include <string>

namespace kerf {

void LogSink::flush() {
  if (!batch_.empty()) writer_.addSamples(first_, batch_);
  batch_.clear();
  // close() reports a full disk: the writer keeps its first error.
  static_cast<void>(writer_.write());
}

void LogSink::sample(const DeviceSample& sample, std::uint64_t tick) noexcept {
  if (batch_.size() == kBatch) flush();
  if (batch_.empty()) first_ = tick;
  batch_.push_back(sample);
  last_ = tick;
}

void LogSink::command(const Command& command, std::uint64_t tick) noexcept {
  flush();
  writer_.add(tick, SessionCommand{printCommand(command)});
}

void LogSink::mark(StrokeMark mark, std::uint64_t tick) noexcept {
  flush();
  writer_.add(tick, mark);
}

void LogSink::check(const StateCheck& check, std::uint64_t tick) noexcept {
  flush();
  writer_.add(tick, check);
}

void LogSink::snapshot(std::span<const std::byte> state, std::uint64_t tick) noexcept {
  flush();
  // Omits a state too large for a snapshot: the log is complete without it.
  if (const auto packed = packSnapshot(state)) writer_.add(tick, *packed);
}

Expected<void> LogSink::close() {
  flush();
  return writer_.close(last_);
}

}  // namespace kerf
