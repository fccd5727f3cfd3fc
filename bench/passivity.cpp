// Whether a force-feedback device gains energy: a simulated device and hand press on a rigid wall.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "bench/bench.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/practice_block.h"
#include "bench/scenes/press.h"
#include "sim/hand/virtual_hand.h"

namespace kerf::cli {
namespace {

using namespace scenes;

// The case with a formula: stiff tissue without friction, the tool at rest.
Model modelOf(const ToolModel& ball, Rendering rendering, double stiffness) {
  Model model;
  model.tools = {ball};
  model.tools[0].drive.speed = 0;
  model.tissues = oneTissue(200, 0, 1000);
  model.settings.rendering = rendering;
  model.settings.coupling.stiffness = stiffness;
  model.settings.ramp_s = 0;
  return model;
}

// Hands pressed at one stiffness on devices of one friction.
struct Hands {
  int runs = 0;
  double energy = 0;     // highest energy gain of a device, mJ; 0: none
  double trembling = 0;  // maximum, mm
  int direct_fails = 0;  // devices that gain energy under direct rendering
  double direct_energy = 0;
};
Expected<Hands> pressHands(const std::shared_ptr<const BakedObject>& block, const ToolModel& ball, double stiffness,
                           double friction, bool also_direct, const Bench& bench) {
  Hands hands;
  for (const double hand_stiffness : {0.05, 0.1, 0.3, 1.0, 2.0})
    for (const double hand_damping : {0.0005, 0.003, 0.01})
      for (const double encoder : {0.01, 0.03})
        for (const double mass : {0.05, 0.1}) {
          if (!report(bench.progress, 0.2 * stiffness, "hands")) return cancelled();
          DeviceHand::Options options;
          options.hand_stiffness = hand_stiffness;
          options.hand_damping = hand_damping;
          options.encoder_mm = encoder;
          options.mass_kg = mass;
          options.friction = friction;
          const Press coupled = press(modelOf(ball, Rendering::kCoupled, stiffness), block, options);
          hands.energy = std::max(hands.energy, coupled.energy);
          hands.trembling = std::max(hands.trembling, coupled.trembling);
          ++hands.runs;
          if (!also_direct) continue;

          const Press direct = press(modelOf(ball, Rendering::kDirect, stiffness), block, options);
          hands.direct_energy = std::max(hands.direct_energy, direct.energy);
          hands.direct_fails += direct.energy > 0;
        }
  return hands;
}

}  // namespace

Expected<Result> benchPassivity(const Bench& bench) {
  Result r(SceneId::kPassivity, "a simulated device pressed on a block that does not give way, 1.8 s, all hands");
  KERF_TRY(block, practiceBlock({4, 4, 2}, 0.1));
  const ToolModel ball = practiceBall(0.5, 840);
  // Bounds of the literature for b = 0.5 N s/m, one tick of delay: K <= 0.33 N/mm; and K <= 2 f / encoder step. A
  // device without friction never meets the second bound: its encoder steps make it tremble with any coupling.
  Hands direct;
  int runs = 0;
  for (const double friction : {0.05, 0.0})
    for (const double stiffness : {0.33, 0.7, 1.0, 1.5, 2.0}) {
      const bool also_direct = stiffness == 1.0 && friction > 0;
      KERF_TRY(hands, pressHands(block, ball, stiffness, friction, also_direct, bench));
      if (also_direct) direct = hands;
      runs += hands.runs;
      const std::string what = fmt::format("K {} N/mm, friction {} N", stiffness, friction);
      r.add(what + ": energy given away, worst of 60 hands", hands.energy, "mJ");
      r.add(what + ": trembling", 1000 * hands.trembling, "um");
    }

  r.add("direct rendering: energy given away, worst of 60 hands", direct.direct_energy, "mJ");
  r.add("direct rendering: hands it fails with, of 60", direct.direct_fails);
  r.add("runs", runs);
  return r;
}

namespace {

// The grid. Commercial devices have 0.03 to 0.2 kg at the tip, encoders of 5 to 55 um, some hundredths of a newton of
// friction; hands 0.05 (two fingertips) to 2 N/mm (a fist).
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

// Highest passive stiffness of a sampled wall, N/mm: Colgate & Schenkel with a delay (Gil, Hulin), Coulomb friction
// against the encoder steps (Abbott & Okamura 2005).
double boundOf(const Numbers& n) {
  const double late = (0.5 + n[kDelay]) * kTick;
  return std::min({2 * n[kDamping] / kTick, n[kDamping] / late, 2 * n[kFriction] / n[kEncoder]});
}

Press pressOf(const Numbers& n, const std::shared_ptr<const BakedObject>& block, const ToolModel& ball) {
  DeviceHand::Options options;
  options.friction = n[kFriction];
  options.encoder_mm = n[kEncoder];
  options.mass_kg = n[kMass];
  options.delay_ticks = static_cast<int>(n[kDelay]);
  options.damping = n[kDamping];
  options.hand_stiffness = n[kHand];
  options.hand_damping = n[kHandDamping];
  return press(modelOf(ball, Rendering::kCoupled, n[kStiffness]), block, options);
}

// Runs are independent: the numbers are the same on any number of threads.
Expected<std::vector<Press>> pressGrid(std::size_t runs, const Bench& bench) {
  KERF_TRY(block, practiceBlock({4, 4, 2}, 0.1));
  const ToolModel ball = practiceBall(0.5, 840);
  std::vector<Press> presses(runs);
  constexpr std::size_t kBatch = 256;
  for (std::size_t begin = 0; begin < runs; begin += kBatch) {
    if (!report(bench.progress, static_cast<double>(begin) / static_cast<double>(runs), "hands")) return cancelled();
    tbb::parallel_for(begin, std::min(runs, begin + kBatch), [&](std::size_t run) {
      std::array<std::size_t, kAxes> at;
      presses[run] = pressOf(numbersOf(run, at), block, ball);
    });
  }
  return presses;
}

// A subset of the runs, and its results.
struct Share {
  std::size_t runs = 0, given = 0;
  double energy = 0;              // maximum, mJ
  std::vector<double> trembling;  // um

  void add(const Press& p) {
    ++runs;
    given += p.energy > 0;
    energy = std::max(energy, p.energy);
    trembling.push_back(1000 * p.trembling);
  }
  void addTo(Result& r, const std::string& name) const {
    if (runs == 0) return;
    r.add(name + ": runs", static_cast<double>(runs));
    r.add(name + ": given energy", static_cast<double>(given));
    r.add(name + ": most energy", energy, "mJ");
    r.add(name + ": trembling, p50", percentile(trembling, 0.5), "um");
    r.add(name + ": trembling, p95", percentile(trembling, 0.95), "um");
    r.add(name + ": trembling, most", percentile(trembling, 1), "um");
  }
};

constexpr double kNone = std::numeric_limits<double>::infinity();

struct Shares {
  Share all, within, twice;
  std::vector<std::vector<Share>> by{kAxes};  // by axis and value
  Share of_default[4];                        // K = 1 N/mm, by friction
  // By friction: the lowest stiffness at which a device gained energy.
  std::array<double, 4> least_stiffness{kNone, kNone, kNone, kNone};
  std::uint64_t hash = 0;

  Shares() {
    for (std::size_t axis = 0; axis < kAxes; ++axis) by[axis].resize(grid()[axis].values.size());
  }
  void add(std::size_t run, const Press& p);
};

void Shares::add(std::size_t run, const Press& p) {
  std::array<std::size_t, kAxes> at;
  const Numbers n = numbersOf(run, at);
  all.add(p);
  for (std::size_t axis = 0; axis < kAxes; ++axis) by[axis][at[axis]].add(p);
  if (p.energy > 0) least_stiffness[at[kFriction]] = std::min(least_stiffness[at[kFriction]], n[kStiffness]);
  const double bound = boundOf(n);
  if (n[kStiffness] <= bound)
    within.add(p);
  else if (n[kStiffness] <= 2 * bound)
    twice.add(p);
  if (n[kStiffness] == 1) of_default[at[kFriction]].add(p);
  hash = hash * 0x100000001b3ull ^ std::bit_cast<std::uint64_t>(std::max(0.0, p.energy)) ^
         std::rotl(std::bit_cast<std::uint64_t>(p.trembling), 32);
}

}  // namespace

Expected<Result> benchPassivityLarge(const Bench& bench) {
  std::size_t runs = 1;
  for (const Axis& axis : grid()) runs *= axis.values.size();
  Result r(SceneId::kPassivityLarge,
           fmt::format("{} devices, hands and stiffnesses, all of a grid, pressed on a block for 1.8 s", runs));
  KERF_TRY(presses, pressGrid(runs, bench));
  Shares shares;
  for (std::size_t run = 0; run < runs; ++run) shares.add(run, presses[run]);

  const std::vector<double>& frictions = grid()[kFriction].values;
  shares.within.addTo(r, "K within the bounds of the literature");
  shares.twice.addTo(r, "K up to twice these bounds");
  for (std::size_t f = 0; f < 4; ++f)
    shares.of_default[f].addTo(r, fmt::format("K 1 N/mm (the default), friction {} N", frictions[f]));
  shares.all.addTo(r, "all");

  for (std::size_t f = 0; f < 4; ++f)
    if (shares.least_stiffness[f] < kNone)
      r.add(fmt::format("least K that gave energy, friction {} N", frictions[f]), shares.least_stiffness[f], "N/mm");
  for (std::size_t axis = 0; axis < kAxes; ++axis)
    for (std::size_t v = 0; v < shares.by[axis].size(); ++v) {
      const Share& share = shares.by[axis][v];
      r.add(fmt::format("given energy with {} {} {}, of {}", grid()[axis].name, grid()[axis].values[v],
                        grid()[axis].unit, share.runs),
            static_cast<double>(share.given));
    }
  r.state_hash = fmt::format("{:016x}", shares.hash);
  return r;
}

}  // namespace kerf::cli
