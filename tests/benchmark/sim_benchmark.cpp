// What follows a cut: meshing again what changed.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <vector>

#include "sim/remesher.h"
#include "tests/sim/carved_field.h"

namespace kerf {
namespace {

// From 60 changed bricks to their chunks: a dent in a ball of 12 mm at 0.1 mm, another one each time.
void remeshSixtyBricks(benchmark::State& state) {
  const BrickField phi0 = ballWithAHole(6.0, 0.1);
  OverlayField truth(phi0);
  Remesher remesher(phi0);
  std::mt19937 random(4);
  std::normal_distribution<double> n;
  std::vector<double> ms;
  std::size_t dirty = 0;
  for (auto _ : state) {
    const Vec3d p = 6.0 * Vec3d(n(random), n(random), n(random)).normalized();
    std::vector<BrickEdit> edits;
    for (double radius = 0.5; edits.size() < 60; radius += 0.1) {
      OverlayField copy = truth;
      edits = carve(copy, p, radius);
    }
    edits.resize(60);
    for (const BrickEdit& e : edits) truth.set(e);
    const auto before = std::chrono::steady_clock::now();
    dirty += remesher.apply(edits);
    benchmark::DoNotOptimize(remesher.changedSince(remesher.version() - 1));
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - before;
    state.SetIterationTime(took.count());
    ms.push_back(1e3 * took.count());
  }
  double sum = 0;
  for (const double t : ms) sum += t;
  std::sort(ms.begin(), ms.end());
  state.counters["p50_ms"] = ms[ms.size() / 2];
  state.counters["p95_ms"] = ms[ms.size() * 95 / 100];
  state.counters["max_ms"] = ms.back();
  state.counters["us_per_brick"] = 1e3 * sum / static_cast<double>(dirty);
}
BENCHMARK(remeshSixtyBricks)->UseManualTime()->Iterations(200)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kerf
