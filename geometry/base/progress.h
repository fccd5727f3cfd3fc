// Progress of long work, and the way to cancel it.
#pragma once

#include <functional>
#include <string_view>

namespace kerf {

/// Called from the working thread, at most some hundred times per job. `fraction` in [0, 1], `what` names the step.
/// Returning false cancels: the work stops soon, leaves nothing behind and yields Error::Code::kCancelled.
using Progress = std::function<bool(double fraction, std::string_view what)>;

inline bool report(const Progress& progress, double fraction, std::string_view what) {
  return !progress || progress(fraction, what);
}

}  // namespace kerf
