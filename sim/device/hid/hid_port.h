// HID devices of the system, through hidapi. No other file uses hidapi.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geometry/base/error.h"

namespace kerf {

/// One HID interface, as listed by the system. A device may have several.
struct HidInfo {
  std::string path;  ///< of its node, "/dev/hidraw0"
  std::uint16_t vendor = 0, product = 0;
  std::uint16_t usage_page = 0, usage = 0;  ///< of its first application collection
  int interface = -1;                       ///< of USB; -1: not known
  std::string serial;                       ///< may be empty
  /// The same for all interfaces of one plugged-in device.
  std::string parent;
  bool may_open = false;  ///< this user may read and write it
};

/// Every interface, once each, by path. Takes some ms and allocates; not for the 1 kHz thread. Any one thread at a
/// time.
std::vector<HidInfo> listHid();

/// An open interface. One thread may read while others write, and neither waits for the other: its node is open twice,
/// since hidapi allows no two simultaneous calls on one. Writers wait for each other.
class HidPort {
 public:
  /// Errors: kUnreadable, with the udev rule if permission is missing; kNotFound.
  static Expected<HidPort> open(const std::string& path);
  HidPort(HidPort&&) noexcept;
  HidPort& operator=(HidPort&&) noexcept;
  ~HidPort();

  static constexpr std::size_t kLongestReport = 256;  ///< bytes
  /// The oldest waiting report, its number first if it has one.
  /// @param wait_ms  longest wait.
  /// @return  its bytes; 0: none came; negative: the device is gone.
  int read(std::span<std::uint8_t> report, int wait_ms) noexcept;
  /// @param report  its number first; 0 if it has none.   @return  false: not sent.
  /// @cost  about a ms on USB, much longer from a device in trouble.
  bool write(std::span<const std::uint8_t> report) noexcept;

 private:
  struct Handle;
  explicit HidPort(std::unique_ptr<Handle> handle);
  std::unique_ptr<Handle> handle_;
};

}  // namespace kerf
