// A part of a long list of like cases. KERF_SLICE chooses the part: CI takes another one each day, so that within a week
// all cases are run. KERF_SLICE=all runs all of them at once.
#pragma once

#include <cstdlib>
#include <string_view>

namespace kerf::test {

class Slice {
 public:
  /// @param parts  1 to 7. A number that shares no factor with the cases of a row, so that each kind is in each part.
  explicit Slice(unsigned parts) : parts_(parts) {
    const char* const wanted = std::getenv("KERF_SLICE");
    if (!wanted) return;
    if (std::string_view(wanted) == "all")
      parts_ = 1;
    else
      next_ = static_cast<unsigned>(std::strtoul(wanted, nullptr, 10));
  }
  /// Of the next case: whether it is run.
  bool has() { return next_++ % parts_ == 0; }
  /// Of a case that has a name and a test of its own.
  bool has(std::string_view name) const {
    unsigned sum = next_;
    for (const char c : name) sum += static_cast<unsigned char>(c);
    return sum % parts_ == 0;
  }

 private:
  unsigned parts_, next_ = 0;
};

/// Skips a test whose name is not in today's slice.
#define KERF_SLICE_OF(parts, name) \
  if (!::kerf::test::Slice(parts).has(name)) GTEST_SKIP() << "in another slice (KERF_SLICE=all runs all)"

}  // namespace kerf::test
