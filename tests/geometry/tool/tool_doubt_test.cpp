#include "geometry/tool/tool_doubt.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "geometry/formats/mesh_writer.h"
#include "geometry/tool/tool_file.h"
#include "tests/geometry/turned_rod.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace kerf::tool_doubt_test {
namespace {

std::string tool(const std::string& id, const std::string& kind, const std::string& keys) {
  return fmt::format("format = \"kerf-tool\"\nversion = 1\nid = \"{}\"\nname = \"A\"\nkind = \"{}\"\n{}", id, kind,
                     keys);
}

std::string doubtOf(const std::string& keys, const std::string& id = "a", const std::string& kind = "bur") {
  const TemporaryFolder folder;
  const auto read = readTool(folder.write(id + ".toml", tool(id, kind, keys)));
  EXPECT_TRUE(read) << read.error().message();
  return read ? doubtAbout(*read) : "not read";
}

TEST(ToolDoubt, NoToolThatComesWithKerfIsDoubted) {
  for (const ToolListing& t : listTools({std::filesystem::path(kSourceFolder) / "assets/tools"})) {
    ASSERT_TRUE(t.tool) << t.error->message();
    EXPECT_EQ(doubtAbout(*t.tool), "") << t.tool->id;
  }
}

TEST(ToolDoubt, AShankThinnerThanItsNeckOrOfNoHandpiece) {
  const auto with = [](double head, double neck, double shank) {
    return doubtOf(
        fmt::format("shape = \"round\"\nhead_diameter = {}\nneck_diameter = {}\nneck_length = 3\n"
                    "shank_diameter = {}\nshank_length = 12\n",
                    head, neck, shank));
  };
  EXPECT_EQ(with(2.3, 2, 1.6), "the shank, 1.6 mm, is thinner than the neck, 2 mm");
  EXPECT_NE(with(2.3, 1, 2).find("a shank of 2 mm fits no handpiece"), std::string::npos);
  for (const double shank : {1.6, 1.59, 1.65, 2.35, 2.334, 2.4, 3.0, 3.02}) EXPECT_EQ(with(2.3, 1, shank), "") << shank;
  for (const double shank : {0.8, 1.5, 1.7, 2.2, 2.5, 3.175}) EXPECT_NE(with(2.3, 0.7, shank), "") << shank;
  EXPECT_EQ(doubtOf("shape = \"round\"\nhead_diameter = 1.4\n"), "") << "a shank that is not given";
  EXPECT_NE(doubtOf("motion = \"spin\"\nthickness = 0.4\ndiameter = 22\nshank_diameter = 1.175\nshank_length = 40\n",
                    "disc", "blade")
                .find("fits no handpiece"),
            std::string::npos);
}

TEST(ToolDoubt, RadiiWhereAFileHasDiameters) {
  const std::string radii = "shape = \"profile\"\nhead_diameter = 0.8\nprofile = [[0, 0.4], [4, 0.8]]\n";
  EXPECT_EQ(doubtOf(radii, "my-bur-016"),
            "the head is 0.8 mm wide, but by its id 1.6 mm, twice as much: write diameters, not radii");
  EXPECT_NE(doubtOf("shape = \"round\"\nhead_diameter = 2.8\n", "round-014").find("half as much"), std::string::npos);
  for (const char* id : {"bur", "bur-008", "us-160", "0016", "bur-012"}) EXPECT_EQ(doubtOf(radii, id), "") << id;
  EXPECT_EQ(doubtOf(radii, "bur-016a").substr(0, 8), "the head");
}

TEST(ToolDoubt, AnArcGivenByItsDiameter) {
  const auto with = [](double arc) {
    return doubtOf(
        fmt::format("shape = \"profile\"\nhead_diameter = 2\nprofile = [[0, 1], [0.5, 2, {}], [3, 2]]\n", arc));
  };
  EXPECT_EQ(with(1), "the arc of 1 mm rounds an edge of 0.5 mm: write the radius of an arc, not its diameter");
  EXPECT_EQ(with(0.5), "");
  EXPECT_EQ(with(0.8), "");
}

TEST(ToolDoubt, AProfileOfRadiiBesideAHeadDiameterIsRefused) {
  const TemporaryFolder folder;
  const auto read = readTool(folder.write(
      "a.toml", tool("a", "bur", "shape = \"profile\"\nhead_diameter = 1.6\nprofile = [[0, 0.4], [4, 0.8]]\n")));
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message().find("twice the profile's second numbers"), std::string::npos)
      << read.error().message();
}

TEST(ToolDoubt, SeveralDoubtsAreAllSaid) {
  const std::string doubt =
      doubtOf("shape = \"round\"\nhead_diameter = 16\nshank_diameter = 2\nshank_length = 12\n", "ball");
  EXPECT_NE(doubt.find("a head 16 mm wide is unusual"), std::string::npos) << doubt;
  EXPECT_NE(doubt.find("; a shank of 2 mm"), std::string::npos) << doubt;
}

// A taper of 19 mm in mm, its tip 0.8 and its shank 1.6 mm wide.
const std::vector<std::array<double, 2>> kTaper = {{0, 0.4}, {8, 0.6}, {8.5, 0.8}, {19, 0.8}};

class MeshToolDoubt : public testing::Test {
 protected:
  Expected<Tool> read(const Mesh& mesh, const std::string& lines, double mm_per_unit = 1) const {
    EXPECT_TRUE(writeMesh(folder_.path() / "a.ply", mesh));
    return readTool(folder_.write(
        "a.toml",
        tool("a", "mesh", fmt::format("mesh = \"a.ply\"\nmm_per_unit = {}\n{}\ncut_below = 4\n", mm_per_unit, lines))));
  }
  TemporaryFolder folder_;
};

Mesh scaled(Mesh mesh, double factor) {
  for (Vec3d& p : mesh.vertices) p *= factor;
  return mesh;
}

TEST_F(MeshToolDoubt, AnotherUnitIsRefusedWithTheFactorThatMakesABur) {
  const Mesh taper = turned(kTaper, Vec3d::Zero(), Vec3d::UnitZ());
  struct Case {
    double in_file, mm_per_unit;
    const char* hint;
  };
  for (const Case& c : {Case{1e-3, 1, "Try: mm_per_unit = 1000 (metres) makes it 19 mm long"},
                        Case{1 / 25.4, 1, "mm_per_unit = 25.4 (inches) makes it 19 mm long"},
                        Case{1e-3, 25.4, "mm_per_unit = 1000 (metres)"}, Case{1, 1000, "mm_per_unit = 1 (mm)"}}) {
    const auto tool = read(scaled(taper, c.in_file), "tip = [0, 0, 0]\naxis = [0, 0, 1]", c.mm_per_unit);
    ASSERT_FALSE(tool) << c.hint;
    EXPECT_NE(tool.error().place.find("mm_per_unit"), std::string::npos) << tool.error().message();
    EXPECT_NE(tool.error().message().find(c.hint), std::string::npos) << tool.error().message();
  }
  const auto right = read(scaled(taper, 1e-3), "tip = [0, 0, 0]\naxis = [0, 0, 1]", 1000);
  ASSERT_TRUE(right) << right.error().message();
  EXPECT_EQ(doubtAbout(*right), "");
}

TEST_F(MeshToolDoubt, AnotherUnitThatMakesAToolIsDoubted) {
  const std::string place = "tip = [0, 0, 0]\naxis = [0, 0, 1]";
  const Mesh taper = turned(kTaper, Vec3d::Zero(), Vec3d::UnitZ());
  const auto inches = read(scaled(taper, 44.5 / 19 / 25.4), place);
  ASSERT_TRUE(inches) << inches.error().message();
  EXPECT_EQ(
      doubtAbout(*inches),
      "the mesh is 1.75 mm long: mm_per_unit = 10 (cm) makes it 17.5 mm long, mm_per_unit = 25.4 (inches) makes it "
      "44.5 mm long");
  const auto not_inches = read(taper, place, 25.4);
  ASSERT_TRUE(not_inches) << not_inches.error().message();
  EXPECT_EQ(doubtAbout(*not_inches), "the mesh is 483 mm long: mm_per_unit = 1 (mm) makes it 19 mm long");
}

// The lines that the refusal offers, one below the other. `second`: those for the other end.
std::string linesOf(const Error& error, bool second = false) {
  const std::size_t tip = second ? error.hint.rfind("tip = [") : error.hint.find("tip = ["),
                    axis = error.hint.find("axis = [", tip);
  EXPECT_TRUE(tip != std::string::npos && axis != std::string::npos) << error.message();
  if (axis == std::string::npos) return "";
  const auto line = [&](std::size_t at) { return error.hint.substr(at, error.hint.find(']', at) + 1 - at); };
  return line(tip) + "\n" + line(axis);
}

TEST_F(MeshToolDoubt, TheAdviceForAWrongTipCutsWithTheTip) {
  const Vec3d tip(3, -2, 5), slanted = Vec3d(1, 2, 2) / 3;
  for (const Vec3d& axis : {Vec3d(Vec3d::UnitZ()), Vec3d(-Vec3d::UnitX()), slanted}) {
    const Mesh taper = turned(kTaper, tip, axis);
    const auto numbers = [](const Vec3d& v) { return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]); };
    const Vec3d across = axis.unitOrthogonal();
    // Turned round; across; slightly off; only the tip is wrong.
    for (const Vec3d& wrong : {Vec3d(-axis), across, Vec3d(axis + 0.2 * across), axis}) {
      const auto refused = read(taper, "tip = " + numbers(tip - 0.5 * wrong) + "\naxis = " + numbers(wrong));
      ASSERT_FALSE(refused);
      EXPECT_NE(refused.error().place.find("key tip"), std::string::npos) << refused.error().message();
      const auto right = read(taper, linesOf(refused.error()));
      ASSERT_TRUE(right) << right.error().message();
      EXPECT_EQ(doubtAbout(*right), "") << linesOf(refused.error());
      EXPECT_LT(right->cut->bounds().size().head<2>().maxCoeff(), 1.2) << "it cuts with its tip, not with its shank";
    }
  }
}

// The ball of a bur may be as wide as its shank: then the axis of the file decides, and both ends are offered.
TEST_F(MeshToolDoubt, OfTwoEndsAlmostAsThickBothAreOffered) {
  const Mesh bur = turned({{0, 0.3}, {1, 0.9}, {2, 0.3}, {19, 0.8}}, Vec3d::Zero(), Vec3d::UnitZ());
  const auto refused = read(bur, "tip = [0, 0, 0.5]\naxis = [0, 0, 1]");
  ASSERT_FALSE(refused);
  EXPECT_NE(linesOf(refused.error()).find("axis = [0.0, 0.0, 1.0]"), std::string::npos) << refused.error().message();
  EXPECT_NE(linesOf(refused.error(), true).find("axis = [0.0, 0.0, -1.0]"), std::string::npos)
      << refused.error().message();
  for (const bool second : {false, true}) {
    const auto right = read(bur, linesOf(refused.error(), second));
    ASSERT_TRUE(right) << right.error().message();
    EXPECT_EQ(doubtAbout(*right), "");
  }
}

// A plate 4 x 0.5 mm: turned, a rod of 4 mm. A bur in the head of a contra-angle is right as it is.
TEST(ToolDoubt, AMeshThatDoesNotTurn) {
  const TemporaryFolder folder;
  const auto doubtOfMesh = [&](const Mesh& mesh, double cut_below) {
    EXPECT_TRUE(writeMesh(folder.path() / "a.ply", mesh));
    const auto read =
        readTool(folder.write("a.toml", tool("a", "mesh",
                                             fmt::format("mesh = \"a.ply\"\nmm_per_unit = 1\ntip = [0, 0, 0]\n"
                                                         "axis = [0, 0, 1]\ncut_below = {}\n",
                                                         cut_below))));
    EXPECT_TRUE(read) << read.error().message();
    return read ? doubtAbout(*read) : "not read";
  };
  const Mesh rod = tubeMesh(2, 0, 0, 12, 32);
  Mesh plate = rod;
  for (Vec3d& p : plate.vertices) p[1] *= 0.125;
  EXPECT_NE(doubtOfMesh(plate, 5).find("fills 8.1 times its mesh"), std::string::npos) << doubtOfMesh(plate, 5);
  EXPECT_EQ(doubtOfMesh(rod, 5), "");

  Mesh handpiece = tubeMesh(0.5, 0, 0, 8, 32);
  append(handpiece, turned({{0, 5}, {60, 6}}, {-5, 0, 14}, Vec3d::UnitX()));
  EXPECT_EQ(doubtOfMesh(handpiece, 5), "");
}

}  // namespace
}  // namespace kerf::tool_doubt_test
