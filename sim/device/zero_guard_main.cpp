// kerf-zero-guard PATH REPORT...: takes the force of a device away when who started it is killed. Started by
// zero_guard.cpp, by nobody else.
//
//   PATH     node of the device: kept open
//   REPORT   bytes as hexadecimal digits: each is one write, in this order
//   input    a socket. It says one byte when the node is open, and waits: for a byte, then it ends; for the end, which
//            the other process makes, or the system however that one ends, then it writes the reports
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <csignal>
#include <span>
#include <string_view>
#include <vector>

namespace {

using Report = std::vector<unsigned char>;

bool readReport(std::string_view digits, Report& out) {
  if (digits.empty() || digits.size() % 2 != 0) return false;
  for (; !digits.empty(); digits.remove_prefix(2)) {
    unsigned byte = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + 2, byte, 16);
    if (error != std::errc() || end != digits.data() + 2) return false;
    out.push_back(static_cast<unsigned char>(byte));
  }
  return true;
}

// A serial port whose buffer is full is waited for, and may take a part first; what a device that is gone says is
// nothing to be mended.
void writeReport(int device, std::span<const unsigned char> left) {
  constexpr int kTries = 50, kWaitMs = 20;
  for (int n = 0; n < kTries && !left.empty(); ++n) {
    const ssize_t size = ::write(device, left.data(), left.size());
    if (size > 0) {
      left = left.subspan(static_cast<std::size_t>(size));
      continue;
    }
    if (size < 0 && errno != EAGAIN && errno != EINTR) return;
    pollfd waits{device, POLLOUT, 0};
    ::poll(&waits, 1, kWaitMs);
  }
}

}  // namespace

int main(int count, char** words) {
  for (const int signal : {SIGINT, SIGHUP, SIGTERM, SIGQUIT, SIGPIPE}) std::signal(signal, SIG_IGN);
  std::vector<Report> reports;
  for (int n = 2; n < count; ++n) {
    reports.emplace_back();
    if (!readReport(words[n], reports.back())) return 2;
  }
  if (reports.empty()) return 2;

  const int device = ::open(words[1], O_WRONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (device < 0) return 1;
  const char ready = 'r';
  if (::send(STDIN_FILENO, &ready, 1, MSG_NOSIGNAL) != 1) return 1;

  char word = 0;
  ssize_t size = -1;
  do size = ::recv(STDIN_FILENO, &word, 1, 0);
  while (size < 0 && errno == EINTR);
  if (size == 1) return 0;  // not needed
  for (const Report& report : reports) writeReport(device, report);
  return 0;
}
