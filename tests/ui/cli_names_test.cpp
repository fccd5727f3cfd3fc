// Names of objects from the baked file to the exported files.
#include <sstream>

#include "tests/ui/cli_runner.h"

namespace kerf::cli_names_test {
namespace {

class CliNames : public Cli {
 protected:
  // Boxes of 6 x 5 x 4 mm and less, 10 mm apart.
  static std::string boxes(const std::vector<std::string>& names) {
    constexpr int kFaces[][3] = {{1, 3, 2}, {2, 3, 4}, {5, 6, 7}, {6, 8, 7}, {1, 2, 5}, {2, 6, 5},
                                 {3, 7, 4}, {4, 7, 8}, {1, 5, 3}, {3, 5, 7}, {2, 4, 6}, {4, 8, 6}};
    std::string out;
    for (std::size_t n = 0; n < names.size(); ++n) {
      const double size = 1 - 0.125 * static_cast<double>(n);  // exact in float32
      out += "o " + names[n] + "\n";
      for (int c = 0; c < 8; ++c)
        out += fmt::format("v {} {} {}\n", 10.0 * static_cast<double>(n) + size * (c & 1 ? 3 : -3),
                           size * (c & 2 ? 2.5 : -2.5), size * (c & 4 ? 0 : -4));
      const int first = 8 * static_cast<int>(n);
      for (const auto& face : kFaces)
        out += fmt::format("f {} {} {}\n", first + face[0], first + face[1], first + face[2]);
    }
    return out;
  }
  void runs(const std::vector<std::string>& words) {
    const Outcome o = runKerf(words);
    ASSERT_EQ(o.exit_code, 0) << o.err;
  }
  void bakes(const std::string& file, const std::string& folder) {
    runs({"bake", at(file), "--unit", "mm", "--voxel", "0.3", "-o", at(folder)});
  }
  // The "o ..." lines of an OBJ, in order.
  std::vector<std::string> objects(const std::string& file) {
    std::vector<std::string> out;
    std::istringstream text(contentOf(at(file)));
    for (std::string line; std::getline(text, line);)
      if (line.starts_with("o ")) out.push_back(line.substr(2));
    return out;
  }
  using Names = std::vector<std::string>;
};

TEST_F(CliNames, GoFromObjTo3mfAndBack) {
  folder_.write("row.obj", boxes({"tooth 36", "gingiva", "tooth 37"}));
  bakes("row.obj", "row.case");
  runs({"export", at("row.case"), "-o", at("row.3mf"), "-o", at("out.obj"), "-o", at("out.stl")});
  EXPECT_EQ(objects("out.obj"), (Names{"tooth 36", "gingiva", "tooth 37"}));
  bakes("row.3mf", "again.case");
  runs({"export", at("again.case"), "-o", at("again.obj")});
  EXPECT_EQ(objects("again.obj"), (Names{"tooth 36", "gingiva", "tooth 37"}));
}

TEST_F(CliNames, NamePiecesAndTheirFiles) {
  folder_.write("row.obj", boxes({"tooth 36", "gingiva", "tooth 36"}));
  bakes("row.obj", "row.case");
  runs({"export", at("row.case"), "--piece", "all", "-o", at("out.obj")});
  EXPECT_EQ(objects("out-tooth-36.obj"), Names{"tooth 36"});
  EXPECT_EQ(objects("out-gingiva.obj"), Names{"gingiva"});
  EXPECT_EQ(objects("out-tooth-36-2.obj"), Names{"tooth 36"});
  runs({"export", at("row.case"), "--piece", "gingiva", "-o", at("chosen.obj")});
  EXPECT_EQ(contentOf(at("chosen.obj")), contentOf(at("out-gingiva.obj")));
}

// Tooth numbers are names, and "all" may be a name.
TEST_F(CliNames, ThatAreNumbersOrAllChooseNoOtherPiece) {
  folder_.write("row.obj", boxes({"all", "1", "3"}));
  bakes("row.obj", "row.case");
  const auto exports = [&](const std::string& piece) {
    return runKerf({"export", at("row.case"), "--piece", piece, "-o", at("one.obj"), "--overwrite"});
  };
  const Outcome two_fit = exports("1");
  EXPECT_NE(two_fit.exit_code, 0);
  EXPECT_NE(two_fit.err.find("the number of one piece and the name of another"), two_fit.err.npos) << two_fit.err;
  for (const char* const piece : {"2", "3"}) {
    const Outcome one = exports(piece);
    ASSERT_EQ(one.exit_code, 0) << one.err;
    EXPECT_EQ(objects("one.obj"), Names{piece == std::string("2") ? "1" : "3"});
  }
  std::filesystem::remove(at("one.obj"));
  ASSERT_EQ(exports("all").exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(at("one.obj")));
  EXPECT_EQ(objects("one-all.obj"), Names{"all"});
}

TEST_F(CliNames, OutliveACutAndATrim) {
  folder_.write("row.obj", boxes({"tooth 36", "gingiva"}));
  folder_.write("groove.csv", groove());
  bakes("row.obj", "row.case");
  runs({"cut", at("row.case"), "--tool", "round-014", "--path", at("groove.csv"), "-o", at("row.run")});
  runs({"export", at("row.run"), "-o", at("cut.obj")});
  EXPECT_EQ(objects("cut.obj"), (Names{"tooth 36", "gingiva"}));

  runs({"trim", at("row.obj"), "--unit", "mm", "--plane", "1,0,0@1,0,0", "-o", at("part.obj")});
  EXPECT_EQ(objects("part-above.obj"), (Names{"tooth 36", "gingiva"}));
  EXPECT_EQ(objects("part-below.obj"), Names{"tooth 36"});
  runs({"trim", at("row.run"), "--plane", "1,0,0@9,0,0", "--keep", "above", "-o", at("right.obj")});
  EXPECT_EQ(objects("right.obj"), Names{"gingiva"});
}

TEST_F(CliNames, OfAStrangerGiveNoCommandsToATerminalAndNoPath) {
  folder_.write("row.obj", boxes({"../../up", "\x1b[31mred\\x", "\xff" + std::string(5000, 'x')}));
  bakes("row.obj", "row.case");
  const Outcome o = runKerf({"export", at("row.case"), "--piece", "all", "-o", at("out/row.obj")});
  EXPECT_NE(o.exit_code, 0) << "there is no such folder";
  std::filesystem::create_directory(in("out"));
  runs({"export", at("row.case"), "--piece", "all", "-o", at("out/row.obj")});
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(in("out"))) {
    ++files;
    EXPECT_LT(entry.path().filename().string().size(), 80u);
    const Names names = objects("out/" + entry.path().filename().string());
    ASSERT_EQ(names.size(), 1u);
    EXPECT_LE(names[0].size(), 256u);
    EXPECT_EQ(names[0].find_first_of("\x1b\xff"), std::string::npos);
  }
  EXPECT_EQ(files, 3u);
  const Outcome none = runKerf({"export", at("row.case"), "--piece", "nine", "-o", at("nine.obj")});
  EXPECT_EQ(none.err.find_first_of("\x1b\xff"), std::string::npos) << none.err;
}

}  // namespace
}  // namespace kerf::cli_names_test
