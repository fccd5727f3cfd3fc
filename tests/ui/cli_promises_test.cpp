// What the guides promise of every command: nothing is replaced unasked, units are told, doubtful results are warned
// of.
#include <nlohmann/json.hpp>

#include "tests/ui/cli_runner.h"

namespace kerf {
namespace {

using nlohmann::json;

class CliPromises : public Cli {
 protected:
  // Runs well, and warns of these.
  void warns(const std::vector<std::string>& arguments, const std::vector<std::string>& said) {
    const Outcome o = runKerf(arguments);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    for (const std::string& text : said)
      EXPECT_NE(o.err.find(text), o.err.npos) << "not said: " << text << "\n" << o.err;
  }
};

TEST_F(CliPromises, NoMeshIsWrittenOverUnasked) {
  makeRun();
  folder_.write("theirs.stl", "another patient's");
  folder_.write("theirs-above.stl", "another patient's");
  refuses({"export", at("box.run"), "-o", at("theirs.stl")}, {"theirs.stl", "exists already", "--overwrite"});
  refuses({"export", at("box.run"), "-o", at("new.stl"), "-o", at("theirs.stl")}, {"theirs.stl"});
  refuses({"trim", at("box.run"), "--plane", "0,0,1@0,0,-2", "--keep", "above", "-o", at("theirs.stl")},
          {"theirs.stl", "--overwrite"});
  refuses({"trim", at("box.run"), "--plane", "0,0,1@0,0,-2", "-o", at("theirs.stl")}, {"theirs-above.stl"});
  refuses({"demo-molar", "-o", at("theirs.stl")}, {"theirs.stl", "--overwrite"});

  EXPECT_EQ(runKerf({"export", at("box.run"), "-o", at("theirs.stl"), "--overwrite"}).exit_code, 0);
  EXPECT_EQ(runKerf({"check", at("theirs.stl")}).exit_code, 0);
}

TEST_F(CliPromises, NoDrawingIsWrittenOverUnasked) {
  folder_.write("theirs.svg", "a drawing of theirs");
  refuses({"tool", "draw", "round-014", "-o", at("theirs.svg")}, {"theirs.svg", "exists already", "--overwrite"});
  EXPECT_EQ(runKerf({"tool", "draw", "round-014", "-o", at("theirs.svg"), "--overwrite"}).exit_code, 0);
  EXPECT_NE(contentOf(in("theirs.svg")).find("<svg"), std::string::npos);
}

TEST_F(CliPromises, PiecesGoIntoAFolderThatIsMade) {
  makeRun();
  const Outcome o = runKerf({"export", at("box.run"), "--piece", "all", "-o", at("for the printer"), "--json"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_EQ(json::parse(o.out)["files"], json::array({at("for the printer/box-piece-1.stl")})) << o.out;
  EXPECT_TRUE(std::filesystem::exists(in("for the printer/box-piece-1.stl")));
}

TEST_F(CliPromises, CheckDoubtsTheUnitAndTakesOne) {
  std::string metres = box();
  std::string small = "OFF\n8 12 0\n";
  for (int c = 0; c < 8; ++c)
    small += fmt::format("{} {} {}\n", c & 1 ? 0.03 : -0.03, c & 2 ? 0.025 : -0.025, c & 4 ? 0.04 : 0.0);
  small += metres.substr(metres.find("3 0 2 3"));
  folder_.write("metres.off", small);
  warns({"check", at("metres.off")}, {"metres.off", "CHECK THE UNIT", "in m"});
  const Outcome o = runKerf({"check", at("metres.off"), "--unit", "m", "--json"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_EQ(o.err, "");
  EXPECT_NEAR(json::parse(o.out)["volume_mm3"].get<double>(), 60 * 50 * 40, 1e-6);
}

TEST_F(CliPromises, ABurOfOneVoxelAndAPathThatBeginsInsideAreWarnedOf) {
  makeCase();
  const std::string coarse = at("coarse.case");
  ASSERT_EQ(runKerf({"bake", at("box.off"), "--unit", "mm", "-o", coarse, "--voxel", "0.5"}).exit_code, 0);
  warns({"cut", coarse, "--tool", "round-005", "--path", at("groove.csv"), "-o", at("coarse.run")},
        {"WARNING", "round-005", "1.0 voxels", "--fine-along"});
  const Outcome fine =
      runKerf({"cut", at("box.case"), "--tool", "round-014", "--path", at("groove.csv"), "-o", at("fine.run")});
  EXPECT_EQ(fine.err, "");

  folder_.write("inside.csv", groove(-2));
  warns({"cut", at("box.case"), "--tool", "round-014", "--path", at("inside.csv"), "--hand", "force", "--time-limit",
         "0.3", "-o", at("inside.run")},
        {"WARNING", "begins", "inside tissue"});
}

TEST_F(CliPromises, RecoverDiscardsNoRunThatHasEnded) {
  makeRun();
  RunOptions home;
  home.environment["XDG_DATA_HOME"] = at("data");
  const Outcome none = runKerf({"recover"}, home);
  EXPECT_EQ(none.exit_code, 0);
  EXPECT_NE(none.out.find("no session"), none.out.npos) << none.out;
  refuses({"recover", at("box.run"), "--discard"}, {"box.run", "a run that has ended"});
  refuses({"recover", "--discard"}, {"RUN"}, 2);
}

TEST_F(CliPromises, AFolderThatIsNoRunIsSaidToBeWhatItIs) {
  makeCase();
  refuses({"plot", at("none.run"), "-o", at("x.svg")}, {"none.run", "no such folder"});
  refuses({"plot", at("box.case"), "-o", at("x.svg")}, {"box.case", "a case", "kerf cut"});
  refuses({"check", at("box.case")}, {"box.case", "kerf export"});
}

TEST_F(CliPromises, ATrimTellsItsPlanes) {
  makeRun();
  const Outcome o = runKerf({"trim", at("box.run"), "--plane", "0,0,2@0,0,-2", "-o", at("half.stl")});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_NE(o.out.find("cut along 0.00000,0.00000,1.00000@"), o.out.npos) << o.out;
}

TEST_F(CliPromises, AToolMeshInAnotherUnitIsRefused) {
  folder_.write("bur.off", box());
  const auto tool = [](double scale) {
    return fmt::format(
        "format = \"kerf-tool\"\nversion = 1\nid = \"bur\"\nname = \"Bur\"\nkind = \"mesh\"\nmesh = "
        "\"bur.off\"\nmm_per_unit = {}\ntip = [3, 2.5, -4]\naxis = [0, 0, 1]\ncut_below = 2\n",
        scale);
  };
  folder_.write("bur.toml", tool(0.1));
  refuses({"tool", "info", at("bur.toml")}, {"mm_per_unit", "0.6 mm", "25.4 for inches"});
  folder_.write("bur.toml", tool(1));
  EXPECT_EQ(runKerf({"tool", "info", at("bur.toml")}).exit_code, 0);
}

}  // namespace
}  // namespace kerf
