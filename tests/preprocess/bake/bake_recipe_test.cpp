// Recipes baked into cases: synthetic parts here, real parts where the data is (KERF_DATA).
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <numbers>

#include "geometry/base/hash.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/mesh/mesh_check.h"
#include "preprocess/bake/bake.h"
#include "preprocess/bake/bake_sources.h"
#include "preprocess/volume/label_volume.h"
#include "preprocess/voxelize/voxel_union.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/support/places.h"
#include "tests/support/slice.h"
#include "tests/support/temporary_folder.h"

namespace kerf::bake_recipe_test {
namespace {

namespace fs = std::filesystem;
double ballVolume(double r) { return 4.0 / 3 * std::numbers::pi * r * r * r; }

void write(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

const std::string kHead = "format = \"kerf-recipe\"\nversion = 1\n";

// A dentin ball with a pulp ball in it, as a tooth.
fs::path toothRecipe(const fs::path& folder) {
  EXPECT_TRUE(writeMesh(folder / "tooth.ply", ballMesh({10, 0, 0}, 3, 60)));
  EXPECT_TRUE(writeMesh(folder / "pulp.ply", ballMesh({10.03, 0.02, 0.54}, 1, 60)));
  write(folder / "tooth.toml", kHead +
                                   "unit = \"mm\"\nvoxel = 0.1\n[[part]]\nmaterial = \"pulp\"\nmesh = \"pulp.ply\"\n"
                                   "[[part]]\nmaterial = \"dentin\"\nmesh = \"tooth.ply\"\n");
  return folder / "tooth.toml";
}

TEST(BakeRecipe, TissuesBecomeOneCaseWithTheirVolumes) {
  const TemporaryFolder folder;
  const auto report = bakeRecipe(toothRecipe(folder.path()), folder.path() / "tooth.case", {});
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_TRUE(report->manifest.exact);
  const auto m = readCaseManifest(folder.path() / "tooth.case");
  ASSERT_TRUE(m) << m.error().message();
  ASSERT_EQ(m->materials.size(), 2u);
  EXPECT_EQ(m->materials[0].id, "dentin");
  EXPECT_NEAR(m->materials[0].volume_mm3 / (ballVolume(3) - ballVolume(1)), 1, 0.01);
  EXPECT_EQ(m->materials[1].id, "pulp");
  EXPECT_NEAR(m->materials[1].volume_mm3 / ballVolume(1), 1, 0.015) << "a polygon of 60 sides is 0.5 % short";
  ASSERT_EQ(m->parts.size(), 2u);
  EXPECT_EQ(m->parts[0].origin, "pulp.ply");
  EXPECT_EQ(m->voxel_mm, 0.1) << "the recipe's";
  EXPECT_EQ(m->sources.size(), 2u);
  EXPECT_EQ(*sha256OfFile(folder.path() / "tooth.case" / kCaseRecipe), *sha256OfFile(folder.path() / "tooth.toml"));
  const auto solid = readCaseSolid(folder.path() / "tooth.case");
  ASSERT_TRUE(solid);
  EXPECT_EQ(edgeConnectedPieces(*solid).count, 1u) << "the pulp makes no inner wall";
}

TEST(BakeRecipe, PartsFarTooLargeAreRefusedBeforeTheyAreClosed) {
  const TemporaryFolder folder;
  const fs::path recipe = toothRecipe(folder.path());
  BakeOptions options;
  options.unit = "m";  // 6 mm as 6 m
  bool was_uniting = false;
  const auto refused = bakeRecipe(recipe, folder.path() / "tooth.case", options, [&](double, std::string_view what) {
    was_uniting = was_uniting || what == "welding" || what == "uniting parts";
    return true;
  });
  ASSERT_FALSE(refused);
  EXPECT_FALSE(was_uniting);
  for (const char* said : {"size", "unit m", "at most 2000 mm", "--unit"})
    EXPECT_NE(refused.error().message().find(said), std::string::npos) << refused.error().message();
}

TEST(BakeRecipe, AnOpenPartIsRefusedWithAWayOutThatWorks) {
  const TemporaryFolder folder;
  const fs::path recipe = toothRecipe(folder.path()), out = folder.path() / "tooth.case";
  Mesh open = ballMesh({10, 0, 0}, 3, 60);
  std::erase_if(open.triangles, [&](const Triangle& f) { return open.vertices[f[0]].z() < 0; });
  ASSERT_TRUE(writeMesh(folder.path() / "tooth.ply", open));
  const auto refused = bakeRecipe(recipe, out, {});
  ASSERT_FALSE(refused);
  for (const char* said : {"tooth.ply", "a solid, as every part", "--close base, then kerf export tooth-closed.case"})
    EXPECT_NE(refused.error().message().find(said), std::string::npos) << refused.error().message();

  BakeOptions base;
  base.close.mode = CloseMode::kBase;
  const auto again = bakeRecipe(recipe, out, base);
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().message().find("tooth.toml"), std::string::npos) << again.error().message();
  EXPECT_NE(again.error().hint.find("kerf export"), std::string::npos);

  // The remedy.
  ASSERT_TRUE(bake({folder.path() / "tooth.ply"}, folder.path() / "part.case", base));
  const auto solid = readCaseSolid(folder.path() / "part.case");
  ASSERT_TRUE(solid && writeMesh(folder.path() / "tooth.ply", *solid));
  EXPECT_TRUE(bakeRecipe(recipe, out, {}));

  // A closed mesh alone: the error names the file and the remedy.
  const auto closed = bake({folder.path() / "pulp.ply"}, folder.path() / "pulp.case", base);
  ASSERT_FALSE(closed);
  EXPECT_NE(closed.error().message().find("pulp.ply: a closed mesh, which needs no base"), std::string::npos)
      << closed.error().message();
}

TEST(BakeRecipe, NothingIsBakedTwiceButAnyChangeBakesAgain) {
  const TemporaryFolder folder;
  const fs::path recipe = toothRecipe(folder.path()), out = folder.path() / "tooth.case";
  ASSERT_TRUE(bakeRecipe(recipe, out, {}));
  const auto written = fs::last_write_time(out / kCaseManifest);
  const auto again = bakeRecipe(recipe, out, {});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->was_up_to_date);
  EXPECT_EQ(fs::last_write_time(out / kCaseManifest), written);

  BakeOptions coarser;
  coarser.voxelize.voxel_mm = 0.2;
  coarser.voxel_is_given = true;
  EXPECT_FALSE(bakeRecipe(recipe, out, coarser)) << "another case is in the way";
  ASSERT_TRUE(writeMesh(folder.path() / "pulp.ply", ballMesh({10, 0, 0.5}, 1.2, 40)));
  EXPECT_FALSE(bakeRecipe(recipe, out, {})) << "so is this one, since a source changed";

  BakeOptions force;
  force.overwrite = true;
  const auto changed = bakeRecipe(recipe, out, force);
  ASSERT_TRUE(changed) << changed.error().message();
  EXPECT_FALSE(changed->was_up_to_date);

  write(out / kCaseAnatomy, "damaged");
  EXPECT_FALSE(bakeRecipe(recipe, out, {})) << "a damaged case is not up to date";
}

TEST(BakeRecipe, ALabelBesideMeshesKeepsItsPlaceAndTheOutlineBounds) {
  const TemporaryFolder folder;
  constexpr int kSide = 24;  // of 0.5 mm; a bar of 2 x 2 mm passes through the whole volume, and out of a ball of 4 mm
  const Vec3d center(5.75, 5.75, 5.75);
  std::string values;
  double bar_in_ball = 0;
  for (int z = 0; z < kSide; ++z)
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const bool bar = std::abs(y - 11.5) < 2 && std::abs(z - 11.5) < 2;
        values += bar ? '\5' : '\0';
        if (bar && (0.5 * Vec3d(x, y, z) - center).norm() < 4) bar_in_ball += 0.125;
      }
  write(folder.path() / "nerve.nrrd",
        fmt::format("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {0} {0} {0}\nspacings: 0.5 0.5 0.5\n"
                    "encoding: raw\n\n",
                    kSide) +
            values);

  ASSERT_TRUE(writeMesh(folder.path() / "bone.ply", ballMesh(center, 4, 100)));
  write(folder.path() / "a.toml", kHead +
                                      "unit = \"mm\"\nvoxel = 0.1\n[[part]]\nmaterial = \"nerve_canal\"\nlabel = 5\n"
                                      "[[part]]\nmaterial = \"cancellous\"\nmesh = \"bone.ply\"\n"
                                      "[outline]\nmeshes = [\"bone.ply\"]\n[labels]\nvolume = \"nerve.nrrd\"\n");

  const auto report = bakeRecipe(folder.path() / "a.toml", folder.path() / "a.case", {});
  ASSERT_TRUE(report) << report.error().message();
  const CaseManifest& m = report->manifest;
  EXPECT_NEAR(m.solid_volume_mm3 / ballVolume(4), 1, 0.005) << "the bar does not stick out";
  EXPECT_NEAR(m.parts[0].volume_mm3 / bar_in_ball, 1, 0.05) << "nor does it grow into the bone";
  EXPECT_NEAR(m.parts[0].volume_mm3 + m.parts[1].volume_mm3, ballVolume(4), 0.005 * ballVolume(4));
  const auto again = readCaseManifest(folder.path() / "a.case");
  ASSERT_TRUE(again && again->gaps);
  EXPECT_EQ(again->gaps->forgotten_mm3, 0);
}

TEST(BakeRecipe, TheSameVoxelFromRecipeOrCallerIsTheSameCase) {
  const TemporaryFolder folder;
  const fs::path recipe = toothRecipe(folder.path());  // says 0.1
  BakeOptions given;
  given.voxelize.voxel_mm = 0.1;
  given.voxel_is_given = true;
  given.close.cleanup_length_mm = 0.005;
  const auto first = bakeRecipe(recipe, folder.path() / "a.case", {}),
             second = bakeRecipe(recipe, folder.path() / "a.case", given);
  ASSERT_TRUE(first && second);
  EXPECT_TRUE(second->was_up_to_date);
}

// A ball of label 1, its radius in voxels of 0.5 mm, as values of a 24 x 24 x 24 volume.
std::string ballLabels(double radius) {
  std::string values;
  for (int k = 0; k < 24; ++k)
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 24; ++i) values.push_back(std::hypot(i - 11.5, j - 11.5, k - 11.5) < radius ? '\1' : '\0');
  return values;
}

TEST(BakeRecipe, AHeaderAndItsRawFileAreBothHashedAndStored) {
  const TemporaryFolder folder;
  const fs::path recipe = folder.path() / "a.toml", out = folder.path() / "a.case";
  write(folder.path() / "ball.mhd",
        "ObjectType = Image\nNDims = 3\nDimSize = 24 24 24\nElementSpacing = 0.5 0.5 0.5\nElementType = MET_UCHAR\n"
        "ElementDataFile = ball.raw\n");
  write(folder.path() / "ball.raw", ballLabels(8));
  write(recipe, kHead +
                    "unit = \"mm\"\nvoxel = 0.2\n[labels]\nvolume = \"ball.mhd\"\n"
                    "[[part]]\nmaterial = \"dentin\"\nlabel = 1\n");
  const auto first = bakeRecipe(recipe, out, {});
  ASSERT_TRUE(first) << first.error().message();

  ASSERT_EQ(first->manifest.sources.size(), 1u);
  const fs::path stored = out / first->manifest.sources[0].stored_as;
  EXPECT_EQ(contentOf(stored / "ball.mhd"), contentOf(folder.path() / "ball.mhd"));
  EXPECT_EQ(contentOf(stored / "ball.raw"), contentOf(folder.path() / "ball.raw"));
  const auto volume = readLabelVolume(stored / "ball.mhd");
  ASSERT_TRUE(volume) << volume.error().message();
  EXPECT_EQ(volume->at(12, 12, 12), 1);
  const auto again = bakeRecipe(recipe, out, {});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->was_up_to_date);

  write(folder.path() / "ball.raw", ballLabels(6));
  BakeOptions force;
  force.overwrite = true;
  EXPECT_FALSE(bakeRecipe(recipe, out, {})) << "the values changed, the header did not";
  const auto changed = bakeRecipe(recipe, out, force);
  ASSERT_TRUE(changed) << changed.error().message();
  EXPECT_NE(changed->manifest.sources[0].sha256, first->manifest.sources[0].sha256);
}

TEST(BakeRecipe, ACompressedNiftiKeepsTheNameItsReaderKnows) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "case";
  fs::create_directory(out);
  CaseManifest manifest;
  const auto source = internal::storeSource(folder.write("jaw.v2.nii.gz", "values"), "NIfTI", "0", out, manifest);
  ASSERT_TRUE(source) << source.error().message();
  EXPECT_EQ((*source)->stored_as, "source-1.nii.gz");
  EXPECT_TRUE(isLabelVolume(out / (*source)->stored_as));
  EXPECT_EQ(contentOf(out / "source-1.nii.gz"), "values");
}

TEST(BakeRecipe, APartThatGetsNothingIsWarnedOf) {
  const TemporaryFolder folder;
  toothRecipe(folder.path());
  write(folder.path() / "a.toml", kHead +
                                      "voxel = 0.2\n[[part]]\nmaterial = \"dentin\"\nmesh = \"tooth.ply\"\n"
                                      "[[part]]\nmaterial = \"pulp\"\nmesh = \"pulp.ply\"\n");
  const auto hidden = bakeRecipe(folder.path() / "a.toml", folder.path() / "a.case", {});
  ASSERT_TRUE(hidden) << hidden.error().message();
  EXPECT_NE(describe(*hidden).find("WARNING: part 2 (pulp, pulp.ply) got nothing"), std::string::npos);
  const auto again = bakeRecipe(folder.path() / "a.toml", folder.path() / "a.case", {});
  ASSERT_TRUE(again && again->was_up_to_date);
  EXPECT_NE(describe(*again).find("WARNING: part 2 (pulp, pulp.ply) got nothing"), std::string::npos);
  const auto seen = bakeRecipe(folder.path() / "tooth.toml", folder.path() / "tooth.case", {});
  ASSERT_TRUE(seen);
  EXPECT_EQ(describe(*seen).find("got nothing"), std::string::npos);
}

TEST(BakeRecipe, AMissingMeshIsNamedAndNothingIsLeft) {
  const TemporaryFolder folder;
  write(folder.path() / "a.toml", kHead + "[[part]]\nmaterial = \"pulp\"\nmesh = \"gone.ply\"\n");
  const auto report = bakeRecipe(folder.path() / "a.toml", folder.path() / "a.case", {});
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message().find("gone.ply"), std::string::npos) << report.error().message();
  EXPECT_NE(report.error().message().find("a.toml names it"), std::string::npos) << report.error().message();
  EXPECT_FALSE(fs::exists(folder.path() / "a.case"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

TEST(BakeRecipe, PartsShareOneUnit) {
  const TemporaryFolder folder;
  Mesh tooth = ballMesh({0, 0, 0}, 0.01, 40), pulp = ballMesh({0, 0, 0}, 0.003, 40);  // metres
  ASSERT_TRUE(writeMesh(folder.path() / "tooth.stl", tooth));
  ASSERT_TRUE(writeMesh(folder.path() / "pulp.stl", pulp));
  write(folder.path() / "a.toml", kHead +
                                      "voxel = 0.4\n[[part]]\nmaterial = \"pulp\"\nmesh = \"pulp.stl\"\n"
                                      "[[part]]\nmaterial = \"dentin\"\nmesh = \"tooth.stl\"\n");
  const auto report = bakeRecipe(folder.path() / "a.toml", folder.path() / "a.case", {});
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_EQ(report->manifest.sources[0].unit, report->manifest.sources[1].unit);
  EXPECT_EQ(report->manifest.sources[0].scale_to_mm, report->manifest.sources[1].scale_to_mm);
}

TEST(BakeRecipe, PartsInDifferentUnitsAreRefused) {
  const TemporaryFolder folder;
  ASSERT_TRUE(writeMesh(folder.path() / "tooth.stl", ballMesh({0, 0, 0}, 8, 40)));
  ASSERT_TRUE(writeMesh(folder.path() / "pulp.stl", ballMesh({0, 0, 0}, 0.004, 40)));  // metres
  write(folder.path() / "a.toml", kHead +
                                      "voxel = 0.4\n[[part]]\nmaterial = \"pulp\"\nmesh = \"pulp.stl\"\n"
                                      "[[part]]\nmaterial = \"dentin\"\nmesh = \"tooth.stl\"\n");
  const auto report = bakeRecipe(folder.path() / "a.toml", folder.path() / "a.case", {});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().place, "unit") << report.error().message();
  EXPECT_FALSE(fs::exists(folder.path() / "a.case"));
}

TEST(VoxelUnion, ASheetOfAirBetweenPartsVanishesAndTheSurfaceStays) {
  // Two halves of a ball of 3 mm with 0.05 mm of air between them.
  Mesh ball = ballMesh({0, 0, 0}, 3, 80), core = ballMesh({0, 0, 0}, 2, 80);
  Mesh rind = ball;
  append(rind, ballMesh({0, 0, 0}, 2.05, 80, true));
  const std::vector<Mesh> parts{rind, core};
  const auto united = voxelUnion(parts, 0.1);
  ASSERT_TRUE(united) << united.error().message();
  const MeshReport check = checkMesh(united->mesh);
  EXPECT_EQ(check.boundary_edges, 0u);
  EXPECT_EQ(check.non_manifold_edges, 0u);
  EXPECT_EQ(edgeConnectedPieces(united->mesh).count, 1u);
  EXPECT_NEAR(signedVolume(united->mesh) / signedVolume(ball), 1, 0.002);
  EXPECT_LT(united->rms_off_mm, 0.01);
}

fs::path dataFolder() {
  const char* given = std::getenv("KERF_DATA");
  return given ? fs::path(given) : fs::path(kSourceFolder) / ".." / "shared" / "data";
}

// Parts of a recipe from files of the data folder, with absolute paths.
std::string partsOf(const std::vector<std::pair<const char*, const char*>>& parts) {
  std::string text;
  for (const auto& [material, file] : parts)
    text += "[[part]]\nmaterial = \"" + std::string(material) + "\"\nmesh = \"" +
            fs::absolute(dataFolder() / file).string() + "\"\n";
  return text;
}

void expectVolumesWithinAHundredth(const BakeReport& report) {
  for (const CasePart& part : report.manifest.parts)
    EXPECT_NEAR(part.volume_mm3 / part.own_mm3, 1, 0.01) << part.material << " from " << part.origin;
}

TEST(BakeRecipeData, MolarOfFourTissuesKeepsEachVolume) {
  if (!fs::exists(dataFolder() / "molar-L6-enamel.stl")) GTEST_SKIP() << "no data: " << dataFolder();
  const TemporaryFolder folder;
  write(folder.path() / "l6.toml", kHead + "unit = \"mm\"\nvoxel = 0.05\n" +
                                       partsOf({{"pulp", "molar-L6-pulp.stl"},
                                                {"enamel", "molar-L6-enamel.stl"},
                                                {"dentin", "molar-L6-dentin.stl"},
                                                {"pdl", "molar-L6-pdl.stl"}}));
  const auto report = bakeRecipe(folder.path() / "l6.toml", folder.path() / "l6.case", {});
  ASSERT_TRUE(report) << report.error().message();
  fmt::print("{}", describe(*report));
  expectVolumesWithinAHundredth(*report);
}

TEST(BakeRecipeData, BlockOfBoneWithTheMolarInItKeepsEachVolume) {
  KERF_SLICE_OF(3, "block");
  if (!fs::exists(dataFolder() / "mandible-block-L4-L6-cortical.stl")) GTEST_SKIP() << "no data: " << dataFolder();
  const TemporaryFolder folder;
  write(folder.path() / "block.toml", kHead + "unit = \"mm\"\nvoxel = 0.07\n" +
                                          partsOf({{"pulp", "molar-L6-pulp.stl"},
                                                   {"enamel", "molar-L6-enamel.stl"},
                                                   {"dentin", "molar-L6-dentin.stl"},
                                                   {"pdl", "molar-L6-pdl.stl"},
                                                   {"cancellous", "mandible-block-L4-L6-cancellous.stl"},
                                                   {"cortical", "mandible-block-L4-L6-cortical.stl"}}));
  const auto report = bakeRecipe(folder.path() / "block.toml", folder.path() / "block.case", {});
  ASSERT_TRUE(report) << report.error().message();
  fmt::print("{}", describe(*report));
  expectVolumesWithinAHundredth(*report);
}

// A recipe of labels of one volume.
std::string labelsOf(const char* volume, const std::string& more,
                     const std::vector<std::pair<const char*, int>>& parts) {
  std::string text = kHead;
  for (const auto& [material, label] : parts)
    text += fmt::format("[[part]]\nmaterial = \"{}\"\nlabel = {}\n", material, label);
  return text + "[labels]\nvolume = \"" + fs::absolute(dataFolder() / volume).string() + "\"\n" + more;
}

TEST(BakeRecipeData, LowerJawOfACbctKeepsEachLabelsVolume) {
  KERF_SLICE_OF(3, "jaws");
  if (!fs::exists(dataFolder() / "cbct-jaws-teeth-labels.nii.gz")) GTEST_SKIP() << "no data: " << dataFolder();
  const TemporaryFolder folder;
  // Cracks of a tenth of a millimetre run between bone and canal. Coarser voxels fill them, and the canal gains 2 %.
  write(folder.path() / "jaw.toml", "voxel = 0.1\n" + labelsOf("cbct-jaws-teeth-labels.nii.gz", "",
                                                               {{"nerve_canal", 5}, {"dentin", 4}, {"cortical", 2}}));
  const auto report = bakeRecipe(folder.path() / "jaw.toml", folder.path() / "jaw.case", {});
  ASSERT_TRUE(report) << report.error().message();
  fmt::print("{}", describe(*report));
  expectVolumesWithinAHundredth(*report);
}

TEST(BakeRecipeData, SkullPhantomByAThresholdKeepsItsVolume) {
  if (!fs::exists(dataFolder() / "ct-skull-phantom-128-intensity.nrrd")) GTEST_SKIP() << "no data: " << dataFolder();
  const TemporaryFolder folder;
  const auto bakeWith = [&](const std::string& more) {
    write(folder.path() / "skull.toml",
          "voxel = 0.15\n" + labelsOf("ct-skull-phantom-128-intensity.nrrd", more, {{"cortical", 1}}));
    BakeOptions again;
    again.overwrite = true;
    return bakeRecipe(folder.path() / "skull.toml", folder.path() / "skull.case", again);
  };
  // Sheets of a voxel or two. Without a correction, chords thin them by 3 %.
  const auto report = bakeWith("spacing = [1, 1, 1]\nthreshold = 120\n");
  ASSERT_TRUE(report) << report.error().message();
  fmt::print("{}", describe(*report));
  expectVolumesWithinAHundredth(*report);
  const auto unspaced = bakeWith("threshold = 120\n"), unlabelled = bakeWith("spacing = [1, 1, 1]\n");
  ASSERT_FALSE(unspaced || unlabelled);
  EXPECT_NE(unspaced.error().message().find("spacing"), std::string::npos) << unspaced.error().message();
  EXPECT_NE(unlabelled.error().message().find("threshold"), std::string::npos) << unlabelled.error().message();
}

TEST(BakeReport, WhatTheToolWillNotFindIsSaidInMillimetresAndOnlyWhereItIsMuch) {
  BakeReport r;
  r.manifest.voxel_mm = 0.5;
  r.manifest.solid_area_mm2 = 100;
  r.manifest.shell_area_mm2 = 93;
  EXPECT_NE(describe(r).find("narrower than 0.5 mm, 7 % of the surface. The export"), std::string::npos) << describe(r);
  EXPECT_NE(describe(r).find("--voxel 0.25 keeps more"), std::string::npos);
  r.manifest.shell_area_mm2 = 96;
  EXPECT_EQ(describe(r).find("narrower than"), std::string::npos) << describe(r);
}

}  // namespace
}  // namespace kerf::bake_recipe_test
