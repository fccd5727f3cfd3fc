// Cuts by planes in a session: exact fields, undo, snapshots, replay.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "geometry/mesh/mesh_check.h"
#include "sim/pieces/joined_field.h"
#include "sim/pieces/plane_parts.h"
#include "sim/run/export/placed_pieces.h"
#include "sim/run/export/plane_parts_mesh.h"
#include "sim/run/files/log_sink.h"
#include "sim/run/report/replay.h"
#include "sim/run/session/session_pieces.h"
#include "sim/session/session.h"
#include "sim/session/state_bytes.h"
#include "tests/sim/block_scene.h"
#include "tests/support/temporary_file.h"

namespace kerf::plane_cut_session_test {
namespace {

Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }

Model ballModel() {
  Model model;
  model.tools = {practiceBall(0.65, 8400)};
  model.tissues = test::oneTissue(200, 0.3, 1000);
  model.settings.rendering = Rendering::kRigid;
  model.settings.geometry_only = true;
  return model;
}

CutByPlanes cutBy(PlaneKeep keep, const Plane& plane, double kerf_mm = 0, std::size_t object = 0) {
  CutByPlanes out{object, static_cast<std::uint8_t>(keep), {}};
  out.planes.kerf_mm = kerf_mm;
  out.planes.add(plane);
  return out;
}

double volumeOf(const CutObject& object) {
  double out = 0;
  for (const double v : object.bricks().countVolumes()) out += v;
  return out;
}

// Across the bar, off the nodes.
const Plane kAcross{{0.31, 0, 0}, {1, 0, 0}};

class PlaneCutSession : public testing::Test {
 protected:
  Session session_{ballModel(), {test::block({6, 2, 1}, 0.1)}, at(-2, -1.8, 3)};
  const std::vector<CutObject>& objects_ = session_.state().objects;
};

TEST_F(PlaneCutSession, BothPartsTogetherAreTheWhole) {
  const double whole = volumeOf(objects_[0]);
  ASSERT_TRUE(session_.apply(cutBy(PlaneKeep::kBoth, kAcross)));
  ASSERT_EQ(objects_.size(), 2u);
  EXPECT_NEAR(volumeOf(objects_[0]), 2 * (3 - 0.31), 0.06) << "above comes first";
  EXPECT_NEAR(volumeOf(objects_[1]), 2 * (3 + 0.31), 0.06);
  EXPECT_NEAR(volumeOf(objects_[0]) + volumeOf(objects_[1]), whole, 0.005);
  EXPECT_NE(objects_[0].id, objects_[1].id);
  for (const CutObject& part : objects_) EXPECT_EQ(part.bricks().shellDefects(), 0u);
  EXPECT_EQ(session_.undoList().newest[0].kind, UndoStep::Kind::kPlaneCut);
  EXPECT_EQ(session_.undoList().newest[0].removed_mm3, 0);
}

// The law of the part: phi = max(phi before, -height), at every node of any plane, kerf and side.
TEST(PlaneCutOfASession, EveryNodeOfAPartIsTheGreaterOfFieldAndPlane) {
  std::mt19937 random(1);
  const auto number = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  const auto block = test::block({2, 2, 1}, 0.1);
  for (int n = 0; n < 40; ++n) {
    Session session(ballModel(), {block}, at(0, 0, 5));
    const Vec3d normal = Vec3d(number(-1, 1), number(-1, 1), number(-1, 1)).normalized();
    const bool is_above = n % 2 == 0;
    const Vec3d point(number(-0.5, 0.5), number(-0.5, 0.5), number(-0.9, -0.1));
    CutByPlanes cut =
        cutBy(is_above ? PlaneKeep::kAbove : PlaneKeep::kBelow, {point, normal}, n % 3 == 0 ? 0 : number(0, 0.3));
    if (n % 4 > 1) cut.planes.setHole({{number(-1, 1), number(-1, 1), -1.5}, Vec3d(0.1, 0, 1).normalized(), 0.7, 1.2});
    const BrickField before = session.state().objects[0].bricks().field();
    ASSERT_TRUE(session.apply(cut)) << printCommand(cut);
    const CutObject& part = session.state().objects[0];
    std::size_t wrong = 0;
    for (std::size_t b = 0; b < before.brickCount(); ++b) {
      const int slot = part.find(before.brickCoord(b));
      for (int k = 0; k < kBrickNodes; ++k) {
        const Vec3i node = before.brickCoord(b) * kBrickSide + Vec3i{k >> 6, k >> 3 & 7, k & 7};
        const double height = cut.planes.height(before.position(node), is_above);
        const float wanted = planePartValue(before.brick(b)[static_cast<std::size_t>(k)], height, before.background());
        wrong += slot >= 0 ? part.slot(slot).phi[k] != wanted : wanted <= 0;
      }
    }
    EXPECT_EQ(wrong, 0u) << printCommand(cut);
  }
}

TEST_F(PlaneCutSession, APartThatLeavesIsRemovedVolumeAndUndoBringsItBack) {
  const double whole = volumeOf(objects_[0]);
  const std::uint64_t hash = session_.hash();
  ASSERT_TRUE(session_.apply(cutBy(PlaneKeep::kAbove, kAcross, 0.2)));
  ASSERT_EQ(objects_.size(), 1u);
  double removed = 0;
  for (const double v : objects_[0].removed_before_mm3) removed += v;
  EXPECT_NEAR(volumeOf(objects_[0]) + removed, whole, 1e-9);
  EXPECT_NEAR(removed, 2 * (3 + 0.31 + 0.1), 0.06) << "with half of the kerf";
  EXPECT_EQ(session_.undoList().newest[0].removed_mm3, removed);
  const std::uint64_t cut = session_.hash();

  ASSERT_TRUE(session_.apply(Undo{}));
  EXPECT_EQ(session_.hash(), hash);
  EXPECT_FALSE(session_.apply(Undo{}));
  ASSERT_TRUE(session_.apply(Redo{}));
  EXPECT_EQ(session_.hash(), cut);
}

TEST_F(PlaneCutSession, FourPlanesCutOutABlock) {
  CutByPlanes cut = cutBy(PlaneKeep::kBoth, {{-0.52, 0, 0}, {1, 0, 0}});
  cut.planes.add({{0.48, 0, 0}, {-1, 0, 0}});
  cut.planes.add({{0, -0.53, 0}, {0, 1, 0}});
  cut.planes.add({{0, 0.47, 0}, {0, -1, 0}});
  ASSERT_TRUE(session_.apply(cut));
  ASSERT_EQ(objects_.size(), 2u);
  EXPECT_NEAR(volumeOf(objects_[0]), 1, 0.03);
  EXPECT_NEAR(volumeOf(objects_[1]), 11, 0.1);
}

TEST_F(PlaneCutSession, APlaneBesideTheObjectAndBadNumbersAreRefused) {
  const Plane beside{{9, 0, 0}, {1, 0, 0}};
  const double nan = std::nan("");
  CutByPlanes many = cutBy(PlaneKeep::kBoth, kAcross);
  many.planes.count = CutPlanes::kMost + 1;
  const CutByPlanes bad[] = {cutBy(PlaneKeep::kBoth, beside),
                             cutBy(PlaneKeep::kAbove, beside),
                             cutBy(PlaneKeep::kBoth, {{0, 0, 0}, {2, 0, 0}}),
                             cutBy(PlaneKeep::kBoth, {{nan, 0, 0}, {1, 0, 0}}),
                             cutBy(PlaneKeep::kBoth, kAcross, -1),
                             cutBy(PlaneKeep::kBoth, kAcross, 11),
                             cutBy(PlaneKeep::kBoth, kAcross, 0, 1),
                             cutBy(static_cast<PlaneKeep>(3), kAcross),
                             many};
  for (const CutByPlanes& command : bad) EXPECT_FALSE(session_.apply(command)) << printCommand(command);
  EXPECT_EQ(objects_.size(), 1u);
  EXPECT_FALSE(session_.canUndo());
}

TEST_F(PlaneCutSession, AHoleAloneIsLostAndUndone) {
  CutByPlanes cut{0, static_cast<std::uint8_t>(PlaneKeep::kAbove), {}};
  cut.planes.setHole({{0.5, 0.1, -1.5}, Vec3d::UnitZ(), 1, 1});
  const std::uint64_t hash = session_.hash();
  ASSERT_TRUE(session_.apply(cut));
  ASSERT_EQ(objects_.size(), 1u);
  EXPECT_NEAR(volumeOf(objects_[0]), 12 - 0.25 * std::numbers::pi * 0.5, 0.1) << "in voxels of 0.1 mm";
  EXPECT_GT(session_.undoList().newest[0].removed_mm3, 0.3);
  cut.keep = static_cast<std::uint8_t>(PlaneKeep::kBoth);
  EXPECT_FALSE(session_.apply(cut)) << "without planes there is no rest";
  ASSERT_TRUE(session_.apply(Undo{}));
  EXPECT_EQ(session_.hash(), hash);
}

// A box of the same size as test::block({6, 2, 1}).
Mesh boxMesh() {
  Mesh out;
  for (int n = 0; n < 8; ++n) out.vertices.push_back({n & 1 ? 3.0 : -3.0, n & 2 ? 1.0 : -1.0, n & 4 ? 0.0 : -1.0});
  out.triangles = {{4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                   {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}, {0, 2, 1}, {1, 2, 3}};
  return out;
}

// A hole drilled before or after the cut, through both new faces: its wall crosses the plane, without a rim or a film.
TEST(PlaneCutExport, StrokesAcrossThePlaneAreExportedToBothFaces) {
  constexpr double kRadius = 0.65, kDeepest = -0.4;  // mm, of the ball
  const double drilled = kAcross.point[0] + 0.2;
  for (const bool is_before : {true, false}) {
    Session session(ballModel(), {test::block({6, 2, 1}, 0.1)}, at(drilled, 0, 3));
    StepOutput out;
    const auto drill = [&] {
      for (int n = 0; n <= 800; ++n)
        session.tick(test::sampleAt(at(drilled, 0, 0.4 - (0.4 - kDeepest) * std::min(n, 400) / 400), 1), out);
      session.tick(test::sampleAt(at(drilled, 0, 3), 0), out);
    };
    if (is_before) drill();
    ASSERT_TRUE(session.apply(cutBy(PlaneKeep::kBoth, kAcross)));
    if (!is_before) drill();

    const internal::Objects objects = internal::objectsOf(session, 0);
    const std::vector<BrickField> fields = internal::fieldsOf(objects);
    const std::vector<RunManifest::Piece> pieces = internal::piecesOf(objects, fields, {});
    std::vector<FieldPart> parts;
    for (const BrickField& field : fields) parts.push_back({.begin = &field});
    const BrickField& phi0 = objects.front()->baked().phi0();
    const auto made = planePartsMesh(boxMesh(), phi0, joinedChanges(phi0, parts), pieces);
    ASSERT_TRUE(made) << made.error().message();
    const auto placed = placedPieces(made->mesh, pieces);
    ASSERT_TRUE(placed) << placed.error().message();
    ASSERT_EQ(placed->size(), 2u);
    for (std::size_t n = 0; n < 2; ++n) {
      const Mesh& half = (*placed)[n].mesh;
      const MeshReport report = checkMesh(half);
      EXPECT_TRUE(report.print_ready) << (report.reasons.empty() ? "" : report.reasons.front());
      EXPECT_NEAR(signedVolume(half), volumeOf(*objects[n]), 0.08);
    }

    // Every new vertex lies on the plane or on the wall of the hole.
    double worst = 0;
    for (std::size_t v = 0; v < made->mesh.vertices.size(); ++v) {
      if (made->is_source[v]) continue;
      const Vec3d& p = made->mesh.vertices[v];
      const Vec3d axis(drilled, 0, std::max(p[2], kDeepest + kRadius));
      if (std::abs(kAcross.height(p)) > 1e-4) worst = std::max(worst, std::abs((p - axis).norm() - kRadius));
    }
    EXPECT_GT(worst, 0) << "the hole has a wall";
    EXPECT_LT(worst, 0.08) << is_before;
  }
}

// A block with tapered sides, a base and a hole from below through both parts.
CutByPlanes dieCut() {
  CutByPlanes cut = cutBy(PlaneKeep::kBoth, {{-0.52, 0, 0}, Vec3d(1, 0, 0.05).normalized()}, 0.1);
  cut.planes.add({{0.48, 0, 0}, Vec3d(-1, 0, 0.05).normalized()});
  cut.planes.add({{0, -0.53, 0}, Vec3d(0, 1, 0.05).normalized()});
  cut.planes.add({{0, 0.47, 0}, Vec3d(0, -1, 0.05).normalized()});
  cut.planes.add({{0, 0, -0.71}, {0, 0, 1}});
  cut.planes.setHole({{0, 0, -1.5}, Vec3d::UnitZ(), 0.4, 1.2});
  return cut;
}

TEST(PlaneCutExport, ADieHasItsHoleAndSoHasTheModel) {
  Session session(ballModel(), {test::block({6, 2, 1}, 0.1)}, at(0, 0, 3));
  ASSERT_TRUE(session.apply(dieCut()));
  ASSERT_EQ(session.state().objects.size(), 2u);
  const internal::Objects objects = internal::objectsOf(session, 0);
  const std::vector<BrickField> fields = internal::fieldsOf(objects);
  const std::vector<RunManifest::Piece> pieces = internal::piecesOf(objects, fields, {});
  std::vector<FieldPart> parts;
  for (const BrickField& field : fields) parts.push_back({.begin = &field});
  const BrickField& phi0 = objects.front()->baked().phi0();
  const auto made = planePartsMesh(boxMesh(), phi0, joinedChanges(phi0, parts), pieces);
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_TRUE(checkMesh(made->mesh).print_ready) << "with a kerf both fit one file";
  const auto placed = placedPieces(made->mesh, pieces);
  ASSERT_TRUE(placed) << placed.error().message();
  ASSERT_EQ(placed->size(), 2u);
  const RoundHole hole = dieCut().planes.hole();
  for (const PlacedPiece& piece : *placed) {
    EXPECT_TRUE(checkMesh(piece.mesh).print_ready);
    std::size_t on_wall = 0;
    for (const Vec3d& p : piece.mesh.vertices) {
      EXPECT_GT(hole.outside(p), -2e-3);
      on_wall += std::abs(hole.outside(p)) < 2e-3;
    }
    EXPECT_GE(on_wall, 64u);
  }
}

TEST(PlaneCutLog, ReplayAndSnapshotGiveTheSameBits) {
  const TemporaryFile file("session.log", "");
  std::filesystem::remove(file.path());
  const LoadedObjects objects{test::block({6, 2, 1}, 0.1)};
  std::string hash;
  {
    auto writer = SessionLogWriter::create(file.path(), describe(Session(ballModel(), objects, at(-2, 0, 3))));
    ASSERT_TRUE(writer) << writer.error().message();
    LogSink sink(*writer);
    Session session(ballModel(), objects, at(-2, 0, 3), &sink);
    StepOutput out;
    const auto drill = [&](double x) {
      for (int n = 0; n < 200; ++n) session.tick(test::sampleAt(at(x, 0, 1.2 - 0.008 * n), 1), out);
      session.tick(test::sampleAt(at(x, 0, 3), 0), out);
    };
    drill(-2);
    ASSERT_TRUE(session.apply(cutBy(PlaneKeep::kBoth, kAcross)));
    drill(1.5);
    drill(0.31);  // through both faces
    CutByPlanes last = cutBy(PlaneKeep::kBelow, {{0, 0.2, 0}, {0, 1, 0}}, 0, 1);
    last.planes.setHole({{-1.3, -0.4, -1.5}, Vec3d::UnitZ(), 0.5, 1});
    ASSERT_TRUE(session.apply(last));
    session.tick(test::sampleAt(at(0, 0, 3), 0), out);

    const auto bytes = session.snapshot();
    const auto state = unpackState(bytes, objects, "snapshot");
    ASSERT_TRUE(state) << state.error().message();
    EXPECT_EQ(state->hash(), session.hash());
    for (std::size_t n = 0; n < state->objects.size(); ++n)
      EXPECT_EQ(*state->objects[n].plane_sides, *session.state().objects[n].plane_sides);
    EXPECT_EQ(packState(*state, objects), bytes);
    session.finish();
    hash = fmt::format("{:016x}", session.hash());
    ASSERT_TRUE(sink.close());
  }
  const auto log = readSessionLog(file.path());
  ASSERT_TRUE(log) << log.error().message();
  const auto again = replay(*log, file.path().string(), ballModel(), objects);
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same) << again->differs_at;
  EXPECT_EQ(again->state_hash, hash);
}

}  // namespace
}  // namespace kerf::plane_cut_session_test
