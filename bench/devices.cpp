// Whether devices of any make, in any hand, gain energy or tremble with the coupling from their profile:
// sim/hand/device_profile.h.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "bench/bench.h"
#include "bench/device_stack.h"
#include "bench/scenes/held_device.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

using namespace scenes;

// ---- One device, pressed and held

constexpr double kPressed = 0.4, kEnd = 1.6;  // s: end of the press, end of the hold
constexpr int kTicks = 1600;
constexpr int kEnergyTicks = 580, kTremblingTicks = 256;

struct Grasp {
  Model model;  // with the device's coupling
  std::shared_ptr<const BakedObject> object;
  std::function<Rigid3(const Vec3d&)> pose;   // of the device, from its coordinates
  std::function<Vec3d(const Wrench&)> force;  // along the coordinates
  std::function<Vec3d(double)> wanted;        // target of the arm at a time
  HeldDeviceNumbers numbers;
};

struct Held {
  double given = 0;      // energy over the last 0.58 s, N mm = mJ
  double trembling = 0;  // peak to peak over the last 0.256 s, detrended, mm or rad
  double ripple = 0;     // the same, above 15 Hz
  double force = 0;      // mean over the same time, N or N mm
};

// Largest range of a coordinate.
double rangeOf(std::span<const Vec3d> values) {
  Vec3d low = Vec3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Vec3d& v : values) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return (high - low).maxCoeff();
}

// Subtracts the least-squares line.
std::vector<Vec3d> withoutTrend(std::span<const Vec3d> values) {
  const auto n = static_cast<double>(values.size());
  Vec3d mean = Vec3d::Zero(), slope = Vec3d::Zero();
  double spread = 0;
  for (const Vec3d& v : values) mean += v / n;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double t = static_cast<double>(i) - 0.5 * (n - 1);
    slope += t * values[i];
    spread += t * t;
  }
  slope /= spread;
  std::vector<Vec3d> out;
  for (std::size_t i = 0; i < values.size(); ++i)
    out.emplace_back(values[i] - mean - (static_cast<double>(i) - 0.5 * (n - 1)) * slope);
  return out;
}

// Subtracts the mean over 1/15 s around each value, for the last `count` values that have half of 1/15 s after them.
std::vector<Vec3d> above15Hz(std::span<const Vec3d> values, int count) {
  constexpr int kHalf = 33;
  const int end = static_cast<int>(values.size()) - kHalf;
  std::vector<Vec3d> out;
  for (int i = end - count; i < end; ++i) {
    Vec3d mean = Vec3d::Zero();
    for (int k = i - kHalf; k <= i + kHalf; ++k) mean += values[static_cast<std::size_t>(k)] / (2 * kHalf + 1);
    out.emplace_back(values[static_cast<std::size_t>(i)] - mean);
  }
  return out;
}

Held holdDevice(const Grasp& grasp) {
  State state;
  state.objects.emplace_back(grasp.object, 512);
  HeldDevice device(grasp.numbers, grasp.wanted(0));
  state.place(grasp.pose(device.read()));

  Held out;
  StepOutput tick;
  std::vector<Vec3d> way;
  double before = 0;
  for (int n = 0; n < kTicks; ++n) {
    step(grasp.model, state, sampleAt(grasp.pose(device.read())), tick);
    if (state.objects[0].freeBricks() < 128) state.objects[0].reserve(256);
    if (n == kTicks - kEnergyTicks) before = device.given();
    const Wrench felt{tick.force.force, tick.force.torque};
    device.tick(grasp.force(felt), grasp.wanted((n + 1) * kTick));
    way.push_back(device.position());
    if (n >= kTicks - kTremblingTicks) out.force += grasp.force(felt).norm() / kTremblingTicks;
  }
  out.given = device.given() - before;
  out.trembling = rangeOf(withoutTrend(std::span(way).last(kTremblingTicks)));
  out.ripple = rangeOf(above15Hz(way, 2 * kTremblingTicks));
  return out;
}

// ---- Many

using GraspOf = std::function<Grasp(std::size_t draw)>;

Expected<std::vector<Held>> holdMany(std::size_t draws, const GraspOf& grasp, double share, const char* what,
                                     const Bench& bench) {
  std::vector<Held> held(draws);
  constexpr std::size_t kBatch = 16;
  for (std::size_t begin = 0; begin < draws; begin += kBatch) {
    if (!report(bench.progress, share, what)) return cancelled();
    tbb::parallel_for(begin, std::min(draws, begin + kBatch),
                      [&](std::size_t draw) { held[draw] = holdDevice(grasp(draw)); });
  }
  return held;
}

struct Unit {
  const char* name;  // of a thousandth of the coordinate's unit
  double runaway;    // mm or rad
};
constexpr Unit kMicrometres{"um", 1}, kMilliradians{"mrad", 0.02};

void addHeld(Result& r, const std::string& scene, const std::vector<Held>& held, Unit unit, bool is_cutting = false,
             const char* lost = "runaways") {
  constexpr double kNotable = 1e-4;  // mJ
  int runaways = 0, given = 0, rippling = 0;
  double most_given = 0;
  std::vector<double> trembling, ripple;
  for (const Held& h : held) {
    if (!(h.trembling < unit.runaway) || !std::isfinite(h.given)) {
      ++runaways;
      continue;
    }
    given += h.given > kNotable;
    rippling += h.ripple > 0.02;
    most_given = std::max(most_given, h.given);
    trembling.push_back(1000 * h.trembling);
    ripple.push_back(1000 * h.ripple);
  }
  const auto share = [&](int count) { return 100.0 * count / static_cast<double>(held.size()); };
  r.add(scene + ": devices", static_cast<double>(held.size()));
  r.add(fmt::format("{}: {}", scene, lost), runaways);
  if (is_cutting) {
    r.add(scene + ": rippling by more than 20 um above 15 Hz", share(rippling), "%");
    r.add(scene + ": ripple, p90", percentile(ripple, 0.9), unit.name);
    r.add(scene + ": ripple, most", percentile(ripple, 1), unit.name);
  } else {
    r.add(scene + ": trembling, p99", percentile(trembling, 0.99), unit.name);
    r.add(scene + ": trembling, most", percentile(trembling, 1), unit.name);
  }
  r.add(scene + ": given more than 1e-4 mJ", share(given), "%");
  r.add(scene + ": most energy given", most_given, "mJ");
}

// ---- Scenes

double pressedBy(double t) { return std::min(1.0, t / kPressed); }

Expected<Model> modelOf(const char* tool_id, bool is_running) {
  KERF_TRY(tool, toolOfRack(tool_id));
  KERF_TRY(model, makeModel(std::span(&tool, 1)));
  model.settings.ramp_s = 0;
  if (!is_running) model.tools[0].drive.speed = 0;
  return model;
}

// A ball with its drive off on enamel. The arm's target lies 2 mm beyond the surface.
struct Wall {
  Model model;
  std::shared_ptr<const BakedObject> block;

  static Expected<Wall> make() {
    KERF_TRY(model, modelOf("round-018", false));
    KERF_TRY(block, practiceBlock({4, 4, 2}, 0.1, {}, Material::kEnamel));
    return Wall{std::move(model), std::move(block)};
  }
  Grasp grasp(const HeldDeviceNumbers& numbers, const CouplingSettings& coupling) const {
    Grasp g{model, block, {}, {}, {}, numbers};
    g.model.settings.coupling = coupling;
    g.pose = [](const Vec3d& at) { return Rigid3{Eigen::Quaterniond::Identity(), at}; };
    g.force = [](const Wrench& w) { return w.force; };
    g.wanted = [](double t) { return Vec3d(0, 0, 0.5 - 2.5 * pressedBy(t)); };
    return g;
  }
};

Expected<void> pressOnWall(Result& r, const Bench& bench) {
  KERF_TRY(wall, Wall::make());
  const auto byProfile = [&](double least_friction, std::uint64_t seed) {
    return [&wall, least_friction, seed](std::size_t draw) {
      const HeldDeviceNumbers numbers = randomDevice(seed + draw, least_friction);
      return wall.grasp(numbers, couplingFor(numbers.profile()).settings);
    };
  };
  KERF_TRY(held, holdMany(2000, byProfile(0.01, 100'000), 0, "wall", bench));
  addHeld(r, "wall", held, kMicrometres);
  KERF_TRY(slippery, holdMany(600, byProfile(0, 200'000), 0.3, "wall, no friction", bench));
  addHeld(r, "wall, friction down to 0", slippery, kMicrometres);

  const auto alike = [&](std::size_t draw) { return wall.grasp(randomDevice(100'000 + draw), CouplingSettings{}); };
  KERF_TRY(before, holdMany(200, alike, 0.4, "wall, one coupling for all", bench));
  addHeld(r, "wall, one coupling for all", before, kMicrometres, false, "lost, for comparison");

  // Loss of force.
  const auto perfect = [&](std::size_t draw) {
    HeldDeviceNumbers numbers = randomDevice(100'000 + draw);
    numbers.delay_s = numbers.step = 0;
    return wall.grasp(numbers, CouplingSettings{});
  };
  KERF_TRY(ideal, holdMany(400, perfect, 0.45, "wall, ideal devices", bench));
  std::vector<double> unbound, bound;
  for (std::size_t n = 0; n < ideal.size(); ++n) {
    const DeviceCoupling coupling = couplingFor(randomDevice(100'000 + n).profile());
    (coupling.bound == CouplingBound::kNone ? unbound : bound).push_back(held[n].force / ideal[n].force);
  }
  r.add("wall: force at rest over an ideal device's, as stiff as wanted, p1", percentile(unbound, 0.01));
  r.add("wall: force at rest over an ideal device's, as stiff as wanted, p50", percentile(unbound, 0.5));
  r.add("wall: force at rest over an ideal device's, softer, p50", percentile(bound, 0.5));
  r.add("wall: share that gets a softer coupling", 100.0 * static_cast<double>(bound.size()) / 400, "%");
  return {};
}

// A blade in a kerf of its own width, 1.5 mm deep in cortical bone.
struct BladeInKerf {
  Model model;
  std::shared_ptr<const BakedObject> block;

  static Expected<BladeInKerf> make() {
    KERF_TRY(saw, toolOfRack("saw-reciprocating-25"));
    KERF_TRY(model, modelOf("saw-reciprocating-25", false));
    const double half_width = 0.5 * saw.kerfWidth() + 0.01;
    const Vec3d half(5, 2, 2);
    Box3 box;
    box.add(Vec3d(-5.2, -2.2, -4.2));
    box.add(Vec3d(5.2, 2.2, 0.2));
    const auto distance = [&](const Vec3d& p) {
      return std::max(boxDistance(p, Vec3d(0, 0, -2), half), std::min(half_width - std::abs(p[1]), p[2] + 1.55));
    };
    KERF_TRY(block, bakedFrom(distance, box, 0.1, Material::kCortical));
    return BladeInKerf{std::move(model), std::move(block)};
  }
};

Expected<void> pushBlade(Result& r, const Bench& bench) {
  KERF_TRY(blade, BladeInKerf::make());
  const Vec3d start(-12.5, 0, -1.5);
  const auto sideways = [&](std::size_t draw) {
    const HeldDeviceNumbers numbers = randomDevice(300'000 + draw);
    Grasp g{blade.model, blade.block, {}, {}, {}, numbers};
    g.model.settings.coupling = couplingFor(numbers.profile()).settings;
    g.pose = [](const Vec3d& at) { return Rigid3{teethDown(), at}; };
    g.force = [](const Wrench& w) { return w.force; };
    g.wanted = [start](double t) { return Vec3d(start + Vec3d(0, 1.5 * pressedBy(t), 0)); };
    return g;
  };
  KERF_TRY(pushed, holdMany(64, sideways, 0.5, "blade pushed", bench));
  addHeld(r, "blade pushed sideways in its kerf", pushed, kMicrometres);

  const auto turning = [&](std::size_t draw) {
    const HeldDeviceNumbers numbers = randomTurningDevice(400'000 + draw);
    Grasp g{blade.model, blade.block, {}, {}, {}, numbers};
    g.model.settings.coupling = couplingFor(numbers.turningProfile()).settings;
    g.pose = [start](const Vec3d& at) { return Rigid3{Eigen::AngleAxisd(at[0], Vec3d::UnitZ()) * teethDown(), start}; };
    g.force = [](const Wrench& w) { return Vec3d(w.torque[2], 0, 0); };
    g.wanted = [](double t) { return Vec3d(0.05 * pressedBy(t), 0, 0); };
    return g;
  };
  KERF_TRY(turned, holdMany(48, turning, 0.6, "blade turned", bench));
  addHeld(r, "blade turned in its kerf", turned, kMilliradians);
  return {};
}

Expected<void> sawBone(Result& r, const Bench& bench) {
  KERF_TRY(model, modelOf("saw-reciprocating-25", true));
  KERF_TRY(block, practiceBlock({10, 3, 5}, 0.1, {}, Material::kCortical));
  const auto sawing = [&](std::size_t draw) {
    const HeldDeviceNumbers numbers = randomDevice(500'000 + draw);
    Grasp g{model, block, {}, {}, {}, numbers};
    g.model.settings.coupling = couplingFor(numbers.profile()).settings;
    g.pose = [](const Vec3d& at) { return Rigid3{teethDown(), at}; };
    g.force = [](const Wrench& w) { return w.force; };
    g.wanted = [](double t) { return Vec3d(-12.5, 0, 0.05 - 2 * pressedBy(t) - t); };
    return g;
  };
  KERF_TRY(held, holdMany(24, sawing, 0.7, "saw cutting", bench));
  addHeld(r, "saw cutting", held, kMicrometres, true);
  return {};
}

Expected<void> cutEnamel(Result& r, const Bench& bench) {
  KERF_TRY(model, modelOf("round-018", true));
  KERF_TRY(block, practiceBlock({6, 4, 3}, 0.1, {}, Material::kEnamel));
  const auto grasp = [&](const HeldDeviceNumbers& numbers) {
    Grasp g{model, block, {}, {}, {}, numbers};
    g.model.settings.coupling = couplingFor(numbers.profile()).settings;
    g.pose = [](const Vec3d& at) { return Rigid3{Eigen::Quaterniond::Identity(), at}; };
    g.force = [](const Wrench& w) { return w.force; };
    g.wanted = [](double t) { return Vec3d(-1 + 0.5 * t, 0, 0.1 - 1.1 * pressedBy(t)); };
    return g;
  };
  constexpr std::size_t kDraws = 120;
  const auto real = [&](std::size_t draw) { return grasp(randomDevice(600'000 + draw)); };
  const auto ideal = [&](std::size_t draw) { return grasp(idealised(randomDevice(600'000 + draw))); };
  KERF_TRY(held, holdMany(kDraws, real, 0.8, "bur cutting", bench));
  addHeld(r, "bur cutting enamel", held, kMicrometres, true);
  KERF_TRY(best, holdMany(kDraws, ideal, 0.9, "bur cutting, ideal devices", bench));
  addHeld(r, "bur cutting enamel, ideal devices", best, kMicrometres, true);
  return {};
}

}  // namespace

Expected<Result> benchDevices(const Bench& bench) {
  Result r(SceneId::kDevices, "random devices in random hands, pressed and held, each with its profile's coupling");
  KERF_CHECK(pressOnWall(r, bench));
  KERF_CHECK(pushBlade(r, bench));
  KERF_CHECK(sawBone(r, bench));
  KERF_CHECK(cutEnamel(r, bench));
  KERF_CHECK(pressThroughTheStack(r, bench));
  return r;
}

}  // namespace kerf::cli
