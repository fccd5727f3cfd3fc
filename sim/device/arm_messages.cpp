#include "sim/device/arm_messages.h"

#include <algorithm>

#include "sim/device/arm_driver.h"
#include "sim/device/haply_arm.h"
#include "sim/device/serial_arm.h"

namespace kerf {
namespace {

using Message = std::span<const std::uint8_t>;

// What is kept between two messages, whoever sends them.
struct Memory {
  ArmState arm;      // of a driver; `hand` of all
  HaplyState haply;  // of its service
};

ArmNews takeDatagram(Message message, Memory& memory) {
  return decode(message, memory.arm.hand) == FrameFault::kNone ? ArmNews::kHand : ArmNews::kRefused;
}

std::string_view textOf(Message message) { return {reinterpret_cast<const char*>(message.data()), message.size()}; }

ArmNews takeLine(Message message, Memory& memory) {
  SerialLine line;
  if (!parseSerialLine(textOf(message), line)) return ArmNews::kRefused;
  if (line.model != kSerialWoody) return ArmNews::kOther;
  takeSerialLine(line, memory.arm.hand, memory.arm.jacobian);
  return ArmNews::kHand;
}

ArmNews takeJson(Message message, Memory& memory) {
  switch (parseHaplyState(textOf(message), memory.haply)) {
    case HaplyNews::kMalformed:
      return ArmNews::kRefused;
    case HaplyNews::kOther:
      return ArmNews::kOther;
    case HaplyNews::kPlace:
      break;
  }
  if (memory.haply.id.empty()) return ArmNews::kOther;
  memory.arm.hand = handOf(memory.haply);
  return ArmNews::kHand;
}

// Those that are no driver of HID.
struct Language {
  const char* id;
  DeviceProfile profile;
  bool counts_itself;  // its messages have a number and a clock
  ArmNews (*take)(Message, Memory&);
};
const Language kLanguages[] = {{"bridge", {}, true, takeDatagram},
                               {"serial", kSerialProfile, false, takeLine},
                               {"haply", kHaplyProfile, false, takeJson}};

}  // namespace

struct ArmMessages::State {
  const Language* language = nullptr;  // one of the two
  const ArmDriver* driver = nullptr;
  Memory memory;
  HandFrame hand;
  std::uint64_t hands = 0;
};

ArmMessages::ArmMessages(std::unique_ptr<State> state) : state_(std::move(state)) {}
ArmMessages::~ArmMessages() = default;

std::unique_ptr<ArmMessages> ArmMessages::of(std::string_view language) {
  auto state = std::make_unique<State>();
  for (const Language& one : kLanguages)
    if (one.id == language) state->language = &one;
  for (const ArmDriver* driver : armDrivers())
    if (driver->id == language) state->driver = driver;
  if (!state->language && !state->driver) return nullptr;
  return std::unique_ptr<ArmMessages>(new ArmMessages(std::move(state)));
}

const char* ArmMessages::language() const { return state_->language ? state_->language->id : state_->driver->id; }

const DeviceProfile& ArmMessages::profile() const {
  return state_->language ? state_->language->profile : state_->driver->profile;
}

ArmNews ArmMessages::take(Message message, std::int64_t came_ns) {
  State& s = *state_;
  ArmNews news = ArmNews::kHand;
  if (s.language)
    news = s.language->take(message, s.memory);
  else if (s.driver->take(message, s.memory.arm) != FrameFault::kNone)
    news = ArmNews::kRefused;
  if (news != ArmNews::kHand) return news;

  ++s.hands;
  s.hand = s.memory.arm.hand;
  const bool counts_itself = s.language ? s.language->counts_itself : s.hand.number != 0;
  if (!counts_itself) countHand(s.hand, s.hands, came_ns);
  return news;
}

const HandFrame& ArmMessages::hand() const { return state_->hand; }

}  // namespace kerf
