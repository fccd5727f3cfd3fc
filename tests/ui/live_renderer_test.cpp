// The picture of an object during a cut, drawn without a display. Skipped, with a message, if OpenGL is missing.
#include "ui/window/draw/live_renderer.h"

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>

#include "bench/scenes/carved_field.h"
#include "geometry/field/sample_field.h"
#include "sim/live/chunk_occlusion.h"
#include "tests/ui/picture_compare.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/view/mesh_chunks.h"
#include "ui/window/draw/still_picture.h"
#include "ui/window/gl/gl_context.h"
#include "ui/window/gl/gl_target.h"

namespace kerf::live_renderer_test {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A block of 10 x 10 x 4 mm, its top at z = 0, voxel 0.2 mm, with a round cavity of 1 mm radius about (2, 0, 0).
class Block {
 public:
  Block()
      : phi0_(sampleDistance(
            [](const Vec3d& p) {
              const Vec3d q = (p - Vec3d(0, 0, -2)).cwiseAbs() - Vec3d(5, 5, 2);
              return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
            },
            Box3{{-5, -5, -4}, {5, 5, 0}}, 0.2)),
        remesher_(phi0_, {.marching_cubes = {}, .is_parallel = false}) {
    OverlayField field(phi0_);
    remesher_.apply(scenes::carve(field, {2, 0, 0}, 1));
    chunks_ = remesher_.changedSince(0);
  }
  const std::vector<MeshChunkPtr>& chunks() const { return chunks_; }
  const OverlayField& field() const { return remesher_.field(); }

 private:
  BrickField phi0_;
  Remesher remesher_;
  std::vector<MeshChunkPtr> chunks_;
};

/// A ball of 0.5 mm on a shank of 0.3 mm, its tip at the origin, red.
ToolLook redBur() {
  const auto distance = [](const Vec3d& p) {
    const double ball = (p - Vec3d(0, 0, 0.5)).norm() - 0.5;
    const Vec3d q = p - Vec3d(0, 0, std::clamp(p[2], 0.5, 6.0));
    return std::min(ball, q.norm() - 0.3);
  };
  ToolLook look;
  look.mesh = marchingCubes(sampleDistance(distance, Box3{{-1, -1, -0.5}, {1, 1, 7}}, 0.1));
  look.mesh.vertex_colors.assign(look.mesh.vertices.size(), {200, 10, 10, 255});
  look.cutting = {{-0.5, -0.5, 0}, {0.5, 0.5, 1}};
  look.distance = [](const Vec3d& p) { return (p - Vec3d(0, 0, 0.5)).norm() - 0.5; };
  return look;
}

Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }

class LivePicture : public ::testing::Test {
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
    auto made = LiveRenderer::create();
    ASSERT_TRUE(made) << made.error().message();
    renderer_ = std::move(*made);
    camera_ = *cameraFromView("20,55");
    camera_.half_height = 6;
    camera_.target = {0, 0, -1};
  }
  void TearDown() override { renderer_.reset(); }

  void showBlock() {
    for (const MeshChunkPtr& chunk : block_.chunks())
      renderer_->setChunk(0, *chunk, {}, occlusionOf(*chunk, block_.field()));
  }
  Image picture(const LiveFrame& frame = {}) { return picture(camera_, frame); }
  Image picture(const Camera& camera, const LiveFrame& frame) {
    auto image = renderer_->picture(camera, kWidth, kHeight, frame);
    EXPECT_TRUE(image) << image.error().message();
    return image ? *image : Image{kWidth, kHeight, std::vector<std::uint8_t>(4 * kWidth * kHeight)};
  }
  /// Place of a point of the world in the picture.
  std::array<int, 2> pixelOf(const Vec3d& p) const {
    const Vec3d v = camera_.rotation() * (p - camera_.target) / camera_.mmPerPixel(kHeight);
    return {static_cast<int>(std::floor(0.5 * kWidth + v[0])), static_cast<int>(std::floor(0.5 * kHeight - v[1]))};
  }

  static inline std::unique_ptr<OffscreenContext> context_;
  static inline std::string why_;
  std::unique_ptr<LiveRenderer> renderer_;
  Block block_;
  Camera camera_;
};

/// Pixels that satisfy a predicate on (red, green, blue).
template <class Is>
int count(const Image& image, const Is& is) {
  int n = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4)
    n += is(int{image.rgba[i]}, int{image.rgba[i + 1]}, int{image.rgba[i + 2]}) ? 1 : 0;
  return n;
}
bool isIvory(int r, int, int b) { return r > b + 12; }  // the background is blueish
bool isRed(int r, int g, int b) { return r > 2 * g && r > 2 * b && r > 60; }
bool isTinted(int r, int, int b) { return b > r + 40; }

/// Pixels with a difference above `most` in any channel.
int different(const Image& a, const Image& b, int most = 0) {
  int n = 0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    bool differs = false;
    for (std::size_t k = 0; k < 4; ++k) differs |= std::abs(int{a.rgba[i + k]} - int{b.rgba[i + k]}) > most;
    n += differs ? 1 : 0;
  }
  return n;
}

const LiveFrame kPlain{.contact_mm = 0, .has_shadow = false, .has_axis_line = false};

// ---- Planned cuts

bool isPlanBlue(int r, int, int b) { return b > r + 60; }

/// Across the block at x = -2, from above it through its underside, 0.44 mm thick.
LiveSlab slabAcross() {
  LiveSlab slab;
  slab.corners = {Vec3d(-2, -6, 1), {-2, 6, 1}, {-2, 6, -5}, {-2, -6, -5}};
  slab.thickness = 0.44;
  slab.contour = {{Vec3d(-2, -5, 0), Vec3d(-2, 5, 0)}};
  return slab;
}
LiveFrame planned() {
  LiveFrame frame = kPlain;
  frame.plan.slabs = {slabAcross()};
  return frame;
}

TEST_F(LivePicture, APlannedCutIsTranslucentAndItsPlaceIsSeen) {
  showBlock();
  const Image plain = picture(kPlain), with = picture(planned());
  EXPECT_EQ(count(plain, isPlanBlue), 0);
  EXPECT_GT(count(with, isPlanBlue), 300);

  // The background is visible through its middle, above the block. The line on the block's top is dark.
  const auto at = [&](const Image& image, const Vec3d& p) {
    const auto [x, y] = pixelOf(p);
    const std::size_t i = 4 * (static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x));
    return std::array<int, 3>{image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]};
  };
  const auto before = at(plain, {-2, 1, 0.5}), shown = at(with, {-2, 1, 0.5});
  EXPECT_NE(before, shown);
  EXPECT_GT(shown[0], before[0] / 3) << "translucent";
  const auto line = at(with, {-2, 1, 0});
  EXPECT_LT(line[0], 90);
  EXPECT_GT(line[2], line[0] + 30);

  // Only pixels near the slab change.
  EXPECT_LT(different(plain, with), 12000);
}

TEST_F(LivePicture, APlannedCutSeenEdgeOnIsALineAtEveryZoom) {
  showBlock();
  // From above, along the approach; and along the teeth.
  for (const char* const view : {"top", "front"})
    for (const double half_height : {6.0, 60.0}) {
      camera_ = *cameraFromView(view);
      camera_.half_height = half_height;
      camera_.target = {0, 0, -1};
      const Image with = picture(planned());
      // In every row between its ends it has a pixel, at most a few wide.
      const bool is_top = std::string(view) == "top";
      const auto [x, y0] = pixelOf(is_top ? Vec3d(-2, 5.5, 0) : Vec3d(-2, 0, 0.8));
      const auto y1 = pixelOf(is_top ? Vec3d(-2, -5.5, 0) : Vec3d(-2, 0, -4.8))[1];
      ASSERT_LT(y0, y1);
      for (int y = y0; y <= y1; ++y) {
        int wide = 0;
        for (int k = 0; k < kWidth; ++k) {
          const std::size_t i = 4 * (static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(k));
          wide += isPlanBlue(with.rgba[i], with.rgba[i + 1], with.rgba[i + 2]);
        }
        EXPECT_GE(wide, 1) << view << ", " << half_height << " mm, row " << y << " of " << y0 << " to " << y1
                           << ", column " << x;
        EXPECT_LE(wide, 0.44 / camera_.mmPerPixel(kHeight) + 6) << view << ", " << half_height << " mm, row " << y;
      }
    }
}

TEST_F(LivePicture, WhatIsBeingPickedIsOnTopAndWithoutAPlanNothingChanges) {
  showBlock();
  const Image plain = picture(kPlain);
  LiveFrame frame = kPlain;
  frame.plan.dots = {Vec3d(0, 0, -2)};  // inside the block
  frame.plan.lines = {{Vec3d(-4, 0, -2), Vec3d(4, 0, -2)}};
  EXPECT_GT(count(picture(frame), isPlanBlue), 200);
  EXPECT_EQ(different(picture(kPlain), plain), 0);
}

TEST_F(LivePicture, AnotherPlaneThanTheChosenOneIsGrey) {
  showBlock();
  LiveFrame frame = planned();
  const int chosen = count(picture(frame), isPlanBlue);
  frame.plan.slabs[0].is_chosen = false;
  const Image other = picture(frame);
  EXPECT_LT(count(other, isPlanBlue), chosen / 10);
  EXPECT_GT(different(other, picture(kPlain), 8), 1000);
}

TEST_F(LivePicture, NothingToShowIsBackground) {
  const Image empty = picture();
  EXPECT_EQ(count(empty, isIvory), 0);
  EXPECT_EQ(renderer_->counts().drawn_triangles, 0u);
  showBlock();
  EXPECT_GT(count(picture(), isIvory), 15000);
}

TEST_F(LivePicture, AChunkThatIsReplacedByAnEmptyOneIsGone) {
  showBlock();
  const Image before = picture();
  for (const MeshChunkPtr& chunk : block_.chunks()) {
    MeshChunk gone;
    gone.brick = chunk->brick;
    if (chunk->brick[0] >= 0) renderer_->setChunk(0, gone);
  }
  const Image half = picture();
  EXPECT_NEAR(count(half, isIvory) / double(count(before, isIvory)), 0.5, 0.15);
  renderer_->clear();
  EXPECT_EQ(count(picture(), isIvory), 0);
}

TEST_F(LivePicture, SameInputGivesTheSameBytesWhateverCameFirst) {
  showBlock();
  renderer_->setTool(redBur());
  const LiveFrame frame{.T_world_tool = at(2, 0, -1)};
  const Image first = picture(frame);
  picture(*cameraFromView("top"), {});
  EXPECT_EQ(different(first, picture(frame)), 0);

  auto other = LiveRenderer::create();
  ASSERT_TRUE(other);
  std::vector<MeshChunkPtr> shuffled = block_.chunks();
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(7));
  for (const MeshChunkPtr& chunk : shuffled) (*other)->setChunk(0, *chunk, {}, occlusionOf(*chunk, block_.field()));
  (*other)->setTool(redBur());
  const auto again = (*other)->picture(camera_, kWidth, kHeight, frame);
  ASSERT_TRUE(again);
  EXPECT_EQ(different(first, *again), 0);
}

TEST_F(LivePicture, CullingChangesNoPixel) {
  showBlock();
  renderer_->setTool(redBur());
  renderer_->setPose(1, {Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized())), {4, 5, 3}});
  for (const MeshChunkPtr& chunk : block_.chunks()) renderer_->setChunk(1, *chunk);
  for (const char* view : {"front", "top", "iso", "bottom", "-130,-20"})
    for (const double half_height : {2.0, 9.0}) {
      Camera camera = *cameraFromView(view);
      camera.half_height = half_height;
      LiveFrame frame{.T_world_tool = at(2, 0, -0.8)};
      const Image culled = picture(camera, frame);
      const std::size_t drawn = renderer_->counts().drawn_triangles;
      frame.is_culled = false;
      EXPECT_EQ(different(culled, picture(camera, frame)), 0) << view << " " << half_height;
      EXPECT_LT(drawn, 0.75 * static_cast<double>(renderer_->counts().drawn_triangles)) << view;
    }
}

TEST_F(LivePicture, TheToolIsThereAndAGhostLetsTissueThrough) {
  showBlock();
  renderer_->setTool(redBur());
  LiveFrame frame = kPlain;
  frame.T_world_tool = at(-1, 1, 1);
  const int solid = count(picture(frame), isRed);
  EXPECT_GT(solid, 400);
  frame.is_ghost = true;
  const Image ghost = picture(frame);
  EXPECT_LT(count(ghost, isRed), solid / 4);
  EXPECT_GT(different(ghost, picture(kPlain), 8), solid / 2);
  renderer_->setTool({});
  EXPECT_EQ(different(picture(frame), picture(kPlain)), 0);
}

TEST_F(LivePicture, TissueNearTheTipIsTintedAndNoOther) {
  showBlock();
  renderer_->setTool(redBur());
  LiveFrame frame = kPlain;
  frame.T_world_tool = at(-2, 0, 0.05);
  const Image plain = picture(frame);
  frame.contact_mm = 0.3;
  const Image tinted = picture(frame);
  EXPECT_GT(count(tinted, isTinted), 40);

  // Only with the tip within 0.3 mm of the plane z = 0: less than 0.8 mm from the axis, with a margin of a pixel.
  const auto [x, y] = pixelOf({-2, 0, 0});
  const double most = 0.8 / camera_.mmPerPixel(kHeight) + 2;
  for (int row = 0; row < kHeight; ++row)
    for (int column = 0; column < kWidth; ++column)
      if (!std::equal(plain.at(column, row), plain.at(column, row) + 4, tinted.at(column, row))) {
        EXPECT_LT(std::hypot(column - x, row - y), most);
      }

  frame.T_world_tool = at(-2, 0, 0.5);
  EXPECT_EQ(count(picture(frame), isTinted), 0);
}

TEST_F(LivePicture, TheShadowIsDarkUnderTheToolAndNowhereElse) {
  showBlock();
  renderer_->setTool(redBur());
  LiveFrame frame = kPlain;
  frame.T_world_tool = at(-2, -1, 3);
  const Image without = picture(frame);
  frame.has_shadow = true;
  const Image with = picture(frame);
  const auto [x, y] = pixelOf({-2, -1, 0});
  EXPECT_LT(with.at(x, y)[1], 0.85 * without.at(x, y)[1]);
  const auto [beside_x, beside_y] = pixelOf({-2.8, -1, 0});
  EXPECT_EQ(with.at(beside_x, beside_y)[1], without.at(beside_x, beside_y)[1]);

  // A disc of 0.5 mm radius, seen from 55 degrees above.
  const double mm = camera_.mmPerPixel(kHeight);
  const double area = different(with, without, 6) * mm * mm / std::sin(camera_.elevation);
  EXPECT_NEAR(area / (0.25 * 3.14159), 1, 0.2);
}

TEST_F(LivePicture, TheAxisLineRunsBelowTheTip) {
  showBlock();
  renderer_->setTool(redBur());
  LiveFrame frame = kPlain;
  frame.T_world_tool = at(-2, -1, 1);
  const Image without = picture(frame);
  frame.has_axis_line = true;
  frame.axis_line_mm = 4;
  const Image with = picture(frame);
  const auto [x, y] = pixelOf({-2, -1, 0.5});
  int darkest = 255;
  for (int step = -2; step <= 2; ++step) darkest = std::min(darkest, int{with.at(x + step, y)[0]});
  EXPECT_LT(darkest, 120);
  EXPECT_GT(without.at(x, y)[0], 150);
}

TEST_F(LivePicture, ASectionShowsTheInsideInOneColour) {
  showBlock();
  Camera front = *cameraFromView("front");
  front.half_height = 4;
  front.target = {0, 0, -2};
  LiveFrame frame = kPlain;
  frame.section = Plane{{0, 0, 0}, -Vec3d::UnitY()};
  frame.section_color = {0, 200, 0, 255};
  const Image open = picture(front, frame);
  const auto isSection = [](int r, int g, int b) { return r < 5 && g > 190 && b < 5; };
  const double mm = front.mmPerPixel(kHeight);
  // 10 x 4 mm less the half disc of the cavity.
  EXPECT_NEAR(count(open, isSection) * mm * mm, 40 - 0.5 * 3.14159, 1.2);

  frame.section = Plane{{0, -6, 0}, -Vec3d::UnitY()};  // takes nothing away
  EXPECT_EQ(count(picture(front, frame), isSection), 0);
  frame.section = Plane{{0, 6, 0}, -Vec3d::UnitY()};  // takes all
  EXPECT_EQ(count(picture(front, frame), isIvory), 0);

  // The lid lies in the plane: it hides a tool behind it, but not one in front.
  renderer_->setTool(redBur());
  frame.section = Plane{{0, 0, 0}, -Vec3d::UnitY()};
  frame.T_world_tool = at(-2, 1, -3);
  const int behind = count(picture(front, frame), isRed);
  frame.T_world_tool = at(-2, -1, -3);
  EXPECT_GT(count(picture(front, frame), isRed), behind + 400);
}

// ---- Perspective

TEST_F(LivePicture, InPerspectiveAThingIsDrawnWhereItsPixelIs) {
  showBlock();
  renderer_->setTool(redBur());
  setFieldOfView(camera_, 1.2);
  const Image without = picture(kPlain);
  // The bur's ball, in front of the focus and behind it.
  for (const Vec3d& tip : {Vec3d(3, -1, 2), Vec3d(-3, 2, 0), Vec3d(0, 2, 1), Vec3d(-4, 4, 1)}) {
    LiveFrame frame = kPlain;
    frame.T_world_tool = at(tip[0], tip[1], tip[2]);
    const Image with = picture(frame);
    const auto pixel = kerf::pixelOf(camera_, tip + Vec3d(0, 0, 0.5), kWidth, kHeight);
    const int x = static_cast<int>(pixel[0]), y = static_cast<int>(pixel[1]);
    const auto isTool = [&](int row) { return !std::equal(with.at(x, row), with.at(x, row) + 3, without.at(x, row)); };

    // As large as a ball of 0.5 mm there: down to its lower edge, away from the shank.
    const double radius = 0.5 / camera_.mmPerPixelAt(tip + Vec3d(0, 0, 0.5), kHeight);
    int below = 0;
    while (y + below < kHeight && isTool(y + below)) ++below;
    EXPECT_NEAR(below, radius, 0.1 * radius + 1.5) << tip.transpose();
  }
}

// A round shank of 0.5 mm along z, of that many slices: long or short triangles.
ToolLook shankOf(int slices) {
  constexpr int kSides = 12;
  constexpr double kRadius = 0.5, kFrom = -1, kTo = 80;
  ToolLook look;
  for (int n = 0; n <= slices; ++n)
    for (int k = 0; k < kSides; ++k) {
      const double turn = 2 * std::numbers::pi * k / kSides;
      look.mesh.vertices.push_back(
          {kRadius * std::cos(turn), kRadius * std::sin(turn), kFrom + (kTo - kFrom) * n / slices});
    }
  for (int n = 0; n < slices; ++n)
    for (int k = 0; k < kSides; ++k) {
      const auto at = [&](int row, int side) { return static_cast<std::uint32_t>(row * kSides + side % kSides); };
      look.mesh.triangles.push_back({at(n, k), at(n, k + 1), at(n + 1, k)});
      look.mesh.triangles.push_back({at(n + 1, k), at(n, k + 1), at(n + 1, k + 1)});
    }
  look.mesh.vertex_colors.assign(look.mesh.vertices.size(), {200, 10, 10, 255});
  look.cutting = {{-0.5, -0.5, -1}, {0.5, 0.5, 0}};
  return look;
}

// Triangles that pass the eye are clipped there, with some corners behind it.
TEST_F(LivePicture, AShankThatGoesPastTheEyeIsLitAsInFrontOfIt) {
  Camera camera = *cameraFromView("top");
  camera.half_height = 6;
  setFieldOfView(camera, 1.0);
  for (const double lean : {0.0, 0.1, 0.25, 0.4})
    for (const double aside : {0.7, 1.5, 3.0}) {
      LiveFrame frame;
      frame.T_world_tool = Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(lean, Vec3d::UnitY())), {aside, 0.3, 0}};
      renderer_->setTool(shankOf(1));
      const Image whole = picture(camera, frame);
      renderer_->setTool(shankOf(400));
      EXPECT_LT(test::pictureDifference(whole, picture(camera, frame)), 0.5) << lean << ' ' << aside;
    }
}

// A floor of 40 x 40 mm at z = 0 with that many squares per side, red to green to the right, matte to wet to the back.
Mesh floorOf(std::uint32_t squares) {
  Mesh mesh;
  for (std::uint32_t y = 0; y <= squares; ++y)
    for (std::uint32_t x = 0; x <= squares; ++x) {
      const double right = static_cast<double>(x) / squares, back = static_cast<double>(y) / squares;
      mesh.vertices.push_back({40 * right - 20, 40 * back - 20, 0});
      const auto byte = [](double share) { return static_cast<std::uint8_t>(std::lround(255 * share)); };
      mesh.vertex_colors.push_back({byte(1 - right), byte(right), byte(back), 255});
    }
  for (std::uint32_t y = 0; y < squares; ++y)
    for (std::uint32_t x = 0; x < squares; ++x) {
      const std::uint32_t n = y * (squares + 1) + x, above = n + squares + 1;
      mesh.triangles.push_back({n, n + 1, above + 1});
      mesh.triangles.push_back({n, above + 1, above});
    }
  return mesh;
}

// The colours of two large triangles match those of many small ones, also on a floor that passes the eye.
TEST_F(LivePicture, InPerspectiveColoursLieWhereTheyAreHoweverLargeATriangleIs) {
  Camera camera = *cameraFromView("10,20");
  camera.half_height = 6;
  const auto pictureOf = [&](std::uint32_t squares, bool is_ghost, const LiveFrame& frame) {
    renderer_->removeObject(0);
    const Mesh floor = floorOf(squares);
    for (const ColouredChunk& made : chunksOf(floor)) renderer_->setChunk(0, made.chunk, made.colours);
    renderer_->setGhost(0, is_ghost);
    return picture(camera, frame);
  };
  LiveFrame shaded = kPlain;
  shaded.has_shadow = true;
  shaded.T_world_tool = at(1, 2, 0.5);
  renderer_->setTool(redBur());
  for (const double field : {0.0, 0.4, 1.2})
    for (const bool is_ghost : {false, true})
      for (const LiveFrame& frame : {kPlain, shaded}) {
        setFieldOfView(camera, field);
        EXPECT_LT(test::pictureDifference(pictureOf(1, is_ghost, frame), pictureOf(256, is_ghost, frame)), 0.5)
            << field << " rad" << (is_ghost ? ", ghost" : "") << (frame.has_shadow ? ", shadow" : "");
      }
}

TEST_F(LivePicture, CullingChangesNoPixelInPerspectiveEither) {
  showBlock();
  renderer_->setTool(redBur());
  for (const double field : {0.3, 1.5})
    for (const double half_height : {6.0, 1.5, 0.4}) {
      Camera camera = camera_;
      camera.half_height = half_height;
      camera.target = {2, -1, 0};
      setFieldOfView(camera, field);
      LiveFrame frame{.T_world_tool = at(2, 0, -1)};
      const Image culled = picture(camera, frame);
      const std::size_t drawn = renderer_->counts().drawn_triangles;
      frame.is_culled = false;
      EXPECT_EQ(different(culled, picture(camera, frame)), 0) << field << " rad, " << half_height << " mm";
      if (half_height < 1) {
        EXPECT_LT(drawn, 0.8 * static_cast<double>(renderer_->counts().drawn_triangles));
      }
    }
}

/// Hills of 0.2 mm on 6 x 6 mm in triangles of 0.03 mm, about (x, 0, 0).
MeshChunk fineHills(float x) {
  constexpr int kSide = 200;
  MeshChunk hills;
  for (int j = 0; j <= kSide; ++j)
    for (int i = 0; i <= kSide; ++i) {
      const float u = 0.03f * static_cast<float>(i) - 3, v = 0.03f * static_cast<float>(j) - 3;
      hills.vertices.emplace_back(x + u, v, 0.2f * std::sin(9 * u + 2 * v) * std::cos(8 * v));
      hills.normals.push_back(Vec3f(std::sin(9 * u), std::cos(8 * v), 1.5f).normalized());
    }
  const auto number = [](int i, int j) { return static_cast<std::uint16_t>(j * (kSide + 1) + i); };
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      hills.triangles.push_back({number(i, j), number(i + 1, j), number(i + 1, j + 1)});
      hills.triangles.push_back({number(i, j), number(i + 1, j + 1), number(i, j + 1)});
    }
  return hills;
}

TEST_F(LivePicture, TrianglesThatCoverNoPixelAreLeftOutAndNotMissed) {
  for (const float x : {0.0f, 400.0f}) {
    renderer_->clear();
    renderer_->setChunk(0, fineHills(x));
    for (const double field : {0.0, 0.4})
      for (const char* view : {"top", "20,30", "-130,75", "10,8", "bottom"})
        for (const bool is_open : {false, true}) {
          Camera camera = *cameraFromView(view);
          camera.half_height = 5;
          camera.target = {x, 0, 0};
          setFieldOfView(camera, field);
          LiveFrame frame = kPlain;
          if (is_open) frame.section = Plane{.point = {x, 0.3, 0}, .normal = Vec3d(1, 2, 3).normalized()};
          const Image culled = picture(camera, frame);
          const std::size_t drawn = renderer_->counts().drawn_triangles;
          frame.is_culled = false;
          EXPECT_EQ(different(culled, picture(camera, frame)), 0) << x << " mm, " << view << ", " << field << " rad";
          EXPECT_LT(drawn, 0.6 * static_cast<double>(renderer_->counts().drawn_triangles)) << view;
        }
  }
}

// Stripes of 1 mm in the section plane appear at the places of its points.
TEST_F(LivePicture, ASectionShowsItsTissuesInPlaceInBothProjections) {
  showBlock();
  TissueSection stripes;
  stripes.width = 240;
  stripes.height = 100;
  stripes.origin = Vec3d(-6 + 0.025, 0, -4.5 + 0.025);
  stripes.u = 0.05 * Vec3d::UnitX();
  stripes.v = 0.05 * Vec3d::UnitZ();
  const auto isGreen = [](double x, double z) {
    return (static_cast<int>(std::floor(x)) + static_cast<int>(std::floor(z))) % 2 == 0;
  };
  for (int j = 0; j < stripes.height; ++j)
    for (int i = 0; i < stripes.width; ++i) {
      const Vec3d p = stripes.origin + i * stripes.u + j * stripes.v;
      stripes.colours.push_back(isGreen(p[0], p[2]) ? Rgba8{0, 200, 0, 255} : Rgba8{200, 0, 0, 255});
    }
  renderer_->setSection(0, stripes);

  for (const double degrees : {0, 30, 80}) {
    Camera camera = *cameraFromView("25,20");
    camera.half_height = 5;
    camera.target = {0.3, 1, -2};
    setFieldOfView(camera, degrees * 3.14159 / 180);
    LiveFrame frame = kPlain;
    frame.section = Plane{{0, 0, 0}, -Vec3d::UnitY()};
    const Image image = picture(camera, frame);
    for (double x = -4.5; x < 0.6; x += 1)
      for (double z = -3.5; z < 0; z += 1) {
        const auto pixel = kerf::pixelOf(camera, {x, 0, z}, kWidth, kHeight);
        const auto* const shown = image.at(static_cast<int>(pixel[0]), static_cast<int>(pixel[1]));
        EXPECT_EQ(shown[1] > shown[0], isGreen(x, z)) << degrees << " deg, " << x << ", " << z;
        EXPECT_GT(std::max(shown[0], shown[1]), 190) << degrees << " deg, " << x << ", " << z;
      }

    // The lid lies in the plane: it hides a tool behind it, but not one in front.
    renderer_->setTool(redBur());
    renderer_->setSection(0, {});
    frame.section_color = {0, 200, 0, 255};
    frame.T_world_tool = at(-2, 1.5, -3);
    const auto seen = [&](double y) {
      frame.T_world_tool = at(-2, y, -3);
      const auto pixel = kerf::pixelOf(camera, Vec3d(-2, y, -2.5), kWidth, kHeight);
      const auto* const shown = picture(camera, frame).at(static_cast<int>(pixel[0]), static_cast<int>(pixel[1]));
      return isRed(shown[0], shown[1], shown[2]);
    };
    EXPECT_FALSE(seen(1.5)) << degrees;
    EXPECT_TRUE(seen(-1.5)) << degrees;
    renderer_->setSection(0, stripes);
  }
}

TEST_F(LivePicture, InPerspectiveAPlannedCutIsAsWideInPixelsEverywhere) {
  showBlock();
  setFieldOfView(camera_, 1.0);
  LiveFrame frame = kPlain;
  // From behind the focus to in front of it.
  frame.plan.lines = {{camera_.target - 4 * camera_.right() - 4 * camera_.backwards(),
                       camera_.target + 2 * camera_.right() + 5 * camera_.backwards()}};
  const Image image = picture(frame);
  int least = 1000, most = 0;
  for (double part = 0.1; part < 0.95; part += 0.1) {
    const Vec3d p = frame.plan.lines[0].from + part * (frame.plan.lines[0].to - frame.plan.lines[0].from);
    const int x = static_cast<int>(kerf::pixelOf(camera_, p, kWidth, kHeight)[0]);
    if (x < 0 || x >= kWidth) continue;
    int wide = 0;
    for (int y = 0; y < kHeight; ++y) wide += isPlanBlue(image.at(x, y)[0], image.at(x, y)[1], image.at(x, y)[2]);
    least = std::min(least, wide);
    most = std::max(most, wide);
  }
  EXPECT_GE(least, 2);
  EXPECT_LE(most, 5);
}

TEST_F(LivePicture, PosesThatAreNotUsableHideWhatHasThem) {
  showBlock();
  renderer_->setTool(redBur());
  const Image plain = picture(kPlain);
  LiveFrame frame;
  frame.T_world_tool = at(kNaN, 0, 0);
  EXPECT_EQ(different(picture(frame), plain), 0);
  frame.T_world_tool = at(1e300, 0, 0);
  EXPECT_EQ(different(picture(frame), plain), 0);
  frame.T_world_tool->rotation.coeffs().setZero();
  EXPECT_EQ(different(picture(frame), plain), 0);

  renderer_->setPose(0, at(0, kNaN, 0));
  EXPECT_EQ(count(picture(), isIvory), 0);
  renderer_->setPose(0, {});
  renderer_->setVisible(0, false);
  EXPECT_EQ(count(picture(), isIvory), 0);
  renderer_->setVisible(0, true);
  EXPECT_EQ(different(picture(), plain), 0);

  frame = {.T_world_tool = at(0, 0, 0), .contact_mm = kNaN, .axis_line_mm = kNaN};
  frame.section = Plane{{kNaN, 0, 0}, Vec3d::UnitZ()};
  frame.supersampling = -3;
  picture(frame);
  Camera camera = camera_;
  camera.azimuth = kNaN;
  EXPECT_TRUE(renderer_->draw(camera, 10, 10, {}));
}

TEST_F(LivePicture, SizesOfNothingAndOfOnePixelDoNotHarm) {
  showBlock();
  const internal::GlTarget target(1, 1);
  glBindFramebuffer(GL_FRAMEBUFFER, target.id());
  EXPECT_TRUE(renderer_->draw(camera_, 0, 0, {}));
  EXPECT_TRUE(renderer_->draw(camera_, 100, -1, {}));
  EXPECT_TRUE(renderer_->draw(camera_, 1, 1, {}));
  EXPECT_TRUE(renderer_->picture(camera_, 1, 1, {.supersampling = 3}));
  EXPECT_FALSE(renderer_->picture(camera_, 0, 100, {}));
  EXPECT_FALSE(renderer_->picture(camera_, 100, 9000, {}));
}

TEST_F(LivePicture, ALostFramebufferIsAnErrorAndTheNextFrameIsDrawn) {
  showBlock();
  const Image before = picture();
  GLuint incomplete = 0;
  glGenFramebuffers(1, &incomplete);
  glBindFramebuffer(GL_FRAMEBUFFER, incomplete);
  for (const int supersampling : {1, 2}) {
    glBindFramebuffer(GL_FRAMEBUFFER, incomplete);
    const auto lost = renderer_->draw(camera_, kWidth, kHeight, {.supersampling = supersampling});
    ASSERT_FALSE(lost);
    EXPECT_NE(lost.error().message().find("framebuffer"), std::string::npos);
  }
  glDeleteFramebuffers(1, &incomplete);
  EXPECT_EQ(different(before, picture()), 0);
}

TEST_F(LivePicture, AChunkThatIsNotSoundIsTakenAsEmpty) {
  MeshChunk chunk;
  chunk.vertices = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  chunk.normals.assign(3, Vec3f::UnitZ());
  chunk.triangles = {{0, 1, 2}};
  renderer_->setChunk(0, chunk);
  EXPECT_GT(count(picture(), isIvory), 500);

  MeshChunk wrong = chunk;
  wrong.triangles = {{0, 1, 3}};
  renderer_->setChunk(0, wrong);
  EXPECT_EQ(count(picture(), isIvory), 0);
  const std::vector<Rgba8> two_colours(2);
  renderer_->setChunk(0, chunk, two_colours);
  EXPECT_EQ(count(picture(), isIvory), 0);
  wrong = chunk;
  wrong.vertices[1][0] = std::numeric_limits<float>::infinity();
  renderer_->setChunk(0, wrong);
  EXPECT_EQ(count(picture(), isIvory), 0);
}

TEST_F(LivePicture, OnlyWhatChangedIsUploaded) {
  showBlock();
  picture();
  const std::size_t all = renderer_->counts().uploaded_bytes;
  picture();
  EXPECT_EQ(renderer_->counts().uploaded_bytes, 0u);
  renderer_->setChunk(0, *block_.chunks().front());
  picture();
  EXPECT_GT(renderer_->counts().uploaded_bytes, 0u);
  EXPECT_LT(renderer_->counts().uploaded_bytes, all / 3);
}

TEST_F(LivePicture, SupersamplingSmoothsEdgesAndMovesNothing) {
  showBlock();
  const Image rough = picture(kPlain);
  LiveFrame frame = kPlain;
  frame.supersampling = 3;
  const Image smooth = picture(frame);
  EXPECT_LT(different(rough, smooth, 24), 1500);  // along edges
  EXPECT_NEAR(count(smooth, isIvory) / double(count(rough, isIvory)), 1, 0.02);
}

// ---- A share of the upload in each frame

TEST_F(LivePicture, AFrameUploadsItsShareAndAfterAFewTheSurfaceIsWhole) {
  showBlock();
  LiveFrame frame = kPlain;
  frame.most_upload = 1;  // a page
  const internal::GlTarget target(kWidth, kHeight);
  const auto drawn = [&] {
    glBindFramebuffer(GL_FRAMEBUFFER, target.id());
    const auto done = renderer_->draw(camera_, kWidth, kHeight, frame);
    EXPECT_TRUE(done) << done.error().message();
    return target.read();
  };

  Image last = drawn();
  const std::size_t pages = renderer_->counts().waiting_pages + 1;
  ASSERT_GT(pages, 2u) << "else there is nothing to share";
  for (std::size_t n = 1; n < pages; ++n) {
    const std::uint64_t version = renderer_->version();
    last = drawn();
    EXPECT_EQ(renderer_->counts().waiting_pages, pages - 1 - n);
    EXPECT_EQ(renderer_->version() != version, n + 1 < pages) << "there is more to come, or there is not";
  }
  drawn();
  EXPECT_EQ(renderer_->counts().uploaded_bytes, 0u);
  EXPECT_EQ(different(last, picture(kPlain)), 0);
}

TEST_F(LivePicture, APictureShowsAllThatFramesHaveNotUploadedYet) {
  showBlock();
  const Image whole = picture(kPlain);
  renderer_->clear();
  showBlock();
  LiveFrame frame = kPlain;
  frame.most_upload = 1;
  EXPECT_EQ(different(picture(frame), whole), 0);
  EXPECT_EQ(renderer_->counts().waiting_pages, 0u);
}

TEST_F(LivePicture, WhatIsCutComesBeforeWhatIsNew) {
  for (const MeshChunkPtr& chunk : block_.chunks()) renderer_->setChunk(1, *chunk);
  const Image before = picture(kPlain);
  renderer_->setVisible(0, false);  // new content: first in the renderer's order
  for (const MeshChunkPtr& chunk : block_.chunks()) renderer_->setChunk(0, *chunk);
  const auto isOnTop = [](const MeshChunkPtr& chunk) {
    return std::any_of(chunk->normals.begin(), chunk->normals.end(), [](const Vec3f& n) { return n[2] > 0.99f; });
  };
  const auto top = std::find_if(block_.chunks().begin(), block_.chunks().end(), isOnTop);
  ASSERT_NE(top, block_.chunks().end());
  const std::vector<Rgba8> green((*top)->vertices.size(), {20, 220, 20, 140});
  renderer_->setChunk(1, **top, green);

  LiveFrame frame = kPlain;
  frame.most_upload = 1;
  const internal::GlTarget target(kWidth, kHeight);
  glBindFramebuffer(GL_FRAMEBUFFER, target.id());
  ASSERT_TRUE(renderer_->draw(camera_, kWidth, kHeight, frame));
  const Image first = target.read();
  EXPECT_GT(renderer_->counts().waiting_pages, 0u);
  EXPECT_GT(different(first, before), 50);
  EXPECT_EQ(different(first, picture(kPlain)), 0);
}

// A wide tool changes more pages per frame than its share.
TEST_F(LivePicture, NoPageWaitsForEverBehindOthersThatChangeInEveryFrame) {
  for (const MeshChunkPtr& chunk : block_.chunks()) renderer_->setChunk(1, *chunk);
  picture(kPlain);
  const auto pageOf = [](const MeshChunk& chunk) {
    return std::array<int, 3>{chunk.brick[0] >> 3, chunk.brick[1] >> 3, chunk.brick[2] >> 3};
  };
  const auto isOnTop = [](const MeshChunkPtr& chunk) {
    return std::any_of(chunk->normals.begin(), chunk->normals.end(), [](const Vec3f& n) { return n[2] > 0.99f; });
  };
  MeshChunkPtr last;  // in the order of the renderer
  for (const MeshChunkPtr& chunk : block_.chunks())
    if (isOnTop(chunk) && (!last || pageOf(*last) < pageOf(*chunk))) last = chunk;
  ASSERT_TRUE(last);
  renderer_->setChunk(1, *last, std::vector<Rgba8>(last->vertices.size(), {20, 220, 20, 140}));

  LiveFrame frame = kPlain;
  frame.most_upload = 1;
  const internal::GlTarget target(kWidth, kHeight);
  const auto isGreen = [](int r, int g, int b) { return g > r + 60 && g > b + 60; };
  std::size_t frames = 0, pages = 1;
  for (int seen = 0; seen == 0; ++frames) {
    for (const MeshChunkPtr& chunk : block_.chunks())
      if (pageOf(*chunk) != pageOf(*last)) renderer_->setChunk(1, *chunk);
    glBindFramebuffer(GL_FRAMEBUFFER, target.id());
    ASSERT_TRUE(renderer_->draw(camera_, kWidth, kHeight, frame));
    pages = std::max(pages, renderer_->counts().waiting_pages + 1);
    ASSERT_LE(frames, pages) << "it is never its turn";
    seen = count(target.read(), isGreen);
  }
  EXPECT_GT(pages, 2u) << "else nobody waits";
}

// ---- A still picture

TEST_F(LivePicture, OfAStillSceneGetsSmoothFromFrameToFrameAndStartsAnewWhenAnythingMoves) {
  showBlock();
  renderer_->setTool(redBur());
  LiveFrame frame = kPlain;
  frame.T_world_tool = at(2, 0, 0.2);
  const internal::GlTarget target(kWidth, kHeight);
  StillPicture still;
  const auto drawn = [&] {
    glBindFramebuffer(GL_FRAMEBUFFER, target.id());
    const auto done = still.draw(*renderer_, camera_, kWidth, kHeight, frame);
    EXPECT_TRUE(done) << done.error().message();
    return target.read();
  };

  const Image once = drawn();
  EXPECT_EQ(still.samples(), 0);
  EXPECT_EQ(different(once, picture(frame)), 0) << "the first is a frame as ever";
  Image smooth;
  for (int n = 1; n <= StillPicture::kSamples; ++n) {
    smooth = drawn();
    EXPECT_EQ(still.samples(), n);
  }
  EXPECT_EQ(different(smooth, drawn()), 0) << "then it stays as it is";

  // Its edges come from nine points per pixel instead of one.
  LiveFrame fine = frame;
  fine.supersampling = 3;
  const Image truth = picture(fine);
  const int off_once = different(once, truth, 24), off_smooth = different(smooth, truth, 24);
  EXPECT_GT(off_once, 100);
  EXPECT_LT(off_smooth, off_once / 4);

  // Changes are drawn at once.
  const auto startsAnew = [&](const char* what) {
    const Image now = drawn();
    EXPECT_EQ(still.samples(), 0) << what;
    EXPECT_EQ(different(now, picture(frame)), 0) << what;
    drawn();
    EXPECT_EQ(still.samples(), 1) << what;
  };
  camera_.azimuth += 0.01;
  startsAnew("the camera");
  frame.T_world_tool = at(2, 0, 0.1);
  startsAnew("the tool");
  renderer_->setPose(0, at(0.1, 0, 0));
  startsAnew("the object");
  renderer_->setVisible(0, false);
  startsAnew("what is hidden");
  renderer_->setVisible(0, true);
  frame.section = Plane{{0, 0, -1}, Vec3d::UnitX()};
  startsAnew("the section");
  renderer_->setChunk(0, *block_.chunks().front(), {}, {});
  startsAnew("the surface");
  // Setting an unchanged value is no change.
  renderer_->setVisible(0, false);
  renderer_->setVisible(0, true);
  drawn();
  EXPECT_EQ(still.samples(), 2);
}

}  // namespace
}  // namespace kerf::live_renderer_test
