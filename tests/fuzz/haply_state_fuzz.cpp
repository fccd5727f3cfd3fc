// States of Haply's service in sequence, separated by zero bytes.
#include "bridges/haply_state.h"
#include "tests/fuzz/harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace bridge;
  HaplyState state;
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\0'), rest.size());
    const HaplyState before = state;
    const HaplyNews news = parseHaplyState(rest.substr(0, end), state);
    for (const double place : state.hand.position)
      kerf::fuzz::require(std::abs(place) <= 10, "a place that is taken is near");
    kerf::fuzz::require(state.id.size() <= 64, "an id is short");
    if (news == HaplyNews::kMalformed)
      kerf::fuzz::require(state.id == before.id && state.hand.position == before.hand.position &&
                              state.hand.buttons == before.hand.buttons,
                          "nothing of a malformed state is used");
    (void)haplyForce(state.id, state.hand.position);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return 0;
}
