// Kerf's own text files, damaged in thousands of ways: each is read or refused, no reader crashes, and every result
// keeps the promises of its header.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <random>

#include "geometry/case/case_bundle.h"
#include "geometry/formats/mesh_writer.h"
#include "geometry/tool/tool_file.h"
#include "sim/hand/path.h"
#include "sim/run/files/run_manifest.h"
#include "tests/geometry/ball_mesh.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace kerf::text_files_test {
namespace {

// One to four changes: a byte, a run of bytes cut or doubled, a hostile word in place of a number.
std::string mutated(std::string text, std::mt19937& random) {
  static const std::vector<std::string> kWords{
      "nan", "inf",  "-inf", "1e308", "-1", "0", "1e-320", "99999999999999999999", "true", "\"\"", "[]", "{}",
      "[[",  "''''", "\n",   "\0x",   ",",  "=", "\xff"};
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  for (std::size_t changes = 1 + below(4); changes > 0 && !text.empty(); --changes) {
    const std::size_t at = below(text.size()), length = 1 + below(std::min<std::size_t>(40, text.size() - at));
    switch (below(5)) {
      case 0:
        text[at] = static_cast<char>(random());
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(at, text.substr(at, length));
        break;
      case 3:
        text.insert(at, kWords[below(kWords.size())]);
        break;
      default:
        if (const std::size_t digit = text.find_first_of("0123456789", at); digit != text.npos) {
          std::size_t end = text.find_first_not_of("0123456789.-+e", digit);
          text.replace(digit, std::min(end, text.size()) - digit, kWords[below(kWords.size())]);
        }
    }
  }
  return text;
}

struct Tally {
  int read = 0, refused = 0;
};

// Feeds mutations of `good` to `reads`, which returns whether the file was accepted.
Tally tally(const TemporaryFolder& folder, const std::string& name, const std::string& good, int count,
            const std::function<Expected<void>()>& reads) {
  std::mt19937 random(20240607);
  Tally out;
  folder.write(name, good);
  EXPECT_TRUE(reads()) << name << ": the unchanged file is refused";
  for (int n = 0; n < count; ++n) {
    const std::string bad = mutated(good, random);
    folder.write(name, bad);
    if (const auto result = reads()) {
      ++out.read;
    } else {
      ++out.refused;
      EXPECT_NE(result.error().message().find(name), std::string::npos) << result.error().message();
    }
  }
  return out;
}

TEST(TextFiles, MutatedToolsAreReadOrRefused) {
  const TemporaryFolder folder;
  ASSERT_TRUE(writeMesh(folder.path() / "ball.ply", ballMesh({0, 0, 0.7}, 0.7, 6)));
  std::map<std::string, std::string> files{
      {"odd.toml",
       "format = \"kerf-tool\"\nversion = 1\nid = \"odd\"\nname = \"Odd\"\nkind = \"bur\"\nshape = "
       "\"profile\"\nhead_diameter = 1.4\nprofile = [[0, 0.8], [0.3, 1.4, 0.3], "
       "[1.4, 1.4, -1.0], [1.8, 1.4]]\n"},
      {"ball.toml",
       "format = \"kerf-tool\"\nversion = 1\nid = \"ball\"\nname = \"Ball\"\nkind = \"mesh\"\nmesh = "
       "\"ball.ply\"\nmm_per_unit = 1\ntip = [0, 0, 0]\naxis = [0, 0, 1]\ncut_below = 1\n"}};
  for (const char* id : {"round-014", "856-016", "saw-reciprocating-25", "us-957", "878k-016", "379-018",
                         "saw-sagittal-10", "disc-22"}) {
    const std::string name = std::string(id) + ".toml";
    files[name] = contentOf(std::string(kSourceFolder) + "/assets/tools/" + name);
  }
  for (const auto& [name, good] : files) {
    const Tally t = tally(folder, name, good, 400, [&]() -> Expected<void> {
      KERF_TRY(tool, readTool(folder.path() / name));
      const Box3 box = tool.cut->bounds();
      EXPECT_TRUE(box.min.allFinite() && box.max.allFinite());
      EXPECT_TRUE((box.size().array() > 0).all());
      EXPECT_TRUE(std::isfinite(tool.cut->distance(box.center())));
      return {};
    });
    EXPECT_GT(t.read, 3) << name;  // a dense file seldom survives
    EXPECT_GT(t.refused, 100) << name;
  }
}

TEST(TextFiles, MutatedPathsAreReadOrRefused) {
  const TemporaryFolder folder;
  for (const std::string name : {"demo-cavity.toml", "demo-poses.csv"}) {
    const Tally t = tally(folder, name, contentOf(std::string(kSourceFolder) + "/assets/paths/" + name), 700,
                          [&]() -> Expected<void> {
                            KERF_TRY(path, readPath(folder.path() / name));
                            EXPECT_EQ(path.cuts.size() + 1, path.poses.size());
                            for (std::size_t p = 0; p < path.poses.size(); ++p) {
                              const Rigid3& pose = path.poses[p].T_object_tool;
                              EXPECT_TRUE(pose.translation.allFinite());
                              EXPECT_NEAR(pose.rotation.norm(), 1, 1e-9);
                              EXPECT_TRUE(p == 0 || path.poses[p].t > path.poses[p - 1].t);
                            }
                            return {};
                          });
    EXPECT_GT(t.read, 3) << name;  // a dense file seldom survives
    EXPECT_GT(t.refused, 100) << name;
  }
}

TEST(TextFiles, MutatedCaseManifestsAreReadOrRefused) {
  const TemporaryFolder folder;
  CaseManifest m;
  m.kerf_version = "0.1.0";
  m.id = std::string(64, 'a');
  m.close_mode = "auto";
  m.changes = {"one", "two"};
  m.sources.push_back({"source-1.stl", "binary STL", std::string(64, 'b'), "mm", "as said", 1, 8, 12});
  m.voxel_mm = 0.1;
  m.materials = {{"generic", 9, 1.0}};
  m.solid_vertices = 8;
  m.solid_triangles = 12;
  m.box.add(Vec3d(-1, -2, -3));
  m.box.add(Vec3d(1, 2, 3));
  m.solid_sha256 = std::string(64, 'c');
  m.field_sha256 = std::string(64, 'd');
  ASSERT_TRUE(writeCaseManifest(folder.path(), m));
  const Tally t = tally(folder, "case.toml", contentOf(folder.path() / "case.toml"), 1000, [&]() -> Expected<void> {
    KERF_TRY(read, readCaseManifest(folder.path()));
    EXPECT_TRUE(read.voxel_mm >= 0.001 && read.voxel_mm <= 100) << read.voxel_mm;
    EXPECT_FALSE(read.box.isEmpty());
    return {};
  });
  EXPECT_GT(t.read, 10);
  EXPECT_GT(t.refused, 100);
}

constexpr const char* kRunOfAPath =
    "# Kerf run\nformat = \"kerf-run\"\nversion = 1\nkerf_version = \"0.1.0\"\ncase_path = \"../a.case\"\n"
    "case_id = \"0123456789abcdef\"\nmode = \"geometry\"\ntool_id = \"round-014\"\ntool_sha256 = \"01\"\n"
    "path_file = \"path.csv\"\npath_sha256 = \"02\"\nsegments = 12\npath_length_mm = 3.5\nduration_s = 2.0\n"
    "voxel_mm = 0.1\nstate_hash = \"0123456789abcdef\"\nfield_sha256 = \"03\"\n";

// Unchecked, they would appear as results.
TEST(TextFiles, NumbersThatNoRunHasAreRefusedByTheirKey) {
  const TemporaryFolder folder;
  for (const std::string line : {"segments = 12", "path_length_mm = 3.5", "duration_s = 2.0", "voxel_mm = 0.1"}) {
    const std::string key = line.substr(0, line.find(' '));
    for (const char* value : {"-1", "nan", "inf", "1e30"}) {
      std::string bad = kRunOfAPath;
      bad.replace(bad.find(line), line.size(), key + " = " + value);
      folder.write("run.toml", bad);
      const auto read = readRunManifest(folder.path());
      ASSERT_FALSE(read) << key << " " << value;
      EXPECT_NE(read.error().message().find(key), std::string::npos) << read.error().message();
    }
  }
}

TEST(TextFiles, APieceFarAwayAndASessionWithoutToolsAreRefused) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& text) {
    folder.write("run.toml", text);
    const auto read = readRunManifest(folder.path());
    return read ? std::string() : read.error().message();
  };
  const auto piece = [](const std::string& at) {
    return "[[piece]]\nid = 1\nname = \"a\"\nvolume_mm3 = 1.0\ninside = [0.0, " + at +
           ", 0.0]\ntranslation = [0.0, 0.0, 0.0]\nrotation = [1.0, 0.0, 0.0, 0.0]\n";
  };
  EXPECT_EQ(refusal(kRunOfAPath + piece("2.0")), "");
  for (const char* at : {"1e300", "-1e6", "nan", "inf"})
    EXPECT_NE(refusal(kRunOfAPath + piece(at)).find("inside"), std::string::npos) << at;

  const std::string session =
      "format = \"kerf-run\"\nversion = 1\nkerf_version = \"0.1.0\"\ncase_path = \"../a.case\"\n"
      "case_id = \"0123456789abcdef\"\nmode = \"session\"\ntool_id = \"round-014\"\nis_open = false\n"
      "duration_s = 2.0\nvoxel_mm = 0.1\nstate_hash = \"0123456789abcdef\"\nfield_sha256 = \"03\"\n";
  EXPECT_EQ(refusal(session + "[[tool]]\nid = \"a\"\nfile = \"tools/a.toml\"\nsha256 = \"01\"\n"), "");
  EXPECT_NE(refusal(session + "tool = []\n").find("tool"), std::string::npos);
}

TEST(TextFiles, MutatedRunManifestsAreReadOrRefused) {
  const TemporaryFolder folder;
  const std::string good = kRunOfAPath;
  const auto read_all = [&]() -> Expected<void> {
    KERF_TRY(read, readRunManifest(folder.path()));
    EXPECT_TRUE(read.voxel_mm >= 0.001 && read.voxel_mm <= 100) << read.voxel_mm;
    EXPECT_TRUE(read.path_file == "path.csv" || read.path_file == "path.toml") << read.path_file;
    for (const RunManifest::Beside& b : read.beside)
      EXPECT_TRUE(b.voxel_mm >= 0.001 && b.voxel_mm <= 100 && b.removed_mm3 >= 0) << b.voxel_mm;
    return {};
  };
  const Tally t = tally(folder, "run.toml", good, 1000, read_all);
  EXPECT_GT(t.read, 10);
  EXPECT_GT(t.refused, 100);

  // With two teeth beside the cut tooth.
  std::string scene = good;
  scene.replace(scene.find("geometry"), 8, "haptic");
  for (const char* name : {"35", "37"})
    scene += fmt::format(
        "[[beside]]\ncase_path = \"../{}.case\"\ncase_id = \"01\"\nvoxel_mm = 0.1\nremoved_mm3 = 0.25\n", name);
  folder.write("run.toml", scene);
  const auto read = readRunManifest(folder.path());
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_EQ(read->beside.size(), 2u);
  EXPECT_EQ(read->beside[1].case_path, "../37.case");
  EXPECT_EQ(read->beside[1].removed_mm3, 0.25);
  const Tally beside = tally(folder, "run.toml", scene, 1000, read_all);
  EXPECT_GT(beside.read, 10);
  EXPECT_GT(beside.refused, 100);
  // A geometry-only cut of a case has no neighbours.
  folder.write("run.toml", good + scene.substr(scene.find("[[beside]]")));
  EXPECT_FALSE(readRunManifest(folder.path()));
}

}  // namespace
}  // namespace kerf::text_files_test
