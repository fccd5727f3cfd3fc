// Implant drills: feed under a hand, time per site, thrust by diameter and density. Machine-independent numbers, no
// times.
#include <fmt/format.h>

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <vector>

#include "bench/bench.h"
#include "bench/scenes/feed.h"
#include "bench/scenes/hold.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "bench/spread.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

using namespace scenes;

constexpr double kVoxel = 0.1;
constexpr std::array kDiameters{2.0, 2.8, 3.5, 4.2};  // mm
constexpr double kSlow = 800, kFast = 1500;           // rpm
constexpr double kDeep = 10;                          // mm, depth of a site at full width
constexpr double kPlate = 2;                          // mm of cortical bone over cancellous

double speedOf(double rpm) { return rpm * 2 * std::numbers::pi / 60; }

// ---- Drills

// The rack ends at 3.5 mm. The widest drill here is that drill, enlarged.
Expected<Tool> drillOf(double diameter, const Bench& bench) {
  const std::string id = fmt::format("drill-{:02.0f}", 10 * diameter);
  if (diameter < 4) return toolOfRack(id);
  const std::filesystem::path file = bench.scratch.path() / (id + ".toml");
  std::ofstream(file) << fmt::format(
      "format = \"kerf-tool\"\nversion = 1\nid = \"{}\"\nname = \"Twist drill {}\"\nkind = \"bur\"\nshape = \"drill\"\n"
      "head_diameter = {}\nhead_length = 16.0\npoint_angle = 120.0\ncuts = [\"end\"]\n",
      id, diameter, diameter);
  return readTool(file);
}

Expected<Model> allDrills(const Bench& bench) {
  std::vector<Tool> drills;
  for (const double diameter : kDiameters) {
    KERF_TRY(drill, drillOf(diameter, bench));
    drills.push_back(drill);
  }
  KERF_TRY(model, makeModel(drills));
  model.settings.coupling.force_limit = 40;  // an arm, not a device
  for (ToolModel& tool : model.tools) tool.drive.speed = speedOf(kSlow);
  return model;
}

// ---- Feed under a hand

// Feed by DrillLips with the whole point in bone. mm/s
double feedByLaw(double diameter, double rpm, double force, double hardness) {
  const double per_feed = DrillLips::kThrust * std::pow(diameter, 1.25) * hardness;
  const double a_turn = std::clamp(force / per_feed - DrillLips::kRubbing, 0.0, DrillLips::kMostFeed * diameter);
  return a_turn * rpm / 60;
}

// The pilot drill under a constant force.   @return mm/s, after its point has entered.
Expected<double> pressPilot(Result& r, const Model& drills, Material material, double rpm, double force) {
  Model model = drills;
  model.tools.resize(1);
  model.tools[0].drive.speed = speedOf(rpm);
  HoldScene scene;
  KERF_TRY(block, practiceBlock({5, 5, 9}, kVoxel, {}, material));
  scene.object = block;
  scene.start = {Eigen::Quaterniond::Identity(), {0.011, 0.013, 0}};
  scene.force = force;
  scene.seconds = 3;
  scene.settle = 1.5;
  const double feed = hold(model, scene).feed;

  const bool is_cortical = material == Material::kCortical;
  const Tissue& bone = model.tissues[static_cast<std::size_t>(material)];
  const double hardness = std::pow(DrillLips::kReference * static_cast<double>(bone.inverse_energy), -0.75);
  const double law = feedByLaw(kDiameters[0], rpm, force, hardness);
  const std::string name =
      fmt::format("2.0 mm, {} N, {}, {} rpm: feed", force, is_cortical ? "cortical" : "cancellous", rpm);
  if (rpm == kSlow)
    r.addWithin(name, feed, is_cortical ? 0.5 : 0.8, is_cortical ? 1 : 3, "mm/s");
  else
    r.add(name, feed, "mm/s");
  r.add(fmt::format("  off the law's {:.3g} mm/s by", law), std::abs(percentOff(feed, law)), "%");
  return feed;
}

Expected<void> pressPilots(Result& r, const Model& drills, const Bench& bench) {
  if (!report(bench.progress, 0, "feed")) return cancelled();
  KERF_TRY(slow, pressPilot(r, drills, Material::kCortical, kSlow, 10));
  KERF_TRY(fast, pressPilot(r, drills, Material::kCortical, kFast, 10));
  r.addWithin("feed at 1500 over 800 rpm", fast / slow, 1.6, 2.4, "");
  KERF_TRY(soft, pressPilot(r, drills, Material::kCancellous, kSlow, 3));
  r.add("cancellous at 3 N over cortical at 10 N", soft / slow);
  return {};
}

// ---- Sites

// Each site is its own object, with its top at z = 0 and below the plate.
using Bone = std::vector<std::shared_ptr<const BakedObject>>;

Expected<Bone> plateOverCancellous() {
  const Rigid3 below{Eigen::Quaterniond::Identity(), {0, 0, -kPlate}};
  KERF_TRY(plate, practiceBlock({6, 6, kPlate}, kVoxel, {}, Material::kCortical));
  KERF_TRY(sponge, practiceBlock({6, 6, kDeep + 3 - kPlate}, kVoxel, below, Material::kCancellous));
  return Bone{plate, sponge};
}

State freshSite(const Bone& bone) {
  State state;
  for (const auto& object : bone) state.objects.emplace_back(object, 4096);
  return state;
}

// A guided hand pushes straight down with a constant force, from contact of the point with the hole's rim.
// @param hole  mm, width of the existing hole; 0: none.
// @return s until the hole is kDeep at its full width; NaN: not within 20 s.
double drillDown(const Model& model, State& state, std::size_t drill, double force, double hole) {
  constexpr double kLongest = 20;  // s
  const ToolModel& tool = model.tools[drill];
  const double cone = tool.lips.height / tool.equator_mm;
  const Vec3d start(0.011, 0.013, -0.5 * hole * cone);
  state.selectTool(drill);
  state.has_device = false;
  state.place({Eigen::Quaterniond::Identity(), start});
  state.speed = tool.drive.speed;

  const double lead = force / model.settings.coupling.stiffness;
  double depth = -start[2];
  StepOutput tick;
  for (int n = 0; n < static_cast<int>(kLongest / kTick); ++n) {
    step(model, state, sampleAt({Eigen::Quaterniond::Identity(), Vec3d(start[0], start[1], -depth - lead)}), tick);
    for (CutObject& object : state.objects) reserveForTicks(object);
    depth = -tick.T_world_tool.translation[2];
    if (depth >= kDeep + tool.lips.height) return (n + 1) * kTick;
  }
  return std::nan("");
}

Expected<void> drillSites(Result& r, const Model& model, const Bench& bench) {
  KERF_TRY(bone, plateOverCancellous());
  double share = 0.1;
  for (const double force : {8.0, 12.0, 20.0}) {
    if (!report(bench.progress, share, "sites")) return cancelled();
    share += 0.1;
    State site = freshSite(bone);
    double hole = 0, all = 0;
    for (std::size_t d = 0; d < kDiameters.size(); ++d) {
      const double seconds = drillDown(model, site, d, force, hole);
      if (d == 0)
        r.addWithin(fmt::format("2.0 mm, {} N: site of 10 mm", force), seconds, 4, 8, "s");
      else
        r.add(fmt::format("  then {} mm, {} N", kDiameters[d], force), seconds, "s");
      all += seconds;
      hole = kDiameters[d];
    }
    r.addWithin(fmt::format("2.0 to 4.2 mm in turn, {} N: site of 10 mm", force), all, 4, 8, "s");
  }

  // Into solid bone, without a pilot.
  for (std::size_t d = 1; d < kDiameters.size(); ++d)
    for (const double force : {12.0, 20.0}) {
      if (!report(bench.progress, share, "sites")) return cancelled();
      share += 0.05;
      State site = freshSite(bone);
      r.addWithin(fmt::format("{} mm at once, {} N: site of 10 mm", kDiameters[d], force),
                  drillDown(model, site, d, force, 0), 4, 8, "s");
    }
  return {};
}

// ---- Thrust at a fixed feed

struct Thrust {
  double diameter, density, force;
};

// Density classes as fractions of cortical bone. D1 : D4 is 4 : 1.
constexpr std::array kClasses{1.0, 0.75, 0.5, 0.25};

// ln F = c + p ln D + q ln rho by least squares.   @return c, p, q.
Vec3d fitPowers(const std::vector<Thrust>& runs) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Vec3d b = Vec3d::Zero();
  for (const Thrust& run : runs) {
    const Vec3d row(1, std::log(run.diameter), std::log(run.density));
    a += row * row.transpose();
    b += std::log(run.force) * row;
  }
  return a.ldlt().solve(b);
}

Expected<void> feedDrills(Result& r, const Model& drills, const Bench& bench) {
  constexpr double kFeed = 1, kStart = 0.3, kWay = 0.5;  // mm/s; mm below the point's shoulder; mm
  KERF_TRY(block, practiceBlock({6, 6, 5}, kVoxel, {}, Material::kCortical));
  Model model = drills;
  model.settings.rendering = Rendering::kRigid;
  Tissue& bone = model.tissues[static_cast<std::size_t>(Material::kCortical)];
  const Tissue dense = bone;
  // Stiffness from the table: a power law of density through cortical and cancellous bone.
  const Tissue& sponge = model.tissues[static_cast<std::size_t>(Material::kCancellous)];
  KERF_TRY(materials, readDefaultMaterials());
  KERF_TRY(cortical, materials.require("cortical"));
  KERF_TRY(cancellous, materials.require("cancellous"));
  const double stiffening = std::log(static_cast<double>(dense.stiffness / sponge.stiffness)) /
                            std::log(cortical.density.value / cancellous.density.value);

  std::vector<Thrust> runs;
  double off = 0;
  for (std::size_t d = 0; d < kDiameters.size(); ++d)
    for (const double density : kClasses) {
      if (!report(bench.progress, 0.7 + 0.02 * static_cast<double>(runs.size()), "thrust")) return cancelled();
      bone.inverse_energy = dense.inverse_energy / static_cast<float>(density * density);
      bone.stiffness = dense.stiffness * static_cast<float>(std::pow(density, stiffening));

      const ToolModel& tool = model.tools[d];
      State state;
      state.objects.emplace_back(block, 8192);
      state.selectTool(d);
      state.speed = tool.drive.speed;
      const Rigid3 from{Eigen::Quaterniond::Identity(), {0.011, 0.013, -tool.lips.height - kStart}};
      StepOutput tick;
      model.settings.geometry_only = true;
      step(model, state, sampleAt(from), tick);
      model.settings.geometry_only = false;
      const Feed f = feed(model, state, {}, from, {0, 0, -kWay}, kFeed, 0.5);

      const double law = DrillLips::kThrust * std::pow(kDiameters[d], 1.25) *
                         (kFeed / (kSlow / 60) + DrillLips::kRubbing) * std::pow(density, 1.5);
      runs.push_back({kDiameters[d], density, f.thrust});
      r.add(fmt::format("thrust at 1 mm/s, 800 rpm, {} mm, {} of cortical density", kDiameters[d], density), f.thrust,
            "N");
      off = std::max(off, std::abs(percentOff(f.thrust, law)));
    }

  const Vec3d powers = fitPowers(runs);
  r.addWithin("power of the diameter", powers[1], 1.1, 1.5, "");
  r.addWithin("power of the density", powers[2], 1.2, 1.8, "");
  r.add("thrust against the law, the worst of 16", off, "%");
  return {};
}

}  // namespace

Expected<Result> benchDrillSites(const Bench& bench) {
  Result r(SceneId::kDrillSites, "implant drills under a hand and on a feed, 0.1 mm voxels");
  KERF_TRY(drills, allDrills(bench));
  KERF_CHECK(pressPilots(r, drills, bench));
  KERF_CHECK(drillSites(r, drills, bench));
  KERF_CHECK(feedDrills(r, drills, bench));
  return r;
}

}  // namespace kerf::cli
