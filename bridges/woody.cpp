// kerf-bridge-woody NODE [KERF-PORT]: a WoodenHaptics arm, or the first Polhem, for `kerf live --device bridge`.
// Untested on hardware: reports and lines are those that the projects published.
//
// NODE /dev/hidrawN, 1234:0006 by 14 bytes, or by a Teensy as raw HID, 16c0:0486, by 64, the rest zero:
//
//   from the arm   six encoders, int16 each; information, int16: bit 0 the button. An encoder of more than 5000 counts
//                  at the fourth place: the button of the pen is down
//   to the arm     currents of three motors, int16, mA; command, int16 (0: currents, 1: encoders are set); values for
//                  three encoders, int16 each. Its firmware switches the motors off 500 ms after the last report
//
// NODE /dev/ttyACMN, lines of text:
//
//   from the arm   [model,e0,e1,e2,e3,e4,e5,error]\n      one for each line it receives; model 3: WoodenHaptics
//   to the arm     [mA,mA,mA]\n                           currents. Its firmware switches the motors off after 100 ms
//
// Its encoders count from where it was switched on. The arm is not ready, and gets no current, before a person has put
// it into its home pose and pressed Enter, and for 1.5 s after that: long enough for Kerf to disarm. On HID it then has
// to report its home pose: it took the command.
#include <fcntl.h>
#include <linux/hidraw.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "bridges/serial_writer.h"
#include "bridges/woody_arm.h"

namespace bridge {
namespace {

constexpr std::int64_t kMs = 1'000'000;         // ns
constexpr std::int64_t kAnswerBy = 20 * kMs;    // then the bridge asks a serial arm again
constexpr std::int64_t kOldReport = 100 * kMs;  // a report this long after the command is newer than the command
constexpr std::int64_t kNotReady = 1500 * kMs;  // after Enter: Kerf's window disarms after 1 s
constexpr int kGoodbyeMs = 50;                  // most wait for a full serial port at the end

class Woody {
 public:
  Woody(int fd, bool is_serial, std::size_t size)
      : fd_(fd), is_serial_(is_serial), size_(size), model_(is_serial ? kSerialWoody : WoodyModel{}) {}
  ~Woody() { ::close(fd_); }

  /// @return  the exit code: 0 by a signal, 1: unplugged.
  int exchange(KerfLink& kerf);

 private:
  bool receive();
  void takeReport(std::span<const unsigned char> report);
  void takeLine(std::string_view line);
  void moved();
  void askHome();
  void sendHome();
  bool send(const Vec3& currents);
  bool write(const void* bytes, std::size_t size);

  const int fd_;
  const bool is_serial_;
  const std::size_t size_;  // of HID reports
  const WoodyModel model_;

  Counts counts_{}, zero_{};  // zero_: for a serial arm, its encoders at home, less model_.home
  WoodyPose pose_;
  Hand hand_{.is_ready = false, .most_force = 5};
  bool has_news_ = false, has_answer_ = true, is_fine_ = true, has_warned_ = false;
  bool is_calibrated_ = false;
  bool is_home_ = false;        // since home_sent_: a serial arm was zeroed, one on HID reported its home pose
  std::int64_t home_sent_ = 0;  // 0: no calibration runs
  std::string heard_;           // of a line that has not ended
  SerialWriter writer_{fd_};
};

// In the background of a terminal: reading it would fail.
bool isInBackground() {
  const pid_t front = ::tcgetpgrp(STDIN_FILENO);  // -1: not its terminal
  return front >= 0 && front != ::getpgrp();
}

int Woody::exchange(KerfLink& kerf) {
  std::fprintf(stderr, "kerf-bridge-woody: put the arm into its home pose and press Enter; Ctrl-C ends\n");
  bool is_there = true;
  pollfd waits[] = {{fd_, POLLIN, 0}, {STDIN_FILENO, POLLIN, 0}};
  std::int64_t sent = 0;
  bool has_keys = true;
  while (!must_end && is_there) {
    waits[1].fd = has_keys && !isInBackground() ? STDIN_FILENO : -1;
    waits[1].revents = 0;
    ::poll(waits, 2, 1);
    if (waits[1].revents != 0) {
      char typed[64];
      const auto size = ::read(STDIN_FILENO, typed, sizeof typed);
      if (size > 0) sendHome();
      has_keys = size > 0 || (size < 0 && waits[1].revents == POLLIN);  // false: closed
    }
    if (waits[0].revents != 0) is_there = receive();
    if (home_sent_ != 0) askHome();
    if (std::exchange(has_news_, false)) kerf.say(hand_);

    const std::int64_t now = clockNow();
    const bool is_due = is_serial_ ? has_answer_ || now - sent >= kAnswerBy : true;
    if (!is_there || !is_due || now - sent < kMs) continue;
    sent = now;
    has_answer_ = false;
    is_there = send(hand_.is_ready ? woodyCurrents(pose_, kerf.force()) : Vec3{});
  }
  // Twice: the arm may have taken the previous line in part.
  for (int n = 0; n < 2; ++n) {
    pollfd room{fd_, POLLOUT, 0};
    if (is_serial_) ::poll(&room, 1, kGoodbyeMs);
    send({});
  }
  if (!is_there) std::fprintf(stderr, "kerf-bridge-woody: the arm is gone: plug it in and begin again\n");
  return is_there ? 0 : 1;
}

// False: the arm is gone.
bool Woody::receive() {
  std::array<unsigned char, 256> bytes{};
  pollfd waits{fd_, POLLIN, 0};
  for (int n = 0; n < 64 && (n == 0 || ::poll(&waits, 1, 0) > 0); ++n) {
    const auto size = ::read(fd_, bytes.data(), bytes.size());
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return true;
    if (size <= 0) return false;
    const std::span<const unsigned char> got(bytes.data(), static_cast<std::size_t>(size));
    if (!is_serial_) {
      takeReport(got);
      continue;
    }
    constexpr std::size_t kLongestLine = 128;
    for (const unsigned char c : got) {
      if (c == '\n') {
        takeLine(heard_);
        heard_.clear();
      } else if (c != '\r' && heard_.size() <= kLongestLine) {
        heard_ += static_cast<char>(c);
      }
    }
  }
  return true;
}

void Woody::takeReport(std::span<const unsigned char> report) {
  constexpr int kPenButton = 5000;
  constexpr int kTrembles = 50;  // counts: up to 3 mm at the tip
  if (report.size() != size_) return;
  const auto word = [&](std::size_t n) { return static_cast<std::int16_t>(report[2 * n] | (report[2 * n + 1] << 8)); };
  bool is_near = true;
  for (std::size_t n = 0; n < 3; ++n) {
    counts_[n] = word(n);
    is_near = is_near && std::abs(counts_[n] - model_.home[n]) <= kTrembles;
  }
  // Reports from before the command may be near home by chance.
  if (is_near && home_sent_ != 0 && clockNow() - home_sent_ >= kOldReport) is_home_ = true;
  hand_.buttons = word(3) > kPenButton || (word(6) & 1) ? 1 : 0;
  moved();
}

// Strict: eight whole numbers.
void Woody::takeLine(std::string_view line) {
  constexpr int kModel = 3;
  has_answer_ = true;
  if (line.size() < 2 || line.front() != '[' || line.back() != ']') return;
  std::array<int, 8> numbers{};
  const char* at = line.data() + 1;
  const char* const end = line.data() + line.size() - 1;
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    const auto [after, error] = std::from_chars(at, end, numbers[n]);
    const bool is_last = n + 1 == numbers.size();
    if (error != std::errc() || (is_last ? after != end : after == end || *after != ',')) return;
    at = after + (is_last ? 0 : 1);
  }
  is_fine_ = numbers[0] == kModel && numbers[7] == 0;
  if (!is_fine_ && !std::exchange(has_warned_, true))
    std::fprintf(stderr, "kerf-bridge-woody: the arm is of model %d and tells of error %d: no force (known: model 3)\n",
                 numbers[0], numbers[7]);
  constexpr int kFarthest = 1 << 20;  // counts: far beyond any turn of a motor
  const bool is_at_home = home_sent_ != 0 && !std::exchange(is_home_, true);
  for (std::size_t n = 0; n < 3; ++n) {
    const int count = std::clamp(numbers[n + 1], -kFarthest, kFarthest);
    if (is_at_home) zero_[n] = count - model_.home[n];
    counts_[n] = count - zero_[n];
  }
  moved();
}

void Woody::moved() {
  pose_ = woodyPose(model_, counts_);
  hand_.position = pose_.position;
  hand_.is_ready = is_calibrated_ && is_fine_;
  has_news_ = true;
}

// A serial arm's home is its place at the next line; one on HID sets its encoders.
void Woody::sendHome() {
  is_calibrated_ = is_home_ = hand_.is_ready = false;
  home_sent_ = clockNow();
  if (is_serial_) return;
  std::array<unsigned char, 65> report{};
  const auto put = [&](std::size_t n, int value) {
    report[1 + 2 * n] = static_cast<unsigned char>(value & 255);
    report[2 + 2 * n] = static_cast<unsigned char>((value >> 8) & 255);
  };
  put(3, 1);
  for (std::size_t n = 0; n < 3; ++n) put(4 + n, model_.home[n]);
  write(report.data(), 1 + size_);
}

void Woody::askHome() {
  if (clockNow() - home_sent_ < kNotReady) return;
  home_sent_ = 0;
  is_calibrated_ = is_home_;
  std::fprintf(stderr, is_home_ ? "kerf-bridge-woody: calibrated\n"
                                : "kerf-bridge-woody: the arm did not take its home pose: hold it still and press "
                                  "Enter again\n");
}

// False: the arm is gone.
bool Woody::send(const Vec3& currents) {
  if (is_serial_) {
    char line[64];
    const int size = std::snprintf(line, sizeof line, "[%ld,%ld,%ld]\n", std::lround(currents[0]),
                                   std::lround(currents[1]), std::lround(currents[2]));
    return write(line, static_cast<std::size_t>(size));
  }
  std::array<unsigned char, 65> report{};
  for (std::size_t n = 0; n < 3; ++n) {
    const auto value = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(currents[n])));
    report[1 + 2 * n] = static_cast<unsigned char>(value & 255);
    report[2 + 2 * n] = static_cast<unsigned char>(value >> 8);
  }
  return write(report.data(), 1 + size_);
}

// A full buffer is no error: the arm's own watchdog counts then.
bool Woody::write(const void* bytes, std::size_t size) {
  if (is_serial_) return writer_.write({static_cast<const char*>(bytes), size});
  return ::write(fd_, bytes, size) >= 0 || errno == EAGAIN || errno == EINTR;
}

int fail(const char* node, const char* what) {
  std::fprintf(stderr, "kerf-bridge-woody: %s: %s\n", node, what);
  return 1;
}

int run(int argc, char** argv) {
  std::uint16_t port = 4417;
  if (argc < 2 || argc > 3 || (argc == 3 && !parsePort(argv[2], port))) {
    std::fprintf(stderr, "usage: kerf-bridge-woody NODE [KERF-PORT]   NODE /dev/hidraw0 or /dev/ttyACM0; port 4417\n");
    return 2;
  }
  const char* const node = argv[1];
  const int fd = ::open(node, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0 && (errno == EACCES || errno == EPERM))
    return fail(
        node,
        "no permission: run scripts/setup --udev and plug the arm in again; or, for a serial port, add your user "
        "to the group dialout and log in again");
  if (fd < 0) return fail(node, std::strerror(errno));

  std::size_t size = 14;
  termios line{};
  hidraw_devinfo info{};
  const bool is_serial = ::ioctl(fd, HIDIOCGRAWINFO, &info) < 0;
  if (is_serial) {
    if (::tcgetattr(fd, &line) != 0) return fail(node, "neither a HID device nor a serial port");
    ::cfmakeraw(&line);
    ::tcsetattr(fd, TCSANOW, &line);
    ::tcflush(fd, TCIOFLUSH);
  } else {
    const bool is_teensy = info.vendor == 0x16c0 && info.product == 0x0486;
    const bool is_woody = info.vendor == 0x1234 && info.product == 0x0006;
    if (!is_teensy && !is_woody) return fail(node, "no WoodenHaptics arm (1234:0006, 16c0:0486)");
    if (is_teensy) size = 64;
  }
  KerfLink kerf;
  if (!kerf.open(port)) return fail("socket", std::strerror(errno));
  endBySignals();
  std::signal(SIGTTIN, SIG_IGN);  // in the background of a terminal it goes on
  return Woody(fd, is_serial, size).exchange(kerf);
}

}  // namespace
}  // namespace bridge

int main(int argc, char** argv) { return bridge::run(argc, argv); }
