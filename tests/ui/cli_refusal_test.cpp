// Errors of kerf: every bad input gives one line with the name of the file, exit code 1, and leaves nothing behind.
#include <sys/stat.h>

#include <cstdio>
#include <random>
#include <sstream>

#include "tests/support/places.h"
#include "tests/ui/cli_runner.h"

namespace kerf::cli_refusal_test {
namespace {

namespace fs = std::filesystem;

std::string randomBytes(std::size_t count) {
  std::mt19937 random(7);
  std::string bytes(count, '\0');
  for (char& c : bytes) c = static_cast<char>(random());
  return bytes;
}

std::string binaryStl(std::uint32_t claimed, std::size_t present) {
  std::string bytes(80, 'b');
  bytes.append(reinterpret_cast<const char*>(&claimed), 4);
  for (std::size_t t = 0; t < present; ++t) {
    const float numbers[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, static_cast<float>(t)};
    bytes.append(reinterpret_cast<const char*>(numbers), sizeof numbers).append(2, '\0');
  }
  return bytes;
}

TEST_F(Cli, MalformedMeshesAreRefusedByEveryCommandThatReadsOne) {
  const std::string nan_stl =
      "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
      "endsolid x\n";
  const std::map<std::string, std::string> meshes{
      {"empty.stl", ""},
      {"cut-short.stl", binaryStl(100, 12)},
      {"huge-count.stl", binaryStl(0xfffffff0u, 12)},
      {"no-faces.stl", binaryStl(0, 0)},
      {"nan.stl", nan_stl},
      {"huge-count.ply",
       "ply\nformat ascii 1.0\nelement vertex 18446744073709551615\nproperty float x\nproperty float "
       "y\nproperty float z\nelement face 9999999999\nproperty list uchar int vertex_indices\n"
       "end_header\n0 0 0\n"},
      {"no-faces.ply",
       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
       "z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n"},
      {"header-only.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 3\n"},
      {"huge-count.off", "OFF\n2000000000 2000000000 0\n0 0 0\n"},
      {"bad-index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"},
      {"bad-index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n"},
      {"no-faces.obj", "v 0 0 0\n"},
      {"noise.stl", randomBytes(4000)},
      {"noise.ply", "ply\n" + randomBytes(4000)},
      {"words.xyz", "this is no mesh\n"},
  };
  for (const auto& [name, content] : meshes) {
    folder_.write(name, content);
    refuses({"bake", at(name), "-o", at("x.case")}, {name});
    refuses({"check", at(name)}, {name});
    refuses({"info", at(name), "--json"}, {name});
  }
}

TEST_F(Cli, MissingFilesFoldersAndDevicesAreRefused) {
  makeRun();
  fs::create_directory(in("folder.stl"));
  ASSERT_EQ(::mkfifo(at("pipe.toml").c_str(), 0600), 0);
  for (const std::string command : {"bake", "check", "info"}) {
    std::vector<std::string> words{command, at("missing.stl")};
    if (command == "bake") words.insert(words.end(), {"-o", at("x.case")});
    refuses(words, {"missing.stl", "no such file"});
    words[1] = at("folder.stl");
    refuses(words, {"folder.stl"});
    words[1] = "/dev/zero";
    refuses(words, {"/dev/zero"});
  }
  const std::string tool = "round-014", path = at("groove.csv"), box = at("box.case");
  refuses({"cut", at("missing.case"), "--tool", tool, "--path", path, "-o", at("x.run")}, {"missing.case"});
  refuses({"cut", at("folder.stl"), "--tool", tool, "--path", path, "-o", at("x.run")}, {"folder.stl", "case.toml"});
  refuses({"cut", box, "--tool", at("missing.toml"), "--path", path, "-o", at("x.run")}, {"missing.toml"});
  refuses({"cut", box, "--tool", at("folder.stl"), "--path", path, "-o", at("x.run")}, {"folder.stl"});
  refuses({"cut", box, "--tool", tool, "--path", at("missing.csv"), "-o", at("x.run")}, {"missing.csv"});
  refuses({"cut", box, "--tool", tool, "--path", at("folder.stl"), "-o", at("x.run")}, {"folder.stl"});
  refuses({"cut", box, "--tool", tool, "--path", at("pipe.toml"), "-o", at("x.run")}, {"pipe.toml"});
  refuses({"cut", box, "--tool", "drill", "--path", path, "-o", at("x.run")}, {"drill", "drill-20", "kerf tool list"});
  refuses({"tool", "check", "drill"}, {"drill", "drill-20"});
  refuses({"tool", "check"}, {"--all"}, 2);
  refuses({"tool", "info", "drill"}, {"drill", "drill-20"});
  refuses({"tool", "bake", "drill", "-o", at("x.tool")}, {"drill", "drill-20"});
  refuses({"info", "drill"}, {"drill"});
  refuses({"export", at("missing.run"), "-o", at("x.stl")}, {"missing.run"});
  const auto at_box = [&](const std::string& name) { return "kerf bake " + at("box.off") + " -o " + at(name); };
  refuses({"cut", at("box.off"), "--tool", tool, "--path", path, "-o", at("x.run")}, {at_box("box.case")});
  refuses({"export", at("folder.stl"), "-o", at("x.stl")}, {"folder.stl"});
}

// It has no writer: a program that opens it waits for ever.
TEST_F(Cli, ARunWithAPipeInPlaceOfAFileDoesNotHang) {
  makeCase();
  const std::vector<std::string> cut{"cut", "CASE", "--tool", "round-014", "--path", at("down.csv"), "-o", "RUN"};
  folder_.write("down.csv", "t,x,y,z,qw,qx,qy,qz\n0,0,0,0.2,1,0,0,0\n1,0,0,-0.3,1,0,0,0\n");
  const auto of = [&](std::vector<std::string> words, const std::string& from, const std::string& to) {
    words[1] = at(from);
    words.back() = at(to);
    words.insert(words.end(), {"--hand", "feed"});
    return words;
  };
  const Outcome by_hand = runKerf(of(cut, "box.case", "hand.run"));
  ASSERT_EQ(by_hand.exit_code, 0) << by_hand.err;

  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(in("hand.run"))) {
    const std::string name = entry.path().filename();
    SCOPED_TRACE(name);
    fs::remove_all(in("piped.run"));
    fs::copy(in("hand.run"), in("piped.run"), fs::copy_options::recursive);
    fs::remove(in("piped.run") / name);
    ASSERT_EQ(::mkfifo((in("piped.run") / name).c_str(), 0600), 0);
    for (const auto& words : {std::vector<std::string>{"info", at("piped.run")},
                              {"export", at("piped.run"), "-o", at("x.stl"), "--overwrite"},
                              {"plot", at("piped.run"), "-o", at("x.svg"), "--overwrite"},
                              {"replay", at("piped.run")},
                              of(cut, "piped.run", "x.run")}) {
      const Outcome o = runKerf(words);
      EXPECT_EQ(o.signal, 0) << words[0] << ": " << o.err;
      fs::remove_all(in("x.run"));
    }
    ++files;
  }
  EXPECT_GE(files, 5u);
}

// A misspelt variable would silently select the default tools and materials.
TEST_F(Cli, AFolderOfAssetsThatIsNoneIsRefused) {
  folder_.write("box.off", box());
  fs::create_directories(in("empty"));
  fs::create_directories(in("mine/tools"));
  const auto with = [&](const std::string& folder) {
    RunOptions options;
    options.environment["KERF_ASSETS"] = folder;
    return options;
  };
  refuses({"check", at("box.off")}, {"missing: KERF_ASSETS: no such folder", "tools/, paths/ or materials.toml"}, 1,
          with(at("missing")));
  refuses({"tool", "list", "--json"}, {"empty: KERF_ASSETS: a folder without assets", "unset KERF_ASSETS"}, 1,
          with(at("empty")));
  EXPECT_EQ(runKerf({"tool", "--help"}, with(at("missing"))).exit_code, 0);
  EXPECT_EQ(runKerf({"check", at("box.off")}, with(at("mine"))).exit_code, 0);
}

TEST_F(Cli, WhatIsNoMeshIsCalledByItsName) {
  makeCase();
  refuses({"bake", at("box.case"), "-o", at("x.case")}, {"a case already, baked from source-1.off"});
  for (const std::string name : {"a.nii.gz", "a.nii", "a.nrrd", "a.mha", "a.mhd"}) {
    folder_.write(name, name == "a.nii.gz" ? "\x1f\x8b and more" : "NRRD0004 or another");
    refuses({"bake", at(name), "-o", at("x.case")}, {name, "label volume", "docs/reference/recipes.md"});
  }
  folder_.write("slice.dcm", std::string(128, '\0') + "DICM and more");
  refuses({"bake", at("slice.dcm"), "-o", at("x.case")}, {"slice.dcm", "docs/reference/recipes.md"});
  fs::create_directory(in("series"));
  fs::copy_file(in("slice.dcm"), in("series/1.dcm"));
  refuses({"bake", at("series"), "-o", at("x.case")}, {"series", "label volume", "docs/reference/recipes.md"});
}

TEST_F(Cli, ARenamedToolHearsOfItsOtherMistakesFirst) {
  const std::string tool = contentOf(fs::path(kSourceFolder) / "assets/tools/round-014.toml");
  folder_.write("my-copy.toml", tool);
  refuses({"tool", "check", at("my-copy.toml")}, {"key id", "Try: id = \"my-copy\""});
  folder_.write("my-copy.toml", tool + "\nhead_dimeter = 2\n");
  refuses({"tool", "check", at("my-copy.toml")}, {"head_dimeter", "unknown key"});
}

TEST_F(Cli, OutputsThatCannotBeAreRefusedAndNothingOfOthersIsReplaced) {
  makeRun();
  fs::create_directory(in("mine"));
  folder_.write("mine/letter.txt", "dear diary");
  folder_.write("file.case", "a file");
  const std::string mesh = at("box.off"), box = at("box.case"), path = at("groove.csv");
  const auto bake = [&](const std::string& out) {
    return std::vector<std::string>{"bake", mesh, "--unit", "mm", "--voxel", "0.2", "-o", out};
  };
  const auto cut = [&](const std::string& out) {
    return std::vector<std::string>{"cut", box, "--tool", "round-014", "--path", path, "-o", out};
  };
  const auto forced = [](std::vector<std::string> words) {
    words.emplace_back("--force");
    return words;
  };
  for (const auto& command : {bake(at("none/x")), cut(at("none/x"))}) refuses(command, {"none/x", "make the folder"});
  for (const auto& command : {bake(at("mine")), cut(at("mine"))}) refuses(command, {"mine", "exists"});
  for (const auto& command : {bake(at("mine")), cut(at("mine"))}) refuses(forced(command), {"not made by Kerf"});
  refuses(forced(bake(at("box.run"))), {"box.run", "it is a run"});
  refuses(forced(cut(at("box.case"))), {"box.case", "it is a case"});
  refuses({"tool", "bake", "round-014", "-o", at("box.run"), "--force"}, {"box.run", "it is a run"});
  refuses({"cut", at("box.run"), "--tool", "round-014", "--path", path, "-o", at("x.run")},
          {"does not touch the remaining object"});
  refuses({"cut", at("box.run"), "--tool", "round-014", "--path", path, "-o", at("box.run"), "--force"},
          {"box.run", "never changes a run"});
  for (const auto& command : {bake(at("file.case")), cut(at("file.case"))}) refuses(forced(command), {"file.case"});
  std::vector<std::string> finer = bake(box);
  finer.insert(finer.end(), {"--close", "repair"});
  refuses(finer, {"box.case", "exists already"});
  refuses(cut(at("box.run")), {"box.run", "exists already"});
  refuses({"tool", "bake", "round-014", "-o", at("mine"), "--force"}, {"not made by Kerf"});
  refuses({"tool", "bake", "round-014", "-o", at("none/x")}, {"none/x"});
  for (const std::string out : {"none/x.stl", "x.step", "x", "mine"}) {
    refuses({"export", at("box.run"), "-o", at(out)}, {out});
    refuses({"demo-molar", "-o", at(out)}, {out});
  }
  refuses({"export", at("box.run"), "-o", at("good.stl"), "-o", at("bad.step")}, {"bad.step"});
  EXPECT_EQ(runKerf(forced(bake(box))).exit_code, 0);
  EXPECT_EQ(runKerf(forced(cut(at("box.run")))).exit_code, 0);
}

TEST_F(Cli, FoldersWithoutPermissionAreRefused) {
  if (::geteuid() != 0) {
    makeRun();
    fs::create_directory(in("locked"));
    fs::permissions(in("locked"), fs::perms::owner_read | fs::perms::owner_exec);
    refuses({"bake", at("box.off"), "-o", at("locked/x.case")}, {"locked/x.case", "Permission denied"});
    refuses({"export", at("box.run"), "-o", at("locked/x.stl")}, {"locked/x.stl", "Permission denied"});
    fs::permissions(in("locked"), fs::perms::owner_all);
    return;
  }
  // Root may write anywhere, so kerf runs as nobody, who must have access to it.
  RunOptions nobody;
  nobody.as_nobody = true;
  makeRun();
  fs::permissions(folder_.path(), fs::perms(0755));
  if (runKerf({"--version"}, nobody).exit_code != 0) GTEST_SKIP() << "nobody may not run " << kProgramFolder << "/kerf";
  refuses({"bake", at("box.off"), "-o", at("x.case")}, {"x.case", "Permission denied"}, 1, nobody);
  refuses({"export", at("box.run"), "-o", at("x.stl")}, {"x.stl", "Permission denied"}, 1, nobody);
  fs::permissions(in("box.off"), fs::perms(0600));
  refuses({"check", at("box.off")}, {"box.off", "Permission denied"}, 1, nobody);
}

TEST_F(Cli, NonsenseNumbersAndUnitsAreRefused) {
  makeCase();
  for (const std::string voxel : {"0", "-1", "1e9", "0.0001"}) {
    refuses({"bake", at("box.off"), "-o", at("x.case"), "--voxel", voxel}, {"--voxel", "0.005"}, 2);
    refuses({"bake", at("box.off"), "-o", at("x.case"), "--fine-along", at("groove.csv"), "--fine-voxel", voxel},
            {"--fine-voxel", "0.005"}, 2);
    const Outcome tool = runKerf({"tool", "bake", "round-014", "-o", at("x.tool"), "--voxel", voxel});
    EXPECT_NE(tool.exit_code, 0) << voxel;
    EXPECT_EQ(tool.signal, 0) << voxel;
    const Outcome check = runKerf({"tool", "check", "round-014", "--voxel", voxel});
    EXPECT_NE(check.exit_code, 0) << voxel;
    EXPECT_EQ(check.signal, 0) << voxel;
  }
  for (const std::string edge : {"0", "nan", "1e-9"}) {
    const Outcome molar = runKerf({"demo-molar", "-o", at("x.stl"), "--edge", edge});
    EXPECT_NE(molar.exit_code, 0) << edge;
    EXPECT_EQ(molar.signal, 0) << edge;
  }
  for (const std::string margin : {"0", "-1", "1e9"})
    refuses({"bake", at("box.off"), "--unit", "mm", "-o", at("x.case"), "--base-margin=" + margin},
            {"--base-margin: ", "more than 0, less than 1000 mm"}, 2);
  for (const std::string height : {"0", "-5", "5000"})
    refuses({"bake", at("box.off"), "--unit", "mm", "-o", at("x.case"), "--base-height=" + height},
            {"--base-height: ", "more than 0, less than 1000 mm"}, 2);
  refuses({"bake", at("box.off"), "--unit", "mm", "-o", at("x.case"), "--base", "oval"},
          {"--base: \"oval\"; expected horseshoe or full"}, 2);
  refuses({"bake", at("box.off"), "-o", at("x.case"), "--unit", "furlong"}, {"--unit", "furlong", "inch"}, 2);
  for (const std::string stitch : {"-1", "1.5"})
    refuses({"bake", at("box.off"), "-o", at("x.case"), "--stitch-mm", stitch}, {"--stitch-mm", stitch}, 2);
  for (const std::string& wrong : std::vector<std::string>{"--push=-1", "--push=9", "--feed-limit=0", "--patience=0",
                                                           "--spindle=2", "--coupling=0", "--time-limit=0"})
    refuses({"cut", at("box.case"), "--tool", "round-014", "--path", at("groove.csv"), "-o", at("x.run"), "--hand",
             "force", wrong},
            {wrong.substr(0, wrong.find('=')) + ": "}, 2);
  // 0.005 mm on a box of 60 mm needs too much memory: the error names a voxel size that fits.
  refuses({"bake", at("box.off"), "-o", at("x.case"), "--unit", "cm", "--voxel", "0.005"},
          {"GB", "60 x 50 x 40 mm", "--voxel", "another --unit"});
  // A box of metres is no dental object at any voxel size.
  refuses({"bake", at("box.off"), "-o", at("x.case"), "--unit", "m", "--voxel", "0.005"},
          {"8775 mm across", "at most 2000 mm", "another --unit"});
}

// The numeric options in a command's help: "--voxel FLOAT=0.1".
std::vector<std::string> optionsOfNumbers(const std::vector<std::string>& command) {
  std::vector<std::string> words = command, options;
  words.push_back("--help");
  std::istringstream help(runKerf(words).out);
  for (std::string line; std::getline(help, line);) {
    const std::size_t name = line.find_first_not_of(' '), end = line.find(' ', name);
    if (line.find("FLOAT") != line.npos && line.compare(name, 2, "--") == 0)
      options.push_back(line.substr(name, end - name));
  }
  return options;
}

TEST_F(Cli, NumbersThatAreNotFiniteAreRefusedByEveryOptionThatTakesNumbers) {
  std::size_t options = 0;
  for (const std::vector<std::string>& command : std::vector<std::vector<std::string>>{
           {"bake"}, {"cut"}, {"replay"}, {"tool", "check"}, {"tool", "bake"}, {"demo", "arch"}, {"demo-molar"}})
    for (const std::string& option : optionsOfNumbers(command)) {
      ++options;
      for (const std::string number : {"nan", "-inf"}) {
        std::vector<std::string> words = command;
        words.push_back(option + "=" + number);
        refuses(words, {option, number}, 2);
      }
    }
  EXPECT_GT(options, 20u) << "the help says FLOAT where an option takes numbers";
  for (const std::string number : {"-NaN", "infinity", "1e999"})
    refuses({"bake", at("box.off"), "--voxel=" + number}, {"--voxel", number}, 2);
}

TEST_F(Cli, BadPathsAndToolsAreRefused) {
  makeCase();
  const std::string head = "t,x,y,z,qw,qx,qy,qz\n", row = "0,0,0,0,1,0,0,0\n";
  const std::string toml = "format = \"kerf-path\"\nversion = 1\nframe = \"object\"\n";
  const std::string start = "[start]\nposition = [0, 0, 5]\naxis = [0, 0, 1]\n";
  const std::map<std::string, std::string> paths{
      {"empty.csv", ""},
      {"header.csv", head},
      {"one.csv", head + row},
      {"columns.csv", head + row + "1,2,3\n"},
      {"nan.csv", head + row + "1,nan,0,0,1,0,0,0\n"},
      {"words.csv", head + row + "1,here,0,0,1,0,0,0\n"},
      {"turn.csv", head + row + "1,0,0,0,0,0,0,0\n"},
      {"back.csv", head + row + "-1,0,0,0,1,0,0,0\n"},
      {"far.csv", head + row + "1,1e300,0,0,1,0,0,0\n"},
      {"noise.csv", randomBytes(3000)},
      {"air.csv", groove(50)},
      {"wrong.dat", head},
      {"empty.toml", ""},
      {"noise.toml", randomBytes(3000)},
      {"no-strokes.toml", toml + start},
      {"kind.toml", toml + start + "[[stroke]]\nkind = \"drill\"\n"},
      {"misspelt.toml", toml + start + "[[stroke]]\nkind = \"plunge\"\ndepht = 1\n"},
      {"deep.toml", "a = " + std::string(100000, '[')},
      {"dotted.toml",
       [] {
         std::string key = "a";
         for (int n = 0; n < 200000; ++n) key += ".a";
         return key + " = 1\n";
       }()},
  };
  for (const auto& [name, content] : paths) {
    folder_.write(name, content);
    refuses({"cut", at("box.case"), "--tool", "round-014", "--path", at(name), "-o", at("x.run")}, {name});
    if (fs::path(name).extension() != ".toml") continue;
    refuses({"cut", at("box.case"), "--tool", at(name), "--path", at("groove.csv"), "-o", at("x.run")}, {name});
    refuses({"tool", "check", at(name)}, {name});
    refuses({"info", at(name)}, {name});
  }
  // A kilometre through the box in one motion costs the same as a path of the box's size.
  folder_.write("long.toml", toml + "[start]\nposition = [-900, -900, -900]\naxis = [0, 0, 1]\n" +
                                 "[[stroke]]\nkind = \"line\"\nto = [900, 900, 900]\n");
  const Outcome o =
      runKerf({"cut", at("box.case"), "--tool", "round-014", "--path", at("long.toml"), "-o", at("x.run")});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_LT(o.seconds, 30);
}

TEST_F(Cli, DamagedCasesAndRunsAreRefused) {
  makeRun();
  const auto commands = [&](const std::string& file) {
    std::vector<std::vector<std::string>> all{{"export", at("box.run"), "-o", at("x.stl")}};
    if (file.starts_with("box.case")) {
      all.push_back({"cut", at("box.case"), "--tool", "round-014", "--path", at("groove.csv"), "-o", at("x.run")});
      all.push_back({"export", at("box.case"), "-o", at("x.stl")});
      if (file == "box.case/anatomy.vdb") all.pop_back();  // a case without a cut needs only its solid
      if (file == "box.case/solid.ply") all.erase(all.begin() + 1);
    }
    return all;
  };
  for (const std::string file : {"box.case/case.toml", "box.case/solid.ply", "box.case/anatomy.vdb", "box.run/run.toml",
                                 "box.run/run.vdb", "box.run/tool.toml", "box.run/path.csv"}) {
    const std::string good = contentOf(in(file));
    std::string flipped = good;
    flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 0x40);
    const bool is_toml = file.ends_with("case.toml") || file.ends_with("run.toml");
    for (const std::string& bad :
         {good.substr(0, good.size() / 2), randomBytes(good.size()), std::string(), is_toml ? "[" + good : flipped}) {
      folder_.write(file, bad);
      for (const auto& command : commands(file)) refuses(command, {fs::path(file).filename().string()});
    }
    fs::remove(in(file));
    for (const auto& command : commands(file)) refuses(command, {file.substr(0, 5)});
    folder_.write(file, good);
  }
  // Manifests that parse but hold false values.
  const auto replaced = [](std::string text, const std::string& key, const std::string& value) {
    const std::size_t at = text.find("\n" + key + " = "), end = text.find('\n', at + 1);
    EXPECT_NE(at, text.npos) << key;
    return text.replace(at, end - at, "\n" + key + " = " + value);
  };
  const std::string case_toml = contentOf(in("box.case/case.toml")), run_toml = contentOf(in("box.run/run.toml"));
  for (const auto& [key, value] : std::vector<std::pair<std::string, std::string>>{
           {"voxel_mm", "nan"}, {"voxel_mm", "0"}, {"voxel_mm", "-1"}, {"version", "4294967297"}, {"id", "7"}}) {
    folder_.write("box.case/case.toml", replaced(case_toml, key, value));
    for (const auto& command : commands("box.case/case.toml")) refuses(command, {"case.toml", key});
  }
  folder_.write("box.case/case.toml", case_toml);
  for (const auto& [key, value] : std::vector<std::pair<std::string, std::string>>{
           {"voxel_mm", "nan"}, {"case_path", "'../other.case'"}, {"path_file", "'/etc/passwd'"}, {"version", "2"}}) {
    folder_.write("box.run/run.toml", replaced(run_toml, key, value));
    refuses({"export", at("box.run"), "-o", at("x.stl")}, {"box.run", key});
  }
  folder_.write("box.run/run.toml", run_toml);
  ASSERT_EQ(runKerf({"export", at("box.run"), "-o", at("fine.stl")}).exit_code, 0);
}

TEST_F(Cli, VdbFilesWithOtherGridsAreRefused) {
  makeRun();
  // The manifest confirms the file, but its content must also fit: a tool's fields in place of the case's.
  ASSERT_EQ(runKerf({"tool", "bake", "round-014", "-o", at("round.tool")}).exit_code, 0);
  const auto vouch = [&](const std::string& manifest, const std::string& file) {
    std::string text = contentOf(in(manifest));
    FILE* pipe = ::popen(("sha256sum '" + at(file) + "'").c_str(), "r");
    char sum[65] = {};
    ASSERT_EQ(::fread(sum, 1, 64, pipe), 64u);
    ::pclose(pipe);
    const std::string key = manifest == "box.run/run.toml" ? "field_sha256 = '" : "[field]";
    std::size_t at = text.find(key);
    ASSERT_NE(at, text.npos);
    at = text.find("sha256 = '", at) + 10;
    folder_.write(manifest, text.replace(at, 64, sum));
  };
  const std::string other = contentOf(in("round.tool/tool.vdb")), good = contentOf(in("box.run/run.vdb"));
  folder_.write("box.run/run.vdb", other);
  vouch("box.run/run.toml", "box.run/run.vdb");
  refuses({"export", at("box.run"), "-o", at("x.stl")}, {"run.vdb", "grid sweep"});
  folder_.write("box.run/run.vdb", good.substr(0, good.size() / 2));
  vouch("box.run/run.toml", "box.run/run.vdb");
  refuses({"export", at("box.run"), "-o", at("x.stl")}, {"run.vdb"});
  folder_.write("box.case/anatomy.vdb", other);
  vouch("box.case/case.toml", "box.case/anatomy.vdb");
  refuses({"cut", at("box.case"), "--tool", "round-014", "--path", at("groove.csv"), "-o", at("x.run")},
          {"anatomy.vdb", "grid phi"});
}

TEST_F(Cli, ARunWhoseCaseIsGoneOrAnotherIsRefused) {
  makeRun();
  fs::rename(in("box.case"), in("moved.case"));
  refuses({"export", at("box.run"), "-o", at("x.stl")}, {"box.run", "case_path", "box.case"});
  ASSERT_EQ(runKerf({"bake", at("box.off"), "--unit", "mm", "-o", at("box.case"), "--voxel", "0.25"}).exit_code, 0);
  refuses({"export", at("box.run"), "-o", at("x.stl")}, {"box.run", "baked again"});
}

TEST_F(Cli, ARunThatWasMovedAloneFindsItsCaseWhereItIsSaidToBe) {
  makeRun();
  const std::string moved = at("moved.case");
  ASSERT_EQ(runKerf({"export", at("box.run"), "-o", at("before.stl")}).exit_code, 0);
  fs::rename(in("box.case"), moved);
  const Outcome lost = runKerf({"export", at("box.run"), "-o", at("x.stl")});
  EXPECT_NE(lost.err.find("give its folder with --case FOLDER"), std::string::npos) << lost.err;
  const Outcome found = runKerf({"export", at("box.run"), "--case", moved, "-o", at("after.stl")});
  EXPECT_EQ(found.exit_code, 0) << found.err;
  EXPECT_EQ(contentOf(in("after.stl")), contentOf(in("before.stl")));
  const Outcome info = runKerf({"info", at("box.run"), "--case", moved});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_EQ(info.out.find("no case at"), std::string::npos) << info.out;

  ASSERT_EQ(runKerf({"bake", at("box.off"), "--unit", "mm", "-o", at("other.case"), "--voxel", "0.25"}).exit_code, 0);
  refuses({"export", at("box.run"), "--case", at("other.case"), "-o", at("x.stl")},
          {"--case", "other.case is case", "from which this run was cut"});
  refuses({"export", at("box.run"), "--case", at("nowhere"), "-o", at("x.stl")}, {"nowhere"});
}

TEST_F(Cli, WrongWordsOfTrimAreUsageErrors) {
  makeRun();
  for (const std::vector<std::string>& words : {std::vector<std::string>{"--plane", "sideways"},
                                                {"--plane", "0,0,0@0,0,2"},
                                                {"--box", "1,2,3/1,5,6"},
                                                {"--between", "1,1,1/1,1,1"}}) {
    std::vector<std::string> command{"trim", at("box.case"), "-o", at("x.stl")};
    command.insert(command.end(), words.begin(), words.end());
    refuses(command, {words[0]}, 2);
  }
}

TEST_F(Cli, TomlFilesOfManyMegabytesAreRefusedBeforeTheyAreParsed) {
  folder_.write("big.toml", "id = \"" + std::string(17 << 20, 'x') + "\"\n");
  refuses({"tool", "check", at("big.toml")}, {"big.toml", "more than 16 MB"});
}

// Names in external files must not reach the terminal unescaped.
TEST_F(Cli, NoOutputHoldsCommandsToTheTerminal) {
  const std::string commands =
      "\x1b]0;x\x07\xc2\x9b"
      "2J\x7f";
  const auto isClean = [](const std::string& text) {
    return text.find_first_of("\x1b\x07\x7f\x9b\r") == text.npos && text.find("x1b") != text.npos;
  };
  ASSERT_EQ(runKerf({"tool", "new", "odd", "--shape", "round", "-o", at("odd.toml")}).exit_code, 0);
  std::string tool = contentOf(at("odd.toml"));
  const std::size_t name = tool.find("\nname = \"") + 9;
  folder_.write("odd.toml", tool.insert(name, "\\u001b]0;x\\u0007\\u009b2J\\u007f"));
  const Outcome info = runKerf({"tool", "info", at("odd.toml")});
  EXPECT_TRUE(info.exit_code == 0 && isClean(info.out)) << info.out << info.err;
  const Outcome json = runKerf({"tool", "info", at("odd.toml"), "--json"});
  EXPECT_EQ(json.out.find_first_of("\x1b\x07\x7f\x9b\r"), json.out.npos) << json.out;
  EXPECT_NE(json.out.find("\\u009b"), json.out.npos) << json.out;

  const fs::path file = folder_.path() / ("box" + commands + ".off");
  std::ofstream(file) << box();
  const Outcome read = runKerf({"check", file});
  EXPECT_TRUE(isClean(read.out + read.err)) << read.out << read.err;
  const Outcome refused = runKerf({"info", at("none" + commands)});
  EXPECT_TRUE(refused.exit_code == 1 && isClean(refused.err)) << refused.err;
  const Outcome misspelt = runKerf({"info", "--none" + commands});
  EXPECT_TRUE(misspelt.exit_code == 2 && isClean(misspelt.err)) << misspelt.err;
}

TEST_F(Cli, FilesOfARunThatNoKerfWroteAreRefusedSoon) {
  makeCase();
  folder_.write("down.csv", "t,x,y,z,qw,qx,qy,qz\n0,0,0,0.2,1,0,0,0\n0.2,0,0,-0.3,1,0,0,0\n");
  ASSERT_EQ(runKerf({"cut", at("box.case"), "--tool", "round-014", "--path", at("down.csv"), "-o", at("hand.run"),
                     "--hand", "feed"})
                .exit_code,
            0);
  std::ofstream(in("hand.run") / "summary.json") << std::string(12 << 20, '[');
  refuses({"info", at("hand.run")}, {"summary.json"});

  std::string table = contentOf(in("hand.run") / "forces.csv");
  const std::size_t row = table.find('\n') + 1;
  for (const char* time : {"1e300", "-1", "1e8"}) {
    std::string other = table;
    other.replace(row, table.find(',', row) - row, time);
    std::ofstream(in("hand.run") / "forces.csv") << other;
    const Outcome plot = runKerf({"plot", at("hand.run"), "-o", at("x.svg")});
    EXPECT_EQ(plot.exit_code, 1) << time;
    EXPECT_NE(plot.err.find("line 2"), plot.err.npos) << plot.err;
    EXPECT_LT(plot.most_memory_mb, 200);
  }
}

// Some of its files have no end, others wait for a writer.
TEST_F(Cli, AFolderOfTheSystemIsRefused) {
  for (const char* command : {"info", "check"}) refuses({command, "/proc"}, {"/proc"});
  refuses({"bake", "/proc", "-o", at("x.case")}, {"/proc"});
}

TEST_F(Cli, AToolThatDoesNotFitIntoMemoryIsRefusedBeforeItIsBaked) {
  ASSERT_EQ(runKerf({"tool", "new", "wide", "--shape", "spin", "-o", at("wide.toml")}).exit_code, 0);
  std::string tool = contentOf(at("wide.toml"));
  const auto set = [&](const std::string& key, const std::string& value) {
    const std::size_t at = tool.find("\n" + key + " = ") + 1;
    ASSERT_NE(at, 0u) << key << tool;
    tool.replace(at, tool.find('\n', at) - at, key + " = " + value);
  };
  set("diameter", "100");
  set("thickness", "0.2");
  folder_.write("wide.toml", tool);
  refuses({"tool", "bake", at("wide.toml"), "-o", at("x.tool"), "--voxel", "0.005"}, {"--voxel", "GB"});
}

TEST_F(Cli, AToolThatIsBakedStopsSoonAndLeavesNothing) {
  const auto before = snapshot(folder_.path());
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    RunOptions options;
    options.signal = signal;
    options.signal_after = 1;
    const Outcome o = runKerf({"tool", "bake", "round-023", "-o", at("x.tool"), "--voxel", "0.005"}, options);
    EXPECT_GT(o.seconds_after_signal, 0) << "it was done before the signal";
    EXPECT_LT(o.seconds_after_signal, 5);
    EXPECT_NE(o.exit_code, 0);
    EXPECT_FALSE(fs::exists(at("x.tool")));
    if (o.exit_code == 1) EXPECT_TRUE(snapshot(folder_.path()) == before) << o.err;
  }
}

TEST_F(Cli, OverwriteIsTheNameAndForceTheOldOne) {
  makeRun();
  const std::vector<std::string> cut{"cut",    at("box.case"),   "--tool", "round-014",
                                     "--path", at("groove.csv"), "-o",     at("box.run")};
  refuses(cut, {"exists already", "or --overwrite"});
  for (const std::string& word : {std::string("--overwrite"), std::string("--force")}) {
    std::vector<std::string> command = cut;
    command.push_back(word);
    EXPECT_EQ(runKerf(command).exit_code, 0) << word;
  }
  const std::string help = runKerf({"cut", "--help"}).out;
  EXPECT_NE(help.find("--overwrite"), std::string::npos);
  EXPECT_EQ(help.find("--force"), std::string::npos);
}

// On a full disk writes fail half-way. A file size limit does the same to a program that ignores SIGXFSZ.
TEST_F(Cli, AFullDiskLeavesNothing) {
  makeRun();
  ASSERT_EQ(runKerf({"demo-molar", "--edge", "0.8", "-o", at("molar.stl")}).exit_code, 0);
  const auto field = fs::file_size(in("box.case/anatomy.vdb")), run = fs::file_size(in("box.run/run.vdb"));
  ASSERT_GT(field, 8192u);
  ASSERT_GT(run, 8192u);
  RunOptions full;
  for (const rlim_t room : {rlim_t{1000}, static_cast<rlim_t>(field / 2), static_cast<rlim_t>(field - 1)}) {
    full.largest_file = room;
    refuses({"bake", at("box.off"), "--unit", "mm", "-o", at("x.case"), "--voxel", "0.2"}, {}, 1, full);
  }
  for (const rlim_t room : {rlim_t{1000}, static_cast<rlim_t>(run / 2), static_cast<rlim_t>(run - 1)}) {
    full.largest_file = room;
    refuses({"cut", at("box.case"), "--tool", "round-014", "--path", at("groove.csv"), "-o", at("x.run")}, {}, 1, full);
  }
  full.largest_file = 2000;
  for (const std::string out : {"x.stl", "x.ply", "x.obj", "x.off"}) {
    refuses({"export", at("box.run"), "-o", at(out)}, {out}, 1, full);
    refuses({"demo-molar", "-o", at(out), "--edge", "0.8"}, {out}, 1, full);
  }
  refuses({"tool", "bake", "round-014", "-o", at("x.tool")}, {}, 1, full);
  refuses({"bake", at("molar.stl"), "-o", at("box.case"), "--force", "--voxel", "0.3"}, {}, 1, full);  // the old stays
}

TEST_F(Cli, InterruptedBakesStopSoonAndLeaveNothing) {
  ASSERT_EQ(runKerf({"demo-molar", "--edge", "0.6", "-o", at("molar.stl")}).exit_code, 0);
  const auto before = snapshot(folder_.path());
  for (const int signal : {SIGINT, SIGTERM}) {
    RunOptions options;
    options.signal = signal;
    options.signal_after = 1.5;
    const Outcome o = runKerf({"bake", at("molar.stl"), "-o", at("x.case"), "--voxel", "0.016"}, options);
    EXPECT_GT(o.seconds_after_signal, 0) << "it was done before the signal: choose a finer voxel";
    EXPECT_LT(o.seconds_after_signal, 10);
    EXPECT_EQ(o.signal, 0);
    // On a busy machine, cleaning up may take longer than the two seconds of SIGTERM: the next run does it then.
    if (signal == SIGTERM && o.exit_code == 128 + SIGTERM) {
      ASSERT_EQ(runKerf({"bake", at("molar.stl"), "-o", at("x.case"), "--voxel", "0.3"}).exit_code, 0);
      std::filesystem::remove_all(at("x.case"));
      EXPECT_TRUE(snapshot(folder_.path()) == before) << ::testing::PrintToString(names(snapshot(folder_.path())));
      continue;
    }
    EXPECT_EQ(o.exit_code, 1);
    EXPECT_NE(o.err.find("cancelled"), o.err.npos) << o.err;
    EXPECT_TRUE(snapshot(folder_.path()) == before) << ::testing::PrintToString(names(snapshot(folder_.path())));
  }
}

TEST_F(Cli, ASecondSignalOfEitherKindEndsTheProgramAtOnce) {
  ASSERT_EQ(runKerf({"demo-molar", "--edge", "0.6", "-o", at("molar.stl")}).exit_code, 0);
  RunOptions options;
  options.signal = SIGINT;
  options.second_signal = SIGTERM;
  options.signal_after = 1.5;
  const Outcome o = runKerf({"bake", at("molar.stl"), "-o", at("x.case"), "--voxel", "0.016"}, options);
  EXPECT_TRUE(o.signal == SIGINT || o.signal == SIGTERM) << o.exit_code << o.err;
}

}  // namespace
}  // namespace kerf::cli_refusal_test
