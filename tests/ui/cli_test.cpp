// The program kerf from mesh to print, run as a user does: its output, its messages, and its reproducibility.
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "tests/support/places.h"
#include "tests/ui/cli_runner.h"

namespace kerf::cli_test {
namespace {

using nlohmann::json;

json parsed(const Outcome& o) {
  EXPECT_EQ(o.exit_code, 0) << o.err;
  const json j = json::parse(o.out, nullptr, false);
  EXPECT_FALSE(j.is_discarded()) << o.out;
  return j;
}

std::string bytesOf(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  EXPECT_TRUE(in) << path;
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_F(Cli, WithoutArgumentsShowsHelpAndFails) {
  const Outcome o = runKerf({});
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_EQ(o.out, "");
  for (const char* command : {"bake", "cut", "export", "check", "info", "devices", "tool", "demo-molar"})
    EXPECT_NE(o.err.find(command), o.err.npos) << command;
}

TEST_F(Cli, WrongCommandLinesAreUsageErrors) {
  makeCase();
  refuses({"saw"}, {"no command \"saw\"", "demo-molar"}, 2);
  refuses({"bake"}, {"INPUT"}, 2);
  refuses({"bake", at("box.off")}, {"--output"}, 2);
  refuses({"bake", at("box.off"), "-o", at("x.case"), "--voxel", "fine"}, {"--voxel"}, 2);
  refuses({"bake", at("box.off"), "-o", at("x.case"), "--close", "sew"}, {"--close"}, 2);
  refuses({"bake", at("box.off"), "-o", at("x.case"), "--base-direction", "up"}, {"+x"}, 2);
  refuses({"cut", at("box.case"), "--tool", "round-014", "-o", at("x.run")}, {"--path"}, 2);
  refuses({"export", at("box.case")}, {"--output"}, 2);
  refuses({"tool"}, {"subcommand"}, 2);
  refuses({"check", at("box.off"), "--fix"}, {"--fix"}, 2);
}

TEST_F(Cli, HelpListsEveryCommandUnderAHeadingAndEachHasHelpOfItsOwn) {
  const std::string help = runKerf({"--help"}).out;
  for (const char* heading : {"Commands from scan to mesh:", "Commands for files and tools:", "Commands for examples:"})
    EXPECT_NE(help.find(heading), help.npos) << heading << "\n" << help;

  // The names in the message about an unknown command: "expected one of bake, cut, ... Try: ..."
  const std::string message = runKerf({"saw"}).err;
  const std::size_t begin = message.find("one of ") + 7, end = message.find(". Try");
  ASSERT_LT(begin, end) << message;
  std::istringstream names(message.substr(begin, end - begin));
  std::size_t count = 0;
  for (std::string name; std::getline(names >> std::ws, name, ','); ++count) {
    EXPECT_NE(help.find("\n  " + name + " "), help.npos) << name << "\n" << help;
    const Outcome own = runKerf({name, "--help"});
    EXPECT_EQ(own.exit_code, 0) << name;
    EXPECT_NE(own.out.find("Usage: kerf " + name), own.out.npos) << own.out;
    EXPECT_NE(own.out.find("Example"), own.out.npos) << own.out;
  }
  EXPECT_GE(count, 10u);
}

TEST_F(Cli, ErrorsAreAnsweredInJsonToo) {
  const Outcome o = runKerf({"info", at("none.stl"), "--json"});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_EQ(o.err.substr(0, 6), "kerf: ");
  const json error = json::parse(o.out)["error"];
  EXPECT_EQ(error["file"], at("none.stl"));
  EXPECT_EQ(error["code"], "not_found");
  for (const char* key : {"message", "found", "expected", "hint"}) EXPECT_FALSE(error[key].get<std::string>().empty());
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"bake", at("none.stl"), "-o", at("x.case")},
        {"export", at("none.run"), "-o", at("x.stl")},
        {"check", at("none.stl")},
        {"replay", at("none.run")},
        {"pick", at("none.stl"), "--at", "0,0"},
        {"cut", at("none.case"), "--tool", "round-014", "--path", at("none.csv"), "-o", at("x.run")}}) {
    std::vector<std::string> asked = words;
    asked.push_back("--json");
    EXPECT_TRUE(json::parse(runKerf(asked).out, nullptr, false).contains("error")) << words[0];
    EXPECT_EQ(runKerf(words).out, "") << words[0];
  }
}

TEST_F(Cli, ACommandThatDoesNotExistIsAnsweredInJsonToo) {
  refuses({"bogus", "--json"}, {"no command \"bogus\"", "kerf --help"}, 2);
  const json error = json::parse(runKerf({"bogus", "--json"}).out, nullptr, false);
  ASSERT_TRUE(error.contains("error")) << error;
  EXPECT_EQ(error["error"]["found"], "no command \"bogus\"");
}

TEST_F(Cli, BakeTellsTheSameKeysWhenUpToDate) {
  folder_.write("box.off", box());
  const std::vector<std::string> words{"bake", at("box.off"), "--unit",       "mm",    "--voxel",
                                       "0.2",  "-o",          at("box.case"), "--json"};
  const json first = parsed(runKerf(words)), again = parsed(runKerf(words));
  EXPECT_FALSE(first["was_up_to_date"].get<bool>());
  EXPECT_TRUE(again["was_up_to_date"].get<bool>());
  for (const auto& [key, value] : first.items()) EXPECT_TRUE(again.contains(key)) << key;
  EXPECT_EQ(again["sources"][0]["sha256"], first["sources"][0]["sha256"]);

  // The costs of closing are kept as numbers, without the places.
  ASSERT_TRUE(again["closing"].is_object()) << again["closing"];
  for (const auto& [key, value] : first["closing"].items()) {
    ASSERT_TRUE(again["closing"].contains(key)) << key;
    if (value.is_number()) {
      EXPECT_EQ(again["closing"][key], value) << key;
    }
  }
  const json info = parsed(runKerf({"info", at("box.case"), "--json"}));
  EXPECT_EQ(info["closing"]["holes_filled"], first["closing"]["holes_filled"]);
  EXPECT_EQ(info["closing"]["vertices_lost"], first["closing"]["vertices_lost"]);
}

// A scan of 2.6 mm gets a warning: its base is scaled down with it. The warning is repeated when nothing is baked.
TEST_F(Cli, BakeTellsItsWarningsAgainWhenUpToDate) {
  std::string tiny = "OFF\n8 10 0\n";
  for (int c = 0; c < 8; ++c)
    tiny += fmt::format("{} {} {}\n", c & 1 ? 0.9 : -0.9, c & 2 ? 0.75 : -0.75, c & 4 ? 0 : -1.2);
  for (const char* t : {"0 2 3", "0 3 1", "0 1 5", "0 5 4", "2 6 7", "2 7 3", "0 4 6", "0 6 2", "1 3 7", "1 7 5"})
    tiny += std::string("3 ") + t + "\n";
  folder_.write("tiny.off", tiny);
  const std::vector<std::string> words{"bake",    at("tiny.off"), "--unit", "mm",
                                       "--voxel", "0.05",         "-o",     at("tiny.case")};
  std::vector<std::string> as_json = words;
  as_json.emplace_back("--json");
  const json first = parsed(runKerf(as_json)), again = parsed(runKerf(as_json));
  ASSERT_TRUE(again["was_up_to_date"].get<bool>());
  ASSERT_FALSE(first["warnings"].empty()) << first;
  EXPECT_EQ(again["warnings"], first["warnings"]);
  EXPECT_EQ(again["closing"]["warnings"], first["closing"]["warnings"]);
  EXPECT_EQ(parsed(runKerf({"info", at("tiny.case"), "--json"}))["warnings"], first["warnings"]);

  const std::string said = first["warnings"][0];
  const Outcome told = runKerf(words);
  EXPECT_NE(told.out.find("WARNING: " + said), told.out.npos) << told.out;
}

// 016 in a bur's number means 1.6 mm. A ball of 16 mm gets a warning, but cuts correctly.
TEST_F(Cli, AHeadTenTimesTooWideIsDoubtedAndItsVolumeIsRight) {
  folder_.write("big-ball.toml",
                "format = \"kerf-tool\"\nversion = 1\nid = \"big-ball\"\nname = \"Ball\"\nkind = \"bur\"\n"
                "shape = \"round\"\nhead_diameter = 16\nshank_diameter = 1.6\nshank_length = 15\n");
  const Outcome o = runKerf({"tool", "check", at("big-ball.toml")});
  EXPECT_EQ(o.exit_code, 0) << o.out << o.err;
  EXPECT_NE(o.out.find("CHECK THIS: a head 16 mm wide"), o.out.npos) << o.out;
  EXPECT_EQ(runKerf({"tool", "check", "round-016"}).out.find("CHECK THIS"), std::string::npos);
  EXPECT_TRUE(parsed(runKerf({"tool", "check", at("big-ball.toml"), "--json"}))[0].contains("doubt"));
}

// A rod of 6 mm across its declared rotation axis: every command that reads it warns.
TEST_F(Cli, AToolMeshAcrossItsAxisIsDoubtedWhereverItIsUsed) {
  makeCase();
  std::string rod = "OFF\n8 12 0\n";
  for (int c = 0; c < 8; ++c) rod += fmt::format("{} {} {}\n", c & 1 ? 3 : -3, c & 2 ? 0.5 : -0.5, c & 4 ? 1 : 0);
  folder_.write("rod.off", rod + box().substr(box().find("3 0 2 3")));
  const auto tool = [](const std::string& id, const std::string& axis, const std::string& tip, double cut_below) {
    return fmt::format(
        "format = \"kerf-tool\"\nversion = 1\nid = \"{}\"\nname = \"Rod\"\nkind = \"mesh\"\nmesh = \"rod.off\"\n"
        "mm_per_unit = 1\ntip = {}\naxis = {}\ncut_below = {}\n",
        id, tip, axis, cut_below);
  };
  folder_.write("across.toml", tool("across", "[0, 0, 1]", "[0, 0, 0]", 0.5));
  folder_.write("along.toml", tool("along", "[1, 0, 0]", "[-3, 0, 0.5]", 2));
  const std::string doubt = "the mesh is longest 90 degrees off its axis";

  const Outcome table = runKerf({"tool", "check", at("across.toml"), at("along.toml"), "--voxel", "0.1"});
  EXPECT_NE(table.out.find("CHECK THIS: " + doubt), table.out.npos) << table.out;
  EXPECT_EQ(table.out.find("CHECK THIS"), table.out.rfind("CHECK THIS")) << "of one of them\n" << table.out;
  const Outcome info = runKerf({"tool", "info", at("across.toml")});
  EXPECT_NE(info.out.find("CHECK THIS: " + doubt), info.out.npos) << info.out;
  EXPECT_TRUE(parsed(runKerf({"tool", "info", at("across.toml"), "--json"})).contains("doubt"));
  EXPECT_FALSE(parsed(runKerf({"tool", "info", at("along.toml"), "--json"})).contains("doubt"));
  const Outcome cut =
      runKerf({"cut", at("box.case"), "--tool", at("across.toml"), "--path", at("groove.csv"), "-o", at("rod.run")});
  EXPECT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_NE(cut.err.find("WARNING: across: " + doubt), cut.err.npos) << cut.err;
}

// A pin of 120 000 triangles as a tool: the convexity test uses few of its vertices. Each triangle against each vertex
// took ten times as long, and half an hour with the 1.5 million triangles of a scanner. The unit is the time of a check
// of the same mesh on this machine: the tool now takes 4 times that, formerly 40 times.
TEST_F(Cli, AToolMeshOfManyTrianglesIsReadInAFewTimesTheProcessorTimeOfItsCheck) {
  constexpr int kAround = 300, kUp = 200;
  std::string off = fmt::format("OFF\n{} {} 0\n", kAround * (kUp - 1) + 2, 2 * kAround * (kUp - 1));
  const auto ring = [](int up) { return std::numbers::pi * up / kUp; };
  for (int u = 1; u < kUp; ++u)
    for (int a = 0; a < kAround; ++a) {
      const double at = 2 * std::numbers::pi * a / kAround, r = 0.7 * std::sin(ring(u));
      off += fmt::format("{:.7f} {:.7f} {:.7f}\n", r * std::cos(at), r * std::sin(at), 0.7 - 0.7 * std::cos(ring(u)));
    }
  off += "0 0 0\n0 0 1.4\n";
  const int bottom = kAround * (kUp - 1), top = bottom + 1;
  for (int a = 0; a < kAround; ++a) {
    const int b = (a + 1) % kAround;
    off += fmt::format("3 {} {} {}\n3 {} {} {}\n", bottom, b, a, top, bottom - kAround + a, bottom - kAround + b);
    for (int u = 0; u + 2 < kUp; ++u)
      off += fmt::format("3 {0} {1} {2}\n3 {0} {2} {3}\n", u * kAround + a, u * kAround + b, (u + 1) * kAround + b,
                         (u + 1) * kAround + a);
  }
  folder_.write("pin.off", off);
  folder_.write(
      "pin.toml",
      "format = \"kerf-tool\"\nversion = 1\nid = \"pin\"\nname = \"Pin\"\nkind = \"mesh\"\nmesh = \"pin.off\"\n"
      "mm_per_unit = 1\ntip = [0, 0, 0]\naxis = [0, 0, 1]\ncut_below = 2\n");
  const Outcome checked = runKerf({"check", at("pin.off"), "--unit", "mm"});
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
  const Outcome o = runKerf({"tool", "info", at("pin.toml")});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_LT(o.processor_seconds, 15 * checked.processor_seconds);
}

TEST_F(Cli, CheckJudgesManyMeshesEachUnderItsName) {
  folder_.write("box.off", box());
  folder_.write("open.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const Outcome all = runKerf({"check", at("box.off"), at("open.off"), at("none.off")});
  EXPECT_EQ(all.exit_code, 1);
  EXPECT_NE(all.out.find(at("box.off") + ": Ready to print."), all.out.npos) << all.out;
  EXPECT_NE(all.out.find(at("open.off") + ": Not ready"), all.out.npos) << all.out;
  EXPECT_NE(all.out.find("1 of 3 ready to print"), all.out.npos) << all.out;
  EXPECT_NE(all.err.find("none.off"), all.err.npos) << all.err;

  const Outcome rows = runKerf({"check", at("box.off"), at("none.off"), "--json"});
  EXPECT_EQ(rows.exit_code, 1);
  const json j = json::parse(rows.out);
  ASSERT_EQ(j.size(), 2u);
  EXPECT_EQ(j[0]["file"], at("box.off"));
  EXPECT_TRUE(j[0]["print_ready"].get<bool>()) << j[0];
  EXPECT_NE(j[1]["error"]["message"].get<std::string>().find("none.off"), std::string::npos) << j[1];

  EXPECT_EQ(runKerf({"check", at("box.off"), at("box.off")}).exit_code, 0);
}

TEST_F(Cli, ACutAgainstResistanceGoesOnFromARun) {
  ASSERT_EQ(runKerf({"demo", "molar", "--coarseness", "3", "-o", at("molar")}).exit_code, 0);
  ASSERT_EQ(runKerf({"bake", at("molar/molar.toml"), "--voxel", "0.2", "-o", at("molar.case")}).exit_code, 0);
  const std::string cavity = std::string(kSourceFolder) + "/assets/paths/demo-cavity.toml";
  // A hole beside it.
  folder_.write("beside.csv", "t,x,y,z,qw,qx,qy,qz\n0,3.2,0.5,9,1,0,0,0\n3,3.2,0.5,3,1,0,0,0\n6,3.2,0.5,9,1,0,0,0\n");
  const auto cut = [&](const std::string& from, const std::string& path, const std::string& run,
                       const std::vector<std::string>& more) {
    std::vector<std::string> words{"cut", at(from), "--tool", "round-014", "--path", path, "-o", at(run), "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const json first = parsed(runKerf(cut("molar.case", at("beside.csv"), "first.run", {"--hand", "feed"})));
  const json second = parsed(runKerf(cut("first.run", cavity, "second.run", {"--hand", "force"})));
  const json alone = parsed(runKerf(cut("molar.case", cavity, "alone.run", {"--hand", "force"})));
  const double before = first["removed_mm3"], then = second["removed_mm3"];
  ASSERT_GT(before, 0.05);
  EXPECT_GT(then, 5);
  EXPECT_NEAR(second["initial_mm3"].get<double>(), first["remaining_mm3"].get<double>(), 1e-6);
  EXPECT_LE(then, alone["removed_mm3"].get<double>() + 0.2) << "what is gone is not cut again";

  // The export has the cuts of both runs. The run names its origin, and replays.
  const auto exported = [&](const std::string& run) {
    const json out = parsed(runKerf({"export", at(run), "-o", at(run + ".stl"), "--json"}));
    EXPECT_EQ(runKerf({"check", at(run + ".stl")}).exit_code, 0) << run;
    return out["removed_volume_mm3"].get<double>();
  };
  const double all = exported("second.run"), part = exported("first.run");
  EXPECT_NEAR(all - part, then, 0.05 * then);
  const json info = parsed(runKerf({"info", at("second.run"), "--json"}));
  EXPECT_EQ(info["goes_on_from_field_sha256"].get<std::string>().size(), 64u) << info;
  const json replayed = parsed(runKerf({"replay", at("second.run"), "--json"}));
  EXPECT_TRUE(replayed["is_same"].get<bool>() && replayed["is_whole"].get<bool>()) << replayed;

  const json swept = parsed(runKerf(cut("first.run", cavity, "swept.run", {})));
  EXPECT_NEAR(exported("swept.run") - part, swept["removed_mm3"].get<double>(), 0.05 * then);
  EXPECT_EQ(swept["goes_on"], at("first.run"));
  EXPECT_TRUE(swept["warnings"].empty() && swept["beside"].empty()) << swept;
  EXPECT_TRUE(alone["goes_on"].is_null());
  const Outcome told = runKerf({"info", at("swept.run")});
  EXPECT_NE(told.out.find("since the run that this one continues"), told.out.npos) << told.out;

  // In a later run, by hand or by geometry alone, the filling in the hole is composite.
  const json filled =
      parsed(runKerf(cut("first.run", at("beside.csv"), "filled.run", {"--hand", "feed", "--add", "composite"})));
  const double filling = filled["added_by_material_mm3"]["composite"];
  ASSERT_GT(filling, 1);
  const json picked = parsed(runKerf({"pick", at("filled.run"), "--at", "3.2,0.5", "--json"}));
  EXPECT_EQ(picked["points"][0]["tissue"], "composite") << picked;
  const Outcome in_filling = runKerf(cut("filled.run", at("beside.csv"), "in_filling.run", {}));
  EXPECT_EQ(in_filling.err.find("WARNING"), in_filling.err.npos) << in_filling.err;
  const json drilled = parsed(in_filling);
  EXPECT_TRUE(drilled["warnings"].empty()) << drilled;
  EXPECT_NEAR(drilled["removed_by_material_mm3"]["composite"].get<double>(), filling, 0.05 * filling) << drilled;
  const json by_hand = parsed(runKerf(cut("filled.run", at("beside.csv"), "hand_in_filling.run", {"--hand", "feed"})));
  EXPECT_NEAR(by_hand["initial_by_material_mm3"]["composite"].get<double>(), filling, 0.01 * filling) << by_hand;
  EXPECT_GT(by_hand["removed_by_material_mm3"]["composite"].get<double>(), 0.1) << by_hand;
  EXPECT_NE(runKerf({"info", at("hand_in_filling.run")}).out.find("\n  composite "), std::string::npos);
  EXPECT_TRUE(parsed(runKerf({"replay", at("hand_in_filling.run"), "--json"}))["is_same"].get<bool>());

  refuses(cut("first.run", cavity, "first.run", {"--hand", "feed", "--force"}), {"never changes a run"});
  parsed(runKerf(cut("molar.case", at("beside.csv"), "damaged.run", {"--hand", "feed"})));
  std::ofstream(at("damaged.run/run.vdb"), std::ios::binary) << "no field";
  refuses(cut("damaged.run", cavity, "x.run", {"--hand", "feed"}), {"run.vdb"});
}

TEST_F(Cli, ACutAgainstResistanceIsRecordedAndReplaysBitForBit) {
  ASSERT_EQ(runKerf({"demo", "molar", "--coarseness", "3", "-o", at("molar")}).exit_code, 0);
  ASSERT_EQ(runKerf({"bake", at("molar/molar.toml"), "--voxel", "0.2", "-o", at("molar.case")}).exit_code, 0);
  const std::string cavity = std::string(kSourceFolder) + "/assets/paths/demo-cavity.toml";
  // A strong and fast drive, for a short test.
  std::string tool = bytesOf(std::string(kSourceFolder) + "/assets/tools/round-014.toml");
  tool.replace(tool.find("round-014"), 9, "quick");
  folder_.write("quick.toml", tool + "\n[drive]\nhandpiece = \"electric\"\nstall_torque_Nmm = 8\nenergy_factor = 3\n");
  const auto cut = [&](const std::string& run, const std::vector<std::string>& hand) {
    std::vector<std::string> words{"cut", at("molar.case"), "--tool", at("quick.toml"), "--path", cavity,
                                   "-o",  at(run),          "--json", "--hand"};
    words.insert(words.end(), hand.begin(), hand.end());
    return parsed(runKerf(words));
  };
  const json feed = cut("feed.run", {"feed"}), again = cut("again.run", {"feed"});
  EXPECT_TRUE(feed["is_complete"].get<bool>());
  EXPECT_EQ(feed["state_hash"], again["state_hash"]);
  EXPECT_TRUE(bytesOf(at("feed.run/forces.csv")) == bytesOf(at("again.run/forces.csv")));
  EXPECT_TRUE(bytesOf(at("feed.run/session.kerflog")) == bytesOf(at("again.run/session.kerflog")));
  const double removed = feed["removed_mm3"], left = feed["remaining_mm3"], initial = feed["initial_mm3"];
  EXPECT_GT(removed, 10);
  EXPECT_NEAR(removed + left, initial, 1e-6 * initial);
  double by_material = 0;
  for (const auto& [id, volume] : feed["removed_by_material_mm3"].items()) by_material += volume.get<double>();
  EXPECT_NEAR(by_material, removed, 1e-9 * initial);
  EXPECT_GT(feed["removed_by_material_mm3"].size(), 1u);
  EXPECT_EQ(feed["pieces"], 1);
  // The planned volume equals the volume of a cut without resistance.
  const json plan = parsed(
      runKerf({"cut", at("molar.case"), "--tool", at("quick.toml"), "--path", cavity, "-o", at("plan.run"), "--json"}));
  EXPECT_EQ(plan["removed_by_material_mm3"], feed["planned_by_material_mm3"]);
  EXPECT_NEAR(plan["removed_mm3"].get<double>(), feed["planned_mm3"].get<double>(), 1e-9);
  EXPECT_NEAR(removed / feed["planned_mm3"].get<double>(), 1, 0.05);
  EXPECT_LT(feed["farthest_off_mm"].get<double>(), 1e-6);  // a machine's tool is at its place on the path
  // A dry cut gets hotter, and nothing else changes.
  const json dry = cut("dry.run", {"feed", "--irrigation", "0"});
  EXPECT_EQ(dry["removed_mm3"], feed["removed_mm3"]);
  EXPECT_GT(dry["hottest_C"].get<double>(), 1.5 * feed["hottest_C"].get<double>());

  // More push: larger force, shorter time, and still nearly the whole path is cut.
  const json gentle = cut("gentle.run", {"force", "--push", "1"}), firm = cut("firm.run", {"force", "--push", "2"});
  EXPECT_GT(firm["mean_contact_force_N"].get<double>(), gentle["mean_contact_force_N"].get<double>());
  EXPECT_LT(firm["seconds_in_contact"].get<double>(), gentle["seconds_in_contact"].get<double>());
  EXPECT_LT(firm["mean_contact_force_N"].get<double>(), 3);
  for (const json& pushed : {gentle, firm}) {
    EXPECT_NEAR(pushed["removed_mm3"].get<double>() / pushed["planned_mm3"].get<double>(), 1, 0.05);
    EXPECT_GT(pushed["farthest_off_mm"].get<double>(), 0.01);
  }
  const json device = cut("device.run", {"device", "--hand-stiffness", "1"});
  EXPECT_LE(device["peak_hand_force_N"].get<double>(), 8);
  for (const char* response : {"constraint", "impulse"}) {
    const json held = cut(std::string(response) + ".run", {"force", "--push", "2", "--response", response});
    EXPECT_EQ(held["response"], response);
    EXPECT_NE(held["state_hash"], firm["state_hash"]);
    EXPECT_GT(held["removed_mm3"].get<double>(), 1);
    EXPECT_LT(held["peak_hand_force_N"].get<double>(), 8.001);
  }
  for (const char* run : {"feed.run", "firm.run", "device.run", "constraint.run", "impulse.run"}) {
    const json replayed = parsed(runKerf({"replay", at(run), "--json"}));
    EXPECT_TRUE(replayed["is_same"].get<bool>()) << run;
    EXPECT_GT(replayed["checks"].get<int>(), 3);
    EXPECT_EQ(runKerf({"export", at(run), "-o", at(std::string(run) + ".stl")}).exit_code, 0);
    EXPECT_EQ(runKerf({"check", at(std::string(run) + ".stl")}).exit_code, 0);
  }
  const json late = parsed(runKerf({"replay", at("feed.run"), "--from", "1e9", "--json"}));
  EXPECT_TRUE(late["is_same"].get<bool>());
  EXPECT_EQ(late["state_hash"], feed["state_hash"]);
  const Outcome early = runKerf({"replay", at("firm.run"), "--from", "0.5"});
  EXPECT_NE(early.out.find("from the beginning"), early.out.npos) << early.out;
  refuses({"replay", at("firm.run"), "--from", "3", "--until", "2"}, {"--from", "--until"}, 2);
  // Sound as long as the run, at an audible pitch, and reproducible.
  cut("loud.run", {"feed", "--sound"});
  const std::string sound = bytesOf(at("loud.run/sound.wav"));
  ASSERT_EQ(sound.size(), 44 + 2 * 48 * feed["ticks"].get<std::size_t>());
  EXPECT_EQ(sound.substr(0, 4) + sound.substr(8, 8), "RIFFWAVEfmt ");
  double square = 0;
  for (std::size_t n = 44; n < sound.size(); n += 2) {
    const auto value =
        static_cast<std::int16_t>(static_cast<unsigned char>(sound[n]) | static_cast<unsigned char>(sound[n + 1]) << 8);
    square += value / 32768.0 * value / 32768.0;
  }
  EXPECT_GT(std::sqrt(square / (48.0 * feed["ticks"].get<double>())), 0.02);
  EXPECT_FALSE(std::filesystem::exists(at("feed.run/sound.wav")));
  const json half = parsed(runKerf({"replay", at("feed.run"), "--until", "8", "--json"}));
  EXPECT_EQ(half["ticks"], 8000);
  EXPECT_LT(half["removed_mm3"].get<double>(), removed);

  // A row per tick, in order, with the columns of the header.
  std::istringstream rows(bytesOf(at("feed.run/forces.csv")));
  std::string row;
  std::getline(rows, row);
  const auto columns = std::count(row.begin(), row.end(), ',');
  std::uint64_t count = 0;
  while (std::getline(rows, row)) {
    ASSERT_EQ(std::count(row.begin(), row.end(), ','), columns) << row;
    ++count;
    ASSERT_NEAR(std::stod(row), 0.001 * static_cast<double>(count), 1e-9);
  }
  EXPECT_EQ(count, feed["ticks"].get<std::uint64_t>());

  // A log of another run, or a truncated log.
  const std::string log = bytesOf(at("feed.run/session.kerflog"));
  std::ofstream(at("feed.run/session.kerflog"), std::ios::binary) << log.substr(0, log.size() / 2);
  const Outcome torn = runKerf({"replay", at("feed.run")});
  EXPECT_EQ(torn.exit_code, 3) << torn.out;
  EXPECT_NE(torn.out.find("cut off"), torn.out.npos) << torn.out;
  const std::string all = fmt::format(" of {:.3f} s", 0.001 * feed["ticks"].get<double>());
  EXPECT_NE(torn.out.find(all), torn.out.npos) << torn.out;
  EXPECT_NE(torn.out.find("INCOMPLETE: the same bit for bit"), torn.out.npos) << torn.out;
  EXPECT_EQ(torn.out.find("\nthe same"), torn.out.npos) << torn.out;
  const Outcome torn_json = runKerf({"replay", at("feed.run"), "--json"});
  EXPECT_EQ(torn_json.exit_code, 3);
  EXPECT_NE(torn_json.out.find("\"is_whole\": false"), torn_json.out.npos) << torn_json.out;
  // A request within the available range reports how it went.
  const json part = parsed(runKerf({"replay", at("feed.run"), "--until", "5", "--json"}));
  EXPECT_TRUE(part["is_same"].get<bool>() && part["is_whole"].get<bool>());
  // Cut short to a second: one sample record per tick, hardly a check.
  std::ofstream(at("feed.run/session.kerflog"), std::ios::binary) << log.substr(0, log.size() / 18);
  EXPECT_EQ(runKerf({"replay", at("feed.run")}).exit_code, 3);
  std::ofstream(at("feed.run/session.kerflog"), std::ios::binary) << "no log";
  refuses({"replay", at("feed.run")}, {"session.kerflog"});
  refuses({"replay", at("molar.case")}, {"not a run"});
  refuses({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("x.run"), "--hand", "foot"},
          {"--hand"}, 2);
  refuses({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("x.run"), "--hand", "force",
           "--push", "0"},
          {"--push: 0 N", "0.01 to 8"}, 2);
  refuses({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("x.run"), "--hand", "feed",
           "--spindle", "nan"},
          {"--spindle"}, 2);
  refuses({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("x.run"), "--push", "1"},
          {"--push", "--hand force"}, 2);
  refuses({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("x.run"), "--hand", "force",
           "--encoder", "0.1"},
          {"--encoder", "--hand device"}, 2);
  refuses({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("x.run"), "--hand", "feed",
           "--response", "impulse"},
          {"--response", "--hand feed", "--hand force or device"}, 2);
  // A machine's tool is at its place on the path: it has no coupling.
  refuses({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("x.run"), "--hand", "feed",
           "--coupling", "5"},
          {"--coupling", "--hand feed", "--hand device"}, 2);
  refuses({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("x.run"), "--hand", "force",
           "--response", "god"},
          {"--response", "constraint"}, 2);
  // A table that lacks one of the case's materials cannot define its cutting: no guess.
  std::filesystem::create_directories(at("assets"));
  std::string table = bytesOf(std::string(kSourceFolder) + "/assets/materials.toml");
  const std::size_t caries = table.find("number = 4\n");
  ASSERT_NE(caries, table.npos);
  table.replace(caries, 10, "number = 44");
  std::ofstream(at("assets/materials.toml"), std::ios::binary) << table;
  RunOptions other;
  other.environment["KERF_ASSETS"] = at("assets");
  refuses({"cut", at("molar.case"), "--tool", std::string(kSourceFolder) + "/assets/tools/round-014.toml", "--path",
           cavity, "-o", at("x.run"), "--hand", "feed"},
          {"[[material]] caries", "number 4, which is no material in", "KERF_ASSETS"}, 1, other);
  // The same for a table that reuses the number: caries would be cut, and counted, as resin.
  table.replace(table.find("id = \"caries\""), 13, "id = \"resin\"");
  table.replace(table.find("number = 44\n"), 11, "number = 4");
  std::ofstream(at("assets/materials.toml"), std::ios::binary) << table;
  for (const std::vector<std::string>& hand : {std::vector<std::string>{}, {"--hand", "feed"}}) {
    std::vector<std::string> words{
        "cut",    at("molar.case"), "--tool", std::string(kSourceFolder) + "/assets/tools/round-014.toml",
        "--path", cavity,           "-o",     at("x.run")};
    words.insert(words.end(), hand.begin(), hand.end());
    refuses(words, {"case.toml", "number 4, which is 'resin' in", "there 4 is 'caries'", "bake again"}, 1, other);
  }
  // A spindle at rest cuts nothing, and nothing is written.
  refuses({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("x.run"), "--hand", "feed",
           "--spindle", "0"},
          {"cut nothing", "spindle"});
  // Nor does a tool that has not arrived at the time limit: no message about the path's frame.
  refuses({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("x.run"), "--hand", "feed",
           "--time-limit", "0.02"},
          {"cut nothing within the time limit of 0.02 s", "Try: a longer --time-limit"});
  refuses({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("x.run"), "--hand", "feed",
           "--add", "chewing-gum"},
          {"--add: \"chewing-gum\"", "Try: another id, or a [[material]] of that id in materials.toml"});
  refuses({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("x.run"), "--haptic", "--hand",
           "force"},
          {"--hand excludes --haptic"}, 2);
  EXPECT_FALSE(std::filesystem::exists(at("x.run")));
  refuses({"replay", at("gone.run")}, {"not a run"});
}

// A machine's feed continues past uncut tissue. The step's count and the remaining surface then disagree, and both
// commands warn. For a hand's cut neither warns.
TEST_F(Cli, ACutThatWasFedThroughWhatItDidNotCutIsDoubtedAndSoIsItsExport) {
  folder_.write(
      "block.obj",
      "v -4 -4 -4\nv 4 -4 -4\nv 4 4 -4\nv -4 4 -4\nv -4 -4 0\nv 4 -4 0\nv 4 4 0\nv -4 4 0\n"
      "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n");
  folder_.write("block.toml",
                "format = \"kerf-recipe\"\nversion = 1\nname = \"block\"\nunit = \"mm\"\nvoxel = 0.25\n"
                "[[part]]\nmaterial = \"enamel\"\nmesh = \"block.obj\"\n");
  ASSERT_EQ(runKerf({"bake", at("block.toml"), "-o", at("block.case")}).exit_code, 0);
  folder_.write("plunge.toml",
                "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 1.0\n[start]\nposition = [0, 0, 0.8]\n"
                "axis = [0, 0, 1]\n[[stroke]]\nkind = \"plunge\"\ndepth = 2.0\n");
  const auto cut = [&](const char* tool, const char* run, const std::vector<std::string>& how) {
    std::vector<std::string> words{"cut", at("block.case"), "--tool", tool, "--path", at("plunge.toml"), "-o", at(run)};
    words.insert(words.end(), how.begin(), how.end());
    return runKerf(words);
  };
  const auto exported = [&](const char* run) {
    return runKerf({"export", at(run), "-o", at(std::string(run) + ".stl")});
  };
  const auto has = [](const Outcome& outcome, const char* what) { return outcome.err.find(what) != std::string::npos; };

  const Outcome fed = cut("round-005", "fed.run", {"--hand", "feed"});
  ASSERT_EQ(fed.exit_code, 0) << fed.err;
  EXPECT_TRUE(has(fed, "WARNING: fed faster than it can cut")) << fed.err;
  const Outcome in_part = cut("round-005", "part.run", {"--hand", "feed", "--time-limit", "1"});
  ASSERT_EQ(in_part.exit_code, 0) << in_part.err;
  EXPECT_FALSE(has(in_part, "fed faster")) << in_part.err;  // an unfinished path proves nothing
  const Outcome doubted = exported("fed.run");
  ASSERT_EQ(doubted.exit_code, 0) << doubted.err;
  EXPECT_TRUE(has(doubted, "WARNING: the run counted")) << doubted.err;

  const Outcome held = cut("round-018", "held.run", {"--hand", "force", "--push", "1.5"});
  ASSERT_EQ(held.exit_code, 0) << held.err;
  EXPECT_FALSE(has(held, "WARNING")) << held.err;
  const Outcome trusted = exported("held.run");
  ASSERT_EQ(trusted.exit_code, 0) << trusted.err;
  EXPECT_FALSE(has(trusted, "WARNING")) << trusted.err;

  // A slow machine feed gets no warning either. For a thin point the message names the consequences on a path.
  folder_.write("plunge.toml",
                "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 0.05\n[start]\n"
                "position = [0, 0, 0.05]\naxis = [0, 0, 1]\n[[stroke]]\nkind = \"plunge\"\ndepth = 0.4\n");
  const Outcome slowly = cut("round-018", "slowly.run", {"--hand", "feed"});
  ASSERT_EQ(slowly.exit_code, 0) << slowly.err;
  EXPECT_FALSE(has(slowly, "WARNING")) << slowly.err;
  const Outcome slow_mesh = exported("slowly.run");
  ASSERT_EQ(slow_mesh.exit_code, 0) << slow_mesh.err;
  EXPECT_FALSE(has(slow_mesh, "WARNING")) << slow_mesh.err;
  const Outcome swept = cut("862-012", "swept.run", {});
  EXPECT_TRUE(has(swept, "volumes may be off by a tenth. Bake with --voxel 0.1 or finer, or for the mesh alone"))
      << swept.err;

  // Only penalty supports a point.
  const Outcome flame = cut("862-012", "flame.run", {"--hand", "force", "--push", "2", "--response", "impulse"});
  EXPECT_EQ(flame.exit_code, 1);
  EXPECT_TRUE(has(flame, "862-012 cut nothing") && has(flame, "Try: omit --response")) << flame.err;
  const Outcome needle = cut("859-012", "needle.run", {"--hand", "force", "--push", "2", "--response", "impulse"});
  EXPECT_EQ(needle.exit_code, 0);
  EXPECT_TRUE(has(needle, "WARNING: with impulse a point as thin as that of 859-012")) << needle.err;
  const Outcome ball = cut("round-018", "ball.run", {"--hand", "force", "--response", "impulse"});
  ASSERT_EQ(ball.exit_code, 0) << ball.err;
  EXPECT_FALSE(has(ball, "Omit --response")) << ball.err;
}

TEST_F(Cli, DevicesSaysWhichCouplingADeviceCanHold) {
  const json typical = parsed(runKerf({"devices", "--typical", "--json"}));
  EXPECT_GE(typical.size(), 5u);
  const json own = parsed(runKerf({"devices", "--delay", "2", "--friction", "0.02", "--encoder", "0.05", "--json"}));
  ASSERT_EQ(own.size(), 1u);
  EXPECT_NEAR(own[0]["stiffness_N_per_mm"].get<double>(), 0.4 / std::numbers::sqrt2, 1e-9);
  EXPECT_NE(runKerf({"devices", "--encoder", "0.05"}).out.find("coarse for its friction"), std::string::npos);
  refuses({"devices", "--mass", "0"}, {"--mass"}, 2);
}

TEST_F(Cli, FastHandpiecesTakeFrictionGripOnly) {
  makeCase();
  folder_.write("down.toml",
                "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\n[start]\nposition = [0, 0, 1]\n"
                "axis = [0, 0, 1]\n[[stroke]]\nkind = \"line\"\nby = [0, 0, -1]\n");
  for (const char* tool : {"disc-22", "drill-20"})
    refuses({"cut", at("box.case"), "--tool", tool, "--path", at("down.toml"), "-o", at("x.run"), "--hand", "feed",
             "--drive", "turbine"},
            {"--drive", "friction-grip"});
}

TEST_F(Cli, ADrillTurnedBackwardsTakesNothingAndATurbineRefuses) {
  makeCase();
  folder_.write("down.toml",
                "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\n[start]\nposition = [0, 0, 1]\n"
                "axis = [0, 0, 1]\n[[stroke]]\nkind = \"line\"\nby = [0, 0, -2]\n");
  const auto cut = [&](const char* tool) {
    return std::vector<std::string>{"cut", at("box.case"), "--tool", tool,   "--path",    at("down.toml"),
                                    "-o",  at("back.run"), "--hand", "feed", "--reverse", "--force"};
  };
  refuses(cut("round-014"), {"--reverse", "no reverse", "Try: --drive electric"});
  refuses(cut("drill-20"), {"drill-20 cut nothing", "in reverse this tool only rubs"});

  std::vector<std::string> electric = cut("856-016");
  electric.insert(electric.end(), {"--drive", "electric"});
  const auto done = runKerf(electric);
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(done.out.find("removed 0.0000 mm3"), std::string::npos) << done.out;
  const auto again = runKerf({"replay", at("back.run")});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.out.find("the same bit for bit"), std::string::npos) << again.out;
  refuses({"cut", at("box.case"), "--tool", "drill-20", "--path", at("down.toml"), "-o", at("x.run"), "--reverse"},
          {"--reverse", "--hand"}, 2);
}

// Along a groove out of one box, over a gap of 1 mm, into the next one, which has other voxels.
TEST_F(Cli, AToolThatLeavesItsToothCutsTheNeighbourWhichIsMeasuredToldReplayedAndExported) {
  makeCase();
  const auto boxAt = [&](const std::string& name, double shift, const std::string& voxel) {
    std::istringstream in(box());
    std::string out, line;
    for (int n = 0; std::getline(in, line); ++n) {
      const double x = n >= 2 && n < 10 ? std::stod(line) + shift : 0;
      out += n >= 2 && n < 10 ? fmt::format("{}{}\n", x, line.substr(line.find(' '))) : line + "\n";
    }
    folder_.write(name + ".off", out);
    EXPECT_EQ(
        runKerf({"bake", at(name + ".off"), "--unit", "mm", "-o", at(name + ".case"), "--voxel", voxel}).exit_code, 0);
  };
  boxAt("next", 7, "0.15");
  boxAt("far", -20, "0.2");
  boxAt("over", 2, "0.2");
  folder_.write(
      "across.toml",
      "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 1.0\n[start]\nposition = [0, 0, -0.35]\n"
      "axis = [0, 0, 1]\n[[stroke]]\nkind = \"line\"\nby = [6, 0, 0]\n");
  const auto cut = [&](const std::string& run, const std::vector<std::string>& more) {
    std::vector<std::string> words{"cut",    at("box.case"),    "--tool", "round-014", "--drive", "electric",
                                   "--path", at("across.toml"), "--hand", "feed",      "-o",      at(run)};
    words.insert(words.end(), more.begin(), more.end());
    return runKerf(words);
  };
  const std::vector<std::string> beside{"--beside", at("next.case"), "--beside", at("far.case")};
  const Outcome told = cut("row.run", beside);
  ASSERT_EQ(told.exit_code, 0) << told.err;
  EXPECT_NE(told.err.find("beside_1"), told.err.npos) << told.err;
  EXPECT_NE(told.err.find("mm3 removed"), told.err.npos) << told.err;
  EXPECT_EQ(told.err.find("beside_2"), told.err.npos) << told.err;
  EXPECT_EQ(told.err.find("overlaps"), told.err.npos) << told.err;

  const json summary = json::parse(bytesOf(at("row.run/summary.json")));
  EXPECT_NEAR(summary["removed_mm3"].get<double>() + summary["remaining_mm3"].get<double>(),
              summary["initial_mm3"].get<double>(), 1e-6 * summary["initial_mm3"].get<double>());
  // By geometry alone, deeper: the output includes the neighbour's removed volume.
  folder_.write(
      "deeper.toml",
      "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 1.0\n[start]\nposition = [0, 0, -0.7]\n"
      "axis = [0, 0, 1]\n[[stroke]]\nkind = \"line\"\nby = [6, 0, 0]\n");
  const Outcome deeper = runKerf(
      {"cut", at("row.run"), "--tool", "round-014", "--path", at("deeper.toml"), "-o", at("deeper.run"), "--json"});
  ASSERT_EQ(deeper.exit_code, 0) << deeper.err;
  EXPECT_NE(deeper.err.find("beside_1"), deeper.err.npos) << deeper.err;
  EXPECT_EQ(deeper.err.find("beside_2"), deeper.err.npos) << deeper.err;
  const json taken = json::parse(deeper.out)["beside"];
  EXPECT_GT(taken[0]["removed_mm3"].get<double>(), 0.1) << taken;
  EXPECT_EQ(taken[1]["removed_mm3"].get<double>(), 0) << taken;

  const json &next = summary["beside"][0], &far = summary["beside"][1];
  const double lost = next["removed_mm3"];
  EXPECT_GT(lost, 0.5);
  EXPECT_EQ(next["case_path"], "../next.case");
  EXPECT_EQ(far["removed_mm3"], 0.0);
  EXPECT_GT(next["seconds_touched"].get<double>(), 0.3);
  EXPECT_EQ(far["seconds_touched"], 0.0);
  // The ball's lowest point goes 0.35 mm below the top, to 2 mm behind the wall at x = 4: within the baked band.
  EXPECT_NEAR(summary["least_distance_mm"]["beside_1"].get<double>(), -0.35, 0.01);
  EXPECT_FALSE(summary["least_distance_mm"].contains("beside_2"));

  // The columns: the distance falls as the tool approaches, the severed volume grows, the ledger of the case stays
  // constant.
  std::istringstream rows(bytesOf(at("row.run/forces.csv")));
  std::string row, first, last;
  std::getline(rows, row);
  EXPECT_TRUE(row.ends_with(",beside_1_mm,beside_2_mm,beside_1_removed_mm3,beside_2_removed_mm3")) << row;
  while (std::getline(rows, row)) {
    first = first.empty() ? row : first;
    last = row;
  }
  const auto columns = [](const std::string& line) {
    std::vector<double> out;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) out.push_back(std::stod(cell));
    return out;
  };
  const std::vector<double> begin = columns(first), end = columns(last);
  ASSERT_EQ(end.size(), begin.size());
  const std::size_t n = begin.size();
  EXPECT_NEAR(begin[n - 4], 4 - 0.7, 0.12) << "0.7 mm of ball, half a voxel of 0.15 mm, sampling";
  EXPECT_EQ(begin[n - 3], 5);
  EXPECT_NEAR(end[n - 2], lost, 1e-8);
  EXPECT_EQ(end[n - 1], 0);
  EXPECT_NEAR(end[12], summary["removed_mm3"].get<double>(), 1e-8);

  const json again = parsed(runKerf({"replay", at("row.run"), "--json"}));
  EXPECT_TRUE(again["is_same"].get<bool>());
  EXPECT_NEAR(again["removed_mm3"].get<double>(), summary["removed_mm3"].get<double>() + lost, 1e-9);

  // The case's mesh and the neighbour's own, both exact. A message names the part missing from the first.
  const Outcome exported = runKerf({"export", at("row.run"), "-o", at("row.stl"), "--json"});
  EXPECT_NE(exported.err.find("--beside 1"), exported.err.npos) << exported.err;
  EXPECT_NEAR(parsed(exported)["removed_volume_mm3"].get<double>(), summary["removed_mm3"].get<double>(), 0.15);
  const json other = parsed(runKerf({"export", at("row.run"), "--beside", "1", "-o", at("next.stl"), "--json"}));
  EXPECT_NEAR(other["removed_volume_mm3"].get<double>(), lost, 0.1);
  EXPECT_EQ(other["source_vertices_removed"], 0);
  const json whole = parsed(runKerf({"export", at("row.run"), "--beside", "2", "-o", at("far.stl"), "--json"}));
  EXPECT_EQ(whole["removed_volume_mm3"], 0.0);
  EXPECT_EQ(runKerf({"check", at("row.stl")}).exit_code + runKerf({"check", at("next.stl")}).exit_code, 0);
  EXPECT_NE(runKerf({"info", at("row.run")}).out.find("../next.case"), std::string::npos);
  refuses({"export", at("row.run"), "--beside", "3", "-o", at("x.stl")}, {"beside_3", "1 to 2"});
  refuses({"export", at("box.case"), "--beside", "1", "-o", at("x.stl")}, {"beside_1", "--beside OTHER.case"});

  // A drive that starts deep in two objects at once would stall.
  folder_.write("across.toml",
                "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\n[start]\nposition = [0, 0, 0.5]\n"
                "axis = [0, 0, 1]\n[[stroke]]\nkind = \"line\"\nby = [0, 0, -0.7]\n");
  const Outcome both = cut("both.run", {"--beside", at("over.case")});
  EXPECT_NE(both.err.find("overlaps the case by about 8"), both.err.npos) << "4 x 5 x 4 mm3: " << both.err;

  const auto refused = [&](const std::vector<std::string>& more, const std::vector<std::string>& said, int code = 1) {
    std::vector<std::string> words{"cut",    at("box.case"),    "--tool", "round-014", "--drive", "electric",
                                   "--path", at("across.toml"), "--hand", "feed",      "-o",      at("x.run")};
    words.insert(words.end(), more.begin(), more.end());
    refuses(words, said, code);
  };
  std::filesystem::copy(at("box.case"), at("copy.case"), std::filesystem::copy_options::recursive);
  refused({"--beside", at("box.case")}, {"box.case", "--beside", "the same case"});
  refused({"--beside", at("copy.case")}, {"copy.case", "--beside", "the same case"});
  refused({"--beside", at("next.case"), "--beside", at("next.case")}, {"next.case", "the same case"});
  refused({"--beside", at("none.case")}, {"none.case", "not a case"});
  refuses({"cut", at("box.case"), "--tool", "round-014", "--path", at("across.toml"), "-o", at("x.run"), "--beside",
           at("next.case")},
          {"--beside", "--hand"}, 2);
  // A missing or different neighbour: no replay, and advice. The case's own mesh needs no neighbour.
  std::filesystem::rename(at("next.case"), at("gone.case"));
  refuses({"replay", at("row.run")}, {"beside_1", "no case at ../next.case", "move it back"});
  refuses({"export", at("row.run"), "--beside", "1", "-o", at("x.stl")}, {"beside_1", "../next.case"});
  EXPECT_EQ(runKerf({"export", at("row.run"), "-o", at("again.stl")}).exit_code, 0);
  EXPECT_TRUE(bytesOf(at("again.stl")) == bytesOf(at("row.stl")));
  std::filesystem::copy(at("far.case"), at("next.case"), std::filesystem::copy_options::recursive);
  refuses({"replay", at("row.run")}, {"beside_1", "case_id"});
}

// As recorded by a device: 20 000 poses of a groove of 4 mm.
TEST_F(Cli, APathOfManyRowsIsSweptAndMeasuredInFewMotionsAndPlannedAsItIsCut) {
  folder_.write("box.off", box());
  ASSERT_EQ(runKerf({"bake", at("box.off"), "--unit", "mm", "-o", at("box.case"), "--voxel", "0.1"}).exit_code, 0);
  constexpr int kRows = 20'000;
  std::string csv = "t,x,y,z,qw,qx,qy,qz\n0,-2,0,1,1,0,0,0\n";
  for (int n = 0; n < kRows; ++n) {
    const double s = n / (kRows - 1.0);
    csv += fmt::format("{:.4f},{:.6f},{:.6f},-0.5,1,0,0,0\n", 2 + 8 * s, 4 * s - 2, 0.3 * std::sin(6 * s));
  }
  folder_.write("recorded.csv", csv);
  const std::vector<std::string> words{"cut",    at("box.case"),     "--tool", "round-014",
                                       "--path", at("recorded.csv"), "--json", "-o"};
  const auto cut = [&](const std::string& run, const std::vector<std::string>& more) {
    std::vector<std::string> command = words;
    command.push_back(at(run));
    command.insert(command.end(), more.begin(), more.end());
    return parsed(runKerf(command));
  };
  const json made = cut("many.run", {});
  EXPECT_EQ(made["segments"], kRows);
  EXPECT_LT(made["swept_motions"].get<int>(), kRows / 50);
  EXPECT_GT(made["merged_motions"].get<int>(), kRows / 2);

  const Outcome exported = runKerf({"export", at("many.run"), "-o", at("many.stl"), "--json"});
  const json wall = parsed(exported)["wall"];
  EXPECT_GT(wall["vertices"].get<int>(), 200);
  EXPECT_LT(wall["max_mm"].get<double>(), 0.05);
  EXPECT_LT(exported.processor_seconds, 20) << "a vertex asks few of the motions";

  // The planned volume is counted along the same motions.
  const json planned = cut("hand.run", {"--hand", "feed", "--drive", "electric"});
  EXPECT_EQ(planned["planned_mm3"], made["removed_mm3"]);
}

// Memory addresses must not affect a mesh: other words on the command line, other settings of malloc.
TEST_F(Cli, AnExportIsTheSameBytesWhereverItsMeshesLieInMemory) {
  makeRun();
  std::string first;
  for (int n = 0; n < 16; ++n) {
    RunOptions options;
    if (n > 0) options.environment["MALLOC_MMAP_THRESHOLD_"] = std::to_string(700 * n);
    const std::string name = at(std::string(static_cast<std::size_t>(1 + n), 'm') + ".stl");
    std::vector<std::string> words{"export", at("box.run"), "-o", name};
    if (n % 2) words.emplace_back("--json");
    ASSERT_EQ(runKerf(words, options).exit_code, 0);
    if (first.empty()) first = bytesOf(name);
    EXPECT_TRUE(bytesOf(name) == first) << n;
  }
}

TEST_F(Cli, WhatIsAddedIsPartOfTheExportedSolidAndTheRestIsAsItWas) {
  ASSERT_EQ(runKerf({"demo", "molar", "--coarseness", "2", "-o", at("molar")}).exit_code, 0);
  ASSERT_EQ(runKerf({"bake", at("molar/molar.toml"), "--voxel", "0.2", "-o", at("molar.case")}).exit_code, 0);
  std::ofstream(at("ridge.toml")) << "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\nfeed = 4.0\n[start]\n"
                                     "position = [-2, 0, 4.6]\naxis = [0, 0, 1]\n[[stroke]]\nkind = \"line\"\n"
                                     "by = [4, 1, 0.3]\n";
  const auto put = [&](const std::string& run, const std::string& material) {
    return runKerf({"cut", at("molar.case"), "--tool", "round-023", "--path", at("ridge.toml"), "-o", at(run), "--hand",
                    "feed", "--add", material, "--json"});
  };
  const json added = parsed(put("ridge.run", "composite"));
  EXPECT_EQ(added["removed_mm3"], 0);
  EXPECT_GT(added["added_mm3"].get<double>(), 5);
  EXPECT_NEAR(added["initial_mm3"].get<double>() + added["added_mm3"].get<double>(),
              added["remaining_mm3"].get<double>(), 1e-6 * added["initial_mm3"].get<double>());
  EXPECT_GT(added["added_by_material_mm3"]["composite"].get<double>(), 5);
  EXPECT_TRUE(parsed(runKerf({"replay", at("ridge.run"), "--json"}))["is_same"].get<bool>());
  const json solid =
      parsed(runKerf({"export", at("ridge.run"), "-o", at("ridge.stl"), "-o", at("ridge.ply"), "--json"}));
  EXPECT_EQ(solid["pieces"], 1);
  EXPECT_NEAR(solid["removed_volume_mm3"].get<double>(), 0, 1e-3);
  // The mesh contains the material added by the step. The surface that it covers is exact to some tenths of a voxel.
  EXPECT_NEAR(solid["added_volume_mm3"].get<double>(), added["added_mm3"].get<double>(),
              0.03 * added["added_mm3"].get<double>());
  EXPECT_GT(solid["source_vertices_kept"].get<int>(), 9 * solid["source_vertices_removed"].get<int>());
  EXPECT_EQ(runKerf({"check", at("ridge.stl")}).exit_code, 0);
  const Outcome unknown = put("x.run", "amalgam");
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_NE(unknown.err.find("\"amalgam\""), unknown.err.npos) << unknown.err;
  EXPECT_FALSE(std::filesystem::exists(at("x.run")));
}

TEST_F(Cli, ACutInAFineRegionIsTheCutOfAnObjectBakedThatFine) {
  ASSERT_EQ(runKerf({"demo-molar", "--edge", "0.4", "-o", at("molar.ply")}).exit_code, 0);
  const std::string cavity = std::string(kSourceFolder) + "/assets/paths/demo-cavity.toml";
  const auto bake = [&](const std::string& name, std::vector<std::string> more) {
    more.insert(more.begin(), {"bake", at("molar.ply"), "-o", at(name + ".case"), "--json"});
    return parsed(runKerf(more));
  };
  const auto cut = [&](const std::string& name) {
    const json j = parsed(runKerf(
        {"cut", at(name + ".case"), "--tool", "round-014", "--path", cavity, "-o", at(name + ".run"), "--json"}));
    EXPECT_EQ(runKerf({"export", at(name + ".run"), "-o", at(name + ".stl")}).exit_code, 0);
    return j;
  };
  bake("fine", {"--voxel", "0.1"});
  bake("coarse", {"--voxel", "0.2"});
  const json region = bake("region", {"--voxel", "0.2", "--fine-along", cavity, "--fine-radius", "2"});
  EXPECT_EQ(region["region"]["voxel_mm"], 0.1) << "half of the object's";
  bake("narrow", {"--voxel", "0.2", "--fine-along", cavity, "--fine-radius", "0.8"});
  const json fine = cut("fine"), coarse = cut("coarse"), in_region = cut("region"), beyond = cut("narrow");
  EXPECT_EQ(in_region["state_hash"], fine["state_hash"]);
  EXPECT_EQ(in_region["voxel_mm"], 0.1);
  EXPECT_EQ(in_region["beyond_region_mm"], 0);
  EXPECT_TRUE(bytesOf(at("region.stl")) == bytesOf(at("fine.stl")));
  const Outcome by_hand = runKerf({"cut", at("region.case"), "--tool", "round-014", "--path", cavity, "-o",
                                   at("hand.run"), "--hand", "feed", "--time-limit", "3"});
  EXPECT_EQ(by_hand.exit_code, 0) << by_hand.err;
  EXPECT_NE(by_hand.err.find("does not use the case's fine region"), by_hand.err.npos) << by_hand.err;
  EXPECT_EQ(beyond["state_hash"], coarse["state_hash"]) << "not half on one grid, half on the other";
  EXPECT_GT(beyond["beyond_region_mm"], 0);
  EXPECT_TRUE(bytesOf(at("narrow.stl")) == bytesOf(at("coarse.stl")));
  refuses({"bake", at("molar.ply"), "-o", at("x.case"), "--fine-along", cavity, "--fine-voxel", "0.1"},
          {"fine region", "less than the object's", "0.05"});
  refuses({"bake", at("molar.ply"), "-o", at("x.case"), "--fine-radius", "2"}, {"--fine-along"}, 2);
  refuses({"bake", "--pair", at("molar.ply"), at("molar.ply"), "-o", at("x"), "--fine-along", cavity},
          {"--pair", "one by one"}, 2);
}

TEST_F(Cli, DemoMolarGoesFromMeshToPrint) {
  ASSERT_EQ(runKerf({"demo-molar", "--edge", "0.4", "-o", at("molar.ply")}).exit_code, 0);
  const json baked = parsed(runKerf({"bake", at("molar.ply"), "-o", at("molar.case"), "--voxel", "0.2", "--json"}));
  EXPECT_TRUE(baked["exact"]);
  EXPECT_EQ(baked["sources"][0]["unit"], "mm");
  const std::string cavity = std::string(kSourceFolder) + "/assets/paths/demo-cavity.toml";
  const json cut = parsed(
      runKerf({"cut", at("molar.case"), "--tool", "round-014", "--path", cavity, "-o", at("molar.run"), "--json"}));
  EXPECT_GT(cut["segments"], 0);
  std::vector<std::string> command{"export", at("molar.run"), "--json"}, files;
  for (const char* extension : {"stl", "ply", "obj", "off"}) {
    files.push_back(at(std::string("molar-cut.") + extension));
    command.insert(command.end(), {"-o", files.back()});
  }
  const json exported = parsed(runKerf(command));
  EXPECT_GT(exported["removed_volume_mm3"], 1);
  EXPECT_LT(exported["wall"]["max_mm"], 0.2);
  for (const std::string& file : files) {
    const json checked = parsed(runKerf({"check", file, "--json"}));
    EXPECT_TRUE(checked["print_ready"]) << file;
    EXPECT_NEAR(checked["volume_mm3"].get<double>(), exported["result_volume_mm3"].get<double>(), 1e-3) << file;
  }
  for (const auto& [what, kind] : std::map<std::string, std::string>{
           {at("molar.ply"), "mesh"}, {at("molar.case"), "case"}, {at("molar.run"), "run"}, {"round-014", "tool"}}) {
    EXPECT_EQ(parsed(runKerf({"info", what, "--json"}))["kind"], kind);
    const Outcome plain = runKerf({"info", what});
    EXPECT_EQ(plain.exit_code, 0);
    EXPECT_NE(plain.out.find(kind == "run" ? "planned " : "kind: " + kind), plain.out.npos);
  }
  const Outcome again = runKerf({"export", at("molar.case"), "-o", at("solid.stl")});
  EXPECT_EQ(again.exit_code, 0) << again.err;
}

TEST_F(Cli, ToolsAreListedCheckedAndBaked) {
  const json all = parsed(runKerf({"tool", "list", "--json"}));
  EXPECT_GE(all.size(), 90u);
  const json checked = parsed(runKerf({"tool", "check", "round-014", "--json"}));
  EXPECT_TRUE(checked[0]["passed"]);
  const Outcome baked = runKerf({"tool", "bake", "round-014", "-o", at("round.tool")});
  EXPECT_EQ(baked.exit_code, 0) << baked.err;
  for (const char* file : {"round.tool/tool.toml", "round.tool/tool.vdb", "round.tool/tool.ply"})
    EXPECT_GT(std::filesystem::file_size(in(file)), 0u) << file;
}

// CONTRIBUTING.md's promise: a new bur is one text file, and passes the full chain.
TEST_F(Cli, ANewBurIsOneTextFileFromDrawingToCut) {
  makeCase();
  folder_.write("bobbin.toml", R"(format = "kerf-tool"
version = 1
id = "bobbin"
name = "Bobbin"
kind = "bur"
shape = "profile"
head_diameter = 1.4
profile = [[0, 0.8], [0.3, 1.4, 0.3], [0.6, 1.4], [1.4, 1.4, -1.0], [1.8, 1.4]]
neck_diameter = 0.8
neck_length = 4.0
)");
  const json checked = parsed(runKerf({"tool", "check", at("bobbin.toml"), "--json"}));
  EXPECT_TRUE(checked[0]["passed"]) << checked[0];
  RunOptions mine;
  std::filesystem::create_directories(in("rack/tools"));
  std::filesystem::copy_file(in("bobbin.toml"), in("rack/tools/bobbin.toml"));
  mine.environment["KERF_ASSETS"] = at("rack");
  EXPECT_NE(runKerf({"tool", "list", "bobbin"}, mine).out.find("1.40 x 1.80"), std::string::npos);
  EXPECT_NE(runKerf({"tool", "info", "bobbin"}, mine).out.find("Bobbin"), std::string::npos);
  EXPECT_EQ(runKerf({"tool", "draw", "bobbin", "-o", at("bobbin.svg")}, mine).exit_code, 0);
  EXPECT_NE(contentOf(in("bobbin.svg")).find("⌀ 1.4"), std::string::npos);
  const json cut = parsed(runKerf(
      {"cut", at("box.case"), "--tool", "bobbin", "--path", at("groove.csv"), "-o", at("bobbin.run"), "--json"}, mine));
  EXPECT_EQ(cut["tool"], "bobbin");
  const json exported = parsed(runKerf({"export", at("bobbin.run"), "-o", at("bobbin.stl"), "--json"}));
  EXPECT_GT(exported["removed_volume_mm3"].get<double>(), 1.5);  // 4 mm of a groove 0.5 mm deep, 0.8 to 1.4 wide
  EXPECT_LT(exported["removed_volume_mm3"].get<double>(), 3.5);
}

TEST_F(Cli, ANewToolIsWrittenOnceAndPassesItsCheckAsItIs) {
  const Outcome made = runKerf({"tool", "new", "my-bur", "--shape", "taper_round", "-o", at("my-bur.toml")});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_TRUE(parsed(runKerf({"tool", "check", at("my-bur.toml"), "--json"}))[0]["passed"]);
  refuses({"tool", "new", "my-bur", "--shape", "taper_round", "-o", at("my-bur.toml")},
          {"exists already", "--overwrite"});
  refuses({"tool", "new", "my-bur", "--shape", "taper_ruond", "-o", at("my-bur.toml")}, {"Try: taper_round"}, 2);
  refuses({"tool", "new", "My Bur", "--shape", "round"}, {"lower-case"}, 2);
  refuses({"tool", "new", "my-bur", "--shape", "round", "-o", at("other.toml")}, {"my-bur.toml"}, 2);
  EXPECT_EQ(runKerf({"tool", "new", "my-bur", "--shape", "round", "-o", at("my-bur.toml"), "--force"}).exit_code, 0);
}

TEST_F(Cli, SeveralToolsAreCheckedInATable) {
  const Outcome table = runKerf({"tool", "check", "us-957", "saw-sagittal-6"});
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_NE(table.out.find("2 of 2 tools pass."), std::string::npos) << table.out;
  EXPECT_NE(runKerf({"tool", "info", "856-016"}).out.find("taper, round; medium grit, 107 um; head 1.6 mm"),
            std::string::npos);
}

// The full chain twice, then on one core: same id, same state, same exported bytes.
TEST_F(Cli, TheSameInputsGiveTheSameBytesOnAnyNumberOfThreads) {
  ASSERT_EQ(runKerf({"demo-molar", "--edge", "0.6", "-o", at("molar.stl")}).exit_code, 0);
  const std::string cavity = std::string(kSourceFolder) + "/assets/paths/demo-cavity.toml";
  std::map<std::string, std::string> first;
  for (int round = 0; round < 3; ++round) {
    RunOptions options;
    options.one_core = round == 2;
    const std::string n = std::to_string(round);
    std::map<std::string, std::string> found;
    found["id"] =
        parsed(runKerf({"bake", at("molar.stl"), "-o", at(n + ".case"), "--voxel", "0.2", "--json"}, options))["id"];
    found["state"] = parsed(
        runKerf({"cut", at(n + ".case"), "--tool", "round-014", "--path", cavity, "-o", at(n + ".run"), "--json"},
                options))["state_hash"];
    const Outcome o = runKerf({"export", at(n + ".run"), "-o", at(n + ".stl"), "-o", at(n + ".ply")}, options);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    found["solid"] = contentOf(in(n + ".case/solid.ply"));
    found["stl"] = contentOf(in(n + ".stl"));
    found["ply"] = contentOf(in(n + ".ply"));
    EXPECT_FALSE(found["stl"].empty());
    if (round == 0) first = found;
    for (const auto& [what, value] : found) EXPECT_TRUE(value == first[what]) << what << " differs in round " << round;
  }
}

TEST_F(Cli, CheckSaysWhyAMeshDoesNotPrint) {
  folder_.write("open.off", "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n");
  const Outcome plain = runKerf({"check", at("open.off")});
  EXPECT_EQ(plain.exit_code, 1);
  EXPECT_NE(plain.out.find("Not ready to print:\n  - "), plain.out.npos) << plain.out;
  const Outcome as_json = runKerf({"check", at("open.off"), "--json"});
  EXPECT_EQ(as_json.exit_code, 1);
  const json verdict = json::parse(as_json.out);
  EXPECT_FALSE(verdict["print_ready"]);
  EXPECT_FALSE(verdict["reasons"].empty());
}

TEST_F(Cli, FileNamesMayHoldAnyBytes) {
  const std::string odd = "caf\xe9\nx.off";  // Latin-1 and a line end
  folder_.write(odd, box());
  folder_.write("groove.csv", groove());
  const json baked =
      parsed(runKerf({"bake", at(odd), "--unit", "mm", "-o", at("odd.case"), "--voxel", "0.3", "--json"}));
  EXPECT_EQ(baked["sources"][0]["stored_as"], "source-1.off");
  EXPECT_EQ(runKerf({"info", at(odd), "--json"}).exit_code, 0);
  std::filesystem::rename(in("odd.case"), in("\xe9.case"));
  EXPECT_EQ(runKerf({"info", at("\xe9.case"), "--json"}).exit_code, 0);
  refuses({"cut", at("\xe9.case"), "--tool", "round-014", "--path", at("groove.csv"), "-o", at("x.run")}, {"UTF-8"});
  refuses({"check", at("no\nsuch\x1b[2J.stl")}, {"no such file"});
}

TEST_F(Cli, CasesAndRunsMoveTogetherAndThroughLinks) {
  makeRun();
  std::filesystem::create_directory(in("elsewhere"));
  std::filesystem::rename(in("box.case"), in("elsewhere/box.case"));
  std::filesystem::rename(in("box.run"), in("elsewhere/box.run"));
  std::filesystem::create_symlink("elsewhere/box.run", in("link.run"));
  for (const char* run : {"elsewhere/box.run", "elsewhere/box.run/", "link.run"}) {
    const Outcome o = runKerf({"export", at(run), "-o", at("out.stl"), "--overwrite"});
    EXPECT_EQ(o.exit_code, 0) << o.err;
  }
}

TEST_F(Cli, AVolumeWithoutSpacingIsDescribedAndSaysSo) {
  folder_.write("labels.nrrd", "NRRD0004\ntype: unsigned char\ndimension: 3\nsizes: 2 2 1\nencoding: raw\n\n" +
                                   std::string("\0\5\5\5", 4));
  const Outcome o = runKerf({"info", at("labels.nrrd"), "--json"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  const auto info = parsed(o);
  EXPECT_EQ(info["size"], nlohmann::json({2, 2, 1}));
  EXPECT_TRUE(info["spacing_mm"].is_null());
  EXPECT_EQ(info["labels"][1]["voxels"], 3);
  EXPECT_FALSE(info["labels"][1].contains("volume_mm3"));
  EXPECT_NE(info["notes"][0].get<std::string>().find("spacing"), std::string::npos);
}

TEST_F(Cli, ExportOfACaseSpeaksOfNoCut) {
  makeRun();
  const std::string plain = runKerf({"export", at("box.case"), "-o", at("a.stl")}).out;
  EXPECT_NE(plain.find("nothing cut: 8 vertices, 12 triangles"), std::string::npos) << plain;
  EXPECT_EQ(plain.find("removed"), std::string::npos) << plain;
  const std::string cut = runKerf({"export", at("box.run"), "-o", at("b.stl")}).out;
  EXPECT_NE(cut.find("vertices of the solid: "), std::string::npos) << cut;
}

}  // namespace
}  // namespace kerf::cli_test
