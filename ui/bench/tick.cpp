// How long a tick takes: the scenes that gate the haptic rate.
#include <fmt/format.h>

#include <cmath>

#include "preprocess/bake/bake.h"
#include "preprocess/demo/demo_anatomy.h"
#include "sim/hand/virtual_hand.h"
#include "sim/live/remesher.h"
#include "sim/run/load_scene.h"
#include "sim/run/practice_block.h"
#include "ui/bench/bench.h"

namespace kerf::cli {
namespace {

namespace fs = std::filesystem;

void addPercentiles(Result& r, double goal_p999) {
  r.measured.push_back({"p50", r.percentile(0.5), "ms", 0, false});
  r.measured.push_back({"p99", r.percentile(0.99), "ms", 0, false});
  r.measured.push_back({"p99.9", r.percentile(0.999), "ms", goal_p999});
  r.measured.push_back({"max", r.percentile(1), "ms", 0, false});
}

// Changed bricks on their way to the visible mesh. The clock is the session's: a mesher that is busy when a brick
// changes takes it with its next batch.
struct MeshLatency {
  explicit MeshLatency(const CutObject& object) : remesher(object.baked().phi0()) {}
  void tick(CutObject& object, double at_ms) {
    object.changes(BrickSubscriber::kMesher).take([&](const CutObject::Slot& slot) {
      BrickEdit& edit = waiting.emplace_back();
      edit.brick = slot.brick;
      std::copy_n(slot.phi, kBrickNodes, edit.phi.begin());
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

// Ticks of a hand until its path ends, each timed.
Expected<void> timeTicks(const Model& model, State& state, VirtualHand& hand, Result& r, const Progress& progress,
                         MeshLatency* mesh = nullptr) {
  StepOutput out;
  out.T_world_tool = state.body.pose;
  DeviceSample sample;
  double touching = 0, tested = 0, bricks = 0, most_force = 0;
  std::uint64_t in_contact = 0, troubled = 0;
  for (std::uint64_t n = 0; hand.next(out, sample); ++n) {
    if (n % 256 == 0 && !report(progress, hand.progress(), "cutting")) return cancelled();
    if (state.objects[0].freeBricks() < 2048) state.objects[0].reserve(4096);
    const double start = now();
    step(model, state, sample, out);
    const double took = now() - start;
    if (mesh) mesh->tick(state.objects[0], static_cast<double>(n + 1) * 1e3 * kTick);
    troubled += (out.status & (kStepBricksRanOut | kStepNearRanOut | kStepBadSample)) != 0;
    if (out.touching == 0) continue;
    r.ms.push_back(took);
    ++in_contact;
    touching += out.touching;
    tested += out.tested;
    bricks += out.bricks_cut;
    most_force = std::max(most_force, out.contact.force.norm());
  }
  if (in_contact == 0)
    return fail({Error::Code::kEmpty, "", r.scene, "the tool met nothing", "contact", "report this"});
  const auto count = static_cast<double>(in_contact);
  r.measured.push_back({"nodes tested a tick", tested / count, "", 0, false});
  r.measured.push_back({"nodes touching", touching / count, "", 0, false});
  r.measured.push_back({"bricks cut a tick", bricks / count, "", 0, false});
  r.measured.push_back({"largest force", most_force, "N", 0, false});
  r.measured.push_back({"ticks that lacked room", static_cast<double>(troubled), "", 0});
  r.state_hash = fmt::format("{:016x}", state.hash());
  return {};
}

}  // namespace

Expected<fs::path> bakedDemo(const DemoAnatomy& anatomy, double voxel, const Scratch& scratch,
                             const Progress& progress) {
  const fs::path folder = scratch.path() / anatomy.name, out = scratch.path() / (anatomy.name + ".case");
  KERF_CHECK(writeDemoAnatomy(anatomy, folder, true));
  BakeOptions options;
  options.overwrite = true;
  options.voxelize.voxel_mm = voxel;
  options.voxel_is_given = true;
  KERF_CHECK(bakeRecipe(folder / anatomy.manifest(), out, options, progress));
  return out;
}

double topAt(const BrickField& phi, double x, double y, const Box3& box) {
  for (double z = box.max[2]; z > box.min[2]; z -= phi.voxel())
    if (phi.sample({x, y, z}) < 0) return z;
  return std::nan("");
}

Expected<Result> benchPoints(const Progress& progress) {
  Result r{"points", "contact of a plate with a block: every node transformed, both fields looked up, forces summed",
           {},       "",
           0,        ""};
  for (const auto& [side, name, goal] : {std::tuple(12.9, "50k", 0.5), std::tuple(25.8, "200k", 0.5)}) {
    constexpr double kVoxel = 0.1;
    KERF_TRY(block, practiceBlock({side + 4, side + 4, 1.5}, kVoxel));
    Tool tool;
    Box3 box;
    box.add(Vec3d(-side / 2, -side / 2, 0));
    box.add(Vec3d(side / 2, side / 2, 3));
    tool.id = "plate";
    tool.cut = std::make_shared<const BoxShape>(box);
    tool.kind = ToolKind::kBlade;
    tool.thickness_mm = 3;
    ToolFieldOptions options;
    ToolModel plate;
    plate.id = tool.id;
    plate.cut = ToolField(*tool.cut, options);
    box.min[2] = 1;
    plate.body = ToolField(BoxShape(box), options);
    plate.motion = ToolMotion::kStroke;
    plate.drive.speed = 1000;
    plate.finest_mm = 3;
    plate.smallest_radius_mm = 1.5;
    plate.reach_mm = plate.cut.reach();
    KERF_TRY(model, makeModel({}));
    CutObject object(block, 64);
    NearBricks near;
    std::vector<double> ms;
    int tested = 0, touching = 0;
    for (int n = 0; n < 3000; ++n) {
      if (n % 256 == 0 && !report(progress, n / 3000.0, "points")) return cancelled();
      object.wake();  // nothing sleeps: every node is tested
      ContactInput in;
      in.tool = &plate;
      in.tissues = &model.tissues;
      in.speed = 1000;
      // Tilted, so that about one node in fifty touches.
      in.T_object_tool = {
          Eigen::Quaterniond(Eigen::AngleAxisd(0.01, Vec3d(1, 0.3 * std::sin(0.01 * n), 0).normalized())),
          Vec3d(0, 0, 0.0049 * side)};
      const double start = now();
      near.find(object, plate, in.T_object_tool);
      ContactSums sums;
      sumContact(object, near, in, sums);
      ms.push_back(now() - start);
      tested = sums.tested;
      touching = sums.touching;
    }
    Result part;
    part.ms = ms;
    const double share = tested / (side > 20 ? 200e3 : 50e3);
    r.measured.push_back({fmt::format("nodes tested ({})", name), static_cast<double>(tested), "", 0, false});
    r.measured.push_back({fmt::format("of them touching ({})", name), static_cast<double>(touching), "", 0, false});
    r.measured.push_back({fmt::format("{} nodes, p50", name), part.percentile(0.5) / share, "ms", 0, false});
    r.measured.push_back({fmt::format("{} nodes, p99", name), part.percentile(0.99) / share, "ms", goal});
    r.measured.push_back({fmt::format("a node, p50 ({})", name), 1e6 * part.percentile(0.5) / tested, "ns", 0, false});
    if (side < 20) r.ms = ms;
  }
  return r;
}

Expected<Result> benchTickBur(const Scratch& scratch, const Progress& progress) {
  Result r{"tick-bur",
           "taper 856/016 along the flank of the demo molar at 2 mm/s and into its fossa at 1 mm/s, 0.05 mm voxels",
           {},
           "",
           0,
           ""};
  KERF_TRY(anatomy, demoMolarAnatomy(1, progress));
  KERF_TRY(folder, bakedDemo(anatomy, 0.05, scratch, progress));
  KERF_TRY(object, loadObject(folder));
  KERF_TRY(tool, toolOfRack("856-016"));
  KERF_TRY(model, makeModel(std::span(&tool, 1)));
  State state;
  state.objects.emplace_back(object, 8192);
  // A shoulder along the buccal side: the bur's flank against the enamel, then a plunge into the fossa.
  const Box3 box = object->phi0().bounds();
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
  model.settings.rendering = Rendering::kRigid;
  {
    FeedHand hand(path);
    state.place(poseAt(path, 0));
    KERF_CHECK(timeTicks(model, state, hand, r, progress));
    addPercentiles(r, 0.8);
  }
  // Once more with a mesher: the step's thread and core are its own, so its ticks are timed without one.
  State again;
  again.objects.emplace_back(object, 8192);
  FeedHand hand(path);
  again.place(poseAt(path, 0));
  MeshLatency mesh(again.objects[0]);
  Result carve = r;
  carve.measured.clear();
  KERF_CHECK(timeTicks(model, again, hand, carve, progress, &mesh));
  if (carve.state_hash != r.state_hash)
    return fail({Error::Code::kGeometry, "", r.scene, "two runs of the same ticks that differ", "the same bits",
                 "report this"});
  carve.ms = std::move(mesh.latency);
  r.measured.push_back({"carve to mesh ready, p50", carve.percentile(0.5), "ms", 0, false});
  r.measured.push_back({"carve to mesh ready, p95", carve.percentile(0.95), "ms", 15});
  r.measured.push_back({"carve to mesh ready, max", carve.percentile(1), "ms", 33});
  return r;
}

Expected<Result> benchTickSaw(const Scratch& scratch, const Progress& progress) {
  Result r{"tick-saw", "25 mm blade, 40 mm/min, through the demo mandible behind the molars at 0.1 mm", {}, "", 0, ""};
  KERF_TRY(anatomy, demoMandible(1, progress));
  KERF_TRY(folder, bakedDemo(anatomy, 0.1, scratch, progress));
  KERF_TRY(object, loadObject(folder));
  KERF_TRY(tool, toolOfRack("saw-reciprocating-25"));
  KERF_TRY(model, makeModel(std::span(&tool, 1)));
  model.settings.rendering = Rendering::kRigid;
  State state;
  state.objects.emplace_back(object, 8192);
  const Box3 box = object->phi0().bounds();
  // Behind the last molar on the left: the widest stretch of bone across.
  const double y = 58;
  double left = 0, right = 0, top = -1e9;
  for (double x = 5; x < box.max[0]; x += 0.5) {
    const double z = topAt(object->phi0(), x, y, box);
    if (std::isnan(z)) continue;
    if (left == 0) left = x;
    right = x;
    top = std::max(top, z);
  }
  if (left == 0)
    return fail({Error::Code::kEmpty, "", "demo mandible", "no bone where the saw goes", "", "report this"});
  // Tool z across the bone, tool x up: the teeth look down.
  Eigen::Matrix3d axes;
  axes.col(0) = Vec3d::UnitZ();
  axes.col(1) = -Vec3d::UnitY();
  axes.col(2) = Vec3d::UnitX();
  const Rigid3 start{Eigen::Quaterniond(axes), Vec3d(0.5 * (left + right) - 12.5, y, top + 0.2)};
  const auto lowered = [&](double by) {
    Rigid3 pose = start;
    pose.translation[2] -= by;
    return pose;
  };
  // Down to 6 mm without resistance, then timed at the feed of the literature (J Biomech Eng 2014;136:034501).
  constexpr double kDeep = 6, kFeed = 40.0 / 60;
  CutPath path;
  path.poses = {{0, lowered(kDeep)}, {4, lowered(kDeep + 4 * kFeed)}};
  path.cuts = {1};
  model.settings.geometry_only = true;
  state.place(start);
  StepOutput out;
  for (int n = 0; n <= 600; ++n) {
    DeviceSample sample;
    sample.T_world_device = lowered(n * kDeep / 600);
    if (state.objects[0].freeBricks() < 2048) state.objects[0].reserve(4096);
    step(model, state, sample, out);
  }
  model.settings.geometry_only = false;
  FeedHand hand(path);
  KERF_CHECK(timeTicks(model, state, hand, r, progress));
  addPercentiles(r, 0.8);
  return r;
}

Expected<Result> benchTickSizes(const Progress& progress) {
  Result r{"tick-sizes", "a ball of 1.6 mm in a slot, the block ever larger", {}, "", 0, ""};
  double first = 0;
  for (const double size : {6.0, 12.0, 24.0}) {
    KERF_TRY(block, practiceBlock({size, size, size / 2}, 0.05));
    KERF_TRY(tool, toolOfRack("round-016"));
    KERF_TRY(model, makeModel(std::span(&tool, 1)));
    model.settings.rendering = Rendering::kRigid;
    State state;
    state.objects.emplace_back(block, 8192);
    CutPath path;
    path.poses = {{0, {Eigen::Quaterniond::Identity(), {-1, 0, -0.6}}},
                  {1.5, {Eigen::Quaterniond::Identity(), {2, 0, -0.6}}}};
    path.cuts = {1};
    FeedHand hand(path);
    Result part;
    state.place(poseAt(path, 0));
    KERF_CHECK(timeTicks(model, state, hand, part, progress));
    const double p50 = part.percentile(0.5);
    if (first == 0) {
      first = p50;
      r.ms = part.ms;
      r.state_hash = part.state_hash;
    }
    r.measured.push_back({fmt::format("{} bricks: p50", block->slots().size()), p50, "ms", 0, false});
    r.measured.push_back({fmt::format("{} bricks: over the smallest", block->slots().size()), p50 / first, "", 1.25});
  }
  return r;
}

}  // namespace kerf::cli
