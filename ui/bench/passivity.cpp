// Whether a force-feedback device is given energy: a simulated device and hand, pressed on a wall that does not give
// way.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "sim/hand/virtual_hand.h"
#include "sim/run/practice_block.h"
#include "ui/bench/bench.h"

namespace kerf::cli {
namespace {

struct Press {
  double energy = 0;     // most the device was given beyond its own losses, N mm = mJ; 0: never any
  double trembling = 0;  // while the hand holds still, mm from end to end
};

// Down, held for a second, up again.
Press press(const std::shared_ptr<const BakedObject>& block, const ToolModel& ball, Rendering rendering,
            double stiffness, const DeviceHand::Options& options) {
  Model model;
  model.tools = {ball};
  model.tools[0].drive.speed = 0;
  model.tissues.fill({200, 0, 1e-3f, true});
  model.settings.rendering = rendering;
  model.settings.coupling.stiffness = stiffness;
  model.settings.ramp_s = 0;
  State state;
  state.objects.emplace_back(block, 16);
  CutPath path;
  for (const auto& [t, z] : {std::pair(0.0, 1.0), std::pair(0.5, -2.0), std::pair(1.5, -2.0), std::pair(1.8, 1.0)})
    path.poses.push_back({t, {Eigen::Quaterniond::Identity(), {0, 0, z}}});
  path.cuts = {1, 1, 1};
  DeviceHand hand(path, options);
  StepOutput out;
  DeviceSample sample;
  state.place(poseAt(path, 0));
  Press result;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int n = 0; hand.next(out, sample); ++n) {
    step(model, state, sample, out);
    result.energy = std::max(result.energy, hand.portEnergy());
    if (n > 1200 && n < 1490) {
      low = std::min(low, hand.position()[2]);
      high = std::max(high, hand.position()[2]);
    }
  }
  result.trembling = high - low;
  return result;
}

}  // namespace

Expected<Result> benchPassivity(const Progress& progress) {
  Result r{"passivity", "a simulated device pressed on a block that does not give way, 1.8 s, all hands", {}, "", 0,
           ""};
  KERF_TRY(block, practiceBlock({4, 4, 2}, 0.1));
  const ToolModel ball = practiceBall(0.5, 840);
  // Bounds of the literature for b = 0.5 N s/m, one tick of delay: K <= 0.33 N/mm; and K <= 2 f / encoder step, which a
  // device without friction never meets: its encoder's steps make it tremble whatever the coupling.
  double direct_energy = 0;
  int direct_fails = 0, runs = 0;
  for (const double friction : {0.05, 0.0})
    for (const double stiffness : {0.33, 0.7, 1.0, 1.5, 2.0}) {
      double energy = 0, trembling = 0;
      for (const double hand_stiffness : {0.05, 0.1, 0.3, 1.0, 2.0})
        for (const double hand_damping : {0.0005, 0.003, 0.01})
          for (const double encoder : {0.01, 0.03})
            for (const double mass : {0.05, 0.1}) {
              if (!report(progress, 0.2 * stiffness, "hands")) return cancelled();
              DeviceHand::Options options;
              options.hand_stiffness = hand_stiffness;
              options.hand_damping = hand_damping;
              options.encoder_mm = encoder;
              options.mass_kg = mass;
              options.friction = friction;
              const Press p = press(block, ball, Rendering::kCoupled, stiffness, options);
              energy = std::max(energy, p.energy);
              trembling = std::max(trembling, p.trembling);
              ++runs;
              if (stiffness == 1.0 && friction > 0) {
                const double d = press(block, ball, Rendering::kDirect, stiffness, options).energy;
                direct_energy = std::max(direct_energy, d);
                direct_fails += d > 0;
              }
            }
      const std::string what = fmt::format("K {} N/mm, friction {} N", stiffness, friction);
      r.measured.push_back(
          {what + ": energy given away, worst of 60 hands", energy, "mJ", friction > 0 ? 0 : 0.1, stiffness <= 1});
      r.measured.push_back({what + ": trembling", 1000 * trembling, "um", 5, friction > 0 && stiffness <= 1});
    }
  r.measured.push_back({"direct rendering: energy given away, worst of 60 hands", direct_energy, "mJ", 0, false});
  r.measured.push_back(
      {"direct rendering: hands it fails with, of 60", static_cast<double>(direct_fails), "", 0, false});
  r.measured.push_back({"runs", static_cast<double>(runs), "", 0, false});
  return r;
}

namespace {

// The grid. Devices of the trade have 0.03 to 0.2 kg at the tip, encoders of 5 to 55 um, some hundredths of a newton
// of friction; hands 0.05 (two fingertips) to 2 N/mm (a fist).
struct Axis {
  const char* name;
  const char* unit;
  std::vector<double> values;
};
enum : std::size_t { kStiffness, kFriction, kEncoder, kDelay, kMass, kDamping, kHand, kHandDamping, kAxes };
const std::vector<Axis>& grid() {
  static const std::vector<Axis> axes{
      {"K", "N/mm", {0.33, 0.7, 1, 1.5, 2, 3}}, {"friction", "N", {0, 0.02, 0.05, 0.1}},
      {"encoder", "mm", {0.005, 0.02, 0.055}},  {"delay", "ticks", {1, 2}},
      {"mass", "kg", {0.03, 0.08, 0.2}},        {"damping", "N s/mm", {0.0001, 0.0005, 0.002}},
      {"hand", "N/mm", {0.05, 0.3, 2}},         {"hand's damping", "N s/mm", {0.0005, 0.003, 0.01}}};
  return axes;
}

using Numbers = std::array<double, kAxes>;

Numbers numbersOf(std::size_t run, std::array<std::size_t, kAxes>& at) {
  Numbers out{};
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    const std::vector<double>& values = grid()[axis].values;
    at[axis] = run % values.size();
    run /= values.size();
    out[axis] = values[at[axis]];
  }
  return out;
}

// Stiffness up to which a sampled wall is passive, N/mm: Colgate & Schenkel with a delay (Gil, Hulin), Coulomb friction
// against the encoder's steps (Abbott & Okamura 2005).
double boundOf(const Numbers& n) {
  const double late = (0.5 + n[kDelay]) * kTick;
  return std::min({2 * n[kDamping] / kTick, n[kDamping] / late, 2 * n[kFriction] / n[kEncoder]});
}

}  // namespace

Expected<Result> benchPassivityLarge(const Progress& progress) {
  Result r{"passivity-large", "", {}, "", 0, ""};
  KERF_TRY(block, practiceBlock({4, 4, 2}, 0.1));
  const ToolModel ball = practiceBall(0.5, 840);
  std::size_t runs = 1;
  for (const Axis& axis : grid()) runs *= axis.values.size();
  r.what = fmt::format("{} devices, hands and stiffnesses, all of a grid, pressed on a block for 1.8 s", runs);
  // Every run is its own: the same numbers on any number of threads.
  std::vector<Press> presses(runs);
  constexpr std::size_t kBatch = 256;
  for (std::size_t begin = 0; begin < runs; begin += kBatch) {
    if (!report(progress, static_cast<double>(begin) / static_cast<double>(runs), "hands")) return cancelled();
    tbb::parallel_for(begin, std::min(runs, begin + kBatch), [&](std::size_t run) {
      std::array<std::size_t, kAxes> at;
      const Numbers n = numbersOf(run, at);
      DeviceHand::Options options;
      options.friction = n[kFriction];
      options.encoder_mm = n[kEncoder];
      options.mass_kg = n[kMass];
      options.delay_ticks = static_cast<int>(n[kDelay]);
      options.damping = n[kDamping];
      options.hand_stiffness = n[kHand];
      options.hand_damping = n[kHandDamping];
      presses[run] = press(block, ball, Rendering::kCoupled, n[kStiffness], options);
    });
  }

  // A share of the runs, and what they show.
  struct Share {
    std::size_t runs = 0, given = 0;
    double energy = 0;
    std::vector<double> trembling;
    void add(const Press& p) {
      ++runs;
      given += p.energy > 0;
      energy = std::max(energy, p.energy);
      trembling.push_back(1000 * p.trembling);
    }
  };
  const auto say = [&](const std::string& name, Share& share, bool must, double most_mJ) {
    if (share.runs == 0) return;
    Result part;
    part.ms = share.trembling;
    const auto number = [&](const char* what, double value, const char* unit, double goal, bool has_goal) {
      r.measured.push_back({fmt::format("{}: {}", name, what), value, unit, goal, has_goal});
    };
    number("runs", static_cast<double>(share.runs), "", 0, false);
    number("given energy", static_cast<double>(share.given), "", 0, must);
    number("most energy", share.energy, "mJ", most_mJ, most_mJ > 0);
    number("trembling, p50", part.percentile(0.5), "um", 0, false);
    number("trembling, p95", part.percentile(0.95), "um", 0, false);
    number("trembling, most", part.percentile(1), "um", 5, must);
  };
  Share all, within, twice;
  std::vector<std::vector<Share>> by(kAxes);
  for (std::size_t axis = 0; axis < kAxes; ++axis) by[axis].resize(grid()[axis].values.size());
  Share of_default[4];  // K = 1 N/mm, by friction
  const double none = std::numeric_limits<double>::infinity();
  std::array<double, 4> least_stiffness{none, none, none, none};  // at which any was given energy
  std::uint64_t hash = 0;
  for (std::size_t run = 0; run < runs; ++run) {
    std::array<std::size_t, kAxes> at;
    const Numbers n = numbersOf(run, at);
    const Press& p = presses[run];
    all.add(p);
    for (std::size_t axis = 0; axis < kAxes; ++axis) by[axis][at[axis]].add(p);
    if (p.energy > 0) least_stiffness[at[kFriction]] = std::min(least_stiffness[at[kFriction]], n[kStiffness]);
    const double bound = boundOf(n);
    if (n[kStiffness] <= bound)
      within.add(p);
    else if (n[kStiffness] <= 2 * bound)
      twice.add(p);
    if (n[kStiffness] == 1) of_default[at[kFriction]].add(p);
    hash = hash * 0x100000001b3ull ^ std::bit_cast<std::uint64_t>(p.energy) ^
           std::rotl(std::bit_cast<std::uint64_t>(p.trembling), 32);
  }
  say("K within the bounds of the literature", within, true, 0);
  say("K up to twice these bounds", twice, false, 0.1);
  for (std::size_t f = 0; f < 4; ++f)
    say(fmt::format("K 1 N/mm (the default), friction {} N", grid()[kFriction].values[f]), of_default[f], false, 0);
  say("all", all, false, 0);
  for (std::size_t f = 0; f < 4; ++f)
    if (least_stiffness[f] < none)
      r.measured.push_back({fmt::format("least K that gave energy, friction {} N", grid()[kFriction].values[f]),
                            least_stiffness[f], "N/mm", 0, false});
  for (std::size_t axis = 0; axis < kAxes; ++axis)
    for (std::size_t v = 0; v < by[axis].size(); ++v) {
      const Share& share = by[axis][v];
      r.measured.push_back({fmt::format("given energy with {} {} {}, of {}", grid()[axis].name, grid()[axis].values[v],
                                        grid()[axis].unit, share.runs),
                            static_cast<double>(share.given), "", 0, false});
    }
  r.state_hash = fmt::format("{:016x}", hash);
  return r;
}

}  // namespace kerf::cli
