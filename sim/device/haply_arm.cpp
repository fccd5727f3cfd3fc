#include "sim/device/haply_arm.h"

#include <utility>  // before Boost.Asio 1.74, which forgets it

#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <mutex>
#include <thread>

#include "sim/device/arm_thread.h"
#include "sim/device/device_driver.h"

namespace kerf {
namespace {

namespace beast = boost::beast;
namespace asio = boost::asio;
using Socket = asio::ip::tcp::socket;
using Stream = beast::websocket::stream<Socket>;
using BoostError = boost::system::error_code;

constexpr std::int64_t kPeriod = 1'000'000;  // ns: no state is asked for more often
constexpr std::int64_t kLeastWait = kPeriod / 20;
constexpr auto kTryAgain = std::chrono::milliseconds(500);
constexpr std::int64_t kAskSoon = 20 * kPeriod;    // after a command: then the service is told that there is no force
constexpr std::int64_t kAskAgain = 100 * kPeriod;  // and from then on
constexpr std::int64_t kNoWord = 5000 * kPeriod;   // since it was called: then it is called again
constexpr std::int64_t kGoodbye = 100 * kPeriod;   // that the end may take
constexpr std::size_t kLongestState = 1 << 20;     // bytes

// One connection, driven by HaplyArm's thread alone: reading and writing go on at the same time, and neither is waited
// for, so a service that says nothing is still told that there is no force.
class HaplyLine {
 public:
  explicit HaplyLine(std::uint16_t port) : stream_(context_) {
    // Of a service that hangs the queue of calls may be full: then this takes minutes.
    stream_.next_layer().async_connect({asio::ip::address_v4::loopback(), port}, [this, port](BoostError e) {
      if (!isOver(e)) greet(port);
    });
  }
  ~HaplyLine() {
    BoostError ignored;
    stream_.next_layer().close(ignored);
    context_.restart();
    context_.run();  // what was under way ends with an error
  }
  HaplyLine(const HaplyLine&) = delete;
  HaplyLine& operator=(const HaplyLine&) = delete;

  bool isOpen() const { return !error_; }
  bool isConnected() const { return isOpen() && is_connected_; }
  bool canWrite() const { return isOpen() && !is_waiting_; }
  /// Until something happens, or the time is over; some microseconds at least, without which nothing is looked for.
  void wait(std::int64_t ns) {
    context_.restart();
    context_.run_one_for(std::chrono::nanoseconds(std::max(ns, kLeastWait)));
  }
  /// What the service said since, if anything.
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
  /// Says goodbye, if the service listens.
  void close() {
    const std::int64_t last = deviceClock() + kGoodbye;
    while (isOpen() && is_waiting_ && deviceClock() < last) wait(kPeriod);
    if (!canWrite()) return;
    is_waiting_ = true;
    stream_.async_close(beast::websocket::close_code::normal, [this](BoostError e) {
      is_waiting_ = false;
      isOver(e ? e : BoostError(beast::websocket::error::closed));
    });
    while (isOpen() && deviceClock() < last) wait(kPeriod);
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

}  // namespace

struct HaplyArm::State {
  enum class Line {
    kNone,       ///< nothing answers on the port
    kAnswered,   ///< something does, and has said nothing yet
    kConnected,  ///< the service has said something
  };

  void run();
  void talk();
  void take(std::string_view text);
  void mark(Line how);

  std::uint16_t port = kHaplyPort;
  HaplyArm* arm = nullptr;

  // The thread alone.
  HaplyState said;
  ArmLink::Hand newest;

  internal::ArmThread thread;
  Line line = Line::kNone;     // guarded by the thread's mutex, as the next
  std::int64_t last_word = 0;  // deviceClock() of whatever the service said last
};

void HaplyArm::State::run() {
  while (!thread.isStopping()) {
    talk();
    mark(Line::kNone);
    for (int n = 0; n < 50 && !thread.isStopping(); ++n) std::this_thread::sleep_for(kTryAgain / 50);
  }
}

// The service speaks first; then it answers each command. One that does not answer is told that there is no force, and
// so asked again.
void HaplyArm::State::talk() {
  HaplyLine line_to(port);
  const std::int64_t began = deviceClock();
  while (!thread.isStopping() && line_to.isOpen() && !line_to.isConnected() && deviceClock() - began < kNoWord)
    line_to.wait(kPeriod);
  if (!line_to.isConnected()) return;

  mark(Line::kAnswered);
  said = {};
  std::string text;
  std::int64_t due = began, sent = 0, patience = kAskSoon;
  bool has_heard = false, owes_answer = false;
  while (!thread.isStopping() && line_to.isOpen()) {
    if (line_to.hear(text)) {
      take(text);
      has_heard = owes_answer = true;
      patience = kAskSoon;
    }
    const std::int64_t now = deviceClock();
    const bool is_silent = !owes_answer && sent != 0 && now - sent >= patience;
    if (!has_heard && now - began > kNoWord) return;  // no service: it is called again
    if (line_to.canWrite() && ((owes_answer && now >= due) || is_silent)) {
      const ForceFrame next = is_silent ? ForceFrame{} : arm->link_.answer(newest, now);
      line_to.write(haplyForce(said.id, next.force));
      if (is_silent) patience = kAskAgain;
      owes_answer = false;
      sent = now;
      due = std::max(due + kPeriod, now - 5 * kPeriod);
      const std::lock_guard lock(thread.mutex);
      ++thread.counts.forces;
      thread.counts.is_enabled = next.is_enabled;
    }
    line_to.wait(owes_answer ? std::min(due - deviceClock(), kPeriod) : kPeriod);
  }
  // Whatever ended it: as far as the service still listens, the last word is no force.
  if (line_to.canWrite() && !said.id.empty()) line_to.write(haplyForce(said.id, Vec3d::Zero()));
  line_to.close();
}

void HaplyArm::State::mark(Line how) {
  const std::lock_guard lock(thread.mutex);
  line = how;
  thread.counts.is_enabled = false;
}

void HaplyArm::State::take(std::string_view text) {
  const std::int64_t came = deviceClock();
  thread.tell(came, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  const HaplyNews news = parseHaplyState(text, said);
  const std::lock_guard lock(thread.mutex);
  line = Line::kConnected;
  last_word = came;
  ArmCounts& counts = thread.counts;
  if (news == HaplyNews::kMalformed) {
    ++counts.refused;
    counts.last_fault = "its JSON";
  }
  if (news != HaplyNews::kPlace || said.id.empty()) return;
  ++counts.hands;
  counts.newest_came_ns = came;
  newest.frame = handOf(said);
  countHand(newest.frame, counts.hands, came);
  newest.came_ns = came;
  arm->publish(newest);
}

HaplyArm::HaplyArm(const ArmSettings& settings, const Rigid3& start, std::unique_ptr<State> state)
    : ForceArm(settings, start), state_(std::move(state)) {
  state_->arm = this;
}
HaplyArm::~HaplyArm() { state_->thread.stop(); }

Expected<std::unique_ptr<HaplyArm>> HaplyArm::open(const std::string& port, const ArmSettings& settings,
                                                   const Rigid3& start, ArmListener listener) {
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
  s.thread.listener = std::move(listener);
  KERF_CHECK(s.thread.start([&s] { s.run(); }, "", "haply"));
  return arm;
}

std::string HaplyArm::what() const { return fmt::format("Haply service, port {} of this machine", state_->port); }

ArmCounts HaplyArm::counts() const {
  ArmCounts out = state_->thread.told();
  const std::lock_guard lock(state_->thread.mutex);
  const double silent = 1e-9 * static_cast<double>(deviceClock() - state_->last_word);
  if (state_->line == State::Line::kNone)
    out.trouble = fmt::format("no service answers on port {}: start haply-inverse-service", state_->port);
  else if (state_->line == State::Line::kAnswered)
    out.trouble = fmt::format(
        "port {} answers but says nothing: end what else listens there, or start haply-inverse-service anew",
        state_->port);
  else if (silent > kDeadMan)
    out.trouble = fmt::format(
        "the service has said nothing for {:.1f} s: if that goes on, start haply-inverse-service anew", silent);
  else if (!out.is_talking)
    out.trouble = "the service knows of no arm that moves: plug it in and switch it on";
  return out;
}

}  // namespace kerf
