#include "geometry/outline/outline.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "geometry/tool/tool_doubt.h"
#include "geometry/tool/tool_file.h"
#include "tests/support/temporary_folder.h"

namespace kerf::outline_test {
namespace {

// An entity or variable: code and value, line by line.
std::string groups(const std::vector<std::pair<int, std::string>>& pairs) {
  std::string out;
  for (const auto& [code, value] : pairs) out += fmt::format("{:3}\n{}\n", code, value);
  return out;
}
std::string dxf(const std::string& entities, const std::string& header = "") {
  return groups({{0, "SECTION"}, {2, "HEADER"}}) + header + groups({{0, "ENDSEC"}, {0, "SECTION"}, {2, "ENTITIES"}}) +
         entities + groups({{0, "ENDSEC"}, {0, "EOF"}});
}
std::string line(double x, double y, double to_x, double to_y) {
  const auto n = [](double value) { return fmt::format("{}", value); };
  return groups({{0, "LINE"}, {8, "0"}, {10, n(x)}, {20, n(y)}, {11, n(to_x)}, {21, n(to_y)}});
}
std::string arc(double x, double y, double r, double from, double to) {
  const auto n = [](double value) { return fmt::format("{}", value); };
  return groups({{0, "ARC"}, {8, "0"}, {10, n(x)}, {20, n(y)}, {40, n(r)}, {50, n(from)}, {51, n(to)}});
}
std::string svg(const std::string& body,
                const std::string& root = "viewBox=\"0 0 20 40\" width=\"20mm\" height=\"40mm\"") {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" " + root + ">\n" + body + "\n</svg>\n";
}

class Outline : public testing::Test {
 protected:
  Expected<std::vector<OutlinePiece>> read(const std::string& name, const std::string& text) const {
    return readOutline(folder_.write(name, text));
  }
  Expected<Tool> tool(const std::string& name, const std::string& text, double head_diameter) const {
    folder_.write(name, text);
    return readTool(folder_.write(
        "a.toml", fmt::format("format = \"kerf-tool\"\nversion = 1\nid = \"a\"\nname = \"A\"\nkind = \"bur\"\n"
                              "shape = \"profile\"\nhead_diameter = {}\nprofile_file = \"{}\"\n",
                              head_diameter, name)));
  }
  Expected<Tool> same(double head_diameter, const std::string& profile) const {
    return readTool(folder_.write(
        "a.toml", fmt::format("format = \"kerf-tool\"\nversion = 1\nid = \"a\"\nname = \"A\"\nkind = \"bur\"\n"
                              "shape = \"profile\"\nhead_diameter = {}\nprofile = {}\n",
                              head_diameter, profile)));
  }
  void refuses(const std::string& name, const std::string& text, const std::vector<std::string>& words) const {
    const auto read = this->read(name, text);
    ASSERT_FALSE(read) << text;
    for (const std::string& word : words)
      EXPECT_NE(read.error().message().find(word), std::string::npos) << word << "\n" << read.error().message();
  }
  TemporaryFolder folder_;
};

// A cylinder of 2 mm, 3 mm long, its lower edge rounded by 0.5 mm, and a groove of radius 0.25 mm: one head, as the
// drawing of each format, as it lies on the sheet, and as the numbers of a file.
const std::string kProfile = "[[0, 1], [0.5, 2, 0.5], [1, 2], [1.5, 2, -0.25], [3, 2]]";

struct Drawing {
  const char* name;
  std::string text;
};
std::vector<Drawing> drawings() {
  const std::string entities = line(0, 10, 0.5, 10) + line(1, 11, 1, 10.5) + arc(0.5, 10.5, 0.5, 270, 0) +
                               arc(1, 11.25, 0.25, 90, 270) + line(1, 11.5, 1, 13);
  const std::string corners = groups({{10, "0.5"},
                                      {20, "0"},
                                      {42, "0.41421356237309503"},
                                      {10, "1"},
                                      {20, "0.5"},
                                      {10, "1"},
                                      {20, "1"},
                                      {42, "-1"},
                                      {10, "1"},
                                      {20, "1.5"},
                                      {10, "1"},
                                      {20, "3"}});
  std::string vertices;
  for (const auto& [x, y, bulge] : std::vector<std::array<double, 3>>{
           {1, 3, 0}, {1, 1.5, 1}, {1, 1, 0}, {1, 0.5, -0.41421356237309503}, {0.5, 0, 0}})
    vertices += groups({{0, "VERTEX"},
                        {8, "0"},
                        {10, fmt::format("{}", x)},
                        {20, fmt::format("{}", y)},
                        {42, fmt::format("{}", bulge)}});
  // In inches, closed by lines to and along the axis.
  const auto inch = [](double mm) { return mm / 25.4; };
  const std::string in_inches =
      line(0, 0, inch(0.5), 0) + arc(inch(0.5), inch(0.5), inch(0.5), 270, 360) +
      line(inch(1), inch(0.5), inch(1), inch(1)) + arc(inch(1), inch(1.25), inch(0.25), 90, 270) +
      line(inch(1), inch(1.5), inch(1), inch(3)) + line(inch(1), inch(3), 0, inch(3)) + line(0, inch(3), 0, 0);
  return {{"lines.dxf", dxf(entities)},
          {"light.dxf", dxf(groups({{0, "LWPOLYLINE"}, {90, "5"}, {70, "0"}}) + corners,
                            groups({{9, "$ACADVER"}, {1, "AC1032"}, {9, "$INSUNITS"}, {70, "4"}}))},
          {"r12.dxf", dxf(groups({{0, "POLYLINE"}, {66, "1"}, {70, "0"}}) + vertices + groups({{0, "SEQEND"}}))},
          {"inches.dxf", dxf(in_inches, groups({{9, "$INSUNITS"}, {70, "1"}}))},
          {"windows.dxf",
           [&] {
             std::string text = dxf(entities);
             for (std::size_t at = 0; (at = text.find('\n', at)) != text.npos; at += 2) text.insert(at, "\r");
             return text;
           }()},
          {"plain.svg", svg("<path d=\"M0,30 H0.5 A.5.5 0 0 0 1 29.5 V29 a.25.25 0 01-0-.5 L1 27\"/>")},
          {"closed.svg", svg("<g><path d=\"M0 30h.5a.5.5 0 00.5-.5v-.5A.25.25 0 0 1 1 28.5V27H0Z\"/></g>")},
          {"scaled.svg", svg("<path d=\"M0 300 5 300A5 5 0 0 0 10 295V290A2.5 2.5 0 0 1 10 285V270\"/>",
                             "viewBox=\"0 0 200 400\" width=\"2cm\" height=\"4cm\"")}};
}

TEST_F(Outline, EveryDrawingOfAHeadIsTheHead) {
  const auto expected = same(2, kProfile);
  ASSERT_TRUE(expected) << expected.error().message();
  for (const Drawing& d : drawings()) {
    const auto drawn = tool(d.name, d.text, 2);
    ASSERT_TRUE(drawn) << d.name << ": " << drawn.error().message();
    EXPECT_NEAR(drawn->head_length_mm, 3, 1e-9) << d.name;
    for (double x = 0; x < 1.6; x += 0.07)
      for (double z = -0.5; z < 3.6; z += 0.07)
        EXPECT_NEAR(drawn->cut->distance(Vec3d(x, 0, z)), expected->cut->distance(Vec3d(x, 0, z)), 1e-9)
            << d.name << " at " << x << ", " << z;
    for (const double depth : {0.3, 1.2, 2.9})
      EXPECT_NEAR(plungeVolume(*drawn, depth) / plungeVolume(*expected, depth), 1, 1e-9) << d.name;
    EXPECT_EQ(doubtAbout(*drawn), "") << d.name;
    EXPECT_EQ(drawn->companion.filename(), d.name);
  }
}

TEST_F(Outline, ABezierCurveIsWithinAMicrometre) {
  // A quarter circle of 5 mm by the usual control points, itself within 0.03 % of the circle.
  const double k = 5 * 0.5522847498;
  const auto pieces = read("c.svg", svg(fmt::format("<path d=\"M0 30C{} 30 5 {} 5 25\"/>", k, 25 + k)));
  ASSERT_TRUE(pieces) << pieces.error().message();
  EXPECT_LT(pieces->size(), 80u);
  double longest = 0;
  for (const OutlinePiece& p : *pieces) {
    EXPECT_NEAR((p.from - Eigen::Vector2d(0, 5)).norm(), 5, 0.0015);
    const double half = 0.5 * (p.to - p.from).norm();
    longest = std::max(longest, 5 - std::sqrt(25 - half * half));
  }
  EXPECT_LT(longest, 0.001) << "distance of a chord from its arc";
}

TEST_F(Outline, WhatIsNoHalfProfileIsRefusedWithItsLine) {
  const std::string rod = line(0, 0, 1, 0) + line(1, 0, 1, 3);
  refuses("a.dxf", dxf(rod + groups({{0, "SPLINE"}, {8, "0"}})), {"line 35", "SPLINE", "polyline with arcs"});
  refuses("a.dxf", dxf(groups({{0, "INSERT"}, {2, "bur"}})), {"line 11", "INSERT", "explode the block"});
  refuses("a.dxf", dxf(rod + line(1, 3.2, 1, 4)), {"line 35", "does not join", "no gap"});
  refuses("a.dxf", dxf(rod + line(1, 1, 2, 1)), {"does not join", "no branch"});
  refuses("a.dxf", dxf(line(-1, 0, -1, 3)), {"line 11", "x = -1 mm", "mirror"});
  refuses("a.dxf", dxf(arc(3, 3, 1, 0, 360)), {"closed curve"});
  refuses("a.dxf", dxf(rod, groups({{9, "$INSUNITS"}, {70, "10"}})), {"$INSUNITS 10", "inches"});
  refuses("a.dxf", dxf(""), {"no curve"});
  refuses("a.dxf", dxf(rod + groups({{0, "ARC"}, {40, "1"}, {230, "-1"}})), {"line 35", "another plane"});
  refuses("a.dxf", dxf(groups({{0, "VIEWPORT"}, {67, "1"}}) + groups({{0, "TEXT"}})), {"line 15", "TEXT"});
  refuses("a.dxf", "AutoCAD Binary DXF\r\n\x1a", {"binary DXF", "ASCII"});
  refuses("a.dxf", dxf(groups({{0, "LINE"}, {10, "1,5"}})), {"line 13", "1,5"});
  refuses("a.dxf", "solid\n1\n", {"line 1", "group code"});
  refuses("a.dxf", dxf(groups({{0, "POLYLINE"}, {70, "8"}})), {"3D"});
  refuses("a.dxf", dxf(groups({{0, "POLYLINE"}}) + rod), {"without an end"});
  const auto at = [&](const char* z, const char* to) {
    return groups({{0, "LINE"}, {10, "0"}, {20, "0"}, {30, z}, {11, "1"}, {21, "0"}, {31, to}});
  };
  refuses("a.dxf", dxf(at("0", "5")), {"line 11", "height z"});
  refuses("a.dxf", dxf(at("3", "3") + at("9", "9")), {"line 25", "height z"});
  refuses("a.svg", svg("<path style=\"transform:scale(2)\" d=\"M0 0H1\"/>"), {"line 2", "transform"});
  refuses("a.svg", svg("<g style=\"display:none\"><path d=\"M0 0H1\"/></g>"), {"line 2", "hidden"});
  refuses("a.svg", svg("<path d=\"M0 0H1" + std::string(3000, 'Z') + "\"/>"), {"more than 1000 pieces"});
  refuses("a.svg", svg("<path d=\"M0 0l1e308 0l1e308 0c1 1 1 1 1 1\"/>"), {"farther than numbers reach"});
  refuses("a.dwg", "AC1032", {".dwg", ".dxf or .svg"});
  refuses("a.svg", svg("<path d=\"M0 0H1\"/>", "viewBox=\"0 0 20 40\" width=\"20\" height=\"40\""), {"line 1", "unit"});
  refuses("a.svg", svg("<path d=\"M0 0H1\"/>", "width=\"20mm\" height=\"40mm\""), {"no viewBox"});
  refuses("a.svg", svg("<path d=\"M0 0H1\"/>\n<path d=\"M1 0V1\"/>"), {"line 3", "second <path>"});
  refuses("a.svg", svg("<rect width=\"1\" height=\"1\"/>"), {"line 2", "<rect>"});
  refuses("a.svg", svg("<g transform=\"scale(2)\"><path d=\"M0 0H1\"/></g>"), {"line 2", "transform"});
  refuses("a.svg", svg("<path d=\"M0 0Q1 0 1 1\"/>"), {"\"Q\""});
  refuses("a.svg", svg("<path d=\"M0 0A1 2 0 0 0 1 1\"/>"), {"elliptical arc"});
  refuses("a.svg", svg("<path d=\"M0 0L1\"/>"), {"\"L\" takes"});
  refuses("a.svg", svg("<path d=\"L1 1\"/>"), {"begin with M"});
  refuses("a.svg", svg("<circle r=\"1\"/>").substr(0, 60), {"XML"});
  refuses("none.svg", "", {"XML"});
}

TEST_F(Outline, AHeadThatCannotBeTurnedIsRefused) {
  const auto refusedAs = [&](const std::string& entities, double diameter, const std::string& word) {
    const auto drawn = tool("a.dxf", dxf(entities), diameter);
    ASSERT_FALSE(drawn) << word;
    EXPECT_NE(drawn.error().message().find(word), std::string::npos) << drawn.error().message();
  };
  refusedAs(line(0, 0, 1, 1) + line(1, 1, 2, 0.5) + line(2, 0.5, 2, 3), 4, "heights that do not decrease");
  refusedAs(arc(1, 1, 0.5, 270, 180) + line(0.5, 1, 0.5, 3), 3, "profile_file");
  refusedAs(line(0, 0, 0.8, 0) + line(0.8, 0, 0.8, 3), 0.8, "diameters throughout, never radii");
  const auto both = readTool(folder_.write(
      "a.toml",
      "format = \"kerf-tool\"\nversion = 1\nid = \"a\"\nname = \"A\"\nkind = \"bur\"\nshape = \"profile\"\n"
      "head_diameter = 2\nprofile_file = \"a.dxf\"\nprofile = [[0, 1], [1, 2]]\n"));
  ASSERT_FALSE(both);
  EXPECT_NE(both.error().message().find("one of profile and profile_file"), std::string::npos)
      << both.error().message();
  const auto elsewhere = readTool(folder_.write(
      "a.toml",
      "format = \"kerf-tool\"\nversion = 1\nid = \"a\"\nname = \"A\"\nkind = \"bur\"\nshape = \"profile\"\n"
      "head_diameter = 2\nprofile_file = \"../a.dxf\"\n"));
  ASSERT_FALSE(elsewhere);
  EXPECT_NE(elsewhere.error().message().find("folder of this one"), std::string::npos) << elsewhere.error().message();
}

// Bytes of a drawing exchanged, cut off and repeated: read or refused, never more.
TEST_F(Outline, NoBytesCrashTheReaders) {
  std::mt19937 random(20261121);
  std::size_t read = 0, refused = 0;
  const std::vector<Drawing> all = drawings();
  for (int n = 0; n < 800; ++n) {
    const Drawing& d = all[random() % all.size()];
    std::string text = d.text;
    for (std::size_t changes = random() % 8; changes > 0; --changes) {
      const std::size_t at = random() % text.size();
      constexpr std::string_view kLikely = "0123456789.-eE\nAaCcZzMm<>/\"\0\xff ";
      switch (random() % 4) {
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text[at] = kLikely[random() % kLikely.size()];
          break;
        case 2:
          text.insert(at, text.substr(random() % text.size(), random() % 30));
          break;
        default:
          text.erase(at, random() % 20);
      }
      if (text.empty()) text = " ";
    }
    const auto drawn = tool(d.name, text, 2);
    drawn ? ++read : ++refused;
    if (drawn) {
      EXPECT_TRUE(std::isfinite(drawn->cut->distance(Vec3d(0.3, -0.2, 0.1))));
      EXPECT_TRUE(std::isfinite(plungeVolume(*drawn, 1)));
    } else {
      EXPECT_NE(drawn.error().message(), "");
    }
  }
  EXPECT_GT(read, 50u);
  EXPECT_GT(refused, 100u);
}

}  // namespace
}  // namespace kerf::outline_test
