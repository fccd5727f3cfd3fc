#include "sim/device/haply_arm.h"

#include <sys/socket.h>
#include <utility>  // before Boost.Asio 1.74, which forgets it

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include <fmt/format.h>

#include <atomic>
#include <charconv>
#include <chrono>
#include <mutex>
#include <system_error>
#include <thread>

#include "sim/device/device_driver.h"

namespace kerf {
namespace {

namespace beast = boost::beast;
namespace asio = boost::asio;
using Socket = asio::ip::tcp::socket;
using Stream = beast::websocket::stream<Socket>;
using BoostError = boost::system::error_code;

constexpr std::int64_t kPeriod = 1'000'000;  // ns: no state is asked for more often
constexpr auto kTryAgain = std::chrono::milliseconds(500);
constexpr std::size_t kLongestState = 1 << 20;        // bytes
constexpr double kMostForce = 8, kMostStiffness = 1;  // N, N/mm: not told by the service

}  // namespace

struct HaplyArm::State {
  void run();
  void talk(Stream& stream);
  bool take(std::string_view text);
  void stop();

  std::uint16_t port = kHaplyPort;
  HaplyArm* arm = nullptr;
  std::atomic<bool> is_stopping{false};
  std::atomic<int> open_socket{-1};  // to end a read that waits

  // The thread alone.
  HaplyState said;
  ArmLink::Hand newest;

  mutable std::mutex mutex;
  ArmCounts counts;  // guarded by mutex, as the next
  bool is_connected = false;
  std::thread thread;
};

void HaplyArm::State::run() {
  while (!is_stopping.load(std::memory_order_acquire)) {
    asio::io_context context;
    Stream stream(context);
    BoostError error;
    stream.next_layer().connect({asio::ip::address_v4::loopback(), port}, error);
    if (!error) {
      stream.next_layer().set_option(asio::ip::tcp::no_delay(true), error);
      open_socket.store(stream.next_layer().native_handle());
      if (!is_stopping) stream.handshake("127.0.0.1:" + std::to_string(port), "/", error);
      if (!error && !is_stopping) talk(stream);
      open_socket.store(-1);
    }
    {
      const std::lock_guard lock(mutex);
      is_connected = false;
      counts.is_enabled = false;
    }
    for (int n = 0; n < 50 && !is_stopping; ++n) std::this_thread::sleep_for(kTryAgain / 50);
  }
}

// The service speaks first; then it answers each command.
void HaplyArm::State::talk(Stream& stream) {
  stream.read_message_max(kLongestState);
  stream.text(true);
  said = {};
  beast::flat_buffer buffer;
  BoostError error;
  std::int64_t due = deviceClock();
  while (!is_stopping.load(std::memory_order_acquire)) {
    buffer.clear();
    stream.read(buffer, error);
    if (error) break;
    {
      const std::lock_guard lock(mutex);
      is_connected = true;
    }
    (void)take({static_cast<const char*>(buffer.data().data()), buffer.size()});

    due = std::max(due + kPeriod, deviceClock() - 5 * kPeriod);
    if (const std::int64_t early = due - deviceClock(); early > 0)
      std::this_thread::sleep_for(std::chrono::nanoseconds(early));
    const ForceFrame next = arm->link_.answer(newest, deviceClock());
    stream.write(asio::buffer(haplyForce(said.id, next.force)), error);
    if (error) return;
    const std::lock_guard lock(mutex);
    ++counts.forces;
    counts.is_enabled = next.is_enabled;
  }
  // Whatever ended it: as far as the service still listens, the last word is no force.
  if (!said.id.empty()) stream.write(asio::buffer(haplyForce(said.id, Vec3d::Zero())), error);
  stream.close(beast::websocket::close_code::normal, error);
}

bool HaplyArm::State::take(std::string_view text) {
  const std::int64_t came = deviceClock();
  const HaplyNews news = parseHaplyState(text, said);
  const std::lock_guard lock(mutex);
  if (news == HaplyNews::kMalformed) {
    ++counts.refused;
    counts.last_fault = "its JSON";
  }
  if (news != HaplyNews::kPlace || said.id.empty()) return false;
  ++counts.hands;
  counts.newest_came_ns = came;
  newest.frame = said.hand;
  newest.frame.number = counts.hands;
  newest.frame.time_ns = static_cast<std::uint64_t>(came);
  newest.frame.is_ready = true;
  newest.frame.most_force = kMostForce;
  newest.frame.most_stiffness = kMostStiffness;
  newest.came_ns = came;
  arm->publish(newest);
  return true;
}

// A read that waits for a service that says nothing is ended after 100 ms.
void HaplyArm::State::stop() {
  is_stopping.store(true, std::memory_order_release);
  for (int n = 0; n < 20 && open_socket.load() >= 0; ++n) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  if (const int socket = open_socket.load(); socket >= 0) ::shutdown(socket, SHUT_RD);
  if (thread.joinable()) thread.join();
}

HaplyArm::HaplyArm(const ArmSettings& settings, const Rigid3& start, std::unique_ptr<State> state)
    : ForceArm(settings, start), state_(std::move(state)) {
  state_->arm = this;
}
HaplyArm::~HaplyArm() { state_->stop(); }

Expected<std::unique_ptr<HaplyArm>> HaplyArm::open(const std::string& port, const ArmSettings& settings,
                                                   const Rigid3& start) {
  auto state = std::make_unique<State>();
  if (!port.empty()) {
    unsigned number = 0;
    const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
    if (error != std::errc() || end != port.data() + port.size() || number == 0 || number > 65535)
      return fail({.code = Error::Code::kBadValue,
                   .place = "haply",
                   .found = "\"" + port + "\"",
                   .expected = "a port of this machine: other hosts are refused",
                   .hint = "haply:10001"});
    state->port = static_cast<std::uint16_t>(number);
  }
  std::unique_ptr<HaplyArm> arm(new HaplyArm(settings, start, std::move(state)));
  State& s = *arm->state_;
  try {
    s.thread = std::thread([&s] { s.run(); });
  } catch (const std::system_error& e) {
    return fail({.code = Error::Code::kBadValue, .place = "haply", .found = e.what(), .expected = "a thread"});
  }
  return arm;
}

std::string HaplyArm::what() const { return fmt::format("Haply service, port {} of this machine", state_->port); }

ArmCounts HaplyArm::counts() const {
  const std::lock_guard lock(state_->mutex);
  ArmCounts out = state_->counts;
  const double age = 1e-9 * static_cast<double>(deviceClock() - out.newest_came_ns);
  out.is_talking = out.newest_came_ns != 0 && age <= kDeadMan;
  if (!state_->is_connected)
    out.trouble = fmt::format("no service answers on port {}: start haply-inverse-service", state_->port);
  else if (!out.is_talking)
    out.trouble = "the service knows of no arm that moves: plug it in and switch it on";
  return out;
}

}  // namespace kerf
