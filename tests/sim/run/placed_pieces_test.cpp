#include "sim/run/export/placed_pieces.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "geometry/base/hash.h"
#include "geometry/mesh/mesh_check.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"

namespace kerf::placed_pieces_test {
namespace {

using Piece = RunManifest::Piece;

Mesh shifted(Mesh mesh, const Vec3d& by) {
  for (Vec3d& v : mesh.vertices) v = roundedToFloat(v + by);
  return mesh;
}

Piece pieceAt(std::uint32_t id, const Vec3d& inside, const Rigid3& pose = {}) {
  Piece out;
  out.id = id;
  out.name = "piece " + std::to_string(id);
  out.inside = inside;
  out.T_case_piece = pose;
  return out;
}

Rigid3 turned(double degrees, const Vec3d& by) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vec3d(1, 2, 3).normalized())), by};
}

// Three blocks of 6 x 4 x 3 mm in a row, and a speck without a piece.
Mesh row() {
  Mesh out = test::blockMesh(true);
  append(out, shifted(test::blockMesh(true), {10, 0, 0}));
  append(out, shifted(test::blockMesh(true), {20, 0, 0}));
  append(out, shifted(test::blockMesh(true, {0.05, 0.05, 0.05}), {23.2, 0, 0}));
  return out;
}

TEST(PlacedPieces, WhatIsNotMovedKeepsEveryBit) {
  const Mesh mesh = row();
  const std::vector<Piece> pieces = {pieceAt(4, {0, 0, -1}), pieceAt(7, {10, 0, -1}, turned(20, {0, 3, 5})),
                                     pieceAt(5, {20, 0, -1})};
  const auto placed = placedPieces(mesh, pieces);
  ASSERT_TRUE(placed) << placed.error().message();
  ASSERT_EQ(placed->size(), 3u);
  EXPECT_EQ((*placed)[0].mesh.vertices, test::blockMesh(true).vertices);
  EXPECT_FALSE((*placed)[0].is_moved);
  EXPECT_EQ((*placed)[2].mesh.triangles.size(), 24u) << "the speck goes with the nearest";
  EXPECT_TRUE((*placed)[1].is_moved);
  for (std::size_t v = 0; v < 8; ++v) {
    const Vec3d there = pieces[1].T_case_piece * mesh.vertices[8 + v];
    EXPECT_LT(((*placed)[1].mesh.vertices[v] - there).norm(), 1e-5);
    EXPECT_EQ((*placed)[1].mesh.vertices[v], roundedToFloat((*placed)[1].mesh.vertices[v]));
  }
  EXPECT_TRUE(checkMesh(together(*placed)).print_ready);

  const auto back = placedPieces(mesh, pieces, true);
  ASSERT_TRUE(back);
  EXPECT_EQ(together(*back).vertices, mesh.vertices);
}

// Two rows of touching teeth: each row is one piece, with one inner point at one end.
TEST(PlacedPieces, SolidsThatTouchGoTogether) {
  Mesh teeth;
  for (int n = 0; n < 5; ++n) append(teeth, shifted(test::blockMesh(true), {6.05 * n, 0, 0}));
  for (int n = 0; n < 5; ++n) append(teeth, shifted(test::blockMesh(true), {6.05 * n, 4.4, 0}));
  const std::vector<Piece> rows = {pieceAt(1, {0, 0, -1}), pieceAt(2, {4 * 6.05, 4.4, -1}, turned(0, {0, 0, 5}))};
  const auto placed = placedPieces(teeth, rows);
  ASSERT_TRUE(placed) << placed.error().message();
  ASSERT_EQ(placed->size(), 2u);
  EXPECT_EQ((*placed)[0].mesh.triangles.size(), 60u);
  EXPECT_LT(bounds((*placed)[0].mesh).max[1], 2.1);
  EXPECT_GT(bounds((*placed)[1].mesh).min[1], 2.3);
  EXPECT_NEAR(bounds((*placed)[1].mesh).max[2], 5, 1e-5);
}

TEST(PlacedPieces, PiecesThatHangTogetherAreNotTornApart) {
  const Mesh mesh = row();
  const std::vector<Piece> two = {pieceAt(1, {-1, 0, -1}), pieceAt(2, {1, 0, -1}, turned(5, {0, 0, 1}))};
  const auto placed = placedPieces(mesh, two);
  ASSERT_FALSE(placed);
  EXPECT_NE(placed.error().message().find("are connected"), std::string::npos);
  const auto back = placedPieces(mesh, two, true);
  ASSERT_TRUE(back) << "nothing is moved";
  EXPECT_EQ(together(*back).triangles.size(), mesh.triangles.size());

  const Rigid3 aside = turned(5, {0, 0, 1});
  const std::vector<Piece> alike = {pieceAt(1, {-1, 0, -1}, aside), pieceAt(2, {1, 0, -1}, aside)};
  const auto both = placedPieces(mesh, alike);
  ASSERT_TRUE(both) << "moved alike: " << both.error().message();
  EXPECT_EQ(together(*both).triangles.size(), mesh.triangles.size());
}

TEST(PlacedPieces, HaveTheNamesOfTheirSourceUnlessAPersonNamedThem) {
  const Mesh mesh = row();
  const std::vector<NamedPart> objects = {{"tooth 36", 0}, {"gingiva", 12}, {"tooth 37", 24}};
  const ObjectNames names = ObjectNames::ofMesh(mesh, objects);
  std::vector<Piece> pieces = {pieceAt(4, {0, 0, -1}), pieceAt(7, {10, 0, -1}, turned(20, {0, 3, 5})),
                               pieceAt(5, {20, 0, -1})};
  pieces[2].name = "piece of mine";
  const auto placed = placedPieces(mesh, pieces, false, names);
  ASSERT_TRUE(placed) << placed.error().message();
  EXPECT_EQ(objectsOf(*placed), (std::vector<NamedPart>{{"tooth 36", 0}, {"gingiva", 12}, {"piece of mine", 24}}));
  EXPECT_EQ((*placed)[1].name, "piece 7") << "as the session calls it";
  const auto nameless = placedPieces(mesh, std::span(pieces).first(2));
  ASSERT_TRUE(nameless);
  EXPECT_TRUE(objectsOf(*nameless).empty());
}

// Touching teeth are one piece and two solids. Each keeps its name, also after a move.
TEST(PlacedPieces, APieceOfSeveralSolidsHasTheNamesOfAll) {
  const Mesh mesh = row();
  const std::vector<NamedPart> objects = {{"tooth 36", 0}, {"gingiva", 12}, {"tooth 37", 24}, {"", 36}};
  const ObjectNames names = ObjectNames::ofMesh(mesh, objects);
  const auto whole = placedPieces(mesh, {}, false, names);
  ASSERT_TRUE(whole);
  EXPECT_EQ(objectsOf(*whole), (std::vector<NamedPart>{{"", 0}, {"tooth 36", 12}, {"gingiva", 24}, {"tooth 37", 36}}));

  std::vector<Piece> one = {pieceAt(1, {0, 0, -1}, turned(20, {0, 3, 5}))};
  const auto moved = placedPieces(mesh, one, false, names);
  ASSERT_TRUE(moved);
  EXPECT_EQ(objectsOf(*moved), objectsOf(*whole));
  one[0].name = "Bridge";
  const auto named = placedPieces(mesh, one, false, names);
  ASSERT_TRUE(named);
  EXPECT_EQ(objectsOf(*named), (std::vector<NamedPart>{{"Bridge", 0}})) << "by the user";
}

TEST(PlacedPieces, FilesKeepLettersOfAnyScript) {
  const auto fileOf = [](const std::string& name) {
    const PlacedPiece piece{.name = name};
    return filesOfPieces("w.obj", std::span(&piece, 1))[0].string();
  };
  EXPECT_EQ(fileOf("Zähne 3/6"), "w-Zähne-3-6.obj");
  EXPECT_EQ(fileOf("名前"), "w-名前.obj");
  EXPECT_EQ(fileOf("a\u202eb\u200bc"), "w-a-b-c.obj") << "marks that turn or hide text";
  EXPECT_EQ(fileOf("../x"), "w----x.obj");
  std::string longest;
  for (int n = 0; n < 40; ++n) longest += "ä";
  EXPECT_EQ(fileOf(longest), "w-" + longest.substr(0, 60) + ".obj");
  const std::vector<PlacedPiece> alike(3, PlacedPiece{.name = "Tooth"});
  EXPECT_EQ(filesOfPieces("w.obj", alike)[2], "w-Tooth-3.obj");
}

TEST(PlacedPieces, SolidsOfOneNameAreNumbered) {
  const Mesh mesh = row();
  const std::vector<NamedPart> objects = {{"tooth", 0}, {"piece 2", 12}, {"tooth", 24}, {"", 36}};
  const std::vector<PlacedPiece> solids = solidPieces(mesh, ObjectNames::ofMesh(mesh, objects));
  std::vector<std::string> of_pieces, of_objects;
  for (const PlacedPiece& piece : solids) {
    of_pieces.push_back(piece.name);
    of_objects.push_back(piece.objects.empty() ? "" : piece.objects[0].name);
  }
  EXPECT_EQ(of_pieces, (std::vector<std::string>{"tooth", "piece 2", "tooth 2", "piece 4"}));
  EXPECT_EQ(of_objects, (std::vector<std::string>{"tooth", "piece 2", "tooth", ""}));
  EXPECT_EQ(solidPieces(mesh)[3].name, "piece 4");
}

TEST(PlacedPieces, WithoutPiecesThereIsOne) {
  const auto placed = placedPieces(row(), {});
  ASSERT_TRUE(placed);
  EXPECT_EQ(placed->size(), 1u);
}

TEST(PlacedPieces, TheManifestBringsThemBack) {
  const TemporaryFolder folder;
  RunManifest m;
  m.kerf_version = "x";
  m.mode = kModeSession;
  m.voxel_mm = 0.1;
  m.tools.push_back({"a", "tools/01/a.toml", "b"});
  m.pieces = {pieceAt(1, {0.1, 1.0 / 3, -7}), pieceAt(9, {1, 2, 3}, turned(33, {1, 1e-7, 4}))};
  m.pieces[1].name = "chin \"left\"";
  ASSERT_TRUE(writeRunManifest(folder.path(), m));
  const auto read = readRunManifest(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->pieces.size(), 2u);
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_EQ(read->pieces[n].id, m.pieces[n].id);
    EXPECT_EQ(read->pieces[n].name, m.pieces[n].name);
    EXPECT_EQ(read->pieces[n].inside, m.pieces[n].inside);
    EXPECT_EQ(read->pieces[n].T_case_piece.translation, m.pieces[n].T_case_piece.translation);
    EXPECT_EQ(read->pieces[n].T_case_piece.rotation.coeffs(), m.pieces[n].T_case_piece.rotation.coeffs());
  }
  EXPECT_FALSE(read->pieces[0].isMoved());
  EXPECT_TRUE(read->pieces[1].isMoved());
}

TEST(PlacedPieces, FilesAreNamedAfterThemEachADifferentOne) {
  std::vector<PlacedPiece> pieces(6);
  const char* const names[] = {"piece 2", "../x:y", "piece 2", "PIECE-2", "piece-2-2", ""};
  for (std::size_t n = 0; n < pieces.size(); ++n) pieces[n].name = names[n];
  const auto files = filesOfPieces("a/jaw.stl", pieces);
  const char* const wanted[] = {"a/jaw-piece-2.stl",   "a/jaw----x-y.stl",      "a/jaw-piece-2-2.stl",
                                "a/jaw-PIECE-2-3.stl", "a/jaw-piece-2-2-2.stl", "a/jaw-.stl"};
  for (std::size_t n = 0; n < pieces.size(); ++n) EXPECT_EQ(files[n], wanted[n]);

  pieces.resize(2);
  for (PlacedPiece& piece : pieces) piece.name = std::string(300, 'x');
  const auto cut = filesOfPieces("jaw.stl", pieces);
  EXPECT_LT(cut[1].string().size(), 80u);
  EXPECT_NE(cut[0], cut[1]);
}

TEST(PlacedPieces, WhatTheCaseWasMadeOfIsNeverWrittenOver) {
  const TemporaryFolder folder;
  const auto scan = folder.write("scan.stl", "a scan"), other = folder.write("other.stl", "another");
  CaseManifest manifest;
  manifest.sources.emplace_back();
  manifest.sources[0].sha256 = *sha256OfFile(scan);
  EXPECT_FALSE(requireNoSource(scan, manifest));
  EXPECT_FALSE(requireNoSource(folder.write("copy of it.stl", "a scan"), manifest)) << "by whatever name";
  EXPECT_TRUE(requireNoSource(other, manifest));
  EXPECT_TRUE(requireNoSource(folder.path() / "new.stl", manifest));
}

}  // namespace
}  // namespace kerf::placed_pieces_test
