// The rack in the window: favourites first, and a file's error in its row.
#include "ui/app/readout/tool_rack.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "geometry/formats/mesh_writer.h"
#include "tests/ui/block_on_bench.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/settings/settings.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/tools.h"

namespace kerf::tool_rack_test {
namespace {

namespace fs = std::filesystem;

class ToolRackTest : public testing::Test {
 protected:
  static WorkbenchOptions in(const TemporaryFolder& folder) {
    WorkbenchOptions out;
    out.data_folder = folder.path() / "data";
    out.tools = {"round-014", "round-010", "disc-22"};
    out.real_time = {.priority = 0, .lock_memory = false};
    return out;
  }
  void SetUp() override {
    const fs::path file = folder_.path() / "block.ply";
    ASSERT_TRUE(writeMesh(file, test::blockMesh(false)));
    bench_.sessions->open(file);
    ASSERT_TRUE(comes([&] { return bench_.document->isOpen() && !bench_.jobs->running(); }));
  }
  void TearDown() override {
    EXPECT_TRUE(comes([&] { return !bench_.jobs->running(); }));
    bench_.sessions->close();
    EXPECT_TRUE(comes([&] { return !bench_.jobs->running(); }));
  }
  Expected<void> favourite(const std::string& id) {
    return runAppCommand(context_, "tool.favourite", id.empty() ? std::vector<std::string>{} : std::vector{id});
  }
  std::vector<std::string> shown(std::string_view search = {}) const {
    const RackView view{.search = search, .favourites = settings_.values.favourite_tools};
    std::vector<std::string> out;
    for (const std::size_t n : rackRows(bench_, view)) out.push_back(bench_.tools->at(n).id);
    return out;
  }
  // Waits for a condition; the rack checks files once a second.
  template <class IsSo>
  bool comes(const IsSo& is_so) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!is_so() && std::chrono::steady_clock::now() < until) {
      bench_.update();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return is_so();
  }
  bool isInHand(const std::string& id) const {
    return bench_.document->isOpen() && !bench_.jobs->running() && bench_.tools->at(bench_.tools->inHand()).id == id;
  }
  // Like an editor's save: newer than the old file.
  void rewrite(const fs::path& file, const std::string& text) {
    folder_.write(file.filename().string(), text);
    age_ += std::chrono::seconds(5);
    fs::last_write_time(file, fs::file_time_type::clock::now() + age_);
  }

  TemporaryFolder folder_;
  Workbench bench_{in(folder_)};
  Camera camera_;
  SettingsFile settings_{folder_.path() / "config"};
  AppContext context_{.bench = bench_, .camera = camera_, .settings = &settings_};
  std::chrono::seconds age_{0};
};

using Ids = std::vector<std::string>;

TEST_F(ToolRackTest, OfTwoToolsWithOneIdEachIsTakenByItsOwnWord) {
  fs::create_directories(folder_.path() / "mine");
  const fs::path mine = folder_.path() / "mine" / "round-010.toml";
  fs::copy_file(bench_.document->run()->tools()[1].file, mine);
  bench_.tools->add(mine);
  ASSERT_TRUE(
      comes([&] { return bench_.document->isOpen() && !bench_.jobs->running() && bench_.tools->count() == 4; }));
  ASSERT_EQ(bench_.tools->at(3).id, "round-010");
  EXPECT_EQ(bench_.tools->inHand(), 3u);
  EXPECT_EQ(bench_.tools->wordFor(1), "round-010");
  for (const std::size_t wanted : {1u, 3u, 0u}) {
    ASSERT_TRUE(runAppCommand(context_, "tool.select", std::vector{bench_.tools->wordFor(wanted)}));
    EXPECT_EQ(bench_.tools->inHand(), wanted);
  }
}

TEST_F(ToolRackTest, FavouritesAreFirstInTheOrderInWhichTheyWereChosen) {
  EXPECT_EQ(shown(), (Ids{"round-014", "round-010", "disc-22"}));
  ASSERT_TRUE(favourite("disc-22"));
  ASSERT_TRUE(favourite("round-010"));
  EXPECT_EQ(shown(), (Ids{"disc-22", "round-010", "round-014"}));
  EXPECT_EQ(shown("round"), (Ids{"round-010", "round-014"})) << "of what is searched for, too";
  ASSERT_TRUE(favourite("disc-22"));
  EXPECT_EQ(shown(), (Ids{"round-010", "round-014", "disc-22"})) << "again: no longer";
}

TEST_F(ToolRackTest, FavouritesAreKeptInTheSettings) {
  ASSERT_TRUE(favourite("disc-22"));
  ASSERT_TRUE(favourite(""));  // the tool in hand
  EXPECT_EQ(SettingsFile(folder_.path() / "config").values.favourite_tools, (Ids{"disc-22", "round-014"}));
  ASSERT_TRUE(favourite("disc-22"));
  EXPECT_EQ(SettingsFile(folder_.path() / "config").values.favourite_tools, Ids{"round-014"});

  const auto refused = favourite("no-such-tool");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Error::Code::kBadValue);
  EXPECT_EQ(settings_.values.favourite_tools, Ids{"round-014"});
  AppContext without{.bench = bench_, .camera = camera_};
  EXPECT_FALSE(runAppCommand(without, "tool.favourite")) << "nothing would be kept";
}

TEST_F(ToolRackTest, AFavouriteThatIsNotThereTodayStaysOne) {
  fs::create_directories(folder_.path() / "config");
  folder_.write("config/settings.toml", "favourite_tools = \"gone-022 disc-22 disc-22\"\n");
  SettingsFile kept(folder_.path() / "config");
  ASSERT_FALSE(kept.error());
  EXPECT_EQ(kept.values.favourite_tools, (Ids{"gone-022", "disc-22"})) << "each once";
  settings_.values = kept.values;
  EXPECT_EQ(shown(), (Ids{"disc-22", "round-014", "round-010"}));
}

const char* const kBur =
    "format = \"kerf-tool\"\nversion = 1\nid = \"mine\"\nname = \"My bur\"\ndescription = \"\"\nkind = \"bur\"\n"
    "shape = \"round\"\nhead_diameter = 2.2\nneck_diameter = 0.9\nneck_length = 3.6\nshank_diameter = 1.6\n"
    "shank_length = 10\n";

TEST_F(ToolRackTest, AFileThatIsNoToolStandsInTheRackUntilItIsOne) {
  const fs::path file = folder_.write("mine.toml", std::string(kBur) + "head_diamter = 3\n");
  bench_.tools->add(file);
  ASSERT_EQ(bench_.tools->broken().size(), 1u);
  EXPECT_EQ(bench_.tools->broken()[0].file, file);
  EXPECT_NE(bench_.tools->broken()[0].error.message().find("head_diamter"), std::string::npos);
  EXPECT_EQ(bench_.tools->count(), 3u);

  rewrite(file, kBur);
  ASSERT_TRUE(comes([&] { return bench_.tools->broken().empty() && isInHand("mine"); })) << "it was asked for";
  ASSERT_EQ(bench_.tools->count(), 4u);

  // Broken again: the tool stays as read, with the error in its row.
  EXPECT_FALSE(bench_.tools->error(3));
  rewrite(file, std::string(kBur) + "neck = 3\n");
  ASSERT_TRUE(comes([&] { return bench_.tools->error(3) != nullptr; }));
  EXPECT_NE(bench_.tools->error(3)->message().find("neck"), std::string::npos);
  EXPECT_TRUE(isInHand("mine"));
  EXPECT_EQ(bench_.tools->at(3).head_diameter_mm, 2.2);
  EXPECT_TRUE(bench_.tools->broken().empty());
  rewrite(file, kBur);
  EXPECT_TRUE(comes([&] { return bench_.tools->error(3) == nullptr; }));
}

TEST_F(ToolRackTest, TheNextToolIsTheNextOneThatIsSeen) {
  ASSERT_TRUE(favourite("disc-22"));
  ASSERT_TRUE(favourite("round-010"));
  ASSERT_EQ(shown(), (Ids{"disc-22", "round-010", "round-014"}));
  const auto after = [&](const char* command) {
    EXPECT_TRUE(runAppCommand(context_, command));
    return bench_.tools->at(bench_.tools->inHand()).id;
  };
  ASSERT_TRUE(bench_.tools->select("disc-22"));
  EXPECT_EQ(after("tool.next"), "round-010");
  EXPECT_EQ(after("tool.next"), "round-014");
  EXPECT_EQ(after("tool.next"), "disc-22") << "behind the last one comes the first";
  EXPECT_EQ(after("tool.previous"), "round-014");
  EXPECT_EQ(after("tool.previous"), "round-010");
}

TEST_F(ToolRackTest, OfAToolThatIsTooThinForTheVoxelsItTellsOnce) {
  WorkbenchOptions coarse = in(folder_);
  coarse.data_folder = folder_.path() / "other data";
  coarse.voxel_mm = 0.15;
  Workbench bench(coarse);
  bench.tools->takeRack(true);
  bench.sessions->open(folder_.path() / "block.ply");
  const auto isDone = [&] {
    bench.update();
    return !bench.jobs->running();
  };
  ASSERT_TRUE(comes(isDone));

  const auto told = [&] {
    return std::count_if(bench.notices->list().begin(), bench.notices->list().end(), [](const Notice& notice) {
      return !notice.is_error && notice.text.find("disc-22 cuts 1.3 voxels wide") != std::string::npos;
    });
  };
  EXPECT_EQ(told(), 0) << "another tool is in hand";
  for (const char* id : {"disc-22", "round-010", "disc-22"}) ASSERT_TRUE(bench.tools->select(id));
  EXPECT_EQ(told(), 1);
  bench.sessions->close();
  EXPECT_TRUE(comes(isDone));
}

TEST_F(ToolRackTest, ABrokenFileThatTheProgramWasToldOfIsWatched) {
  const fs::path file = folder_.write("mine.toml", std::string(kBur) + "head_diamter = 3\n");
  WorkbenchOptions told = in(folder_);
  told.data_folder = folder_.path() / "other data";
  told.tools = {"round-014", file.string()};
  Workbench bench(told);
  bench.tools->takeRack(true);
  ASSERT_EQ(bench.tools->broken().size(), 1u);
  EXPECT_EQ(bench.tools->broken()[0].file, file);
  rewrite(file, kBur);
  EXPECT_TRUE(comes([&] {
    bench.update();
    return bench.tools->broken().empty();
  }));
  EXPECT_NE(bench.notices->list().back().text.find("is now readable and in the rack"), std::string::npos)
      << bench.notices->list().back().text;
}

// ---- While the tools are still being read

TEST_F(ToolRackTest, IsReadBesideTheWindowAndWhatIsOpenedMeanwhileHasAllOfIt) {
  const fs::path broken = folder_.write("broken.toml", std::string(kBur) + "head_diamter = 3\n");
  WorkbenchOptions told = in(folder_);
  told.data_folder = folder_.path() / "other data";
  told.tools.push_back(broken.string());
  Workbench bench(told);
  EXPECT_TRUE(bench.tools->isReading()) << "who makes the window does not wait";
  EXPECT_TRUE(bench.tools->broken().empty());
  EXPECT_TRUE(bench.notices->list().empty());

  bench.sessions->open(folder_.path() / "block.ply");
  ASSERT_TRUE(bench.jobs->running()) << "it is not refused either";
  ASSERT_TRUE(comes([&] {
    bench.update();
    return !bench.jobs->running();
  }));
  ASSERT_TRUE(bench.document->isOpen());
  EXPECT_FALSE(bench.tools->isReading());
  EXPECT_EQ(bench.tools->count(), 3u);
  EXPECT_EQ(bench.tools->firstLook(), 3u);
  EXPECT_TRUE(bench.tools->select("disc-22"));

  // The error appears as a notice and in the rack.
  ASSERT_EQ(bench.tools->broken().size(), 1u);
  EXPECT_EQ(bench.tools->broken()[0].file, broken);
  EXPECT_TRUE(std::any_of(bench.notices->list().begin(), bench.notices->list().end(), [](const Notice& notice) {
    return notice.is_error && notice.text.find("head_diamter") != std::string::npos;
  }));
  bench.sessions->close();
  EXPECT_TRUE(comes([&] {
    bench.update();
    return !bench.jobs->running();
  }));
}

TEST_F(ToolRackTest, AToolDroppedMeanwhileComesBehindTheOthers) {
  const fs::path mine = folder_.write("mine.toml", kBur);
  WorkbenchOptions told = in(folder_);
  told.data_folder = folder_.path() / "other data";
  Workbench bench(told);
  bench.tools->add(mine);
  EXPECT_FALSE(bench.tools->isReading());
  bench.sessions->open(folder_.path() / "block.ply");
  ASSERT_TRUE(comes([&] {
    bench.update();
    return !bench.jobs->running();
  }));
  ASSERT_EQ(bench.tools->count(), 4u);
  EXPECT_EQ(bench.tools->at(3).id, "mine");
  bench.sessions->close();
  EXPECT_TRUE(comes([&] {
    bench.update();
    return !bench.jobs->running();
  }));
}

// A point of 2 x 2 mm at its widest, of that length upwards from (0, 0, 0).
Mesh pointedTool(double length) {
  Mesh out;
  out.vertices = {{0, 0, 0},      {1, 1, 2},       {-1, 1, 2},       {-1, -1, 2},    {1, -1, 2},
                  {1, 1, length}, {-1, 1, length}, {-1, -1, length}, {1, -1, length}};
  for (std::uint32_t k = 0; k < 4; ++k) {
    const std::uint32_t a = 1 + k, b = 1 + (k + 1) % 4;
    out.triangles.push_back({0, b, a});
    out.triangles.push_back({a, b, b + 4});
    out.triangles.push_back({a, b + 4, a + 4});
  }
  out.triangles.push_back({5, 6, 7});
  out.triangles.push_back({5, 7, 8});
  return out;
}

const char* const kPoint =
    "format = \"kerf-tool\"\nversion = 1\nid = \"point\"\nname = \"Point\"\nkind = \"mesh\"\nmesh = \"point.stl\"\n"
    "mm_per_unit = 1.0\ntip = [0.0, 0.0, 0.0]\naxis = [0.0, 0.0, 1.0]\ncut_below = 4.0\n";

TEST_F(ToolRackTest, AFileWhoseMeshIsBrokenIsAToolAsSoonAsTheMeshIsMended) {
  const fs::path mesh = folder_.write("point.stl", "solid nothing\n");
  bench_.tools->add(folder_.write("point.toml", kPoint));
  ASSERT_EQ(bench_.tools->broken().size(), 1u);
  ASSERT_TRUE(writeMesh(mesh, pointedTool(10)));
  fs::last_write_time(mesh, fs::file_time_type::clock::now() + std::chrono::seconds(5));
  EXPECT_TRUE(comes([&] { return bench_.tools->broken().empty() && isInHand("point"); }));
}

TEST_F(ToolRackTest, AToolMadeOfAMeshIsReadAnewWhenItsMeshChanges) {
  const fs::path mesh = folder_.path() / "point.stl";
  ASSERT_TRUE(writeMesh(mesh, pointedTool(10)));
  bench_.tools->add(folder_.write("point.toml", kPoint));
  ASSERT_TRUE(comes([&] { return isInHand("point"); })) << bench_.notices->list().back().text;
  const auto length = [&] {
    return isInHand("point") ? bounds(*bench_.tools->at(bench_.tools->inHand()).mesh).max[2] : 0;
  };
  EXPECT_NEAR(length(), 10, 1e-5);

  ASSERT_TRUE(writeMesh(mesh, pointedTool(14)));
  fs::last_write_time(mesh, fs::file_time_type::clock::now() + std::chrono::seconds(5));
  EXPECT_TRUE(comes([&] { return length() > 13; }));
  EXPECT_NEAR(length(), 14, 1e-5);

  // A file that is no mesh: the row shows the error.
  folder_.write("point.stl", "solid nothing\n");
  fs::last_write_time(mesh, fs::file_time_type::clock::now() + std::chrono::seconds(10));
  EXPECT_TRUE(comes([&] { return bench_.tools->error(3) != nullptr; }));
  EXPECT_NEAR(length(), 14, 1e-5) << "the tool is as it was read";
}

}  // namespace
}  // namespace kerf::tool_rack_test
