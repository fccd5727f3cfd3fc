// On request, ragged gum is cut off along the rim, and the report names the removed area.
#include "preprocess/close/trim.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "preprocess/close/edges.h"
#include "tests/preprocess/solid_checks.h"

namespace kerf::trim_test {
namespace {

// An open box of 20 x 12 x 8 mm without underside, in squares of 0.5 mm, with tongues of a given width and length, mm,
// that hang from one wall.
Mesh tray(const std::vector<std::pair<double, double>>& tongues) {
  Mesh m;
  const auto add = [&](const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    const auto n = static_cast<std::uint32_t>(m.vertices.size());
    for (const Vec3d& p : {a, b, c, d}) m.vertices.push_back(p);
    m.triangles.push_back({n, n + 1, n + 2});
    m.triangles.push_back({n, n + 2, n + 3});
  };
  // A face from `o` along u and v, with normal u x v.
  const auto face = [&](const Vec3d& o, const Vec3d& u, const Vec3d& v) {
    const int nu = static_cast<int>(std::lround(u.norm() / 0.5)), nv = static_cast<int>(std::lround(v.norm() / 0.5));
    for (int i = 0; i < nu; ++i)
      for (int j = 0; j < nv; ++j)
        add(o + u * i / nu + v * j / nv, o + u * (i + 1) / nu + v * j / nv, o + u * (i + 1) / nu + v * (j + 1) / nv,
            o + u * i / nu + v * (j + 1) / nv);
  };
  face({0, 0, 8}, {20, 0, 0}, {0, 12, 0});
  face({0, 0, 0}, {20, 0, 0}, {0, 0, 8});
  face({20, 12, 0}, {-20, 0, 0}, {0, 0, 8});
  face({0, 12, 0}, {0, -12, 0}, {0, 0, 8});
  face({20, 0, 0}, {0, 12, 0}, {0, 0, 8});
  double x = 3;
  for (const auto& [width, length] : tongues) {
    face({x, 0, -length}, {width, 0, 0}, {0, 0, length});
    x += width + 3;
  }
  return m;
}

bool says(const Solid& s, const std::string& what) {
  return std::any_of(s.report.changes.begin(), s.report.changes.end(),
                     [&](const std::string& change) { return change.find(what) != std::string::npos; });
}

TEST(TrimRim, TonguesNarrowerThanAskedGoAndNothingElse) {
  const Mesh m = tray({{1, 4}, {1.5, 3}, {6, 3}});
  const Solid whole = closed(m);
  const Solid trimmed = closed(m, {.trim_rim_mm = 3});
  EXPECT_EQ(whole.report.vertices_trimmed, 0u);
  EXPECT_FALSE(says(whole, "trimmed"));

  EXPECT_EQ(trimmed.report.rim_places_trimmed, 2u);
  EXPECT_NEAR(trimmed.report.trimmed_mm2, 1 * 4 + 1.5 * 3, 2.5) << "whole triangles, less what the disc reaches";
  EXPECT_GT(trimmed.report.triangles_trimmed, 30u);
  EXPECT_GT(trimmed.report.vertices_trimmed, 20u);
  EXPECT_TRUE(says(trimmed, "the rim was trimmed, as asked, in 2 places narrower than 3 mm"));

  // The wide tongue remains, the others are cut.
  const auto reaches = [&](const Solid& s, double from, double to) {
    return std::any_of(s.mesh.vertices.begin(), s.mesh.vertices.end(),
                       [&](const Vec3d& p) { return p.x() >= from && p.x() <= to && p.y() == 0 && p.z() == -3; });
  };
  EXPECT_TRUE(reaches(whole, 3, 4));
  EXPECT_FALSE(reaches(trimmed, 3, 4));
  EXPECT_TRUE(reaches(trimmed, 12, 17));
}

TEST(TrimRim, AStraightRimIsLeftAlone) {
  const Mesh m = tray({});
  const Solid s = closed(m, {.trim_rim_mm = 4});
  EXPECT_EQ(s.report.triangles_trimmed, 0u);
  EXPECT_TRUE(says(s, "nothing was trimmed"));
  EXPECT_EQ(s.report.vertices_lost, 0u);
}

TEST(TrimRim, WhatWasTrimmedDoesNotCountAsLost) {
  const Solid s = closed(tray({{1, 4}}), {.trim_rim_mm = 2});
  EXPECT_GT(s.report.vertices_trimmed, 0u);
  EXPECT_EQ(s.report.vertices_lost, 0u);
}

// A head on a narrow neck goes with its neck. A closed mesh has no rim.
TEST(TrimRim, WhatHangsOnANarrowNeckGoesToo) {
  Mesh m = tray({{1, 8}});
  const Mesh head = [&] {
    Mesh out;
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 8; ++j) {
        const auto n = static_cast<std::uint32_t>(out.vertices.size());
        const Vec3d o(1.5 + 0.5 * i, 0, -12 + 0.5 * j);
        for (const Vec3d& d : {Vec3d(0, 0, 0), Vec3d(0.5, 0, 0), Vec3d(0.5, 0, 0.5), Vec3d(0, 0, 0.5)})
          out.vertices.push_back(o + d);
        out.triangles.push_back({n, n + 1, n + 2});
        out.triangles.push_back({n, n + 2, n + 3});
      }
    return out;
  }();
  append(m, head);
  const Solid s = closed(m, {.trim_rim_mm = 3});
  EXPECT_NEAR(s.report.trimmed_mm2, 8 + 16, 3);
  EXPECT_EQ(s.report.rim_places_trimmed, 1u);

  const Solid solid = closed(box(0, 5), {.trim_rim_mm = 3});
  EXPECT_EQ(solid.report.triangles_trimmed, 0u);
}

}  // namespace
}  // namespace kerf::trim_test
