// Micro-benchmarks of the inner loops: build/release/bin/kerf_benchmarks. Compare ratios within one run, never absolute
// times between machines. `kerf-bench` times whole scenes.
#include <benchmark/benchmark.h>

#include "geometry/field/marching_cubes.h"
#include "geometry/mesh/self_intersection.h"
#include "geometry/tool/sweep.h"
#include "sim/run/sweep/sweep_cutter.h"
#include "tests/geometry/ball_mesh.h"

namespace kerf {
namespace {

RevolvedShape bur() {
  RevolvedProfile p(0);
  p.arcTo({0, 0.7}, {0, 1.4});
  return RevolvedShape(p);
}

BrickField ballField(double radius, double h) {
  BrickField field(h, static_cast<float>(4 * h));
  const int n = static_cast<int>(radius / h / kBrickSide) + 2;
  for (int x = -n; x < n; ++x)
    for (int y = -n; y < n; ++y)
      for (int z = -n; z < n; ++z) {
        const Vec3i c{x, y, z};
        if (std::abs((field.position(c * kBrickSide) + Vec3d::Constant(3.5 * h)).norm() - radius) > 12 * h) continue;
        BrickValues& v = field.brick(field.touch(c));
        for (int i = 0; i < kBrickNodes; ++i)
          v[static_cast<std::size_t>(i)] = static_cast<float>(std::clamp(
              field.position(c * kBrickSide + Vec3i{i >> 6, i >> 3 & 7, i & 7}).norm() - radius, -4 * h, 4 * h));
      }
  return field;
}

void marchingCubesOfABall(benchmark::State& state) {
  const BrickField field = ballField(3, 3.0 / static_cast<double>(state.range(0)));
  std::size_t triangles = 0;
  for (auto _ : state) triangles = marchingCubes(field).triangles.size();
  state.counters["triangles/s"] =
      benchmark::Counter(static_cast<double>(triangles), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(marchingCubesOfABall)->Arg(20)->Arg(40)->Arg(80)->Unit(benchmark::kMillisecond);

void sweptDistance(benchmark::State& state) {
  const RevolvedShape shape = bur();
  const Rigid3 from, to{Eigen::Quaterniond(Eigen::AngleAxisd(0.02, Vec3d::UnitX())),
                        Vec3d(1e-3 * static_cast<double>(state.range(0)), 0, 0)};
  const SweptTool sweep(shape, from, to);
  double x = 0;
  for (auto _ : state) {
    x = x > 1.5 ? 0 : x + 0.01;
    benchmark::DoNotOptimize(sweep.distance({x, 0.4, 0.3}, 1e9, 4e-4));
  }
}
BENCHMARK(sweptDistance)->Arg(1)->Arg(20)->Arg(1000);

void selfIntersectionsOfABall(benchmark::State& state) {
  const Mesh mesh = ballMesh(Vec3d::Zero(), 10, static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(selfIntersections(mesh.vertices, mesh.triangles).size());
  state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
}
BENCHMARK(selfIntersectionsOfABall)->Arg(64)->Arg(160)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kerf

BENCHMARK_MAIN();
