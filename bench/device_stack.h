// The real-time scene of `kerf-bench devices`.
#pragma once

#include "bench/bench.h"

namespace kerf::cli {

/// A simulated arm behind a bridge presses for 10 s on a wall, as stiff as its profile permits. Measures age and jitter
/// of forces and the energy given. The times depend on the machine.
Expected<void> pressThroughTheStack(Result& r, const Bench& bench);

}  // namespace kerf::cli
