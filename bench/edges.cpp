// Smoothness of the force where a tool slides off an edge, off a thin wall, or over a groove. Every tool, its drive
// off.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <vector>

#include "bench/bench.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "bench/scenes/sink.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

using namespace scenes;

constexpr double kVoxel = 0.1;

// ---- Release of a spring

// The largest change of the felt force per tick, over the force, after the support of the tool vanishes within a tick:
// the coupling's own release. The equations are linear, so the ratio holds for any force.
double releaseOverForce(const CouplingSettings& coupling) {
  ToolBody body;
  DeviceMotion device;
  constexpr double kForce = 1;
  body.pose.translation = Vec3d(0, 0, kForce / coupling.stiffness);
  double last = kForce, most = 0;
  for (int n = 0; n < 200; ++n) {
    advance(body, device, ContactSums{}, Wrench{}, coupling, 1, 1e9, kTick);
    const double force = couplingWrench(body, device, coupling).force.norm();
    most = std::max(most, std::abs(force - last));
    last = force;
  }
  return most / kForce;
}

// ---- Objects, tops at z = 0, edges along y

using Object = std::shared_ptr<const BakedObject>;

struct Place {
  const char* name;
  Object object;
  double edge = 0;  // x, mm: start of the exit
};

Expected<std::vector<Place>> places(const Rigid3& frame) {
  const auto baked = [&](double x0, double x1, const auto& distance) {
    Box3 bounds;
    for (const double x : {x0 - 0.3, x1 + 0.3})
      for (const double y : {-3.3, 3.3})
        for (const double z : {-3.3, 0.3}) bounds.add(frame * Vec3d(x, y, z));
    const Rigid3 inverse = frame.inverse();
    return bakedFrom([&, inverse](const Vec3d& p) { return distance(inverse * p); }, bounds, kVoxel, Material::kEnamel);
  };
  const Vec3d middle(0, 0, -1.5);
  KERF_TRY(block,
           baked(-4, 1, [&](const Vec3d& p) { return boxDistance(p, Vec3d(-1.5, 0, -1.5), Vec3d(2.5, 3, 1.5)); }));
  KERF_TRY(wall, baked(-0.2, 0.2, [&](const Vec3d& p) { return boxDistance(p, middle, Vec3d(0.2, 3, 1.5)); }));
  KERF_TRY(groove, baked(-4, 5, [&](const Vec3d& p) {
             const double solid = boxDistance(p, Vec3d(0.5, 0, -1.5), Vec3d(4.5, 3, 1.5));
             return std::max(solid, -boxDistance(p, Vec3d(1.5, 0, 0), Vec3d(0.5, 9, 0.5)));
           }));
  return std::vector<Place>{{"edge", block, 1}, {"wall of 0.4 mm", wall, 0.2}, {"groove 1 mm wide", groove, 1}};
}

// ---- One slide

struct Slide {
  double jump = 0;    // N a tick, the largest change of the felt force
  double excess = 0;  // N a tick, the largest excess over the release of a spring
};

Slide slide(const Model& model, const Place& place, const Rigid3& frame, double lean, double force, double speed,
            double release) {
  constexpr double kPress = 0.25;  // s of pressing before the slide
  const ToolModel& tool = model.tools[0];
  const Vec3d first = tool.plunge_direction.normalized();
  const Eigen::Quaterniond upright = Eigen::Quaterniond::FromTwoVectors(first, -Vec3d::UnitZ());
  const Eigen::Quaterniond turn = Eigen::AngleAxisd(lean, Vec3d::UnitY()) * upright;
  const Vec3d lowest = turn * foremost(tool, turn.conjugate() * -Vec3d::UnitZ());
  const Vec3d start = Vec3d(place.edge - 0.2, 0.013, 0.05) - lowest;
  const double lead = force / model.settings.coupling.stiffness;
  const double way = std::min(2.5, 0.7 + 0.5 * (tool.cut.bounds().max - tool.cut.bounds().min).minCoeff());

  State state;
  state.objects.emplace_back(place.object, 64);
  const auto at = [&](double t) {
    const double down = (lead + 0.05) * std::min(1.0, t / kPress);
    const double x = speed * std::max(0.0, t - 1.5 * kPress);
    return frame * Rigid3{turn, start + Vec3d(x, 0, -down)};
  };
  state.place(at(0));

  Slide out;
  StepOutput tick;
  Vec3d last = Vec3d::Zero();
  std::array<double, 32> recent{};  // forces of the last ticks
  const int ticks = static_cast<int>((1.5 * kPress + way / speed) / kTick);
  for (int n = 0; n < ticks; ++n) {
    step(model, state, sampleAt(at((n + 1) * kTick), 0), tick);
    const Vec3d felt = tick.force.force;
    recent[static_cast<std::size_t>(n) % recent.size()] = felt.norm();
    if (n * kTick > 1.4 * kPress) {
      const double jump = (felt - last).norm();
      out.jump = std::max(out.jump, jump);
      out.excess = std::max(out.excess, jump - release * *std::max_element(recent.begin(), recent.end()));
    }
    last = felt;
  }
  return out;
}

// ---- The rack

struct Worst {
  double value = 0;
  std::string tool;
  void add(double v, const std::string& id) {
    if (v <= value) return;
    value = v;
    tool = id;
  }
};

constexpr std::array<double, 2> kForces{0.5, 1}, kSpeeds{5, 20}, kLeans{0, 0.3};

// All slides of one tool over one place.
std::vector<Slide> slides(const Model& model, const Place& place, const Rigid3& frame, double release) {
  std::vector<Slide> out;
  for (const double force : kForces)
    for (const double speed : kSpeeds)
      for (const double lean : kLeans) out.push_back(slide(model, place, frame, lean, force, speed, release));
  return out;
}

}  // namespace

Expected<Result> benchEdges(const Bench& bench) {
  Result r(SceneId::kEdges, "every tool, its drive off, slid at 5 and 20 mm/s under 0.5 and 1 N: largest change a ms");
  const Rigid3 frame = askew();
  KERF_TRY(all, places(frame));
  KERF_TRY(tools, wholeRack());
  const double release = releaseOverForce(CouplingSettings{});
  r.add("a spring of the coupling that is let go: change a ms, of its force", 100 * release, "%");

  std::vector<std::vector<std::vector<Slide>>> found(tools.size());
  Expected<void> fault;
  for (std::size_t begin = 0; begin < tools.size(); begin += 8) {
    if (!report(bench.progress, static_cast<double>(begin) / static_cast<double>(tools.size()), "tools"))
      return cancelled();
    std::vector<Model> models;
    for (std::size_t n = begin; n < std::min(tools.size(), begin + 8); ++n) {
      KERF_TRY(model, makeModel(std::span(&tools[n], 1)));
      model.settings.ramp_s = 0;
      model.tools[0].drive.speed = 0;
      models.push_back(std::move(model));
    }
    tbb::parallel_for(std::size_t{0}, models.size(), [&](std::size_t n) {
      for (const Place& place : all) found[begin + n].push_back(slides(models[n], place, frame, release));
    });
  }

  int runs = 0;
  for (std::size_t p = 0; p < all.size(); ++p) {
    Worst jump, excess;
    int above = 0;
    for (std::size_t n = 0; n < tools.size(); ++n)
      for (const Slide& s : found[n][p]) {
        ++runs;
        above += s.excess > 0.05;
        jump.add(s.jump, tools[n].id);
        excess.add(s.excess, tools[n].id);
      }
    r.add(fmt::format("{}: largest change ({})", all[p].name, jump.tool), jump.value, "N");
    r.add(fmt::format("{}: beyond a spring that is let go ({})", all[p].name, excess.tool), excess.value, "N");
    r.add(fmt::format("{}: slides with more than 0.05 N beyond that", all[p].name), above);
  }
  r.add("slides", runs);
  return r;
}

}  // namespace kerf::cli
