#include "preprocess/bake/bake.h"

#include <gtest/gtest.h>

#include <fstream>

#include "geometry/base/hash.h"
#include "geometry/formats/mesh_writer.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/preprocess/solid_checks.h"
#include "tests/support/temporary_folder.h"

namespace kerf::bake_test {
namespace {

namespace fs = std::filesystem;

BakeOptions coarse() {
  BakeOptions options;
  options.voxelize.voxel_mm = 0.2;
  return options;
}

TEST(Bake, OneOfAThingIsToldInTheSingular) {
  BakeReport report;
  report.manifest.sources.emplace_back();
  report.unit_is_doubtful.push_back(false);
  report.notes.emplace_back();
  MeshReport& mesh = report.source_checks.emplace_back();
  mesh.boundary_loops.emplace_back();
  mesh.boundary_edges = 3;
  mesh.pieces = 1;
  EXPECT_NE(
      describe(report).find("  defects  1 boundary loop (3 edges), 0 non-manifold edges, 0 flipped, 0 degenerate, "
                            "0 repeated, 1 piece, 0 self-intersections\n"),
      std::string::npos)
      << describe(report);
}

TEST(Bake, WhatClosingWarnsOfIsAWarningOfTheReport) {
  const TemporaryFolder folder;
  const fs::path mesh = folder.path() / "crumb.stl";
  ASSERT_TRUE(writeMesh(mesh, ballMesh({1, 2, 3}, 0.7, 30)));
  const auto report = bake({mesh}, folder.path() / "crumb.case", coarse());
  ASSERT_TRUE(report) << report.error().message();
  ASSERT_EQ(report->close.warnings.size(), 1u);
  EXPECT_NE(describe(*report).find("\nWARNING: the object is only 2."), std::string::npos) << describe(*report);
  EXPECT_EQ(describe(*report).find("closing: the object is only"), std::string::npos) << describe(*report);
}

// Voxels of 0.2 mm join two plates 0.1 mm apart, and the unit of 4 mm could also be inches.
TEST(Bake, WhatItWarnedOfIsToldAgainWhenNothingIsBaked) {
  const TemporaryFolder folder;
  const fs::path mesh = folder.path() / "plates.stl";
  Mesh plates = box({0, 0, 0}, {3, 2.5, 0.6});
  const Mesh upper = box({0, 0, 0.7}, {3, 2.5, 1.3});
  for (const auto& t : upper.triangles) plates.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  plates.vertices.insert(plates.vertices.end(), upper.vertices.begin(), upper.vertices.end());
  ASSERT_TRUE(writeMesh(mesh, plates));

  const auto first = bake({mesh}, folder.path() / "plates.case", coarse());
  ASSERT_TRUE(first) << first.error().message();
  ASSERT_TRUE(first->unit_is_doubtful[0]);
  EXPECT_NE(describe(*first).find("\nWARNING: the tool cannot cut or feel gaps and ridges narrower than 0.2 mm"),
            std::string::npos);
  EXPECT_EQ(describe(*first).find("CHECK THE UNIT"), std::string::npos) << "its line of the source says so";
  EXPECT_NE(describe(*first).find("  unit     CHECK THIS: "), std::string::npos) << describe(*first);

  const auto again = bake({mesh}, folder.path() / "plates.case", coarse());
  ASSERT_TRUE(again) << again.error().message();
  ASSERT_TRUE(again->was_up_to_date);
  for (const char* said : {"WARNING: the tool cannot cut or feel gaps and ridges narrower than 0.2 mm",
                           "WARNING: CHECK THE UNIT of source 1, mm: "})
    EXPECT_NE(describe(*again).find(said), std::string::npos) << describe(*again);
}

TEST(Bake, CaseHoldsTheFileByteForByteTheSolidAndTheField) {
  const TemporaryFolder folder;
  const fs::path mesh = folder.path() / "ball.stl", out = folder.path() / "ball.case";
  ASSERT_TRUE(writeMesh(mesh, ballMesh({1, 2, 3}, 3, 30)));
  const auto report = bake({mesh}, out, coarse());
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_EQ(*sha256OfFile(out / "source-1.stl"), *sha256OfFile(mesh));
  EXPECT_EQ(report->manifest.sources[0].sha256, *sha256OfFile(mesh));
  EXPECT_TRUE(report->manifest.changes.empty());
  EXPECT_TRUE(report->manifest.exact);

  const auto manifest = readCaseManifest(out);
  ASSERT_TRUE(manifest) << manifest.error().message();
  EXPECT_EQ(manifest->id, report->manifest.id);
  EXPECT_EQ(manifest->voxel_mm, 0.2);
  EXPECT_EQ(manifest->sources.size(), 1u);
  EXPECT_EQ(manifest->sources[0].unit, "mm");
  const auto solid = readCaseSolid(out);
  ASSERT_TRUE(solid);
  EXPECT_EQ(solid->vertices.size(), manifest->solid_vertices);
  const auto field = readCaseField(out);
  ASSERT_TRUE(field) << field.error().message();
  EXPECT_LT(field->at({5, 10, 15}), 0);  // the centre
}

TEST(Bake, SameInputsSameIdOtherVoxelOtherId) {
  const TemporaryFolder folder;
  const fs::path mesh = folder.path() / "ball.ply";
  ASSERT_TRUE(writeMesh(mesh, ballMesh({0, 0, 0}, 3, 20)));
  const auto a = bake({mesh}, folder.path() / "a", coarse()), b = bake({mesh}, folder.path() / "b", coarse());
  BakeOptions finer = coarse();
  finer.voxelize.voxel_mm = 0.15;
  const auto c = bake({mesh}, folder.path() / "c", finer);
  ASSERT_TRUE(a && b && c);
  EXPECT_EQ(a->manifest.id, b->manifest.id);
  EXPECT_NE(a->manifest.id, c->manifest.id);
}

TEST(Bake, TwoMeshesBecomeOneObject) {
  const TemporaryFolder folder;
  ASSERT_TRUE(writeMesh(folder.path() / "a.stl", ballMesh({0, 0, 0}, 3, 24)));
  ASSERT_TRUE(writeMesh(folder.path() / "b.stl", ballMesh({4, 0, 0}, 3, 24)));
  const auto report = bake({folder.path() / "a.stl", folder.path() / "b.stl"}, folder.path() / "ab", coarse());
  ASSERT_TRUE(report) << report.error().message();
  const auto solid = readCaseSolid(folder.path() / "ab");
  ASSERT_TRUE(solid);
  EXPECT_EQ(edgeConnectedPieces(*solid).count, 1u);
  EXPECT_EQ(report->manifest.sources.size(), 2u);
}

TEST(Bake, FilesOfOneObjectInDifferentUnitsAreRefused) {
  const TemporaryFolder folder;
  const fs::path arch = folder.path() / "arch.stl", ball = folder.path() / "ball-m.stl", out = folder.path() / "x.case";
  ASSERT_TRUE(writeMesh(arch, box({0, 0, 0}, {60, 50, 20})));
  ASSERT_TRUE(writeMesh(ball, ballMesh({0, 0, 0}, 0.004, 20)));
  for (const auto& order : {std::vector{arch, ball}, std::vector{ball, arch}}) {
    const auto refused = bake(order, out, coarse());
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().place, "unit");
    EXPECT_EQ(refused.error().file, ball.string());
    EXPECT_NE(refused.error().found.find("but mm for " + arch.string()), std::string::npos)
        << refused.error().message();
    EXPECT_NE(refused.error().hint.find("--unit"), std::string::npos);
    EXPECT_FALSE(fs::exists(out));
  }
  BakeOptions options = coarse();
  options.voxelize.voxel_mm = 1;
  options.unit = "mm";
  EXPECT_TRUE(bake({arch, ball}, out, options)) << "as asked";
}

TEST(Bake, AFailedOrCancelledBakeLeavesNothingBehind) {
  const TemporaryFolder folder;
  const fs::path mesh = folder.path() / "ball.stl", bad = folder.path() / "bad.stl", out = folder.path() / "x.case";
  ASSERT_TRUE(writeMesh(mesh, ballMesh({0, 0, 0}, 3, 20)));
  std::ofstream(bad) << "solid nothing\nendsolid\n";
  const auto entries = [&] { return std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator{}); };
  const auto before = entries();
  const auto refused = bake({bad}, out, coarse());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("bad.stl"), std::string::npos);
  EXPECT_EQ(entries(), before);
  for (int stop = 0; stop < 8; ++stop) {
    int calls = 0;
    const auto cancelled = bake({mesh}, out, coarse(), [&](double, std::string_view) { return calls++ < stop; });
    ASSERT_FALSE(cancelled);
    EXPECT_EQ(cancelled.error().code, Error::Code::kCancelled);
    EXPECT_EQ(entries(), before) << "cancelled at call " << stop;
  }
}

TEST(Bake, AnObjectSmallerThanAVoxelIsRefusedBeforeItIsClosed) {
  const TemporaryFolder folder;
  const fs::path mesh = folder.path() / "metres.stl", out = folder.path() / "x.case";
  ASSERT_TRUE(writeMesh(mesh, ballMesh({0, 0, 0}, 0.05, 20)));  // 100 mm, in metres
  BakeOptions options = coarse();
  options.unit = "mm";
  bool was_closing = false;
  const auto refused = bake({mesh}, out, options, [&](double, std::string_view what) {
    was_closing = was_closing || what == "closing";
    return true;
  });
  ASSERT_FALSE(refused);
  EXPECT_FALSE(was_closing);
  for (const char* said : {"metres.stl", "0.2 mm for an object of 0.1", "--unit", "in m"})
    EXPECT_NE(refused.error().message().find(said), std::string::npos) << refused.error().message();
  EXPECT_FALSE(fs::exists(out));
  options.voxelize.voxel_mm = 0.005;  // on explicit request
  const auto baked = bake({mesh}, out, options);
  ASSERT_TRUE(baked) << baked.error().message();
  EXPECT_TRUE(baked->unit_is_doubtful[0]);
}

// An arch of 60 mm read as 60 m once took more than ten minutes to close before Kerf refused its field.
TEST(Bake, AnObjectFarTooLargeIsRefusedBeforeItIsClosed) {
  const TemporaryFolder folder;
  const fs::path mesh = folder.path() / "arch.stl", out = folder.path() / "x.case";
  ASSERT_TRUE(writeMesh(mesh, ballMesh({0, 0, 0}, 30, 20)));
  bool was_closing = false;
  const auto watch = [&](double, std::string_view what) {
    was_closing = was_closing || what == "closing";
    return true;
  };
  BakeOptions options;
  options.unit = "m";
  const auto refused = bake({mesh}, out, options, watch);
  ASSERT_FALSE(refused);
  EXPECT_FALSE(was_closing);
  EXPECT_EQ(refused.error().code, Error::Code::kBadValue);
  for (const char* said : {"arch.stl", "size", "unit m", "in mm", "at most 2000 mm", "--unit"})
    EXPECT_NE(refused.error().message().find(said), std::string::npos) << refused.error().message();
  EXPECT_FALSE(fs::exists(out));

  // 600 mm can be closed, but the field would not fit.
  options.unit = "cm";
  options.voxelize.max_bytes = 1 << 30;
  const auto too_fine = bake({mesh}, out, options, watch);
  ASSERT_FALSE(too_fine);
  EXPECT_FALSE(was_closing);
  for (const char* said : {"arch.stl", "voxel size", "0.1 mm would need", "GB or more", "unit cm", "--voxel"})
    EXPECT_NE(too_fine.error().message().find(said), std::string::npos) << too_fine.error().message();
}

TEST(Bake, WhereVerticesAreLostTogetherIsSaidFirst) {
  BakeReport report;
  report.manifest.exact = true;
  report.close.vertices_lost = 128;
  report.close.lost_at = {{{-13.21, 11.12, -0.44}, 126}, {{3.9, 20.3, -6.5}, 1}};
  EXPECT_NE(describe(report).find("scan: 128 of its vertices are not in the solid, 126 of them together near (-13.2, "
                                  "11.1, -0.4) mm\n"),
            std::string::npos)
      << describe(report);
  report.close.lost_at[0].vertices = 3;
  EXPECT_EQ(describe(report).find("together"), std::string::npos) << describe(report);
}

// Three windows open one scan: the last one finds the finished case.
TEST(Bake, ACaseThatAnotherProgramWroteMeanwhileIsTakenIfItIsTheSame) {
  const TemporaryFolder folder;
  const fs::path mesh = folder.path() / "ball.stl", out = folder.path() / "ball.case";
  ASSERT_TRUE(writeMesh(mesh, ballMesh({1, 2, 3}, 4, 30)));
  for (const double voxel : {0.2, 0.25}) {
    BakeOptions other = coarse();
    other.voxelize.voxel_mm = voxel;
    fs::remove_all(out);
    bool is_baked = false;
    const auto last = bake({mesh}, out, coarse(), [&](double done, std::string_view) {
      if (done >= 0.95 && !is_baked) EXPECT_TRUE(is_baked = bake({mesh}, out, other).has_value());
      return true;
    });
    EXPECT_TRUE(is_baked);
    ASSERT_EQ(last.has_value(), voxel == 0.2) << voxel;
    if (last)
      EXPECT_EQ(last->manifest.id, readCaseManifest(out)->id);
    else
      EXPECT_NE(last.error().found.find("another program"), std::string::npos) << last.error().message();
    EXPECT_EQ(readCaseManifest(out)->voxel_mm, voxel);
  }
}

TEST(Bake, AnExistingCaseIsReplacedOnlyWhenAsked) {
  const TemporaryFolder folder;
  const fs::path mesh = folder.path() / "ball.stl", out = folder.path() / "x.case";
  ASSERT_TRUE(writeMesh(mesh, ballMesh({0, 0, 0}, 3, 20)));
  ASSERT_TRUE(bake({mesh}, out, coarse()));
  const auto same = bake({mesh}, out, coarse());
  EXPECT_TRUE(same && same->was_up_to_date) << "nothing is baked twice";
  BakeOptions other = coarse();
  other.voxelize.voxel_mm = 0.25;
  EXPECT_FALSE(bake({mesh}, out, other));
  other.overwrite = true;
  const auto replaced = bake({mesh}, out, other);
  EXPECT_TRUE(replaced && !replaced->was_up_to_date);
}

TEST(CaseManifest, UnknownMissingAndNewerAreErrorsWithTheKey) {
  const TemporaryFolder folder;
  const fs::path mesh = folder.path() / "ball.stl", out = folder.path() / "x.case";
  ASSERT_TRUE(writeMesh(mesh, ballMesh({0, 0, 0}, 3, 20)));
  ASSERT_TRUE(bake({mesh}, out, coarse()));
  std::ifstream in(out / kCaseManifest);
  const std::string good((std::istreambuf_iterator<char>(in)), {});
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    std::ofstream(out / kCaseManifest) << text.replace(at, from.size(), to);
    const auto manifest = readCaseManifest(out);
    EXPECT_FALSE(manifest);
    return manifest ? std::string() : manifest.error().message();
  };
  EXPECT_NE(with("voxel_mm", "voxel_inch").find("voxel"), std::string::npos);
  EXPECT_NE(with("version = 2", "version = 99").find("99"), std::string::npos);
  EXPECT_NE(with("exact = true", "exact = 'yes'").find("exact"), std::string::npos);
  EXPECT_NE(with("[field]", "[field]\nsurprise = 1").find("surprise"), std::string::npos);
}

}  // namespace
}  // namespace kerf::bake_test
