// Haptic-thread results of the real-time scenes.
#pragma once

#include "bench/bench.h"
#include "sim/live/haptic_thread.h"
#include "sim/run/report/replay.h"

namespace kerf::cli {

/// Calls stop() of a thread at the end of a scope, before older locals are destroyed.
template <class Thread>
struct StoppedAtTheEnd {
  Thread& thread;
  ~StoppedAtTheEnd() { thread.stop(); }
};

/// Notes the thread's grants and refusals from the system.
void addGrant(Result& r, const HapticThread& haptic);

/// Adds the state hash, and whether the replay of the log reached the same hash.
void addReplay(Result& r, const HapticThread& haptic, const Replay& again);

}  // namespace kerf::cli
