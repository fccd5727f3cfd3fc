#include "bench/scenes/strokes.h"

#include <cmath>
#include <numeric>
#include <random>

#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "geometry/field/marching_cubes.h"

namespace kerf::scenes {
namespace {

constexpr int kTicks = 8;         // of a stroke
constexpr double kLongest = 0.4;  // mm along each axis
constexpr double kAbove = 0.4;    // mm over the block

double sum(const std::array<double, 256>& volumes) { return std::accumulate(volumes.begin(), volumes.end(), 0.0); }

Model ballModel(double radius, bool geometry_only) {
  Model model;
  model.tools = {practiceBall(radius, 840)};
  model.tissues = oneTissue(200, 0.5, 1000);
  model.settings.rendering = Rendering::kRigid;
  model.settings.geometry_only = geometry_only;
  return model;
}

}  // namespace

double StrokesLedger::imbalance() const { return std::abs(loaded - removed - left) / loaded; }

Expected<StrokesLedger> cutAtRandom(const RandomStrokes& strokes, const Progress& progress) {
  const Model model = ballModel(strokes.radius, strokes.geometry_only);
  KERF_TRY(block, practiceBlock(strokes.block, strokes.voxel, askew()));
  State state;
  state.objects.emplace_back(block, 8192);
  const CutObject& object = state.objects[0];
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(-1, 1);

  StepOutput out;
  for (int n = 0; n < strokes.count; ++n) {
    if (n % 64 == 0 && !report(progress, static_cast<double>(n) / strokes.count, "strokes"))
      return fail({.code = Error::Code::kCancelled, .found = "cancelled"});
    const double x = u(random), y = u(random), z = u(random);
    const Vec3d half = 0.5 * strokes.block + Vec3d::Constant(0.3);
    const Vec3d begin(half[0] * x, half[1] * y, 0.5 * (1 + z) * (strokes.block[2] + kAbove) - strokes.block[2]);
    const double dx = u(random), dy = u(random), dz = u(random);
    const Vec3d way = kLongest * Vec3d(dx, dy, dz);

    state.has_device = false;  // no sweep from the last stroke
    for (int tick = 0; tick < kTicks; ++tick) {
      reserveForTicks(state.objects[0]);
      Rigid3 pose;
      pose.translation = begin + static_cast<double>(tick) / kTicks * way;
      step(model, state, sampleAt(askew() * pose), out);
    }
  }

  StrokesLedger ledger;
  ledger.loaded = sum(object.baked().volumes());
  ledger.removed = sum(object.removed_mm3);
  ledger.left = sum(object.bricks().countVolumes());
  ledger.mesh_loaded = signedVolume(marchingCubes(object.baked().phi0()));
  ledger.mesh_removed = ledger.mesh_loaded - signedVolume(marchingCubes(object.bricks().field()));
  ledger.state = object.stateHash();
  return ledger;
}

Expected<FillingLedger> cutFilling(bool geometry_only) {
  constexpr double kDeep = 1, kSmall = 0.4, kLarge = 0.8;  // mm
  constexpr int kDown = 200;                               // ticks
  Model model = ballModel(kSmall, true);
  model.tools.push_back(practiceBall(kLarge, 840));
  KERF_TRY(block, practiceBlock({4, 4, 3}, 0.1, askew()));
  State state;
  state.objects.emplace_back(block, 8192);

  StepOutput out;
  const auto dip = [&](double from, double to) {
    state.has_device = false;
    for (int n = 0; n <= 2 * kDown; ++n) {
      Rigid3 pose;
      pose.translation[2] = from + (to - from) * (1 - std::abs(1 - static_cast<double>(n) / kDown));
      step(model, state, sampleAt(askew() * pose), out);
    }
  };

  dip(0.1, -kDeep);
  state.adds = Material::kComposite;
  dip(0.1, -kDeep);
  state.adds = Material::kNone;

  state.selectTool(1);
  model.settings.geometry_only = geometry_only;
  for (int pass = 0; pass < 3; ++pass) dip(0.1, -kDeep - 0.4);

  const CutObject& object = state.objects[0];
  constexpr auto kComposite = static_cast<std::size_t>(Material::kComposite);
  return FillingLedger{object.added_mm3[kComposite], object.removed_mm3[kComposite],
                       object.bricks().countVolumes()[kComposite]};
}

}  // namespace kerf::scenes
