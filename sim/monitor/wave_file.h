// A sound as a file that any player opens: RIFF WAVE, one channel, 16 bits a sample.
#pragma once

#include <filesystem>
#include <fstream>
#include <span>

#include "geometry/base/error.h"

namespace kerf::internal {

/// Writes the sound as it is made. Not atomic: write into a staging folder.
class WaveFile {
 public:
  /// @param rate  samples per second.
  WaveFile(const std::filesystem::path& path, std::uint32_t rate);
  /// Values in [-1, 1]; larger ones are clipped.
  void add(std::span<const float> samples);
  /// Puts the lengths into the head. Error kWriteFailed: the disk is full, or more than 4 GB.
  Expected<void> close();

 private:
  std::filesystem::path path_;
  std::ofstream out_;
  std::uint32_t rate_;
  std::uint64_t samples_ = 0;
};

}  // namespace kerf::internal
