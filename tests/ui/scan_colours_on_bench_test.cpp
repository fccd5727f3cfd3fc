// The scan's colours on the cut surface: visible from the start, and by choice.
#include <cmath>

#include "sim/live/scan_colours.h"
#include "tests/ui/block_on_bench.h"
#include "ui/app/commands/app_commands.h"
#include "ui/app/document/document.h"
#include "ui/app/document/view_state.h"
#include "ui/app/view/tissue_display.h"
#include "ui/app/workbench/strokes.h"

namespace kerf::scan_colours_on_bench_test {
namespace {

constexpr Rgba8 kRose = {220, 120, 130, 255}, kIvory = {240, 235, 210, 255};

class ColouredBlock : public test::OnABlock {
 protected:
  // Rose on its left side, ivory on its right side, mixed in between.
  Mesh block() const override {
    Mesh out = test::blockMesh(false);
    for (const Vec3d& p : out.vertices) out.vertex_colors.push_back(p[0] < 0 ? kRose : kIvory);
    return out;
  }
  // Counts of the displayed vertices selected by `is_wanted`.
  struct Shown {
    int count = 0, as_scanned = 0;
  };
  Shown shownAt(const std::function<bool(const Vec3d&)>& is_wanted) const {
    Shown out;
    for (const SceneObject* object : bench_.document->scene().shown())
      object->surface.forEachChunk([&](const MeshChunk& chunk) {
        const std::vector<Rgba8> colours = bench_.views->tissues().coloursOf(chunk);
        ASSERT_EQ(colours.size(), chunk.vertices.size());
        for (std::size_t v = 0; v < colours.size(); ++v) {
          const Vec3d p = chunk.vertices[v].cast<double>();
          if (!is_wanted(p)) continue;
          ++out.count;
          out.as_scanned += isAsScanned(p, colours[v]);
        }
      });
    return out;
  }
  static bool isAsScanned(const Vec3d& p, const Rgba8& colour) {
    const double share = std::clamp(p[0] / 6 + 0.5, 0.0, 1.0);
    for (std::size_t k = 0; k < 3; ++k)
      if (std::abs((1 - share) * kRose[k] + share * kIvory[k] - colour[k]) > 6) return false;
    return true;
  }
  static bool isOnTop(const Vec3d& p) { return p[2] > -0.02 && p.head<2>().cwiseAbs().maxCoeff() < 1.8; }
};

TEST_F(ColouredBlock, ItIsShownAsItWasScannedAndTheFloorOfACutAsItsTissue) {
  EXPECT_EQ(bench_.views->tissues().colours(), SurfaceColours::kScan);
  const Shown before = shownAt(isOnTop);
  EXPECT_GT(before.count, 500);
  EXPECT_EQ(before.as_scanned, before.count);

  ASSERT_TRUE(bench_.strokes->press(pointedRay(context_, std::vector<std::string>{"200", "150"}).value()));
  runToDepth();
  bench_.strokes->release();
  run(0.3);
  const auto isFloor = [](const Vec3d& p) { return p[2] < -0.3 && p[2] > -1.5 && p.head<2>().norm() < 1; };
  const Shown floor = shownAt(isFloor);
  EXPECT_GT(floor.count, 20);
  EXPECT_EQ(floor.as_scanned, 0);
  const Shown around = shownAt([](const Vec3d& p) { return isOnTop(p) && p.head<2>().norm() > 1.2; });
  EXPECT_GT(around.count, 300);
  EXPECT_EQ(around.as_scanned, around.count);
}

TEST_F(ColouredBlock, TissuesAndTheScanAreShownByChoice) {
  const std::uint64_t version = bench_.views->tissues().coloursVersion();
  ASSERT_TRUE(runAppCommand(context_, "view.colours", std::vector<std::string>{"tissue"}));
  EXPECT_EQ(shownAt(isOnTop).as_scanned, 0);
  EXPECT_GT(bench_.views->tissues().coloursVersion(), version) << "what is shown is coloured anew";
  ASSERT_TRUE(runAppCommand(context_, "view.colours-scan"));
  EXPECT_EQ(shownAt(isOnTop).as_scanned, shownAt(isOnTop).count);
}

using PlainBlock = test::OnABlock;
TEST_F(PlainBlock, AScanWithoutColoursIsShownByItsTissueAndHasNoOtherChoice) {
  EXPECT_EQ(bench_.views->tissues().colours(), SurfaceColours::kTissue);
  const auto refused = runAppCommand(context_, "view.colours", std::vector<std::string>{"scan"});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Error::Code::kUnsupported);
  EXPECT_EQ(bench_.views->tissues().colours(), SurfaceColours::kTissue);
}

}  // namespace
}  // namespace kerf::scan_colours_on_bench_test
