// The scene of `kerf-bench devices` that runs on the clock.
#pragma once

#include "bench/bench.h"

namespace kerf::cli {

/// A simulated arm behind a bridge presses on a wall as stiff as its profile bears, for 10 s: ages and jitter of
/// forces, energy given. Its times are of this machine as it is.
Expected<void> pressThroughTheStack(Result& r, const Bench& bench);

}  // namespace kerf::cli
