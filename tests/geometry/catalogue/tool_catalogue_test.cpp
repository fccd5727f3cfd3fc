#include "geometry/catalogue/tool_catalogue.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <ctime>
#include <map>
#include <random>

#include "geometry/catalogue/csv.h"
#include "geometry/tool/tool_file.h"
#include "tests/support/temporary_file.h"
#include "tests/support/temporary_folder.h"

namespace kerf::tool_catalogue_test {
namespace {

namespace fs = std::filesystem;
using Cells = std::vector<std::string>;

Cells rowOf(const std::string& text, std::size_t n = 0) {
  const auto table = parseCsv(text, "t.csv");
  EXPECT_TRUE(table) << table.error().message();
  return table && n < table->rows.size() ? table->rows[n].cells : Cells{};
}

TEST(Csv, CellsAreReadWhicheverProgramWroteThem) {
  EXPECT_EQ(rowOf("a,b;c\td,e"), (Cells{"a", "b;c\td", "e"}));
  EXPECT_EQ(rowOf("a;b,c;d"), (Cells{"a", "b,c", "d"}));
  EXPECT_EQ(rowOf("a\tb;c\td"), (Cells{"a", "b;c", "d"}));
  EXPECT_EQ(rowOf("\xef\xbb\xbf"
                  "a,b\r\n"),
            (Cells{"a", "b"}));
  EXPECT_EQ(rowOf("a,b\n\"1,\n2\" , \"say \"\"x\"\"\",\n", 1), (Cells{"1,\n2", "say \"x\"", ""}));
  EXPECT_EQ(rowOf("a\n5\" long\n", 1), (Cells{"5\" long"}));
  const auto numbers = parseCsv("a,b\n\n,,\n1,2\n", "t.csv");
  ASSERT_TRUE(numbers);
  ASSERT_EQ(numbers->rows.size(), 2u) << "blank rows are left out ...";
  EXPECT_EQ(numbers->rows[1].number, 4u) << "... but counted";
}

TEST(Csv, BadTablesAreRefusedWithTheRow) {
  for (const auto& [text, word] : std::map<std::string, std::string>{
           {"a\n\"b", "not closed"}, {"a\nb\xe9\n", "0xe9"}, {std::string("a\n\0", 3), "0x00"}}) {
    const auto table = parseCsv(text, "t.csv");
    ASSERT_FALSE(table) << text;
    EXPECT_NE(table.error().message().find(word), std::string::npos) << table.error().message();
    EXPECT_EQ(table.error().place, "row 2");
  }
}

class Catalogue : public testing::Test {
 protected:
  CatalogueImport import(const std::string& csv, bool overwrite = false) const {
    const auto out = importCatalogue(folder_.write("c.csv", csv), tools(), overwrite);
    EXPECT_TRUE(out) << out.error().message();
    return out.value_or(CatalogueImport{});
  }
  Error refused(const std::string& csv) const {
    const auto out = importCatalogue(folder_.write("c.csv", csv), tools(), false);
    EXPECT_FALSE(out);
    return out ? Error{} : out.error();
  }
  fs::path tools() const { return folder_.path() / "tools"; }
  Tool tool(const std::string& id) const {
    auto out = readTool(tools() / (id + ".toml"));
    EXPECT_TRUE(out) << out.error().message();
    return out.value_or(Tool{});
  }
  TemporaryFolder folder_;
};

TEST_F(Catalogue, ARowIsABur) {
  const CatalogueImport done = import(
      "Name;Shape;Head diameter (mm);head_length;tip_diameter;Cuts;End length;Shank diameter;Shank "
      "length;speed_rpm;Grit\n"
      "\"Taper \"\"fine\"\"\";taper_round;1,6;8,00;1,0;;;1,6;11;300000;fine\n"
      "End 012;cylinder;1,2;4;;end;0,4;;;;\n");
  ASSERT_EQ(done.refused.size(), 0u) << done.refused[0].found << done.refused[0].expected;
  ASSERT_EQ(done.written.size(), 2u);
  EXPECT_EQ(done.written[0].id, "taper-fine");
  EXPECT_EQ(done.written[0].row, 2u);
  EXPECT_EQ(done.remarks, (Cells{"Grit"}));
  const Tool taper = tool("taper-fine");
  EXPECT_EQ(taper.name, "Taper \"fine\"");
  EXPECT_EQ(taper.shape, "taper_round");
  EXPECT_EQ(taper.head_diameter_mm, 1.6);
  EXPECT_EQ(taper.head_length_mm, 8);
  EXPECT_EQ(taper.shank_diameter_mm, 1.6);
  EXPECT_NEAR(*taper.drive.frequency_hz, 5000, 1e-9);
  EXPECT_NE(contentOf(done.written[0].file).find("# Grit: fine\n"), std::string::npos);
  EXPECT_FALSE(tool("end-012").cuts_side);
}

TEST_F(Catalogue, AnIso6360NumberAloneIsARoundBurWithItsShank) {
  const CatalogueImport done = import("ISO 6360\n500 314 001001 014\n806314198524016\n");
  ASSERT_EQ(done.written.size(), 1u);
  const Tool ball = tool("round-014");
  EXPECT_EQ(ball.shape, "round");
  EXPECT_EQ(ball.head_diameter_mm, 1.4);
  EXPECT_EQ(ball.shank_diameter_mm, 1.6);
  EXPECT_NEAR(ball.body->bounds().max[2], 19, 1e-9);
  ASSERT_EQ(done.refused.size(), 1u) << "a taper's length is not in the code";
  EXPECT_EQ(done.refused[0].row, 3u);
  EXPECT_EQ(done.refused[0].column, "head_length");
  EXPECT_EQ(done.refused[0].found, "missing");
  EXPECT_EQ(import("iso,length,tip_diameter\n806314198524016,8,1\n").written.size(), 1u) << "its shape is";
}

TEST_F(Catalogue, WhatIsWrongIsRefusedAndLeavesNoFile) {
  const CatalogueImport done = import(
      "id,name,shape,head_diameter,neck_diameter,neck_length,iso6360\n"
      "good,Good,round,1.4,,,\n"
      "unit,Unit,round,1.4 mm,,,\n"
      "word,Word,ball,1.4,,,\n"
      "code,Code,round,1.6,,,500314001001014\n"
      "excel,Excel,round,,,,5.00314E+14\n"
      "good,Twice,round,1.6,,,\n"
      "alone,Alone,round,1.6,0.8,,\n"
      "Big Id,Id,round,1.6,,,\n"
      ",,round,1.6,,,\n"
      "more,More,round,1.6,,,,7\n"
      "../up,Up,round,1.6,,,\n");
  struct Case {
    std::size_t row;
    const char *name, *column, *found, *expected;
  };
  const Case cases[] = {{3, "Unit", "head_diameter", "1.4 mm", "a number"},
                        {4, "Word", "shape", "ball", "one of round"},
                        {5, "Code", "iso6360", "014 = 1.4 mm", "1.6 mm"},
                        {6, "Excel", "iso6360", "5.00314E+14", "15 digits"},
                        {7, "Twice", "id", "good", "row 2"},
                        {8, "Alone", "neck_diameter", "stands alone", "both"},
                        {9, "Id", "id", "Big Id", "lower-case"},
                        {10, "", "id", "missing", "a name"},
                        {11, "More", "", "8 cells", "7"},
                        {12, "Up", "id", "../up", "lower-case"}};
  ASSERT_EQ(done.refused.size(), std::size(cases));
  for (std::size_t n = 0; n < std::size(cases); ++n) {
    const CatalogueImport::Refused& r = done.refused[n];
    EXPECT_EQ(r.row, cases[n].row);
    EXPECT_EQ(r.name, cases[n].name) << r.row;
    EXPECT_EQ(r.column, cases[n].column) << r.row;
    EXPECT_NE(r.found.find(cases[n].found), std::string::npos) << r.row << ": " << r.found;
    EXPECT_NE(r.expected.find(cases[n].expected), std::string::npos) << r.row << ": " << r.expected;
  }
  ASSERT_EQ(done.written.size(), 1u);
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : fs::recursive_directory_iterator(folder_.path())) ++files;
  EXPECT_EQ(files, 3u) << "the table, the folder, one tool";
}

TEST_F(Catalogue, NothingIsReplacedUnasked) {
  ASSERT_EQ(import("id,shape,head_diameter\na,round,1.4\n").written.size(), 1u);
  const CatalogueImport again = import("id,shape,head_diameter\na,round,1.6\nb,round,1.6\n");
  ASSERT_EQ(again.refused.size(), 1u);
  EXPECT_NE(again.refused[0].found.find("exists already"), std::string::npos);
  EXPECT_EQ(again.written.size(), 1u);
  EXPECT_EQ(tool("a").head_diameter_mm, 1.4);
  EXPECT_EQ(import("id,shape,head_diameter\na,round,1.6\n", true).written.size(), 1u);
  EXPECT_EQ(tool("a").head_diameter_mm, 1.6);
}

TEST_F(Catalogue, DecimalCommasAndPointsDoNotMix) {
  const CatalogueImport mixed = import("id;shape;head_diameter;speed_rpm\na;round;1,4;380.000\nb;round;1,4;380000\n");
  ASSERT_EQ(mixed.refused.size(), 1u);
  EXPECT_EQ(mixed.refused[0].column, "speed_rpm");
  EXPECT_EQ(import("id;shape;head_diameter\nc;round;1.4\n").written.size(), 1u) << "points throughout";
  EXPECT_EQ(import("id\tshape\thead_diameter\nd\tround\t1,40\n").written.size(), 1u);
  EXPECT_EQ(tool("d").head_diameter_mm, 1.4);
}

TEST_F(Catalogue, AColumnInAnotherUnitIsRefusedByItsTitle) {
  for (const char* title : {"Diameter (1/10 mm)", "Head diameter (inch)", "diameter [cm]", "Diameter, tenths"})
    EXPECT_NE(refused(fmt::format("id,shape,\"{}\"\na,round,7\n", title)).message().find(title), std::string::npos)
        << title;
  EXPECT_NE(refused("id,shape,diameter,speed_rpm (krpm)\na,round,7,300\n").message().find("krpm"), std::string::npos);
  EXPECT_EQ(import("id,shape,\"Diameter, mm\",Speed RPM [1/min]\na,round,1.4,300000\n").written.size(), 1u);
}

TEST_F(Catalogue, MarksForThousandsAreNoDecimalMarks) {
  const char* const cells[] = {"380.000", "300,000", "1.300.000"};
  for (const char* cell : cells)
    for (const char separator : {';', '\t'}) {
      const auto done =
          import(fmt::format("id{0}shape{0}diameter{0}speed_rpm\na{0}round{0}1{0}{1}\n", separator, cell));
      ASSERT_EQ(done.refused.size(), 1u) << cell;
      EXPECT_EQ(done.refused[0].column, "speed_rpm");
    }
}

TEST_F(Catalogue, ARefusedRowKeepsNoIdAndInsideIsNoSide) {
  const auto done =
      import("id,shape,diameter,cuts\na,ball,1.4,\na,round,1.4,\nb,round,1.4,inside\nc,round,1.4,side end\n");
  EXPECT_EQ(done.written.size(), 2u);
  ASSERT_EQ(done.refused.size(), 2u);
  EXPECT_EQ(done.refused[1].column, "cuts");
}

TEST_F(Catalogue, ATableWithoutAHeaderIsRefused) {
  EXPECT_NE(refused("a,round,1.4\nb,round,1.6\n").message().find("row 1: no column shape or iso6360"),
            std::string::npos);
  EXPECT_NE(refused("").message().find("empty table"), std::string::npos);
  EXPECT_NE(refused("shape,iso6360\n").message().find("no row below"), std::string::npos);
  EXPECT_NE(refused("shape,Length,head_length\n").message().find("two columns for head_length"), std::string::npos);
}

TEST_F(Catalogue, DoubtsOfATool) {
  const CatalogueImport done = import("name,shape,head_diameter\nBall 016,round,0.8\n");
  ASSERT_EQ(done.written.size(), 1u);
  EXPECT_NE(done.written[0].doubt.find("twice as much"), std::string::npos) << done.written[0].doubt;
}

// The goal: 100 rows in 10 s of the processor.
TEST_F(Catalogue, AHundredRowsAreImportedFast) {
  std::string csv = "id,name,shape,head_diameter,head_length,tip_diameter,shank_diameter,shank_length\n";
  for (int n = 0; n < 100; ++n)
    csv += fmt::format("taper-{:03},Taper {},taper_round,{:.2f},8,{:.2f},1.6,11\n", n + 300, n, 1.2 + 0.01 * n,
                       0.8 + 0.01 * n);
  csv += "bad-1,Bad,taper_round,1.2,8,1.4,,\nbad-2,Bad,taper_round,1.2,,1,,\nbad-3,Bad,tapre,1.2,8,1,,\n";
  const std::clock_t start = std::clock();
  const CatalogueImport done = import(csv);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  RecordProperty("processor_ms", static_cast<int>(1000 * seconds));
  EXPECT_EQ(done.written.size(), 100u);
  EXPECT_EQ(done.refused.size(), 3u);
  EXPECT_LT(seconds, 10);
  const auto tools = listTools({this->tools()});
  EXPECT_EQ(tools.size(), 100u);
  for (const ToolListing& t : tools) EXPECT_TRUE(t.tool) << t.error->message();
  for (const CatalogueImport::Written& w : done.written) EXPECT_EQ(w.doubt, "") << w.id;
}

TEST_F(Catalogue, NoBytesCrashIt) {
  const std::string csv =
      "id;name;shape;head_diameter;profile;cuts\na;A;round;1,4;;side\n\"b\";\"B\";profile;2;"
      "[[0, 1], [3, 2]];\"side end\"\n";
  std::mt19937 random(20261121);
  std::size_t written = 0, refused = 0;
  for (int n = 0; n < 200; ++n) {
    std::string text = csv;
    for (std::size_t changes = random() % 6; changes > 0; --changes) {
      const std::size_t at = random() % text.size();
      constexpr std::string_view kLikely = "\";,\n\r.[]0123456789-e\t\\#=";
      if (random() % 2)
        text[at] = random() % 2 ? kLikely[random() % kLikely.size()] : static_cast<char>(random());
      else
        text.insert(at, text.substr(random() % text.size(), random() % 20));
    }
    const auto done = importCatalogue(folder_.write("c.csv", text), tools(), true);
    written += done && !done->written.empty();
    refused += !done || !done->refused.empty();
  }
  EXPECT_GT(written, 20u);
  EXPECT_GT(refused, 20u);
  for (const auto& entry : fs::directory_iterator(folder_.path()))
    EXPECT_TRUE(entry.path().filename() == "c.csv" || entry.path() == tools()) << entry.path();
}

}  // namespace
}  // namespace kerf::tool_catalogue_test
