// Burs pressed into enamel and dentin: the surface warms as measured, for every bur size.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>

#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "geometry/tool/tool_file.h"
#include "sim/monitor/monitor.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::heat_of_burs_test {
namespace {

using namespace scenes;
using Block = std::shared_ptr<const BakedObject>;

Block blockOf(Material material) {
  const auto block = practiceBlock({2.4, 4, 3}, 0.1, {}, material);
  EXPECT_TRUE(block) << block.error().message();
  return *block;
}

// Means from a moment on, K. The spray is at body temperature: measurements give the rise by the cut alone.
struct Warmth {
  double dry = 0, wet = 0;
  double watts = 0, area = 0;  // of the drive; mm^2
};

// A guided hand pushes the bur straight down.
Warmth press(const char* id, const Block& block, double newtons, double seconds, double from) {
  const auto file = findToolFile(id, defaultToolFolders());
  EXPECT_TRUE(file) << file.error().message();
  auto tool = readTool(*file);
  EXPECT_TRUE(tool) << tool.error().message();
  auto model = makeModel(std::span(&*tool, 1));
  EXPECT_TRUE(model) << model.error().message();

  const HeatSettings body_warm{.coolant_rise = 0};
  auto dry = Monitor::make({block}, model->tools[0], heatSource(*tool), body_warm);
  auto wet = Monitor::make({block}, model->tools[0], heatSource(*tool), body_warm);
  EXPECT_TRUE(dry && wet);
  const Rigid3 start{Eigen::Quaterniond::Identity(), {0.011, 0.013, 0.02}};
  State state;
  state.objects.emplace_back(block, 4096);
  state.place(start);
  state.speed = model->tools[0].drive.speed;

  Warmth out;
  StepOutput tick;
  tick.T_world_tool = start;
  int counted = 0;
  for (int n = 0; n < seconds / kTick; ++n) {
    Rigid3 hand = start;
    hand.translation[2] = tick.T_world_tool.translation[2] - newtons / model->settings.coupling.stiffness;
    DeviceSample sample = sampleAt(hand);
    step(*model, state, sample, tick);
    reserveForTicks(state.objects[0]);
    sample.irrigation = 0;
    dry->tick(sample, tick, state.objects);
    sample.irrigation = 1;
    wet->tick(sample, tick, state.objects);
    if (n < from / kTick) continue;
    ++counted;
    out.dry += dry->heat().surfaceRise();
    out.wet += wet->heat().surfaceRise();
    out.watts += tick.power / 1000;
    out.area += dry->area();
  }
  for (double* sum : {&out.dry, &out.wet, &out.watts, &out.area}) *sum /= counted;
  return out;
}

// 0.5 to 2.3 mm.
struct Bur {
  const char* id;
  bool is_diamond;
};
constexpr Bur kBurs[] = {{"round-005", false}, {"us-330", false},    {"801-010", true},
                         {"round-010", false}, {"round-023", false}, {"801-023", true}};
constexpr Material kTissues[] = {Material::kEnamel, Material::kDentin};
// Carbide warms less than diamond: by a factor of 0.68 to 0.81 on teeth under spray (IADR 2002, San Diego 18318), 0.30
// and 0.33 in fillings, dry (Mafrici et al. 2024, doi 10.2341/23-033-L).
constexpr double kLeastRatio = 0.30, kMostRatio = 0.81;

// Diamond at 1 N: 50 to 115 K dry after a second of 5 W, of which a ball pushed straight down spends half or more; 3 to
// 17 K wet (IADR 2002: 4.0 to 16.8 K). The rise is at most proportional to the force.
TEST(HeatOfBurs, OfEachSizeAndKindWarmTheSurfaceAsMeasured) {
  for (const Material material : kTissues) {
    const Block block = blockOf(material);
    for (const Bur& bur : kBurs)
      for (const double newtons : {0.5, 1.0, 2.0}) {
        const Warmth found = press(bur.id, block, newtons, 1.2, 0.8);
        const double low = std::min(newtons, 1.0) * (bur.is_diamond ? 1 : kLeastRatio);
        const double high = newtons * (bur.is_diamond ? 1 : kMostRatio);
        const std::string what =
            fmt::format("{}, {} N, {}, {:.2f} W, {:.2f} mm2", bur.id, newtons,
                        material == Material::kEnamel ? "enamel" : "dentin", found.watts, found.area);
        EXPECT_GT(found.dry, 40 * low) << what;
        EXPECT_LT(found.dry, 115 * high) << what;
        EXPECT_GT(found.wet, 3 * low) << what;
        EXPECT_LT(found.wet, 17 * high) << what;
      }
  }
}

TEST(HeatOfBurs, CarbideWarmsLessThanDiamondOfItsSize) {
  for (const Material material : kTissues) {
    const Block block = blockOf(material);
    for (const auto& [carbide, diamond] : {std::pair{"round-010", "801-010"}, std::pair{"round-023", "801-023"}}) {
      const Warmth of_carbide = press(carbide, block, 1, 0.8, 0.4), of_diamond = press(diamond, block, 1, 0.8, 0.4);
      for (const double ratio : {of_carbide.dry / of_diamond.dry, of_carbide.wet / of_diamond.wet}) {
        EXPECT_GT(ratio, kLeastRatio) << carbide;
        EXPECT_LT(ratio, kMostRatio) << carbide;
      }
    }
  }
}

}  // namespace
}  // namespace kerf::heat_of_burs_test
