// Display of the demo molar's tissues. Skipped, with a message, if OpenGL is missing.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "bench/scenes/carved_field.h"
#include "geometry/mesh/mesh_check.h"
#include "sim/live/tissue_mesher.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/welded_mesh.h"
#include "tests/ui/picture_compare.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/document/view_state.h"
#include "ui/app/script/app_script.h"
#include "ui/app/view/tissue_display.h"
#include "ui/app/workbench/scene_pieces.h"
#include "ui/app/workbench/sessions.h"
#include "ui/window/draw/live_view.h"
#include "ui/window/gl/gl_context.h"

namespace kerf::tissue_picture_test {
namespace {

constexpr int kWidth = 320, kHeight = 240;

constexpr Rgba8 kEnamel = {0xf4, 0xf1, 0xe8, 255}, kDentin = {0xe8, 0xcf, 0x9a, 255}, kPulp = {0xc8, 0x43, 0x4b, 255};

/// Pixels within `most` of a colour, in each channel.
int countNear(const Image& image, const Rgba8& colour, int most = 6) {
  int n = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    bool is_near = true;
    for (std::size_t k = 0; k < 3; ++k) is_near &= std::abs(int{image.rgba[i + k]} - int{colour[k]}) <= most;
    n += is_near ? 1 : 0;
  }
  return n;
}
/// Colour of light from pulp: far more red than green and blue.
int countRed(const Image& image) {
  int n = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4)
    n += image.rgba[i] > 70 && image.rgba[i] > 1.6 * image.rgba[i + 1] && image.rgba[i] > 1.5 * image.rgba[i + 2];
  return n;
}

/// Colour of light from dentin: yellowish. Enamel is nearly grey.
int countYellow(const Image& image) {
  int n = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4)
    n += image.rgba[i] > image.rgba[i + 2] + 45 && image.rgba[i + 1] > image.rgba[i + 2] + 20;
  return n;
}

double volumeOf(const MeshChunk& chunk) {
  double out = 0;
  for (const auto& t : chunk.triangles) {
    const Vec3d a = chunk.vertices[t[0]].cast<double>(), b = chunk.vertices[t[1]].cast<double>(),
                c = chunk.vertices[t[2]].cast<double>();
    out += a.dot(b.cross(c)) / 6;
  }
  return out;
}
double volumeOf(std::span<const MeshChunkPtr> chunks) {
  double out = 0;
  for (const MeshChunkPtr& chunk : chunks) out += volumeOf(*chunk);
  return out;
}
TissueSet setOf(std::initializer_list<Material> materials) {
  TissueSet out;
  for (const Material material : materials) out.set(static_cast<std::size_t>(material));
  return out;
}

/// Opened once for all tests: each starts with the loaded scene.
class TissuePicture : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto made = OffscreenContext::create();
    if (!made) {
      why_ = made.error().message();
      return;
    }
    context_ = std::move(*made);
    view_ = std::move(*LiveView::create());
    folder_ = std::make_unique<TemporaryFolder>();
    WorkbenchOptions options;
    options.data_folder = folder_->path() / "data";
    options.tools = {"round-014"};
    options.voxel_mm = 0.15;
    options.real_time = {.priority = 0, .lock_memory = false};
    bench_ = std::make_unique<Workbench>(options);
    bench_->sessions->openDemo("molar");
    while (bench_->jobs->running() || (bench_->document->isOpen() && bench_->document->scene().triangleCount() == 0))
      frame();
  }
  static void TearDownTestSuite() {
    view_.reset();
    bench_.reset();
    context_.reset();
    folder_.reset();
  }
  void SetUp() override {
    if (!context_) GTEST_SKIP() << why_;
    ASSERT_TRUE(bench_->document->isOpen())
        << (bench_->notices->list().empty() ? "" : bench_->notices->list().back().text);
    run("view.from front");
  }
  void TearDown() override {
    if (!context_ || !bench_->document->isOpen()) return;
    bench_->views->section.reset();
    bench_->views->tissues().showAll();
    run("view.colours tissue");
  }

  static void frame() {
    view_->update(*bench_);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  /// One line of a script, and its effect.
  void run(const std::string& line) {
    const auto played = runScript(app_, folder_->write("line.ks", line + "\nwait\n"), frame);
    EXPECT_TRUE(played) << played.error().message();
  }
  Image picture() {
    view_->update(*bench_);
    auto image = view_->picture(*bench_, camera_, kWidth, kHeight);
    EXPECT_TRUE(image) << image.error().message();
    return image ? *image : Image{};
  }

  static inline std::unique_ptr<OffscreenContext> context_;
  static inline std::string why_;
  static inline std::unique_ptr<TemporaryFolder> folder_;
  static inline std::unique_ptr<Workbench> bench_;
  static inline std::unique_ptr<LiveView> view_;
  Camera camera_;
  AppContext app_{.bench = *bench_, .camera = camera_, .width = kWidth, .height = kHeight};
};

TEST_F(TissuePicture, ASectionShowsEnamelDentinAndPulpInTheirColours) {
  const Image whole = picture();
  EXPECT_EQ(countNear(whole, kPulp), 0);
  bench_->views->section = Plane{bench_->document->scene().bounds().center(), {0, -1, 0}};
  const Image front = picture();
  EXPECT_GT(countNear(front, kEnamel), 1500);
  EXPECT_GT(countNear(front, kDentin), 4000);
  EXPECT_GT(countNear(front, kPulp), 600);

  // The plane is sampled, not the view: another view shows the same tissues, a little narrower.
  run("view.from 30,20");
  const Image oblique = picture();
  EXPECT_NEAR(countNear(oblique, kPulp) / (0.8 * countNear(front, kPulp)), 1, 0.3);

  // In front of the tooth the plane cuts nothing open.
  bench_->views->section->point[1] = bench_->document->scene().bounds().min[1] - 1;
  EXPECT_EQ(countNear(picture(), kPulp), 0);
}

TEST_F(TissuePicture, ASectionOfAPieceThatIsMovedShowsWhatIsInThePiece) {
  bench_->views->section = Plane{bench_->document->scene().bounds().center(), {0, -1, 0}};
  const int before = countNear(picture(), kPulp);
  const std::uint32_t id = bench_->document->scene().shown()[0]->id;
  const Vec3d middle = bench_->document->scene().bounds().center();

  // Rotated about the axis of the view, and along the plane: the same section elsewhere.
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5, Vec3d::UnitY()));
  bench_->pieces->drag(id, Rigid3{turn, middle - turn * middle + Vec3d(1, 0, 0)});
  EXPECT_NEAR(countNear(picture(), kPulp), before, 0.15 * before);

  // Towards the viewer: another section, in front of the pulp.
  bench_->pieces->drag(id, Rigid3{Eigen::Quaterniond::Identity(), {0, 6, 0}});
  EXPECT_LT(countNear(picture(), kPulp), before / 2);
  bench_->pieces->drag(id, std::nullopt);
}

TEST_F(TissuePicture, ASessionThatIsWatchedShowsThemAsWhileItIsCut) {
  WorkbenchOptions options;
  options.data_folder = folder_->path() / "data";
  options.tools = {"round-014"};
  options.voxel_mm = 0.15;
  options.real_time = {.priority = 0, .lock_memory = false};
  Workbench bench(options);
  auto view = std::move(*LiveView::create());
  Camera camera;
  AppContext app{.bench = bench, .camera = camera, .width = kWidth, .height = kHeight};
  const auto play = [&](const std::string& lines) {
    const auto played = runScript(app, folder_->write("watch.ks", lines), [&] {
      view->update(bench);
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    });
    EXPECT_TRUE(played) << played.error().message();
  };
  const auto shot = [&] {
    view->update(bench);
    auto image = view->picture(bench, camera, kWidth, kHeight);
    EXPECT_TRUE(image) << image.error().message();
    return image ? *image : Image{};
  };
  play(
      "file.demo molar\nwait\nview.from top\ncut.force 2\ncut.press 160 120\nwait 1.5\ncut.release\nwait 0.3\n"
      "file.close\nwait\n");
  play("replay.open \"" + bench.document->sessionFolder().string() + "\"\nwait\nview.from front\n");
  ASSERT_TRUE(bench.document->watched());

  EXPECT_EQ(countNear(shot(), kPulp), 0);
  bench.views->section = Plane{bench.document->scene().bounds().center(), {0, -1, 0}};
  const Image open = shot();
  EXPECT_GT(countNear(open, kDentin), 4000);
  EXPECT_GT(countNear(open, kPulp), 600);
  bench.views->section.reset();

  const Image whole = shot();
  play("view.tissue enamel hide\nwait\n");
  EXPECT_GT(countYellow(shot()), countYellow(whole) + 3000) << "dentin under it";

  // They follow the replay.
  play("view.from top\n");
  const Image before = shot();
  // The spray cools.
  play("replay.end\nwait\nexpect same 1 1\nwait\nexpect warm 20 42.5\n");
  double difference = 0;
  for (int n = 0; n < 100 && difference < 0.05; ++n) {
    play("wait\n");
    difference = test::pictureDifference(before, shot());
  }
  EXPECT_GT(difference, 0.05) << "the stroke has gone into the dentin";
  play("view.tissues-all\nwait\n");
  const Image cut = shot();
  play("view.as-loaded on\nwait\n");
  EXPECT_GT(test::pictureDifference(cut, shot()), 0.01) << "without the cut";
  play("replay.begin\nwait\n");
  const Image as_loaded = shot();
  play("view.as-loaded off\nwait\n");
  EXPECT_EQ(shot().rgba, as_loaded.rgba);
  play("replay.close\nwait\n");
}

TEST_F(TissuePicture, WhatIsUnderAHiddenTissueIsSeen) {
  const Image whole = picture();
  run("view.tissue enamel hide");
  const Image without_enamel = picture();
  EXPECT_GT(countYellow(without_enamel), countYellow(whole) + 1500);
  EXPECT_EQ(countRed(without_enamel), 0) << "pulp is inside of dentin";

  run("view.tissue dentin hide");
  const Image pulp = picture();
  EXPECT_GT(countRed(pulp), 400) << "the colour of the nerve is visible";
  run("view.tissues-all");
  EXPECT_EQ(picture().rgba, whole.rgba);
}

TEST_F(TissuePicture, AGhostLetsThePulpShineThrough) {
  run("view.tissue enamel ghost");
  run("view.tissue dentin ghost");
  const Image with = picture();
  run("view.tissue pulp hide");
  const Image without = picture();
  int reddened = 0, changed = 0;
  for (std::size_t i = 0; i < with.rgba.size(); i += 4) {
    const int more = with.rgba[i] - with.rgba[i + 1] - (without.rgba[i] - without.rgba[i + 1]);
    reddened += more > 30;
    changed += std::abs(with.rgba[i + 1] - without.rgba[i + 1]) > 4;
  }
  EXPECT_GT(reddened, 400);
  EXPECT_LT(changed, 3 * reddened) << "elsewhere the ghost is the same";

  // The tooth itself remains, faintly.
  run("view.tissue dentin hide");
  EXPECT_GT(test::pictureDifference(without, picture()), test::kSamePicture);
}

TEST_F(TissuePicture, WhatIsGhostOrHiddenSaysSoAndWrongWordsAreRefused) {
  run("view.tissue enamel ghost");
  EXPECT_TRUE(bench_->views->tissues().isOwnSurfaceGhost());
  EXPECT_FALSE(bench_->views->tissues().hasPart(TissuePart::kGhost));
  run("view.tissue pulp hide");
  EXPECT_FALSE(bench_->views->tissues().isOwnSurfaceGhost());
  EXPECT_TRUE(bench_->views->tissues().hasPart(TissuePart::kGhost));
  for (const auto& words : {std::vector<std::string>{"bark", "hide"}, {"enamel", "eat"}, {"enamel"}, {}})
    EXPECT_FALSE(runAppCommand(app_, "view.tissue", words));
  EXPECT_FALSE(runAppCommand(app_, "view.colours", std::vector<std::string>{"blue"}));
  EXPECT_TRUE(bench_->views->tissues().hasPart(TissuePart::kSolid));
}

TEST_F(TissuePicture, TheSurfaceOfSomeTissuesIsClosedAndHoldsTheirVolume) {
  const BakedObject& object = bench_->document->run()->object();
  const auto volume = [&](Material material) { return object.volumes()[static_cast<std::size_t>(material)]; };
  TissueSet all;
  all.set();
  TissueMesher everything(object, all, object.phi0());
  TissueMesher inner(object, setOf({Material::kDentin, Material::kPulp}), object.phi0());
  TissueMesher pulp(object, setOf({Material::kPulp}), object.phi0());
  const BrickField uncut(object.voxel(), object.phi0().background(), object.phi0().interior());

  double sum = 0;
  for (const double v : object.volumes()) sum += v;
  EXPECT_NEAR(volumeOf(everything.update(uncut)), sum, 0.01 * sum);
  const double pulp_volume = volume(Material::kPulp), inner_volume = volume(Material::kDentin) + pulp_volume;
  const auto chunks = inner.update(uncut);
  EXPECT_NEAR(volumeOf(chunks), inner_volume, 0.02 * inner_volume);
  EXPECT_TRUE(checkMesh(weldedMesh(chunks)).isClosed());
  EXPECT_NEAR(volumeOf(pulp.update(uncut)), pulp_volume, 0.15 * pulp_volume) << "canals thinner than voxels vanish";
  EXPECT_TRUE(inner.update(uncut).empty()) << "nothing has changed";
}

TEST_F(TissuePicture, TheSurfaceOfSomeTissuesFollowsTheCutAndItsUndo) {
  const BakedObject& object = bench_->document->run()->object();
  TissueMesher pulp(object, setOf({Material::kPulp}), object.phi0());
  OverlayField field(object.phi0());
  const double before = volumeOf(pulp.update(field.changed()));

  // A ball that removes the middle of the chamber.
  const Box3 box = object.phi0().bounds();
  Vec3d middle = box.center();
  while (bench_->document->structures()->distance(middle) > -0.3 && middle[2] < box.max[2]) middle[2] += object.voxel();
  ASSERT_LT(middle[2], box.max[2]);
  LiveSurface surface;
  const auto update = [&] { surface.update(pulp.update(field.changed())); };
  TissueMesher again(object, setOf({Material::kPulp}), object.phi0());
  surface.update(again.update(BrickField(object.voxel(), object.phi0().background(), object.phi0().interior())));
  scenes::carve(field, middle, 0.8);
  update();
  EXPECT_LT(surface.volume(), before - 0.5);

  std::vector<BrickEdit> back;
  for (std::size_t b = 0; b < field.changed().brickCount(); ++b) {
    const Vec3i at = field.changed().brickCoord(b);
    BrickEdit edit{at, {}};
    edit.phi.fill(object.phi0().constantAt(at));
    if (const BrickValues* const values = object.phi0().valuesAt(at)) edit.phi = *values;
    back.push_back(edit);
  }
  for (const BrickEdit& edit : back) field.set(edit);
  update();
  EXPECT_NEAR(surface.volume(), before, 1e-3);
}

TEST_F(TissuePicture, WhatIsCutWhileATissueIsHiddenIsSeenToBeCut) {
  run("view.from top");
  run("view.tissue pulp ghost");  // the surface of the others is meshed separately
  const Image before = picture();
  run("cut.force 8");
  run("cut.depth 1");
  run("cut.press 160 120");
  run("wait 3");
  run("cut.release");
  run("wait 0.5");
  EXPECT_GT(bench_->document->removedMm3(), 0.01);
  const auto differs = [&](const Image& now) {
    int n = 0;
    for (std::size_t i = 0; i < now.rgba.size(); i += 4) n += std::abs(now.rgba[i] - before.rgba[i]) > 12;
    return n;
  };
  view_->hover({});
  const int cut = differs(picture());
  EXPECT_GT(cut, 20);

  run("edit.undo");
  run("wait 0.5");
  EXPECT_LT(differs(picture()), cut / 4);
}

TEST_F(TissuePicture, AsLoadedShowsTheObjectWithoutItsCutsWhereItWas) {
  run("view.from top");
  view_->hover({});
  const Image whole = picture();
  const Plane across{bench_->document->scene().bounds().center(), {0, 0, 1}};
  bench_->views->section = across;
  const Image whole_section = picture();
  bench_->views->section.reset();

  run("view.as-loaded on");
  EXPECT_EQ(picture().rgba, whole.rgba);
  run("view.as-loaded");
  run("cut.force 8");
  run("cut.depth 1");
  run("cut.press 160 120");
  run("wait 3");
  run("cut.release");
  run("wait 0.5");
  const std::uint32_t id = bench_->document->scene().shown()[0]->id;
  bench_->pieces->drag(id, Rigid3{Eigen::Quaterniond::Identity(), {2, 0, 0}});
  const Image cut = picture();
  EXPECT_NE(cut.rgba, whole.rgba);
  run("view.as-loaded on");
  EXPECT_EQ(picture().rgba, whole.rgba) << "not moved, and nothing is cut";
  bench_->views->section = across;
  EXPECT_EQ(picture().rgba, whole_section.rgba);
  bench_->views->section.reset();
  run("view.tissue enamel hide");
  EXPECT_EQ(picture().rgba, whole.rgba) << "all of its tissues";
  run("view.tissues-all");
  run("view.as-loaded off");
  EXPECT_EQ(picture().rgba, cut.rgba);
  EXPECT_FALSE(runAppCommand(app_, "view.as-loaded", std::vector<std::string>{"maybe"}));
  bench_->pieces->drag(id, std::nullopt);
  run("edit.undo");
}

TEST_F(TissuePicture, MapsSayDepthAndDistanceInMillimetres) {
  const TissueDisplay& tissues = bench_->views->tissues();
  const BrickField& phi0 = bench_->document->run()->object().phi0();
  MeshChunk chunk;
  const Box3 box = phi0.bounds();
  for (int n = 0; n < 400; ++n) {
    const Vec3d share(n % 7 / 7.0, n % 11 / 11.0, n % 13 / 13.0);
    chunk.vertices.push_back(Vec3f((box.min + share.cwiseProduct(box.size())).cast<float>()));
  }
  const auto isNear = [](const Rgba8& a, const Rgba8& b, int most) {
    for (std::size_t k = 0; k < 3; ++k)
      if (std::abs(int{a[k]} - int{b[k]}) > most) return false;
    return true;
  };

  run("view.colours depth");
  ASSERT_EQ(tissues.colours(), SurfaceColours::kDepth);
  auto colours = tissues.coloursOf(chunk);
  int known = 0;
  for (std::size_t v = 0; v < chunk.vertices.size(); ++v) {
    const double depth = -phi0.sample(chunk.vertices[v].cast<double>());
    if (depth > 3 * phi0.voxel()) continue;  // beyond its band
    EXPECT_TRUE(isNear(colours[v], mapColour(std::max(depth, 0.0) / kMapReach), 6)) << depth << " mm";
    ++known;
  }
  EXPECT_GT(known, 100);
  const Image depth = picture();

  run("view.colours distance");
  colours = tissues.coloursOf(chunk);
  for (std::size_t v = 0; v < chunk.vertices.size(); ++v) {
    const double distance = bench_->document->structures()->distance(chunk.vertices[v].cast<double>());
    EXPECT_TRUE(isNear(colours[v], mapColour(1 - distance / kMapReach), 0));
  }
  EXPECT_GT(test::pictureDifference(depth, picture()), 2);
  run("view.colours tissue");
}

TEST(MapColours, AreTakenForEachOtherByNobody) {
  // View of a person without the red or the green cones: Vienot, Brettel & Mollon, Color Res Appl 1999;24:243.
  const Eigen::Matrix3d protan{{0.11238, 0.88762, 0}, {0.11238, 0.88762, 0}, {0.00401, -0.00401, 1}};
  const Eigen::Matrix3d deutan{{0.29275, 0.70725, 0}, {0.29275, 0.70725, 0}, {-0.02234, 0.02234, 1}};
  const auto seen = [](const Eigen::Matrix3d& eye, const Rgba8& c) {
    Vec3d linear;
    for (int k = 0; k < 3; ++k) linear[k] = std::pow(c[static_cast<std::size_t>(k)] / 255.0, 2.2);
    linear = (eye * linear).cwiseMax(0).cwiseMin(1);
    std::array<std::uint8_t, 3> out{};
    for (int k = 0; k < 3; ++k)
      out[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(std::lround(255 * std::pow(linear[k], 1 / 2.2)));
    return test::labOf(out.data());
  };
  for (const Eigen::Matrix3d& eye : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), protan, deutan})
    for (double mm = 0; mm + 0.5 <= kMapReach; mm += 0.5) {
      const Vec3d near = seen(eye, mapColour(mm / kMapReach)), far = seen(eye, mapColour((mm + 0.5) / kMapReach));
      EXPECT_GT(near[0] - far[0], 5) << "darker with each half millimetre, at " << mm;
      EXPECT_GT((near - far).norm(), 6) << mm;
    }
}

// ---- Reference pictures

TEST_F(TissuePicture, LooksAsItDid) {
  struct Scene {
    const char* name;
    std::vector<std::string> script;
  };
  const std::vector<Scene> scenes = {
      {"molar", {"view.from 20,35"}},
      {"molar-section", {"view.from front", "view.section", "view.from 20,25"}},
      {"molar-without-enamel", {"view.from 20,35", "view.tissue enamel hide"}},
      {"molar-ghost", {"view.from 20,10", "view.tissue enamel ghost", "view.tissue dentin ghost"}},
      {"molar-distance", {"view.from 20,10", "view.colours distance", "view.tissue enamel hide"}},
  };
  const char* const write_to = std::getenv("KERF_WRITE_PICTURES");
  for (const Scene& scene : scenes) {
    for (const std::string& line : scene.script) run(line);
    const Image now = picture();
    TearDown();
    const std::filesystem::path file =
        std::filesystem::path(kSourceFolder) / "tests/ui/pictures" / (std::string(scene.name) + ".png");
    if (write_to) {
      ASSERT_TRUE(writePng(std::filesystem::path(write_to) / file.filename(), now));
      continue;
    }
    const auto before = readPng(file);
    ASSERT_TRUE(before) << before.error().message();
    EXPECT_LT(test::pictureDifference(*before, now), test::kSamePicture) << scene.name;
  }
}

TEST_F(TissuePicture, AShiftedOrRecolouredToothIsAnotherPicture) {
  run("view.from 20,35");
  const Image image = picture();
  EXPECT_EQ(test::pictureDifference(image, image), 0);
  EXPECT_GT(test::pictureDifference(image, Image{kWidth, 1, {}}), 99);

  // Like another driver: each channel off by one, edges by a quarter of a pixel.
  Image noisy = image;
  for (std::size_t i = 0; i < noisy.rgba.size(); ++i)
    noisy.rgba[i] = static_cast<std::uint8_t>(std::clamp(int{noisy.rgba[i]} + (i % 3 == 0) - (i % 5 == 0), 0, 255));
  Image smoothed = image;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 1; x < kWidth; ++x)
      for (int k = 0; k < 3; ++k)
        smoothed.at(x, y)[k] = static_cast<std::uint8_t>((3 * image.at(x, y)[k] + image.at(x - 1, y)[k]) / 4);
  EXPECT_LT(test::pictureDifference(image, noisy), test::kSamePicture);
  EXPECT_LT(test::pictureDifference(image, smoothed), test::kSamePicture);

  Image shifted = image;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 5; x < kWidth; ++x) std::copy_n(image.at(x - 5, y), 4, shifted.at(x, y));
  EXPECT_GT(test::pictureDifference(image, shifted), 2 * test::kSamePicture);

  Image recoloured = image;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4)
    if (image.rgba[i] + 4 > image.rgba[i + 2])
      recoloured.rgba[i + 2] = static_cast<std::uint8_t>(0.85 * image.rgba[i + 2]);
  EXPECT_GT(test::pictureDifference(image, recoloured), 2 * test::kSamePicture);
}

}  // namespace
}  // namespace kerf::tissue_picture_test
