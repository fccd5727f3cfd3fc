#include "sim/live/piece_maker.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cstring>
#include <map>
#include <mutex>

#include "bench/scenes/simulated_device.h"
#include "sim/pieces/split_field.h"
#include "sim/run/report/replay.h"
#include "tests/sim/block_scene.h"
#include "tests/sim/haptic_scene.h"
#include "tests/support/temporary_folder.h"

namespace kerf::piece_maker_test {
namespace {

using namespace std::chrono_literals;
using test::becomes;
using test::GuardedDevice;

// ThreadSanitizer does not see into Debian's TBB.
#if defined(__SANITIZE_THREAD__)
constexpr bool kParallel = false;
#else
constexpr bool kParallel = true;
#endif

Model ball() {
  Model model;
  model.tools = {practiceBall(0.65, 8400)};
  model.tissues = test::oneTissue(200, 0.3, 1000);
  model.settings.rendering = Rendering::kRigid;
  model.settings.geometry_only = true;
  return model;
}

std::shared_ptr<const BakedObject> bar() { return test::block({6, 2, 1}, 0.1); }

// A person who saws through a bar at one place after another, and waits for next() in between.
class Sawyer final : public DeviceSource {
 public:
  explicit Sawyer(std::vector<double> places) : places_(std::move(places)) {}
  DeviceSample read() noexcept override {
    constexpr int kTicks = 400;
    const int place = place_.load();
    DeviceSample out = test::sampleAt({Eigen::Quaterniond::Identity(), {0, -1.8, 3}}, 0);
    if (place > done_ && place <= static_cast<int>(places_.size())) {
      const double x = places_[static_cast<std::size_t>(place - 1)];
      out = test::sampleAt({Eigen::Quaterniond::Identity(), {x, -1.8 + 3.6 * tick_ / kTicks, -1.15}}, tick_ < kTicks);
      if (tick_++ == kTicks) {
        tick_ = 0;
        done_ = place;
      }
    }
    return out;
  }
  void write(const DeviceForce&) noexcept override {}
  void next() { ++place_; }
  bool rests() const { return done_.load() == place_.load(); }

 private:
  std::vector<double> places_;
  std::atomic<int> place_{0}, done_{0};
  int tick_ = 0;
};

// Acts as a renderer: receives each piece and takes its changed bricks.
class Audience {
 public:
  void add(std::shared_ptr<const PieceOrigin> origin, std::shared_ptr<BrickFeed> feed) {
    const std::lock_guard lock(mutex_);
    Seen& seen = seen_[origin->id];
    seen.origin = std::move(origin);
    seen.feed = std::move(feed);
  }
  void drain() {
    const std::lock_guard lock(mutex_);
    BrickEdit edit;
    for (auto& [id, seen] : seen_)
      while (seen.feed->tryPop(edit)) seen.edits[coordKey(edit.brick)] = edit.phi;
  }
  void expectKnows(const CutObject& object) {
    ASSERT_TRUE(seen_.contains(object.id));
    const Seen& seen = seen_[object.id];
    BrickField field = seen.origin->field();
    EXPECT_GT(field.brickCount(), 10u);
    for (const auto& [key, phi] : seen.edits) {
      const auto c = coordOfKey(key);
      field.brick(field.touch({c[0], c[1], c[2]})) = phi;
    }
    const BrickField now = object.bricks().field();
    for (std::size_t b = 0; b < now.brickCount(); ++b) {
      const BrickValues* values = field.valuesAt(now.brickCoord(b));
      ASSERT_TRUE(values);
      ASSERT_EQ(*values, now.brick(b)) << now.brickCoord(b).transpose();
    }
    EXPECT_EQ(field.interiorBricks().size(), now.interiorBricks().size());
  }
  std::uint32_t parentOf(std::uint32_t id) { return seen_.at(id).origin->of; }
  std::size_t count() const { return seen_.size(); }

 private:
  struct Seen {
    std::shared_ptr<const PieceOrigin> origin;
    std::shared_ptr<BrickFeed> feed;
    std::map<std::uint64_t, BrickValues> edits;
  };
  std::mutex mutex_;
  std::map<std::uint32_t, Seen> seen_;
};

// Compares values and materials of two objects, independent of their storage.
std::uint64_t volumesOf(const std::vector<CutObject>& objects) {
  std::uint64_t nodes = 0;
  for (const CutObject& object : objects)
    for (int s = 0; s < object.slotCount(); ++s)
      if (object.bricks().has(s))
        nodes += static_cast<std::uint64_t>(
            std::count_if(object.slot(s).phi, object.slot(s).phi + kBrickNodes, [](float v) { return v < 0; }));
  return nodes;
}

TEST(PieceMaker, WhatIsSeveredOnTheThreadIsCutMovedTakenBackAndReplayedBitForBit) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "s.kerflog";
  Audience audience;
  HapticOptions options = test::ordinaryHaptics();
  options.pieces.is_parallel = kParallel;
  options.pieces.pieces.crumb_mm3 = 0.4;
  options.pieces.on_piece = [&](std::shared_ptr<const PieceOrigin> origin, std::shared_ptr<BrickFeed> feed) {
    audience.add(std::move(origin), std::move(feed));
  };
  Sawyer sawyer({-0.7, 1.4, -2.05, 1.6});
  GuardedDevice device(&sawyer);
  HapticThread haptic(ball(), {bar()}, {Eigen::Quaterniond::Identity(), {0, -1.8, 3}}, options);
  auto recorder = SessionRecorder::start(file, describe(haptic.session()));
  ASSERT_TRUE(recorder) << recorder.error().message();
  ASSERT_TRUE(haptic.start(device, {}, &*recorder));
  const auto holds = [&](const std::function<bool(const HapticReport&)>& what) {
    return becomes(haptic, [&](const HapticReport& r) {
      audience.drain();
      return what(r);
    });
  };
  const auto saw = [&] {
    sawyer.next();
    EXPECT_TRUE(holds([&](const HapticReport&) { return sawyer.rests(); }));
  };
  std::uint64_t sent = 0;
  const auto send = [&](const Command& command) {
    EXPECT_TRUE(haptic.send(command));
    ++sent;
    EXPECT_TRUE(holds([&](const HapticReport& r) { return r.counts.commands_done == sent; })) << printCommand(command);
  };
  saw();
  EXPECT_TRUE(holds([](const HapticReport& r) { return r.object_count == 2; }));
  // Numbers are positions in the scene. Ids persist.
  EXPECT_EQ(haptic.report().objects[0].id, 1u);
  EXPECT_EQ(haptic.report().objects[1].id, 2u);
  send(MoveObject{1, {0, 0.05, 0}, {1, 0, 0, 0}});
  EXPECT_EQ(haptic.report().objects[1].T_world_object.translation[1], 0.05);
  saw();  // the larger one, which is object 0
  EXPECT_TRUE(holds([](const HapticReport& r) { return r.object_count == 3; }));
  saw();  // the moved piece loses a crumb or a piece
  EXPECT_TRUE(holds([](const HapticReport& r) { return r.counts.pieces.splits + r.counts.pieces.crumbs >= 3; }));
  send(Undo{});
  send(Undo{});  // undoes the second cut, and its split
  EXPECT_TRUE(holds([](const HapticReport& r) { return r.object_count == 2; }));
  EXPECT_EQ(haptic.report().objects[0].id, 1u);
  send(Redo{});
  EXPECT_TRUE(holds([](const HapticReport& r) { return r.object_count == 3; }));
  const std::uint32_t stays = haptic.report().objects[1].id;
  send(DeleteObjects{{0b101}});
  EXPECT_TRUE(holds([](const HapticReport& r) { return r.object_count == 1; }));
  EXPECT_EQ(haptic.report().objects[0].id, stays);
  send(Undo{});
  EXPECT_TRUE(holds([](const HapticReport& r) { return r.object_count == 3; }));
  send(Undo{});
  saw();  // a new cut instead: the redo list and its subscriber are gone
  EXPECT_TRUE(holds([](const HapticReport& r) { return r.counts.pieces.splits + r.counts.pieces.crumbs >= 4; }));
  haptic.stop();
  audience.drain();
  ASSERT_TRUE(recorder->close());
  haptic.update();
  const HapticReport& report = haptic.report();
  EXPECT_EQ(report.counts.records_lost, 0u);
  EXPECT_EQ(report.counts.out_of_bricks, 0u);
  EXPECT_GE(report.counts.pieces.splits, 3u);
  EXPECT_GE(report.counts.pieces.crumbs, 1u);
  EXPECT_EQ(report.counts.pieces.crumbs, haptic.session().crumbs().count);
  // An object that only loses crumbs is also frozen, so neither time bounds the other.
  EXPECT_GT(report.counts.pieces.longest_split_ms, 0);
  EXPECT_GT(report.counts.pieces.longest_freeze_ms, 0);
  const std::vector<CutObject>& objects = haptic.session().state().objects;
  EXPECT_EQ(report.object_count, objects.size());
  for (const CutObject& object : objects) {
    EXPECT_EQ(object.bricks().shellDefects(), 0u);
    EXPECT_FALSE(object.isFrozen());
    audience.expectKnows(object);
    const BrickField field = object.bricks().field();
    PieceFinder alone(field, options.pieces.pieces);
    EXPECT_EQ(alone.find().pieces.size(), 1u);
    EXPECT_EQ(alone.find().crumbs.size(), 0u);
  }
  EXPECT_EQ(audience.parentOf(1), 0u);
  EXPECT_EQ(audience.parentOf(3), 1u);

  const auto log = readSessionLog(file);
  ASSERT_TRUE(log) << log.error().message();
  const auto again = replay(*log, "s.kerflog", ball(), {bar()});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same) << again->differs_at;
  EXPECT_EQ(again->note, "");
  EXPECT_GE(again->checks, 2u);
  EXPECT_EQ(again->state_hash, fmt::format("{:016x}", haptic.session().hash()));
}

TEST(PieceMaker, AFrozenObjectIsFeltAndNotCutAndNothingIsTakenBack) {
  Model model = ball();
  model.settings.geometry_only = false;
  Session session(model, {bar()}, {Eigen::Quaterniond::Identity(), {0, 0, 0.1}});
  StepOutput out;
  const auto press = [&](double depth, int ticks) {
    double removed = 0;
    for (int n = 0; n < ticks; ++n) {
      session.tick(test::sampleAt({Eigen::Quaterniond::Identity(), {0, 0, -depth * (n + 1) / ticks}}), out);
      removed += out.removed_mm3;
    }
    return removed;
  };
  EXPECT_GT(press(0.2, 100), 0);
  const std::uint64_t before = session.state().objects[0].stateHash();
  ASSERT_TRUE(session.apply(FreezeObject{0}));
  EXPECT_EQ(press(0.3, 100), 0);
  EXPECT_GT(out.contact.force.norm(), 0.5);
  EXPECT_TRUE(out.status & kStepFrozen);
  EXPECT_EQ(session.state().objects[0].stateHash(), before);
  for (const Command& wrong :
       {Command(FreezeObject{0}), Command(FreezeObject{1}), Command(UnfreezeObject{1}), Command(Undo{}),
        Command(Redo{}), Command(SplitObject{0}), Command(MoveObject{0, {0, 0, 1}, {1, 0, 0, 0}})})
    EXPECT_FALSE(session.apply(wrong)) << printCommand(wrong);
  ASSERT_TRUE(session.apply(AddMaterial{11, 0}));
  EXPECT_EQ(press(0.1, 10), 0);
  EXPECT_EQ(session.state().objects[0].stateHash(), before) << "nor filled";
  ASSERT_TRUE(session.apply(StopAdding{}));
  // A snapshot keeps it.
  const auto bytes = packState(session.state(), {session.state().objects[0].bricks().sharedBaked()});
  const auto again = unpackState(bytes, {session.state().objects[0].bricks().sharedBaked()}, "here");
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->objects[0].isFrozen());
  ASSERT_TRUE(session.apply(UnfreezeObject{0}));
  EXPECT_GT(press(0.4, 100), 0);
  EXPECT_FALSE(out.status & kStepFrozen);
  EXPECT_TRUE(session.apply(Undo{}));
}

TEST(PieceMaker, CrumbsAreTakenAwayWithTheStrokeThatMadeThem) {
  Session session(ball(), {bar()}, {Eigen::Quaterniond::Identity(), {0, -1.8, 3}});
  const std::uint64_t untouched = session.state().objects[0].stateHash();
  StepOutput out;
  const auto nodes = volumesOf(session.state().objects);
  for (int n = 0; n <= 400; ++n)
    session.tick(test::sampleAt({Eigen::Quaterniond::Identity(), {2.25, -1.8 + 3.6 * n / 400, -1.15}}, n < 400 ? 1 : 0),
                 out);
  const double cut = session.state().objects[0].removed_mm3[static_cast<std::size_t>(Material::kDentin)];
  const std::uint32_t id = session.state().objects[0].id;
  ASSERT_TRUE(session.apply(SplitObject{0, 0.4}));
  const CutObject& object = session.state().objects[0];
  EXPECT_EQ(session.state().objects.size(), 1u);
  EXPECT_EQ(object.id, id) << "the same object";
  EXPECT_EQ(session.crumbs().count, 1u);
  EXPECT_GT(object.removed_mm3[static_cast<std::size_t>(Material::kDentin)], cut + 0.05);
  const auto now = object.bricks().countVolumes();
  EXPECT_NEAR(object.baked().volumes()[static_cast<std::size_t>(Material::kDentin)] -
                  object.removed_mm3[static_cast<std::size_t>(Material::kDentin)],
              now[static_cast<std::size_t>(Material::kDentin)], 1e-9);
  EXPECT_EQ(object.bricks().shellDefects(), 0u);
  EXPECT_LT(volumesOf(session.state().objects), nodes);
  EXPECT_FALSE(session.apply(SplitObject{0, 0.4}));
  ASSERT_TRUE(session.apply(Undo{}));
  EXPECT_EQ(volumesOf(session.state().objects), nodes);
  EXPECT_EQ(session.state().objects[0].stateHash(), untouched);
}

TEST(PieceMaker, TwoObjectsThatComeApartTogetherBothDo) {
  const auto block = test::block({2, 1.6, 1}, 0.1);
  Sawyer sawyer({0});
  GuardedDevice device(&sawyer);
  HapticOptions options = test::ordinaryHaptics();
  options.pieces.is_parallel = kParallel;
  // Both at the same place: the same cut severs both in the same tick.
  HapticThread haptic(ball(), {block, block}, {Eigen::Quaterniond::Identity(), {0, -1.8, 3}}, options);
  ASSERT_TRUE(haptic.start(device, {}, nullptr));
  sawyer.next();
  EXPECT_TRUE(becomes(haptic, [&](const HapticReport& r) { return r.object_count == 4; }));
  haptic.stop();
  EXPECT_EQ(haptic.report().counts.pieces.splits, 2u);
}

TEST(PieceMaker, StopsInTheMiddleOfASplitWithTheObjectAsItIsAndReplaysThat) {
  const TemporaryFolder folder;
  for (const int wait_ms : {0, 20}) {  // until the pieces are ready, possibly before the stop and after it
    const auto file = folder.path() / fmt::format("{}.kerflog", wait_ms);
    Sawyer sawyer({0.3});
    GuardedDevice device(&sawyer);
    HapticOptions options = test::ordinaryHaptics();
    options.pieces.is_parallel = kParallel;
    std::atomic<bool> is_asked{false}, may_go_on{false};
    options.pieces.on_apart = [&](std::uint32_t id) {
      EXPECT_EQ(id, 0u);
      is_asked = true;
      while (!may_go_on) std::this_thread::sleep_for(1ms);
      std::this_thread::sleep_for(std::chrono::milliseconds(wait_ms));
    };
    HapticThread haptic(ball(), {bar()}, {Eigen::Quaterniond::Identity(), {0, -1.8, 3}}, options);
    auto recorder = SessionRecorder::start(file, describe(haptic.session()));
    ASSERT_TRUE(recorder);
    ASSERT_TRUE(haptic.start(device, {}, &*recorder));
    sawyer.next();
    EXPECT_TRUE(becomes(haptic, [&](const HapticReport& r) { return is_asked && (r.output.status & kStepFrozen); }));
    // Commands wait during the split.
    EXPECT_TRUE(haptic.send(SelectTool{0}));
    const std::uint64_t since = haptic.report().tick;
    EXPECT_TRUE(becomes(haptic, [&](const HapticReport& r) { return r.tick > since + 50; }));
    EXPECT_EQ(haptic.report().counts.commands_done, 0u);
    may_go_on = true;
    haptic.stop();
    ASSERT_TRUE(recorder->close());
    for (const CutObject& object : haptic.session().state().objects) {
      EXPECT_FALSE(object.isFrozen());
      EXPECT_EQ(object.bricks().shellDefects(), 0u);
    }
    const auto log = readSessionLog(file);
    ASSERT_TRUE(log) << log.error().message();
    const auto again = replay(*log, file.string(), ball(), {bar()});
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_TRUE(again->is_same) << again->differs_at;
    EXPECT_GE(again->commands, 2u);
    EXPECT_EQ(again->state_hash, fmt::format("{:016x}", haptic.session().hash()));
  }
}

// The subscriber and a replay must get the same pieces, although the inside of another piece is air for this one.
TEST(PieceMaker, MaterialAddedWhereAnotherPieceWasAndTakenBackLeavesNoTrace) {
  const auto object = test::block({12, 6, 6}, 0.1);  // large enough to have bricks wholly inside
  const BrickField& phi0 = object->phi0();
  ASSERT_FALSE(phi0.interiorBricks().empty());
  // The half below x = 0, and a layer of air.
  std::vector<Vec3i> bricks;
  std::vector<BrickEdit> own;
  const auto valuesOf = [&](const Vec3i& c) {
    BrickEdit edit;
    edit.brick = c;
    if (const BrickValues* values = phi0.valuesAt(c))
      edit.phi = *values;
    else
      edit.phi.fill(phi0.constantAt(c));
    return edit;
  };
  for (const auto& slot : object->slots()) {
    if (slot.brick[0] > 0) continue;
    bricks.push_back(slot.brick);
    if (slot.brick[0] < 0) continue;
    own.push_back(valuesOf(slot.brick));
    for (int n = 0; n < kBrickNodes; ++n)
      own.back().phi[static_cast<std::size_t>(n)] =
          std::max(own.back().phi[static_cast<std::size_t>(n)], 0.1f * static_cast<float>(n >> 6) + 0.05f);
  }
  PieceFinder fresh(phi0, bricks), subscriber(phi0, bricks);
  fresh.apply(own);
  subscriber.apply(own);
  // Bricks of the other half, filled and emptied again.
  std::vector<BrickEdit> filled, emptied;
  for (const auto& slot : object->slots()) {
    if (slot.brick[0] != 1) continue;
    filled.push_back(valuesOf(slot.brick));
    emptied.push_back(valuesOf(slot.brick));
    emptied.back().phi.fill(phi0.background());
  }
  ASSERT_FALSE(filled.empty());
  subscriber.apply(filled);
  subscriber.apply(emptied);
  ASSERT_EQ(fresh.find().pieces.size(), 1u);
  ASSERT_EQ(subscriber.find().pieces.size(), 1u);
  const auto expected = bricksOfPieces(fresh, 1), found = bricksOfPieces(subscriber, 1);
  EXPECT_EQ(found[0].bricks, expected[0].bricks);
  EXPECT_EQ(found[0].interior, expected[0].interior);
  EXPECT_EQ(found[0].changed.size(), expected[0].changed.size());
}

}  // namespace
}  // namespace kerf::piece_maker_test
