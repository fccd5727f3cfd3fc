#include "geometry/field/vdb_io.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <sys/stat.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>

#include "geometry/field/material_bricks.h"
#include "geometry/field/material_field.h"
#include "tests/geometry/sampled_field.h"
#include "tests/support/temporary_folder.h"

namespace kerf::vdb_io_test {
namespace {

TEST(VdbIo, FieldsComeBackBitForBitWithTheirDeepInside) {
  const TemporaryFolder folder;
  BrickField field(0.05, 0.2f, -0.25f);
  for (std::size_t n = 0; n < kBrickNodes; ++n)
    field.brick(field.touch({-3, 2, 1}))[n] = 1e-3f * static_cast<float>(n) - 0.2f;
  field.markInterior({-2, 2, 1});
  field.markInterior({40, -17, 3});
  ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {{"phi", &field}}));
  const auto back = readVdb(folder.path() / "f.vdb", "phi");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->stateHash(), field.stateHash());
  EXPECT_EQ(back->interior(), -0.25f);
  EXPECT_EQ(back->at({-15, 17, 9}), -0.25f);
  EXPECT_EQ(back->at({8 * 40, 8 * -17, 8 * 3 + 7}), -0.25f);
  EXPECT_EQ(back->at({0, 0, 0}), 0.2f);
  EXPECT_EQ(back->interiorBricks().size(), 2u);
}

// Without a brick deep inside, the nodes give the width of the band: a tool's table must be right that far.
TEST(VdbIo, TheBandOfAThinObjectReachesAsFarAsItsNodes) {
  const TemporaryFolder folder;
  BrickField field(0.05, 0.15f, -0.2f);
  for (std::size_t n = 0; n < kBrickNodes; ++n)
    field.brick(field.touch({0, 0, 0}))[n] = std::max(0.15f - 1e-3f * static_cast<float>(n), -0.2f);
  ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {{"phi", &field}}));
  const auto back = readVdb(folder.path() / "f.vdb", "phi");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->interior(), -0.2f);
}

// OpenVDB gives each file a random identifier.
TEST(VdbIo, TheSameFieldsAreTheSameBytesAndOthersHaveAnotherIdentifier) {
  const TemporaryFolder folder;
  BrickField field(0.05, 0.2f, -0.25f);
  field.brick(field.touch({-3, 2, 1}))[7] = 0.1f;
  std::string bytes[3];
  for (std::string& one : bytes) {
    if (&one == &bytes[2]) field.brick(field.touch({-3, 2, 1}))[8] = 0.1f;
    ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {{"phi", &field}}));
    one = contentOf(folder.path() / "f.vdb");
  }
  EXPECT_EQ(bytes[0], bytes[1]);
  EXPECT_NE(bytes[0].substr(21, 36), bytes[2].substr(21, 36));
  EXPECT_EQ(bytes[0].find_first_not_of("0123456789abcdef-", 21), 57u) << "it stands where it is expected";
}

TEST(VdbIo, AMissingFileOrGridIsAnError) {
  const TemporaryFolder folder;
  EXPECT_FALSE(readVdb(folder.path() / "none.vdb", "phi"));
  const BrickField field(0.1, 0.3f);
  ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {{"phi", &field}}));
  const auto other = readVdb(folder.path() / "f.vdb", "sweep");
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message().find("sweep"), std::string::npos);
}

// A case from elsewhere: numbers that are no distances must not be cut as tissue.
TEST(VdbIo, ValuesThatAreNoDistancesAreRefused) {
  const TemporaryFolder folder;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinite = std::numeric_limits<float>::infinity();
  for (const float bad : {kNan, kInfinite, -kInfinite, 1e30f, -51.f}) {
    BrickField field(0.05, 0.2f, -0.25f);
    field.brick(field.touch({0, 0, 0}))[77] = bad;
    ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {{"phi", &field}}));
    const auto back = readVdb(folder.path() / "f.vdb", "phi");
    ASSERT_FALSE(back) << bad;
    EXPECT_NE(back.error().message().find("at voxel 1, 1, 5"), std::string::npos) << back.error().message();
  }
  BrickField deep(0.05, 0.2f, -1e9f);
  deep.markInterior({0, 0, 0});
  ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {{"phi", &deep}}));
  EXPECT_FALSE(readVdb(folder.path() / "f.vdb", "phi"));
}

// One number in a file of some kB: 4096 nodes along each side of a tile are 134 million bricks.
TEST(VdbIo, ATileThatWouldFillTheMemoryIsRefused) {
  const TemporaryFolder folder;
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(0.2f);
  grid->setName("phi");
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.05));
  grid->tree().addTile(openvdb::FloatTree::RootNodeType::LEVEL, openvdb::Coord(0, 0, 0), -0.25f, false);
  const auto file = folder.path() / "f.vdb";
  openvdb::io::File(file.string()).write({grid});
  const auto back = readVdb(file, "phi");
  ASSERT_FALSE(back);
  EXPECT_NE(back.error().message().find("deep inside"), std::string::npos) << back.error().message();
}

TEST(VdbIo, APipeIsRefusedAtOnce) {
  const TemporaryFolder folder;
  const auto pipe = folder.path() / "pipe.vdb";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_FALSE(readVdb(pipe, "phi"));
  EXPECT_FALSE(inspectVdb(pipe));
}

std::string contentOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(VdbIo, AFileThatWasCutShortIsRefused) {
  const TemporaryFolder folder;
  BrickField field(0.05, 0.2f, -0.25f);
  for (const int x : {0, 1, 40})
    for (std::size_t n = 0; n < kBrickNodes; ++n)
      field.brick(field.touch({x, 2, 1}))[n] = 1e-4f * static_cast<float>((n * n + 7 * n) % 1999);
  ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {{"phi", &field}}));
  const std::string good = contentOf(folder.path() / "f.vdb");
  for (std::size_t size = 0; size < good.size(); size += 1 + size / 16) {
    const auto back = readVdb(folder.write("short.vdb", good.substr(0, size)), "phi");
    EXPECT_FALSE(back) << size << " of " << good.size() << " bytes";
  }
  const auto back = readVdb(folder.write("short.vdb", good.substr(0, good.size() - 100)), "phi");
  ASSERT_FALSE(back);
  EXPECT_NE(back.error().message().find("cut short"), std::string::npos) << back.error().message();
}

// A small grid as a file, with single numbers forged. OpenVDB uses them unchecked: it allocates a length of 2 GB before
// it reads a byte.
class ForgedVdb : public ::testing::Test {
 protected:
  void SetUp() override {
    BrickField field(0.05, 0.2f, -0.25f);
    for (std::size_t n = 0; n < kBrickNodes; ++n)
      field.brick(field.touch({3, 2, 1}))[n] = 1e-3f * static_cast<float>(n) - 0.2f;
    field.markInterior({2, 2, 1});
    ASSERT_TRUE(writeVdb(folder_.path() / "f.vdb", {{"phi", &field}}, {{"case_id", "0123"}}));
    good_ = contentOf(folder_.path() / "f.vdb");
    ASSERT_TRUE(readVdb(folder_.path() / "f.vdb", "phi"));
  }

  template <class Number>
  static std::string forged(std::string bytes, std::size_t at, Number number) {
    std::memcpy(bytes.data() + at, &number, sizeof number);
    return bytes;
  }

  // The reader's error for these bytes; empty: none.
  std::string refusalOf(const std::string& bytes) const {
    const auto field = readVdb(folder_.write("bad.vdb", bytes), "phi");
    return field ? std::string() : field.error().message();
  }

  // Behind the transform: 15 numbers after the name of the map.
  std::size_t tree() const { return good_.find("UniformScaleMap") + 15 + 15 * sizeof(double); }

  TemporaryFolder folder_;
  std::string good_;
};

TEST_F(ForgedVdb, LengthsAndCountsAreRefusedBeforeMemoryIsTakenForThem) {
  const std::size_t metadata = good_.find("case_id") + 7 + 4 + 6;  // name, and "string" with its length
  const std::size_t map = good_.find("UniformScaleMap") - 4;
  const std::size_t notes = good_.find("__delayedload") + 13 + 4;
  const std::size_t tiles = tree() + 4 + 4, children = tiles + 4;
  const std::size_t first_block = children + 4 + 12 + 2 * 4096 + 1;
  for (const std::size_t at : {metadata, map, notes, tiles, children}) {
    const std::string refusal = refusalOf(forged(good_, at, std::int32_t{0x7ffffff0}));
    EXPECT_NE(refusal.find("grid phi: byte "), std::string::npos) << "byte " << at << ": " << refusal;
  }
  for (const std::int64_t length : {std::int64_t{1} << 33, -(std::int64_t{1} << 33), std::int64_t{1'000'000}}) {
    const std::string refusal = refusalOf(forged(good_, first_block, length));
    EXPECT_NE(refusal.find("grid phi: byte "), std::string::npos) << length << ": " << refusal;
  }
}

TEST_F(ForgedVdb, NodesFarAwayOrTwiceAtOnePlaceAreRefused) {
  const std::size_t origin = tree() + 4 + 4 + 8;
  for (const std::int32_t x : {1 << 30, -(1 << 30), 17})
    EXPECT_NE(refusalOf(forged(good_, origin, x)).find("a node at voxel"), std::string::npos) << x;
}

TEST_F(ForgedVdb, OtherTypesAndTransformsAreRefused) {
  const auto with = [&](const char* from, const char* to) {
    std::string bytes = good_;
    return bytes.replace(bytes.find(from), std::strlen(to), to);
  };
  EXPECT_NE(refusalOf(with("Tree_float_5_4_3", "Tree_int32_5_4_3")).find("of type"), std::string::npos);
  EXPECT_NE(refusalOf(with("UniformScaleMap", "UnitaryMap_____")).find("transform"), std::string::npos);
}

TEST_F(ForgedVdb, AFileCutShortAnywhereIsRefused) {
  for (std::size_t size = 0; size < good_.size(); size += 1 + size / 64)
    EXPECT_FALSE(refusalOf(good_.substr(0, size)).empty()) << size << " bytes";
}

// Forges some bytes of each kind: a successful read gives a field of numbers that can be cut.
TEST_F(ForgedVdb, NoByteMakesTheReaderCrash) {
  for (std::size_t at = 0; at < good_.size(); at += at < 1500 ? 5 : 151)
    for (const char wrong : {'\x00', '\x7f', '\xff'}) {
      std::string bad = good_;
      bad[at] = wrong;
      const auto field = readVdb(folder_.write("bad.vdb", bad), "phi");
      if (!field) continue;
      EXPECT_LE(field->brickCount(), 1u + 8u) << "byte " << at;
      for (std::size_t b = 0; b < field->brickCount(); ++b)
        for (const float value : field->brick(b)) ASSERT_LE(std::abs(value), 1000 * field->voxel()) << "byte " << at;
    }
}

TEST(MaterialGrid, ANumberThatNoMaterialHasIsRefusedWithItsPlace) {
  const TemporaryFolder folder;
  openvdb::initialize();
  for (const std::int32_t label : {-1, 256, 1 << 30}) {
    auto grid = openvdb::Int32Grid::create(0);
    grid->setName("material");
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    grid->tree().setValue({4, 5, 6}, label);
    const auto file = folder.path() / "m.vdb";
    openvdb::io::File(file.string()).write({grid});
    const auto read = readMaterialField(file);
    ASSERT_FALSE(read) << label;
    EXPECT_NE(read.error().message().find("at voxel 4, 5, 6, which is 2.000, 2.500, 3.000 mm"), std::string::npos)
        << read.error().message();
  }
}

MaterialBricks someMaterials() {
  MaterialBricks out;
  out.voxel = 0.5;
  for (const Vec3i& brick : {Vec3i{-3, 2, 1}, Vec3i{4, -5, 6}, Vec3i{4, 5, 6}}) out.bricks.push_back(brick);
  std::sort(out.bricks.begin(), out.bricks.end(),
            [](const Vec3i& a, const Vec3i& b) { return coordKey(a) < coordKey(b); });
  for (std::size_t b = 0; b < out.bricks.size(); ++b) {
    out.numbers.emplace_back().fill(static_cast<std::uint8_t>(3 + b));
    out.numbers.back()[static_cast<std::size_t>(nodeOffset(1, 2, 3))] = 255;
  }
  out.added = {{11, "composite"}, {255, "gum"}};
  return out;
}

TEST(MaterialBricks, ComeBackAsTheyWereBesideAField) {
  const TemporaryFolder folder;
  BrickField field(0.5, 2.f, -2.f);
  field.touch({0, 0, 0});
  const auto file = folder.path() / "f.vdb";
  const MaterialBricks written = someMaterials();
  ASSERT_TRUE(writeVdb(file, {{"phi", &field}}, {}, &written));
  const auto read = readMaterialBricks(file);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->voxel, 0.5);
  EXPECT_EQ(read->bricks, written.bricks);
  EXPECT_EQ(read->numbers, written.numbers);
  EXPECT_EQ(read->added, written.added);
  EXPECT_TRUE(readVdb(file, "phi"));
  for (std::size_t b = 0; b < written.bricks.size(); ++b) EXPECT_EQ(*read->find(written.bricks[b]), written.numbers[b]);
  EXPECT_EQ(read->find({0, 0, 0}), nullptr);

  // A run without added material has no grid.
  const MaterialBricks none;
  ASSERT_TRUE(writeVdb(file, {{"phi", &field}}, {}, &none));
  EXPECT_EQ(inspectVdb(file)->size(), 1u);
  const auto empty = readMaterialBricks(file);
  ASSERT_TRUE(empty) << empty.error().message();
  EXPECT_TRUE(empty->isEmpty());
  EXPECT_FALSE(readMaterialBricks(folder.path() / "none.vdb"));
}

TEST(MaterialBricks, LieOverTheLabelsOfACase) {
  const TemporaryFolder folder;
  openvdb::initialize();
  auto grid = openvdb::Int32Grid::create(0);
  grid->setName("material");
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  grid->tree().fill(openvdb::CoordBBox({0, 0, 0}, {63, 63, 63}), 5);
  const auto file = folder.path() / "m.vdb";
  openvdb::io::File(file.string()).write({grid});
  const auto in_case = readMaterialField(file);
  ASSERT_TRUE(in_case) << in_case.error().message();

  MaterialBricks over = someMaterials();
  const Vec3i in_both(4, 5, 6);
  const std::uint8_t number = over.find(in_both)->front();
  const MaterialField labels = laidOver(*in_case, over);
  EXPECT_EQ(labels.voxel(), 0.5);
  EXPECT_EQ(labels.at({0, 0, 0}), static_cast<Material>(5));
  EXPECT_EQ(labels.at(8 * in_both), static_cast<Material>(number));
  EXPECT_EQ(labels.at(8 * in_both + Vec3i(1, 2, 3)), static_cast<Material>(255));
  EXPECT_EQ(labels.oneOf({0, 0, 0}), static_cast<Material>(5));
  EXPECT_EQ(labels.oneOf(in_both), std::nullopt);
  MaterialBricks::Numbers numbers;
  EXPECT_FALSE(labels.copyBrick(in_both, numbers));
  EXPECT_EQ(numbers, *over.find(in_both));
  EXPECT_TRUE(labels.copyBrick({0, 0, 0}, numbers));
  EXPECT_EQ(numbers.front(), 5);

  const auto refused = requireOnlyAdded(over, *in_case, Material::kGeneric);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().place, "grid material");
  for (std::uint8_t n = 3; n < 6; ++n) over.added[n] = "any";
  EXPECT_TRUE(requireOnlyAdded(over, *in_case, Material::kGeneric));
}

// Files of other programs: each of these would be cut as tissue.
TEST(MaterialBricks, WhatNoRunStoresIsRefusedWithItsPlace) {
  const TemporaryFolder folder;
  openvdb::initialize();
  const auto refusalOf = [&](const auto& make) {
    auto grid = openvdb::Int32Grid::create(0);
    grid->setName("material");
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    grid->tree().touchLeaf({0, 0, 0})->fill(3, true);
    make(*grid);
    const auto file = folder.path() / "m.vdb";
    openvdb::io::File(file.string()).write({grid});
    const auto read = readMaterialBricks(file);
    return read ? std::string() : read.error().message();
  };
  EXPECT_EQ(refusalOf([](auto&) {}), "");
  for (const std::int32_t number : {-1, 0, 256, 1 << 30}) {
    const std::string refusal = refusalOf([&](auto& grid) { grid.tree().setValue({4, 5, 6}, number); });
    EXPECT_NE(refusal.find("at voxel 4, 5, 6, which is 2.000, 2.500, 3.000 mm"), refusal.npos) << refusal;
  }
  const auto withTile = [](auto& grid) { grid.tree().addTile(1, openvdb::Coord(8, 0, 0), 3, true); };
  EXPECT_NE(refusalOf(withTile).find("a tile of material 3"), std::string::npos);
  const auto withBackground = [](auto& grid) { grid.tree().root().setBackground(3, false); };
  EXPECT_NE(refusalOf(withBackground).find("as background"), std::string::npos);
  const auto scaled = [](auto& grid) { grid.setTransform(openvdb::math::Transform::createLinearTransform(5e-4)); };
  EXPECT_NE(refusalOf(scaled).find("voxel size"), std::string::npos);

  const BrickField field(0.5, 2.f);
  ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {{"material", &field}}));
  const auto of_floats = readMaterialBricks(folder.path() / "f.vdb");
  ASSERT_FALSE(of_floats);
  EXPECT_NE(of_floats.error().message().find("of type"), std::string::npos) << of_floats.error().message();
}

// Forges some bytes of each kind and cuts the file short anywhere: a successful read gives bricks of materials.
TEST(MaterialBricks, NoByteMakesTheReaderCrash) {
  const TemporaryFolder folder;
  MaterialBricks written = someMaterials();
  written.bricks.resize(1);
  written.numbers.resize(1);
  ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {}, {}, &written));
  const std::string good = contentOf(folder.path() / "f.vdb");
  for (std::size_t size = 0; size < good.size(); size += 1 + size / 64)
    EXPECT_FALSE(readMaterialBricks(folder.write("bad.vdb", good.substr(0, size)))) << size << " bytes";
  for (std::size_t at = 0; at < good.size(); at += at < 1500 ? 7 : 401)
    for (const char wrong : {'\x00', '\x7f', '\xff'}) {
      std::string bad = good;
      bad[at] = wrong;
      const auto read = readMaterialBricks(folder.write("bad.vdb", bad));
      if (!read) continue;
      ASSERT_EQ(read->bricks.size(), read->numbers.size()) << "byte " << at;
      EXPECT_LE(read->bricks.size(), 1u) << "byte " << at;
      for (const auto& numbers : read->numbers)
        for (const std::uint8_t number : numbers) ASSERT_GE(number, 1) << "byte " << at;
    }
}

TEST(VdbIo, InspectingTellsTheGridsByName) {
  const TemporaryFolder folder;
  BrickField one(0.05, 0.2f), other(0.1, 0.3f);
  one.touch({0, 0, 0});
  one.touch({5, -7, 0});
  // The reader skips metadata of any length.
  ASSERT_TRUE(
      writeVdb(folder.path() / "f.vdb", {{"sweep", &one}, {"phi", &other}}, {{"case_id", std::string(100'000, 'x')}}));
  const auto grids = inspectVdb(folder.path() / "f.vdb");
  ASSERT_TRUE(grids) << grids.error().message();
  ASSERT_EQ(grids->size(), 2u);
  EXPECT_EQ((*grids)[0].name, "phi");
  EXPECT_EQ((*grids)[0].voxel, 0.1);
  EXPECT_EQ((*grids)[0].active_voxels, 0u);
  EXPECT_EQ((*grids)[1].name, "sweep");
  EXPECT_EQ((*grids)[1].type, "Tree_float_5_4_3");
  EXPECT_EQ((*grids)[1].voxel, 0.05);
  EXPECT_EQ((*grids)[1].active_voxels, 2u * kBrickNodes);
}

TEST(VdbIo, InspectingRefusesWhatWasCutShortAndSurvivesAnyByte) {
  const TemporaryFolder folder;
  BrickField field(0.05, 0.2f);
  field.touch({0, 0, 0});
  ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {{"phi", &field}}));
  const std::string good = contentOf(folder.path() / "f.vdb");
  for (std::size_t size = 0; size < good.size(); size += 1 + size / 16)
    EXPECT_FALSE(inspectVdb(folder.write("short.vdb", good.substr(0, size)))) << size << " bytes";
  EXPECT_FALSE(inspectVdb(folder.path() / "none.vdb"));

  for (std::size_t at = 0; at < std::min<std::size_t>(good.size(), 700); ++at)
    for (const char wrong : {'\x00', '\x7f', '\xff'}) {
      std::string bad = good;
      bad[at] = wrong;
      const auto grids = inspectVdb(folder.write("bad.vdb", bad));
      EXPECT_TRUE(!grids || grids->size() <= 1) << "byte " << at;
    }
}

}  // namespace
}  // namespace kerf::vdb_io_test
