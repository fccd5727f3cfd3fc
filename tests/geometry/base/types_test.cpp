#include "geometry/base/types.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "geometry/base/progress.h"

namespace kerf::types_test {
namespace {

TEST(Box3, HasEightDifferentCornersThatSpanIt) {
  const Box3 box{Vec3d(-1, 2, 3), Vec3d(4, 5, 7)};
  std::set<std::array<double, 3>> corners;
  Box3 around;
  for (int n = 0; n < 8; ++n) {
    const Vec3d c = box.corner(n);
    corners.insert({c[0], c[1], c[2]});
    around.add(c);
  }
  EXPECT_EQ(corners.size(), 8u);
  EXPECT_EQ(around.min, box.min);
  EXPECT_EQ(around.max, box.max);
  EXPECT_EQ(box.corner(1), Vec3d(4, 2, 3));
  EXPECT_EQ(box.corner(6), Vec3d(-1, 5, 7));
}

TEST(Box3, IsTransformedByAPoseToTheBoxOfItsMovedCorners) {
  const Rigid3 pose{Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3d::UnitZ())), Vec3d(10, 0, 0)};
  const Box3 moved = Box3{Vec3d(0, 0, 0), Vec3d(1, 2, 3)}.transformed(pose);
  EXPECT_LT((moved.min - Vec3d(8, 0, 0)).norm(), 1e-12);
  EXPECT_LT((moved.max - Vec3d(10, 1, 3)).norm(), 1e-12);
}

TEST(Rigid3, IsUsableWhenFiniteUnitAndNear) {
  EXPECT_TRUE(Rigid3{}.isUsable());
  EXPECT_FALSE((Rigid3{Eigen::Quaterniond(1, 0, 0, 0.01), Vec3d::Zero()}.isUsable()));
  EXPECT_FALSE((Rigid3{Eigen::Quaterniond(0, 0, 0, 0), Vec3d::Zero()}.isUsable()));
  EXPECT_FALSE((Rigid3{Eigen::Quaterniond::Identity(), Vec3d(0, std::nan(""), 0)}.isUsable()));
  EXPECT_FALSE((Rigid3{Eigen::Quaterniond(1, std::nan(""), 0, 0), Vec3d::Zero()}.isUsable()));
  EXPECT_FALSE((Rigid3{Eigen::Quaterniond::Identity(), Vec3d(0, 0, Rigid3::kMostTranslation)}.isUsable()));
  EXPECT_TRUE((Rigid3{Eigen::Quaterniond::Identity(), Vec3d(0, 0, 99999)}.isUsable()));
}

TEST(Cancelled, SaysSoAndNamesTheFileIfThereIsOne) {
  EXPECT_EQ(cancelled().value().code, Error::Code::kCancelled);
  EXPECT_EQ(cancelled().value().message(), "cancelled");
  EXPECT_EQ(cancelled("scan.stl").value().message(), "scan.stl: cancelled");
  EXPECT_EQ(cancelledBeforeWriting().value().message(), "cancelled; nothing was written");
}

}  // namespace
}  // namespace kerf::types_test
