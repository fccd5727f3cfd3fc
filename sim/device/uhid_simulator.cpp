#include "sim/device/uhid_simulator.h"

#include <fcntl.h>
#include <linux/uhid.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <mutex>
#include <numbers>
#include <span>
#include <system_error>
#include <thread>

#include "sim/device/device_driver.h"

namespace kerf {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr std::uint16_t kUsb = 3, kBluetooth = 5;

// Six axes of 16 bits in report 1, buttons in report 3, the light in report 4.
Bytes spaceMouseDescriptor() {
  return {0x05, 0x01, 0x09, 0x08, 0xA1, 0x01, 0xA1, 0x00, 0x85, 0x01, 0x16, 0xA2, 0xFE, 0x26, 0x5E, 0x01, 0x36, 0x88,
          0xFA, 0x46, 0x78, 0x05, 0x55, 0x0C, 0x65, 0x11, 0x09, 0x30, 0x09, 0x31, 0x09, 0x32, 0x09, 0x33, 0x09, 0x34,
          0x09, 0x35, 0x75, 0x10, 0x95, 0x06, 0x81, 0x02, 0xC0, 0xA1, 0x02, 0x85, 0x03, 0x05, 0x09, 0x19, 0x01, 0x29,
          0x02, 0x15, 0x00, 0x25, 0x01, 0x75, 0x01, 0x95, 0x02, 0x81, 0x02, 0x95, 0x0E, 0x81, 0x03, 0xC0, 0x05, 0x08,
          0x09, 0x4B, 0xA1, 0x02, 0x85, 0x04, 0x75, 0x01, 0x95, 0x01, 0x91, 0x02, 0x95, 0x07, 0x91, 0x03, 0xC0, 0xC0};
}
// Report 1 with 15 bytes of anything, report 3 with 8 to be sent.
Bytes padDescriptor() {
  return {0x05, 0x01, 0x09, 0x05, 0xA1, 0x01, 0x85, 0x01, 0x06, 0x00, 0xFF, 0x09, 0x20, 0x15, 0x00, 0x26, 0xFF,
          0x00, 0x75, 0x08, 0x95, 0x0F, 0x81, 0x02, 0x85, 0x03, 0x09, 0x21, 0x95, 0x08, 0x91, 0x02, 0xC0};
}

struct Model {
  const char* name;
  std::uint16_t bus, vendor, product;
  Bytes descriptor;
};
Model modelOf(UhidModel model) {
  if (model == UhidModel::kSpaceMouse) return {"Simulated SpaceMouse", kUsb, 0x256f, 0xc62e, spaceMouseDescriptor()};
  // No Sony pad: Linux's driver would ask it for things that this one does not know.
  return {"Simulated gamepad", kBluetooth, 0x045e, 0x0b13, padDescriptor()};
}

// The knob goes round in 8 s; every fourth second button 1 is down.
Bytes motionAt(double t) {
  constexpr double kFull = 300;
  const double angle = 2 * std::numbers::pi * t / 8;
  const std::array<double, 6> axes{std::cos(angle), std::sin(angle), 0, 0, 0, 0.3 * std::sin(angle)};
  Bytes out{1};
  for (const double axis : axes) {
    const auto value = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(kFull * axis)));
    out.push_back(static_cast<std::uint8_t>(value & 255));
    out.push_back(static_cast<std::uint8_t>(value >> 8));
  }
  return out;
}
Bytes buttonsAt(double t) { return {3, static_cast<std::uint8_t>(std::fmod(t, 4) >= 3 ? 1 : 0), 0}; }

}  // namespace

struct UhidSimulator::State {
  ~State() {
    if (fd >= 0) ::close(fd);
  }
  bool write(const uhid_event& event) { return ::write(fd, &event, sizeof event) == sizeof event; }
  bool create();
  void send(const Bytes& report);
  void hear();
  void run();

  UhidModel model = UhidModel::kSpaceMouse;
  int fd = -1;
  std::atomic<bool> is_stopping{false};
  mutable std::mutex mutex;
  UhidReport told;  // guarded by mutex
  std::thread thread;
};

bool UhidSimulator::State::create() {
  const Model what = modelOf(model);
  uhid_event event{};
  event.type = UHID_CREATE2;
  uhid_create2_req& request = event.u.create2;
  std::strncpy(reinterpret_cast<char*>(request.name), what.name, sizeof request.name - 1);
  std::strncpy(reinterpret_cast<char*>(request.uniq), "KERF-SIM", sizeof request.uniq - 1);
  request.rd_size = static_cast<std::uint16_t>(what.descriptor.size());
  request.bus = what.bus;
  request.vendor = what.vendor;
  request.product = what.product;
  std::copy(what.descriptor.begin(), what.descriptor.end(), request.rd_data);
  return write(event);
}

void UhidSimulator::State::send(const Bytes& report) {
  uhid_event event{};
  event.type = UHID_INPUT2;
  event.u.input2.size = static_cast<std::uint16_t>(report.size());
  std::copy(report.begin(), report.end(), event.u.input2.data);
  const bool is_sent = write(event);
  const std::lock_guard lock(mutex);
  told.sent += is_sent;
}

void UhidSimulator::State::hear() {
  pollfd waits{fd, POLLIN, 0};
  uhid_event event{};
  if (::poll(&waits, 1, 0) <= 0 || ::read(fd, &event, sizeof event) <= 0 || event.type != UHID_OUTPUT) return;
  const auto size = std::min<std::size_t>(event.u.output.size, sizeof event.u.output.data);
  const std::lock_guard lock(mutex);
  ++told.received;
  told.last.assign(event.u.output.data, event.u.output.data + size);
}

void UhidSimulator::State::run() {
  const std::int64_t began = deviceClock();
  while (!is_stopping) {
    const double t = 1e-9 * static_cast<double>(deviceClock() - began);
    if (model == UhidModel::kSpaceMouse) {
      send(motionAt(t));
      send(buttonsAt(t));
    } else {
      Bytes report(16);
      report[0] = 1;
      send(report);
    }
    hear();
    std::this_thread::sleep_for(std::chrono::milliseconds(16));
  }
  uhid_event end{};
  end.type = UHID_DESTROY;
  (void)write(end);
}

UhidSimulator::UhidSimulator(std::unique_ptr<State> state) : state_(std::move(state)) {}
UhidSimulator::~UhidSimulator() {
  state_->is_stopping = true;
  if (state_->thread.joinable()) state_->thread.join();
}

Expected<std::unique_ptr<UhidSimulator>> UhidSimulator::start(UhidModel model, const std::string& node) {
  auto state = std::make_unique<State>();
  State& s = *state;
  s.model = model;
  s.fd = ::open(node.c_str(), O_RDWR | O_CLOEXEC);
  if (s.fd < 0 || !s.create())
    return fail({.code = errno == ENOENT ? Error::Code::kNotFound : Error::Code::kUnreadable,
                 .file = node,
                 .found = std::strerror(errno),
                 .expected = "the kernel's uhid, which makes devices that are not there",
                 .hint = "as root: modprobe uhid, and run this as root; a container has none"});
  std::unique_ptr<UhidSimulator> out(new UhidSimulator(std::move(state)));
  try {
    s.thread = std::thread([&s] { s.run(); });
  } catch (const std::system_error& e) {
    return fail({.code = Error::Code::kBadValue, .place = "the simulated device", .found = e.what()});
  }
  return out;
}

UhidReport UhidSimulator::report() const {
  const std::lock_guard lock(state_->mutex);
  return state_->told;
}

}  // namespace kerf
