// The responses to contact side by side, on the same scenes. Only the default has goals.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/hand/virtual_hand.h"
#include "sim/run/practice_block.h"
#include "ui/bench/bench.h"

namespace kerf::cli {
namespace {

constexpr double kVoxel = 0.05, kRadius = 0.5, kSpeed = 840;  // mm, mm, mm/s
constexpr double kFriction = 0.5, kEnergy = 1000;             // -, N/mm^2

struct Way {
  std::string name;
  Response response;
  Rendering rendering;
};

// Every response, coupled and direct; the first is the default.
std::vector<Way> allWays() {
  std::vector<Way> ways;
  for (const ResponseRow& row : kResponses)
    for (const RenderingRow& rendering : kRenderings)
      if (rendering.rendering != Rendering::kRigid)
        ways.push_back({fmt::format("{} {}", row.name, rendering.name), row.response, rendering.rendering});
  return ways;
}

// Nothing between law and number: no fade-in, no limit of the rate.
Model modelOf(const Way& way, bool cuts) {
  Model model;
  model.tools = {practiceBall(kRadius, kSpeed)};
  if (!cuts) model.tools[0].drive.speed = 0;
  const double friction = cuts ? kFriction : 0;
  model.tissues.fill({200, static_cast<float>(friction), static_cast<float>(1 / kEnergy), true});
  model.settings.response = way.response;
  model.settings.rendering = way.rendering;
  model.settings.ramp_s = 0;
  model.settings.coupling.force_rate = model.settings.coupling.torque_rate = 1e9;
  return model;
}

DeviceSample sampleAt(const Vec3d& tip, bool cuts = false) {
  DeviceSample sample;
  sample.T_world_device.translation = tip;
  sample.pedal = cuts ? 1 : 0;
  return sample;
}

struct Objects {
  std::shared_ptr<const BakedObject> flat, ball;
  Rigid3 askew;  // of the flat: no axis of the grid is one of the scene's
};
constexpr double kBallRadius = 5;
const Vec3d kBallCenter(0.013, 0.027, -kBallRadius);

Expected<Objects> makeObjects() {
  Objects out;
  out.askew = {Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vec3d(1, 2, 3).normalized())), Vec3d::Zero()};
  KERF_TRY(flat, practiceBlock({8, 4, 2}, kVoxel, out.askew));
  Box3 box;
  box.add(Vec3d(kBallCenter.array() - kBallRadius - 0.1));
  box.add(Vec3d(kBallCenter.array() + kBallRadius + 0.1));
  KERF_TRY(ball, bakedFrom([](const Vec3d& p) { return (p - kBallCenter).norm() - kBallRadius; }, box, kVoxel));
  out.flat = flat;
  out.ball = ball;
  return out;
}

struct Pressed {
  double depth = 0;                 // of the device, mm
  double deepest = 0, at_rest = 0;  // of the tool in the tissue, mm
};
// Straight down onto the flat at 100 mm/s to a depth of the device, and 0.5 s there.
Pressed press(const Way& way, const Objects& objects, double depth, double* force = nullptr) {
  const Model model = modelOf(way, false);
  State state;
  state.objects.emplace_back(objects.flat, 16);
  StepOutput out;
  Pressed p{depth, 0, 0};
  for (int n = 0; n < 520; ++n) {
    DeviceSample sample = sampleAt(objects.askew * Vec3d(0.013, 0.027, std::max(1 - 0.1 * n, -depth)));
    sample.T_world_device.rotation = objects.askew.rotation;
    step(model, state, sample, out);
    const double in = -(objects.askew.inverse() * out.T_world_tool.translation)[2];
    p.deepest = std::max(p.deepest, in);
    p.at_rest = in;
  }
  if (force) *force = out.force.force.norm();
  return p;
}
// How deep the device has to be for that force at rest: bisection.
Pressed pressWith(const Way& way, const Objects& objects, double force) {
  const bool is_fixed = way.rendering == Rendering::kDirect && rowOf(way.response).direct == Attachment::kFixed;
  double low = 0, high = is_fixed ? 0.3 : 1.3 * force;
  for (int n = 0; n < 14; ++n) {
    const double middle = 0.5 * (low + high);
    double found = 0;
    press(way, objects, middle, &found);
    (found < force ? low : high) = middle;
  }
  return press(way, objects, 0.5 * (low + high));
}

// The largest change of the hand's force in a ms, less the mean change about it: a hand that follows a curve feels its
// force turn, which is no jump.
double largestJump(const std::vector<Vec3d>& force) {
  constexpr std::size_t kAround = 25;
  double most = 0;
  for (std::size_t n = kAround + 1; n + kAround < force.size(); ++n) {
    const Vec3d mean = (force[n + kAround] - force[n - kAround]) / (2.0 * kAround);
    most = std::max(most, (force[n] - force[n - 1] - mean).norm());
  }
  return most;
}

// 3 mm at 10 mm/s, the device as deep as 1 N wants it on the flat.
double slideOnFlat(const Way& way, const Objects& objects, double depth) {
  const Model model = modelOf(way, false);
  State state;
  state.objects.emplace_back(objects.flat, 16);
  StepOutput out;
  std::vector<Vec3d> force;
  for (int n = 0; n < 800; ++n) {
    DeviceSample sample =
        sampleAt(objects.askew * Vec3d(-1.5 + 0.01 * std::max(n - 500, 0), 0.1, std::max(0.5 - 0.005 * n, -depth)));
    sample.T_world_device.rotation = objects.askew.rotation;
    step(model, state, sample, out);
    if (n > 510) force.push_back(out.force.force);
  }
  return largestJump(force);
}
double slideOnBall(const Way& way, const Objects& objects, double depth) {
  const Model model = modelOf(way, false);
  State state;
  state.objects.emplace_back(objects.ball, 16);
  StepOutput out;
  std::vector<Vec3d> force;
  for (int n = 0; n < 800; ++n) {
    const double a = (-1.5 + 0.01 * std::max(n - 500, 0)) / kBallRadius;
    const Vec3d up = Vec3d(std::sin(a), 0.1 * a, std::cos(a)).normalized();
    const double away = kBallRadius + kRadius + std::max(0.5 - 0.005 * n, -depth);
    step(model, state, sampleAt(kBallCenter + away * up - Vec3d(0, 0, kRadius)), out);
    if (n > 510) force.push_back(out.force.force);
  }
  return largestJump(force);
}

struct Held {
  int given = 0, trembling = 0, runs = 0;
  double energy = -1e9;  // the most, mJ
};
// The scene of `passivity`, some of its hands: a device pressed on a block that does not give way.
Expected<Held> hold(const Way& way, const std::shared_ptr<const BakedObject>& block, double stiffness, double friction,
                    const Progress& progress, double done) {
  Held out;
  CutPath path;
  for (const auto& [t, z] : {std::pair(0.0, 1.0), std::pair(0.5, -2.0), std::pair(1.5, -2.0), std::pair(1.8, 1.0)})
    path.poses.push_back({t, {Eigen::Quaterniond::Identity(), {0, 0, z}}});
  path.cuts = {1, 1, 1};
  for (const double hand_stiffness : {0.1, 0.3, 1.0, 2.0})
    for (const double hand_damping : {0.0005, 0.003})
      for (const double encoder : {0.01, 0.03})
        for (const double mass : {0.05, 0.1}) {
          if (!report(progress, done, way.name)) return cancelled();
          DeviceHand::Options options;
          options.hand_stiffness = hand_stiffness;
          options.hand_damping = hand_damping;
          options.encoder_mm = encoder;
          options.mass_kg = mass;
          options.friction = friction;
          Model model = modelOf(way, false);
          model.settings.coupling.stiffness = stiffness;
          model.settings.coupling.force_rate = CouplingSettings{}.force_rate;  // as it is used
          model.settings.coupling.torque_rate = CouplingSettings{}.torque_rate;
          State state;
          state.objects.emplace_back(block, 16);
          DeviceHand hand(path, options);
          state.place(poseAt(path, 0));
          StepOutput tick;
          DeviceSample sample;
          double energy = -1e9, low = 1e9, high = -1e9;
          for (int n = 0; hand.next(tick, sample); ++n) {
            step(model, state, sample, tick);
            energy = std::max(energy, hand.portEnergy());
            if (n > 1200 && n < 1490) {
              low = std::min(low, hand.position()[2]);
              high = std::max(high, hand.position()[2]);
            }
          }
          ++out.runs;
          out.given += energy > 0;
          out.trembling += high - low > 0.005;
          out.energy = std::max(out.energy, energy);
        }
  return out;
}

struct Slot {
  double rate = 0, jump = 0;     // of removal, over the law's; N
  double removed = 0, load = 0;  // mm^3; N, mean
  std::vector<double> us;
};
// Down at 1 mm/s, then along at 2 mm/s, 0.45 mm below the surface by the device; means along the slot.
Slot cutSlot(const Way& way, const Objects& objects) {
  const Model model = modelOf(way, true);
  State state;
  state.objects.emplace_back(objects.flat, 16384);
  StepOutput out;
  Slot slot;
  double removed = 0, load = 0;
  std::vector<Vec3d> force;
  for (int n = 0; n < 2000; ++n) {
    DeviceSample sample = sampleAt(
        objects.askew * Vec3d(-1.5 + 0.002 * std::max(n - 500, 0), 0.01, 0.05 - 0.001 * std::min(n, 500)), true);
    sample.T_world_device.rotation = objects.askew.rotation;
    const double start = now();
    step(model, state, sample, out);
    slot.us.push_back(1000 * (now() - start));
    if (n < 800) continue;
    removed += out.removed_mm3;
    load += out.normal_load * kTick;
    force.push_back(out.force.force);
  }
  slot.rate = load > 0 ? removed / (kFriction * load * kSpeed / kEnergy) : 0;
  slot.jump = largestJump(force);
  slot.removed = removed;
  slot.load = load / (1200 * kTick);
  std::sort(slot.us.begin(), slot.us.end());
  return slot;
}

}  // namespace

Expected<Result> benchResponse(const Progress& progress) {
  Result r{"response", "contact by penalty, constraints, impulses; given to the hand through the coupling or directly",
           {},         "",
           0,          ""};
  r.is_table = true;
  KERF_TRY(objects, makeObjects());
  KERF_TRY(block, practiceBlock({4, 4, 2}, 0.1));
  const std::vector<Way> ways = allWays();
  const auto count = static_cast<double>(ways.size());
  for (std::size_t w = 0; w < ways.size(); ++w) {
    const Way& way = ways[w];
    const double done = static_cast<double>(w) / count;
    const bool is_default = w == 0;
    const auto add = [&](const char* what, double value, const char* unit, double goal = -1) {
      r.measured.push_back({fmt::format("{}: {}", way.name, what), value, unit, goal, is_default && goal >= 0});
    };
    if (!report(progress, done, way.name)) return cancelled();
    const Pressed one = pressWith(way, objects, 1), five = pressWith(way, objects, 5);
    add("jump of force per ms, flat", slideOnFlat(way, objects, one.depth), "N", 0.02);
    add("jump of force per ms, ball", slideOnBall(way, objects, one.depth), "N", 0.02);
    add("penetration at rest, 1 N", 1000 * one.at_rest, "um");
    add("penetration at rest, 5 N", 1000 * five.at_rest, "um");
    add("deepest, pressed to 1 N at 100 mm/s", 1000 * one.deepest, "um");
    add("deepest, pressed to 5 N at 100 mm/s", 1000 * five.deepest, "um");
    // Direct penalty knows no coupling: the same at any stiffness.
    for (const double stiffness : {1.0, 2.0, 4.0}) {
      KERF_TRY(held, hold(way, block, stiffness, 0.05, progress, done + 0.5 / count));
      add(fmt::format("{} N/mm: devices given energy, of {}", stiffness, held.runs).c_str(), held.given, "",
          stiffness <= 2 ? 0 : -1);
      add(fmt::format("{} N/mm: devices that tremble by 5 um", stiffness).c_str(), held.trembling, "",
          stiffness <= 1 ? 0 : -1);
    }
    KERF_TRY(slippery, hold(way, block, 1, 0, progress, done + 0.8 / count));
    add("1 N/mm, no friction: energy given, most", std::max(slippery.energy, 0.0), "mJ", 0.1);
    const Slot slot = cutSlot(way, objects);
    add("jump of force per ms, cutting", slot.jump, "N", 0.05);
    add("normal load, cutting", slot.load, "N");
    add("removed", slot.removed, "mm3");
    add("removal less mu N v / u_s", 100 * (slot.rate - 1), "%", 5);
    const auto at = [&](double p) {
      return slot.us[std::min(slot.us.size() - 1, static_cast<std::size_t>(p * static_cast<double>(slot.us.size())))];
    };
    add("tick, p50", at(0.5), "us");
    add("tick, p99", at(0.99), "us");
    add("tick, p99.9", at(0.999), "us");
    add("tick, max", at(1), "us");
  }
  return r;
}

}  // namespace kerf::cli
