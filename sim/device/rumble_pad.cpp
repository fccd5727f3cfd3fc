#include "sim/device/rumble_pad.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <system_error>
#include <thread>

#include "sim/device/device_driver.h"
#include "sim/device/zero_guard.h"
#include "sim/hand/triple_buffer.h"

namespace kerf {
namespace {

constexpr auto kPause = std::chrono::milliseconds(10);  // between two reports
constexpr std::int64_t kAgain = 1'000'000'000;          // ns: an Xbox pad stops by itself after 2.5 s
constexpr int kMostFailures = 3;                        // one after the other: it is gone

std::uint8_t strength(double share, double most) {
  if (!(share > 0)) return 0;
  return static_cast<std::uint8_t>(std::lround(std::min(share, 1.0) * most));
}

void sign(std::vector<std::uint8_t>& report) {
  const std::uint32_t crc = padChecksum(std::span(report).first(report.size() - 4));
  for (std::size_t n = 0; n < 4; ++n) report[report.size() - 4 + n] = static_cast<std::uint8_t>(crc >> (8 * n));
}

}  // namespace

std::uint32_t padChecksum(std::span<const std::uint8_t> bytes) {
  constexpr std::uint8_t kOutputBegins = 0xA2;
  std::uint32_t crc = 0xFFFFFFFF;
  const auto add = [&](std::uint8_t byte) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xEDB88320U : 0U);
  };
  add(kOutputBegins);
  for (const std::uint8_t byte : bytes) add(byte);
  return ~crc;
}

std::vector<std::uint8_t> rumbleReport(PadKind kind, const Rumble& rumble, std::uint8_t number) {
  const std::uint8_t weak = strength(rumble.weak, 255), strong = strength(rumble.strong, 255);
  std::vector<std::uint8_t> out;
  switch (kind) {
    case PadKind::kDualSense:
      out.resize(48);
      out[0] = 0x02;
      out[1] = 0x03;  // as a DualShock 4 vibrates; no haptic sound
      out[3] = weak;
      out[4] = strong;
      return out;
    case PadKind::kDualSenseBluetooth:
      out.resize(78);
      out[0] = 0x31;
      out[1] = static_cast<std::uint8_t>((number & 15) << 4);
      out[2] = 0x10;
      out[3] = 0x03;
      out[5] = weak;
      out[6] = strong;
      sign(out);
      return out;
    case PadKind::kDualShock4:
      out.resize(32);
      out[0] = 0x05;
      out[1] = 0x01;  // the motors alone; its light stays
      out[4] = weak;
      out[5] = strong;
      return out;
    case PadKind::kDualShock4Bluetooth:
      out.resize(78);
      out[0] = 0x11;
      out[1] = 0xC0;
      out[3] = 0x01;
      out[6] = weak;
      out[7] = strong;
      sign(out);
      return out;
    case PadKind::kXboxBluetooth:
      break;
  }
  return {0x03, 0x0F, 0, 0, strength(rumble.strong, 100), strength(rumble.weak, 100), 0xFF, 0x00, 0xEB};
}

struct RumblePad::State {
  State(HidPort opened, PadKind of) : port(std::move(opened)), kind(of) {}
  void write();

  struct Wish {
    Rumble rumble;
    std::int64_t wished_ns = 0;
  };
  HidPort port;
  const PadKind kind;
  ZeroGuard guard;  // of the thread, once that runs
  TripleBuffer<Wish> wishes;
  std::atomic<bool> is_stopping{false}, is_connected{true}, is_guarded{true};
  std::thread thread;
};

void RumblePad::State::write() {
  Rumble last;
  std::int64_t written = 0;
  std::uint8_t number = 0;
  int failures = 0;
  const auto send = [&](const Rumble& rumble, std::int64_t now) {
    const bool is_taken = port.write(rumbleReport(kind, rumble, number++));
    failures = is_taken ? 0 : failures + 1;
    last = rumble;
    written = now;
    return is_taken;
  };
  while (!is_stopping.load(std::memory_order_acquire) && failures < kMostFailures) {
    wishes.update();
    const std::int64_t now = deviceClock();
    const Wish& wish = wishes.front();
    const bool is_news = wish.wished_ns != 0 && static_cast<double>(now - wish.wished_ns) < 1e9 * kStale;
    const bool has_guard = guard.isThere();
    is_guarded.store(has_guard, std::memory_order_release);
    const Rumble wanted = is_news && has_guard ? wish.rumble : Rumble{};
    const bool fades = last != Rumble{} && now - written > kAgain;
    if (wanted != last || fades || failures > 0) send(wanted, now);
    std::this_thread::sleep_for(kPause);
  }

  // What it does not take from here its guard may bring it.
  const bool is_gone = failures >= kMostFailures;
  if (!is_gone && (written == 0 || send({}, deviceClock()))) guard.release();
  guard = {};
  is_connected.store(!is_gone, std::memory_order_release);
}

RumblePad::RumblePad(std::unique_ptr<State> state) : state_(std::move(state)) {}
RumblePad::~RumblePad() {
  state_->is_stopping.store(true, std::memory_order_release);
  if (state_->thread.joinable()) state_->thread.join();
}

Expected<std::unique_ptr<RumblePad>> RumblePad::open(const HidInfo& info, PadKind kind) {
  KERF_TRY(port, HidPort::open(info.path));
  std::unique_ptr<RumblePad> pad(new RumblePad(std::make_unique<State>(std::move(port), kind)));
  State& s = *pad->state_;
  const std::array rest{rumbleReport(kind, {}, 0)};
  KERF_TRY(guard, ZeroGuard::start(info.path, rest));
  s.guard = std::move(guard);
  try {
    s.thread = std::thread([&s] { s.write(); });
  } catch (const std::system_error& e) {
    return fail({.code = Error::Code::kBadValue, .file = info.path, .found = e.what(), .expected = "a thread"});
  }
  return pad;
}

Expected<std::unique_ptr<RumblePad>> RumblePad::open(std::uint16_t vendor, std::uint16_t product) {
  std::vector<HidInfo> alike;
  for (const HidInfo& info : listHid())
    if (info.vendor == vendor && info.product == product && padKindOf(info)) alike.push_back(info);
  // A pad has one interface with motors; those of its sound are no HID.
  if (alike.size() == 1) return open(alike.front(), *padKindOf(alike.front()));
  return fail({.code = alike.empty() ? Error::Code::kUnsupported : Error::Code::kBadValue,
               .place = "gamepad",
               .found = alike.empty() ? fmt::format("{:04x}:{:04x}, which is not known to shake", vendor, product)
                                      : fmt::format("{} pads alike", alike.size()),
               .expected = "one DualSense, DualShock 4, or Xbox pad by Bluetooth"});
}

PadKind RumblePad::kind() const noexcept { return state_->kind; }
bool RumblePad::isConnected() const noexcept { return state_->is_connected.load(std::memory_order_acquire); }
bool RumblePad::isGuarded() const noexcept { return state_->is_guarded.load(std::memory_order_acquire); }

void RumblePad::set(const Rumble& rumble) noexcept {
  State::Wish& wish = state_->wishes.back();
  wish.rumble = rumble;
  wish.wished_ns = deviceClock();
  state_->wishes.publish();
}

}  // namespace kerf
