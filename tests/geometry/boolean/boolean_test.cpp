// Rounding of new corners by the exact boolean.
#include "geometry/boolean/boolean.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace kerf::boolean_test {
namespace {

__extension__ typedef __float128 Quad;  // more than twice the digits of a double

Mesh boxMesh(const Box3& box) {
  Mesh out;
  for (int n = 0; n < 8; ++n) out.vertices.push_back(box.corner(n));
  out.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                   {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  if (signedVolume(out) < 0)
    for (Triangle& t : out.triangles) std::swap(t[1], t[2]);
  return out;
}

double stepOf(double value) { return std::nextafter(std::abs(value), 1e300) - std::abs(value); }

// Distance of a new corner from the intersection of an edge with the plane x = at, in steps of a double.
double stepsOff(const Vec3d& corner, const Vec3d& from, const Vec3d& to, double at) {
  const Quad share = (Quad(at) - Quad(from[0])) / (Quad(to[0]) - Quad(from[0]));
  double out = 0;
  for (int axis = 1; axis < 3; ++axis) {
    const Quad exact = Quad(from[axis]) + share * (Quad(to[axis]) - Quad(from[axis]));
    out = std::max(out, std::abs(static_cast<double>(Quad(corner[axis]) - exact)) / stepOf(corner[axis]));
  }
  return out;
}

// Otherwise the last digits of a corner would depend on the order of discovery, and so on memory addresses.
TEST(Boolean, NewCornersAreRoundedFromExactNumbers) {
  constexpr double kSide = 1;  // mm: the box ends at x = 1
  const Mesh box = boxMesh({{-9, -9, -9}, {kSide, 9, 9}});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> near(0.1, 1.0), place(-3, 3);
  double most = 0;
  int corners = 0;
  for (int n = 0; n < 60; ++n) {
    // A spike through that side, with its tip inside the box and its foot outside.
    Mesh spike;
    spike.vertices = {{kSide - near(random), place(random), place(random)}};
    for (int k = 0; k < 3; ++k) {
      const double turn = 2.1 * k + near(random);
      spike.vertices.push_back({kSide + 1 + near(random), 2 * std::cos(turn), 2 * std::sin(turn)});
    }
    spike.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
    if (signedVolume(spike) < 0)
      for (Triangle& t : spike.triangles) std::swap(t[1], t[2]);

    const auto cut = subtract(box, spike, Reach::kWhole);
    ASSERT_TRUE(cut) << cut.error().message();
    for (std::size_t v = 0; v < cut->mesh.vertices.size(); ++v) {
      const Vec3d& corner = cut->mesh.vertices[v];
      if (cut->from_vertex[v] != kNoSource || corner[0] != kSide) continue;
      double off = std::numeric_limits<double>::infinity();  // of the edge that it is on
      for (std::size_t foot = 1; foot < 4; ++foot)
        off = std::min(off, stepsOff(corner, spike.vertices[0], spike.vertices[foot], kSide));
      if (off > 1000) continue;  // intersection of a side of the spike with a diagonal of the box
      most = std::max(most, off);
      ++corners;
    }
  }
  EXPECT_EQ(corners, 3 * 60);
  EXPECT_LE(most, 1) << "steps of a double";
}

}  // namespace
}  // namespace kerf::boolean_test
