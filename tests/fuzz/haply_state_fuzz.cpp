// What Haply's service says: states one after the other, split by zero bytes.
#include "sim/device/haply_arm.h"
#include "tests/fuzz/harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kerf;
  HaplyState state;
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\0'), rest.size());
    const HaplyState before = state;
    const HaplyNews news = parseHaplyState(rest.substr(0, end), state);
    fuzz::require(state.hand.pose.isUsable(), "a pose that is taken can be computed with");
    fuzz::require(state.id.size() <= 64, "an id is short");
    if (news == HaplyNews::kMalformed)
      fuzz::require(state.id == before.id && state.hand.pose.translation == before.hand.pose.translation &&
                        state.hand.buttons == before.hand.buttons,
                    "nothing of a malformed state is used");
    (void)haplyForce(state.id, state.hand.pose.translation);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return 0;
}
