// Duration of a tick: the scenes that gate the haptic rate.
#include <fmt/format.h>

#include <cmath>

#include "bench/bench.h"
#include "bench/scenes/objects.h"
#include "bench/scenes/poses.h"
#include "bench/scenes/practice_block.h"
#include "preprocess/demo/demo_anatomy.h"
#include "sim/hand/virtual_hand.h"
#include "sim/live/remesher.h"
#include "sim/run/scene/load_scene.h"

namespace kerf::cli {
namespace {

using namespace scenes;

// @param of  owner of the ticks: a prefix of each name.
void addPercentiles(Result& r, const std::vector<double>& ms, const std::string& of = "") {
  r.add(of + "p50", percentile(ms, 0.5), "ms");
  r.add(of + "p99", percentile(ms, 0.99), "ms");
  r.add(of + "p99.9", percentile(ms, 0.999), "ms");
  r.add(of + "max", percentile(ms, 1), "ms");
}

// Repeats the same deterministic work. The minimum per tick is the program's own time, without load of the machine. The
// first run has the times of a real hand.
constexpr int kRuns = 3;
void keepLeast(std::vector<double>& least, const std::vector<double>& ms) {
  if (least.empty()) least = ms;
  for (std::size_t n = 0; n < std::min(least.size(), ms.size()); ++n) least[n] = std::min(least[n], ms[n]);
}

// Changed bricks on their way to the visible mesh. The session sets the clock: a mesher that is busy when a brick
// changes takes it with its next batch.
struct MeshLatency {
  explicit MeshLatency(const CutObject& object) : remesher(object.baked().phi0()) {}
  void tick(CutObject& object, double at_ms) {
    object.changes(BrickSubscriber::kMesher).take([&](const CutObject::Slot& slot) {
      appendEdit(waiting, slot);
      since.push_back(at_ms);
      return true;
    });
    if (waiting.empty() || at_ms < free_at) return;
    const double start = now();
    remesher.apply(waiting);
    free_at = at_ms + (now() - start);
    for (const double changed : since) latency.push_back(free_at - changed);
    waiting.clear();
    since.clear();
  }
  Remesher remesher;
  std::vector<BrickEdit> waiting;
  std::vector<double> since, latency;
  double free_at = 0;
};

tl::unexpected<Error> differing(const char* scene) {
  return fail({.code = Error::Code::kGeometry,
               .place = scene,
               .found = "two runs of the same ticks that differ",
               .expected = "the same bits",
               .hint = "report this bug"});
}

// Cost and effect of the ticks in contact.
struct Ticks {
  std::vector<double> ms;
  std::vector<double> least_ms;                 // of several runs, tick by tick; empty: only one run
  double touching = 0, tested = 0, bricks = 0;  // sums
  double most_force = 0;                        // N
  std::uint64_t troubled = 0;                   // ticks with a bit in their status
  std::uint64_t hash = 0;

  // @param of  owner of the ticks: a prefix of each name.
  void addCounts(Result& r, const std::string& of = "") const {
    const auto count = static_cast<double>(ms.size());
    r.add(of + "nodes tested a tick", tested / count);
    r.add(of + "nodes touching", touching / count);
    r.add(of + "bricks cut a tick", bricks / count);
    r.add(of + "largest force", most_force, "N");
    r.add(of + "ticks that lacked room", static_cast<double>(troubled));
  }
  void addTo(Result& r) const {
    r.ms = ms;
    r.state_hash = fmt::format("{:016x}", hash);
    addCounts(r);
  }
};

// Ticks of a hand until its path ends, each timed.
Expected<Ticks> timeTicks(const Model& model, State& state, VirtualHand& hand, const Bench& bench,
                          MeshLatency* mesh = nullptr) {
  StepOutput out;
  out.T_world_tool = state.body.pose;
  DeviceSample sample;
  Ticks ticks;
  for (std::uint64_t n = 0; hand.next(out, sample); ++n) {
    if (n % 256 == 0 && !report(bench.progress, hand.progress(), "cutting")) return cancelled();
    reserveForTicks(state.objects[0]);
    const double start = now();
    step(model, state, sample, out);
    const double took = now() - start;
    if (mesh) mesh->tick(state.objects[0], static_cast<double>(n + 1) * 1e3 * kTick);

    ticks.troubled += (out.status & (kStepBricksRanOut | kStepNearRanOut | kStepBadSample)) != 0;
    if (out.touching == 0) continue;
    ticks.ms.push_back(took);
    ticks.touching += out.touching;
    ticks.tested += out.tested;
    ticks.bricks += out.bricks_cut;
    ticks.most_force = std::max(ticks.most_force, out.contact.force.norm());
  }
  if (ticks.ms.empty()) return brokenScene("ticks", "the tool met nothing", "contact");
  ticks.hash = state.hash();
  return ticks;
}

// A tool goes straight down into the middle of a block: first without resistance, then timed.
struct Sinking {
  Rigid3 start;      // of the tool: it touches the block's top
  double depth = 0;  // mm, without resistance
  double feed = 0;   // mm/s, then
  double seconds = 2;
};
Expected<Ticks> timeSinkingOnce(const std::shared_ptr<const BakedObject>& block, Model& model, const Sinking& sinking,
                                const Bench& bench) {
  const auto lowered = [&](double by) {
    Rigid3 pose = sinking.start;
    pose.translation[2] -= by;
    return pose;
  };
  State state;
  state.objects.emplace_back(block, 8192);
  model.settings.rendering = Rendering::kRigid;

  model.settings.geometry_only = true;
  state.place(lowered(-0.1));
  StepOutput out;
  for (int n = 0; n <= 600; ++n) {
    reserveForTicks(state.objects[0]);
    step(model, state, sampleAt(lowered(-0.1 + n * (sinking.depth + 0.1) / 600), 0), out);
  }

  model.settings.geometry_only = false;
  CutPath path;
  path.poses = {{0, lowered(sinking.depth)},
                {sinking.seconds, lowered(sinking.depth + sinking.seconds * sinking.feed)}};
  path.cuts = {1};
  FeedHand hand(path);
  return timeTicks(model, state, hand, bench);
}
Expected<Ticks> timeSinking(const std::shared_ptr<const BakedObject>& block, Model& model, const Sinking& sinking,
                            const Bench& bench) {
  KERF_TRY(ticks, timeSinkingOnce(block, model, sinking, bench));
  ticks.least_ms = ticks.ms;
  for (int run = 1; run < kRuns; ++run) {
    KERF_TRY(again, timeSinkingOnce(block, model, sinking, bench));
    if (again.hash != ticks.hash) return differing("tick-fine");
    keepLeast(ticks.least_ms, again.ms);
  }
  return ticks;
}

// A plate of `side` x `side` x 3 mm. Its lowest millimetre cuts.
ToolModel plateOf(double side) {
  Box3 box;
  box.add(Vec3d(-side / 2, -side / 2, 0));
  box.add(Vec3d(side / 2, side / 2, 3));
  const ToolFieldOptions options;
  ToolModel plate;
  plate.id = "plate";
  plate.cut = ToolField(BoxShape(box), options);
  box.min[2] = 1;
  plate.body = ToolField(BoxShape(box), options);
  plate.motion = ToolMotion::kStroke;
  plate.drive.speed = 1000;
  plate.finest_mm = 3;
  plate.smallest_radius_mm = 1.5;
  plate.reach_mm = plate.cut.reach();
  return plate;
}

// Contact of a plate with a block a little larger than itself.   @param nominal  node count for scaling the times.
Expected<std::vector<double>> timePoints(Result& r, double side, const char* name, double nominal, const Bench& bench) {
  KERF_TRY(block, practiceBlock({side + 4, side + 4, 1.5}, 0.1));
  KERF_TRY(model, makeModel({}));
  const ToolModel plate = plateOf(side);
  CutObject object(block, 64);
  NearBricks near;
  constexpr int kEvaluations = 3000;
  std::vector<double> ms;  // of all runs
  int tested = 0, touching = 0;
  for (int n = 0; n < kRuns * kEvaluations; ++n) {
    if (n % 256 == 0 && !report(bench.progress, static_cast<double>(n) / (kRuns * kEvaluations), "points"))
      return cancelled();
    object.odometer += 1e6;  // no node sleeps: every node is tested
    ContactInput in;
    in.tool = &plate;
    in.tissues = &model.tissues;
    in.speed = 1000;
    in.cut_share = 1;
    // Tilted, so that about one node in fifty touches.
    in.T_object_tool = turned(0.01, {1, 0.3 * std::sin(0.01 * (n % kEvaluations)), 0}, {0, 0, 0.0049 * side});

    const double start = now();
    near.find(object, plate, in.T_object_tool);
    ContactSums sums;
    sumContact(object, near, in, sums);
    ms.push_back(now() - start);
    tested = sums.tested;
    touching = sums.touching;
  }

  std::vector<double> least;
  for (auto from = ms.begin(); from != ms.end(); from += kEvaluations)
    keepLeast(least, std::vector<double>(from, from + kEvaluations));
  ms.resize(kEvaluations);  // the first run

  const double share = tested / nominal;
  r.add(fmt::format("nodes tested ({})", name), tested);
  r.add(fmt::format("of them touching ({})", name), touching);
  r.add(fmt::format("{} nodes, p50", name), percentile(ms, 0.5) / share, "ms");
  r.add(fmt::format("{} nodes, p99", name), percentile(ms, 0.99) / share, "ms");
  r.add(fmt::format("{} nodes, p99, each one's least of {} runs", name, kRuns), percentile(least, 0.99) / share, "ms");
  r.add(fmt::format("a node, p50 ({})", name), 1e6 * percentile(ms, 0.5) / tested, "ns");
  return ms;
}

// A shoulder along the buccal side, the bur's flank against the enamel; then a plunge into the fossa.
CutPath shoulderAndFossa(const Box3& box) {
  CutPath path;
  double t = 0;
  const auto go = [&](const Vec3d& p, double feed) {
    if (!path.poses.empty()) {
      t += (p - path.poses.back().T_object_tool.translation).norm() / feed;
      path.cuts.push_back(1);
    }
    path.poses.push_back({t, {Eigen::Quaterniond::Identity(), p}});
  };

  const double side = box.max[1] + 0.3;
  go({-3, side, 2}, 1);
  go({-3, side - 0.6, 2}, 1);
  go({3, side - 0.6, 2}, 2);
  go({3, side + 1, 2}, 10);
  go({3, side + 1, 12}, 20);
  go({0, 0, 12}, 20);
  go({0, 0, 8}, 20);
  go({0, 0, 3.5}, 1);
  go({1.5, 0, 3.5}, 1);
  return path;
}

}  // namespace

Expected<Result> benchPoints(const Bench& bench) {
  Result r(SceneId::kPoints,
           "contact of a plate with a block: every node transformed, both fields looked up, forces summed");
  KERF_TRY(small, timePoints(r, 12.9, "50k", 50e3, bench));
  KERF_CHECK(timePoints(r, 25.8, "200k", 200e3, bench));
  r.ms = small;
  return r;
}

Expected<Result> benchTickBur(const Bench& bench) {
  Result r(SceneId::kTickBur,
           "taper 856/016 along the flank of the demo molar at 2 mm/s and into its fossa at 1 mm/s, 0.05 mm voxels");
  KERF_TRY(anatomy, demoMolarAnatomy(1, bench.progress));
  KERF_TRY(folder, bakedDemo(anatomy, 0.05, bench));
  KERF_TRY(object, loadObject(folder));
  KERF_TRY(tool, toolOfRack("856-016"));
  KERF_TRY(model, makeModel(std::span(&tool, 1)));
  model.settings.rendering = Rendering::kRigid;

  const CutPath path = shoulderAndFossa(object->phi0().bounds());
  {
    State state;
    state.objects.emplace_back(object, 8192);
    FeedHand hand(path);
    state.place(poseAt(path, 0));
    KERF_TRY(ticks, timeTicks(model, state, hand, bench));
    ticks.addTo(r);
    addPercentiles(r, r.ms);
  }

  // Repeats with a mesher. The step has its own thread and core, so its ticks are timed without a mesher.
  State again;
  again.objects.emplace_back(object, 8192);
  FeedHand hand(path);
  again.place(poseAt(path, 0));
  MeshLatency mesh(again.objects[0]);
  KERF_TRY(carve, timeTicks(model, again, hand, bench, &mesh));
  if (fmt::format("{:016x}", carve.hash) != r.state_hash) return differing("tick-bur");
  r.add("carve to mesh ready, p50", percentile(mesh.latency, 0.5), "ms");
  r.add("carve to mesh ready, p95", percentile(mesh.latency, 0.95), "ms");
  r.add("carve to mesh ready, max", percentile(mesh.latency, 1), "ms");
  return r;
}

Expected<Result> benchTickSaw(const Bench& bench) {
  Result r(SceneId::kTickSaw, "25 mm blade, 40 mm/min, through the demo mandible behind the molars at 0.1 mm");
  KERF_TRY(anatomy, demoMandible(1, bench.progress));
  KERF_TRY(folder, bakedDemo(anatomy, 0.1, bench));
  KERF_TRY(object, loadObject(folder));
  KERF_TRY(tool, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(model, makeModel(std::span(&tool, 1)));
  model.settings.rendering = Rendering::kRigid;
  State state;
  state.objects.emplace_back(object, 8192);

  // Behind the last molar on the left: the widest stretch of bone.
  const double y = 58;
  const BoneAcross bone = boneAcross(object->phi0(), y, 1);
  if (bone.from == 0) return brokenScene("demo mandible", "no bone where the saw goes", "");
  const Rigid3 start{teethDown(), Vec3d(0.5 * (bone.from + bone.to) - 12.5, y, bone.top + 0.2)};
  const auto lowered = [&](double by) {
    Rigid3 pose = start;
    pose.translation[2] -= by;
    return pose;
  };

  // Down to 6 mm without resistance.
  constexpr double kDeep = 6;
  model.settings.geometry_only = true;
  state.place(start);
  StepOutput out;
  for (int n = 0; n <= 600; ++n) {
    reserveForTicks(state.objects[0]);
    step(model, state, sampleAt(lowered(n * kDeep / 600), 0), out);
  }
  model.settings.geometry_only = false;

  // Then timed at the feed of the literature (J Biomech Eng 2014;136:034501).
  constexpr double kFeed = 40.0 / 60;
  CutPath path;
  path.poses = {{0, lowered(kDeep)}, {4, lowered(kDeep + 4 * kFeed)}};
  path.cuts = {1};
  FeedHand hand(path);
  KERF_TRY(ticks, timeTicks(model, state, hand, bench));
  ticks.addTo(r);
  addPercentiles(r, r.ms);
  return r;
}

Expected<Result> benchTickFine(const Bench& bench) {
  constexpr double kVoxel = 0.05;
  Result r(SceneId::kTickFine,
           "10 mm of a 25 mm blade, 6 mm deep, fed at 40 mm/min, then a ball of 6 mm, 2 mm deep, fed at 0.1 mm/s: in "
           "blocks of cortical bone, 0.05 mm voxels");

  KERF_TRY(saw, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(with_saw, makeModel(std::span(&saw, 1)));
  KERF_TRY(bar, practiceBlock({10, 4, 9}, kVoxel, {}, Material::kCortical));
  const Rigid3 across{teethDown(), Vec3d(-12.5, 0, 0)};
  KERF_TRY(blade, timeSinking(bar, with_saw, {.start = across, .depth = 6, .feed = 40.0 / 60}, bench));

  KERF_TRY(with_ball, makeModel({}));
  with_ball.tools = {practiceBall(3, 840)};
  KERF_TRY(block, practiceBlock({8, 8, 4}, kVoxel, {}, Material::kCortical));
  KERF_TRY(ball, timeSinking(block, with_ball, {.start = {}, .depth = 2, .feed = 0.1}, bench));

  r.ms = blade.ms;
  r.state_hash = fmt::format("{:016x}", blade.hash ^ ball.hash);
  const std::pair<const char*, const Ticks*> both[] = {{"blade: ", &blade}, {"ball: ", &ball}};
  for (const auto& [of, ticks] : both) {
    ticks->addCounts(r, of);
    addPercentiles(r, ticks->ms, of);
    r.add(fmt::format("{}p99.9, each tick's least of {} runs", of, kRuns), percentile(ticks->least_ms, 0.999), "ms");
  }
  return r;
}

Expected<Result> benchTickSizes(const Bench& bench) {
  Result r(SceneId::kTickSizes, "a ball of 1.6 mm in a slot, the block ever larger");
  KERF_TRY(tool, toolOfRack("round-016"));
  KERF_TRY(model, makeModel(std::span(&tool, 1)));
  model.settings.rendering = Rendering::kRigid;
  CutPath path;
  path.poses = {{0, {Eigen::Quaterniond::Identity(), {-1, 0, -0.6}}},
                {1.5, {Eigen::Quaterniond::Identity(), {2, 0, -0.6}}}};
  path.cuts = {1};

  double first = 0;
  for (const double size : {6.0, 12.0, 24.0}) {
    KERF_TRY(block, practiceBlock({size, size, size / 2}, 0.05));
    State state;
    state.objects.emplace_back(block, 8192);
    FeedHand hand(path);
    state.place(poseAt(path, 0));
    KERF_TRY(ticks, timeTicks(model, state, hand, bench));

    const double p50 = percentile(ticks.ms, 0.5);
    if (first == 0) {
      first = p50;
      r.ms = ticks.ms;
      r.state_hash = fmt::format("{:016x}", ticks.hash);
    }
    r.add(fmt::format("{} bricks: p50", block->slots().size()), p50, "ms");
    r.add(fmt::format("{} bricks: over the smallest", block->slots().size()), p50 / first);
  }
  return r;
}

}  // namespace kerf::cli
