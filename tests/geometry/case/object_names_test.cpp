#include "geometry/case/object_names.h"

#include <gtest/gtest.h>

#include "geometry/base/hash.h"
#include "geometry/formats/mesh_writer.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"

namespace kerf::object_names_test {
namespace {

using Objects = std::vector<NamedPart>;

Mesh blockAt(double x) {
  Mesh out = test::blockMesh(true);
  for (Vec3d& p : out.vertices) p = roundedToFloat(p + Vec3d(x, 0, 0));
  return out;
}

Mesh row(std::initializer_list<double> places) {
  Mesh out;
  for (const double x : places) append(out, blockAt(x));
  return out;
}

const Objects kThree{{"tooth 36", 0}, {"gingiva", 12}, {"tooth 37", 24}};

TEST(ObjectNames, APieceHasTheNameOfMostOfItsTriangles) {
  const ObjectNames names = ObjectNames::ofMesh(row({0, 10, 20}), kThree);
  EXPECT_EQ(names.nameOf(blockAt(10)), "gingiva");
  EXPECT_EQ(names.nameOf(blockAt(20)), "tooth 37");
  EXPECT_EQ(names.nameOf(blockAt(30)), "") << "of none";
  Mesh mixed = row({0, 10});
  mixed.triangles.resize(20);
  EXPECT_EQ(names.nameOf(mixed), "tooth 36");
}

TEST(ObjectNames, SolidsAreGroupedByNameInFilesThatHoldNames) {
  const ObjectNames names = ObjectNames::ofMesh(row({0, 10, 20}), kThree);
  Mesh cut = row({30, 20, 0, 10});
  for (std::size_t t = 0; t < cut.triangles.size(); ++t)
    cut.face_colors.push_back({static_cast<std::uint8_t>(t), 0, 0, 255});
  const NamedMesh out = names.grouped(cut, "a.3MF");
  EXPECT_EQ(out.objects, (Objects{{"", 0}, {"tooth 36", 12}, {"gingiva", 24}, {"tooth 37", 36}}));
  const Mesh expected = row({30, 0, 10, 20});
  EXPECT_EQ(out.mesh.vertices, expected.vertices);
  EXPECT_EQ(out.mesh.triangles, expected.triangles);
  EXPECT_EQ(out.mesh.face_colors[12][0], 24) << "that of the triangle";

  const NamedMesh stl = names.grouped(cut, "a.stl");
  EXPECT_EQ(stl.objects, Objects{});
  EXPECT_EQ(stl.mesh.vertices, cut.vertices);
  EXPECT_EQ(names.grouped(blockAt(10), "a.obj").objects, (Objects{{"gingiva", 0}}));
  EXPECT_EQ(ObjectNames().grouped(cut, "a.obj").objects, Objects{});
}

TEST(ObjectNames, OneNameNeedsNoVertexAndASharedPlaceTellsNothing) {
  const ObjectNames one = ObjectNames::ofMesh(row({0}), Objects{{"tooth 36", 0}});
  EXPECT_EQ(one.nameOf(blockAt(55)), "tooth 36") << "wrapped or moved";
  const ObjectNames twice = ObjectNames::ofMesh(row({0, 0}), Objects{{"a", 0}, {"b", 12}});
  EXPECT_EQ(twice.nameOf(blockAt(0)), "");
}

CaseSource sourceAt(const std::filesystem::path& file, const std::string& format, double scale) {
  CaseSource out;
  out.stored_as = file.filename().string();
  out.format = format;
  out.sha256 = sha256OfFile(file).value_or("");
  out.scale_to_mm = scale;
  return out;
}

TEST(ObjectNames, OfACaseAreThoseOfItsSources) {
  const TemporaryFolder folder;
  Mesh in_cm = row({0, 10, 20});
  for (Vec3d& p : in_cm.vertices) p /= 10;
  const auto obj = folder.path() / "source-1.obj", stl = folder.path() / "source-2.stl";
  ASSERT_TRUE(writeMesh(obj, in_cm, {.objects = kThree}));
  ASSERT_TRUE(writeMesh(stl, blockAt(30)));
  CaseManifest manifest;
  manifest.sources = {sourceAt(obj, "OBJ", 10), sourceAt(stl, "binary STL", 1)};
  const ObjectNames names = ObjectNames::ofCase(folder.path(), manifest);
  EXPECT_EQ(names.nameOf(blockAt(0)), "tooth 36");
  EXPECT_EQ(names.nameOf(blockAt(30)), "");

  manifest.sources[0].sha256 = std::string(64, '0');
  EXPECT_TRUE(ObjectNames::ofCase(folder.path(), manifest).isEmpty()) << "edited since it was stored";
  manifest.sources[0].stored_as = "source-9.obj";
  EXPECT_TRUE(ObjectNames::ofCase(folder.path(), manifest).isEmpty());
}

// The name of the only readable file does not apply to the others.
TEST(ObjectNames, OfASourceThatChangedAreNotThoseOfAnother) {
  const TemporaryFolder folder;
  const auto first = folder.path() / "source-1.obj", second = folder.path() / "source-2.obj";
  ASSERT_TRUE(writeMesh(first, row({0, 10, 20}), {.objects = kThree}));
  ASSERT_TRUE(writeMesh(second, blockAt(30), {.objects = Objects{{"splint", 0}}}));
  CaseManifest manifest;
  manifest.sources = {sourceAt(first, "OBJ", 1), sourceAt(second, "OBJ", 1)};
  manifest.sources[0].sha256 = std::string(64, '0');
  for (const char* const stored : {"source-1.obj", "source-9.obj"}) {
    manifest.sources[0].stored_as = stored;
    const ObjectNames names = ObjectNames::ofCase(folder.path(), manifest);
    EXPECT_EQ(names.nameOf(blockAt(0)), "") << stored;
    EXPECT_EQ(names.nameOf(blockAt(30)), "splint") << stored;
  }
}

}  // namespace
}  // namespace kerf::object_names_test
