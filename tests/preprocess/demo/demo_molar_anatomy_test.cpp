#include <fmt/format.h>
#include <gtest/gtest.h>

#include "geometry/formats/mesh_io.h"
#include "geometry/mesh/mesh_check.h"
#include "preprocess/demo/demo_anatomy.h"
#include "preprocess/demo/demo_dimensions.h"
#include "preprocess/demo/demo_molar.h"
#include "tests/preprocess/mesh_rays.h"
#include "tests/support/temporary_folder.h"

namespace kerf::demo_molar_anatomy_test {
namespace {

constexpr DemoMolarDimensions kDimensions;

void expectWithin(const DemoRange& range, double value, const std::string& what, double tolerance = 0) {
  EXPECT_GE(value, range.least - tolerance) << what;
  EXPECT_LE(value, range.most + tolerance) << what;
}

class DemoMolarAnatomy : public ::testing::Test {
 protected:
  /// Twice as coarse as the default.
  static const DemoAnatomy& anatomy() {
    static const DemoAnatomy anatomy = *demoMolarAnatomy(2);
    return anatomy;
  }
  static const Mesh& mesh(const char* name) { return anatomy().mesh(name); }
  /// The highest point of the crown near a place.
  static Vec3d cuspAt(double x, double y) {
    Vec3d tip(0, 0, -1e9);
    for (const Vec3d& p : mesh("tooth.ply").vertices)
      if ((p.head<2>() - Eigen::Vector2d(x, y)).norm() < 1 && p.z() > tip.z()) tip = p;
    return tip;
  }
  /// From a point of the tooth's surface to the nearest point of the junction: vertices of the enamel inside the tooth.
  static double enamelAt(const Vec3d& surface) {
    double nearest = 1e9;
    for (const Vec3d& p : mesh("enamel.ply").vertices)
      if (demoMolarDistance(p) < -0.1) nearest = std::min(nearest, (p - surface).norm());
    return nearest;
  }
};

TEST_F(DemoMolarAnatomy, EveryTissueIsASolidReadyToPrint) {
  ASSERT_EQ(anatomy().files.size(), 4u);
  for (const DemoAnatomy::File& file : anatomy().files) {
    const MeshReport report = checkMesh(file.mesh);
    EXPECT_TRUE(report.print_ready) << file.name << ": " << describe(report);
    EXPECT_EQ(report.pieces, 1u) << file.name;
    EXPECT_EQ(file.mesh.vertex_colors.size(), file.mesh.vertices.size()) << file.name;
  }
}

TEST_F(DemoMolarAnatomy, CrownRootAndEnamelMeasureWhatTheTableSays) {
  {
    SCOPED_TRACE("CrownAndRootHaveTheirDimensions");
    const Box3 box = bounds(mesh("tooth.ply")), cervix = boundsBetween(mesh("tooth.ply"), 2, -0.25, 0.25);
    EXPECT_NEAR(box.max.z(), kDimensions.crown_height, 0.3);
    EXPECT_NEAR(box.size().x(), kDimensions.crown_mesiodistal, 0.2);
    EXPECT_NEAR(box.size().y(), kDimensions.crown_buccolingual, 0.25);
    EXPECT_NEAR(cervix.size().x(), kDimensions.cervix_mesiodistal, 0.3);
    EXPECT_NEAR(-box.min.z(), kDimensions.root_length, 0.3);
  }
  {
    SCOPED_TRACE("EnamelIsThickOnCuspsAndThinUnderFissures");
    for (const auto& [x, y] : {std::pair{2.65, 2.75}, {-0.85, 2.95}, {2.4, -2.95}, {-2.0, -3.0}})
      expectWithin(kDimensions.enamel_at_cusps, enamelAt(cuspAt(x, y)), fmt::format("cusp at {}, {}", x, y), 0.1);

    // Half-way up the sides, at the exit of a horizontal ray from the axis.
    for (const Vec3d& side : {Vec3d(1, 0.1, 0), Vec3d(-1, 0.1, 0), Vec3d(0, 1, 0), Vec3d(0, -1, 0)}) {
      const Vec3d from(0, 0, 3.2);
      const auto hits = rayCrossings(mesh("tooth.ply"), from, side.normalized());
      ASSERT_EQ(hits.size(), 1u);
      expectWithin(kDimensions.enamel_at_sides, enamelAt(from + hits[0] * side.normalized()),
                   fmt::format("side {}, {}", side.x(), side.y()), 0.1);
    }

    // Floors of the buccal and lingual fissures, outside the lesion, and of the mesial pit.
    for (const auto& [x, y] : {std::pair{3.1, -0.05}, {0.88, 1.9}, {0.1, -1.7}}) {
      const Vec3d from(x, y, 9);
      const auto hits = rayCrossings(mesh("tooth.ply"), from, -Vec3d::UnitZ());
      ASSERT_FALSE(hits.empty());
      expectWithin(kDimensions.enamel_at_fissures, enamelAt(from - hits[0] * Vec3d::UnitZ()),
                   fmt::format("fissure at {}, {}", x, y), 0.1);
    }
  }
  {
    SCOPED_TRACE("EnamelEndsAtTheNeck");
    // The junction of enamel and cementum lies within 0.4 mm of z = 0. The edge of the solid lies a rounding below.
    EXPECT_GT(bounds(mesh("enamel.ply")).min.z(), -0.6);
    for (const Vec3d& p : mesh("enamel.ply").vertices) {
      if (p.z() > 0.2) continue;
      ASSERT_GT(demoMolarDistance(p), -0.6) << p.transpose();
    }
  }
}

TEST_F(DemoMolarAnatomy, PulpAndLesionLieWhereTheyShould) {
  {
    SCOPED_TRACE("PulpChamberLiesWhereItWasMeasured");
    const Vec3d from(-0.3, 0, -8);  // up the furcation and through the middle of the chamber
    const auto tooth = rayCrossings(mesh("tooth.ply"), from, Vec3d::UnitZ());
    const auto pulp = rayCrossings(mesh("pulp.ply"), from, Vec3d::UnitZ());
    ASSERT_EQ(pulp.size(), 2u);
    ASSERT_EQ(tooth.size(), 2u);
    const double furcation = from.z() + tooth[0], floor = from.z() + pulp[0], ceiling = from.z() + pulp[1];
    EXPECT_NEAR(cuspAt(2.65, 2.75).z() - ceiling, kDimensions.cusp_to_pulp_ceiling, 0.15);
    EXPECT_NEAR(ceiling - floor, kDimensions.pulp_chamber_height, 0.15);
    EXPECT_NEAR(floor - furcation, kDimensions.pulp_floor_to_furcation, 0.78);  // one standard deviation
  }
  {
    SCOPED_TRACE("PulpLiesInTheDentinUpToTheApices");
    const Mesh& pulp = mesh("pulp.ply");
    for (std::size_t v = 0; v < pulp.vertices.size(); v += 5) {
      const Vec3d& p = pulp.vertices[v];
      ASSERT_LT(demoMolarDistance(p), 0) << p.transpose();
      ASSERT_GT(distanceToVertices(mesh("tooth.ply"), p), 0.35) << p.transpose();
      ASSERT_FALSE(p.z() > 1.5 && isInside(mesh("enamel.ply"), p)) << p.transpose();
    }

    // Two mesial canals, one distal, a millimetre and a half above their ends.
    const auto across = [&](const Vec3d& from) { return rayCrossings(mesh("pulp.ply"), from, Vec3d::UnitY()); };
    const auto mesial = across({2.15, -5, -11.9}), distal = across({-4.1, -5, -11.2});
    ASSERT_EQ(mesial.size(), 4u);
    ASSERT_EQ(distal.size(), 2u);
    expectWithin(kDimensions.canal_diameter, mesial[1] - mesial[0], "mesiolingual canal");
    expectWithin(kDimensions.canal_diameter, mesial[3] - mesial[2], "mesiobuccal canal");
    expectWithin(kDimensions.canal_diameter, distal[1] - distal[0], "distal canal");
    EXPECT_NEAR(bounds(mesh("pulp.ply")).min.z(), bounds(mesh("tooth.ply")).min.z() + 0.9, 0.3);
  }
  {
    SCOPED_TRACE("LesionRunsFromTheFissureIntoTheDentinShortOfThePulp");
    const Mesh& caries = mesh("caries.ply");
    const Vec3d from(0.1, -0.2, 9);
    const auto lesion = rayCrossings(caries, from, -Vec3d::UnitZ()),
               tooth = rayCrossings(mesh("tooth.ply"), from, -Vec3d::UnitZ());
    ASSERT_EQ(lesion.size(), 2u);
    EXPECT_LT(lesion[0], tooth[0]);  // reaches out of the fissure
    const auto pulp = rayCrossings(mesh("pulp.ply"), from, -Vec3d::UnitZ());
    EXPECT_GT(pulp[0] - lesion[1], 0.5);
    EXPECT_LT(pulp[0] - lesion[1], 2.0);

    // Much wider along the junction than at its mouth.
    Box3 mouth;
    for (const Vec3d& p : caries.vertices)
      if (std::abs(demoMolarDistance(p)) < 0.15) mouth.add(p);
    EXPECT_GT(bounds(caries).size().y(), 1.5 * mouth.size().y());
  }
}

TEST_F(DemoMolarAnatomy, IsWrittenWithARecipeAndOnlyReplacedOnDemand) {
  TemporaryFolder folder;
  const auto target = folder.path() / "molar";
  ASSERT_TRUE(writeDemoAnatomy(anatomy(), target, false));
  EXPECT_FALSE(writeDemoAnatomy(anatomy(), target, false));
  EXPECT_TRUE(writeDemoAnatomy(anatomy(), target, true));
  for (const DemoAnatomy::File& file : anatomy().files) {
    const auto read = readMesh(target / file.name);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->mesh.triangles, file.mesh.triangles);
  }
  const std::string recipe = contentOf(target / "molar.toml");
  EXPECT_EQ(recipe.find("material = \"caries\""), recipe.find("material"));  // first, so it wins
  EXPECT_NE(recipe.find("[[part]]\nmaterial = \"dentin\"\nmesh = \"tooth.ply\""), recipe.npos);
  EXPECT_NE(recipe.find("[outline]\nmeshes = [\"tooth.ply\"]"), recipe.npos);
}

TEST_F(DemoMolarAnatomy, IsTheSameEveryTime) {
  const DemoAnatomy again = *demoMolarAnatomy(2);
  for (std::size_t i = 0; i < again.files.size(); ++i) {
    EXPECT_EQ(again.files[i].mesh.triangles, anatomy().files[i].mesh.triangles);
    EXPECT_TRUE(again.files[i].mesh.vertices == anatomy().files[i].mesh.vertices);
  }
}

TEST_F(DemoMolarAnatomy, StopsWhenCancelled) {
  const auto stopped = demoMolarAnatomy(2, [](double fraction, std::string_view) { return fraction < 0.3; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Error::Code::kCancelled);
}

}  // namespace
}  // namespace kerf::demo_molar_anatomy_test
