// Severed parts become separate objects: found, split, moved, cut further, undone, replayed.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <filesystem>

#include "sim/pieces/joined_field.h"
#include "sim/pieces/make_piece.h"
#include "sim/pieces/split_field.h"
#include "sim/pieces/split_object.h"
#include "sim/run/files/log_sink.h"
#include "sim/run/report/replay.h"
#include "sim/session/session.h"
#include "tests/sim/block_scene.h"
#include "tests/support/temporary_file.h"

namespace kerf::session_pieces_test {
namespace {

Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }

Model ball(double radius = 0.65) {
  Model model;
  model.tools = {practiceBall(radius, 8400)};
  model.tissues = test::oneTissue(200, 0.3, 1000);
  model.settings.rendering = Rendering::kRigid;
  model.settings.geometry_only = true;
  return model;
}

std::shared_ptr<const BakedObject> bar() { return test::block({6, 2, 1}, 0.1); }

// Through the bar at x, from side to side, and away from it.
void sever(Session& session, double x, double from = -1.8, double to = 1.8) {
  StepOutput out;
  session.tick(test::sampleAt(at(x, from, 3), 0), out);
  for (int n = 0; n <= 720; ++n)
    session.tick(test::sampleAt(at(x, from + (to - from) * n / 720, -1.15), n < 720 ? 1 : 0), out);
  session.tick(test::sampleAt(at(x, to, 3), 0), out);
}

std::array<double, 256> sum(const std::vector<CutObject>& objects) {
  std::array<double, 256> out{};
  for (const CutObject& object : objects) {
    const auto now = object.bricks().countVolumes();
    for (std::size_t m = 0; m < 256; ++m) out[m] += now[m];
  }
  return out;
}

TEST(SessionPieces, WhatIsSeveredBecomesAnObjectOfItsOwn) {
  Session session(ball(), {bar()}, at(-0.7, -1.8, -1.15));
  session.splitWhenApart(5);
  sever(session, 0.3);
  const std::vector<CutObject>& objects = session.state().objects;
  ASSERT_EQ(objects.size(), 2u);
  for (const CutObject& object : objects) EXPECT_EQ(object.bricks().shellDefects(), 0u);
  // The larger piece stays object 0; both keep their places.
  constexpr auto kDentin = static_cast<std::size_t>(Material::kDentin);
  const double large = objects[0].bricks().countVolumes()[kDentin], small = objects[1].bricks().countVolumes()[kDentin];
  EXPECT_NEAR(large, 2 * (3.3 - 0.65), 0.4);
  EXPECT_NEAR(small, 2 * (2.7 - 0.65), 0.4);
  for (const CutObject& object : objects) {
    const BrickField field = object.bricks().field();
    PieceFinder alone(field);
    EXPECT_EQ(alone.find().pieces.size(), 1u);
  }
  // Each is cut separately from now on. Each ledger starts at the split.
  const std::uint64_t other = objects[0].stateHash();
  sever(session, 1.9);
  EXPECT_EQ(objects.size(), 3u);
  EXPECT_EQ(objects[0].stateHash(), other);
}

TEST(SessionPieces, EverythingInsideIsInExactlyOnePieceOrCrumb) {
  Session session(ball(), {bar()}, at(-0.7, -1.8, -1.15));
  PieceOptions options;
  options.crumb_mm3 = 0.4;
  session.splitWhenApart(1 << 30, options);  // on request only
  sever(session, 2.2);                       // leaves a sliver at the end of the bar
  sever(session, 0);
  const std::vector<CutObject>& objects = session.state().objects;
  ASSERT_EQ(objects.size(), 1u);
  const BrickField all = objects[0].bricks().field();
  PieceFinder finder(all);
  const SolidMeasure whole = finder.find().whole;
  ASSERT_TRUE(session.apply(SplitObject{0, 0.4}));
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_GE(session.crumbs().count, 1u);
  SolidMeasure parts = session.crumbs().measure;
  for (const CutObject& object : objects) {
    const BrickField field = object.bricks().field();
    PieceFinder alone(field);
    EXPECT_EQ(alone.find().pieces.size() + alone.find().crumbs.size(), 1u);
    parts.add(alone.find().whole);
  }
  EXPECT_EQ(parts, whole);  // whole numbers: to the last bit
  EXPECT_FALSE(session.apply(SplitObject{0}));
  EXPECT_FALSE(session.apply(SplitObject{1}));
}

TEST(SessionPieces, APieceThatIsMovedAwayIsCutThereAndNoLongerHere) {
  Session session(ball(), {bar()}, at(-0.7, -1.8, -1.15));
  session.splitWhenApart(5);
  sever(session, -0.7);
  const std::vector<CutObject>& objects = session.state().objects;
  ASSERT_EQ(objects.size(), 2u);
  // A quarter turn about z, ten millimetres up.
  ASSERT_TRUE(session.apply(MoveObject{1, {0, 0, 10}, {0.7071067811865476, 0, 0, 0.7071067811865476}}));
  const std::uint64_t before = objects[1].stateHash();
  sever(session, -2.2);
  EXPECT_EQ(objects[1].stateHash(), before) << "cut where it no longer is";
  StepOutput out;
  double removed = 0;
  for (int n = 0; n <= 400; ++n) {
    // The piece lay about x = -2: turned, it lies about y = -2.
    session.tick(test::sampleAt(at(0, -2.2, 11 - 0.004 * n), n < 400 ? 1 : 0), out);
    removed += out.removed_mm3;
  }
  EXPECT_GT(removed, 0.05);
  EXPECT_NE(objects[1].stateHash(), before);
  // And back: undo restores poses with their strokes.
  ASSERT_TRUE(session.apply(Undo{}));
  EXPECT_EQ(objects[1].stateHash(), before);
  const double nan = std::nan("");
  const Command bad[] = {MoveObject{2, {0, 0, 0}, {1, 0, 0, 0}},
                         MoveObject{0, {0, 0, 0}, {2, 0, 0, 0}},
                         MoveObject{0, {0, 0, 0}, {nan, 0, 0, 0}},
                         MoveObject{0, {nan, 0, 0}, {1, 0, 0, 0}},
                         MoveObject{0, {1e9, 0, 0}, {1, 0, 0, 0}},
                         SplitObject{9},
                         SplitObject{0},
                         SplitObject{0, -1.0},
                         SplitObject{0, nan},
                         AddMaterial{11, 7},
                         AddMaterial{0, 0}};
  for (const Command& command : bad) EXPECT_FALSE(session.apply(command)) << printCommand(command);
}

TEST(SessionPieces, UndoOfTheStrokeThatSeveredMakesItWholeAgain) {
  Session session(ball(), {bar()}, at(-0.7, -1.8, -1.15));
  session.splitWhenApart(5);
  const std::vector<CutObject>& objects = session.state().objects;
  const std::uint64_t untouched = objects[0].stateHash();
  const auto volumes = sum(objects);
  sever(session, 1.5, -1.8, 0);  // a notch
  const std::uint64_t notched = objects[0].stateHash();
  sever(session, -0.7);
  ASSERT_EQ(objects.size(), 2u);
  const std::uint64_t first = objects[0].stateHash(), second = objects[1].stateHash();
  const auto severed = sum(objects);
  ASSERT_TRUE(session.apply(Undo{}));
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0].stateHash(), notched);
  EXPECT_EQ(objects[0].bricks().shellDefects(), 0u);
  ASSERT_TRUE(session.apply(Undo{}));
  EXPECT_EQ(objects[0].stateHash(), untouched);
  EXPECT_EQ(sum(objects), volumes);
  ASSERT_TRUE(session.apply(Redo{}));
  ASSERT_TRUE(session.apply(Redo{}));
  EXPECT_FALSE(session.apply(Redo{}));
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[0].stateHash(), first);
  EXPECT_EQ(objects[1].stateHash(), second);
  EXPECT_EQ(sum(objects), severed);
}

TEST(SessionPieces, TwoObjectsComeApartInOneTickAndUndoMakesBothWhole) {
  const auto block = test::block({2, 2, 1}, 0.1);
  Session session(ball(), {block, block}, at(0, -1.8, -1.15));
  ASSERT_TRUE(session.apply(MoveObject{1, {0, 2.1, 0}, {1, 0, 0, 0}}));  // one behind the other
  session.splitWhenApart(1 << 30);
  sever(session, 0, -1.8, 3.9);
  ASSERT_TRUE(session.apply(SplitObject{1}));
  ASSERT_TRUE(session.apply(SplitObject{0}));
  const std::vector<CutObject>& objects = session.state().objects;
  ASSERT_EQ(objects.size(), 4u);
  const std::uint64_t hash = session.hash();
  // Adding material to an object that no longer exists adds none.
  ASSERT_TRUE(session.apply(AddMaterial{11, 3}));
  ASSERT_TRUE(session.apply(Undo{}));
  EXPECT_EQ(objects.size(), 2u);
  EXPECT_EQ(session.state().adds, Material::kNone);
  for (const CutObject& object : objects) EXPECT_EQ(object.bricks().changedField().brickCount(), 0u);
  ASSERT_TRUE(session.apply(Redo{}));
  EXPECT_EQ(session.hash(), hash);
}

// Between two strokes no stroke is open: a pending split gets its own step.
TEST(SessionPieces, ASplitAfterAStrokeHasEndedIsUndoneAlone) {
  Session session(ball(), {bar()}, at(-0.7, -1.8, -1.15));
  sever(session, -0.7);
  static_cast<void>(session.snapshot());
  const std::uint64_t severed = session.state().objects[0].stateHash();
  ASSERT_TRUE(session.apply(SplitObject{0}));
  ASSERT_EQ(session.state().objects.size(), 2u);
  ASSERT_TRUE(session.apply(Undo{}));
  ASSERT_EQ(session.state().objects.size(), 1u);
  EXPECT_EQ(session.state().objects[0].stateHash(), severed);
}

TEST(SessionPieces, APieceOfAnObjectWhoseShellsWaitForBricksHasItsOwn) {
  const Model model = ball();
  State state;
  state.objects.emplace_back(bar(), 512);
  CutObject& object = state.objects[0];
  StepOutput out;
  for (int n = 0; n <= 720; ++n) step(model, state, test::sampleAt(at(0, -1.8 + 3.6 * n / 720, -1.15)), out);
  ASSERT_EQ(out.status & kStepBricksRanOut, 0u);
  // Changed once more, without repair: as after a tick that ran out of bricks.
  for (int s = 0; s < object.slotCount(); ++s)
    if (!object.slot(s).own && object.slot(s).shell_count > 0 && object.freeBricks() > 0) {
      float* const phi = object.write(s);
      for (int n = 0; n < kBrickNodes; ++n) phi[n] += 0.01f;
    }
  ASSERT_GT(object.bricks().shellDefects(), 0u);
  const BrickField field = object.bricks().field();
  PieceFinder finder(field);
  const PieceList& list = finder.find();
  ASSERT_EQ(list.pieces.size(), 2u);
  for (const PieceBricks& bricks : bricksOfPieces(finder, list.pieces.size()))
    EXPECT_EQ(makePiece(object, bricks).bricks().shellDefects(), 0u);
}

// Blanks are made before any split, from the loaded object. All later cuts, additions and removals must be in the
// pieces, and in their pieces.
TEST(SessionPieces, APieceOutOfABlankIsTheSameAsOneMadeAnew) {
  const Model model = ball(0.3);
  State scene;
  const std::shared_ptr<const BakedObject> loaded = bar();
  scene.objects.emplace_back(loaded, 512);
  StepOutput out;
  const auto saw = [&](State& state, double x) {
    for (int n = 0; n <= 720; ++n) step(model, state, test::sampleAt(at(x, -1.8 + 3.6 * n / 720, -0.7)), out);
    for (int n = 0; n <= 720; ++n) step(model, state, test::sampleAt(at(x, -1.8 + 3.6 * n / 720, -1.15)), out);
    for (int n = 0; n <= 720; ++n) step(model, state, test::sampleAt(at(x, -1.8 + 3.6 * n / 720, -0.3)), out);
    ASSERT_EQ(out.status & kStepBricksRanOut, 0u);
  };
  saw(scene, -0.7);
  // A lump beside the bar's end, in former air.
  CutObject& whole = scene.objects[0];
  const int air = whole.addAir(whole.slot(0).brick - Vec3i(1, 0, 0));
  ASSERT_GE(air, 0);
  BrickValues lump;
  lump.fill(-0.2f);
  std::array<std::uint8_t, kBrickNodes> enamel;
  enamel.fill(static_cast<std::uint8_t>(Material::kEnamel));
  ASSERT_TRUE(whole.restore(air, lump, enamel.data()));
  ASSERT_TRUE(whole.repair());

  const auto finderOf = [](const CutObject& object) {
    std::vector<Vec3i> bricks;
    std::vector<BrickEdit> edits;
    for (int s = 0; s < object.slotCount(); ++s) {
      const CutObject::Slot& slot = object.slot(s);
      if (!object.bricks().has(s)) continue;
      if (s < object.bricks().firstSlotCount()) bricks.push_back(slot.brick);
      if (!slot.own) continue;
      edits.emplace_back().brick = slot.brick;
      std::copy_n(slot.own, kBrickNodes, edits.back().phi.begin());
    }
    auto finder = std::make_unique<PieceFinder>(object.baked().phi0(), bricks);
    finder->apply(edits);
    return finder;
  };
  // Two blanks for three pieces: the last piece is made anew. Again with the remaining list memory.
  PiecePool pool;
  const auto split = [&](const CutObject& object, std::size_t count, bool in_pool) {
    const auto finder = finderOf(object);
    if (in_pool) pool.reserve(loaded, *finder, 512);
    return std::move(makePieces(object, *finder, 7, count, in_pool ? &pool : nullptr)->parts);
  };
  const auto expectSame = [](const Split& a, const Split& b) {
    ASSERT_EQ(a.out_of_scene.size(), b.out_of_scene.size());
    for (std::size_t n = 0; n < a.out_of_scene.size(); ++n) {
      const CutObject &one = a.out_of_scene[n].object, &other = b.out_of_scene[n].object;
      EXPECT_EQ(one.bricks().shellDefects(), 0u);
      EXPECT_EQ(other.bricks().shellDefects(), 0u);
      EXPECT_EQ(one.stateHash(), other.stateHash());
      EXPECT_EQ(one.bricks().field().stateHash(), other.bricks().field().stateHash());
      EXPECT_EQ(one.bricks().field().interiorBricks().size(), other.bricks().field().interiorBricks().size());
      // Node by node, in any slot order.
      const auto volumes = one.bricks().countVolumes(), others = other.bricks().countVolumes();
      for (std::size_t m = 0; m < volumes.size(); ++m) EXPECT_NEAR(volumes[m], others[m], 1e-9 * (1 + others[m]));
    }
  };
  const auto blank = split(whole, 3, true), anew = split(whole, 3, false);
  ASSERT_EQ(blank->out_of_scene.size(), 3u);
  EXPECT_GT(blank->out_of_scene[2].object.bricks().countVolumes()[static_cast<std::size_t>(Material::kEnamel)], 0.3);
  expectSame(*blank, *anew);
  // The same for the larger piece.
  std::vector<std::uint64_t> hashes;
  for (Split* const parts : {blank.get(), anew.get()}) {
    State piece;
    piece.objects.push_back(std::move(parts->out_of_scene[0].object));
    ASSERT_TRUE(piece.objects[0].reserve(512));
    saw(piece, 1.2);
    ASSERT_TRUE(piece.objects[0].repair());
    expectSame(*split(piece.objects[0], 2, true), *split(piece.objects[0], 2, false));
    hashes.push_back(piece.objects[0].stateHash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(SessionPieces, ReplayComesApartInTheSamePlaceBitForBit) {
  const TemporaryFile file("session.log", "");
  std::filesystem::remove(file.path());
  const SessionHeader header = describe(Session(ball(), {bar()}, at(-0.7, -1.8, -1.15)));
  auto writer = SessionLogWriter::create(file.path(), header);
  ASSERT_TRUE(writer) << writer.error().message();
  LogSink sink(*writer);
  Session session(ball(), {bar()}, at(-0.7, -1.8, -1.15), &sink);
  PieceOptions options;
  options.crumb_mm3 = 0.4;  // in the log, too
  session.splitWhenApart(7, options);
  sever(session, 2.2);
  ASSERT_EQ(session.crumbs().count, 1u);
  sever(session, -0.7);
  ASSERT_TRUE(session.apply(MoveObject{1, {0, 0.5, 0.1}, {1, 0, 0, 0}}));
  sever(session, -2);
  ASSERT_TRUE(session.apply(Undo{}));
  ASSERT_TRUE(session.apply(AddMaterial{11, 0}));
  sever(session, 0.4);
  ASSERT_TRUE(session.apply(StopAdding{}));
  session.finish();
  ASSERT_TRUE(sink.close());
  const auto log = readSessionLog(file.path());
  ASSERT_TRUE(log) << log.error().message();
  const auto again = replay(*log, file.path().string(), ball(), {bar()});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same) << again->differs_at;
  EXPECT_GE(again->checks, 2u);
  EXPECT_EQ(again->state_hash, fmt::format("{:016x}", session.hash()));
}

// Values at inside nodes and at their neighbours along an axis: all values that define the surface.
void expectSameSurface(const BrickField& one, const BrickField& other) {
  std::size_t compared = 0;
  for (std::size_t b = 0; b < one.brickCount(); ++b)
    for (int n = 0; n < kBrickNodes; ++n) {
      const Vec3i node = one.brickCoord(b) * kBrickSide + Vec3i(n >> 6, n >> 3 & 7, n & 7);
      bool counts = one.at(node) < 0;
      for (int axis = 0; axis < 3; ++axis)
        for (const int way : {-1, 1}) counts |= one.at(node + way * Vec3i::Unit(axis)) < 0;
      if (!counts) continue;
      ++compared;
      ASSERT_EQ(one.at(node), other.at(node)) << node.transpose();
    }
  EXPECT_GT(compared, 1000u);
}

BrickField withChanges(const BrickField& loaded, const BrickField& changed) {
  BrickField out = loaded;
  for (std::size_t b = 0; b < changed.brickCount(); ++b) out.brick(out.touch(changed.brickCoord(b))) = changed.brick(b);
  return out;
}

TEST(SessionPieces, JoinedTheyAreWhatWouldHaveBeenCutInOnePiece) {
  const auto object = bar();
  Session apart(ball(), {object}, at(-0.7, -1.8, -1.15)), whole(ball(), {object}, at(-0.7, -1.8, -1.15));
  apart.splitWhenApart(5);
  for (Session* session : {&apart, &whole}) {
    sever(*session, 0.3);
    sever(*session, -0.9);
  }
  const std::vector<CutObject>& objects = apart.state().objects;
  ASSERT_GE(objects.size(), 3u);
  apart.apply(MoveObject{1, {0.5, 4, 0.25}});

  std::vector<BrickField> fields;
  std::vector<FieldPart> parts;
  for (const CutObject& piece : objects) fields.push_back(fieldOf(piece));
  for (const BrickField& field : fields) parts.push_back({.begin = &field});
  const BrickField joined = withChanges(object->phi0(), joinedChanges(object->phi0(), parts));
  expectSameSurface(whole.state().objects[0].bricks().field(), joined);
  for (std::size_t n = 0; n < parts.size(); ++n) {
    const Vec3d deepest = deepestPoint(parts[n]);
    EXPECT_LT(fields[n].sample(deepest), -0.05);
    for (std::size_t m = 0; m < parts.size(); ++m)
      if (m != n) {
        EXPECT_GT(fields[m].sample(deepest), 0);
      }
  }
}

TEST(SessionPieces, OfOneThatWasNotCutNothingDiffers) {
  const auto object = bar();
  const FieldPart part{.begin = &object->phi0()};
  EXPECT_TRUE(joinedChanges(object->phi0(), {&part, 1}).isEmpty());
  const BrickField all = fieldOf(CutObject(object, 64));
  const FieldPart copy{.begin = &all};
  EXPECT_TRUE(joinedChanges(object->phi0(), {&copy, 1}).isEmpty());
}

TEST(SessionPieces, WhatWasRemovedIsCountedOnceWhereverItIsNow) {
  Session session(ball(), {bar()}, at(-0.7, -1.8, -1.15));
  session.splitWhenApart(5);
  const auto removed = [&] {
    double out = 0;
    for (const CutObject& object : session.state().objects)
      for (std::size_t m = 0; m < 256; ++m) out += object.removed_before_mm3[m] + object.removed_mm3[m];
    return out;
  };
  const double loaded = sum(session.state().objects)[static_cast<std::size_t>(Material::kDentin)];
  for (const double x : {0.3, -1.2}) {
    sever(session, x);
    const double left = sum(session.state().objects)[static_cast<std::size_t>(Material::kDentin)];
    EXPECT_NEAR(removed() + left, loaded, 1e-4 * loaded) << "a fringe near other pieces counts otherwise";
    EXPECT_EQ(session.crumbs().count, 0u);
  }
  EXPECT_GE(session.state().objects.size(), 3u);
}

TEST(SessionPieces, AMoveIsAStepOfUndoOfItsOwn) {
  Session session(ball(), {bar()}, at(-0.7, -1.8, -1.15));
  session.splitWhenApart(5);
  sever(session, 0.3);
  ASSERT_EQ(session.state().objects.size(), 2u);
  const std::uint64_t before = session.hash();
  session.apply(MoveObject{1, {1, 0, 0}});
  session.apply(MoveObject{1, {2, 0, 0}});
  EXPECT_TRUE(session.apply(Undo{}));
  EXPECT_EQ(session.state().objects[1].T_world_object.translation, Vec3d(1, 0, 0));
  EXPECT_TRUE(session.apply(Undo{}));
  EXPECT_EQ(session.state().objects[1].T_world_object.translation, Vec3d(0, 0, 0));
  EXPECT_EQ(session.hash(), before);
  EXPECT_EQ(session.state().objects.size(), 2u) << "the cut is still there";
  EXPECT_TRUE(session.apply(Undo{}));
  EXPECT_EQ(session.state().objects.size(), 1u);
}

}  // namespace
}  // namespace kerf::session_pieces_test
