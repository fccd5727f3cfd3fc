// Whether a tool at rest sinks into a material harder than a hand: every tool of the rack, and one from a mesh.
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <fstream>
#include <limits>
#include <thread>

#include "bench/bench.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "bench/scenes/sink.h"
#include "bench/spread.h"
#include "geometry/formats/mesh_writer.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

using namespace scenes;

constexpr double kVoxels[] = {0.1, 0.05};     // mm
constexpr double kWalls[] = {0, 0.3, 0.5};    // mm; 0: a solid block
constexpr double kLeans[] = {0, 0.21, 0.44};  // rad, tilt of the tool, one for each attitude of the block
constexpr std::size_t kAttitudes = std::size(kLeans);
constexpr double kLeastWorkNoted = 0.95, kWorkNoted = 1.25, kVoxelNoted = 5;  // %, of the voxels
constexpr double kLeastDug = 0.002;  // mm^3: smaller volumes say little about a law
constexpr double kThinPoint = 0.2;   // mm across, 0.3 mm behind the tip

// All motions against the solid, some also against walls. A slow motion gives yielding contacts the time to yield.
struct Motion {
  const char* name;
  double hand_mm, speed;  // end of the hand's path beyond the surface, mm; its speed, mm/s
  bool at_walls;
};
constexpr Motion kMotions[] = {{"hand 4 mm beyond", 4, 20, false}, {"hand 8 mm beyond", 8, 20, true},
                               {"tap of 0.1 m/s", 2, 100, false},  {"tap of 0.5 m/s", 2, 500, true},
                               {"tap of 1 m/s", 2, 1000, true},    {"hand 8 mm beyond, slowly", 8, 4, false}};
constexpr std::size_t kMost = std::size(kMotions);

Rigid3 attitudeOf(std::size_t n) {
  const double at = static_cast<double>(n);
  return n == 0
             ? Rigid3{}
             : turned(0.53 * at, {std::sin(2 * at + 1), std::cos(3 * at), 0.4}, {0.017 * at, -0.034 * at, 0.008 * at});
}

// Results for enamel with the drive off hold for tissues as stiff and as rough.
Expected<void> checkTissues(const TissueTable& tissues) {
  const Tissue& enamel = tissues[static_cast<std::size_t>(Material::kEnamel)];
  for (const Material other : {Material::kDentin, Material::kCortical}) {
    const Tissue& tissue = tissues[static_cast<std::size_t>(other)];
    if (tissue.stiffness != enamel.stiffness || tissue.friction != enamel.friction)
      return brokenScene("tissues", "dentin or cortical bone unlike enamel in stiffness or friction",
                         "the same, or a scene for each");
  }
  return {};
}

// One tool in one direction.
struct Approach {
  std::string name;
  const ToolModel* tool;
  Vec3d first;  // leading direction, tool frame, unit
  double across = 0;
};

// Result of one approach.
struct Tally {
  int runs = 0, digs = 0, judged = 0, too_deep = 0, passed = 0, at_walls = 0;
  int aim_too_deep = 0, aim_passed = 0;  // by a tap of 1 m/s
  int paid_too_much = 0;
  double fall = 0;                         // N
  double least_force = 1;                  // at the end, over that of the hand's spring
  std::array<double, kMost> deepest{};     // mm
  double least_work = 1e9, most_work = 0;  // over the law's energy for the volume
  double voxel_effect = 0;                 // %, of the removed volume
  std::uint64_t hash = 0;
};

using Blocks = std::array<std::array<std::array<std::shared_ptr<const BakedObject>, kAttitudes>, std::size(kWalls)>,
                          std::size(kVoxels)>;

Expected<Blocks> makeBlocks() {
  Blocks blocks;
  for (std::size_t v = 0; v < std::size(kVoxels); ++v)
    for (std::size_t w = 0; w < std::size(kWalls); ++w)
      for (std::size_t n = 0; n < kAttitudes; ++n) {
        const Vec3d size(6, 6, kWalls[w] > 0 ? kWalls[w] : 5);
        KERF_TRY(block, practiceBlock(size, kVoxels[v], attitudeOf(n), Material::kEnamel));
        blocks[v][w][n] = block;
      }
  return blocks;
}

// Removal has to match the work for any tool: constant forces, two voxels. Drills follow their own law: their lips pay
// for a chip by its thickness.
void digAll(const Approach& approach, const Model& model, std::size_t tool, const Blocks& blocks, Tally& tally) {
  if (model.tools[tool].lips.height > 0) return;
  const ToolDrive& drive = model.tools[tool].drive;
  const Tissue& tissue = model.tissues[static_cast<std::size_t>(Material::kEnamel)];
  for (const double force : {0.5, 1.0, 3.0}) {
    std::array<double, std::size(kVoxels)> rate{};
    for (std::size_t v = 0; v < std::size(kVoxels); ++v) {
      SinkScene scene;
      scene.object = blocks[v][0][1];
      scene.frame = attitudeOf(1);
      scene.first = approach.first;
      scene.lean = 0.1;
      const Dig dug = dig(model, tool, scene, force, 0.25);
      ++tally.digs;
      tally.hash = tally.hash * 0x100000001b3ull ^ std::bit_cast<std::uint64_t>(dug.removed);
      rate[v] = dug.removed / std::max(dug.seconds, kTick);
      if (dug.removed < kLeastDug) continue;
      ++tally.judged;
      const double paid = dug.work * static_cast<double>(tissue.inverse_energy) / drive.energy_factor;
      tally.paid_too_much += dug.removed < kLeastWorkNoted * paid;
      tally.least_work = std::min(tally.least_work, dug.removed / paid);
      tally.most_work = std::max(tally.most_work, dug.removed / paid);
    }
    if (std::min(rate[0], rate[1]) * 0.25 > kLeastDug)
      tally.voxel_effect = std::max(tally.voxel_effect, std::abs(percentOff(rate[0], rate[1])));
  }
}

// Depth by motion, voxel and attitude, mm.
using Depths = std::array<std::array<std::array<double, kAttitudes>, std::size(kVoxels)>, kMost>;

// @param ball  depths of a ball of 1 mm; null: no judgement.
Tally tryAll(const Approach& approach, const Model& model, std::size_t tool, const Blocks& blocks, const Depths* ball,
             Depths* out) {
  Tally tally;
  const double least = approach.across < kThinPoint ? 0.6 : 0.3;
  for (std::size_t m = 0; m < kMost; ++m)
    for (std::size_t v = 0; v < std::size(kVoxels); ++v)
      for (std::size_t w = 0; w < std::size(kWalls); ++w) {
        if (w > 0 && !kMotions[m].at_walls) continue;
        for (std::size_t n = 0; n < kAttitudes; ++n) {
          SinkScene scene;
          scene.object = blocks[v][w][n];
          scene.frame = attitudeOf(n);
          scene.first = approach.first;
          scene.lean = kLeans[n];
          scene.hand_mm = kMotions[m].hand_mm;
          scene.speed = kMotions[m].speed;
          const Sink sunk = sink(model, tool, scene);
          ++tally.runs;
          tally.hash = tally.hash * 0x100000001b3ull ^ sunk.state;
          const bool is_aim = kMotions[m].speed > 500;
          if (w > 0) {
            const bool passed = sunk.deepest > kWalls[w] + 0.4;
            tally.at_walls += !is_aim;
            (is_aim ? tally.aim_passed : tally.passed) += passed;
            continue;
          }
          if (out) (*out)[m][v][n] = sunk.deepest;
          const double allowed = ball ? std::max(least, 2 * (*ball)[m][v][n]) : 1e9;
          (is_aim ? tally.aim_too_deep : tally.too_deep) += sunk.deepest > allowed;
          if (!(sunk.deepest >= 0 && sunk.deepest < 100)) ++tally.too_deep;  // true for NaN too
          if (kMotions[m].speed < 100) {
            const double wanted = std::min(kMotions[m].hand_mm - sunk.deepest, model.settings.coupling.force_limit);
            tally.least_force = std::min(tally.least_force, sunk.force / wanted);
          }
          if (kMotions[m].speed < 100) tally.fall = std::max(tally.fall, sunk.fall);
          tally.deepest[m] = std::max(tally.deepest[m], sunk.deepest);
        }
      }
  return tally;
}

// A four-sided spike of that length (mm), 0.2 mm across at its end and 1.2 mm at the shank, as a closed mesh. Its lower
// part cuts.
Expected<Tool> meshSpike(const Bench& bench, double length) {
  Mesh spike;
  for (const auto& [half, height] : {std::pair(0.1, 0.0), std::pair(0.6, length)})
    for (const auto& [x, y] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
      spike.vertices.push_back({half * x, half * y, height});
  spike.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}};
  for (std::uint32_t n = 0; n < 4; ++n) {
    const std::uint32_t next = (n + 1) % 4;
    spike.triangles.push_back({n, next, next + 4});
    spike.triangles.push_back({n, next + 4, n + 4});
  }

  const std::filesystem::path folder = bench.scratch.path() / "mesh-tool";
  std::filesystem::create_directories(folder);
  KERF_CHECK(writeMesh(folder / "spike.ply", spike));
  const std::filesystem::path file = folder / "mesh-spike.toml";
  std::ofstream(file) << "format = \"kerf-tool\"\nversion = 1\nid = \"mesh-spike\"\nname = \"Spike of a mesh\"\n"
                         "kind = \"mesh\"\nmesh = \"spike.ply\"\nmm_per_unit = 1\ntip = [0, 0, 0]\n"
                         "axis = [0, 0, 1]\ncut_below = 6\n";
  return readTool(file);
}

}  // namespace

Expected<Result> benchSink(const Bench& bench) {
  Result r(
      SceneId::kSink,
      "a hand pushes and taps every tool, its drive off, into enamel (dentin and cortical bone: the same), 0.1 and "
      "0.05 mm voxels, three attitudes; then pushes it while it cuts, its drive holding its speed");
  KERF_TRY(blocks, makeBlocks());

  StepSettings at_once;
  at_once.ramp_s = 0;  // no fade-in: a rising force would hide a falling one
  KERF_TRY(plain, makeModel({}, at_once));
  KERF_CHECK(checkTissues(plain.tissues));
  Model ball;
  ball.tools = {practiceBall(0.5, 0)};
  ball.settings = at_once;
  ball.tissues = plain.tissues;
  Depths ball_depths{};
  tryAll({"ball of 1 mm", &ball.tools[0], -Vec3d::UnitZ(), 1}, ball, 0, blocks, nullptr, &ball_depths);

  KERF_TRY(tools, wholeRack());
  for (const double length : {10.0, 14.0}) {
    KERF_TRY(drawn, meshSpike(bench, length));
    drawn.id += fmt::format("-{:g}", length);
    tools.push_back(drawn);
  }
  KERF_TRY(model, makeModel(tools, at_once));
  Model steady = model;  // drives that hold their speed: compares the law of removal, not a stall
  for (ToolModel& tool : steady.tools) tool.drive.stall_load = 0;

  std::vector<Approach> approaches;
  std::vector<std::size_t> which;
  for (std::size_t t = 0; t < tools.size(); ++t) {
    const ToolModel& tool = model.tools[t];
    const auto add = [&](const char* how, const Vec3d& first) {
      approaches.push_back({tools[t].id + how, &tool, first, widthBehind(tool, first, 0.3)});
      which.push_back(t);
    };
    if (tools[t].kind == ToolKind::kBlade) add(", teeth first", tools[t].plunge_direction);
    if (tools[t].kind != ToolKind::kBlade || tools[t].plunge_direction[2] > -0.9)
      add(tools[t].kind == ToolKind::kBlade ? ", end first" : "", -Vec3d::UnitZ());
  }

  std::vector<Tally> tallies(approaches.size());
  std::atomic<std::size_t> done{0};
  std::atomic<bool> is_cancelled{false};
  const std::thread::id here = std::this_thread::get_id();  // only this one reports
  tbb::parallel_for(std::size_t{0}, approaches.size(), [&](std::size_t n) {
    if (is_cancelled) return;
    const double share = static_cast<double>(done) / static_cast<double>(approaches.size());
    if (std::this_thread::get_id() == here && !report(bench.progress, share, "tools")) is_cancelled = true;
    tallies[n] = tryAll(approaches[n], model, which[n], blocks, &ball_depths, nullptr);
    digAll(approaches[n], steady, which[n], blocks, tallies[n]);
    ++done;
  });
  if (is_cancelled) return cancelled();

  Tally all;
  std::uint64_t hash = 0;
  std::string off;  // tools with another removal law
  for (std::size_t n = 0; n < tallies.size(); ++n) {
    const Tally& t = tallies[n];
    hash = hash * 0x100000001b3ull ^ t.hash;
    all.runs += t.runs;
    all.digs += t.digs;
    all.judged += t.judged;
    all.paid_too_much += t.paid_too_much;
    all.least_force = std::min(all.least_force, t.least_force);
    all.least_work = std::min(all.least_work, t.least_work);
    all.most_work = std::max(all.most_work, t.most_work);
    all.voxel_effect = std::max(all.voxel_effect, t.voxel_effect);
    all.at_walls += t.at_walls;
    all.too_deep += t.too_deep;
    all.passed += t.passed;
    all.aim_too_deep += t.aim_too_deep;
    all.aim_passed += t.aim_passed;
    all.fall = std::max(all.fall, t.fall);
    for (std::size_t m = 0; m < kMost; ++m) {
      all.deepest[m] = std::max(all.deepest[m], t.deepest[m]);
    }
    if (t.least_work < kLeastWorkNoted || t.most_work > kWorkNoted || t.voxel_effect > kVoxelNoted)
      off += fmt::format("{}{} ({:.2f} to {:.2f}, {:.0f} %)", off.empty() ? "" : ", ", approaches[n].name, t.least_work,
                         t.most_work, t.voxel_effect);
    if (t.too_deep + t.passed + t.aim_too_deep + t.aim_passed > 0 || t.fall > 0.05)
      r.notes.push_back(
          fmt::format("{} ({:.2f} mm): too deep {} (+{} at 1 m/s), walls passed {} (+{}), deepest {:.2f} {:.2f} {:.2f} "
                      "{:.2f} {:.2f}, force falls by {:.2f} N",
                      approaches[n].name, approaches[n].across, t.too_deep, t.aim_too_deep, t.passed, t.aim_passed,
                      t.deepest[0], t.deepest[1], t.deepest[2], t.deepest[3], t.deepest[4], t.fall));
  }
  if (!off.empty()) r.notes.push_back("removal over work, and between voxels, where off by more than a little: " + off);
  r.add("tools", static_cast<double>(tools.size()));
  r.add("runs", all.runs);
  r.add("too deep in the solid", all.too_deep);
  r.add("walls passed, of " + std::to_string(all.at_walls), all.passed);
  r.add("too deep in the solid, 1 m/s", all.aim_too_deep);
  r.add("walls passed, 1 m/s", all.aim_passed);
  r.add("force falls with depth by, most", all.fall, "N");
  r.add("force at the end over the spring's, least", all.least_force);
  r.add("cutting: runs", all.digs);
  r.add("cutting: runs that removed enough to judge", all.judged);
  r.add("cutting: removal over what the work pays for, least", all.least_work);
  r.add("cutting: runs that removed less than 0.95 of that", all.paid_too_much);
  r.add("cutting: removal over what the work pays for, most", all.most_work);
  r.add("cutting: removal, 0.1 mm against 0.05 mm voxels", all.voxel_effect, "%");
  for (std::size_t m = 0; m < kMost; ++m) r.add(fmt::format("deepest, {}", kMotions[m].name), all.deepest[m], "mm");
  r.state_hash = fmt::format("{:016x}", hash);
  return r;
}

}  // namespace kerf::cli
