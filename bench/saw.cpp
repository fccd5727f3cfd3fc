// Width, plane and side force of a blade's kerf over attitudes. Numbers, not times.
#include <fmt/format.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/bench.h"
#include "bench/scenes/feed.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "bench/spread.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

using namespace scenes;

// Zero crossing of phi on a line, mm from its start; NaN: none.
double crossing(const BrickField& phi, const Vec3d& from, const Vec3d& along, double length) {
  constexpr double kStep = 0.005;
  double before = phi.sample(from);
  for (double at = kStep; at <= length; at += kStep) {
    const double here = phi.sample(from + at * along);
    if (before > 0 && here <= 0) return at - kStep * here / (here - before);
    before = here;
  }
  return std::nan("");
}

struct Kerf {
  double width_error = 0, plane_degrees = 0;  // mean width; angle between wall and blade
};
// Walls of a kerf along y = 0 of `frame`, seen from its middle.
Kerf measureKerf(const CutObject& object, const Rigid3& frame, double expected) {
  const BrickField phi = currentField(object);
  double width = 0, sx = 0, sz = 0, sxx = 0, szz = 0, sxz = 0, sw = 0, swx = 0, swz = 0;
  int n = 0;
  for (double x = -4; x <= 4; x += 0.5)
    for (double z = -0.85; z <= -0.15; z += 0.1) {  // above the toothed edge of a blade 1.5 mm deep
      const Vec3d middle = frame * Vec3d(x, 0, z), side = frame.rotation * Vec3d::UnitY();
      const double right = crossing(phi, middle, side, 1), left = crossing(phi, middle, -side, 1);
      // A missing wall counts as a kerf of wrong width.
      if (std::isnan(right) || std::isnan(left)) return {1e3, 90};
      width += right + left;
      ++n;
      sx += x;
      sz += z;
      sxx += x * x;
      szz += z * z;
      sxz += x * z;
      sw += right;
      swx += right * x;
      swz += right * z;
    }

  // Slopes of the right wall over x and z by least squares.
  Eigen::Matrix3d a;
  a << sxx, sxz, sx, sxz, szz, sz, sx, sz, n;
  const Vec3d slope = a.ldlt().solve(Vec3d(swx, swz, sw));
  return {std::abs(width / n - expected), std::atan(std::hypot(slope[0], slope[1])) * 180 / std::numbers::pi};
}

double removedBone(const State& state) {
  return state.objects[0].removed_mm3[static_cast<std::size_t>(Material::kCortical)];
}

// The blade moves sideways in its kerf. The flanks push back and cut nothing.
void pushSideways(Result& r, const Model& model, State& state, const Rigid3& frame, double kerf_width, double h) {
  const double volume = removedBone(state);
  const Kerf before = measureKerf(state.objects[0], frame, kerf_width);
  StepOutput tick;
  double side = 0;
  for (int i = 0; i < 200; ++i) {
    step(model, state, sampleAt(frame * Rigid3{teethDown(), Vec3d(-12.5, 0.0002 * i, -1.5)}), tick);
    if (i == 199) side = -(frame.rotation.conjugate() * tick.contact.force)[1];
  }
  const Kerf after = measureKerf(state.objects[0], frame, kerf_width);

  r.add(fmt::format("side force at 0.04 mm, {} mm voxels", h), side, "N");
  r.add(fmt::format("  pushes the wrong way ({} mm)", h), side > 0 ? 0.0 : 1.0);
  r.add(fmt::format("  kerf widened by the flanks ({} mm)", h), 1000 * std::abs(after.width_error - before.width_error),
        "um");
  r.add(fmt::format("  removed by the edge's side ({} mm)", h), removedBone(state) - volume, "mm3");
}

Expected<void> sawAtVoxel(Result& r, double h, const Model& model, const Tool& saw, const Bench& bench) {
  double width = 0, plane = 0;
  Spread force;
  for (int n = 0; n < 12; ++n) {
    if (!report(bench.progress, (h < 0.1 ? 0.3 : 0) + 0.02 * n, "kerf")) return cancelled();
    const Rigid3 frame = turned(0.41 * n, {std::cos(2.0 * n), std::sin(3.0 * n), 0.7}, 0.017 * n * Vec3d(1, -2, 0.5));
    KERF_TRY(block, practiceBlock({10, 3, 3}, h, frame, Material::kCortical));
    State state;
    state.objects.emplace_back(block, 8192);
    const Feed f = feed(model, state, frame, {teethDown(), {-12.5, 0, 0.05}}, {0, 0, -1.55}, 2, 0.7);
    const Kerf kerf = measureKerf(state.objects[0], frame, saw.kerfWidth());
    width = std::max(width, kerf.width_error);
    plane = std::max(plane, kerf.plane_degrees);
    force.add(f.force);
    if (n == 0) pushSideways(r, model, state, frame, saw.kerfWidth(), h);
  }

  r.add(fmt::format("kerf width, worst of 12 attitudes, {} mm voxels", h), 1000 * width, "um");
  r.add(fmt::format("plane of the wall, worst of 12 ({} mm)", h), plane, "degrees");
  r.add(fmt::format("feed force over 12 attitudes ({} mm)", h), force.percent(), "%");
  r.add(fmt::format("feed force, most ({} mm)", h), force.most, "N");
  return {};
}

}  // namespace

Expected<Result> benchSaw(const Bench& bench) {
  Result r(SceneId::kSaw, "reciprocating blade 0.4 mm with 0.02 mm set, 1.5 mm deep in a block of cortical bone");
  KERF_TRY(saw, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(model, makeModel(std::span(&saw, 1)));
  model.settings.rendering = Rendering::kRigid;
  for (const double h : {0.1, 0.05}) KERF_CHECK(sawAtVoxel(r, h, model, saw, bench));
  return r;
}

}  // namespace kerf::cli
