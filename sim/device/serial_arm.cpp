#include "sim/device/serial_arm.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <mutex>
#include <utility>

#include "sim/device/arm_thread.h"
#include "sim/device/device_driver.h"
#include "sim/device/woody_arm.h"
#include "sim/device/zero_guard.h"

namespace kerf {
namespace {

constexpr std::int64_t kPeriod = 1'000'000;     // ns, between two lines that are sent
constexpr std::int64_t kAnswerBy = 20'000'000;  // ns: then the arm is asked again
constexpr std::size_t kLongestLine = 128;

}  // namespace

bool parseSerialLine(std::string_view line, SerialLine& out) noexcept {
  constexpr std::size_t kNumbers = 8, kMostDigits = 9;
  if (line.size() < 2 || line.front() != '[' || line.back() != ']') return false;
  line = line.substr(1, line.size() - 2);
  std::array<int, kNumbers> numbers{};
  for (std::size_t n = 0; n < kNumbers; ++n) {
    const std::size_t comma = line.find(',');
    const bool is_last = n + 1 == kNumbers;
    if ((comma == line.npos) != is_last) return false;
    const std::string_view word = line.substr(0, comma);
    if (word.empty() || word.size() > kMostDigits + 1) return false;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), numbers[n]);
    if (error != std::errc() || end != word.data() + word.size()) return false;
    if (!is_last) line.remove_prefix(comma + 1);
  }
  out.model = numbers[0];
  std::copy_n(numbers.begin() + 1, 6, out.counts.begin());
  out.error = numbers[7];
  return true;
}

void takeSerialLine(const SerialLine& line, HandFrame& hand, Eigen::Matrix3d& jacobian) noexcept {
  const WoodyModel model = serialWoody();
  std::array<int, 6> counts = line.counts;
  for (std::size_t n = 0; n < 3; ++n) counts[n] += model.home[n];
  const WoodyPose pose = woodyPose(model, counts);
  jacobian = pose.jacobian;
  hand.pose = {Eigen::Quaterniond::Identity(), pose.position};
  hand.is_ready = line.error == 0;
  hand.senses_orientation = false;
  hand.most_force = model.most_force;
  hand.most_stiffness = model.most_stiffness;
}

std::size_t writeSerialLine(const Vec3d& milliamperes, std::span<char, 64> out) noexcept {
  char* at = out.data();
  char* const end = at + out.size();
  *at++ = '[';
  for (int n = 0; n < 3; ++n) {
    const double value = std::isfinite(milliamperes[n]) ? milliamperes[n] : 0;
    const int current = static_cast<int>(std::lround(std::clamp(value, -kWoodyMostCurrent, kWoodyMostCurrent)));
    at = std::to_chars(at, end, current).ptr;
    *at++ = n < 2 ? ',' : ']';
  }
  *at++ = '\n';
  return static_cast<std::size_t>(at - out.data());
}

struct SerialArm::State {
  ~State() {
    if (fd >= 0) ::close(fd);
  }
  void exchange();
  bool receive(int wait_ms);
  void takeLine(std::string_view line);
  enum class Sent { kWhole, kNotWhole, kGone };
  Sent send(const ForceFrame& force);

  std::string path;
  int fd = -1;
  ZeroGuard guard;
  SerialArm* arm = nullptr;
  std::atomic<bool> wants_calibration{false};

  // The thread alone.
  std::array<char, kLongestLine> line{};
  std::size_t length = 0;
  bool is_too_long = false;
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
  ArmLink::Hand newest;
  bool has_answer = true;
  std::array<int, 6> at_home{};  // what its encoders say there

  internal::ArmThread thread;
  bool is_unplugged = false;  // guarded by the thread's mutex, as the next
  bool is_unguarded = false;
  int other_model = 0;  // whose kinematics are not known
  int error = 0;        // that the arm tells of
};

void SerialArm::State::exchange() {
  std::int64_t asked = 0;
  while (!thread.isStopping()) {
    const std::int64_t now = deviceClock();
    if ((has_answer && now - asked >= kPeriod) || now - asked >= kAnswerBy) {
      const bool has_guard = guard.isThere();
      if (send(has_guard ? arm->link_.answer(newest, now) : ForceFrame{}) == Sent::kGone) break;
      const std::lock_guard lock(thread.mutex);
      is_unguarded = !has_guard;
      asked = now;
      has_answer = false;
    }
    if (!receive(1)) break;
  }

  // Twice: the line before it may have been taken in part. Else its guard writes zero.
  const bool is_ended = send({}) == Sent::kWhole;
  if (send({}) == Sent::kWhole && is_ended) guard.release();

  // As long as somebody has the port of an unplugged arm open, the arm comes back as another one.
  if (!thread.isStopping()) {
    ::close(std::exchange(fd, -1));
    guard = {};
  }
}

// False: it is gone.
bool SerialArm::State::receive(int wait_ms) {
  pollfd waits{fd, POLLIN, 0};
  if (::poll(&waits, 1, wait_ms) <= 0) return true;
  std::array<char, 256> bytes{};
  const ssize_t size = ::read(fd, bytes.data(), bytes.size());
  if (size <= 0) {
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return true;
    const std::lock_guard lock(thread.mutex);
    is_unplugged = true;
    return false;
  }
  for (ssize_t n = 0; n < size; ++n) {
    const char c = bytes[static_cast<std::size_t>(n)];
    if (c == '\n') {
      std::string_view text(line.data(), length);
      if (text.ends_with('\r')) text.remove_suffix(1);
      takeLine(is_too_long ? std::string_view() : text);
      length = 0;
      is_too_long = false;
    } else if (length < line.size()) {
      line[length++] = c;
    } else {
      is_too_long = true;
    }
  }
  return true;
}

void SerialArm::State::takeLine(std::string_view text) {
  const std::int64_t came = deviceClock();
  has_answer = true;
  thread.tell(came, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  SerialLine said;
  const bool is_good = parseSerialLine(text, said);
  const std::lock_guard lock(thread.mutex);
  ArmCounts& counts = thread.counts;
  if (!is_good) {
    ++counts.refused;
    counts.last_fault = "its text";
    return;
  }
  error = said.error;
  other_model = said.model == kSerialWoody ? 0 : said.model;
  if (other_model != 0) return;
  ++counts.hands;
  counts.newest_came_ns = came;
  if (wants_calibration.exchange(false)) {
    at_home = said.counts;
    arm->link_.needs_calibration = false;
  }
  for (std::size_t n = 0; n < said.counts.size(); ++n) said.counts[n] -= at_home[n];
  takeSerialLine(said, newest.frame, jacobian);
  countHand(newest.frame, counts.hands, came);
  newest.came_ns = came;
  arm->publish(newest);
}

SerialArm::State::Sent SerialArm::State::send(const ForceFrame& force) {
  std::array<char, 64> text{};
  const Vec3d currents = force.is_enabled ? woodyCurrents(serialWoody(), jacobian, force.force) : Vec3d(Vec3d::Zero());
  const std::size_t size = writeSerialLine(currents, text);
  const ssize_t written = ::write(fd, text.data(), size);
  const std::lock_guard lock(thread.mutex);
  if (written < 0 && errno != EAGAIN) {
    is_unplugged = true;
    return Sent::kGone;
  }
  const bool is_whole = written == static_cast<ssize_t>(size);
  thread.counts.forces += is_whole;
  thread.counts.is_enabled = force.is_enabled;
  return is_whole ? Sent::kWhole : Sent::kNotWhole;
}

SerialArm::SerialArm(const ArmSettings& settings, const Rigid3& start, std::unique_ptr<State> state)
    : ForceArm(settings, start), state_(std::move(state)) {
  state_->arm = this;
}
SerialArm::~SerialArm() { state_->thread.stop(); }

Expected<std::unique_ptr<SerialArm>> SerialArm::open(const std::string& path, const ArmSettings& settings,
                                                     const Rigid3& start, ArmListener listener) {
  auto state = std::make_unique<State>();
  state->path = path;
  state->fd = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (state->fd < 0)
    return fail({.code = errno == ENOENT ? Error::Code::kNotFound : Error::Code::kUnreadable,
                 .file = path,
                 .found = std::strerror(errno),
                 .expected = "a serial port of an arm that this user may open",
                 .hint = "plug it in; for the permission run scripts/setup --udev, which installs the udev rule "
                         "70-kerf-hid.rules, or join the group dialout"});
  termios line{};
  if (::tcgetattr(state->fd, &line) != 0)
    return fail({.code = Error::Code::kBadValue,
                 .file = path,
                 .found = "no serial port",
                 .expected = "one, as /dev/ttyACM0",
                 .hint = "ls /dev/ttyACM*"});
  ::cfmakeraw(&line);
  ::cfsetspeed(&line, B115200);  // USB does not care
  ::tcsetattr(state->fd, TCSANOW, &line);
  ::tcflush(state->fd, TCIOFLUSH);

  constexpr std::string_view kZero = "[0,0,0]\n";
  const ZeroGuard::Report zero(kZero.begin(), kZero.end());
  // Twice: Kerf may have been killed in the middle of a line.
  KERF_TRY(guard, ZeroGuard::start(path, std::array{zero, zero}));
  state->guard = std::move(guard);

  std::unique_ptr<SerialArm> arm(new SerialArm(settings, start, std::move(state)));
  State& s = *arm->state_;
  arm->link_.needs_calibration = true;
  s.thread.listener = std::move(listener);
  KERF_CHECK(s.thread.start([&s] { s.exchange(); }, path, ""));
  return arm;
}

std::string SerialArm::what() const { return "serial arm, " + state_->path; }

bool SerialArm::calibrate() {
  state_->wants_calibration = true;
  return true;
}

bool SerialArm::isGone() const {
  const std::lock_guard lock(state_->thread.mutex);
  return state_->is_unplugged;
}

ArmCounts SerialArm::counts() const {
  ArmCounts out = state_->thread.told();
  const std::lock_guard lock(state_->thread.mutex);
  out.is_talking = out.is_talking && !state_->is_unplugged;
  if (state_->is_unplugged)
    out.trouble = "it was unplugged: plug it in";
  else if (state_->other_model != 0)
    out.trouble =
        fmt::format("it is of model {}, whose arm is not known here: only 3, WoodenHaptics, is", state_->other_model);
  else if (state_->error != 0)
    out.trouble = fmt::format("it tells of error {}", state_->error);
  else if (state_->is_unguarded)
    out.trouble = "it gives no force: the process that guards it is gone; close it, and open it anew";
  else if (!out.is_talking)
    out.trouble = "it does not answer: switch it on";
  return out;
}

}  // namespace kerf
