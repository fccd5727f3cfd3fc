// What the scenes on the clock tell of the haptic thread.
#pragma once

#include "bench/bench.h"
#include "sim/live/haptic_thread.h"
#include "sim/run/replay.h"

namespace kerf::cli {

/// Calls stop() of a thread where a scope ends: before that which was declared earlier is gone.
template <class Thread>
struct StoppedAtTheEnd {
  Thread& thread;
  ~StoppedAtTheEnd() { thread.stop(); }
};

/// Notes what the system granted the thread, and what it refused.
void addGrant(Result& r, const HapticThread& haptic);

/// Adds the state hash, and whether the replay of the log ended in the same one.
void addReplay(Result& r, const HapticThread& haptic, const Replay& again);

}  // namespace kerf::cli
