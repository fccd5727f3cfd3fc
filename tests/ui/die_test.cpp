// A die from a click on a tooth: where its planes lie, its pin hole, its export.
#include <gtest/gtest.h>

#include "geometry/boolean/plane_cut.h"
#include "geometry/case/case_bundle.h"
#include "geometry/mesh/mesh_check.h"
#include "geometry/mesh/solids.h"
#include "preprocess/demo/demo_arch.h"
#include "sim/run/export/export_bundle.h"
#include "sim/run/export/placed_pieces.h"
#include "sim/run/report/replay.h"
#include "tests/ui/block_on_bench.h"
#include "ui/app/workbench/sawing.h"
#include "ui/app/workbench/steps.h"

namespace kerf::die_test {
namespace {

namespace fs = std::filesystem;

class DieOfAnArch : public test::OnABlock {
 protected:
  Mesh block() const override { return demoArch({.edge_mm = 0.8})->mesh; }
  std::size_t pieces() const { return bench_.document->report().object_count; }
  Expected<void> command(const char* id, std::vector<std::string> words = {}) {
    return runAppCommand(context_, id, words);
  }
  Expected<void> planAt(const Vec3d& place) {
    const auto pixel = pixelOf(camera_, place, context_.width, context_.height);
    return command("plane.die", {std::to_string(pixel[0]), std::to_string(pixel[1])});
  }
  const SawPlane& plane(const char* name) {
    EXPECT_TRUE(bench_.saw->plan().choose(name)) << name;
    return *bench_.saw->plan().chosen();
  }
  Expected<void> cut() {
    KERF_CHECK(command("plane.die-cut"));
    const std::uint64_t sent = bench_.document->sent();
    until([&] { return bench_.document->answered() >= sent; });
    bench_.update();
    return {};
  }
  static constexpr double kNear = 0.6;  // mm
};

// The contacts of tooth 36 are those that the guide reads off the picture.
TEST_F(DieOfAnArch, ItsEndsLieInTheContactsAndItsSidesTaper) {
  ASSERT_TRUE(bench_.document->occlusal().arch);
  const Vec3d left(20.9, 26, -2), mesial_contact(19.8, 20.6, -2.4), distal_contact(22.5, 31, -2.4);
  const auto mirrored = [](const Vec3d& p) { return Vec3d(-p.x(), p.y(), p.z()); };
  for (const bool is_left : {true, false}) {
    const auto placed = [&](const Vec3d& p) { return is_left ? p : mirrored(p); };
    const auto planned = planAt(placed(left));
    ASSERT_TRUE(planned) << planned.error().message();
    ASSERT_EQ(bench_.saw->plan().planes().size(), 5u) << "the planes of the first die are gone";
    const SawPlane mesial = plane("mesial"), distal = plane("distal");
    EXPECT_NEAR(mesial.normal.dot(placed(mesial_contact) - mesial.point), 0, kNear);
    EXPECT_NEAR(distal.normal.dot(placed(distal_contact) - distal.point), 0, kNear);
    const Vec3d up = plane("base").normal;
    for (const char* side : {"mesial", "distal", "buccal", "lingual"}) {
      EXPECT_NEAR(plane(side).normal.dot(up), std::sin(3 * kDegree), 1e-9) << side;
      EXPECT_GT(plane(side).normal.dot(placed(left) - plane(side).point), 0) << side;
    }
  }
  ASSERT_TRUE(command("plane.die-set", {"sides", "2"}));
  EXPECT_EQ(bench_.saw->plan().planes().size(), 4u) << "one plane spares the other side of the arch";
  ASSERT_TRUE(command("plane.die-set", {"base", "0"}));
  EXPECT_EQ(bench_.saw->plan().planes().size(), 3u);
}

TEST_F(DieOfAnArch, IsCutWithItsPinHoleExportedAndUndone) {
  const auto planned = planAt({20.9, 26, -2});
  ASSERT_TRUE(planned) << planned.error().message();
  ASSERT_TRUE(command("plane.die-set", {"base", "2"}));
  ASSERT_TRUE(command("plane.die-set", {"pin-depth", "5"}));
  ASSERT_TRUE(bench_.saw->die.pin()) << bench_.saw->die.pin().error().message();
  const RoundHole pin = **bench_.saw->die.pin();
  std::vector<Plane> planes;
  for (const SawPlane& plane : bench_.saw->die.planes()) planes.push_back({plane.point, plane.normal});
  const auto solid = readCaseSolid(bench_.document->run()->caseFolder());
  ASSERT_TRUE(solid);
  EXPECT_NEAR(pin.depth, 5 + 2, 1.2) << "through the base, from outside";

  ASSERT_TRUE(cut());
  ASSERT_EQ(pieces(), 2u);
  ASSERT_TRUE(command("edit.undo"));
  until([&] { return pieces() == 1; });
  ASSERT_TRUE(command("edit.redo"));
  until([&] { return pieces() == 2; });

  const fs::path run = bench_.document->sessionFolder();
  bench_.sessions->close();
  until([&] { return !bench_.jobs->running(); });
  const auto exported = exportBundle(run);
  ASSERT_TRUE(exported) << exported.error().message();
  EXPECT_TRUE(checkMesh(exported->post_op.mesh).print_ready) << "die and model, apart by the kerf";

  // As kerf trim does it, to the bit.
  const auto trimmed = cutByPlanes(*solid, planes, {.piece_at = {}, .kerf_mm = 0.1, .post_op = {}});
  ASSERT_TRUE(trimmed);
  Mesh wanted;
  for (const PostOpMesh* part : {&trimmed->above, &trimmed->rest}) {
    const auto drilled = withHole(part->mesh, pin);
    ASSERT_TRUE(drilled && *drilled);
    append(wanted, (*drilled)->mesh);
  }
  EXPECT_EQ(exported->post_op.mesh.vertices, wanted.vertices);
  EXPECT_EQ(exported->post_op.mesh.triangles, wanted.triangles);

  const auto placed = placedPieces(exported->post_op.mesh, exported->pieces);
  ASSERT_TRUE(placed);
  ASSERT_EQ(placed->size(), 2u);
  const Mesh &die = (*placed)[0].mesh, &model = (*placed)[1].mesh;
  EXPECT_GT(signedVolume(die), 500);
  EXPECT_LT(signedVolume(die), 0.15 * signedVolume(model));
  const auto onAxis = [&](double along) -> Vec3d { return pin.mouth + along * pin.axis; };
  EXPECT_FALSE(isInside(die, onAxis(pin.depth - 0.2)));
  EXPECT_TRUE(isInside(die, onAxis(pin.depth + 0.3)));
  EXPECT_FALSE(isInside(model, onAxis(pin.depth - 5.5)));
  EXPECT_TRUE(isInside(model, onAxis(pin.depth - 5.5) + 1.2 * pin.axis.unitOrthogonal()));
  const auto replayed = replayRun(run);
  ASSERT_TRUE(replayed) << replayed.error().message();
  EXPECT_TRUE(replayed->is_same && replayed->is_whole) << replayed->note;
}

TEST_F(DieOfAnArch, WrongNumbersAndNoRoomAreSaidBeforeTheCut) {
  EXPECT_FALSE(command("plane.die-cut")) << "nothing is planned";
  for (const std::vector<std::string>& bad : {std::vector<std::string>{"pin", "0.1"},
                                              {"pin", "7"},
                                              {"sides", "3"},
                                              {"taper", "16"},
                                              {"width", "4"},
                                              {"base"},
                                              {}})
    EXPECT_FALSE(command("plane.die-set", bad));
  ASSERT_TRUE(planAt({20.9, 26, -2}));
  ASSERT_TRUE(command("plane.die-set", {"pin-depth", "40"}));
  const auto refused = command("plane.die-cut");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().expected.find("at most"), std::string::npos) << refused.error().message();
  EXPECT_FALSE(command("plane.die-set", {"base", "45"})) << "in the crown";
  EXPECT_EQ(bench_.saw->die.choice().base_mm, 3);
  ASSERT_TRUE(command("plane.die-set", {"pin", "0"}));
  EXPECT_TRUE(cut());
  EXPECT_EQ(pieces(), 2u);
}

}  // namespace
}  // namespace kerf::die_test
