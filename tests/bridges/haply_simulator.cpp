#include "tests/bridges/haply_simulator.h"

#include <sys/socket.h>
#include <utility>  // before Boost.Asio 1.74, which forgets it

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "sim/device/hid/device_driver.h"

namespace kerf::test {
namespace {

namespace beast = boost::beast;
namespace asio = boost::asio;
using asio::ip::tcp;
using Stream = beast::websocket::stream<tcp::socket>;
using BoostError = boost::system::error_code;

constexpr std::int64_t kMs = 1'000'000;      // ns
constexpr std::int64_t kForgets = 10 * kMs;  // a command
constexpr int kMostTicks = 50;               // at once

CutPath atRest() {
  CutPath out;
  for (const double t : {0.0, 1e6}) out.poses.push_back({t, {Eigen::Quaterniond::Identity(), Vec3d::Zero()}});
  out.cuts = {1};
  return out;
}

// Zero, unless the force is complete.
Vec3d forceOf(const std::string& text) {
  const auto all = nlohmann::json::parse(text, nullptr, false);
  Vec3d out = Vec3d::Zero();
  try {
    const auto& values = all.at("inverse3").at(0).at("commands").at("set_cursor_force").at("values");
    out = {values.at("x").get<double>(), values.at("y").get<double>(), values.at("z").get<double>()};
  } catch (const nlohmann::json::exception&) {
    return Vec3d::Zero();
  }
  return out.allFinite() ? out : Vec3d(Vec3d::Zero());
}

}  // namespace

struct HaplySimulator::State {
  explicit State(HaplyOptions given)
      : options(std::move(given)),
        path(options.path.poses.empty() ? atRest() : options.path),
        hand(path, options.hand),
        acceptor(context) {}
  void serve();
  void answer(Stream& stream);
  void advance();
  std::string say(bool is_first) const;

  const HaplyOptions options;
  const CutPath path;
  DeviceHand hand;
  asio::io_context context;
  tcp::acceptor acceptor;
  std::uint16_t port = 0;
  std::atomic<bool> is_stopping{false}, is_hanging{false};
  std::atomic<int> open_socket{-1};

  // The thread alone.
  DeviceSample sample;
  Vec3d force = Vec3d::Zero();
  std::int64_t commanded = 0, advanced = 0;

  mutable std::mutex mutex;
  ArmReport told;  // guarded by mutex
  std::thread thread;
};

void HaplySimulator::State::advance() {
  const std::int64_t now = deviceClock();
  if (advanced == 0) advanced = now - kMs;
  const std::lock_guard lock(mutex);
  for (int n = 0; n < kMostTicks && advanced + kMs <= now; ++n) {
    advanced += kMs;
    StepOutput last;
    const bool counts = commanded != 0 && advanced - commanded <= kForgets;
    told.force = counts ? force : Vec3d(Vec3d::Zero());
    told.is_enabled = counts && !force.isZero(0);
    told.most_force = std::max(told.most_force, told.force.norm());
    last.force.force = told.force;
    told.is_over = !hand.next(last, sample);
    ++told.ticks;
    told.position = hand.position();
    told.port_energy = hand.portEnergy();
    told.most_energy = std::max(told.most_energy, told.port_energy);
  }
  advanced = std::max(advanced, now - kMostTicks * kMs);
}

std::string HaplySimulator::State::say(bool is_first) const {
  const Vec3d at = sample.T_world_device.translation / 1000;
  const nlohmann::json place = {{"x", at[0]}, {"y", at[1]}, {"z", at[2]}};
  nlohmann::json arm = {{"state", {{"cursor_position", place}}}};
  nlohmann::json out;
  if (is_first) {
    arm["device_id"] = "SIM1";
    arm["config"] = {{"type", "inverse3"}};
    out["session_id"] = 1;
  }
  out["inverse3"] = nlohmann::json::array({arm});
  const nlohmann::json grip = {{"buttons", {{"a", sample.pedal > 0}, {"b", false}, {"c", false}}}};
  out["wireless_verse_grip"] = nlohmann::json::array({{{"state", grip}}});
  return out.dump();
}

void HaplySimulator::State::answer(Stream& stream) {
  BoostError error;
  stream.text(true);
  stream.write(asio::buffer(say(true)), error);
  beast::flat_buffer buffer;
  while (!error && !is_stopping) {
    buffer.clear();
    stream.read(buffer, error);
    if (error) return;
    while (is_hanging && !is_stopping) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    force = forceOf(beast::buffers_to_string(buffer.data()));
    commanded = deviceClock();
    advance();
    {
      const std::lock_guard lock(mutex);
      ++told.force_frames;
    }
    stream.write(asio::buffer(say(false)), error);
  }
}

void HaplySimulator::State::serve() {
  while (!is_stopping) {
    BoostError error;
    tcp::socket socket(context);
    acceptor.accept(socket, error);
    if (error || is_stopping) return;
    socket.set_option(tcp::no_delay(true), error);
    open_socket = socket.native_handle();
    Stream stream(std::move(socket));
    advance();
    stream.accept(error);
    if (!error) answer(stream);
    open_socket = -1;
  }
}

HaplySimulator::HaplySimulator(std::unique_ptr<State> state) : state_(std::move(state)) {}
HaplySimulator::~HaplySimulator() {
  State& s = *state_;
  s.is_stopping = true;
  ::shutdown(s.acceptor.native_handle(), SHUT_RDWR);  // unblocks accept()
  if (const int socket = s.open_socket; socket >= 0) ::shutdown(socket, SHUT_RDWR);
  if (s.thread.joinable()) s.thread.join();
}

Expected<std::unique_ptr<HaplySimulator>> HaplySimulator::start(HaplyOptions options) {
  auto state = std::make_unique<State>(std::move(options));
  State& s = *state;
  const tcp::endpoint here(asio::ip::address_v4::loopback(), s.options.port);
  BoostError error;
  s.acceptor.open(tcp::v4(), error);
  if (!error) s.acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) s.acceptor.bind(here, error);
  if (!error) s.acceptor.listen(1, error);
  if (error)
    return fail({.code = Error::Code::kUnreadable,
                 .place = fmt::format("127.0.0.1, port {}", s.options.port),
                 .found = error.message(),
                 .expected = "a port of its own",
                 .hint = "end the other program, or choose another port"});
  s.port = s.acceptor.local_endpoint(error).port();
  std::unique_ptr<HaplySimulator> out(new HaplySimulator(std::move(state)));
  try {
    s.thread = std::thread([&s] { s.serve(); });
  } catch (const std::system_error& e) {
    return fail({.code = Error::Code::kBadValue, .place = "the simulated service", .found = e.what()});
  }
  return out;
}

std::uint16_t HaplySimulator::port() const noexcept { return state_->port; }
ArmReport HaplySimulator::report() const {
  const std::lock_guard lock(state_->mutex);
  return state_->told;
}
void HaplySimulator::hang(bool is_hanging) noexcept { state_->is_hanging = is_hanging; }

}  // namespace kerf::test
