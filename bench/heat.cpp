// Temperatures against measurements on teeth and bone. Numbers, not times.
//
// Power, removal and area come from the law's table (a diamond at 1 N spends 5 W), or from the step with a tool of that
// power.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "bench/bench.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "bench/spread.h"
#include "sim/hand/virtual_hand.h"
#include "sim/monitor/monitor.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

using namespace scenes;

constexpr double kDiamond = 0.03, kFastCarbide = 0.018, kCarbide = 0.10, kSteel = 0.15;  // shares
constexpr double kPulpBurPower = 5000;                                                   // mW, of a diamond at 1 N
constexpr HeatSettings kBodyWarm{.coolant_rise = 0};  // measurements give the rise by the cut alone

// Adds a number and its distance outside the measured range, or the range promised by the law.
void addWithin(Result& r, std::string name, double kelvin, double low, double high) {
  r.add(std::move(name), kelvin, "K");
  r.add(fmt::format("  out of {} to {} by", low, high), std::max({0.0, low - kelvin, kelvin - high}), "K");
}

// ---- The model alone: steady work.

struct Work {
  HeatSource source{};
  HeatSettings settings{};
  double power = 0, removal = 0, area = 0;  // mW, mm^3/s, mm^2
  double irrigation = 0, seconds = 0;
  Material material = Material::kDentin;
  // Place of the work at a time, mm. Default: back and forth over 1 mm at 1 mm/s.
  std::function<Vec3d(double)> place = [](double t) { return Vec3d(std::abs(std::fmod(t, 2.0) - 1) - 0.5, 0, 0); };
};

struct Warmth {
  double surface = 0;  // K at the end
  double probe = 0;    // K at the probe, maximum during the work and `after` seconds
  double at_end = 0;   // K at the probe at the end of the work
};

Warmth warm(const Work& work, const Vec3d& probe, double after = 0) {
  Heat heat(work.source, work.settings);
  HeatInput in;
  in.is_touching = true;
  in.power = work.power;
  in.area = work.area;
  in.removed = work.removal * kTick;
  in.irrigation = work.irrigation;
  in.material = work.material;

  Warmth out;
  const int ticks = static_cast<int>(work.seconds / kTick), all = ticks + static_cast<int>(after / kTick);
  for (int n = 0; n < all; ++n) {
    const double t = n * kTick;
    in.place = work.place(std::min(t, work.seconds));
    in.velocity = (work.place(t + kTick) - work.place(t)) / kTick;
    in.is_touching = n < ticks;
    heat.step(in);
    if (n % 50 == 49) out.probe = std::max(out.probe, heat.riseAt(probe));
    if (n != ticks - 1) continue;
    out.surface = heat.surfaceRise();
    out.at_end = heat.riseAt(probe);
  }
  return out;
}

HeatSource sourceOf(double share, double spray_film = 10, double least_area = 0.3) {
  return {.share = share, .spray_film = spray_film, .least_area = least_area};
}

// A bur under a force removes half a cubic millimetre of dentin per second and newton.
Work burInDentin(double share, double force, double seconds) {
  return {.source = sourceOf(share),
          .settings = kBodyWarm,
          .power = kPulpBurPower * force,
          .removal = 0.5 * force,
          .area = 1,
          .seconds = seconds};
}

void addPulp(Result& r) {
  const auto below = [](double depth) { return Vec3d(0, 0, -depth); };
  const Work dry = burInDentin(kDiamond, 1, 60);
  for (const double depth : {2.5, 3.0})
    addWithin(r, fmt::format("pulp, {} mm off, diamond 1 N dry, 60 s", depth), warm(dry, below(depth)).at_end, 3.5, 11);

  Work wet = burInDentin(kDiamond, 3, 10);
  wet.irrigation = 1;
  addWithin(r, "pulp, 2 mm off, diamond 3 N wet, 10 s", warm(wet, below(2)).at_end, 1.2, 6);
  wet.seconds = 30;
  addWithin(r, "pulp, 1.5 mm off, diamond 3 N wet, 30 s", warm(wet, below(1.5)).at_end, 1.2, 6);
  wet.settings = {};
  r.add("  the same with water 10 K below the body", warm(wet, below(1.5)).at_end, "K");

  // The distance was 3 to 4 mm, the time 10 to 20 s. The goal applies to the middle. Carbide removes 5/3 of a diamond's
  // volume.
  const auto carbide = [](double seconds) {
    Work work = burInDentin(kFastCarbide, 0.5, seconds);
    work.removal *= 5.0 / 3;
    return work;
  };
  addWithin(r, "pulp, 3.5 mm off, carbide 0.5 N dry, 15 s", warm(carbide(15), below(3.5)).at_end, 0.4, 3.3);
  r.add("  4 mm, 10 s", warm(carbide(10), below(4)).at_end, "K");
  r.add("  3 mm, 20 s", warm(carbide(20), below(3)).at_end, "K");
}

// A hole drilled down from the origin: feed mm/s, torque by (u / 8) D^2 (f + 0.02), u = 250 N/mm^2.
Work drill(double diameter, double turns, double feed, double depth) {
  const double circle = std::numbers::pi * diameter * diameter / 4, per_turn = feed / turns;
  const double torque = 250.0 / 8 * diameter * diameter * (per_turn + 0.02);
  return {.source = sourceOf(kSteel, 2, circle),
          .settings = kBodyWarm,
          .power = torque * 2 * std::numbers::pi * turns,
          .removal = circle * feed,
          .area = circle,
          .seconds = depth / feed,
          .material = Material::kCortical,
          .place = [feed](double t) { return Vec3d(0, 0, -feed * t); }};
}

void addDrills(Result& r) {
  for (const double diameter : {2.0, 2.8}) {
    const double turns = 1750 / diameter / 60, feed = 0.05 * turns;
    Work work = drill(diameter, turns, feed, 5 * feed);
    addWithin(r, fmt::format("drill {} mm, 5 s dry: surface", diameter), warm(work, Vec3d::Zero()).surface, 10, 16);
    work.irrigation = 1;
    addWithin(r, fmt::format("drill {} mm, 5 s wet: surface", diameter), warm(work, Vec3d::Zero()).surface, 3, 5);
  }
}

// Bone half a millimetre beside a hole at half depth: maximum during the work and 20 s after.
double besideHole(const Work& work, double depth) {
  const double radius = std::sqrt(work.area / std::numbers::pi);
  return warm(work, {radius + Heat::kBoneMargin, 0, -depth / 2}, 20).probe;
}

// Holes of one depth by a fast bur of 1.6 mm. Its force sets the removal: 1 J/mm^3, 4.1 m/s, friction 0.3.
Work fastDrill(double force, double depth) {
  const double power = 0.3 * force * 4100, removal = power / 1000, circle = std::numbers::pi * 0.64;
  const double feed = removal / circle;
  return {.source = sourceOf(kCarbide),
          .settings = kBodyWarm,
          .power = power,
          .removal = removal,
          .area = circle,
          .seconds = depth / feed,
          .material = Material::kCortical,
          .place = [feed](double t) { return Vec3d(0, 0, -feed * t); }};
}

// A blade at constant feed: energy per volume 0.25 (1 + 10 um / h), h the advance per stroke.
Work saw(double cycles_per_minute) {
  const double feed = 0.5, area = 4, advance_um = 1000 * feed / (cycles_per_minute / 60 * 2);
  return {.source = sourceOf(kSteel, 5),
          .settings = kBodyWarm,
          .power = 250 * (1 + 10 / advance_um) * feed * area,
          .removal = feed * area,
          .area = area,
          .seconds = 10,
          .material = Material::kCortical,
          .place = [feed](double t) { return Vec3d(0, 0, -feed * t); }};
}

void addSigns(Result& r) {
  const Work slow = drill(2.5, 1000.0 / 60, 0.5, 10), fast = drill(2.5, 1000.0 / 60, 3, 10);
  Work little = burInDentin(kDiamond, 3, 10), much = little;
  little.irrigation = 0.5;
  much.irrigation = 1;
  const double slow_feed = besideHole(slow, 10), fast_feed = besideHole(fast, 10);
  const double light = besideHole(fastDrill(4, 5), 5), firm = besideHole(fastDrill(9, 5), 5);
  const double slow_saw = warm(saw(10000), Vec3d::Zero()).surface, fast_saw = warm(saw(14000), Vec3d::Zero()).surface;
  const double half_wet = warm(little, Vec3d::Zero()).surface, wet = warm(much, Vec3d::Zero()).surface;

  r.add("beside a hole drilled at 0.5 mm/s", slow_feed, "K");
  r.add("beside a hole drilled at 3 mm/s", fast_feed, "K");
  r.add("beside a hole of a fast bur, 4 N", light, "K");
  r.add("beside a hole of a fast bur, 9 N", firm, "K");
  r.add("saw at 10 000 cycles/min: surface", slow_saw, "K");
  r.add("saw at 14 000 cycles/min: surface", fast_saw, "K");
  r.add("half the spray: surface", half_wet, "K");
  r.add("full spray: surface", wet, "K");
  const int wrong = (fast_feed >= slow_feed) + (firm >= light) + (fast_saw <= slow_saw) + (wet >= half_wet);
  r.add("signs that are wrong, of 4", wrong);
}

// ---- The step and the monitor: a ball of 1.6 mm whose surface moves at 12.5 m/s; friction 0.4 makes 5 W of 1 N.

constexpr double kBallRadius = 0.8, kBallSpeed = 12500, kBallFriction = 0.4;

Model ballModel(double mm3_per_n, Response response) {
  Model model;
  model.tools = {practiceBall(kBallRadius, kBallSpeed)};
  model.tissues = oneTissue(200, kBallFriction, kBallFriction * kBallSpeed / mm3_per_n);
  model.settings.response = response;
  return model;
}

// Result of a cut.
struct Cut {
  double hottest = 0, at_end = 0, mean = 0;  // K at the surface: maximum, last, mean over ticks in contact
  double conducted = 0;                      // mJ
  double power = 0, area = 0, removed = 0;   // means, mW and mm^2; mm^3
  double step_area = 0;                      // mm^2, of StepOutput
  std::vector<double> us;                    // of Monitor::tick()
};

Expected<Cut> cut(const Model& model, const std::shared_ptr<const BakedObject>& object, VirtualHand& hand,
                  const Rigid3& start, const HeatSource& source, const HeatSettings& settings, double irrigation,
                  double seconds, double power = 0) {
  KERF_TRY(monitor, Monitor::make({object}, model.tools[0], source, settings));
  State state;
  state.objects.emplace_back(object, 8192);
  state.place(start);
  state.speed = model.tools[0].drive.speed;
  StepOutput out;
  out.T_world_tool = start;
  DeviceSample sample;

  Cut result;
  int in_contact = 0;
  const int ticks = static_cast<int>(seconds / kTick);
  for (int n = 0; n < ticks && hand.next(out, sample); ++n) {
    sample.irrigation = irrigation;
    reserveForTicks(state.objects[0]);
    step(model, state, sample, out);
    if (power > 0 && out.touching > 0) out.power = power;
    const double before = now();
    monitor.tick(sample, out, state.objects);
    result.us.push_back(1000 * (now() - before));

    const double rise = monitor.heat().surfaceRise();
    result.at_end = rise;
    result.hottest = std::max(result.hottest, rise);
    result.removed += out.removed_mm3;
    if (out.touching == 0) continue;
    ++in_contact;
    result.mean += rise;
    result.power += out.power;
    result.area += monitor.area();
    result.step_area += out.area;
  }
  if (in_contact == 0) return brokenScene("heat", "no contact", "a tool that cuts");
  for (double* sum : {&result.mean, &result.power, &result.area, &result.step_area}) *sum /= in_contact;
  result.conducted = monitor.heat().pulses().energy();
  return result;
}

CutPath pathOf(const std::vector<Vec3d>& tips, double speed, const Eigen::Quaterniond& turn) {
  CutPath path;
  double t = 0;
  for (std::size_t n = 0; n < tips.size(); ++n) {
    if (n > 0) t += (tips[n] - tips[n - 1]).norm() / speed;
    path.poses.push_back({t, {turn, tips[n]}});
    if (n > 0) path.cuts.push_back(1);
  }
  return path;
}

Expected<void> addBurOnEnamel(Result& r) {
  KERF_TRY(block, practiceBlock({6, 6, 3}, 0.05, {}, Material::kEnamel));
  Model model = ballModel(0.1, Response::kPenalty);
  model.settings.coupling.stiffness = ForceHand::kStiffness;
  const CutPath path = pathOf({{0.013, 0.027, 0.01}, {0.013, 0.027, -2}}, 1, Eigen::Quaterniond::Identity());
  const auto press = [&](double irrigation, const HeatSettings& settings) {
    ForceHand hand(path, model.settings.coupling, {.force = 1});
    return cut(model, block, hand, path.poses[0].T_object_tool, sourceOf(kDiamond), settings, irrigation, 1.0);
  };
  KERF_TRY(dry, press(0, {}));
  KERF_TRY(wet, press(1, kBodyWarm));
  KERF_TRY(cold, press(1, {}));
  r.add("diamond pressed into enamel, 1 N, 1 s: power", dry.power / 1000, "W");
  r.add("  area close to tissue", dry.area, "mm2");
  addWithin(r, "  surface, dry", dry.at_end, 50, 115);
  addWithin(r, "  surface, wet", wet.at_end, 3, 17);
  r.add("  surface, wet, water 10 K below the body", cold.at_end, "K");
  r.add("monitor, a tick, p50", percentile(dry.us, 0.5), "us");
  r.add("monitor, a tick, p99", percentile(dry.us, 0.99), "us");
  return {};
}

// A cavity of 3.6 mm by 3.1 mm, planned 0.8 mm deep, by a firm hand at 1 mm/s. Every response gets the same feed and so
// the same force. Under a constant push, hands differ in speed by response.
Expected<void> addResponses(Result& r, const Bench& bench) {
  KERF_TRY(block, practiceBlock({7, 6, 3}, 0.1, askew()));
  std::vector<Vec3d> tips{{-1, -0.75, 0.1}};
  const Vec3d corners[] = {{-1, -0.75, 0}, {1, -0.75, 0}, {1, 0, 0}, {-1, 0, 0}, {-1, 0.75, 0}, {1, 0.75, 0}};
  for (const double depth : {0.4, 0.8})
    for (const Vec3d& corner : corners) tips.push_back(corner - depth * Vec3d::UnitZ());
  for (Vec3d& tip : tips) tip = askew() * tip;
  const CutPath path = pathOf(tips, 1, askew().rotation);

  Spread hottest, mean, of_power, conducted;
  for (const ResponseRow& row : kResponses) {
    if (!report(bench.progress, 0.3 + 0.2 * static_cast<double>(row.response), std::string(row.name).c_str()))
      return cancelled();
    const Model model = ballModel(0.5, row.response);
    DeviceHand hand(path, {.hand_stiffness = 3});
    KERF_TRY(cavity, cut(model, block, hand, path.poses[0].T_object_tool, sourceOf(kDiamond), kBodyWarm, 1, 120));
    r.add(fmt::format("one wet cavity, {}: surface, most", row.name), cavity.hottest, "K");
    r.add("  surface, mean in contact (" + std::string(row.name) + ")", cavity.mean, "K");
    r.add("  power (" + std::string(row.name) + ")", cavity.power / 1000, "W");
    r.add("  area close to tissue (" + std::string(row.name) + ")", cavity.area, "mm2");
    r.add("  patch in contact (" + std::string(row.name) + ")", cavity.step_area, "mm2");
    r.add("  removed (" + std::string(row.name) + ")", cavity.removed, "mm3");
    r.add("  conducted (" + std::string(row.name) + ")", cavity.conducted, "mJ");
    hottest.add(cavity.hottest);
    mean.add(cavity.mean);
    conducted.add(cavity.conducted);
    of_power.add(cavity.mean / cavity.power);
  }
  r.add("responses, one wet cavity: surface, most", hottest.percent(), "%");
  r.add("responses, one wet cavity: surface over power", of_power.percent(), "%");
  r.add("responses, one wet cavity: conducted", conducted.percent(), "%");
  // One response stays longer in contact and spends the least.
  r.add("  mean in contact", mean.percent(), "%");
  return {};
}

// A sagittal blade through 10 mm of cortical bone at 30 mm/min, with the table's 5.3 W. The step's saws have one energy
// per volume, and 7 N were measured.
Expected<void> addSaw(Result& r) {
  constexpr double kWidth = 10, kPower = 5300, kFeed = 0.5;
  KERF_TRY(tool, toolOfRack("saw-sagittal-10"));
  KERF_TRY(model, makeModel(std::span(&tool, 1)));
  model.settings.rendering = Rendering::kRigid;
  KERF_TRY(block, practiceBlock({kWidth, 4, 4}, 0.1, {}, Material::kCortical));
  const CutPath path = pathOf({{0, 0.013, 0.02}, {0, 0.013, -2}}, kFeed, Eigen::Quaterniond::Identity());
  const auto run = [&](double irrigation, const HeatSettings& settings, double power) {
    FeedHand hand(path);
    return cut(model, block, hand, path.poses[0].T_object_tool, heatSource(tool), settings, irrigation, 3.9, power);
  };
  KERF_TRY(dry, run(0, {}, kPower));
  KERF_TRY(wet, run(1, kBodyWarm, kPower));
  KERF_TRY(cold, run(1, {}, kPower));
  KERF_TRY(as_it_is, run(0, {}, 0));
  r.add("saw: area off kerf x 10 mm by", std::abs(percentOff(dry.area, tool.kerfWidth() * kWidth)), "%");
  addWithin(r, "saw, 30 mm/min, 5.3 W: surface, dry", dry.at_end, 65, 100);
  addWithin(r, "saw, 30 mm/min, 5.3 W: surface, wet", wet.at_end, 0, 15);
  r.add("  wet, water 10 K below the body", cold.at_end, "K");
  r.add("  dry, by the step's own power", as_it_is.at_end, "K");
  r.add("  which is", as_it_is.power / 1000, "W");
  return {};
}

}  // namespace

Expected<Result> benchHeat(const Bench& bench) {
  Result r(SceneId::kHeat, "temperature under the tool and at depth, against measurements; responses in one cavity");
  if (!report(bench.progress, 0, "model")) return cancelled();
  addPulp(r);
  addDrills(r);
  addSigns(r);
  if (!report(bench.progress, 0.1, "bur on enamel")) return cancelled();
  KERF_CHECK(addBurOnEnamel(r));
  if (!report(bench.progress, 0.2, "saw")) return cancelled();
  KERF_CHECK(addSaw(r));
  KERF_CHECK(addResponses(r, bench));
  return r;
}

}  // namespace kerf::cli
