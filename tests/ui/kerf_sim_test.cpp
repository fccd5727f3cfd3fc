// The program kerf-sim, run as a user does.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/places.h"
#include "ui/app/view/tissue_display.h"
#include "ui/window/gl/image.h"

namespace kerf::kerf_sim_test {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  int status = -1;
  std::string text;  ///< standard output and error
};

Outcome shell(const std::string& command) {
  Outcome outcome;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return outcome;
  char buffer[512];
  while (std::fgets(buffer, sizeof buffer, pipe)) outcome.text += buffer;
  const int status = pclose(pipe);
  if (WIFEXITED(status)) outcome.status = WEXITSTATUS(status);
  return outcome;
}

const std::string kProgram = std::string("'") + kProgramFolder + "/kerf-sim'";

class KerfSim : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) / "kerf_sim_test" /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream(mesh())
        << "OFF\n4 4 0\n0 0 0\n3 0.2 0.1\n0.7 4 -0.3\n0.4 1.1 6\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path mesh() const { return folder_ / "solid.off"; }
  fs::path png() const { return folder_ / "picture.png"; }
  /// Without a display, even if the test has one.
  Outcome picture(const std::string& arguments) const {
    return shell(fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} --screenshot '{}' --size 96x64 {}", kProgram,
                             png().string(), arguments));
  }
  fs::path folder_;
};

TEST_F(KerfSim, AFilmIsThatOfAReplay) {
  const fs::path film = folder_ / "film";
  const auto asked = [&](const std::string& more) {
    return shell(fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} --film '{}' {}", kProgram, film.string(), more));
  };
  for (const std::string& more : {std::string(), std::string("--replay x.run --fps 0"), "'" + mesh().string() + "'"}) {
    const Outcome refused = asked(more);
    EXPECT_EQ(refused.status, 2) << refused.text;
    EXPECT_FALSE(fs::exists(film)) << more;
  }
  const Outcome missing = asked(fmt::format("--replay '{}'", (folder_ / "none.run").string()));
  EXPECT_EQ(missing.status, 1) << missing.text;
  EXPECT_NE(missing.text.find("none.run"), std::string::npos) << missing.text;
}

// A groove along the mesh, and a picture every half second.
TEST_F(KerfSim, AFilmShowsTheCutGrowAndIsTheSameTwice) {
  const std::string kerf = std::string("'") + kProgramFolder + "/kerf'", a_case = (folder_ / "a.case").string(),
                    run = (folder_ / "a.run").string(), path = (folder_ / "groove.csv").string();
  std::ofstream(path) << "t,x,y,z,qw,qx,qy,qz\n0,1.2,1,5,1,0,0,0\n1,1.2,1,1.5,1,0,0,0\n2,1.2,1.8,1.5,1,0,0,0\n";
  const Outcome made = shell(
      fmt::format("{0} bake '{1}' --unit mm -o '{2}' --voxel 0.2 && {0} cut '{2}' --tool round-014 --path '{3}' --hand "
                  "feed -o '{4}'",
                  kerf, mesh().string(), a_case, path, run));
  ASSERT_EQ(made.status, 0) << made.text;

  std::vector<std::vector<std::string>> films;
  for (const char* name : {"one", "two"}) {
    const fs::path film = folder_ / name;
    const Outcome done =
        shell(fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} --replay '{}' --film '{}' --fps 2 "
                          "--size 96x64",
                          kProgram, run, film.string()));
    if (done.text.find("no way to draw") != std::string::npos) GTEST_SKIP() << done.text;
    ASSERT_EQ(done.status, 0) << done.text;
    films.emplace_back();
    for (int n = 1; fs::exists(film / fmt::format("frame-{:05}.png", n)); ++n) {
      std::ifstream in(film / fmt::format("frame-{:05}.png", n), std::ios::binary);
      films.back().emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
    EXPECT_EQ(static_cast<std::size_t>(std::distance(fs::directory_iterator(film), fs::directory_iterator())),
              films.back().size())
        << "numbered without a gap, and nothing else";
  }
  ASSERT_GE(films[0].size(), 5u) << "two seconds and more, two a second";
  EXPECT_EQ(films[0], films[1]);
  EXPECT_NE(films[0].front(), films[0][films[0].size() / 2]);
  EXPECT_NE(films[0].front(), films[0].back());
}

TEST_F(KerfSim, SigtermToAScriptThatBakesLeavesNothingHalfWritten) {
  const fs::path molar = folder_ / "molar.stl", script = folder_ / "wait.txt", data = folder_ / "data";
  ASSERT_EQ(shell(fmt::format("'{}/kerf' demo-molar --edge 0.1 -o '{}'", kProgramFolder, molar.string())).status, 0);
  std::ofstream(script) << "wait\n";
  const Outcome done = shell(
      fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} '{}' --data '{}' --script '{}' --voxel 0.05 2>&1 & baking=$!; "
                  "until ls -A '{}/cases' 2>/dev/null | grep -q '^[.]' || ! kill -0 $baking; do sleep 0.02; done; "
                  "kill -TERM $baking; wait $baking",
                  kProgram, molar.string(), data.string(), script.string(), data.string()));
  if (done.text.find("no way to draw") != std::string::npos) GTEST_SKIP() << done.text;
  ASSERT_EQ(done.status, 128 + 15) << "it was done before the signal? " << done.text;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(data))
    EXPECT_NE(entry.path().filename().string().front(), '.') << entry.path();
}

TEST_F(KerfSim, TheFirstOfSeveralFilesIsWorkedOnTheOthersStandBeside) {
  const fs::path other = folder_ / "other.off", script = folder_ / "script.ks", data = folder_ / "data";
  std::ofstream(other) << "OFF\n4 4 0\n5 0 0\n8 0.2 0.1\n5.7 4 -0.3\n5.4 1.1 6\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  std::ofstream(script) << "wait\nexpect beside 1 1\nexpect pieces 1 1\nprint\n";
  const std::string both = fmt::format("'{}' '{}'", mesh().string(), other.string());
  const Outcome done =
      shell(fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} {} --script '{}' --data '{}' --voxel 0.2", kProgram, both,
                        script.string(), data.string()));
  if (done.text.find("no way to draw") != std::string::npos) GTEST_SKIP() << done.text;
  EXPECT_EQ(done.status, 0) << done.text;
  EXPECT_NE(done.text.find("\"name\":\"other\""), std::string::npos) << done.text;

  const Outcome refused = picture(both);
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.text.find("one mesh, case or run to draw"), std::string::npos) << refused.text;
}

TEST_F(KerfSim, DrawsAPictureWithoutADisplay) {
  const Outcome done = picture(fmt::format("-v '{}'", mesh().string()));
  if (done.text.find("no way to draw") != std::string::npos) GTEST_SKIP() << done.text;
  EXPECT_EQ(done.status, 0) << done.text;
  EXPECT_NE(done.text.find("drawing with"), std::string::npos) << done.text;
  EXPECT_GT(fs::file_size(png()), 500u);
}

// The tetrahedron from above: x from 0 to 3, y from 0 to 4. The pictures differ in the lines.
TEST_F(KerfSim, AGridHasItsLinesAtRoundMillimetresOfTheScan) {
  const auto draw = [&](const char* option) {
    return shell(
        fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} --screenshot '{}' --size 600x400 --view top --up +z {} "
                    "'{}'",
                    kProgram, png().string(), option, mesh().string()));
  };
  const Outcome plain = draw("");
  if (plain.text.find("no way to draw") != std::string::npos) GTEST_SKIP() << plain.text;
  const Expected<Image> without = readPng(png());
  ASSERT_EQ(draw("--grid").status, 0);
  const Expected<Image> with = readPng(png());
  ASSERT_TRUE(without && with);

  // 4 mm and 7 % on both sides fill the height.
  const double mm_per_pixel = 4.0 / (400 * (1 - 2 * 0.07));
  std::vector<double> found;
  for (int x = 0; x < 600; ++x) {
    int changed = 0;
    for (int y = 100; y < 400; ++y) changed += !std::equal(with->at(x, y), with->at(x, y) + 3, without->at(x, y));
    if (changed > 280) found.push_back(1.5 + (x + 0.5 - 300) * mm_per_pixel);
  }
  ASSERT_GE(found.size(), 6u);
  for (std::size_t n = 0; n < found.size(); ++n)
    EXPECT_NEAR(std::remainder(found[n], 1.0), 0, 0.6 * mm_per_pixel) << found[n] << " mm";
  EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](double x) { return std::abs(x - 3) < mm_per_pixel; }));
}

TEST_F(KerfSim, APictureOfAMapOfDepthHasItsLegend) {
  const fs::path script = folder_ / "script.ks", tissue = folder_ / "tissue.png", depth = folder_ / "depth.png";
  std::ofstream(script) << fmt::format("wait\npicture.write {}\nview.colours depth\nwait\npicture.write {}\n",
                                       tissue.string(), depth.string());
  const Outcome done = shell(
      fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} '{}' --script '{}' --data '{}' --voxel 0.2 --size 600x400",
                  kProgram, mesh().string(), script.string(), (folder_ / "data").string()));
  if (done.text.find("no way to draw") != std::string::npos) GTEST_SKIP() << done.text;
  ASSERT_EQ(done.status, 0) << done.text;
  const Expected<Image> without = readPng(tissue), with = readPng(depth);
  ASSERT_TRUE(without && with);

  // A row in the lower left corner that runs through the map from its light to its dark end.
  const auto isNear = [](const std::uint8_t* pixel, const Rgba8& colour) {
    for (std::size_t k = 0; k < 3; ++k)
      if (std::abs(int{pixel[k]} - int{colour[k]}) > 8) return false;
    return true;
  };
  const auto rowsWithAMap = [&](const Image& image) {
    int rows = 0;
    for (int y = 300; y < 400; ++y) {
      int at = 0;
      for (int x = 0; x < 300 && at < 10; ++x) at += isNear(image.at(x, y), mapColour((at + 0.5) / 10));
      rows += at == 10;
    }
    return rows;
  };
  EXPECT_GT(rowsWithAMap(*with), 3);
  EXPECT_EQ(rowsWithAMap(*without), 0);
}

TEST_F(KerfSim, FoldersShowTheirMesh) {
  const fs::path a_case = folder_ / "a_case";
  fs::create_directories(a_case);
  EXPECT_EQ(picture(fmt::format("'{}'", a_case.string())).status, 1);  // neither case nor run
  std::ofstream(a_case / "case.toml") << "\n";
  const Outcome empty = picture(fmt::format("'{}'", a_case.string()));
  EXPECT_EQ(empty.status, 1);
  EXPECT_NE(empty.text.find("case.toml"), std::string::npos) << empty.text;
  // A real case, baked by the command-line program.
  const fs::path kerf = fs::path(kProgramFolder) / "kerf";
  const Outcome baked =
      shell(fmt::format("'{}' bake '{}' -o '{}' --voxel 0.5 --force", kerf.string(), mesh().string(), a_case.string()));
  ASSERT_EQ(baked.status, 0) << baked.text;
  const Outcome done = picture(fmt::format("'{}'", a_case.string()));
  if (done.text.find("no way to draw") != std::string::npos) GTEST_SKIP() << done.text;
  EXPECT_EQ(done.status, 0) << done.text;
}

TEST_F(KerfSim, BadArgumentsAreErrorsThatSayWhatToDo) {
  const std::string file = fmt::format("'{}'", mesh().string());
  const std::pair<std::string, std::string> cases[] = {{"--view sideways " + file, "--view: \"sideways\""},
                                                       {"--view sideways " + file, "occlusal"},
                                                       {"--frob " + file, "--frob"},
                                                       {"", "a mesh, a case or a run to draw"},
                                                       {"--frames many " + file, "--frames"},
                                                       {"--look-at 1,2 " + file, "--look-at 0,0,5"},
                                                       {"--zoom -1 " + file, "zoom"},
                                                       {"--zoom nan " + file, "--zoom: nan is not a finite number"},
                                                       {"--section 0,0,1 " + file, "--section center,0,1,0"},
                                                       {"--section center,0,0,0 " + file, "--section center,0,1,0"},
                                                       {"--zoom", "--zoom"}};
  for (const auto& [arguments, words] : cases) {
    const Outcome done = picture(arguments);
    EXPECT_EQ(done.status, 2) << arguments << "\n" << done.text;
    EXPECT_NE(done.text.find(words), std::string::npos) << done.text;
    EXPECT_FALSE(fs::exists(png()));
  }
}

TEST_F(KerfSim, WhatCanNotBeShownIsAnErrorThatSaysWhatToDo) {
  const std::string file = fmt::format("'{}'", mesh().string());
  const std::pair<std::string, std::string> cases[] = {{"--section center,0,0,1 " + file, "run kerf bake first"},
                                                       {"missing.stl", "missing.stl"}};
  for (const auto& [arguments, words] : cases) {
    const Outcome done = picture(arguments);
    EXPECT_EQ(done.status, 1) << arguments << "\n" << done.text;
    EXPECT_NE(done.text.find(words), std::string::npos) << done.text;
    EXPECT_FALSE(fs::exists(png()));
  }
}

TEST_F(KerfSim, PicturesOfAnotherNameThanPngAreRefused) {
  const fs::path jpg = folder_ / "picture.jpg";
  const Outcome done = shell(fmt::format("{} --screenshot '{}' '{}'", kProgram, jpg.string(), mesh().string()));
  EXPECT_EQ(done.status, 2);
  EXPECT_NE(done.text.find("picture.png"), std::string::npos) << done.text;
  EXPECT_FALSE(fs::exists(jpg));
}

TEST_F(KerfSim, OptionsOfPicturesAreRefusedWithoutOne) {
  for (const char* const option : {"--section center,0,0,1", "--zoom 2", "--look-at 0,0,1", "--transparent",
                                   "--no-shadow", "--no-scale-bar", "--grid", "--gpu"}) {
    const Outcome done = shell(fmt::format("{} {} '{}'", kProgram, option, mesh().string()));
    EXPECT_EQ(done.status, 2) << option << "\n" << done.text;
    EXPECT_NE(done.text.find("--screenshot"), std::string::npos) << done.text;
  }
  const Outcome both = picture(fmt::format("--script x.ks '{}'", mesh().string()));
  EXPECT_EQ(both.status, 2) << both.text;
}

TEST_F(KerfSim, WithoutADisplayTheWindowSaysWhatToDo) {
  const Outcome done =
      shell(fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} --frames 1 '{}'", kProgram, mesh().string()));
  EXPECT_EQ(done.status, 1);
  EXPECT_NE(done.text.find("--screenshot"), std::string::npos) << done.text;
}

// Mesa reports the version set in its environment.
TEST_F(KerfSim, WithoutOpenGl33TheWindowSaysWhatThereIsAndWhatToDo) {
  if (shell("command -v xvfb-run").status != 0) GTEST_SKIP() << "xvfb-run is missing (Debian: xvfb)";
  const std::string display = "MESA_GL_VERSION_OVERRIDE=2.1 xvfb-run -a -s '-screen 0 800x600x24' ";
  // xvfb-run sometimes fails to clean up after a program that ends at once: the test judges the program, not xvfb-run.
  const Outcome done =
      shell(fmt::format("{0}sh -c \"{1} --frames 3 --data '{2}' --config '{2}' '{3}' >'{2}/said' 2>&1; echo \\$? "
                        ">'{2}/status'\" >/dev/null 2>&1; "
                        "cat '{2}/said'; exit $(cat '{2}/status')",
                        display, kProgram, folder_.string(), mesh().string()));
  EXPECT_EQ(done.status, 1) << done.text;
  EXPECT_NE(done.text.find("has OpenGL 2.1"), std::string::npos) << done.text;
  EXPECT_NE(done.text.find("expected OpenGL 3.3"), std::string::npos) << done.text;
  EXPECT_NE(done.text.find("LIBGL_ALWAYS_SOFTWARE=1"), std::string::npos) << done.text;
  EXPECT_EQ(std::count(done.text.begin(), done.text.end(), '\n'), 1) << "one sentence: " << done.text;
  EXPECT_FALSE(fs::exists(folder_ / "sessions")) << "nothing was begun";
}

TEST_F(KerfSim, WindowOpensDrawsAndCloses) {
  if (shell("command -v xvfb-run").status != 0) GTEST_SKIP() << "xvfb-run is missing (Debian: xvfb)";
  const Outcome done =
      shell(fmt::format("xvfb-run -a -s '-screen 0 800x600x24' {} -v --size 640x480 --frames 3 "
                        "--data '{}' '{}'",
                        kProgram, folder_.string(), mesh().string()));
  EXPECT_EQ(done.status, 0) << done.text;
  EXPECT_NE(done.text.find("3 frames drawn"), std::string::npos) << done.text;
}

}  // namespace
}  // namespace kerf::kerf_sim_test
