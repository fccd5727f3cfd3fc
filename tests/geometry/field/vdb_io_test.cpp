#include "geometry/field/vdb_io.h"

#include <gtest/gtest.h>
#include <openvdb/openvdb.h>
#include <sys/stat.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>

#include "geometry/field/material_field.h"
#include "tests/geometry/sampled_field.h"
#include "tests/support/temporary_folder.h"

namespace kerf {
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

TEST(VdbIo, AMissingFileOrGridIsAnError) {
  const TemporaryFolder folder;
  EXPECT_FALSE(readVdb(folder.path() / "none.vdb", "phi"));
  const BrickField field(0.1, 0.3f);
  ASSERT_TRUE(writeVdb(folder.path() / "f.vdb", {{"phi", &field}}));
  const auto other = readVdb(folder.path() / "f.vdb", "sweep");
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message().find("sweep"), std::string::npos);
}

// A case from a stranger: numbers that are no distances are not cut as if they were tissue.
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

// A small grid as a file, of which single numbers are forged. OpenVDB takes them as they stand: a length of 2 GB is
// allocated before a byte of it is read.
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

  // What the reader says of these bytes; empty: it took them.
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

// Some bytes of each kind: whatever is read then is a field of numbers that can be cut.
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

TEST(VdbIo, InspectingTellsTheGridsByName) {
  const TemporaryFolder folder;
  BrickField one(0.05, 0.2f), other(0.1, 0.3f);
  one.touch({0, 0, 0});
  one.touch({5, -7, 0});
  // Metadata of any length is passed over.
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
}  // namespace kerf
