#include "sim/device/hid/hid_device.h"

#include <fmt/format.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>

#include "sim/hand/triple_buffer.h"

namespace kerf {

struct HidDevice::State {
  explicit State(FoundDevice found, Listener told) : what(std::move(found)), listener(std::move(told)) {}

  void readAll();
  bool drain(std::size_t n, int wait_ms);
  bool isChosen(std::size_t n, ReportKind kind, std::int64_t now);
  void writeWishes();
  void stop();

  const FoundDevice what;
  const Listener listener;
  std::vector<HidPort> ports;  // parallel to what.interfaces

  // The reader's.
  DeviceReading newest;
  std::size_t chosen = 0;
  bool has_chosen = false;
  TripleBuffer<DeviceReading> readings;
  std::atomic<bool> is_connected{true}, is_stopping{false};

  std::mutex mutex;
  std::condition_variable wished;
  std::optional<bool> wish;     // guarded by mutex
  bool writes_no_more = false;  // guarded by mutex

  std::thread reader, writer;
};

// Waits for the interface that counts, and polls the others.
void HidDevice::State::readAll() {
  constexpr int kWait = 5;  // ms: longest delay of the thread's end
  while (!is_stopping.load(std::memory_order_acquire)) {
    bool is_there = true;
    for (std::size_t n = 0; n < ports.size() && is_there; ++n) is_there = drain(n, n == chosen ? kWait : 0);
    if (is_there) continue;
    newest.axes = {};
    newest.buttons = 0;
    readings.back() = newest;
    readings.publish();
    is_connected.store(false, std::memory_order_release);
    return;
  }
}

// Reads until nothing waits. False: the device is gone.
bool HidDevice::State::drain(std::size_t n, int wait_ms) {
  // Limit for a device that sends faster than this thread reads.
  constexpr int kMost = 256;
  std::array<std::uint8_t, HidPort::kLongestReport> bytes{};
  bool has_news = false;
  for (int count = 0; count < kMost; ++count) {
    const int size = ports[n].read(bytes, count == 0 ? wait_ms : 0);
    if (size < 0) return false;
    if (size == 0) break;

    const std::int64_t now = deviceClock();
    const std::span<const std::uint8_t> report(bytes.data(), static_cast<std::size_t>(size));
    if (listener) listener(now, what.interfaces[n].interface, report);
    DeviceReading next = newest;
    if (!isChosen(n, takeReport(*what.driver, report, now, next), now)) continue;
    newest = next;
    has_news = true;
  }
  if (has_news) {
    readings.back() = newest;
    readings.publish();
  }
  return true;
}

bool HidDevice::State::isChosen(std::size_t n, ReportKind kind, std::int64_t now) {
  if (n == chosen && has_chosen) return true;
  const bool is_free = !has_chosen || static_cast<double>(now - newest.time_ns) > 1e9 * kSilence;
  if (kind != ReportKind::kMotion) return !has_chosen;
  if (!is_free) return false;
  chosen = n;
  has_chosen = true;
  return true;
}

void HidDevice::State::writeWishes() {
  std::unique_lock lock(mutex);
  for (;;) {
    wished.wait(lock, [&] { return wish || writes_no_more; });
    if (!wish) return;
    const bool is_lit = *wish;
    wish.reset();
    lock.unlock();
    for (std::size_t n = 0; n < ports.size(); ++n)
      for (const OutputReport& report : what.driver->axes->light(what.interfaces[n], is_lit)) ports[n].write(report);
    lock.lock();
  }
}

// Writer first: it may still put the light out.
void HidDevice::State::stop() {
  {
    const std::lock_guard lock(mutex);
    wish = false;
    writes_no_more = true;
  }
  wished.notify_one();
  if (writer.joinable()) writer.join();
  is_stopping.store(true, std::memory_order_release);
  if (reader.joinable()) reader.join();
}

HidDevice::HidDevice(std::unique_ptr<State> state) : state_(std::move(state)) {}
HidDevice::~HidDevice() { state_->stop(); }

Expected<std::unique_ptr<HidDevice>> HidDevice::open(const FoundDevice& found, Listener listener) {
  auto state = std::make_unique<State>(found, std::move(listener));
  for (const HidInfo& info : found.interfaces) {
    KERF_TRY(port, HidPort::open(info.path));
    state->ports.push_back(std::move(port));
  }
  State& s = *state;
  std::unique_ptr<HidDevice> device(new HidDevice(std::move(state)));
  try {
    s.reader = std::thread([&s] { s.readAll(); });
    s.writer = std::thread([&s] { s.writeWishes(); });
  } catch (const std::system_error& e) {
    return fail({.code = Error::Code::kBadValue,
                 .file = found.path(),
                 .found = e.what(),
                 .expected = "two threads",
                 .hint = "close other programs, or raise the limit nproc"});
  }
  device->light(true);
  return device;
}

const FoundDevice& HidDevice::what() const noexcept { return state_->what; }
bool HidDevice::isConnected() const noexcept { return state_->is_connected.load(std::memory_order_acquire); }
bool HidDevice::update() noexcept { return state_->readings.update(); }
const DeviceReading& HidDevice::reading() const noexcept { return state_->readings.front(); }

std::array<double, 6> HidDevice::axes() noexcept {
  update();
  return isConnected() ? axesAt(reading(), deviceClock()) : std::array<double, 6>{};
}

void HidDevice::light(bool is_lit) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->wish = is_lit;
  }
  state_->wished.notify_one();
}

}  // namespace kerf
