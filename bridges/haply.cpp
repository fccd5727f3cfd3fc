// kerf-bridge-haply [KERF-PORT [SERVICE-PORT]]: Haply Inverse3 through its service on this machine, JSON over a
// WebSocket, for `kerf live --device bridge`. Untested with the service and the device: written from public documents,
// tested against a simulated service.
//
//   service ──state──▶ ┌────────┐ ──hand──▶ Kerf        one state for each command: the service answers
//   service ◀─force─── │ bridge │ ◀─force── Kerf
//
// A command counts once and is forgotten: a killed bridge leaves no force behind. If the service does not answer within
// 20 ms, the bridge sends zero force, which also requests a new answer.
#include <utility>  // before Boost.Asio 1.74, which forgets it

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include <cstdio>
#include <string>
#include <thread>

#include "bridges/haply_state.h"

namespace bridge {
namespace {

namespace beast = boost::beast;
namespace asio = boost::asio;
using Stream = beast::websocket::stream<asio::ip::tcp::socket>;
using BoostError = boost::system::error_code;

constexpr std::int64_t kPeriod = 1'000'000;  // ns: least time between two commands
constexpr std::int64_t kLeastWait = kPeriod / 20;
constexpr auto kTryAgain = std::chrono::milliseconds(500);
constexpr std::int64_t kAskSoon = 20 * kPeriod;    // after a command without an answer: zero force
constexpr std::int64_t kAskAgain = 100 * kPeriod;  // and from then on
constexpr std::int64_t kNoWord = 5000 * kPeriod;   // since the call: then it calls again
constexpr std::int64_t kGoodbye = 100 * kPeriod;   // most time for the end
constexpr std::size_t kLongestState = 1 << 20;     // bytes

// One non-blocking connection: it reads and writes at the same time, so a silent service still hears zero force.
class HaplyLine {
 public:
  explicit HaplyLine(std::uint16_t port) : stream_(context_) {
    // connect() to a hung service can block for minutes.
    stream_.next_layer().async_connect({asio::ip::address_v4::loopback(), port}, [this, port](BoostError e) {
      if (!isOver(e)) greet(port);
    });
  }
  ~HaplyLine() {
    BoostError ignored;
    stream_.next_layer().close(ignored);
    context_.restart();
    context_.run();  // pending operations end with an error
  }
  HaplyLine(const HaplyLine&) = delete;
  HaplyLine& operator=(const HaplyLine&) = delete;

  bool isOpen() const { return !error_; }
  bool isConnected() const { return isOpen() && is_connected_; }
  bool canWrite() const { return isOpen() && !is_waiting_; }
  /// Waits for an event or the end of the time; at least some microseconds, since it polls only then.
  void wait(std::int64_t ns) {
    context_.restart();
    context_.run_one_for(std::chrono::nanoseconds(std::max(ns, kLeastWait)));
  }
  /// Newest message, if any.
  bool hear(std::string& out) {
    if (!has_come_) return false;
    out = beast::buffers_to_string(in_.data());
    in_.clear();
    has_come_ = false;
    read();
    return true;
  }
  /// @pre canWrite().
  void write(std::string text) {
    out_ = std::move(text);
    is_waiting_ = true;
    stream_.async_write(asio::buffer(out_), [this](BoostError e, std::size_t) {
      is_waiting_ = false;
      isOver(e);
    });
  }
  /// Writes a last command and says goodbye, in kGoodbye at most. A service that does not read gets neither.
  /// @param command  empty: none.
  void close(std::string command) {
    const std::int64_t last = clockNow() + kGoodbye;
    const auto isFree = [&] {
      while (isOpen() && is_waiting_ && clockNow() < last) wait(kPeriod);
      return canWrite();
    };
    if (!isFree()) return;
    if (!command.empty()) write(std::move(command));
    if (!isFree()) return;
    is_waiting_ = true;
    stream_.async_close(beast::websocket::close_code::normal, [this](BoostError e) {
      is_waiting_ = false;
      isOver(e ? e : BoostError(beast::websocket::error::closed));
    });
    while (isOpen() && clockNow() < last) wait(kPeriod);
  }

 private:
  bool isOver(BoostError e) {
    if (e) error_ = e;
    return static_cast<bool>(e);
  }
  void greet(std::uint16_t port) {
    is_connected_ = true;
    BoostError ignored;
    stream_.next_layer().set_option(asio::ip::tcp::no_delay(true), ignored);
    stream_.read_message_max(kLongestState);
    stream_.text(true);
    stream_.async_handshake("127.0.0.1:" + std::to_string(port), "/", [this](BoostError e) {
      is_waiting_ = false;
      if (!isOver(e)) read();
    });
  }
  void read() {
    stream_.async_read(in_, [this](BoostError e, std::size_t) { has_come_ = !isOver(e); });
  }

  asio::io_context context_;
  Stream stream_;
  beast::flat_buffer in_;
  std::string out_;
  BoostError error_;
  bool is_connected_ = false, has_come_ = false;
  bool is_waiting_ = true;  // to have called, greeted, written or closed
};

// From a call to the end of the connection. The service speaks first; then it answers each command.
// @return  true if it has sent anything.
bool talk(std::uint16_t port, KerfLink& kerf) {
  HaplyLine line(port);
  const std::int64_t began = clockNow();
  while (!must_end && line.isOpen() && !line.isConnected() && clockNow() - began < kNoWord) line.wait(kPeriod);
  if (!line.isConnected()) return false;

  HaplyState state;
  std::string text;
  std::int64_t due = began, sent = 0, patience = kAskSoon;
  bool has_heard = false, owes_answer = false;
  while (!must_end && line.isOpen()) {
    if (line.hear(text)) {
      if (parseHaplyState(text, state) == HaplyNews::kPlace && !state.id.empty()) kerf.say(state.hand);
      has_heard = owes_answer = true;
      patience = kAskSoon;
    }
    const std::int64_t now = clockNow();
    const bool is_silent = !owes_answer && sent != 0 && now - sent >= patience;
    if (!has_heard && now - began > kNoWord) return false;
    if (line.canWrite() && ((owes_answer && now >= due) || is_silent)) {
      line.write(haplyForce(state.id, is_silent ? Vec3{} : kerf.force()));
      if (is_silent) patience = kAskAgain;
      owes_answer = false;
      sent = now;
      due = std::max(due + kPeriod, now - 5 * kPeriod);
    }
    line.wait(owes_answer ? std::min(due - clockNow(), kPeriod) : kPeriod);
  }
  line.close(state.id.empty() ? std::string() : haplyForce(state.id, {}));
  return has_heard;
}

int run(int argc, char** argv) {
  std::uint16_t kerf_port = 4417, service_port = 10001;
  if (argc > 3 || (argc > 1 && !parsePort(argv[1], kerf_port)) || (argc > 2 && !parsePort(argv[2], service_port))) {
    std::fprintf(stderr, "usage: kerf-bridge-haply [KERF-PORT [SERVICE-PORT]]   default: 4417 10001, of 127.0.0.1\n");
    return 2;
  }
  KerfLink kerf;
  if (!kerf.open(kerf_port)) {
    std::perror("kerf-bridge-haply: socket");
    return 1;
  }
  endBySignals();
  std::fprintf(stderr, "kerf-bridge-haply: service on port %d, Kerf on port %d; Ctrl-C ends\n", service_port,
               kerf_port);
  for (bool was_there = true; !must_end;) {
    const bool is_there = talk(service_port, kerf);
    if (was_there && !is_there)
      std::fprintf(stderr, "kerf-bridge-haply: no service answers on port %d: start haply-inverse-service\n",
                   service_port);
    was_there = is_there;
    if (!must_end) std::this_thread::sleep_for(kTryAgain);
  }
  return 0;
}

}  // namespace
}  // namespace bridge

int main(int argc, char** argv) { return bridge::run(argc, argv); }
