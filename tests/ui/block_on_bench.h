// For tests of hands: a workbench with a block on it, a camera from above, and a pointing person.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <numbers>
#include <thread>

#include "geometry/formats/mesh_writer.h"
#include "tests/support/open_block.h"
#include "tests/support/temporary_folder.h"
#include "ui/app/commands/pointing.h"
#include "ui/app/commands/zoom.h"
#include "ui/app/document/document.h"
#include "ui/app/document/jobs.h"
#include "ui/app/hand/stroke_pointer.h"
#include "ui/app/workbench/sessions.h"
#include "ui/app/workbench/strokes.h"

namespace kerf::test {

// A workbench without an object.
class StrokePointerTest : public testing::Test {
 protected:
  TemporaryFolder folder_;
  static WorkbenchOptions in(const TemporaryFolder& folder) {
    WorkbenchOptions out;
    out.data_folder = folder.path();
    out.tools = {"round-014"};
    out.real_time = {.priority = 0, .lock_memory = false};
    return out;
  }
  Workbench bench_{in(folder_)};
  Camera camera_ = *cameraFromView("top");
  AppContext context_{.bench = bench_, .camera = camera_, .width = 400, .height = 300};
  StrokePointer pointer_;
  static constexpr double kDegree = std::numbers::pi / 180;
};

// A session with a block, on its own threads.
class OnABlock : public StrokePointerTest {
 protected:
  void SetUp() override {
    const std::filesystem::path file = folder_.path() / "block.ply";
    ASSERT_TRUE(writeMesh(file, block()));
    bench_.sessions->open(file);
    until([&] { return !bench_.jobs->running() && bench_.document->scene().triangleCount() > 0; });
    fitToBox(camera_, bench_.document->scene().bounds(), context_.width, context_.height);
    bench_.strokes->depth_mm = 0.6;
    bench_.strokes->setForce(2);
  }
  // The scan to open.
  virtual Mesh block() const { return test::blockMesh(false); }
  void TearDown() override {
    bench_.sessions->close();
    until([&] { return !bench_.jobs->running(); });
  }
  void until(const std::function<bool()>& is_so) {
    do {
      bench_.update();
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    } while (!is_so());
  }
  void run(double seconds) {
    const auto end = bench_.document->report().tick + static_cast<std::uint64_t>(seconds / kTick);
    until([&] { return bench_.document->report().tick >= end; });
  }
  // Runs until a condition holds. On a busy machine a cutting tool goes deeper before it moves on, and then has more to
  // cut on its path.
  void runUntil(const std::function<bool()>& is_so) {
    constexpr double kLongest = 20, kStep = 0.25;  // s
    for (double t = 0; t < kLongest && !is_so(); t += kStep) run(kStep);
  }
  void runToDepth() {
    runUntil(
        [&] { return !bench_.strokes->isPressed() || *bench_.strokes->depthNow() >= bench_.strokes->depth_mm - 0.03; });
  }
  Vec3d tip() const { return bench_.document->report().output.T_world_tool.translation; }
};

}  // namespace kerf::test
