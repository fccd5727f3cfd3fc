// A person at the mouse who drills in blocks, for session tests on the live threads.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "geometry/formats/mesh_writer.h"
#include "geometry/tool/tool_file.h"
#include "preprocess/bake/bake.h"
#include "sim/hand/mouse_hand.h"
#include "sim/run/session/live_run.h"
#include "tests/sim/haptic_scene.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"

namespace kerf::test {

// A block of 6 x 4 x 3 mm, the middle of its top at `shift`, baked at 0.1 mm.
inline std::filesystem::path bakedBlock(const TemporaryFolder& folder, const std::string& name = "block",
                                        const Vec3d& shift = Vec3d::Zero()) {
  const std::filesystem::path file = folder.path() / (name + ".ply"), out = folder.path() / (name + ".case");
  Mesh mesh = blockMesh(true);
  for (Vec3d& v : mesh.vertices) v += shift;
  EXPECT_TRUE(writeMesh(file, mesh));
  BakeOptions options;
  options.unit = "mm";
  options.voxelize.voxel_mm = 0.1;
  const auto baked = bake({file}, out, options);
  EXPECT_TRUE(baked) << baked.error().message();
  return out;
}

inline LiveRunOptions someTools() {
  LiveRunOptions out;
  for (const char* id : {"round-014", "round-010"}) {
    const auto file = findToolFile(id, defaultToolFolders());
    EXPECT_TRUE(file) << file.error().message();
    out.tools.push_back({*file, *readTool(*file)});
  }
  out.start = {Eigen::Quaterniond::Identity(), {0, 0, 3}};
  out.haptic = ordinaryHaptics();
  out.mesher.remesher.is_parallel = false;
  return out;
}

// A person at the mouse.
class Mouse {
 public:
  explicit Mouse(LiveRun& run)
      : run_(run), hand_(surfaceOf(run), {Eigen::Quaterniond::Identity(), {0, 0, 3}}, run.model().settings.coupling) {
    const auto started = run.start(hand_);
    EXPECT_TRUE(started) << started.error().message();
  }
  // Presses until a removal, or until the depth is reached.
  void drill(const Vec3d& at, double seconds, double force = 1.5) {
    ++aim_.stroke;
    aim_.is_pressed = true;
    aim_.anchor = aim_.pointer = at;
    aim_.force = force;
    aim_.depth = 0.5;
    hand_.aim(aim_);
    EXPECT_TRUE(run_.send(PlaceTool{{at[0], at[1], at[2] + 0.3}}));
    waitFor(seconds);
    aim_.is_pressed = false;
    hand_.aim(aim_);
    waitFor(0.3);  // until the tool is out: its spindle runs down
  }
  void send(const Command& command) {
    EXPECT_TRUE(run_.send(command));
    waitFor(0.05);
  }
  // Waits until all cuts are meshed. A copy of the scene is as old as its meshers.
  void awaitMeshers() {
    EXPECT_TRUE(becomes(run_.thread(), [&](const HapticReport& r) {
      return r.counts.edits_waiting == 0 && run_.editsDone() >= r.counts.edits_pushed;
    }));
  }

 private:
  static std::shared_ptr<const BrickField> surfaceOf(const LiveRun& run) { return run.original(); }
  // By the simulation's clock: the machine may be slow.
  void waitFor(double seconds) {
    run_.thread().update();
    const auto until = run_.thread().report().tick + static_cast<std::uint64_t>(seconds / kTick);
    EXPECT_TRUE(becomes(run_.thread(), [&](const HapticReport& r) { return r.tick >= until; }));
  }

  LiveRun& run_;
  MouseHand hand_;
  MouseAim aim_;
};

}  // namespace kerf::test
