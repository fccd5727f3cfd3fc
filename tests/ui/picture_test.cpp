// Pictures drawn without a display. Skipped, with a message, if OpenGL is missing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <numbers>

#include "ui/window/draw/mesh_picture.h"
#include "ui/window/gl/gl_context.h"
#include "ui/window/gl/image.h"
#include "ui/window/gl/picture_legend.h"

namespace kerf::picture_test {
namespace {

/// Octahedron subdivided `levels` times and pushed out to radius r.
Mesh sphere(double r, int levels) {
  Mesh mesh;
  mesh.vertices = {Vec3d::UnitX(), -Vec3d::UnitX(), Vec3d::UnitY(), -Vec3d::UnitY(), Vec3d::UnitZ(), -Vec3d::UnitZ()};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::vector<Triangle> finer;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> midpoints;
    const auto middle = [&](std::uint32_t i, std::uint32_t j) {
      const auto [at, is_new] =
          midpoints.try_emplace(std::minmax(i, j), static_cast<std::uint32_t>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back((mesh.vertices[i] + mesh.vertices[j]).normalized());
      return at->second;
    };
    for (const Triangle& t : mesh.triangles) {
      const std::uint32_t a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Vec3d& p : mesh.vertices) p *= r;
  return mesh;
}

/// A tetrahedron without any symmetry.
Mesh skewTetrahedron() {
  Mesh mesh;
  mesh.vertices = {{0, 0, 0}, {3, 0.2, 0.1}, {0.7, 4, -0.3}, {0.4, 1.1, 6}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return mesh;
}

class Picture : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (auto made = OffscreenContext::create())
      context_ = std::move(*made);
    else
      why_ = made.error().message();
  }
  static void TearDownTestSuite() { context_.reset(); }
  void SetUp() override {
    if (!context_) GTEST_SKIP() << why_;
    auto made = MeshPicture::create();
    ASSERT_TRUE(made) << made.error().message();
    picture_ = std::move(*made);
  }
  void TearDown() override { picture_.reset(); }

  Image draw(const Mesh& mesh, const Camera& camera, int width, int height, const PictureOptions& options) {
    picture_->setMesh(mesh);
    auto image = picture_->picture(camera, width, height, options);
    EXPECT_TRUE(image) << image.error().message();
    return image ? *image : Image{};
  }

  static inline std::unique_ptr<OffscreenContext> context_;
  static inline std::string why_;
  std::unique_ptr<MeshPicture> picture_;
};

const PictureOptions kMask{.transparent = true};

double coveredPixels(const Image& image) {
  double sum = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) sum += image.rgba[i] / 255.0;
  return sum;
}

TEST_F(Picture, SilhouetteOfASphereHasItsProjectedArea) {
  for (const char* view : {"front", "top", "iso"}) {
    Camera camera = *cameraFromView(view);
    camera.half_height = 8;
    camera.target = {0.3, -0.2, 0.1};
    const double mm = camera.mmPerPixel(240);
    const double area = coveredPixels(draw(sphere(5, 5), camera, 320, 240, kMask)) * mm * mm;
    EXPECT_NEAR(area / (std::numbers::pi * 25), 1, 0.01) << view;
  }
}

TEST_F(Picture, OppositeViewsAreMirrored) {
  const Mesh mesh = skewTetrahedron();
  const std::pair<const char*, const char*> pairs[] = {{"left", "right"}, {"front", "back"}};
  for (const auto& [one, other] : pairs) {
    Camera a = *cameraFromView(one), b = *cameraFromView(other);
    fitTo(a, mesh, 200, 150);
    fitTo(b, mesh, 200, 150);
    const Image x = draw(mesh, a, 200, 150, kMask), y = draw(mesh, b, 200, 150, kMask);
    double different = 0;
    for (int row = 0; row < 150; ++row)
      for (int column = 0; column < 200; ++column)
        different += std::abs(x.at(column, row)[3] - y.at(199 - column, row)[3]) / 255.0;
    EXPECT_GT(coveredPixels(x), 2000);
    // Samples exactly on an edge may count for either side: less than one in a hundred along the outline.
    EXPECT_LT(different, 0.01 * coveredPixels(x)) << one;
  }
}

TEST_F(Picture, ColoursOfFacesArriveAndWinOverThoseOfVertices) {
  Mesh mesh = skewTetrahedron();
  mesh.vertex_colors.assign(4, {0, 0, 255, 255});
  mesh.face_colors = {{0, 200, 0, 255}, {220, 0, 0, 255}, {0, 200, 0, 255}, {0, 200, 0, 255}};
  Camera camera = *cameraFromView("front");  // sees triangle 1, (0, 1, 3), which faces -y
  fitTo(camera, mesh, 160, 120);
  const Image image = draw(mesh, camera, 160, 120, kMask);
  int red = 0, blue = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x)
      if (const std::uint8_t* p = image.at(x, y); p[3] == 255) {
        red += p[0] > 2 * p[1] && p[0] > 2 * p[2];
        blue += p[2] > p[0];
      }
  EXPECT_GT(red, 1000);
  EXPECT_EQ(blue, 0);
  mesh.face_colors.clear();
  const Image bluish = draw(mesh, camera, 160, 120, kMask);
  int now_blue = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) now_blue += bluish.at(x, y)[3] == 255 && bluish.at(x, y)[2] > bluish.at(x, y)[0];
  EXPECT_GT(now_blue, 1000);
}

TEST_F(Picture, SameInputGivesTheSameBytes) {
  const Mesh mesh = sphere(3, 4);
  Camera camera = *cameraFromView("iso");
  fitTo(camera, mesh, 200, 160);
  const Image first = draw(mesh, camera, 200, 160, {});
  draw(skewTetrahedron(), camera, 64, 64, {});
  EXPECT_EQ(first.rgba, draw(mesh, camera, 200, 160, {}).rgba);
}

TEST_F(Picture, EmptyMeshIsBackgroundOnly) {
  Camera camera;
  fitTo(camera, {}, 64, 48);
  EXPECT_EQ(coveredPixels(draw({}, camera, 64, 48, kMask)), 0);
  const Image image = draw({}, camera, 64, 48, {});
  EXPECT_GT(image.at(32, 24)[0], 230);
  EXPECT_EQ(image.at(32, 24)[3], 255);
}

TEST_F(Picture, FarFromTheOriginNothingShifts) {
  Mesh near = sphere(3, 4), far = near;
  for (Vec3d& p : far.vertices) p += Vec3d(4096, -2048, 1024);  // exact in binary
  Camera a = *cameraFromView("iso");
  a.half_height = 4;
  Camera b = a;
  b.target = {4096, -2048, 1024};
  const double one = coveredPixels(draw(near, a, 120, 90, kMask)), other = coveredPixels(draw(far, b, 120, 90, kMask));
  EXPECT_NEAR(one, other, 0.001 * one);
}

// A cup, open towards the viewer: the picture shows its inside.
TEST_F(Picture, TheInsideOfAnOpenSurfaceIsBluish) {
  Mesh cup = sphere(3, 4);
  std::erase_if(cup.triangles, [&](const Triangle& t) {
    return cup.vertices[t[0]].z() + cup.vertices[t[1]].z() + cup.vertices[t[2]].z() > 0;
  });
  Camera above = *cameraFromView("top"), below = *cameraFromView("bottom");
  above.half_height = below.half_height = 4;
  const Image inside = draw(cup, above, 64, 64, kMask), outside = draw(cup, below, 64, 64, kMask);
  EXPECT_GT(inside.at(32, 32)[2], inside.at(32, 32)[0]);
  EXPECT_GT(outside.at(32, 32)[0], outside.at(32, 32)[2]) << "ivory";
}

// A groove between two plates: its bottom is darker than the upper end of the same wall.
TEST_F(Picture, ACreviceIsDarkerThanTheOpen) {
  Mesh mesh;
  for (const auto& [x, z] : {std::pair(-4, 0), {-1, 0}, {0, -2}, {1, 0}, {4, 0}})
    for (const int y : {-4, 4}) mesh.vertices.push_back(Vec3d(x, y, z));
  for (std::uint32_t n = 0; n < 8; n += 2) {
    mesh.triangles.push_back({n, n + 2, n + 3});
    mesh.triangles.push_back({n, n + 3, n + 1});
  }
  Camera camera = *cameraFromView("top");
  camera.half_height = 3;
  const auto at = [&](const PictureOptions& options, double x) {
    const Image image = draw(mesh, camera, 200, 120, options);
    return int{image.at(100 + static_cast<int>(x / camera.mmPerPixel(120)), 60)[1]};
  };
  const PictureOptions flat{.occlusion_samples = 0, .transparent = true};
  EXPECT_NEAR(at(flat, 0.15), at(flat, 0.9), 2);
  EXPECT_LT(at(kMask, 0.15), at(kMask, 0.9) - 20);
}

TEST_F(Picture, SizeOutOfRangeIsRefused) {
  picture_->setMesh({});
  EXPECT_FALSE(picture_->picture(Camera{}, 0, 100, {}));
  EXPECT_FALSE(picture_->picture(Camera{}, 100, 9000, {}));
}

std::uint32_t bigEndian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

TEST(Png, HasTheSizeOfThePictureAndReplacesAnOlderFile) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "kerf_png_test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const std::filesystem::path path = folder / "picture.png";
  std::ofstream(path) << "older";
  Image image{123, 45, std::vector<std::uint8_t>(4 * 123 * 45, 200)};
  drawScaleBar(image, 5, 0.2);
  ASSERT_TRUE(writePng(path, image));
  const auto back = readPng(path);
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(back->width, image.width);
  EXPECT_EQ(back->rgba, image.rgba);
  EXPECT_FALSE(readPng(folder / "missing.png"));
  std::ofstream(folder / "text.png") << "no picture";
  EXPECT_FALSE(readPng(folder / "text.png"));
  std::filesystem::remove(folder / "text.png");
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  ASSERT_GT(bytes.size(), 33u);
  EXPECT_EQ(bytes.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(bigEndian(bytes, 16), 123u);
  EXPECT_EQ(bigEndian(bytes, 20), 45u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);  // nothing else beside it
  const auto refused = writePng(folder / "missing" / "picture.png", image);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Error::Code::kWriteFailed);
}

TEST(ScaleBar, IsAsLongAsItSays) {
  Image image{400, 300, std::vector<std::uint8_t>(4 * 400 * 300, 255)};
  drawScaleBar(image, 5, 0.05);  // 100 pixels
  int longest = 0;
  for (int y = 0; y < 300; ++y) {
    int dark = 0;
    for (int x = 0; x < 400; ++x) dark += image.at(x, y)[0] < 128;
    longest = std::max(longest, dark);
  }
  EXPECT_NEAR(longest, 100, 2);  // and half the width of the end ticks on either side
}

TEST(PictureGrid, LinesStandWhereTheirNumbersAre) {
  struct Row {
    const char *view, *right, *up;
  };
  for (const Row& row : {Row{"top", "x", "y"}, Row{"front", "x", "z"}, Row{"back", "-x", "z"}, Row{"left", "-y", "z"},
                         Row{"bottom", "x", "-y"}, Row{"iso", "", ""}}) {
    Camera camera = *cameraFromView(row.view);
    camera.target = {12.34, -7.7, 101};
    camera.half_height = 20;
    const int width = 900, height = 600;
    const PictureGrid grid = pictureGrid(camera, width, height, Eigen::Matrix3d::Identity());
    EXPECT_EQ(grid.right_name, row.right) << row.view;
    EXPECT_EQ(grid.up_name, row.up) << row.view;
    EXPECT_EQ(grid.step_mm, 5) << "50 pixels are 3.3 mm";
    EXPECT_GE(grid.right.size(), 11u);

    const double mm = camera.mmPerPixel(height);
    for (const PictureGrid::Line& line : grid.right) {
      EXPECT_NEAR(std::remainder(line.mm, 5), 0, 1e-9);
      const Vec3d there = camera.target + (line.pixel - 0.5 * width) * mm * camera.right();
      EXPECT_NEAR(there.dot(camera.right()), line.mm, 1e-9) << row.view;
    }
    for (const PictureGrid::Line& line : grid.up) {
      const Vec3d there = camera.target - (line.pixel - 0.5 * height) * mm * camera.up();
      EXPECT_NEAR(there.dot(camera.up()), line.mm, 1e-9) << row.view;
    }
  }
}

// A scan stored upside down is turned before drawing. The axes keep their names from the file.
TEST(PictureGrid, NamesTheAxesOfTheScanThatIsDrawnUpright) {
  const PictureGrid grid = pictureGrid(*cameraFromView("top"), 400, 300, uprightFrame(-Vec3d::UnitZ()));
  EXPECT_EQ(grid.right_name, "x");
  EXPECT_EQ(grid.up_name, "-y");
}

TEST(PictureGrid, IsDrawnWhereItsLinesAre) {
  Image image{900, 600, std::vector<std::uint8_t>(4 * 900 * 600, 255)};
  PictureGrid grid;
  grid.step_mm = 5;
  grid.right = {{0, 300.4}, {5, 500.6}};
  grid.up = {{-5, 400.2}};
  drawGrid(image, grid);
  const auto dark = [&](int x, int y) { return image.at(x, y)[0] < 240; };
  for (int x = 200; x < 700; ++x) EXPECT_EQ(dark(x, 550), x == 300 || x == 500) << x;
  for (int y = 100; y < 590; ++y) EXPECT_EQ(dark(450, y), y == 400) << y;
  EXPECT_LT(image.at(300, 550)[0], image.at(500, 550)[0]) << "the line through the origin is the stronger one";
  int inked = 0;
  for (int y = 0; y < 30; ++y)
    for (int x = 490; x < 512; ++x) inked += x != 500 && dark(x, y);
  EXPECT_GT(inked, 10) << "its number is at its upper end";
}

TEST(PictureGrid, NumbersHaveTheDecimalsThatTellThemApart) {
  PictureGrid grid;
  const auto numbers = [&](double step, const std::vector<double>& lines) {
    grid.step_mm = step;
    std::string out;
    for (const double mm : lines) out += numberAt(grid, {mm, 0}) + " ";
    return out;
  };
  EXPECT_EQ(numbers(0.02, {12345.58, 12345.6, -0.02, 0}), "12345.58 12345.60 -0.02 0.00 ");
  EXPECT_EQ(numbers(0.1, {-0.1, 2}), "-0.1 2.0 ");
  EXPECT_EQ(numbers(0.5, {1.5}), "1.5 ");
  EXPECT_EQ(numbers(0.001, {7}), "7.000 ");
  EXPECT_EQ(numbers(1, {-7}), "-7 ");
  EXPECT_EQ(numbers(500, {1234500}), "1234500 ");
}

// Plates are visible on a black picture: overlaps of two are lighter.
TEST(PictureGrid, NoPlateTouchesAnother) {
  struct Row {
    const char* view;
    int width, height;
    double half_height, along;
  };
  for (const Row& row :
       {Row{"back", 1200, 900, 10, 0}, Row{"top", 1080, 1080, 9.8, 0}, Row{"back", 1200, 900, 0.9, 12345.6},
        Row{"left", 1200, 900, 1.7, -104}, Row{"iso", 2000, 400, 0.01, 12345.6}, Row{"top", 900, 600, 20, 3}}) {
    Camera camera = *cameraFromView(row.view);
    camera.half_height = row.half_height;
    camera.target = row.along * camera.right();
    Image image{row.width, row.height, {}};
    for (int n = 0; n < row.width * row.height; ++n) image.rgba.insert(image.rgba.end(), {0, 0, 0, 255});
    drawGrid(image, pictureGrid(camera, row.width, row.height, Eigen::Matrix3d::Identity()));

    // Above the digits, and within the plates.
    const int y = static_cast<int>(2 * std::max(1.2, row.height / 400.0));
    int plates = 0, gap = 1000, least = 1000;
    for (int x = 0; x < row.width; ++x) {
      const int light = image.at(x, y)[1];
      EXPECT_LT(light, 225) << row.view << " at " << x;
      if (light < 100) {
        ++gap;
        continue;
      }
      if (gap > 0) ++plates;
      if (gap > 0 && plates > 1) least = std::min(least, gap);
      gap = 0;
    }
    EXPECT_GE(plates, 4) << row.view;
    EXPECT_GE(least, 2) << row.view;
  }
}

TEST(PictureLegend, ShowsTheMapFromEndToEndAndItsWordsCanBeDrawn) {
  EXPECT_FALSE(legendOf(SurfaceColours::kTissue));
  EXPECT_FALSE(legendOf(SurfaceColours::kScan));
  for (const SurfaceColours colours : {SurfaceColours::kDepth, SurfaceColours::kDistance, SurfaceColours::kContact}) {
    const std::optional<MapLegend> legend = legendOf(colours);
    ASSERT_TRUE(legend);
    for (const std::string& text : {legend->title, legend->low, legend->high}) EXPECT_TRUE(canBeDrawn(text)) << text;
    for (const MapLegend::Tick& tick : legend->ticks) EXPECT_TRUE(canBeDrawn(tick.text)) << tick.text;
    EXPECT_EQ(legend->high, colours == SurfaceColours::kContact ? "2 mm or more" : "5 mm or more")
        << "what lies farther has the colour of the end";

    // On black, so that the plate is visible.
    Image image{900, 600, std::vector<std::uint8_t>(4 * 900 * 600, 0)};
    for (std::size_t n = 3; n < image.rgba.size(); n += 4) image.rgba[n] = 255;
    drawLegend(image, *legend);
    int longest = 0, low = 0, high = 0, row = 0;
    for (int y = 300; y < 600; ++y) {
      int first = -1, last = -1;
      for (int x = 0; x < 900; ++x) {
        const std::uint8_t* const p = image.at(x, y);
        const bool is_grey = std::abs(p[0] - p[1]) < 12 && std::abs(p[1] - p[2]) < 12;
        if (is_grey) continue;
        if (first < 0) first = x;
        last = x;
      }
      if (last - first <= longest) continue;
      longest = last - first;
      low = first;
      high = last;
      row = y;
    }
    ASSERT_GT(longest, 100) << "no bar";
    for (const auto& [x, share] : {std::pair(low, 0.0), std::pair((low + high) / 2, 0.5), std::pair(high, 1.0)}) {
      const Rgba8 wanted = legend->colourAt(share);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(image.at(x, row)[k], wanted[k], 8) << share;
    }
    EXPECT_GT(image.at(low - 2, row)[0], 150) << "it stands on a light plate";
  }
}

}  // namespace
}  // namespace kerf::picture_test
