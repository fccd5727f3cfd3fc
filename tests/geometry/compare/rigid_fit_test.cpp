#include "geometry/compare/rigid_fit.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <random>

#include "geometry/formats/mesh_io.h"
#include "preprocess/demo/demo_molar.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/support/places.h"

namespace kerf::rigid_fit_test {
namespace {

struct Random {
  std::mt19937 engine{11};
  double operator()(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  Rigid3 pose(double shift) {
    std::normal_distribution<double> normal;
    const Eigen::Vector4d q(normal(engine), normal(engine), normal(engine), normal(engine));
    return {Eigen::Quaterniond(q.normalized()),
            {(*this)(-shift, shift), (*this)(-shift, shift), (*this)(-shift, shift)}};
  }
};

Mesh moved(Mesh mesh, const Rigid3& pose) {
  for (Vec3d& p : mesh.vertices) p = pose * p;
  return mesh;
}

RigidFit fitted(const Mesh& first, const Mesh& second, const RigidFitOptions& options = {}) {
  const auto out = fitRigidly(first, MeshDistance(first), second, MeshDistance(second), options);
  EXPECT_TRUE(out) << out.error().message();
  return out.value_or(RigidFit{});
}

// The farthest that a vertex lies from its place.
double error(const Mesh& at, const Mesh& mesh, const Rigid3& pose) {
  double most = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    most = std::max(most, (pose * mesh.vertices[v] - at.vertices[v]).norm());
  return most;
}

void recoversRandomMotions(const Mesh& mesh, int count) {
  Random random;
  for (int n = 0; n < count; ++n) {
    const Mesh other = moved(mesh, random.pose(100));
    const RigidFit fit = fitted(mesh, other);
    EXPECT_LT(error(mesh, other, fit.T_first_second), 1e-4) << n << ": RMS " << fit.rms_mm;
    EXPECT_LT(fit.rms_mm, 1e-6);
    EXPECT_EQ(fit.free_motions, 0);
  }
}

TEST(RigidFit, RecoversRandomMotionsOfAMolar) { recoversRandomMotions(demoMolar(0.4), 5); }

TEST(RigidFit, RecoversRandomMotionsOfRealScans) {
  const char* const data = std::getenv("KERF_DATA");
  const auto folder = data ? std::filesystem::path(data) : std::filesystem::path(kSourceFolder) / ".." / "shared/data";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no scans at " << folder << ": set KERF_DATA";
  for (const char* name : {"upper-arch-scan-02.stl", "tooth-19-molar-crown-root.stl"}) {
    SCOPED_TRACE(name);
    const auto scan = readMesh(folder / name);
    ASSERT_TRUE(scan) << scan.error().message();
    recoversRandomMotions(scan->mesh, 2);
  }
}

// A cavity in the crown, as after a preparation: the rest decides.
TEST(RigidFit, ChangedPartsDoNotMoveTheFit) {
  const Mesh molar = demoMolar(0.4);
  Mesh cut = molar;
  for (Vec3d& p : cut.vertices)
    if (p[2] > 4) p[2] -= 1.5;
  Random random;
  const Rigid3 pose = random.pose(50);
  const RigidFit fit = fitted(molar, moved(cut, pose));
  EXPECT_LT(error(cut, moved(cut, pose), fit.T_first_second), 1e-4);
  EXPECT_LT(fit.kept, fit.samples);
  EXPECT_GT(fit.kept, fit.samples / 2);
}

TEST(RigidFit, FitsPartOfASurfaceToTheWhole) {
  const Mesh molar = demoMolar(0.4);
  std::vector<char> keep(molar.triangles.size());
  for (std::size_t t = 0; t < keep.size(); ++t) keep[t] = molar.corner(t, 0)[2] > -2;
  const Mesh crown = subset(molar, keep);
  const Rigid3 pose{Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Vec3d(1, 2, -1).normalized())), {0.5, -0.3, 0.4}};
  for (const bool is_part_second : {true, false}) {
    const Mesh& first = is_part_second ? molar : crown;
    const Mesh& second = is_part_second ? crown : molar;
    const RigidFit fit = fitted(first, moved(second, pose));
    EXPECT_LT(error(second, moved(second, pose), fit.T_first_second), 1e-4) << is_part_second;
  }
}

TEST(RigidFit, StaysWhereItLiesAndNamesFreeMotions) {
  const Mesh molar = demoMolar(0.4);
  const RigidFit still = fitted(molar, molar);
  EXPECT_LT(still.before_mm, 1e-9);
  EXPECT_FALSE(still.from_axes);
  EXPECT_LT(still.rotation(), 1e-9);

  // Equal flat sheets: shifts in the plane and the turn about its normal change nothing.
  Mesh sheet;
  sheet.vertices = {{0, 0, 0}, {40, 0, 0}, {40, 40, 0}, {0, 40, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const RigidFit flat =
      fitted(sheet, moved(sheet, {Eigen::Quaterniond::Identity(), {0, 0, 0.3}}), {.from_anywhere = false});
  EXPECT_EQ(flat.free_motions, 3);
  EXPECT_NEAR(flat.T_first_second.translation[2], -0.3, 1e-9);
  EXPECT_NEAR(flat.before_mm, 0.3, 1e-9);
}

TEST(RigidFit, IsTheSameOnAnyNumberOfThreads) {
  const Mesh molar = demoMolar(0.5), other = moved(molar, Random().pose(30));
  const RigidFit many = fitted(molar, other);
  RigidFit one;
  tbb::task_arena(1).execute([&] { one = fitted(molar, other); });
  EXPECT_EQ(many.T_first_second.translation, one.T_first_second.translation);
  EXPECT_EQ(many.T_first_second.rotation.coeffs(), one.T_first_second.rotation.coeffs());
}

TEST(RigidFit, RefusesSurfacesThatFaceOppositeWays) {
  const Mesh ball = ballMesh({0, 0, 0}, 5, 20), inward = ballMesh({0, 0, 0}, 5, 20, true);
  const auto out = fitRigidly(ball, MeshDistance(ball), inward, MeshDistance(inward), {.from_anywhere = false});
  ASSERT_FALSE(out);
  EXPECT_EQ(out.error().code, Error::Code::kGeometry);
}

}  // namespace
}  // namespace kerf::rigid_fit_test
