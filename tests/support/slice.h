// Runs a subset of many similar cases. KERF_SLICE is the number of the subset (default 0) or `all`. CI uses the day
// number, so a week of CI runs covers all of them.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string_view>

namespace kerf::test {

class Slice {
 public:
  /// @param parts  1 to 7, coprime to the cases of a row, so that each kind is in each part.
  explicit Slice(unsigned parts) : parts_(parts) {
    const char* const wanted = std::getenv("KERF_SLICE");
    if (!wanted) return;
    if (std::string_view(wanted) == "all") {
      parts_ = 1;
      return;
    }
    char* end = nullptr;
    next_ = static_cast<unsigned>(std::strtoul(wanted, &end, 10));
    EXPECT_TRUE(end != wanted && *end == 0) << "KERF_SLICE=" << wanted << "; expected a number or \"all\"";
  }
  /// Whether the next case runs.
  bool has() { return next_++ % parts_ == 0; }
  /// Whether a case with its own name and test runs.
  bool has(std::string_view name) const {
    unsigned sum = next_;
    for (const char c : name) sum += static_cast<unsigned char>(c);
    return sum % parts_ == 0;
  }

 private:
  unsigned parts_, next_ = 0;
};

/// Skips a test outside today's slice.
#define KERF_SLICE_OF(parts, name) \
  if (!::kerf::test::Slice(parts).has(name)) GTEST_SKIP() << "in another slice (KERF_SLICE=all runs all)"

}  // namespace kerf::test
