#include "ui/app/import/import_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "geometry/case/case_bundle.h"
#include "geometry/formats/mesh_writer.h"
#include "tests/preprocess/label_volume_samples.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/commands/import_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/script/app_script.h"
#include "ui/app/workbench/imports.h"
#include "ui/app/workbench/scene_neighbours.h"

namespace kerf::import_set_test {
namespace {

namespace fs = std::filesystem;

class ImportSetTest : public testing::Test {
 protected:
  // A block of 6 x 4 x 3 mm without its underside, like a scan, with its middle at x.
  fs::path block(const std::string& name, double x) const {
    Mesh mesh = test::blockMesh(false);
    for (Vec3d& p : mesh.vertices) p[0] += x;
    const fs::path file = folder_.path() / (name + ".ply");
    EXPECT_TRUE(writeMesh(file, mesh));
    return file;
  }
  // 30 x 20 x 20 voxels of 0.3 mm: a ball of label 2, in which one of label 7 lies, and air around.
  fs::path volume(const std::string& names = "") const {
    const Vec3d middle(15, 10, 10);
    std::string values;
    for (int k = 0; k < 20; ++k)
      for (int j = 0; j < 20; ++j)
        for (int i = 0; i < 30; ++i) {
          const double r = (Vec3d(i, j, k) - middle).norm();
          values += static_cast<char>(r < 3 ? 7 : r < 8 ? 2 : 0);
        }
    return folder_.write("ct.nrrd",
                         "NRRD0004\ntype: unsigned char\ndimension: 3\nsizes: 30 20 20\nencoding: raw\nspace: "
                         "left-posterior-superior\nspace directions: (0.3,0,0) (0,0.3,0) (0,0,0.3)\nspace origin: "
                         "(0,0,0)\n" +
                             names + "\n" + values);
  }
  static constexpr const char* kNames =
      "Segment0_LabelValue:=2\nSegment0_Name:=Mandible bone\nSegment1_LabelValue:=7\nSegment1_Name:=Mandibular "
      "canal\n";

  Expected<void> play(Workbench& bench, const std::string& script) {
    Camera camera = *cameraFromView("top");
    AppContext context{.bench = bench, .camera = camera, .width = 400, .height = 300};
    return runScript(context, folder_.write("script.ks", script), [&] { bench.update(); });
  }
  void mustPlay(Workbench& bench, const std::string& script) {
    const auto played = play(bench, script);
    ASSERT_TRUE(played) << played.error().message();
  }
  WorkbenchOptions options() const {
    WorkbenchOptions out;
    out.data_folder = folder_.path() / "data";
    out.tools = {"round-014"};
    out.real_time = {.priority = 0, .lock_memory = false};
    return out;
  }
  static std::string quoted(const fs::path& path) { return " \"" + path.string() + "\""; }
  TemporaryFolder folder_;
};

// ---- Several scans

TEST_F(ImportSetTest, OfSeveralScansOneIsCutAndTheOthersStandBesideAsChosen) {
  Workbench bench(options());
  mustPlay(bench,
           "import.read" + quoted(block("36", 0)) + quoted(block("35", 7)) + quoted(block("37", -7)) + "\nwait\n");
  ASSERT_TRUE(bench.imports->set());
  const auto& entries = bench.imports->set()->entries();
  ASSERT_EQ(entries.size(), 3u);
  EXPECT_EQ(entries[0].role, ImportRole::kCut);
  EXPECT_EQ(entries[1].role, ImportRole::kBeside);
  EXPECT_EQ(bench.imports->set()->chosen(), 0u);

  // Each scan has its own remedies. Exactly one scan is the work object.
  mustPlay(bench, "import.role 2 cut\nimport.role 3 out\nimport.choose 1\nimport.base full 5\nimport.voxel 0.2\n");
  EXPECT_EQ(entries[0].role, ImportRole::kBeside);
  EXPECT_EQ(bench.imports->set()->cut()->file.stem(), "35");
  EXPECT_EQ(entries[1].scan->closing(), ClosingChoice{}) << "another file's base stays as it was";
  EXPECT_FALSE(play(bench, "import.role 2 out\n")) << "one has to be cut";
  EXPECT_EQ(bench.imports->set()->cut()->file.stem(), "35");

  mustPlay(bench, "import.start\nwait\n");
  ASSERT_TRUE(bench.document->isOpen());
  EXPECT_EQ(bench.document->name(), "35");
  ASSERT_EQ(bench.neighbours->list().size(), 1u) << "37 was left out";
  EXPECT_EQ(bench.neighbours->list()[0].name, "36");
  const CaseManifest& beside = bench.document->run()->neighbours()[0].known.manifest;
  EXPECT_NEAR(beside.box.size()[2], 3 + 5, 1e-3) << "the base that was chosen for it";
  EXPECT_EQ(beside.voxel_mm, 0.2);
  EXPECT_EQ(bench.document->run()->caseManifest().voxel_mm, 0.1);
}

TEST_F(ImportSetTest, FilesInDifferentUnitsAreNotPreparedUntilAUnitIsChosen) {
  Mesh metres = test::blockMesh(false);
  for (Vec3d& p : metres.vertices) p *= 1e-3;
  const fs::path small = folder_.path() / "metres.ply";
  ASSERT_TRUE(writeMesh(small, metres));
  Workbench bench(options());
  mustPlay(bench, "import.read" + quoted(block("36", 0)) + quoted(small) + "\nwait\n");
  ASSERT_TRUE(bench.imports->set());
  const auto& findings = bench.imports->set()->findings();
  EXPECT_TRUE(std::any_of(findings.begin(), findings.end(), [](const Finding& f) { return f.about == "Unit"; }));
  const auto ready = bench.imports->set()->requireReady();
  ASSERT_FALSE(ready);
  EXPECT_EQ(ready.error().place, "unit") << ready.error().message();

  mustPlay(bench, "import.choose 2\nimport.unit m\n");
  EXPECT_TRUE(bench.imports->set()->requireReady());
}

TEST_F(ImportSetTest, OneMoreIsAddedToWhatIsLookedAt) {
  Workbench bench(options());
  mustPlay(bench, "import.read" + quoted(block("36", 0)) + "\nwait\nimport.base full 5\n");
  EXPECT_FALSE(play(bench, "import.role 1 beside\n")) << "there is one alone";
  mustPlay(bench, "import.add" + quoted(block("35", 7)) + "\nwait\n");
  ASSERT_EQ(bench.imports->set()->entries().size(), 2u);
  EXPECT_EQ(bench.imports->set()->chosen(), 1u) << "the new one is shown";
  EXPECT_EQ(bench.imports->set()->entries()[0].scan->closing().base_mm, 5) << "what was decided stays";
  EXPECT_EQ(bench.imports->set()->entries()[1].role, ImportRole::kBeside);
}

TEST_F(ImportSetTest, AFileThatIsNoneLeavesWhatIsLookedAtAlone) {
  Workbench bench(options());
  mustPlay(bench, "import.read" + quoted(block("36", 0)) + "\nwait\n");
  EXPECT_FALSE(play(bench, "import.add" + quoted(folder_.write("broken.stl", "solid")) + "\nwait\n"));
  ASSERT_TRUE(bench.imports->set());
  EXPECT_EQ(bench.imports->set()->entries().size(), 1u);
}

TEST_F(ImportSetTest, ScansThatAreFarApartAreDoubtedBeforeTheyArePrepared) {
  Workbench bench(options());
  mustPlay(bench, "import.read" + quoted(block("36", 0)) + quoted(block("far", 90)) + "\nwait\n");
  const auto findings = bench.imports->set()->findings();
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_NE(findings[0].text.find("far.ply is 84 mm away"), std::string::npos) << findings[0].text;
  mustPlay(bench, "import.role 2 out\n");
  EXPECT_TRUE(bench.imports->set()->findings().empty());
}

TEST_F(ImportSetTest, ACaseAmongThemStandsAsItIs) {
  Workbench bench(options());
  mustPlay(bench, "file.open" + quoted(block("35", 7)) + "\nwait\nfile.close\nwait\n");
  const fs::path prepared = fs::directory_iterator(folder_.path() / "data" / "cases")->path();
  mustPlay(bench, "import.read" + quoted(block("36", 0)) + quoted(prepared) + "\nwait\nimport.choose 2\n");
  EXPECT_FALSE(bench.imports->plan());
  EXPECT_FALSE(play(bench, "import.base full 3\n")) << "nothing is decided about a case";
  mustPlay(bench, "import.start\nwait\n");
  ASSERT_EQ(bench.neighbours->list().size(), 1u);
  EXPECT_EQ(bench.document->name(), "36");
}

TEST_F(ImportSetTest, ThePictureShowsAllThatIsNotLeftOut) {
  Workbench bench(options());
  mustPlay(bench, "import.read" + quoted(block("36", 0)) + quoted(block("35", 7)) + "\nwait\n");
  ASSERT_TRUE(bench.imports->set()->preview()) << "a script waits for it";
  ImportPicture picture = bench.imports->set()->picture(true);
  ASSERT_EQ(picture.parts.size(), 2u);
  EXPECT_FALSE(picture.parts[0].is_beside);
  EXPECT_TRUE(picture.parts[1].is_beside);
  EXPECT_EQ(picture.parts[0].mesh, bench.imports->set()->preview()->solid);
  EXPECT_NEAR(picture.box.size()[0], 13, 1e-5);
  mustPlay(bench, "import.role 2 out\n");
  EXPECT_EQ(bench.imports->set()->picture(true).parts.size(), 1u);
}

// ---- Labels of a CT

TEST_F(ImportSetTest, LabelsOfACtAreListedWithTheirNamesAndVolumes) {
  Workbench bench(options());
  mustPlay(bench, "import.read" + quoted(volume(kNames)) + "\nwait\n");
  ASSERT_TRUE(bench.imports->set());
  const LabelPlan* const plan = bench.imports->set()->labels();
  ASSERT_TRUE(plan);
  ASSERT_EQ(plan->found().labels.size(), 2u);
  EXPECT_EQ(plan->found().labels[0].called(), "Mandible bone");
  EXPECT_EQ(plan->found().labels[1].label, 7);
  const double voxels = static_cast<double>(plan->found().labels[1].voxels);
  EXPECT_NEAR(plan->found().labels[1].volume_mm3, voxels * 0.027, 1e-9);
  EXPECT_EQ(plan->tissue(2), Material::kCortical);
  EXPECT_EQ(plan->tissue(7), Material::kNerveCanal);

  // A ball of 2.4 mm: 72 mm2.
  const double area = 4 * M_PI * 2.4 * 2.4;
  ASSERT_TRUE(plan->preview()) << "a script waits for it";
  EXPECT_NEAR(plan->preview()->area_mm2, area, 0.05 * area);
  EXPECT_NEAR(plan->preview()->volume_mm3, plan->volumeMm3(), 0.01 * plan->volumeMm3());
  LabelPlan unseen(plan->found(), plan->materials());
  EXPECT_NEAR(unseen.areaMm2(), area, 0.15 * area) << "from the faces of voxels, before the surface is there";
  EXPECT_GT(unseen.prediction().bytes, 0);

  const auto state = nlohmann::json::parse(import_commands::importState(*bench.imports->set()));
  EXPECT_EQ(state["labels"][1]["tissue"], "nerve_canal");
  EXPECT_EQ(state["files"][0]["what"], "labels of a CT");
}

TEST_F(ImportSetTest, LabelsAreCutAsTheTissuesThatWereChosen) {
  Workbench bench(options());
  mustPlay(bench, "import.read" + quoted(volume()) + "\nwait\n");
  EXPECT_EQ(bench.imports->set()->labels()->tissue(2), Material::kGeneric) << "no name, no tissue of its own";
  EXPECT_FALSE(play(bench, "import.tissue 3 dentin\n")) << "there is no label 3";
  EXPECT_FALSE(play(bench, "import.tissue 2 wood\n"));
  mustPlay(bench, "import.tissue 2 dentin\nimport.tissue 7 pulp\nimport.voxel 0.15\nimport.start\nwait\n");
  ASSERT_TRUE(bench.document->isOpen());
  EXPECT_EQ(bench.document->name(), "ct");
  EXPECT_EQ(bench.document->source(), folder_.path() / "ct.nrrd");
  const CaseManifest& made = bench.document->run()->caseManifest();
  EXPECT_EQ(made.voxel_mm, 0.15);
  ASSERT_EQ(made.parts.size(), 2u);
  EXPECT_EQ(made.parts[0].material, "dentin");
  EXPECT_EQ(made.parts[1].material, "pulp");
  EXPECT_FALSE(bench.document->structures()->isEmpty()) << "a pulp is kept an eye on";
}

TEST_F(ImportSetTest, ALabelThatIsLeftOutIsAir) {
  Workbench bench(options());
  mustPlay(bench, "import.read" + quoted(volume()) + "\nwait\nimport.tissue 7 none\nwait\n");
  const LabelPlan& plan = *bench.imports->set()->labels();
  ASSERT_TRUE(plan.preview());
  EXPECT_NEAR(plan.preview()->volume_mm3, plan.found().labels[0].volume_mm3, 0.02 * plan.found().labels[0].volume_mm3);
  mustPlay(bench, "import.tissue 2 none\n");
  const auto refused = play(bench, "import.start\n");
  ASSERT_FALSE(refused) << "nothing would be there";
  EXPECT_NE(refused.error().message().find("all labels are skipped"), std::string::npos) << refused.error().message();
  EXPECT_TRUE(bench.imports->set());
}

TEST_F(ImportSetTest, AVolumeThatIsOpenedAtOnceTakesItsTissuesByName) {
  Workbench bench(options());
  mustPlay(bench, "file.open" + quoted(volume(kNames)) + "\nwait\n");
  ASSERT_TRUE(bench.document->isOpen());
  ASSERT_EQ(bench.document->run()->caseManifest().parts.size(), 2u);
  EXPECT_EQ(bench.document->run()->caseManifest().parts[1].material, "nerve_canal");
}

TEST_F(ImportSetTest, ARecipeIsBakedAsItSays) {
  (void)volume();
  const fs::path recipe =
      folder_.write("ball.toml",
                    "format = \"kerf-recipe\"\nversion = 1\nname = \"Ball\"\nvoxel = 0.2\n\n[[part]]\n"
                    "material = \"dentin\"\nlabel = 2\n\n[labels]\nvolume = \"ct.nrrd\"\n");
  Workbench bench(options());
  mustPlay(bench, "import.read" + quoted(recipe) + "\nwait\n");
  EXPECT_FALSE(bench.imports->set()) << "nothing is left to decide";
  ASSERT_TRUE(bench.document->isOpen());
  EXPECT_EQ(bench.document->run()->caseManifest().voxel_mm, 0.2);
  EXPECT_EQ(bench.document->source(), recipe);
}

TEST(TissueByName, TheMoreSpecialWordCounts) {
  EXPECT_EQ(tissueByName("Left mandibular canal"), Material::kNerveCanal);
  EXPECT_EQ(tissueByName("MANDIBLE"), Material::kCortical);
  EXPECT_EQ(tissueByName("root canal"), Material::kPulp);
  EXPECT_EQ(tissueByName("Right maxillary sinus"), std::nullopt);
  EXPECT_EQ(tissueByName("removed"), std::nullopt);
  EXPECT_EQ(tissueByName("lower first molar"), Material::kDentin);
  EXPECT_EQ(tissueByName("Segment_1"), Material::kGeneric);
  EXPECT_EQ(tissueByName(""), Material::kGeneric);
}

// `kerf-sim --voxel 0.3 --unit mm` applies to all opened files: a recipe has no panel to repeat the settings.
TEST_F(ImportSetTest, ARecipeAmongSeveralFilesIsPreparedAsTheProgramWasTold) {
  volume(kNames);
  const fs::path recipe =
      folder_.write("ball.toml",
                    "format = \"kerf-recipe\"\nversion = 1\nname = \"Ball\"\nvoxel = 0.2\n\n[[part]]\n"
                    "material = \"dentin\"\nlabel = 2\n\n[labels]\nvolume = \"ct.nrrd\"\n");
  WorkbenchOptions told = options();
  told.voxel_mm = 0.3;
  told.unit = "mm";
  Workbench bench(told);
  mustPlay(bench, "import.read" + quoted(block("36", 0)) + quoted(recipe) + "\nwait\n");
  ASSERT_TRUE(bench.imports->set());
  const PrepareOptions decided = bench.imports->set()->entries()[1].decided();
  EXPECT_EQ(decided.voxel_mm, 0.3);
  EXPECT_EQ(decided.unit, "mm");
  mustPlay(bench, "import.start\nwait\n");
  ASSERT_TRUE(bench.document->isOpen());
  ASSERT_EQ(bench.document->run()->neighbours().size(), 1u);
  EXPECT_EQ(bench.document->run()->neighbours()[0].known.manifest.voxel_mm, 0.3);
}

// ---- Folders

// CT viewers export a folder of slices. Its labels are read like those of a file.
TEST_F(ImportSetTest, AFolderOfDicomSlicesIsLookedAtAndCut) {
  const fs::path slices = folder_.path() / "segmented";
  fs::create_directories(slices);
  for (int z = 0; z < 8; ++z)
    folder_.write("segmented/" + std::to_string(z) + ".dcm",
                  dicomSlice(std::string(12, z < 4 ? '\2' : '\5'), 0.5 * z, "1.2.3", "0.5\\0.5"));
  for (const char* const end : {"", "/"}) {
    Workbench bench(options());
    mustPlay(bench, "import.read \"" + slices.string() + end + "\"\nwait\n");
    ASSERT_TRUE(bench.imports->set() && bench.imports->set()->labels());
    EXPECT_EQ(bench.imports->set()->entries()[0].what(), "labels of a CT");
    ASSERT_EQ(bench.imports->set()->labels()->found().labels.size(), 2u);
    EXPECT_NEAR(bench.imports->set()->labels()->found().labels[0].volume_mm3, 48 * 0.125, 1e-6);
    mustPlay(bench, "import.tissue 2 enamel\nimport.tissue 5 dentin\nimport.voxel 0.1\nimport.start\nwait\n");
    ASSERT_TRUE(bench.document->isOpen());
    EXPECT_EQ(bench.document->name().find("segmented"), 0u) << bench.document->name();
  }
}

TEST_F(ImportSetTest, AFolderThatIsNothingIsRefusedWithWhatToDo) {
  fs::create_directories(folder_.path() / "notes");
  folder_.write("notes/read me.txt", "hello");
  Workbench bench(options());
  const auto played = play(bench, "import.read" + quoted(folder_.path() / "notes") + "\nwait\n");
  ASSERT_FALSE(played);
  EXPECT_NE(played.error().found.find("a folder without slices"), std::string::npos) << played.error().message();
  EXPECT_NE(played.error().found.find("drop the files in it"), std::string::npos) << played.error().message();
  EXPECT_FALSE(bench.imports->isImporting());
}

TEST_F(ImportSetTest, APictureBesideMeshesIsNoSlice) {
  const fs::path folder = folder_.path() / "scans";
  fs::create_directories(folder);
  folder_.write("scans/preview.png", "");
  block("scans/upper", 0);
  Workbench bench(options());
  const auto played = play(bench, "import.read" + quoted(folder) + "\nwait\n");
  ASSERT_FALSE(played);
  EXPECT_NE(played.error().found.find("a folder with meshes"), std::string::npos) << played.error().message();
}

}  // namespace
}  // namespace kerf::import_set_test
