// Promises of the guides for every command: nothing is replaced unasked, units are printed, doubtful results cause
// warnings.
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/places.h"
#include "tests/ui/cli_runner.h"

namespace kerf::cli_promises_test {
namespace {

using nlohmann::json;

class CliPromises : public Cli {
 protected:
  // Succeeds with these warnings.
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

  // Not even when asked: a scan, or a file of a case or run.
  const std::string scan = contentOf(at("box.off")), kept = contentOf(at("box.case/solid.ply"));
  folder_.write("scan.ply", scan);  // a copy of the scan under a name that the command writes
  for (const std::string& mine : {at("scan.ply"), at("box.case/solid.ply")}) {
    refuses({"compare", at("box.case"), at("box.run"), "-o", mine, "--overwrite"}, {"never overwrites a scan"});
    refuses({"export", at("box.run"), "-o", mine, "--overwrite"}, {"never overwrites a scan"});
  }
  EXPECT_EQ(contentOf(at("scan.ply")), scan);
  EXPECT_EQ(contentOf(at("box.case/solid.ply")), kept);

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
  const Outcome in_mm = runKerf({"check", at("metres.off")});
  EXPECT_EQ(in_mm.exit_code, 1) << in_mm.err;
  EXPECT_NE(in_mm.err.find("metres.off: CHECK THE UNIT: checked in mm, but it seems to be in m"), in_mm.err.npos)
      << in_mm.err;
  EXPECT_NE(in_mm.out.find("0.06 mm long, less than any printer makes"), in_mm.out.npos) << in_mm.out;
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

TEST_F(CliPromises, ACutThatEndsBeforeItsPathSaysHowFarShort) {
  makeCase();
  folder_.write("short.toml",
                "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\n[start]\nposition = [-2, 0.3, 0.5]\n"
                "axis = [0, 0, 1]\n[[stroke]]\nkind = \"plunge\"\ndepth = 0.8\n[[stroke]]\nkind = \"line\"\n"
                "by = [1.5, 0, 0]\n");
  for (const std::string hand : {"feed", "force", "device"}) {
    std::vector<std::string> words{"cut", at("box.case"), "--tool", "round-014", "--path", at("short.toml"), "--hand"};
    words.insert(words.end(), {hand, "--time-limit", "0.6", "-o", at(hand + ".run")});
    const Outcome told = runKerf(words);
    EXPECT_EQ(told.exit_code, 0) << told.err;
    EXPECT_NE(told.out.find("mm short of the path's end"), told.out.npos) << told.out;
    words.back() = at(hand + "2.run");
    words.emplace_back("--json");
    const json part = json::parse(runKerf(words).out);
    EXPECT_GT(part["short_of_end_mm"].get<double>(), 1) << part;
    EXPECT_LT(part["short_of_end_mm"].get<double>(), 2.3) << part;
  }
  const Outcome done = runKerf({"cut", at("box.case"), "--tool", "round-014", "--path", at("short.toml"), "--hand",
                                "force", "--push", "2", "-o", at("done.run")});
  EXPECT_NE(done.out.find("ended: end of the path\n"), done.out.npos) << done.out << done.err;
}

// A ball of 0.7 mm, 0.05 mm deep.
TEST_F(CliPromises, ACutOfFewVoxelsIsWarnedOf) {
  makeCase();
  folder_.write("shallow.toml",
                "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 1.0\n[start]\nposition = [-0.5, 0.3, "
                "1]\naxis = [0, 0, 1]\n[[stroke]]\nkind = \"line\"\nby = [0, 0, -1.05]\n[[stroke]]\nkind = "
                "\"line\"\nby = [1, 0, 0]\n");
  for (const std::vector<std::string>& hand : {std::vector<std::string>{}, {"--hand", "feed"}}) {
    std::vector<std::string> words{"cut", at("box.case"),  "--tool",     "round-014", "--path", at("shallow.toml"),
                                   "-o",  at("small.run"), "--overwrite"};
    words.insert(words.end(), hand.begin(), hand.end());
    warns(words, {"WARNING", "voxels of", "volume is known to", "Smaller voxels"});
    EXPECT_NE(runKerf({"info", at("small.run")}).out.find("volume is known to"), std::string::npos);
    warns({"export", at("small.run"), "-o", at("small.stl"), "--overwrite"}, {"WARNING", "volume is known to"});
  }
  std::ifstream file(in("small.run/summary.json"));
  const double voxel = json::parse(runKerf({"info", at("small.run"), "--json"}).out)["voxel_mm"];
  EXPECT_DOUBLE_EQ(json::parse(file)["removed_uncertainty_mm3"].get<double>(), 0.5 * std::pow(voxel, 3));
}

// The second stroke stays above the box; the third goes through its floor, 4 mm below.
TEST_F(CliPromises, AStrokeForNothingAndATipThatComesOutBehindAreTold) {
  makeCase();
  const std::string head =
      "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 4.0\n[start]\nposition = [-2, 0.3, 1]\n"
      "axis = [0, 0, 1]\n";
  const auto stroke = [](const std::string& kind, const std::string& by) {
    return "[[stroke]]\nkind = \"" + kind + "\"\nby = " + by + "\n";
  };
  const std::string groove = stroke("line", "[0, 0, -1.5]") + stroke("line", "[2, 0, 0]") + stroke("move", "[0, 0, 2]");
  const std::string in_air = stroke("line", "[0.5, 0, 0]") + stroke("move", "[0.5, 0, -0.5]");
  folder_.write("three.toml", head + groove + in_air + stroke("line", "[0, 0, -6]"));
  folder_.write("one.toml", head + groove);

  for (const std::vector<std::string>& hand : {std::vector<std::string>{}, {"--hand", "feed", "--drive", "electric"}}) {
    const auto cut = [&](const std::string& path, const std::string& run, bool is_json) {
      std::vector<std::string> words{"cut", at("box.case"), "--tool", "round-014", "--path", at(path), "-o", at(run)};
      words.insert(words.end(), hand.begin(), hand.end());
      if (is_json) words.emplace_back("--json");
      return runKerf(words);
    };
    const std::string name = hand.empty() ? "plain" : "hand";
    const Outcome told = cut("three.toml", name + ".run", true);
    ASSERT_EQ(told.exit_code, 0) << told.err;
    EXPECT_NE(told.err.find("stroke 2 of 3 removed nothing"), told.err.npos) << told.err;
    EXPECT_NE(told.err.find("the tip leaves the object on the far side, at (1.00, 0.30, -4."), told.err.npos)
        << told.err;
    const json j = json::parse(told.out);
    EXPECT_EQ(j["strokes"], 3);
    EXPECT_EQ(j["idle_strokes"], json::array({2}));
    EXPECT_NEAR(j["comes_out_at_mm"][2].get<double>(), -4, 0.15);

    const Outcome quiet = cut("one.toml", name + "-one.run", true);
    EXPECT_EQ(quiet.exit_code, 0) << quiet.err;
    EXPECT_EQ(quiet.err, "");
    EXPECT_EQ(json::parse(quiet.out)["idle_strokes"], json::array());
    EXPECT_TRUE(json::parse(quiet.out)["comes_out_at_mm"].is_null());
  }
}

// The second stroke is inside the box, in existing material.
TEST_F(CliPromises, StrokesThatAddMaterialAreCountedAndThoseForNothingAreTold) {
  makeCase();
  folder_.write(
      "two.toml",
      "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 4.0\n[start]\nposition = [-2, 0.3, 1]\n"
      "axis = [0, 0, 1]\n"
      "[[stroke]]\nkind = \"line\"\nby = [0, 0, -1.2]\n[[stroke]]\nkind = \"line\"\nby = [2, 0, 0]\n"
      "[[stroke]]\nkind = \"move\"\nby = [0, 0, -2.2]\n[[stroke]]\nkind = \"line\"\nby = [0.5, 0, 0]\n");
  const Outcome o = runKerf({"cut", at("box.case"), "--tool", "round-014", "--path", at("two.toml"), "--hand", "feed",
                             "--add", "composite", "-o", at("filled.run"), "--json"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_NE(o.err.find("stroke 2 of 2 added nothing"), o.err.npos) << o.err;
  const json j = json::parse(o.out), summary = json::parse(contentOf(in("filled.run") / "summary.json"));
  EXPECT_EQ(j["strokes"], 2);
  EXPECT_EQ(j["idle_strokes"], json::array({2}));
  EXPECT_EQ(summary["strokes"], 2);
  EXPECT_EQ(summary["idle_strokes"], json::array({2}));
  EXPECT_TRUE(summary["comes_out_at_mm"].is_null());
}

// Voxels of 0.5 mm do not register a scratch of 0.04 mm; those of 0.05 mm around it do. The last stroke stays above the
// box.
TEST_F(CliPromises, AStrokeWithinAFineRegionIsJudgedByItsVoxels) {
  makeCase();
  const auto path = [](double depth) {
    return fmt::format(
        "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 4.0\n[start]\nposition = [-0.6, 0.3, 0.5]\n"
        "axis = [0, 0, 1]\n"
        "[[stroke]]\nkind = \"move\"\nby = [0, 0, {}]\n[[stroke]]\nkind = \"line\"\nby = [1, 0, 0]\n"
        "[[stroke]]\nkind = \"move\"\nby = [0, 0, 0.5]\n[[stroke]]\nkind = \"line\"\nby = [-1, 0, 0]\n",
        -0.5 - depth);
  };
  folder_.write("scratch.toml", path(0.04));
  for (const bool is_fine : {false, true}) {
    const std::string name = is_fine ? "fine" : "coarse";
    std::vector<std::string> words{"bake", at("box.off"), "--unit", "mm", "-o", at(name + ".case"), "--voxel", "0.5"};
    if (is_fine)
      words.insert(words.end(), {"--fine-along", at("scratch.toml"), "--fine-voxel", "0.05", "--fine-radius", "1.9"});
    ASSERT_EQ(runKerf(words).exit_code, 0);
    const Outcome o = runKerf({"cut", at(name + ".case"), "--tool", "round-005", "--path", at("scratch.toml"), "-o",
                               at(name + ".run"), "--json"});
    ASSERT_EQ(o.exit_code, 0) << o.err;
    const json j = json::parse(o.out);
    EXPECT_EQ(j["voxel_mm"], is_fine ? 0.05 : 0.5);
    EXPECT_EQ(j["strokes"], 2);
    EXPECT_EQ(j["idle_strokes"], json::array({2})) << o.err;
    EXPECT_EQ(o.err.find("the tool changed nothing"), o.err.npos) << o.err;
    EXPECT_EQ(o.err.find("thinner than the voxels") != o.err.npos, !is_fine) << o.err;
  }
}

// A stroke that no node registers is judged between the nodes, also beside one that nodes register, and after another
// run.
TEST_F(CliPromises, AThinStrokeBesideADeepOneIsNotSaidToRemoveNothing) {
  makeCase();
  ASSERT_EQ(runKerf({"bake", at("box.off"), "--unit", "mm", "-o", at("coarse.case"), "--voxel", "0.5"}).exit_code, 0);
  const std::string begin =
      "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 4.0\n[start]\nposition = [-2.5, 0.3, {}]\n"
      "axis = [0, 0, 1]\n";
  const auto stroke = [](const std::string& kind, const std::string& by) {
    return "[[stroke]]\nkind = \"" + kind + "\"\nby = " + by + "\n";
  };
  const auto cut = [&](const std::string& bundle, double depth, const std::string& strokes, const std::string& run) {
    folder_.write("p.toml", fmt::format(fmt::runtime(begin), -depth) + strokes);
    const Outcome o =
        runKerf({"cut", at(bundle), "--tool", "round-005", "--path", at("p.toml"), "-o", at(run), "--json"});
    EXPECT_EQ(o.exit_code, 0) << o.err;
    return o.exit_code == 0 ? json::parse(o.out)["idle_strokes"] : json();
  };
  const std::string along = stroke("line", "[5, 0, 0]");
  // Deep; then shallow beside it; along the deep groove again; in the air.
  const std::string thin_and_two_idle = along + stroke("move", "[-5, 0, 1]") + stroke("move", "[0, 1.5, -0.46]") +
                                        along + stroke("move", "[-5, 0, 1]") + stroke("move", "[0, -1.5, -1.54]") +
                                        along + stroke("move", "[-5, 0, 2]") + along;
  EXPECT_EQ(cut("coarse.case", 0.6, thin_and_two_idle, "mixed.run"), json::array({3, 4}));
  EXPECT_EQ(cut("coarse.case", 0.6, along, "deep.run"), json::array());
  EXPECT_EQ(cut("deep.run", 0.61, along, "deeper.run"), json::array()) << "by a hundredth of a mm";
}

// Both the export and the warning use the field between the nodes.
TEST_F(CliPromises, ACutBetweenTheNodesIsWarnedOfAsThin) {
  makeCase();
  ASSERT_EQ(runKerf({"bake", at("box.off"), "--unit", "mm", "-o", at("coarse.case"), "--voxel", "0.5"}).exit_code, 0);
  struct Scratch {
    double x, y, depth, length;
    bool is_thin;
  };
  // Beside a row of nodes and midway between two; the last is smaller than a voxel.
  for (const auto& [x, y, depth, length, is_thin] : {Scratch{-2.5, 0.3, 0.04, 5, true},
                                                     {-2.5, 0.25, 0.09, 5, true},
                                                     {-2.5, 0.3, 0.01, 5, true},
                                                     {-0.02, 0.3, 0.04, 0.05, false}}) {
    SCOPED_TRACE(fmt::format("y {}, {} mm deep, {} mm long", y, depth, length));
    folder_.write(
        "scratch.toml",
        fmt::format("format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 4.0\n[start]\nposition = "
                    "[{}, {}, {}]\naxis = [0, 0, 1]\n[[stroke]]\nkind = \"line\"\nby = [{}, 0, 0]\n",
                    x, y, -depth, length));
    const Outcome o = runKerf({"cut", at("coarse.case"), "--tool", "round-005", "--path", at("scratch.toml"), "-o",
                               at("thin.run"), "--overwrite", "--json"});
    ASSERT_EQ(o.exit_code, 0) << o.err;
    const json cut = json::parse(o.out);
    EXPECT_LT(cut["removed_mm3"].get<double>(), 1e-6);
    EXPECT_EQ(o.err.find("the cut is thinner than the voxels: the exported mesh loses about ") != o.err.npos, is_thin)
        << o.err;
    EXPECT_EQ(o.err.find("the tool changed nothing") != o.err.npos, !is_thin) << o.err;
    EXPECT_EQ(o.err.find("stroke 1 of 1 removed nothing") != o.err.npos, !is_thin) << o.err;

    const Outcome mesh = runKerf({"export", at("thin.run"), "-o", at("thin.stl"), "--overwrite", "--json"});
    ASSERT_EQ(mesh.exit_code, 0) << mesh.err;
    const double about = cut["thinner_than_voxels_mm3"], removed = json::parse(mesh.out)["removed_volume_mm3"];
    EXPECT_EQ(removed > 1e-6, is_thin) << removed;
    EXPECT_NEAR(about, removed, 0.25 * removed + 1e-9);
  }
}

// A bubble of 1 mm in the middle of the box.
TEST_F(CliPromises, ACavityIsToldOfByCheckAndByExport) {
  std::string off = box();
  off.replace(off.find("8 12 0"), 6, "16 24 0");
  std::string corners, walls;
  for (int c = 0; c < 8; ++c)
    corners += fmt::format("{} {} {}\n", c & 1 ? 0.5 : -0.5, c & 2 ? 0.5 : -0.5, c & 4 ? -1.5 : -2.5);
  for (const char* t : {"8 11 10", "8 9 11", "12 15 13", "12 14 15", "8 13 9", "8 12 13", "10 15 14", "10 11 15",
                        "8 14 12", "8 10 14", "9 15 11", "9 13 15"})
    walls += std::string("3 ") + t + "\n";
  off.insert(off.find("3 0 2 3"), corners);
  folder_.write("hollow.off", off + walls);
  const std::string sentence = "Closed cavities: a resin or powder printer leaves material in them.";

  const Outcome checked = runKerf({"check", at("hollow.off")});
  EXPECT_EQ(checked.exit_code, 0) << checked.out;
  EXPECT_NE(checked.out.find("1 piece with 1 cavity"), checked.out.npos) << checked.out;
  EXPECT_NE(checked.out.find(sentence), checked.out.npos) << checked.out;

  ASSERT_EQ(runKerf({"bake", at("hollow.off"), "--unit", "mm", "--voxel", "0.2", "-o", at("hollow.case")}).exit_code,
            0);
  folder_.write("groove.csv", groove());
  ASSERT_EQ(
      runKerf({"cut", at("hollow.case"), "--tool", "round-014", "--path", at("groove.csv"), "-o", at("hollow.run")})
          .exit_code,
      0);
  for (const char* bundle : {"hollow.case", "hollow.run"}) {
    const Outcome plain = runKerf({"export", at(bundle), "-o", at("out.stl"), "--overwrite"});
    EXPECT_NE(plain.out.find("1 piece with 1 cavity"), plain.out.npos) << plain.out;
    EXPECT_NE(plain.out.find(sentence), plain.out.npos) << plain.out;
    const json exported =
        json::parse(runKerf({"export", at(bundle), "-o", at("out.stl"), "--overwrite", "--json"}).out);
    const json result = json::parse(runKerf({"check", at("out.stl"), "--json"}).out);
    EXPECT_EQ(exported["cavities"], 1);
    EXPECT_EQ(exported["cavities"], result["cavities"]);
    EXPECT_EQ(exported["pieces"], result["pieces"]);
  }
}

TEST_F(CliPromises, CheckReadsAMeshFromStandardInput) {
  folder_.write("box.off", box());
  RunOptions piped;
  piped.input = at("box.off");
  const Outcome o = runKerf({"check", "-", "--json"}, piped);
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_EQ(o.out, runKerf({"check", at("box.off"), "--json"}).out);
  EXPECT_EQ(runKerf({"check", "-"}).exit_code, 1) << "nothing comes in";
}

// Two boxes, one of 0.4 mm beside the other.
TEST_F(CliPromises, ARecipeDropsSpecksAndSaysSo) {
  std::string off = "OFF\n16 24 0\n", walls = box().substr(box().find("3 0 2 3"));
  for (int c = 0; c < 8; ++c) off += fmt::format("{} {} {}\n", c & 1 ? 3 : -3, c & 2 ? 2.5 : -2.5, c & 4 ? 0 : -4);
  for (int c = 0; c < 8; ++c) off += fmt::format("{} {} {}\n", c & 1 ? 5.4 : 5.0, c & 2 ? 0.4 : 0.0, c & 4 ? 0.4 : 0.0);
  off += walls;
  for (const char* t : {"8 10 11", "8 11 9", "12 13 15", "12 15 14", "8 9 13", "8 13 12", "10 14 15", "10 15 11",
                        "8 12 14", "8 14 10", "9 11 15", "9 15 13"})
    off += std::string("3 ") + t + "\n";
  folder_.write("two.off", off);
  const auto bake = [&](const std::string& name, const std::string& line) {
    folder_.write(name + ".toml",
                  "format = \"kerf-recipe\"\nversion = 1\nname = \"Two\"\nunit = \"mm\"\nvoxel = 0.2\n" + line +
                      "[[part]]\nmaterial = \"dentin\"\nmesh = \"two.off\"\n");
    const Outcome o = runKerf({"bake", at(name + ".toml"), "-o", at(name + ".case"), "--json"});
    EXPECT_EQ(o.exit_code, 0) << o.err;
    return json::parse(o.out, nullptr, false);
  };
  const json all = bake("all", ""), large = bake("large", "drop_specks_mm3 = 0.1\n");
  EXPECT_EQ(all["solid"]["pieces"], 2);
  EXPECT_EQ(all["solid"]["specks"], 1);
  EXPECT_EQ(large["solid"]["pieces"], 1);
  EXPECT_NEAR(large["solid"]["volume_mm3"].get<double>(), 120, 1e-3);
  EXPECT_NE(large["changes"].dump().find("smaller than 0.1 mm3"), std::string::npos) << large["changes"];
}

TEST_F(CliPromises, NewToolFilesOfSawsAndMeshesAreToolsAtOnce) {
  ASSERT_EQ(runKerf({"tool", "new", "my-saw", "--shape", "sagittal", "-o", at("my-saw.toml")}).exit_code, 0);
  const Outcome saw = runKerf({"tool", "check", at("my-saw.toml")});
  EXPECT_EQ(saw.exit_code, 0) << saw.out << saw.err;
  EXPECT_NE(saw.out.find("sagittal blade"), saw.out.npos) << saw.out;

  // A pin of 1 x 1 x 6 mm on its tip, as the template expects one.
  std::string pin = "OFF\n8 12 0\n";
  for (int c = 0; c < 8; ++c) pin += fmt::format("{} {} {}\n", c & 1 ? 0.5 : -0.5, c & 2 ? 0.5 : -0.5, c & 4 ? 6 : 0);
  folder_.write("pin.off", pin + box().substr(box().find("3 0 2 3")));
  ASSERT_EQ(runKerf({"tool", "new", "my-pin", "--shape", "mesh", "-o", at("my-pin.toml")}).exit_code, 0);
  refuses({"tool", "info", at("my-pin.toml")}, {"my-pin.stl"});
  std::string text = contentOf(in("my-pin.toml"));
  const std::size_t name = text.find("my-pin.stl");
  ASSERT_NE(name, text.npos) << text;
  folder_.write("my-pin.toml", text.replace(name, 10, "pin.off"));
  const Outcome info = runKerf({"tool", "info", at("my-pin.toml")});
  EXPECT_EQ(info.exit_code, 0) << info.err;
}

TEST_F(CliPromises, ACatalogueBecomesToolsAndATableOfRefusals) {
  folder_.write(
      "burs.csv",
      "name;iso6360;head_diameter;length;shank_diameter;shank_length;price\nRound 014;500314001001014;;;;;5,10\n"
      "Bad;500314001001014;1,6;;;;5\nThick;;1,4;;2;10;5\nThick 2;500314001001012;;;2;16;5\n");
  const std::vector<std::string> words{"tool", "import", at("burs.csv"), "-o", at("my tools")};
  const Outcome o = runKerf(words);
  EXPECT_EQ(o.exit_code, 1) << "it refuses some rows";
  for (const char* said : {"row  name", "3    Bad", "code ends in 014 = 1.4 mm", "the head_diameter, 1.6 mm",
                           "columns that are no keys, kept as comments: price", "written: 1 of 4 tools into "})
    EXPECT_NE(o.out.find(said), o.out.npos) << said << "\n" << o.out;
  EXPECT_EQ(runKerf({"tool", "check", at("my tools/round-014.toml")}).exit_code, 0);

  std::vector<std::string> as_json = words;
  as_json.insert(as_json.end(), {"--overwrite", "--json"});
  const json j = json::parse(runKerf(as_json).out);
  EXPECT_EQ(j["written"][0]["id"], "round-014") << j;
  EXPECT_EQ(j["written"][0]["file"], at("my tools/round-014.toml")) << j;
  EXPECT_EQ(j["refused"].size(), 3u) << j;

  folder_.write("one.csv", "id,shape,head_diameter,shank_diameter,shank_length\nball,round,1.4,2,16\n");
  const Outcome one = runKerf({"tool", "import", at("one.csv"), "-o", at("my tools")});
  EXPECT_EQ(one.exit_code, 0) << one.err;
  EXPECT_NE(one.out.find("row 2, ball: CHECK THIS: a shank of 2 mm"), one.out.npos) << one.out;
  refuses({"tool", "import", at("none.csv"), "-o", at("my tools")}, {"none.csv", "no such file"});
}

// The drawing of a head goes where its tool goes.
TEST_F(CliPromises, ABurFromADrawingIsKeptInItsRun) {
  makeCase();
  folder_.write("head.svg",
                "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 2 4\" width=\"2mm\" height=\"4mm\">"
                "<path d=\"M0 4 A4 4 0 0 0 .8 1.6 L.5 0\"/></svg>");
  folder_.write("drawn.toml",
                "format = \"kerf-tool\"\nversion = 1\nid = \"drawn\"\nname = \"Drawn\"\nkind = \"bur\"\n"
                "shape = \"profile\"\nhead_diameter = 1.6\nprofile_file = \"head.svg\"\n");
  EXPECT_EQ(runKerf({"tool", "check", at("drawn.toml")}).exit_code, 0);
  EXPECT_EQ(runKerf({"tool", "bake", at("drawn.toml"), "-o", at("drawn.tool")}).exit_code, 0);
  const Outcome cut =
      runKerf({"cut", at("box.case"), "--tool", at("drawn.toml"), "--path", at("groove.csv"), "-o", at("drawn.run")});
  ASSERT_EQ(cut.exit_code, 0) << cut.err;
  std::filesystem::remove(in("head.svg"));
  for (const char* kept : {"drawn.tool/tool.toml", "drawn.run/tool.toml"})
    EXPECT_EQ(runKerf({"tool", "info", at(kept)}).exit_code, 0) << kept;
}

// script (of bsdutils, which every Debian has) gives it a terminal.
TEST_F(CliPromises, ToolCheckShowsAtATerminalHowFarItIs) {
  const std::string command = fmt::format("script -qec '{}/kerf tool check round-014 us-35' {} >/dev/null 2>&1",
                                          kProgramFolder, at("typescript"));
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  const std::string shown = contentOf(in("typescript"));
  for (const char* said :
       {" %  round-014: reading", " %  round-014: plunging", " %  us-35: plunging", "2 of 2 tools pass."})
    EXPECT_NE(shown.find(said), shown.npos) << said << "\n" << shown;
  EXPECT_NE(shown.find("\r\033[Kus-35  "), shown.npos) << "a row is not on a line of its own\n" << shown;
  EXPECT_EQ(runKerf({"tool", "check", "round-014", "us-35"}).err, "") << "no terminal, no line";
}

// It writes nothing, so it ends at once, even by Ctrl-C during a cut.
TEST_F(CliPromises, ToolCheckEndsAtOnceByEitherSignal) {
  for (const int signal : {SIGINT, SIGTERM}) {
    RunOptions options;
    options.signal = signal;
    options.signal_after = 0.5;
    const Outcome o = runKerf({"tool", "check", "--all", "--json"}, options);
    EXPECT_EQ(o.signal, signal) << o.exit_code << o.err;
    EXPECT_EQ(o.out, "");
  }
}

TEST_F(CliPromises, ExportAndCheckCountTheSamePieces) {
  folder_.write("box.off", box());
  ASSERT_EQ(runKerf({"bake", at("box.off"), "--unit", "mm", "--voxel", "0.2", "-o", at("bar.case")}).exit_code, 0);
  std::string path = "t,x,y,z,qw,qx,qy,qz\n";
  double t = 0;
  for (double z = -0.2; z > -6; z -= 0.5, t += 4)
    path += fmt::format("{},1,-4,{},1,0,0,0\n{},1,4,{},1,0,0,0\n", t, z, t + 2, z);
  folder_.write("saw.csv", path);
  ASSERT_EQ(
      runKerf({"cut", at("bar.case"), "--tool", "round-014", "--path", at("saw.csv"), "-o", at("two.run")}).exit_code,
      0);
  const json exported = json::parse(runKerf({"export", at("two.run"), "-o", at("two.stl"), "--json"}).out);
  const json checked = json::parse(runKerf({"check", at("two.stl"), "--json"}).out);
  EXPECT_EQ(exported["pieces"], 2);
  EXPECT_EQ(checked["pieces"], exported["pieces"]);
  EXPECT_EQ(json::parse(runKerf({"info", at("two.run"), "--json"}).out)["piece_count"], exported["pieces"]);
}

// 2.4 GB before copies were dropped ahead of the pairs. The program itself needs some 50 MB.
TEST_F(CliPromises, ManyCopiesOfOneTriangleTakeLittleMemory) {
  constexpr int kCopies = 20'000;
  std::string off = fmt::format("OFF\n3 {} 0\n0 0 0\n9 0 0\n0 9 0\n", kCopies);
  for (int n = 0; n < kCopies; ++n) off += "3 0 1 2\n";
  folder_.write("copies.off", off);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"check", at("copies.off")},
        {"bake", at("copies.off"), "--unit", "mm", "--voxel", "0.2", "-o", at("copies.case")}}) {
    const Outcome o = runKerf(words);
    EXPECT_EQ(o.exit_code, 1) << words[0];
    EXPECT_EQ(o.signal, 0) << words[0];
    EXPECT_GT(o.most_memory_mb, 1) << "it is measured";
    EXPECT_LT(o.most_memory_mb, 400) << words[0];
  }
}

// 216 MB of a raw volume, with a label in a ball of 40 voxels. Reading it all at once would need more than twice that.
TEST_F(CliPromises, ASparseLabelVolumeTakesLessMemoryThanItsFile) {
  constexpr int kSide = 600;
  {
    std::ofstream out(in("sparse.nrrd"), std::ios::binary);
    out << fmt::format(
        "NRRD0004\ntype: unsigned char\ndimension: 3\nsizes: {0} {0} {0}\nspacings: 0.2 0.2 0.2\nencoding: raw\n\n",
        kSide);
    std::string slice(static_cast<std::size_t>(kSide) * kSide, '\0');
    for (int z = 0; z < kSide; ++z) {
      for (int y = 230; y < 270; ++y)
        for (int x = 230; x < 270; ++x)
          slice[static_cast<std::size_t>(y * kSide + x)] = std::hypot(x - 250, y - 250, z - 250) < 20 ? '\2' : '\0';
      out << slice;
    }
  }
  const Outcome o = runKerf({"info", at("sparse.nrrd"), "--json"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_EQ(json::parse(o.out)["labels"].size(), 2u);
  EXPECT_GT(o.most_memory_mb, 1) << "it is measured";
  EXPECT_LT(o.most_memory_mb, 200);
}

// ITK takes 0.1 s and 50 MB. The dynamic linker lists the loaded libraries.
TEST_F(CliPromises, OnlyWhatReadsAVolumeLoadsItsReader) {
  folder_.write("labels.nrrd",
                "NRRD0004\ntype: unsigned char\ndimension: 3\nsizes: 2 2 1\nspacings: 1 1 1\n"
                "encoding: raw\n\n" +
                    std::string("\0\5\5\5", 4));
  RunOptions traced;
  traced.environment["LD_DEBUG"] = "files";
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--help"}, {"bake", "--help"}, {"tool", "info", "round-014"}}) {
    const Outcome o = runKerf(words, traced);
    EXPECT_EQ(o.exit_code, 0) << words[0];
    EXPECT_NE(o.err.find("file="), o.err.npos) << "the linker says nothing";
    EXPECT_EQ(o.err.find("kerf_volumes.so"), o.err.npos) << words[0];
  }
  const Outcome reads = runKerf({"info", at("labels.nrrd")}, traced);
  EXPECT_EQ(reads.exit_code, 0);
  EXPECT_NE(reads.err.find("kerf_volumes.so"), reads.err.npos);
}

TEST_F(CliPromises, RecoverDiscardsNoRunThatHasEnded) {
  makeRun();
  RunOptions home;
  home.environment["XDG_DATA_HOME"] = at("data");
  const Outcome none = runKerf({"recover"}, home);
  EXPECT_EQ(none.exit_code, 0);
  EXPECT_NE(none.out.find("no lost session"), none.out.npos) << none.out;
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

// Two arms on a bridge: planes around one arm include the other one.
TEST_F(CliPromises, ATrimTellsTheMiddleOfEachPiece) {
  std::string arms = "OFF\n16 24 0\n", faces;
  for (int arm = 0; arm < 2; ++arm) {
    for (int c = 0; c < 8; ++c)
      arms += fmt::format("{} {} {}\n", 20 * arm + (c & 1 ? 4 : 0), c & 2 ? 4 : 0, c & 4 ? 9 : 0);
    for (const auto& f :
         {"0 2 1", "1 2 3", "4 5 6", "5 7 6", "0 1 4", "1 5 4", "2 6 3", "3 6 7", "0 4 2", "2 4 6", "1 3 5", "3 7 5"}) {
      std::istringstream in(f);
      int a = 0, b = 0, d = 0;
      in >> a >> b >> d;
      faces += fmt::format("3 {} {} {}\n", a + 8 * arm, b + 8 * arm, d + 8 * arm);
    }
  }
  folder_.write("arms.off", arms + faces);
  const std::vector<std::string> words{"trim",    at("arms.off"), "--plane", "0,0,1@0,0,3",
                                       "--plane", "0,0,-1@0,0,6", "-o"};
  const auto with = [&](std::vector<std::string> more) {
    std::vector<std::string> out = words;
    out.insert(out.end(), more.begin(), more.end());
    return runKerf(out);
  };
  const Outcome told = with({at("slice.stl")});
  ASSERT_EQ(told.exit_code, 0) << told.err;
  EXPECT_NE(told.out.find("above: 96.0000 mm3 in 2 pieces"), told.out.npos) << told.out;
  EXPECT_NE(told.out.find("48.0000 mm3 around (2.00, 2.00, 4.50) mm"), told.out.npos) << told.out;
  EXPECT_NE(told.out.find("48.0000 mm3 around (22.00, 2.00, 4.50) mm"), told.out.npos) << told.out;
  const json j = json::parse(with({at("slice.ply"), "--json"}).out);
  ASSERT_EQ(j["parts"][0]["pieces_at"].size(), 2u) << j;
  EXPECT_NEAR(j["parts"][0]["pieces_at"][1]["middle_mm"][0].get<double>(), 22, 1e-4);
}

TEST_F(CliPromises, InfoOfAMeshInAnotherUnitIsInMm) {
  std::string metres = "OFF\n8 12 0\n";
  for (int c = 0; c < 8; ++c)
    metres += fmt::format("{} {} {}\n", c & 1 ? 0.03 : -0.03, c & 2 ? 0.025 : -0.025, c & 4 ? 0.04 : 0.0);
  const std::string mm = box();
  folder_.write("metres.off", metres + mm.substr(mm.find("3 0 2 3")));
  const Outcome o = runKerf({"info", at("metres.off"), "--json"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  const json j = json::parse(o.out);
  EXPECT_EQ(j["unit"], "m");
  EXPECT_NEAR(j["size_in_file_unit"][0].get<double>(), 0.06, 1e-9);
  EXPECT_NEAR(j["size_mm"][0].get<double>(), 60, 1e-6);
  EXPECT_NEAR(j["check"]["volume_mm3"].get<double>(), 60 * 50 * 40, 1e-3) << j["check"];
  EXPECT_TRUE(j["check"]["print_ready"].get<bool>()) << j["check"];
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
  refuses({"tool", "info", at("bur.toml")}, {"mm_per_unit", "0.6 mm", "mm_per_unit = 10 (cm) makes it 60 mm long"});
  folder_.write("bur.toml", tool(1));
  EXPECT_EQ(runKerf({"tool", "info", at("bur.toml")}).exit_code, 0);
}

}  // namespace
}  // namespace kerf::cli_promises_test
