// kerf info RUN, kerf plot and kerf trim, run as a user does.
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/places.h"
#include "tests/ui/cli_runner.h"

namespace kerf::cli_run_info_test {
namespace {

using nlohmann::json;

class CliRunInfo : public Cli {
 protected:
  json parsed(const std::vector<std::string>& words) {
    const Outcome o = runKerf(words);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    const json j = json::parse(o.out, nullptr, false);
    EXPECT_FALSE(j.is_discarded()) << o.out;
    return j;
  }

  void bakeMolar() {
    ASSERT_EQ(runKerf({"demo", "molar", "--coarseness", "3", "-o", at("molar")}).exit_code, 0);
    ASSERT_EQ(runKerf({"bake", at("molar/molar.toml"), "--voxel", "0.2", "-o", at("molar.case")}).exit_code, 0);
  }

  json cut(const std::string& run, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{
        "cut",       at("molar.case"), "--tool",
        "round-014", "--path",         std::string(kSourceFolder) + "/assets/paths/demo-cavity.toml",
        "-o",        at(run),          "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return parsed(words);
  }

  static double sumOf(const json& volumes) {
    double sum = 0;
    for (const auto& [id, volume] : volumes.items()) sum += volume.get<double>();
    return sum;
  }
};

TEST_F(CliRunInfo, OfARunOfGeometrySaysTissuesSharesAndPlan) {
  bakeMolar();
  const json made = cut("plain.run");
  const json info = parsed({"info", at("plain.run"), "--json"});
  EXPECT_EQ(info["removed_by_material_mm3"], made["removed_by_material_mm3"]);
  EXPECT_NEAR(sumOf(info["removed_by_material_mm3"]), info["removed_mm3"].get<double>(), 1e-9);
  for (const auto& [id, volume] : info["removed_by_material_mm3"].items())
    EXPECT_NEAR(info["removed_share_by_material"][id].get<double>(),
                volume.get<double>() / info["loaded_by_material_mm3"][id].get<double>(), 1e-12)
        << id;
  EXPECT_EQ(info["removed_share_by_material"]["pulp"], 0.0);
  EXPECT_EQ(info["planned_mm3"], info["removed_mm3"]);
  EXPECT_EQ(info["reached_mm3"], info["removed_mm3"]);
  EXPECT_EQ(info["piece_count"], 1);
  EXPECT_GT(info["strokes"].get<int>(), 0);
  EXPECT_TRUE(info["time_s"].is_null());
  EXPECT_TRUE(info["peak_contact_force_N"].is_null());
  ASSERT_EQ(info["missing"].size(), 1u) << info["missing"];
  EXPECT_NE(info["missing"][0].get<std::string>().find("a geometry run"), std::string::npos);

  // The text output starts with the same data, followed by the composition of the run.
  const Outcome plain = runKerf({"info", at("plain.run")});
  EXPECT_EQ(plain.out.find("removed "), 0u) << plain.out;
  EXPECT_NE(plain.out.find("enamel"), plain.out.npos);
  EXPECT_NE(plain.out.find("not known: force"), plain.out.npos) << plain.out;
  EXPECT_LT(plain.out.find("tools: round-014"), plain.out.find("state_hash:")) << plain.out;

  // An edited summary is not reported as the run's: the error comes first. An older run has no hash of its summary.
  EXPECT_EQ(info["summary_is_edited"], false);
  const std::string summary = contentOf(at("plain.run/summary.json"));
  json doubled = json::parse(summary);
  doubled["removed_mm3"] = 2 * doubled["removed_mm3"].get<double>();
  folder_.write("plain.run/summary.json", doubled.dump());
  EXPECT_EQ(parsed({"info", at("plain.run"), "--json"})["summary_is_edited"], true);
  EXPECT_EQ(runKerf({"info", at("plain.run")}).out.find("EDITED since it was written: summary.json"), 0u);
  const std::string manifest = contentOf(at("plain.run/run.toml"));
  const std::size_t line = manifest.find("\nsummary_sha256 = ");
  ASSERT_NE(line, manifest.npos) << manifest;
  folder_.write("plain.run/run.toml", std::string(manifest).erase(line, manifest.find('\n', line + 1) - line));
  EXPECT_TRUE(parsed({"info", at("plain.run"), "--json"})["summary_is_edited"].is_null());
  EXPECT_EQ(runKerf({"info", at("plain.run")}).out.find("removed "), 0u);
  folder_.write("plain.run/run.toml", manifest);
  folder_.write("plain.run/summary.json", summary);

  // Without its summary, as in older runs, the volume comes from the field: the same result.
  std::filesystem::remove(at("plain.run/summary.json"));
  const json counted = parsed({"info", at("plain.run"), "--json"});
  EXPECT_EQ(counted["removed_by_material_mm3"], info["removed_by_material_mm3"]);
  // With neither summary nor case, kerf info reports this and the remaining data.
  std::filesystem::rename(at("molar.case"), at("elsewhere.case"));
  const json alone = parsed({"info", at("plain.run"), "--json"});
  EXPECT_TRUE(alone["removed_mm3"].is_null());
  EXPECT_NE(alone["missing"].dump().find("removed volume by tissue"), std::string::npos) << alone["missing"];
  EXPECT_EQ(alone["tools"], json({"round-014"}));

  std::ofstream(at("plain.run/summary.json")) << "{\"removed_mm3\": \"much\"}";
  refuses({"info", at("plain.run")}, {"summary.json", "removed_mm3"});
  // Values out of range for any cut are rejected; a volume below zero by a share of a voxel is accepted.
  for (const auto& [lie, words] : std::vector<std::pair<std::string, std::string>>{
           {"{\"removed_mm3\": -5e300}", "key removed_mm3: -5e+300"},
           {"{\"removed_mm3\": 1e13}", "key removed_mm3: 1e+13"},
           {"{\"removed_by_material_mm3\": {\"generic\": -1e300}}", "key removed_by_material_mm3, generic: -1e+300"},
           {"{\"peak_contact_force_N\": -1}", "key peak_contact_force_N: -1"},
           {"{\"hottest_C\": 40, \"hottest_at_s\": 1e300}", "key hottest_at_s: 1e+300"},
           {"{\"planned_mm3\": 1, \"farthest_off_at\": [0, 1e300, 0]}", "key farthest_off_at: 1e+300"},
           {"{\"pieces\": -2}", "key pieces: -2"},
           {"{\"pieces\": 1.5}", "key pieces: 1.5; expected a whole number"}}) {
    std::ofstream(at("plain.run/summary.json")) << lie;
    refuses({"info", at("plain.run")}, {"summary.json", words});
  }
  std::ofstream(at("plain.run/summary.json"))
      << "{\"removed_mm3\": 2, \"removed_by_material_mm3\": {\"enamel\": 2.05, \"dentin\": -0.05}}";
  EXPECT_EQ(parsed({"info", at("plain.run"), "--json"})["removed_by_material_mm3"]["dentin"], -0.05);
  refuses({"info", at("elsewhere.case"), "--replay"}, {"--replay"}, 2);
  refuses({"plot", at("plain.run"), "-o", at("x.svg")}, {"a geometry run"});
}

TEST_F(CliRunInfo, OfARunAgainstResistanceSaysWhenAndWhere) {
  bakeMolar();
  const json made = cut("push.run", {"--hand", "force", "--push", "1.5", "--time-limit", "20"});
  const json info = parsed({"info", at("push.run"), "--json"});
  EXPECT_EQ(info["removed_by_material_mm3"], made["removed_by_material_mm3"]);
  EXPECT_EQ(info["peak_contact_force_N"], made["peak_contact_force_N"]);
  EXPECT_EQ(info["farthest_off_at_mm"], made["farthest_off_at"]);
  EXPECT_EQ(info["missing"], json::array());
  // The settings of the cut: a comparison of two runs needs them.
  const json& with = info["settings"];
  EXPECT_EQ(with["hand"], "force");
  EXPECT_EQ(with["push_N"], 1.5);
  EXPECT_EQ(with["feed_limit_mm_per_s"], 20.0);
  EXPECT_EQ(with["response"], "penalty");
  EXPECT_EQ(with["irrigation"], 1.0);
  EXPECT_EQ(with["is_reversed"], false);
  EXPECT_NE(with["drive"].get<std::string>().find("turbine"), std::string::npos) << with;
  const std::string told = runKerf({"info", at("push.run")}).out;
  EXPECT_NE(told.find("held by a force hand, 1.5 N, at most 20 mm/s; turbine"), told.npos) << told;
  EXPECT_TRUE(info["bone_limit_at_s"].is_null()) << "never is null, not -1";

  // At the stated times, force, temperature and distance had the stated values.
  std::ifstream rows(at("push.run/forces.csv"));
  std::string row;
  std::getline(rows, row);
  std::vector<std::string> names;
  std::istringstream header(row);
  for (std::string name; std::getline(header, name, ',');) names.push_back(name);
  std::map<int, std::map<std::string, double>> by_ms;
  while (std::getline(rows, row)) {
    std::istringstream values(row);
    std::map<std::string, double> of;
    for (const std::string& name : names) {
      std::string value;
      std::getline(values, value, ',');
      of[name] = std::stod(value);
    }
    by_ms[static_cast<int>(std::lround(1000 * of["t_s"]))] = of;
  }
  const auto at_s = [&](const char* key) {
    return by_ms.at(static_cast<int>(std::lround(1000 * info[key].get<double>())));
  };
  auto then = at_s("peak_contact_force_at_s");
  EXPECT_NEAR(std::hypot(then["contact_x_N"], then["contact_y_N"], then["contact_z_N"]),
              info["peak_contact_force_N"].get<double>(), 1e-5);
  EXPECT_NEAR(at_s("hottest_at_s")["temperature_C"], info["hottest_C"].get<double>(), 1e-3);
  const double nearest_s = info["least_distance_at_s"]["pulp"];
  EXPECT_NEAR(by_ms.at(static_cast<int>(std::lround(1000 * nearest_s)))["pulp_mm"],
              info["least_distance_mm"]["pulp"].get<double>(), 1e-4);

  // A summary of an older version has no times; the table has them.
  json older = json::parse(contentOf(at("push.run/summary.json")));
  for (const char* key : {"peak_contact_force_at_s", "hottest_at_s", "least_distance_at_s"}) older.erase(key);
  older["bone_limit_at_s"] = -1;
  std::ofstream(at("push.run/summary.json")) << older;
  const json again = parsed({"info", at("push.run"), "--json"});
  EXPECT_NEAR(again["peak_contact_force_at_s"].get<double>(), info["peak_contact_force_at_s"].get<double>(), 1e-4);
  // To the precision of the table, the distance was equally small once before.
  const double again_s = again["least_distance_at_s"]["pulp"];
  EXPECT_NEAR(by_ms.at(static_cast<int>(std::lround(1000 * again_s)))["pulp_mm"],
              info["least_distance_mm"]["pulp"].get<double>(), 1.1e-4);
  EXPECT_TRUE(again["bone_limit_at_s"].is_null());

  // A chart from the table, or without a table from the log, with the same marks.
  const auto plot = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"plot", at("push.run"), "-o", at("chart.svg"), "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome o = runKerf(words);
    EXPECT_EQ(o.exit_code, 0) << o.err;
    return contentOf(at("chart.svg"));
  };
  const std::string chart = plot({});
  refuses({"plot", at("push.run"), "-o", at("chart.svg")}, {"chart.svg", "exists already", "--overwrite"});
  for (const char* words : {"force [N]", "load of the drive [N mm]", "speed of the drive [rpm]", "removed [mm\u00b3]",
                            "temperature under the tool", "to pulp", "time [s]", "stroke ("})
    EXPECT_NE(chart.find(words), chart.npos) << words;
  const std::string peak = fmt::format("{:.3g} N at {:.2f} s", info["peak_contact_force_N"].get<double>(),
                                       info["peak_contact_force_at_s"].get<double>());
  EXPECT_NE(chart.find(peak), chart.npos) << peak;
  EXPECT_LT(chart.size(), 300'000u);

  const std::string part = plot({"--show", "force,distance", "--from", "1", "--until", "2.5"});
  EXPECT_EQ(part.find("removed [mm"), part.npos);
  EXPECT_NE(part.find("to pulp"), part.npos);
  std::filesystem::remove(at("push.run/forces.csv"));
  const std::string replayed = plot({});
  EXPECT_NE(replayed.find("session.kerflog, replayed"), replayed.npos);
  EXPECT_NE(replayed.find(peak), replayed.npos);

  refuses({"plot", at("push.run"), "-o", at("x.png")}, {".svg"}, 2);
  refuses({"plot", at("push.run"), "--from", "900", "-o", at("x.svg")}, {"--from"});
  refuses({"plot", at("push.run"), "--show", "colour", "-o", at("x.svg")}, {"--show"}, 2);
  std::ofstream(at("push.run/forces.csv")) << "t_s,x\n1,2\n";
  refuses({"plot", at("push.run"), "-o", at("x.svg")}, {"forces.csv", "line 1"});
}

// Spacing cannot repair a damaged picture.
TEST_F(CliRunInfo, OfAFolderOfSlicesNamesTheOneThatIsDamagedOrCut) {
  // 4 x 3 pixels, grey, 8 bits: 0 to 11.
  const std::string png(
      "\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\0\x04\0\0\0\x03\x08\0\0\0\0\x91\x9f\xf1\x1a\0\0\0\x17IDAT\x78\xda\x63"
      "\x60\x60\x64\x62\x66\x60\x61\x65\x63\x67\xe0\xe0\xe4\xe2\x06\0\x01\x4f\0\x43\x16\x6c\x4f\x8e\0\0\0\0IEND"
      "\xae\x42\x60\x82",
      80);
  std::filesystem::create_directory(at("slices"));
  folder_.write("slices/a.png", png);
  folder_.write("slices/b.png", png);
  EXPECT_EQ(parsed({"info", at("slices"), "--json"})["labels"].size(), 12u);

  // libpng's own message about an empty colour profile is suppressed.
  std::string profiled = png;
  profiled.insert(33, std::string("\x00\x00\x00\x03\x69\x43\x43\x50\x78\x00\x00\x84\x32\xba\x59", 15));
  folder_.write("slices/b.png", profiled);
  const Outcome warned = runKerf({"info", at("slices")});
  EXPECT_EQ(warned.exit_code, 0) << warned.err;
  EXPECT_EQ(warned.err, "");

  std::string damaged = png;
  damaged[50] = static_cast<char>(damaged[50] ^ 0x10);
  for (const std::string& bytes : {damaged, png.substr(0, 55)}) {
    folder_.write("slices/b.png", bytes);
    refuses({"info", at("slices")}, {"b.png"});
  }
}

// refuses() expects {"error": {...}} on standard output if --json is given.
TEST_F(CliRunInfo, AWrongCommandLineIsAnsweredInJsonTooAndWithTheNearestOption) {
  refuses({"info", "--json"}, {"PATH is required"}, 2);
  refuses({"info", at("x.run"), "--json", "--bogus"}, {"--bogus: no such option of kerf info"}, 2);
  refuses({"bake", "--json", at("x.stl"), "--bogus"}, {"--bogus: no such option of kerf bake"}, 2);
  refuses({"plot", at("x.run"), "-o", at("x.svg"), "--untill", "3"},
          {"--untill: no such option of kerf plot (did you mean --until?)"}, 2);
  refuses({"plot", at("x.run"), "--ouput=x.svg"}, {"--ouput: no such option of kerf plot (did you mean --output?)"}, 2);
  refuses({"info", at("x.run"), "another"}, {"another: one word too many"}, 2);

  // Numbers: the message has the error in words, without all digits of the largest number.
  refuses({"bake", "--json", at("x.stl"), "-o", at("y"), "--voxel", "7"},
          {"--voxel: 7; expected a number from 0.005 to 5"}, 2);
  refuses({"bake", at("x.stl"), "-o", at("y"), "--drop-specks", "x"},
          {"--drop-specks: x; expected a number of 0 or more"}, 2);
  refuses({"bake", at("x.stl"), "-o", at("y"), "--fill-holes-up-to", "-1"},
          {"--fill-holes-up-to: -1; expected a number above 0"}, 2);
  refuses({"cut", at("x.case"), "--tool", "a", "--path", "b", "-o", at("y"), "--time-limit", "x"},
          {"--time-limit: x; expected a number"}, 2);
  refuses({"export", at("x.run"), "-o", at("y.stl"), "--beside", "1.5"}, {"--beside: 1.5; expected a whole number"}, 2);
  refuses({"bake", at("x.stl"), "-o", at("y"), "--voxel", std::string(100'000, 'x')}, {"a number from 0.005 to 5"}, 2);

  const json j = json::parse(runKerf({"info", at("x.run"), "--json", "--reply"}).out, nullptr, false);
  ASSERT_TRUE(j.is_object()) << j;
  EXPECT_EQ(j["error"]["place"], "--reply");
  EXPECT_EQ(j["error"]["code"], "bad_value");
  EXPECT_NE(j["error"]["message"].get<std::string>().find("--replay"), std::string::npos) << j;
  EXPECT_EQ(j["error"]["hint"], "kerf info --help");
}

// During the check of a sheet, no code polls for cancellation: an alarm ends the program (ui/cli/terminal.cpp). Code
// that does poll cancels, and gets two seconds for it.
TEST_F(CliRunInfo, SigtermEndsWorkThatDoesNotLookUpWithinASecondOrTwo) {
  constexpr double kAllowed = 1 + 2, kBusy = 17;  // s; a machine with much other load
  constexpr int kAlong = 700;                     // a sheet of 0.98 M triangles: some seconds to read and check
  std::string off = fmt::format("OFF\n{} {} 0\n", kAlong * kAlong, 2 * (kAlong - 1) * (kAlong - 1));
  for (int i = 0; i < kAlong; ++i)
    for (int j = 0; j < kAlong; ++j)
      off += fmt::format("{:.4f} {:.4f} {:.3f}\n", 0.05 * i, 0.05 * j, 0.01 * (i * j % 5));
  for (int i = 0; i + 1 < kAlong; ++i)
    for (int j = 0; j + 1 < kAlong; ++j) {
      const int at = i * kAlong + j;
      off += fmt::format("3 {} {} {}\n3 {} {} {}\n", at, at + kAlong, at + 1, at + 1, at + kAlong, at + kAlong + 1);
    }
  folder_.write("sheet.off", off);

  for (const int signal : {SIGTERM, SIGHUP}) {
    RunOptions options;
    options.signal = signal;
    options.signal_after = 1;
    const Outcome o = runKerf({"bake", at("sheet.off"), "-o", at("x.case"), "--voxel", "0.4"}, options);
    const bool is_ended = o.exit_code == 128 + signal;
    EXPECT_GT(o.seconds_after_signal, 0) << "it was done before the signal: choose a larger sheet";
    EXPECT_LT(o.seconds_after_signal, kAllowed + kBusy);
    EXPECT_EQ(o.signal, 0);
    EXPECT_TRUE(is_ended || o.err.find("cancelled") != o.err.npos) << o.exit_code << o.err;
    EXPECT_FALSE(std::filesystem::exists(at("x.case")));
  }
}

TEST_F(CliRunInfo, TrimWritesBothSidesOrOneAndTheFileStaysAsItWas) {
  folder_.write("box.off", box());
  const json j = parsed({"trim", at("box.off"), "--plane", "0,0,1@0,0,-1", "-o", at("out.stl"), "--json"});
  EXPECT_EQ(j["files"], json({at("out-above.stl"), at("out-below.stl")}));
  EXPECT_NEAR(j["parts"][0]["volume_mm3"].get<double>(), 30, 1e-4);
  EXPECT_NEAR(j["parts"][1]["volume_mm3"].get<double>(), 90, 1e-4);
  for (const char* name : {"out-above.stl", "out-below.stl"})
    EXPECT_EQ(runKerf({"check", at(name)}).exit_code, 0) << name;

  // The same plane by three points. A single side gets the requested name.
  const json three = parsed({"trim", at("box.off"), "--plane", "0,0,-1/3,0,-1/0,3,-1", "--keep", "below", "-o",
                             at("low.ply"), "-o", at("low.stl"), "--json"});
  EXPECT_EQ(three["files"], json({at("low.ply"), at("low.stl")}));
  EXPECT_NEAR(parsed({"check", at("low.ply"), "--json"})["volume_mm3"].get<double>(), 90, 1e-4);

  const json die = parsed({"trim", at("box.off"), "--between", "-1,0,-2/1,0,-2", "-o", at("t.stl"), "--json"});
  EXPECT_EQ(die["files"], json({at("t-die.stl"), at("t-rest.stl")}));
  EXPECT_NEAR(die["parts"][0]["volume_mm3"].get<double>(), 40, 1e-4);
  EXPECT_EQ(die["parts"][1]["pieces"], 2);
  const json corner =
      parsed({"trim", at("box.off"), "--box", "1,1,-2/9,9,9", "--keep", "die", "-o", at("c.stl"), "--json"});
  EXPECT_NEAR(corner["parts"][0]["volume_mm3"].get<double>(), 6, 1e-4);

  // The plane x = 1 of 3D Slicer, in both frames; the side above is a fifth or a third of the box, by the frame.
  const std::string slicer = R"({"markups": [{"type": "Line"}, {"type": "Plane", "coordinateSystem": "LPS",
    "center": [1, 0, -2], "normal": [1, 0, 0]}]})";
  folder_.write("lps.mrk.json", slicer);
  folder_.write("ras.mrk.json", std::string(slicer).replace(slicer.find("LPS"), 3, "RAS"));
  const double whole = 120;
  const json lps = parsed({"trim", at("box.off"), "--plan", at("lps.mrk.json"), "-o", at("s.stl"), "--json"});
  const json ras = parsed({"trim", at("box.off"), "--plan", at("ras.mrk.json"), "-o", at("r.stl"), "--json"});
  const double above = lps["parts"][0]["volume_mm3"].get<double>();
  EXPECT_GT(above, 0.1 * whole);
  EXPECT_LT(above, 0.45 * whole);
  EXPECT_NEAR(ras["parts"][0]["volume_mm3"].get<double>(), above, 1e-4) << "the box is the same on both sides of x = 0";
  EXPECT_EQ(ras["planes"][0]["normal"], json({-1, 0, 0}));
  EXPECT_TRUE(
      lps["note"].get<std::string>().ends_with("1 plane of 3D Slicer in LPS: as written; left out 1 other markup"))
      << lps["note"];
  EXPECT_NE(ras["note"].get<std::string>().find("1 plane of 3D Slicer in RAS: x and y of RAS negated, to LPS"),
            std::string::npos);
  folder_.write("ras.off", "OFF\n# SPACE=RAS\n" + box().substr(4));
  refuses({"trim", at("ras.off"), "--plan", at("lps.mrk.json"), "-o", at("x.stl")}, {"ras.off", "SPACE=RAS", "in LPS"});
  folder_.write("bad.mrk.json", R"({"markups": [{"type": "Plane", "center": [1, 0], "normal": [1, 0, 0]}]})");
  refuses({"trim", at("box.off"), "--plan", at("bad.mrk.json"), "-o", at("x.stl")},
          {"bad.mrk.json", "markups[0].center", "a list of 2 items", "3 numbers"});

  refuses({"trim", at("box.off"), "--plane", "0,0,1@0,0,50", "-o", at("x.stl")},
          {"box.off", "nothing", "above plane 1"});
  refuses({"trim", at("box.off"), "--plane", "0,0,1", "-o", at("x.stl")}, {"--plane", "0,0,1@0,0,12"}, 2);
  refuses({"trim", at("box.off"), "--plane", "0,0,0/1,0,0/2,0,0", "-o", at("x.stl")}, {"on a line"});
  refuses({"trim", at("box.off"), "--plane", "occlusal@-3", "-o", at("x.stl")}, {"--plane", "occlusal"});
  refuses({"trim", at("box.off"), "-o", at("x.stl")}, {"nothing to cut along"}, 2);
  refuses({"trim", at("box.off"), "--plane", "0,0,1@0,0,-1", "--keep", "above", "-o", at("box.off")},
          {"never overwrites a scan"});
  folder_.write("open.off", "OFF\n3 1 0\n0 0 0\n9 0 0\n0 9 0\n3 0 1 2\n");
  refuses({"trim", at("open.off"), "--plane", "0,0,1@0,0,0", "-o", at("x.stl")}, {"open.off", "kerf bake"});
}

TEST_F(CliRunInfo, ExportWritesEachPieceOfACutThatSevered) {
  folder_.write("box.off", box());
  ASSERT_EQ(runKerf({"bake", at("box.off"), "--voxel", "0.2", "-o", at("bar.case")}).exit_code, 0);
  // A ball of 1.4 mm passes through the whole height, from one side of the box to the other.
  std::string path = "t,x,y,z,qw,qx,qy,qz\n";
  double t = 0;
  for (double z = -0.2; z > -6; z -= 0.5) {
    path += fmt::format("{},1,-4,{},1,0,0,0\n", t, z);
    path += fmt::format("{},1,4,{},1,0,0,0\n", t + 2, z);
    t += 4;
  }
  folder_.write("saw.csv", path);
  ASSERT_EQ(
      runKerf({"cut", at("bar.case"), "--tool", "round-014", "--path", at("saw.csv"), "-o", at("two.run")}).exit_code,
      0);
  EXPECT_EQ(parsed({"info", at("two.run"), "--json"})["piece_count"], 2);
  std::filesystem::create_directory(at("pieces"));
  const json all = parsed({"export", at("two.run"), "--piece", "all", "-o", at("pieces/bar.stl"), "--json"});
  EXPECT_EQ(all["files"], json({at("pieces/bar-piece-1.stl"), at("pieces/bar-piece-2.stl")}));
  const auto volume = [&](const std::string& file) {
    return parsed({"check", file, "--json"})["volume_mm3"].get<double>();
  };
  const double large = volume(at("pieces/bar-piece-1.stl")), small = volume(at("pieces/bar-piece-2.stl"));
  EXPECT_GT(large, small);
  EXPECT_NEAR(large + small, all["result_volume_mm3"].get<double>(), 1e-2);
  parsed({"export", at("two.run"), "--piece", "2", "-o", at("small.stl"), "--json"});
  EXPECT_NEAR(volume(at("small.stl")), small, 1e-9);
  refuses({"export", at("two.run"), "--piece", "3", "-o", at("x.stl")}, {"--piece", "piece 1"});
}

}  // namespace
}  // namespace kerf::cli_run_info_test
