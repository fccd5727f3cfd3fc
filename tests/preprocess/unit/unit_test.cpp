#include "preprocess/unit/unit.h"

#include <gtest/gtest.h>

namespace kerf::unit_test {
namespace {

Box3 across(double diagonal) {
  Box3 box;
  box.add(Vec3d::Zero());
  box.add(Vec3d(diagonal / std::sqrt(3), diagonal / std::sqrt(3), diagonal / std::sqrt(3)));
  return box;
}

TEST(Unit, ASizeThatFitsMillimetresIsNotScaled) {
  for (const double size : {16.0, 26.0, 90.0, 250.0}) {
    const auto unit = chooseUnit(across(size), "", "");
    ASSERT_TRUE(unit);
    EXPECT_EQ(unit->unit, "mm");
    EXPECT_EQ(unit->scale_to_mm, 1);
    EXPECT_FALSE(unit->is_doubtful);
    EXPECT_FALSE(unit->reason.empty());
  }
}

TEST(Unit, ASmallObjectStaysMillimetresButIsPointedOut) {
  const auto unit = chooseUnit(across(8), "", "");
  ASSERT_TRUE(unit);
  EXPECT_EQ(unit->scale_to_mm, 1);
  EXPECT_TRUE(unit->is_doubtful);
  EXPECT_NE(unit->reason.find("80 mm"), std::string::npos) << unit->reason;
}

TEST(Unit, ASizeThatFitsOneOtherUnitIsTakenForThatAloud) {
  const auto metres = chooseUnit(across(0.105), "", "");
  ASSERT_TRUE(metres);
  EXPECT_EQ(metres->unit, "m");
  EXPECT_EQ(metres->scale_to_mm, 1000);
  EXPECT_TRUE(metres->is_doubtful);
  EXPECT_EQ(chooseUnit(across(60000), "", "")->unit, "um");
}

TEST(Unit, AWholeJawInMetresIsNoSpeckInInches) {
  for (const double size : {0.12, 0.15, 0.18, 0.23}) {
    const auto unit = chooseUnit(across(size), "", "");
    ASSERT_TRUE(unit);
    EXPECT_EQ(unit->unit, "m") << size;
  }
  EXPECT_EQ(chooseUnit(across(0.25), "", "")->unit, "mm") << "6.35 mm in inches, or 250 mm";
  EXPECT_FALSE(chooseUnit(across(0.15), "inch", "")->is_doubtful) << "as asked";
}

TEST(Unit, AFileThatIsClearlyInAnotherUnitContradictsTheSharedOne) {
  const UnitChoice mm{"mm", 1, "90 across", false}, m{"m", 1000, "0.09 across", true};
  EXPECT_FALSE(requireOneUnit("ball.stl", across(0.015), "", mm, "arch.stl"));
  EXPECT_FALSE(requireOneUnit("ball.stl", across(15), "", m, "arch.stl"));
  for (const double size : {80.0, 15.0, 2.5, 1e-5})  // a size that fits no unit is only small
    EXPECT_TRUE(requireOneUnit("ball.stl", across(size), "", mm, "arch.stl")) << size;
  EXPECT_TRUE(requireOneUnit("ball.stl", across(0.0029), "", m, "arch.stl"));
}

TEST(Unit, ASizeThatFitsSeveralUnitsOrNoneStaysMillimetres) {
  for (const double size : {2.7, 1e-6, 800.0}) {
    const auto unit = chooseUnit(across(size), "", "");
    ASSERT_TRUE(unit);
    EXPECT_EQ(unit->scale_to_mm, 1) << size;
    EXPECT_TRUE(unit->is_doubtful) << size;
  }
}

TEST(Unit, TheUserComesBeforeTheFileAndTheFileBeforeTheSize) {
  EXPECT_EQ(chooseUnit(across(50), "inch", "cm")->scale_to_mm, 25.4);
  EXPECT_EQ(chooseUnit(across(50), "", "cm")->scale_to_mm, 10);
  EXPECT_FALSE(chooseUnit(across(50), "furlong", ""));
}

TEST(Unit, ANamedUnitThatMakesNoDentalSizeIsTakenButDoubted) {
  const auto asked = chooseUnit(across(0.105), "mm", ""), declared = chooseUnit(across(80), "", "inch");
  ASSERT_TRUE(asked && declared);
  EXPECT_EQ(asked->scale_to_mm, 1);
  EXPECT_TRUE(asked->is_doubtful && declared->is_doubtful);
  EXPECT_NE(asked->reason.find("105 mm in m"), std::string::npos) << asked->reason;
  EXPECT_FALSE(chooseUnit(across(0.105), "m", "")->is_doubtful);
}

TEST(Unit, AUnitAgainstTheFilesOwnIsDoubted) {
  const auto against = chooseUnit(across(50), "mm", "inch"), same = chooseUnit(across(50), "mm", "mm");
  ASSERT_TRUE(against && same);
  EXPECT_TRUE(against->is_doubtful);
  EXPECT_NE(against->reason.find("though the file says inch"), std::string::npos) << against->reason;
  EXPECT_FALSE(same->is_doubtful);
}

}  // namespace
}  // namespace kerf::unit_test
