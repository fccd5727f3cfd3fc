// Forces on the hand by material, tool and feed, against the laws in closed form. Numbers, not times.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "bench/bench.h"
#include "bench/scenes/feed.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "bench/spread.h"
#include "sim/hand/virtual_hand.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

using namespace scenes;

// A tool pressed straight down into a block with constant force. Means over a range of depth.
struct Plunge {
  double rate = 0, load = 0;  // mm^3/s, N
  std::vector<double> parts;  // removed in each eighth of the time, mm^3
};
Expected<Plunge> plunge(const Model& model, std::shared_ptr<const BakedObject> block, double force, double from,
                        double to) {
  State state;
  state.objects.emplace_back(std::move(block), 8192);
  CutPath path;
  path.poses = {{0, {Eigen::Quaterniond::Identity(), {0.01, 0.02, 0.05}}},
                {1, {Eigen::Quaterniond::Identity(), {0.01, 0.02, -3}}}};
  path.cuts = {1};
  ForceHand::Options push;
  push.force = force;
  ForceHand hand(path, model.settings.coupling, push);
  state.place(poseAt(path, 0));

  StepOutput tick;
  DeviceSample sample;
  Plunge out;
  double seconds = 0;
  std::vector<double> removed;
  while (hand.next(tick, sample)) {
    step(model, state, sample, tick);
    const double depth = -tick.T_world_tool.translation[2];
    if (depth < from || depth > to) continue;
    out.rate += tick.removed_mm3;
    out.load += tick.normal_load * kTick;
    seconds += kTick;
    removed.push_back(tick.removed_mm3);
  }
  if (seconds == 0)
    return brokenScene("a plunge", fmt::format("never {} mm deep with {} N", from, force), "to get there");
  out.rate /= seconds;
  out.load /= seconds;
  const std::size_t ticks = removed.size() / 8;
  for (std::size_t n = 0; n < 8 && ticks > 0; ++n) {
    const auto begin = removed.begin() + static_cast<std::ptrdiff_t>(n * ticks);
    out.parts.push_back(std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(ticks), 0.0));
  }
  return out;
}

// Constant force: removal rates of a round bur plunged into each material. Its drive holds its speed; a turbine would
// slow down with the depth of the hole.
Expected<void> plungeIntoMaterials(Result& r, const Bench& bench) {
  KERF_TRY(bur, toolOfRack("round-014"));
  bur.drive.handpiece = findHandpiece("electric");
  KERF_TRY(model, makeModel(std::span(&bur, 1)));
  model.settings.coupling.stiffness = ForceHand::kStiffness;
  KERF_TRY(table, readDefaultMaterials());
  std::map<std::string, double> rates;  // mm^3/s per N
  // Light force in soft materials, so that every plunge lasts some seconds.
  for (const auto& [id, force] :
       {std::pair("enamel", 3.0), std::pair("dentin", 1.0), std::pair("cortical", 1.0), std::pair("cancellous", 0.1)}) {
    if (!report(bench.progress, 0.1, "constant force")) return cancelled();
    KERF_TRY(row, table.require(id));
    KERF_TRY(block, practiceBlock({3, 3, 4}, 0.1, {}, row.material));
    KERF_TRY(pressed, plunge(model, block, force, 1.2, 2.2));
    rates[id] = pressed.rate / force;
    r.add(fmt::format("round 014 in {}", id), rates[id], "mm3/s per N");

    const std::vector<double>& parts = pressed.parts;
    if (!parts.empty()) {
      const auto [low, high] = std::minmax_element(parts.begin(), parts.end());
      r.add(fmt::format("  spread of the rate in {}", id), percentOff(*high, *low), "%");
    }
  }

  // By the law, the rate is proportional to mu / u_s.
  const auto compare = [&](const char* hard, const char* soft) {
    const auto of = [&](const char* id) {
      const MaterialProperties row = *table.require(id);
      return row.friction.value / row.specific_cutting_energy.value;
    };
    const double configured = of(soft) / of(hard), measured = rates[soft] / rates[hard];
    r.add(fmt::format("{} : {} at the same force", soft, hard), measured);
    r.add(fmt::format("  against {:.3g} as configured", configured), std::abs(percentOff(measured, configured)), "%");
  };
  compare("enamel", "dentin");
  compare("cortical", "cancellous");
  return {};
}

// A ball with uniform surface speed, pressed into dentin with eight forces. Removal rate over normal load is a line
// through the origin with slope mu v / u_s.
Expected<void> fitRemoval(Result& r, const Bench& bench) {
  constexpr double kRadius = 0.8, kSpeed = 840;
  Model model;
  model.tools = {practiceBall(kRadius, kSpeed)};
  model.settings.coupling.stiffness = ForceHand::kStiffness;
  KERF_TRY(materials, readDefaultMaterials());
  KERF_TRY(tissues, tissueTable(materials));
  model.tissues = tissues;
  KERF_TRY(block, practiceBlock({4, 4, 4}, 0.05, {}, Material::kDentin));
  double nn = 0, nr = 0, rr = 0, sum_n = 0, sum_r = 0;
  int count = 0;
  for (const double force : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0}) {
    if (!report(bench.progress, 0.15, "removal over load")) return cancelled();
    KERF_TRY(pressed, plunge(model, block, force, 1.2, 1.6));
    const double n = pressed.load, rate = pressed.rate;
    nn += n * n;
    nr += n * rate;
    rr += rate * rate;
    sum_n += n;
    sum_r += rate;
    ++count;
  }

  const Tissue& dentin = model.tissues[static_cast<std::size_t>(Material::kDentin)];
  const double slope = nr / nn;
  const double law = static_cast<double>(dentin.friction * dentin.inverse_energy) * kSpeed;
  // R^2 of the least-squares line with intercept.
  const double m = count, sxx = nn - sum_n * sum_n / m, sxy = nr - sum_n * sum_r / m, syy = rr - sum_r * sum_r / m;
  r.add("removal over normal load, 8 forces: slope", slope, "mm3/s per N");
  r.add("  against mu v / u_s", std::abs(percentOff(slope, law)), "%");
  r.add("  1 - R^2", 1 - sxy * sxy / (sxx * syy));
  return {};
}

// The saw's 27 runs: 3 bone densities x 3 feeds x 3 stroke rates, 10 mm wide (J Biomech Eng 2014;136:034501).
constexpr std::array kDensities = {0.8, 0.9, 1.0};                    // relative
constexpr std::array kFeeds = {20, 40, 60};                           // mm/min
constexpr std::array kCycles = {9800, 11200, 12600};                  // per minute
using SawGrid = std::array<std::array<std::array<double, 3>, 3>, 3>;  // N, by density, feed, strokes

struct SawRuns {
  SawGrid force{};
  double error = 0, worst = 0;     // deviation of the thrust from the law, %: mean and maximum
  double jump = 0, turn_jump = 0;  // N, N mm a tick
  Spread ratio;                    // thrust over cutting force
};

// Reference: the law in closed form, with cutting energy as the square of the density: N = u_s V' / (mu v). V' is the
// kerf's volume per second.
Expected<SawRuns> sawBone(Result& r, const Bench& bench) {
  constexpr double kWide = 10;
  KERF_TRY(saw, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(model, makeModel(std::span(&saw, 1)));
  model.settings.rendering = Rendering::kRigid;
  KERF_TRY(block, practiceBlock({kWide, 4, 4}, 0.05, {}, Material::kCortical));
  Tissue& bone = model.tissues[static_cast<std::size_t>(Material::kCortical)];
  const float dense = bone.inverse_energy;

  SawRuns out;
  for (std::size_t d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        if (!report(bench.progress, 0.2 + 0.8 * static_cast<double>(9 * d + 3 * i + j) / 27, "sawing"))
          return cancelled();
        const double mm_per_min = kFeeds[i];
        bone.inverse_energy = dense / static_cast<float>(kDensities[d] * kDensities[d]);
        ToolDrive& drive = model.tools[0].drive;
        drive.speed = meanSpeed(saw.stroke_mm, kCycles[j] / 60.0);
        State state;
        state.objects.emplace_back(block, 8192);
        const Feed f = feed(model, state, {}, {teethDown(), {-12.5, 0.01, 0.05}},
                            {0, 0, -(0.05 + mm_per_min / 60 * 1.2)}, mm_per_min / 60, 0.7);

        // Speed sags under load, as the drive's does. The law uses the actual speed.
        const double speed = drive.speed * std::max(0.0, 1 - f.drag / drive.stall_load);
        const double reference =
            drive.energy_factor * mm_per_min / 60 * kWide * saw.kerfWidth() /
            (static_cast<double>(bone.inverse_energy) * static_cast<double>(bone.friction) * drive.drag_factor * speed);
        const double off = std::abs(percentOff(f.thrust, reference));
        out.force[d][i][j] = f.force;
        out.jump = std::max(out.jump, f.jump);
        out.turn_jump = std::max(out.turn_jump, f.turn_jump);
        out.error += off / 27;
        out.worst = std::max(out.worst, off);
        out.ratio.add(f.thrust / f.drag);
        if (d == 2) r.add(fmt::format("saw, cortical, {} mm/min, {} cycles/min", kFeeds[i], kCycles[j]), f.force, "N");
      }
  return out;
}

// Number of neighbour pairs, of 54, where force fails to grow with density and feed, or to fall with strokes.
int countWrongPairs(const SawGrid& force) {
  int wrong = 0;
  for (std::size_t d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        if (d > 0) wrong += force[d][i][j] <= force[d - 1][i][j];
        if (i > 0) wrong += force[d][i][j] <= force[d][i - 1][j];
        if (j > 0) wrong += force[d][i][j] >= force[d][i][j - 1];
      }
  return wrong;
}

}  // namespace

Expected<Result> benchForces(const Bench& bench) {
  Result r(SceneId::kForces, "force on the hand, by material, tool and feed: training defaults");
  KERF_CHECK(plungeIntoMaterials(r, bench));
  KERF_CHECK(fitRemoval(r, bench));
  KERF_TRY(saw, sawBone(r, bench));

  r.add("saw: pairs of 54 where force does not grow with density and feed, fall with strokes",
        countWrongPairs(saw.force));
  r.add("saw: jump of force per ms", saw.jump, "N");
  r.add("saw: jump of torque about the tip per ms", saw.turn_jump, "N mm");
  r.add("saw: thrust against the law's reference, 27 runs, mean error", saw.error, "%");
  r.add("  the worst of the 27", saw.worst, "%");
  r.add("saw: thrust over cutting force, least", saw.ratio.least);
  r.add("  most over the 27", saw.ratio.most);
  r.add("  out of 1.4 to 1.8 by", std::max({0.0, 1.4 - saw.ratio.least, saw.ratio.most - 1.8}));
  return r;
}

}  // namespace kerf::cli
