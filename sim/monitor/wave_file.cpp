#include "sim/monitor/wave_file.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace kerf::internal {
namespace {

void put(std::string& to, std::uint32_t value, int bytes) {
  for (int n = 0; n < bytes; ++n) to.push_back(static_cast<char>(value >> (8 * n) & 255));
}

std::string head(std::uint32_t rate, std::uint32_t bytes) {
  std::string out = "RIFF";
  put(out, 36 + bytes, 4);
  out += "WAVEfmt ";
  put(out, 16, 4);        // length of the rest
  put(out, 1, 2);         // whole numbers, not compressed
  put(out, 1, 2);         // channels
  put(out, rate, 4);      // samples a second
  put(out, 2 * rate, 4);  // bytes a second
  put(out, 2, 2);         // bytes a sample of all channels
  put(out, 16, 2);        // bits a sample
  out += "data";
  put(out, bytes, 4);
  return out;
}

}  // namespace

WaveFile::WaveFile(const std::filesystem::path& path, std::uint32_t rate)
    : path_(path), out_(path, std::ios::binary), rate_(rate) {
  out_ << head(rate_, 0);
}

void WaveFile::add(std::span<const float> samples) {
  std::string bytes;
  bytes.reserve(2 * samples.size());
  for (const float s : samples)
    put(bytes, static_cast<std::uint32_t>(std::lround(32767 * std::clamp(s, -1.0f, 1.0f))), 2);
  out_ << bytes;
  samples_ += samples.size();
}

Expected<void> WaveFile::close() {
  constexpr std::uint64_t kMost = (std::uint64_t{1} << 31) - 64;  // samples: lengths are 32 bits of bytes
  if (samples_ <= kMost) {
    out_.seekp(0);
    out_ << head(rate_, static_cast<std::uint32_t>(2 * samples_));
  }
  out_.close();
  if (out_ && samples_ <= kMost) return {};
  return fail({.code = Error::Code::kWriteFailed,
               .file = path_.string(),
               .found = "could not be written",
               .expected = "space for the sound, at most 4 GB",
               .hint = "free some space, or omit the sound"});
}

}  // namespace kerf::internal
