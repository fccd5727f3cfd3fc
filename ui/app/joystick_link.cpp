#include "ui/app/joystick_link.h"

#include <chrono>
#include <future>
#include <system_error>
#include <utility>

#include "sim/device/device_watch.h"

namespace kerf {
namespace {

// A gamepad is GLFW's.
bool isJoystick(const FoundDevice& found) {
  constexpr std::uint16_t kJoystick = 4;
  return found.driver == findDriver("joystick") && found.interfaces.front().usage == kJoystick;
}

}  // namespace

GamepadState gamepadStateOf(const DeviceReading& reading) {
  constexpr std::size_t kX = 0, kY = 1, kTwist = 5;
  constexpr int kUp = 60, kRight = 61, kDown = 62, kLeft = 63;
  const auto isDown = [&](int bit) { return (reading.buttons >> bit & 1) != 0; };
  const auto share = [&](int plus, int minus) { return (isDown(plus) ? 1.0 : 0.0) - (isDown(minus) ? 1.0 : 0.0); };

  GamepadState out;
  out.left_stick = {reading.axes[kX], reading.axes[kY]};
  out.right_stick = {reading.axes[kTwist] + share(kRight, kLeft), share(kDown, kUp)};
  out.right_trigger = isDown(0) ? 1 : 0;
  out.a = isDown(1);
  out.left_bumper = isDown(2);
  out.right_bumper = isDown(3);
  return out;
}

PidWish pidWishOf(const Rumble& rumble) {
  constexpr double kMostDamping = 0.5, kMostShake = 0.3;
  return {.damping = kMostDamping * rumble.strong, .shake = kMostShake * rumble.weak};
}

struct JoystickLink::State {
  explicit State(bool gives) : gives_force(gives), watch("", 1000, isJoystick) {}
  // Another joystick, or none. One that is being opened is let go when it is.
  void forget() {
    pid.reset();
    has_tried = false;
    is_stale = opening.valid();
    force_trouble.clear();
  }
  void begin();
  void takeOpened();

  const bool gives_force;
  DeviceWatch watch;
  std::shared_ptr<HidDevice> device;
  std::string told_name;
  std::unique_ptr<PidDevice> pid;
  std::future<Expected<std::unique_ptr<PidDevice>>> opening;  // its pool may take a fifth of a second
  bool has_tried = false, is_pid = false, is_stale = false;
  std::string force_trouble;
};

void JoystickLink::State::begin() {
  has_tried = true;
  try {
    opening = std::async(std::launch::async, PidDevice::open, device->what().interfaces.front());
  } catch (const std::system_error& e) {
    force_trouble = e.what();
  }
}

void JoystickLink::State::takeOpened() {
  auto opened = opening.get();
  if (std::exchange(is_stale, false)) return;
  if (!opened)
    force_trouble = opened.error().message();
  else if (!(*opened)->stopsByItself())
    force_trouble = "its effects have no end of their own: they would go on if this program hung";
  else
    pid = std::move(*opened);
}

JoystickLink::JoystickLink(bool gives_force) : state_(std::make_unique<State>(gives_force)) {}
JoystickLink::~JoystickLink() = default;

std::optional<GamepadState> JoystickLink::read() {
  State& s = *state_;
  if (!s.device || !s.device->isConnected()) {
    s.device = s.watch.device();
    s.forget();
    if (s.device) s.is_pid = hasForceFeedback(s.device->what().interfaces.front());
  }
  if (!s.device || !s.device->isConnected()) return {};
  s.device->update();
  if (s.device->reading().reports == 0) return GamepadState{};  // it says nothing before it is moved
  return gamepadStateOf(s.device->reading());
}

std::optional<std::string> JoystickLink::news() {
  State& s = *state_;
  const std::string now = name(), before = std::exchange(s.told_name, now);
  if (now == before) return {};
  return now.empty() ? before + " was unplugged" : now + " is ready";
}

std::string JoystickLink::name() const {
  const State& s = *state_;
  if (!s.device || !s.device->isConnected()) return {};
  const HidInfo& info = s.device->what().interfaces.front();
  return info.name.empty() ? s.device->what().name : info.name;
}

std::string JoystickLink::trouble() const { return state_->watch.trouble(); }

std::string JoystickLink::force() const {
  const State& s = *state_;
  if (!s.is_pid) return "it has no force feedback of the class PID";
  if (!s.gives_force) return "not asked for: kerf-sim --joystick-force, experimental";
  if (!s.force_trouble.empty()) return s.force_trouble;
  if (s.pid && !s.pid->isGuarded()) return "it gives no force: the process that guards it is gone; plug it out and in";
  return "damped and shaken while it drills, experimental";
}

void JoystickLink::shake(const Rumble& wanted) {
  State& s = *state_;
  if (s.opening.valid()) {
    if (s.opening.wait_for(std::chrono::seconds(0)) == std::future_status::ready) s.takeOpened();
  } else if (s.gives_force && s.is_pid && s.device && !s.has_tried && wanted != Rumble{}) {
    s.begin();
  }
  if (s.pid) s.pid->set(pidWishOf(wanted));
}

}  // namespace kerf
