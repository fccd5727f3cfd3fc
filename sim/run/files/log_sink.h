// Writes a session log in lockstep, without a thread of its own.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/session/command.h"
#include "sim/session/session.h"
#include "sim/session/session_log.h"

namespace kerf {

/// Collects samples and forwards them in order with all other events. Allocates and writes: not for a real-time thread,
/// which needs SessionRecorder.
class LogSink final : public SessionSink {
 public:
  /// @param writer  kept by reference.
  explicit LogSink(SessionLogWriter& writer) : writer_(writer) { batch_.reserve(kBatch); }
  ~LogSink() override = default;
  void sample(const DeviceSample& sample, std::uint64_t tick) noexcept override;
  void command(const Command& command, std::uint64_t tick) noexcept override;
  void mark(StrokeMark mark, std::uint64_t tick) noexcept override;
  void check(const StateCheck& check, std::uint64_t tick) noexcept override;
  /// Omits a snapshot larger than kMaxSnapshotBytes: a replay then starts from an earlier one.
  void snapshot(std::span<const std::byte> state, std::uint64_t tick) noexcept override;
  /// Writes pending samples and the clean end. Returns the first error.
  Expected<void> close();

 private:
  static constexpr std::size_t kBatch = 1024;
  void flush();

  SessionLogWriter& writer_;
  std::vector<DeviceSample> batch_;  // consecutive, not forwarded yet
  std::uint64_t first_ = 0, last_ = 0;
};

}  // namespace kerf
