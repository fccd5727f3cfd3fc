// Lines to a serial port that never waits: each arrives whole or not at all.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <string>
#include <string_view>

namespace bridge {

class SerialWriter {
 public:
  /// @param fd  non-blocking; stays the caller's.
  explicit SerialWriter(int fd) : fd_(fd) {}

  /// Sends the rest of the last line first, then this line. Drops this line if the port is full: it would be old later.
  /// @return  false: the port is gone.
  bool write(std::string_view line) {
    if (!send(rest_)) return false;
    if (!rest_.empty()) return true;
    std::string_view left = line;
    if (!send(left)) return false;
    if (left.size() < line.size()) rest_ = left;
    return true;
  }

 private:
  // Removes the sent bytes.
  template <class Text>
  bool send(Text& text) {
    if (text.empty()) return true;
    const auto size = ::write(fd_, text.data(), text.size());
    if (size < 0) return errno == EAGAIN || errno == EINTR;
    text = text.substr(static_cast<std::size_t>(size));
    return true;
  }

  const int fd_;
  std::string rest_;
};

}  // namespace bridge
