#include "sim/step/flush_denormals.h"

#include <gtest/gtest.h>

#include <limits>

namespace kerf::flush_denormals_test {
namespace {

// At run time, in the mode of the processor.
template <typename Number>
Number product(Number a, Number b) {
  const volatile Number left = a;
  const volatile Number right = b;
  return left * right;
}

template <typename Number>
void expectFlushedWithin() {
  const Number least = std::numeric_limits<Number>::min();
  const Number denormal = least / 4;
  ASSERT_GT(product<Number>(least, Number(0.25)), 0);
  {
    const FlushDenormals flush;
    EXPECT_EQ(product<Number>(least, Number(0.25)), 0) << "a denormal result";
    EXPECT_EQ(product<Number>(denormal, Number(8)), 0) << "a denormal operand";
    EXPECT_EQ(product<Number>(least, Number(2)), 2 * least);
  }
  EXPECT_GT(product<Number>(least, Number(0.25)), 0) << "the mode of the caller is back";
}

#if defined(__SSE2__) || defined(__aarch64__)
TEST(FlushDenormals, ResultsAndOperandsAreZeroUntilItEnds) {
  expectFlushedWithin<float>();
  expectFlushedWithin<double>();
}

TEST(FlushDenormals, AnInnerOneLeavesTheOuter) {
  const FlushDenormals outer;
  { const FlushDenormals inner; }
  EXPECT_EQ(product(std::numeric_limits<double>::min(), 0.25), 0);
}
#endif

}  // namespace
}  // namespace kerf::flush_denormals_test
