// What follows a cut: meshing again what changed.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <thread>
#include <vector>

#include "sim/mesher_thread.h"
#include "sim/remesher.h"
#include "tests/sim/carved_field.h"

namespace kerf {
namespace {

// Dents in a ball of 12 mm at 0.1 mm, each at another place: 60 bricks changed by a tool of a millimetre or more.
class Dents {
 public:
  const BrickField phi0 = ballWithAHole(6.0, 0.1);

  std::vector<BrickEdit> next() {
    const Vec3d p = 6.0 * Vec3d(normal_(random_), normal_(random_), normal_(random_)).normalized();
    std::vector<BrickEdit> edits;
    for (double radius = 0.5; edits.size() < 60; radius += 0.1) {
      OverlayField copy = truth_;
      edits = carve(copy, p, radius);
    }
    edits.resize(60);
    for (const BrickEdit& e : edits) truth_.set(e);
    return edits;
  }

 private:
  OverlayField truth_{phi0};
  std::mt19937 random_{4};
  std::normal_distribution<double> normal_;
};

double seconds(std::chrono::steady_clock::duration d) { return std::chrono::duration<double>(d).count(); }

void report(benchmark::State& state, std::vector<double> times) {
  std::sort(times.begin(), times.end());
  state.counters["p50_ms"] = 1e3 * times[times.size() / 2];
  state.counters["p95_ms"] = 1e3 * times[times.size() * 95 / 100];
  state.counters["max_ms"] = 1e3 * times.back();
}

// From 60 changed bricks to their chunks.
void remeshSixtyBricks(benchmark::State& state) {
  Dents dents;
  Remesher remesher(dents.phi0);
  std::vector<double> times;
  double sum = 0;
  std::size_t dirty = 0;
  for (auto _ : state) {
    const std::vector<BrickEdit> edits = dents.next();
    const auto before = std::chrono::steady_clock::now();
    dirty += remesher.apply(edits);
    benchmark::DoNotOptimize(remesher.changedSince(remesher.version() - 1));
    times.push_back(seconds(std::chrono::steady_clock::now() - before));
    sum += times.back();
    state.SetIterationTime(times.back());
  }
  report(state, times);
  state.counters["us_per_brick"] = 1e6 * sum / static_cast<double>(dirty);
}
BENCHMARK(remeshSixtyBricks)->UseManualTime()->Iterations(200)->Unit(benchmark::kMillisecond);

// The same through the mesher's thread: from the first push to the chunks in the reader's hand.
void meshSixtyBricksInTheThread(benchmark::State& state) {
  Dents dents;
  BrickFeed feed;
  MesherThread mesher(dents.phi0, feed);
  std::vector<double> times;
  std::uint64_t pushed = 0;
  for (auto _ : state) {
    const std::vector<BrickEdit> edits = dents.next();
    mesher.take();
    const auto before = std::chrono::steady_clock::now();
    for (const BrickEdit& e : edits) pushed += feed.tryPush(e.brick, e.phi);
    while (mesher.editsDone() != pushed) std::this_thread::yield();
    benchmark::DoNotOptimize(mesher.take());
    times.push_back(seconds(std::chrono::steady_clock::now() - before));
    state.SetIterationTime(times.back());
  }
  report(state, times);
}
BENCHMARK(meshSixtyBricksInTheThread)->UseManualTime()->Iterations(200)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kerf
