// Comparison of the contact responses on the same scenes. Only the default has goals.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/bench.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "bench/scenes/press.h"
#include "sim/step/response.h"

namespace kerf::cli {
namespace {

using namespace scenes;

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

// Law and number only: no fade-in, no rate limit.
Model modelOf(const Way& way, bool cuts) {
  Model model;
  model.tools = {practiceBall(kRadius, kSpeed)};
  if (!cuts) model.tools[0].drive.speed = 0;
  const double friction = cuts ? kFriction : 0;
  model.tissues = oneTissue(200, friction, kEnergy);
  model.settings.response = way.response;
  model.settings.rendering = way.rendering;
  model.settings.ramp_s = 0;
  model.settings.coupling.force_rate = model.settings.coupling.torque_rate = 1e9;
  return model;
}

struct Objects {
  std::shared_ptr<const BakedObject> flat, sphere;
  Rigid3 askew;  // of the flat, with no axis of the grid along one of the scene
};
constexpr double kSphereRadius = 5;
const Vec3d kSphereCenter(0.013, 0.027, -kSphereRadius);

Expected<Objects> makeObjects() {
  Objects out;
  out.askew = askew();
  KERF_TRY(flat, practiceBlock({8, 4, 2}, kVoxel, out.askew));
  KERF_TRY(sphere, practiceSphere(kSphereCenter, kSphereRadius, kVoxel));
  out.flat = flat;
  out.sphere = sphere;
  return out;
}

struct Pressed {
  double depth = 0;                 // of the device, mm
  double deepest = 0, at_rest = 0;  // of the tool in the tissue, mm
};
// Straight down onto the flat at 100 mm/s to a depth of the device, then 0.5 s of rest.
Pressed pressTo(const Way& way, const Objects& objects, double depth, double* force = nullptr) {
  const Model model = modelOf(way, false);
  State state;
  state.objects.emplace_back(objects.flat, 16);
  StepOutput out;
  Pressed p{depth, 0, 0};
  for (int n = 0; n < 520; ++n) {
    const Vec3d tip = objects.askew * Vec3d(0.013, 0.027, std::max(1 - 0.1 * n, -depth));
    step(model, state, sampleAt({objects.askew.rotation, tip}, 0), out);
    const double in = -(objects.askew.inverse() * out.T_world_tool.translation)[2];
    p.deepest = std::max(p.deepest, in);
    p.at_rest = in;
  }
  if (force) *force = out.force.force.norm();
  return p;
}
// Depth of the device for that force at rest, by bisection.
Pressed pressWith(const Way& way, const Objects& objects, double force) {
  const bool is_fixed = way.rendering == Rendering::kDirect && rowOf(way.response).direct == Attachment::kFixed;
  double low = 0, high = is_fixed ? 0.3 : 1.3 * force;
  for (int n = 0; n < 14; ++n) {
    const double middle = 0.5 * (low + high);
    double found = 0;
    pressTo(way, objects, middle, &found);
    (found < force ? low : high) = middle;
  }
  return pressTo(way, objects, 0.5 * (low + high));
}

// The largest change of the hand's force per ms, less the mean change around it. On a curve the force rotates steadily,
// which is no jump.
double largestJump(const std::vector<Vec3d>& force) {
  constexpr std::size_t kAround = 25;
  double most = 0;
  for (std::size_t n = kAround + 1; n + kAround < force.size(); ++n) {
    const Vec3d mean = (force[n + kAround] - force[n - kAround]) / (2.0 * kAround);
    most = std::max(most, (force[n] - force[n - 1] - mean).norm());
  }
  return most;
}

// 3 mm at 10 mm/s, with the device at its depth for 1 N on the flat.
double slideOnFlat(const Way& way, const Objects& objects, double depth) {
  const Model model = modelOf(way, false);
  State state;
  state.objects.emplace_back(objects.flat, 16);
  StepOutput out;
  std::vector<Vec3d> force;
  for (int n = 0; n < 800; ++n) {
    const Vec3d tip = objects.askew * Vec3d(-1.5 + 0.01 * std::max(n - 500, 0), 0.1, std::max(0.5 - 0.005 * n, -depth));
    step(model, state, sampleAt({objects.askew.rotation, tip}, 0), out);
    if (n > 510) force.push_back(out.force.force);
  }
  return largestJump(force);
}

double slideOnSphere(const Way& way, const Objects& objects, double depth) {
  const Model model = modelOf(way, false);
  State state;
  state.objects.emplace_back(objects.sphere, 16);
  StepOutput out;
  std::vector<Vec3d> force;
  for (int n = 0; n < 800; ++n) {
    const double a = (-1.5 + 0.01 * std::max(n - 500, 0)) / kSphereRadius;
    const Vec3d up = Vec3d(std::sin(a), 0.1 * a, std::cos(a)).normalized();
    const double away = kSphereRadius + kRadius + std::max(0.5 - 0.005 * n, -depth);
    const Vec3d tip = kSphereCenter + away * up - Vec3d(0, 0, kRadius);
    step(model, state, sampleAt({Eigen::Quaterniond::Identity(), tip}, 0), out);
    if (n > 510) force.push_back(out.force.force);
  }
  return largestJump(force);
}

struct Hands {
  int given = 0, trembling = 0, runs = 0;
  double energy = -1e9;  // maximum, mJ
};
// The scene of `passivity` with some of its hands: a device pressed on a rigid block.
Expected<Hands> pressHands(const Way& way, const std::shared_ptr<const BakedObject>& block, double stiffness,
                           double friction, const Bench& bench, double done) {
  Model model = modelOf(way, false);
  model.settings.coupling.stiffness = stiffness;
  model.settings.coupling.force_rate = CouplingSettings{}.force_rate;  // default of the coupling
  model.settings.coupling.torque_rate = CouplingSettings{}.torque_rate;

  Hands out;
  for (const double hand_stiffness : {0.1, 0.3, 1.0, 2.0})
    for (const double hand_damping : {0.0005, 0.003})
      for (const double encoder : {0.01, 0.03})
        for (const double mass : {0.05, 0.1}) {
          if (!report(bench.progress, done, way.name.c_str())) return cancelled();
          DeviceHand::Options options;
          options.hand_stiffness = hand_stiffness;
          options.hand_damping = hand_damping;
          options.encoder_mm = encoder;
          options.mass_kg = mass;
          options.friction = friction;

          const Press p = press(model, block, options);
          ++out.runs;
          out.given += p.energy > 0;
          out.trembling += p.trembling > 0.005;
          out.energy = std::max(out.energy, p.energy);
        }
  return out;
}

struct SlotCut {
  double rate = 0, jump = 0;     // of removal, over the law's; N
  double removed = 0, load = 0;  // mm^3; N, mean
  std::vector<double> us;
};
// Down at 1 mm/s, then along at 2 mm/s, with the device 0.45 mm below the surface. Means along the slot.
SlotCut cutSlot(const Way& way, const Objects& objects) {
  const Model model = modelOf(way, true);
  State state;
  state.objects.emplace_back(objects.flat, 16384);
  StepOutput out;
  SlotCut slot;
  double removed = 0, load = 0;
  std::vector<Vec3d> force;
  for (int n = 0; n < 2000; ++n) {
    const Vec3d tip = objects.askew * Vec3d(-1.5 + 0.002 * std::max(n - 500, 0), 0.01, 0.05 - 0.001 * std::min(n, 500));
    const DeviceSample sample = sampleAt({objects.askew.rotation, tip});
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
  return slot;
}

// A column of the table.
Expected<void> addWay(Result& r, const Way& way, const Objects& objects,
                      const std::shared_ptr<const BakedObject>& block, double done, double share, const Bench& bench) {
  const auto add = [&](const std::string& what, double value, const char* unit = "") {
    r.add(fmt::format("{}: {}", way.name, what), value, unit);
  };
  if (!report(bench.progress, done, way.name.c_str())) return cancelled();
  const Pressed one = pressWith(way, objects, 1), five = pressWith(way, objects, 5);
  add("jump of force per ms, flat", slideOnFlat(way, objects, one.depth), "N");
  add("jump of force per ms, ball", slideOnSphere(way, objects, one.depth), "N");
  add("penetration at rest, 1 N", 1000 * one.at_rest, "um");
  add("penetration at rest, 5 N", 1000 * five.at_rest, "um");
  add("deepest, pressed to 1 N at 100 mm/s", 1000 * one.deepest, "um");
  add("deepest, pressed to 5 N at 100 mm/s", 1000 * five.deepest, "um");

  // Direct penalty has no coupling: its result is the same at any stiffness.
  for (const double stiffness : {1.0, 2.0, 4.0}) {
    KERF_TRY(hands, pressHands(way, block, stiffness, 0.05, bench, done + 0.5 * share));
    add(fmt::format("{} N/mm: devices given energy, of {}", stiffness, hands.runs), hands.given);
    add(fmt::format("{} N/mm: devices that tremble by 5 um", stiffness), hands.trembling);
  }
  KERF_TRY(slippery, pressHands(way, block, 1, 0, bench, done + 0.8 * share));
  add("1 N/mm, no friction: energy given, most", std::max(slippery.energy, 0.0), "mJ");

  const SlotCut slot = cutSlot(way, objects);
  add("jump of force per ms, cutting", slot.jump, "N");
  add("normal load, cutting", slot.load, "N");
  add("removed", slot.removed, "mm3");
  add("removal less mu N v / u_s", 100 * (slot.rate - 1), "%");
  add("tick, p50", percentile(slot.us, 0.5), "us");
  add("tick, p99", percentile(slot.us, 0.99), "us");
  add("tick, p99.9", percentile(slot.us, 0.999), "us");
  add("tick, max", percentile(slot.us, 1), "us");
  return {};
}

}  // namespace

Expected<Result> benchResponse(const Bench& bench) {
  Result r(SceneId::kResponse,
           "contact by penalty, constraints, impulses; given to the hand through the coupling or directly");
  r.is_table = true;
  KERF_TRY(objects, makeObjects());
  KERF_TRY(block, practiceBlock({4, 4, 2}, 0.1));
  const std::vector<Way> ways = allWays();
  const double share = 1.0 / static_cast<double>(ways.size());
  for (std::size_t w = 0; w < ways.size(); ++w)
    KERF_CHECK(addWay(r, ways[w], objects, block, static_cast<double>(w) * share, share, bench));
  return r;
}

}  // namespace kerf::cli
