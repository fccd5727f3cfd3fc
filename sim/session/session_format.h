// The bytes of a session log, versions 1 and 2, shared by its writer, reader and recorder.
// docs/reference/file-formats.md has them.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sim/session/session_log.h"

namespace kerf::internal {

inline constexpr std::array<char, 8> kLogMagic = {'K', 'E', 'R', 'F', 'L', 'O', 'G', '\n'};
inline constexpr std::uint32_t kLogVersion = 2;        // written version
inline constexpr std::uint32_t kOldestLogVersion = 1;  // oldest readable version: without packed samples
inline constexpr std::size_t kFileHead = 16;           // magic, version, length of the text block
inline constexpr std::size_t kRecordHead = 20;         // kind, length, tick, checksum
inline constexpr std::size_t kChecksum = 4;

enum RecordKind : std::uint32_t {
  kSamplesRecord = 1,
  kCommandRecord = 2,
  kCheckRecord = 3,
  kSnapshotRecord = 4,
  kStrokeRecord = 5,
  kGapRecord = 6,
  kEndRecord = 7,
  kPackedSamplesRecord = 8,  // since version 2, replaces kSamplesRecord
  kMaySkip = 0x80000000u     // set in kinds that a reader may skip if unknown
};

inline constexpr std::size_t kSampleBytes = 9 * 8 + 4;
inline constexpr std::size_t kCheckBytes = 7 * 8;

/// Writes numbers in little-endian order, on any machine. Doubles keep every bit, NaN and -0 included.
class BytePacker {
 public:
  explicit BytePacker(std::byte* to) : to_(to) {}
  BytePacker& u32(std::uint32_t v) noexcept { return put(v); }
  BytePacker& u64(std::uint64_t v) noexcept { return put(v); }
  BytePacker& f64(double v) noexcept { return put(std::bit_cast<std::uint64_t>(v)); }
  BytePacker& vec(const Vec3d& v) noexcept { return f64(v[0]).f64(v[1]).f64(v[2]); }

 private:
  template <class T>
  BytePacker& put(T v) noexcept {
    for (std::size_t i = 0; i < sizeof(T); ++i) *to_++ = static_cast<std::byte>(v >> (8 * i));
    return *this;
  }
  std::byte* to_;
};

/// Inverse. @pre the bytes are there.
class ByteUnpacker {
 public:
  explicit ByteUnpacker(const std::byte* from) : from_(from) {}
  std::uint32_t u32() { return get<std::uint32_t>(); }
  std::uint64_t u64() { return get<std::uint64_t>(); }
  double f64() { return std::bit_cast<double>(u64()); }
  Vec3d vec() {
    const double x = f64(), y = f64();
    return {x, y, f64()};
  }

 private:
  template <class T>
  T get() {
    T v = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) v |= static_cast<T>(std::to_integer<T>(*from_++) << (8 * i));
    return v;
  }
  const std::byte* from_;
};

/// @rt safe. The structured bindings name every field: one more in the struct does not compile until it is packed.
inline void pack(const DeviceSample& sample, std::span<std::byte, kSampleBytes> to) noexcept {
  const auto& [pose, pedal, irrigation, is_valid] = sample;
  const auto& [rotation, translation] = pose;
  BytePacker(to.data()).f64(rotation.w()).vec(rotation.vec()).vec(translation).f64(pedal).f64(irrigation).u32(is_valid);
}
inline DeviceSample unpackSample(const std::byte* from) {
  ByteUnpacker in(from);
  DeviceSample sample;
  sample.T_world_device.rotation.w() = in.f64();
  sample.T_world_device.rotation.vec() = in.vec();
  sample.T_world_device.translation = in.vec();
  sample.pedal = in.f64();
  sample.irrigation = in.f64();
  sample.is_valid = in.u32();
  return sample;
}

/// @rt safe.
inline void pack(const StateCheck& check, std::span<std::byte, kCheckBytes> to) noexcept {
  const auto& [state_hash, wrench] = check;
  const auto& [force, torque] = wrench;
  BytePacker(to.data()).u64(state_hash).vec(force).vec(torque);
}

inline StateCheck unpackCheck(const std::byte* from) {
  ByteUnpacker in(from);
  StateCheck check;
  check.state_hash = in.u64();
  check.force.force = in.vec();
  check.force.torque = in.vec();
  return check;
}

/// CRC-32 (the one of zlib, PNG and Ethernet) of all so far and `bytes`. Start with 0.
std::uint32_t checksum(std::uint32_t so_far, std::span<const std::byte> bytes);

}  // namespace kerf::internal
