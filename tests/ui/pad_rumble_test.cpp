#include "ui/app/pad_rumble.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(PadRumble, TheIdsOfAPadAreInItsGuid) {
  EXPECT_EQ(padIdOf("030000004c050000e60c000011810000"), (PadId{0x054c, 0x0ce6}));
  EXPECT_EQ(padIdOf("050000005e040000130b000009050000"), (PadId{0x045e, 0x0b13}));
  for (const char* none : {"", "xinput01000000000000000000000000", "78696e70757401000000000000000000x",
                           "03000000000000000000000000000000", "03000000zz050000e60c000011810000"})
    EXPECT_FALSE(padIdOf(none)) << none;
}

TEST(PadRumble, ContactIsHeavyTheDriveIsFineAndALatchIsRest) {
  HapticReport report;
  EXPECT_EQ(rumbleOf(report, 0), Rumble{}) << "nothing turns";
  const Rumble air = rumbleOf(report, 1);
  EXPECT_EQ(air.strong, 0);
  EXPECT_GT(air.weak, 0.1);
  report.output.normal_load = 1.5;
  const Rumble cuts = rumbleOf(report, -1);
  EXPECT_GT(cuts.strong, 0.4) << "backwards, too";
  EXPECT_GT(cuts.weak, air.weak);
  report.output.normal_load = 100;
  EXPECT_LE(rumbleOf(report, 1).strong, 1);
  report.is_latched = true;
  EXPECT_EQ(rumbleOf(report, 1), Rumble{});
}

}  // namespace
}  // namespace kerf
