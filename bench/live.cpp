#include "bench/live.h"

#include <fmt/format.h>

namespace kerf::cli {

void addGrant(Result& r, const HapticThread& haptic) {
  r.notes.push_back("granted: " + haptic.grant().summary());
  for (const RealTimeRefusal& refusal : haptic.grant().refusals) r.notes.push_back(refusal.message());
}

void addReplay(Result& r, const HapticThread& haptic, const Replay& again) {
  r.state_hash = fmt::format("{:016x}", haptic.session().hash());
  if (!again.is_same)
    r.notes.push_back(fmt::format("the replay differs from tick {} on: {}", again.differs_at, again.note));
  r.add("replay differs", !again.is_same || again.state_hash != r.state_hash);
}

}  // namespace kerf::cli
