// Progress of long work, and the way to cancel it.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "geometry/base/error.h"

namespace kerf {

/// Called from the working thread, at most some hundred times per job. `fraction` in [0, 1], `what` names the step.
/// Returning false cancels: the work stops soon, leaves nothing behind and yields Error::Code::kCancelled.
using Progress = std::function<bool(double fraction, std::string_view what)>;

inline bool report(const Progress& progress, double fraction, std::string_view what) {
  return !progress || progress(fraction, what);
}

/// Progress of one part of a job: its 0 to 1 is `from` to `to` of the whole.
inline Progress partOf(const Progress& whole, double from, double to) {
  if (!whole) return {};
  return [whole, from, to](double f, std::string_view what) { return whole(from + f * (to - from), what); };
}

/// Error of a cancelled job: `if (!report(progress, 0.5, "cutting")) return cancelled();`
/// @param file  file being read, if useful in the message.
inline tl::unexpected<Error> cancelled(std::string file = {}) {
  return fail({.code = Error::Code::kCancelled, .file = std::move(file), .found = "cancelled"});
}
/// The same for a job that writes files: the message says that nothing was written.
inline tl::unexpected<Error> cancelledBeforeWriting() {
  return fail({.code = Error::Code::kCancelled, .found = "cancelled; nothing was written"});
}

}  // namespace kerf
