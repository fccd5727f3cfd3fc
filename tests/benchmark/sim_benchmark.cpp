// The work after a cut: meshing the changes and finding the pieces.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <thread>
#include <vector>

#include "bench/scenes/carved_field.h"
#include "geometry/field/sample_field.h"
#include "sim/live/mesher_thread.h"
#include "sim/live/remesher.h"
#include "sim/pieces/pieces.h"
#include "sim/pieces/split_field.h"

namespace kerf {
namespace {

using scenes::ballWithAHole;
using scenes::carve;

// Dents at different places of a ball of 12 mm at 0.1 mm: 60 bricks changed by a tool of a millimetre or more.
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

// The same through the mesher's thread: from the first push to the chunks at the reader.
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

// A block of 50 x 50 x `long_mm` mm at 0.1 mm, sawn through except for a bridge of 1 x 1 mm.
BrickField sawnBlock(double long_mm) {
  Box3 box;
  box.add(Vec3d(-25, -25, -long_mm / 2));
  box.add(Vec3d(25, 25, long_mm / 2));
  return sampleDistance(
      [half = Vec3d(25, 25, long_mm / 2)](const Vec3d& p) {
        const Vec3d d = p.cwiseAbs() - half;
        const double block = d.cwiseMax(0.0).norm() + std::min(0.0, d.maxCoeff());
        const double kerf = std::max(std::abs(p[2] - 5) - 0.2, 0.5 - std::max(std::abs(p[0]), std::abs(p[1])));
        return std::max(block, -kerf);
      },
      box, 0.1);
}

// From the edits that remove the last bridge to the pieces.
void piecesOfABlock(benchmark::State& state) {
  const BrickField phi0 = sawnBlock(static_cast<double>(state.range(0)));
  const auto before_build = std::chrono::steady_clock::now();
  PieceFinder finder(phi0);
  state.counters["build_ms"] = 1e3 * seconds(std::chrono::steady_clock::now() - before_build);
  OverlayField truth(phi0);
  std::vector<BrickEdit> whole;  // the bridge's bricks before and after
  const std::vector<BrickEdit> cut = carve(truth, {0, 0, 5}, 0.9);
  for (const BrickEdit& e : cut) {
    BrickEdit old = e;
    if (const BrickValues* values = phi0.valuesAt(e.brick))
      old.phi = *values;
    else
      old.phi.fill(phi0.constantAt(e.brick));
    whole.push_back(old);
  }
  std::vector<double> times;
  std::size_t count = 0;
  for (auto _ : state) {
    finder.apply(whole);
    if (finder.find().pieces.size() != 1) state.SkipWithError("the bridge does not hold");
    const auto before = std::chrono::steady_clock::now();
    finder.apply(cut);
    count = finder.find().pieces.size();
    times.push_back(seconds(std::chrono::steady_clock::now() - before));
    state.SetIterationTime(times.back());
  }
  report(state, times);
  state.counters["pieces"] = static_cast<double>(count);
  state.counters["edits"] = static_cast<double>(cut.size());
  state.counters["nodes"] = static_cast<double>(finder.find().whole.nodes);
}
BENCHMARK(piecesOfABlock)->Arg(20)->Arg(100)->UseManualTime()->Iterations(20)->Unit(benchmark::kMillisecond);

// The smaller piece of the block as a separate field.
void splitABlock(benchmark::State& state) {
  const BrickField phi0 = sawnBlock(static_cast<double>(state.range(0)));
  OverlayField truth(phi0);
  PieceFinder finder(phi0);
  finder.apply(carve(truth, {0, 0, 5}, 0.9));
  const std::uint32_t smaller = finder.find().pieces.at(1).id;
  std::size_t bricks = 0;
  for (auto _ : state) bricks = splitField(finder, smaller).brickCount();
  state.counters["bricks"] = static_cast<double>(bricks);
}
BENCHMARK(splitABlock)->Arg(20)->Arg(100)->Iterations(2)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kerf
