// A dropped mesh becomes a tool: the displayed guess, the files, the rack, a hole.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "geometry/formats/mesh_writer.h"
#include "geometry/tool/tool_file.h"
#include "tests/geometry/turned_rod.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/commands/import_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/import/tool_plan.h"
#include "ui/app/script/app_script.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/scene_neighbours.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/tools.h"

namespace kerf::import_tool_test {
namespace {

namespace fs = std::filesystem;

class ImportToolTest : public testing::Test {
 protected:
  WorkbenchOptions options() const {
    WorkbenchOptions out;
    out.data_folder = folder_.path() / "data";
    out.tools = {"round-014"};
    out.real_time = {.priority = 0, .lock_memory = false};
    return out;
  }
  ~ImportToolTest() override {
    while (bench_.jobs->running()) bench_.update();
    bench_.sessions->close();
    while (bench_.jobs->running()) bench_.update();
  }
  Expected<void> play(const std::string& script) {
    return runScript(context_, folder_.write("script.ks", script), [&] { bench_.update(); });
  }
  void mustPlay(const std::string& script) {
    const auto played = play(script);
    ASSERT_TRUE(played) << played.error().message();
  }
  std::string written(const std::string& name, const Mesh& mesh) const {
    const fs::path file = folder_.path() / name;
    EXPECT_TRUE(writeMesh(file, mesh));
    return "\"" + file.string() + "\"";
  }
  std::string said() const {
    std::string out;
    for (const Notice& notice : bench_.notices->list()) out += notice.text + "\n";
    return out;
  }
  fs::path toolFolder() const { return folder_.path() / "data" / "tools"; }

  TemporaryFolder folder_;
  Workbench bench_{options()};
  Camera camera_ = *cameraFromView("top");
  AppContext context_{.bench = bench_, .camera = camera_, .width = 400, .height = 300};
};

TEST_F(ImportToolTest, VerticesThatNoTriangleHasDoNotSpoilTheGuess) {
  const std::vector<ToolWay> right = toolWays(handpiece());
  Mesh mesh = handpiece();
  mesh.vertices.insert(mesh.vertices.begin(), {Vec3d(3, 90, 5), Vec3d(3, -90, 5), Vec3d(-70, -70, -70)});
  for (Triangle& t : mesh.triangles)
    for (std::uint32_t& v : t) v += 3;
  const std::vector<ToolWay> ways = toolWays(mesh);
  ASSERT_EQ(ways.size(), right.size());
  EXPECT_EQ(ways[0].name, "-y");
  EXPECT_EQ(ways[0].tip, right[0].tip);
  EXPECT_EQ(ways[0].tip_width_mm, right[0].tip_width_mm);

  mustPlay("import.read " + written("bur.ply", mesh) + "\nwait\nimport.role 1 tool\nimport.start\nwait\n");
  EXPECT_TRUE(readTool(toolFolder() / "bur.toml")) << said();
}

TEST_F(ImportToolTest, ItIsWrittenIsInHandAndDrills) {
  const std::string scan = written("scan.ply", test::blockMesh(false));
  mustPlay("file.open " + scan + "\nwait\nview.fit\n");
  const std::uint64_t before = bench_.document->generation();
  mustPlay("import.read " + written("My Bur (2).obj", handpiece()) + "\nwait\nimport.role 1 tool\n");
  const ImportSet* const set = bench_.imports->set();
  ASSERT_TRUE(set && set->tool());
  EXPECT_FALSE(set->tool()->isDoubtful());
  const auto state = nlohmann::json::parse(import_commands::importState(*set));
  EXPECT_EQ(state["tool"]["way"], "-y");
  EXPECT_EQ(state["files"][0]["role"], "tool");

  mustPlay("import.tool-cut 3\nimport.start\nwait\nwait 0.2\n");
  EXPECT_FALSE(bench_.imports->isImporting());
  ASSERT_TRUE(bench_.document->isOpen());
  EXPECT_GT(bench_.document->generation(), before) << "the session goes on with it";
  EXPECT_EQ(bench_.tools->at(bench_.tools->inHand()).id, "my-bur-2") << said();
  const auto tool = readTool(toolFolder() / "my-bur-2.toml");
  ASSERT_TRUE(tool) << tool.error().message();
  EXPECT_EQ(tool->name, "My Bur (2)");
  EXPECT_EQ(tool->cut_below_mm, 3);
  EXPECT_NEAR(bounds(*tool->mesh).min[2], 0, 1e-4);
  EXPECT_NEAR(bounds(*tool->mesh).max[2], 30, 1e-3);
  EXPECT_NE(contentOf(toolFolder() / "my-bur-2.toml").find("read as mm"), std::string::npos);

  mustPlay("cut.force 3\ncut.depth 0.5\ncut.press 200 150\nwait 4\ncut.release\nwait 0.2\n");
  EXPECT_GT(bench_.document->removedMm3(), 0.05);
}

TEST_F(ImportToolTest, WithNothingOpenItWaitsInTheRackAndIsThereTheNextTime) {
  const std::string file = written("bur.stl", handpiece());
  mustPlay("import.read " + file + "\nwait\nimport.role 1 tool\nimport.start\nwait\n");
  EXPECT_FALSE(bench_.document->isOpen());
  EXPECT_FALSE(bench_.imports->isImporting());
  EXPECT_NE(said().find("bur is now in the rack"), std::string::npos) << said();
  // The same again: another name, and no overwritten file.
  mustPlay("import.read " + file + "\nwait\nimport.role 1 tool\nimport.start\nwait\n");
  EXPECT_TRUE(fs::exists(toolFolder() / "bur.toml") && fs::exists(toolFolder() / "bur-2.toml"));
  mustPlay("file.open " + written("scan.ply", test::blockMesh(false)) + "\nwait\ntool.select bur\n");

  WorkbenchOptions later = options();
  later.tools.clear();  // the whole rack
  Workbench again(later);
  Camera camera;
  AppContext context{.bench = again, .camera = camera};
  const auto opened = runScript(context,
                                folder_.write("again.ks", "file.open \"" + (folder_.path() / "scan.ply").string() +
                                                              "\"\nwait\ntool.select bur\n"),
                                [&] { again.update(); });
  EXPECT_TRUE(opened) << opened.error().message();
  again.sessions->close();
  while (again.jobs->running()) again.update();
}

// If two tools have one id, the rack shows the catalogue's: the other one would be gone at the next start.
TEST_F(ImportToolTest, AnIdOfTheCatalogueOrOfTheRackIsNotTakenAgain) {
  // In the catalogue, but not in this rack.
  mustPlay("import.read " + written("us-330.stl", handpiece()) + "\nwait\nimport.role 1 tool\nimport.start\nwait\n");
  EXPECT_FALSE(fs::exists(toolFolder() / "us-330.toml"));
  ASSERT_TRUE(fs::exists(toolFolder() / "us-330-2.toml")) << said();
  EXPECT_EQ(readTool(toolFolder() / "us-330-2.toml")->id, "us-330-2");

  // In the rack, from a folder that is neither the catalogue's nor the user's.
  fs::create_directories(folder_.path() / "elsewhere");
  bench_.tools->add(folder_.write("elsewhere/mine.toml",
                                  "format = \"kerf-tool\"\nversion = 1\nid = \"mine\"\nname = \"My bur\"\nkind = "
                                  "\"bur\"\nshape = \"round\"\nhead_diameter = 2.2\nneck_diameter = 0.9\nneck_length = "
                                  "3.6\nshank_diameter = 1.6\nshank_length = 10\n"));
  mustPlay("import.read " + written("mine.stl", handpiece()) + "\nwait\nimport.role 1 tool\nimport.start\nwait\n");
  EXPECT_FALSE(fs::exists(toolFolder() / "mine.toml"));
  EXPECT_TRUE(fs::exists(toolFolder() / "mine-2.toml")) << said();
}

TEST_F(ImportToolTest, WhenOneOfTwoFailsNoneIsLeft) {
  const Mesh pole = turned({{0, 0.7}, {60, 0.7}}, Vec3d::Zero(), Vec3d::UnitZ());
  mustPlay("import.read " + written("bur.ply", handpiece()) + " " + written("pole.ply", pole) +
           "\nwait\nimport.role 1 tool\nimport.role 2 tool\nimport.choose 2\nimport.unit cm\n");
  const auto refused = play("import.start\nwait\n");
  ASSERT_FALSE(refused) << "longer than any tool";
  EXPECT_NE(refused.error().message().find("600"), std::string::npos) << refused.error().message();
  EXPECT_TRUE(bench_.imports->isImporting()) << "for another try";
  EXPECT_TRUE(!fs::exists(toolFolder()) || fs::is_empty(toolFolder()));

  // A script would end at that error; a person continues.
  ASSERT_TRUE(bench_.imports->plan()->setUnit("mm"));
  bench_.imports->start();
  do bench_.update();
  while (bench_.jobs->running());
  EXPECT_TRUE(fs::exists(toolFolder() / "bur.toml") && fs::exists(toolFolder() / "pole.toml")) << said();
  EXPECT_FALSE(fs::exists(toolFolder() / "bur-2.toml"));
}

TEST_F(ImportToolTest, UnitAndAxisAreThoseThatWereChosen) {
  Mesh inches = handpiece();
  for (Vec3d& p : inches.vertices) p /= 25.4;
  mustPlay("import.read " + written("bur.ply", inches) + "\nwait\nimport.role 1 tool\nimport.unit inch\n");
  const ImportSet* const set = bench_.imports->set();
  ASSERT_TRUE(set && set->tool());
  EXPECT_NEAR(set->tool()->way().tip_width_mm, 1.4, 0.02) << "of the unit that is chosen";
  mustPlay("import.unit mm\n");
  EXPECT_LT(set->tool()->way().tip_width_mm, 0.5);
  mustPlay("import.unit inch\nimport.tool-axis +y\n");
  EXPECT_EQ(set->tool()->way().name, "+y");
  EXPECT_FALSE(play("import.tool-axis up\n"));
  EXPECT_FALSE(play("import.tool-cut 90\n"));

  mustPlay("import.tool-cut 2\nimport.start\nwait\n");
  const auto tool = readTool(toolFolder() / "bur.toml");
  ASSERT_TRUE(tool) << tool.error().message();
  EXPECT_NEAR(bounds(*tool->mesh).max[2], 30, 1e-3);
  // By its thick end.
  EXPECT_NEAR(bounds(*tool->mesh).max[0], 6, 0.1);
  EXPECT_GT(tool->cut->bounds().size()[0], 11);
}

TEST_F(ImportToolTest, AnEndThatIsHardlyThinnerIsDoubted) {
  // A rod: both ends may be the tip.
  mustPlay("import.read " + written("rod.ply", turned({{0, 0.8}, {19, 0.8}}, Vec3d::Zero(), Vec3d::UnitX())) +
           "\nwait\nimport.role 1 tool\n");
  ASSERT_TRUE(bench_.imports->set() && bench_.imports->set()->tool());
  const ToolPlan& plan = *bench_.imports->set()->tool();
  EXPECT_TRUE(plan.isDoubtful());
  ASSERT_EQ(plan.findings().size(), 1u);
  EXPECT_EQ(plan.findings()[0].weight, Finding::Weight::kDoubtful);
  mustPlay("import.tool-axis +x\n");
  EXPECT_FALSE(plan.isDoubtful()) << "somebody has looked";
}

TEST_F(ImportToolTest, AnOpenMeshIsClosedFirst) {
  Mesh open = handpiece();
  // A hole of two triangles in the handle.
  open.triangles.erase(open.triangles.end() - 4, open.triangles.end() - 2);
  mustPlay("import.read " + written("bur.ply", open) + "\nwait\nimport.role 1 tool\nimport.start\nwait\n");
  EXPECT_TRUE(readTool(toolFolder() / "bur.toml")) << said();
}

TEST_F(ImportToolTest, OfSeveralOneIsAToolAndTheOthersAreOpened) {
  Mesh beside = test::blockMesh(false);
  for (Vec3d& p : beside.vertices) p[0] += 6.3;
  mustPlay("import.read " + written("bur.ply", handpiece()) + " " + written("36.ply", test::blockMesh(false)) + " " +
           written("35.ply", beside) + "\nwait\nimport.role 1 tool\n");
  ASSERT_TRUE(bench_.imports->set() && bench_.imports->set()->cut());
  EXPECT_EQ(bench_.imports->set()->cut()->file.stem(), "36") << "it takes the place of the first";
  mustPlay("import.start\nwait\ntool.select bur\n");
  EXPECT_EQ(bench_.document->name(), "36");
  EXPECT_EQ(bench_.neighbours->list().size(), 1u);
}

TEST_F(ImportToolTest, AScanThatIsDroppedMayStandBesideWhatIsOpen) {
  mustPlay("file.open " + written("36.ply", test::blockMesh(false)) + "\nwait\n");
  Mesh beside = test::blockMesh(false);
  for (Vec3d& p : beside.vertices) p[0] += 6.3;
  mustPlay("import.read " + written("35.ply", beside) + "\nwait\nimport.role 1 beside\nimport.start\nwait\n");
  EXPECT_EQ(bench_.document->name(), "36");
  ASSERT_EQ(bench_.neighbours->list().size(), 1u) << said();
  EXPECT_EQ(bench_.neighbours->list()[0].name, "35");
}

// Undo reaches as far as before.
TEST_F(ImportToolTest, WithEveryFileLeftOutWhatIsOpenGoesOnAsItIs) {
  mustPlay("file.open " + written("36.ply", test::blockMesh(false)) + "\nwait\n");
  const std::uint64_t before = bench_.document->generation();
  const fs::path session = bench_.document->sessionFolder();
  mustPlay("import.read " + written("bur.ply", handpiece()) + "\nwait\nimport.role 1 out\nimport.start\nwait\n");
  EXPECT_FALSE(bench_.imports->isImporting());
  EXPECT_TRUE(bench_.document->isOpen());
  EXPECT_EQ(bench_.document->generation(), before);
  EXPECT_EQ(bench_.document->sessionFolder(), session);
  EXPECT_NE(said().find("Nothing imported"), std::string::npos) << said();
}

TEST_F(ImportToolTest, WithNothingOpenSomethingIsCut) {
  mustPlay("import.read " + written("36.ply", test::blockMesh(false)) + "\nwait\n");
  const auto refused = play("import.role 1 beside\n");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("no file with the role cut"), std::string::npos);
  mustPlay("import.role 1 tool\nimport.role 1 cut\nimport.start\nwait\n");
  EXPECT_TRUE(bench_.document->isOpen());
}

}  // namespace
}  // namespace kerf::import_tool_test
