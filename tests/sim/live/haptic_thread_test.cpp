#include "sim/live/haptic_thread.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <iterator>
#include <map>
#include <thread>

#include "bench/scenes/simulated_device.h"
#include "sim/run/report/replay.h"
#include "tests/sim/block_scene.h"
#include "tests/sim/haptic_scene.h"
#include "tests/support/temporary_folder.h"

namespace kerf::haptic_thread_test {
namespace {

using namespace std::chrono_literals;
using test::becomes;
using test::GuardedDevice;

// In a tissue as soft as caries, so that a light hand cuts fast.
Model twoBalls() {
  Model model;
  model.tools = {practiceBall(0.5, 840), practiceBall(0.3, 840)};
  model.tissues = test::oneTissue(200, 0.3, 100);
  return model;
}

Rigid3 at(double x, double y, double z) { return {Eigen::Quaterniond::Identity(), {x, y, z}}; }
std::shared_ptr<const BakedObject> someBlock() { return test::block({6, 4, 2}, 0.1); }

// Dabs side by side into the block's top, each a stroke of `seconds`, with the pedal up in between, and for `rest`
// seconds after half of them.
CutPath dabs(int count, double seconds, double depth, double rest = 0) {
  CutPath path;
  double t = 0;
  const auto go = [&](const Vec3d& p, double takes, bool cuts) {
    if (!path.poses.empty()) {
      path.cuts.push_back(cuts);
      t += takes;
    }
    path.poses.push_back({t, {Eigen::Quaterniond::Identity(), p}});
  };
  go({-2, 0.1, 0.3}, 0, false);
  for (int n = 0; n < count; ++n) {
    const double x = -2 + 4.0 * (n % 20) / 19, y = 0.1 + 0.35 * ((n / 20 + 3) % 7 - 3);
    go({x, y, 0.2}, seconds / 4 + (n == count / 2 ? rest : 0), false);
    go({x, y, -depth}, seconds / 2, true);
    go({x, y, 0.3}, seconds / 4, true);
  }
  return path;
}

// Keeps the newest values of each brick.
struct Subscriber {
  void run(BrickFeed& feed, const std::atomic<bool>& is_over) {
    BrickEdit edit;
    for (;;) {
      const bool is_last = is_over;
      while (feed.tryPop(edit)) {
        replica[coordKey(edit.brick)] = edit.phi;
        ++edits;
      }
      if (is_last) return;
      std::this_thread::sleep_for(1ms);
    }
  }
  void expectEqual(const CutObject& object) const {
    std::size_t changed = 0;
    for (int s = 0; s < object.slotCount(); ++s) {
      const CutObject::Slot& slot = object.slot(s);
      const auto known = replica.find(coordKey(slot.brick));
      const float* values =
          known != replica.end() ? known->second.data() : object.baked().slots()[static_cast<std::size_t>(s)].phi;
      ASSERT_EQ(std::memcmp(values, slot.phi, sizeof(BrickValues)), 0) << "brick " << slot.brick.transpose();
      changed += known != replica.end();
    }
    EXPECT_GT(changed, 10u);
  }
  std::map<std::uint64_t, BrickValues> replica;
  std::uint64_t edits = 0;
};

TEST(HapticThread, ItsLogReplaysBitForBitAndASubscriberOfTheBricksHasTheField) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "s.kerflog";
  const CutPath path = dabs(12, 0.25, 0.5, 1);
  DeviceHand::Options firm;
  firm.hand_stiffness = 1.5;
  DeviceHand hand(path, firm);
  SimulatedDevice simulated(hand);
  GuardedDevice device(&simulated);
  HapticThread haptic(twoBalls(), {someBlock()}, poseAt(path, 0), test::ordinaryHaptics());
  auto recorder = SessionRecorder::start(file, describe(haptic.session()));
  ASSERT_TRUE(recorder) << recorder.error().message();
  BrickFeed feed(16);  // small on purpose: sometimes full
  std::atomic<bool> is_over{false};
  Subscriber subscriber;
  std::thread subscribing([&] { subscriber.run(feed, is_over); });
  BrickFeed* const feeds[] = {&feed};
  const auto started = haptic.start(device, feeds, &*recorder);
  ASSERT_TRUE(started) << started.error().message();

  std::uint64_t sent = 0;
  const auto sendAt = [&](double tick, std::initializer_list<Command> commands) {
    EXPECT_TRUE(becomes(haptic, [&](const HapticReport& r) { return static_cast<double>(r.tick) > tick; }));
    for (const Command& command : commands) {
      EXPECT_TRUE(haptic.send(command));
      ++sent;
      EXPECT_TRUE(becomes(haptic, [&](const HapticReport& r) { return r.counts.commands_done == sent; }))
          << printCommand(command);
    }
  };
  sendAt(900, {Undo{}});
  sendAt(1300, {SelectTool{1}});
  sendAt(1600, {Undo{}, Redo{}, Undo{}});  // in the rest
  sendAt(2000, {ClearLatch{}});
  EXPECT_TRUE(becomes(haptic, [&](const HapticReport&) { return simulated.isOver(); }));
  sendAt(0, {Undo{}});
  haptic.stop();
  is_over = true;
  subscribing.join();
  ASSERT_TRUE(recorder->close());
  haptic.update();
  haptic.updateTimes();
  const HapticReport& report = haptic.report();
  EXPECT_EQ(report.counts.records_lost, 0u);
  EXPECT_EQ(report.counts.out_of_bricks, 0u);
  EXPECT_EQ(recorder->status().lost, 0u);
  EXPECT_EQ(report.counts.ticks, haptic.session().state().tick);
  EXPECT_EQ(report.tick, report.counts.ticks);
  EXPECT_EQ(report.counts.pauses, 5u);
  EXPECT_GT(device.most_force, 0.1);
  EXPECT_GT(haptic.times().cost.count(), 3000u);

  EXPECT_EQ(haptic.unsentBricks(), 0u);
  EXPECT_EQ(subscriber.edits, report.counts.edits_pushed);
  subscriber.expectEqual(haptic.session().state().objects[0]);

  const auto log = readSessionLog(file);
  ASSERT_TRUE(log) << log.error().message();
  EXPECT_TRUE(log->is_closed);
  const auto again = replay(*log, "s.kerflog", twoBalls(), {someBlock()});
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->is_same) << again->differs_at;
  EXPECT_EQ(again->note, "");
  EXPECT_EQ(again->ticks, report.counts.ticks);
  EXPECT_GE(again->checks, 4u);
  EXPECT_GT(again->removed_mm3, 0.1);
  EXPECT_EQ(again->state_hash, fmt::format("{:016x}", haptic.session().hash()));
}

// Every stroke takes free bricks for its changes, until the initial bricks are used up.
TEST(HapticThread, BricksArriveBeforeTheyRunOut) {
  const CutPath path = dabs(140, 0.04, 1.7);
  FeedHand hand(path);
  SimulatedDevice simulated(hand);
  GuardedDevice device(&simulated);
  Model model = twoBalls();
  model.settings.rendering = Rendering::kRigid;
  model.settings.geometry_only = true;
  HapticThread haptic(std::move(model), {test::block({6, 4, 2}, 0.05)}, poseAt(path, 0), test::ordinaryHaptics());
  const CutObject& object = haptic.session().state().objects[0];
  const std::size_t at_first = object.freeBricks();
  ASSERT_TRUE(haptic.start(device, {}, nullptr));
  EXPECT_TRUE(becomes(haptic, [&](const HapticReport&) { return simulated.isOver(); }));
  haptic.stop();
  haptic.update();
  const std::size_t taken = haptic.report().counts.pools_taken * Session::kReserve;
  EXPECT_GT(at_first + taken - object.freeBricks(), at_first) << "what was there at first would have been enough";
  EXPECT_EQ(haptic.report().counts.pauses, 0u) << "for bricks";
  EXPECT_EQ(haptic.report().counts.out_of_bricks, 0u);
  EXPECT_EQ(object.bricks().shellDefects(), 0u);
}

TEST(HapticThread, CommandsAreDoneInTheirOrderAndRefusedOnesAreCounted) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "s.kerflog";
  GuardedDevice device;
  device.sample = test::sampleAt(at(0, 0, 1), 0);
  HapticThread haptic(twoBalls(), {someBlock()}, at(0, 0, 1), test::ordinaryHaptics());
  auto recorder = SessionRecorder::start(file, describe(haptic.session()));
  ASSERT_TRUE(recorder);
  ASSERT_TRUE(haptic.start(device, {}, &*recorder));
  // Under the device's allocation guard: that thread prints nothing, for texts of any length.
  const MoveObject moved{0, {-1.0 / 3, 1e-300, 0.1}, {1, 0, 0, 1e-12}};
  const Command good[] = {SelectTool{0}, SelectTool{1}, ClearLatch{}, AddMaterial{11, 0}, moved, StopAdding{}};
  // No such tool, and commands that only the simulation may send.
  const Command bad[] = {SelectTool{7}, SplitObject{0}, SplitObject{0, 0.1}, FreezeObject{0}, UnfreezeObject{0}};
  std::vector<std::string> sent;
  std::uint64_t refused = 0;
  const auto send = [&](const Command& command) {
    while (!haptic.send(command)) std::this_thread::sleep_for(1ms);
  };
  send(Redo{});
  ++refused;
  for (std::size_t n = 0; n < 150; ++n) {
    if (n % 10 == 9) {
      send(bad[n / 10 % std::size(bad)]);
      ++refused;
    } else {
      sent.push_back(printCommand(good[n % std::size(good)]));
      send(good[n % std::size(good)]);
    }
  }
  EXPECT_TRUE(becomes(haptic, [&](const HapticReport& r) {
    return r.counts.commands_done == sent.size() && r.counts.commands_refused == refused;
  }));
  haptic.stop();
  EXPECT_EQ(haptic.report().counts.pauses, 0u) << "what can not be done is no reason to pause";
  ASSERT_TRUE(recorder->close());
  const auto log = readSessionLog(file);
  ASSERT_TRUE(log);
  std::vector<std::string> done;
  for (const SessionEvent& event : log->events)
    if (const auto* command = std::get_if<SessionCommand>(&event.what)) done.push_back(command->text);
  EXPECT_EQ(done, sent);
}

// Presses into the block; gives a bad sample on request.
class PressingDevice final : public GuardedDevice {
 public:
  DeviceSample read() noexcept override {
    ++reads;
    DeviceSample out = test::sampleAt(at(0, 0, z), pedal);
    if (is_bad) out.T_world_device.translation[1] = std::nan("");
    return out;
  }
  void write(const DeviceForce& f) noexcept override {
    GuardedDevice::write(f);
    force = f.force.norm();
  }
  std::atomic<double> z{0.1}, force{0}, pedal{0};
  std::atomic<bool> is_bad{false};
};

TEST(HapticThread, ABadSampleLatchesUntilItIsCleared) {
  PressingDevice device;
  HapticThread haptic(twoBalls(), {someBlock()}, at(0, 0, 0.1), test::ordinaryHaptics());
  ASSERT_TRUE(haptic.start(device, {}, nullptr));
  const auto tickOf = [&] { return haptic.report().tick; };
  EXPECT_TRUE(becomes(haptic, [&](const HapticReport& r) { return r.tick > 100; }));
  device.z = -0.3;
  EXPECT_TRUE(becomes(haptic, [&](const HapticReport&) { return device.force > 0.05; }));
  device.is_bad = true;
  EXPECT_TRUE(becomes(haptic, [&](const HapticReport& r) { return r.is_latched; }));
  EXPECT_EQ(device.force, 0);
  device.is_bad = false;  // the device is back, which alone changes nothing
  const std::uint64_t since = tickOf();
  EXPECT_TRUE(becomes(haptic, [&](const HapticReport& r) { return r.tick > since + 50; }));
  EXPECT_TRUE(haptic.report().is_latched);
  EXPECT_EQ(device.force, 0);
  EXPECT_TRUE(haptic.send(ClearLatch{}));
  EXPECT_TRUE(becomes(haptic, [&](const HapticReport& r) { return !r.is_latched && device.force > 0.05; }));
  haptic.stop();
  EXPECT_EQ(device.last_force, 0);
}

// The force varies in every tick while a bur cuts, and the report has the added vibration.
TEST(HapticThread, AToolIsFeltToVibrateOnlyWhileItCuts) {
  PressingDevice device;
  device.z = 0.3;
  device.pedal = 1;
  HapticOptions options = test::ordinaryHaptics();
  options.felt.assign(2, {FeltSource::Kind::kSaw, 100 / 840.0, 840, Vec3d::UnitX()});  // 100 Hz
  HapticThread haptic(twoBalls(), {someBlock()}, at(0, 0, 0.3), options);
  ASSERT_TRUE(haptic.start(device, {}, nullptr));
  EXPECT_TRUE(becomes(haptic, [](const HapticReport& r) { return r.tick > 300; }));
  EXPECT_EQ(haptic.report().vibration, 0) << "in air, long after the start";

  device.z = -1;
  EXPECT_TRUE(becomes(haptic, [](const HapticReport& r) { return r.vibration > 0.002; }));
  EXPECT_TRUE(becomes(haptic, [](const HapticReport& r) { return r.vibration < -0.002; }));
  EXPECT_LT(std::abs(haptic.report().vibration), 0.5);
  haptic.stop();
  EXPECT_EQ(device.last_force, 0);
}

// A device with a driver that hangs once.
TEST(HapticThread, AStallIsCountedAndLatches) {
  class Hanging final : public GuardedDevice {
   public:
    DeviceSample read() noexcept override {
      if (++reads == 50) sleepUntil(monotonicNow() + 150'000'000);
      return sample;
    }
  } device;
  device.sample = test::sampleAt(at(0, 0, 1), 0);
  HapticOptions options = test::ordinaryHaptics();
  options.stall_ms = 100;
  HapticThread haptic(twoBalls(), {someBlock()}, at(0, 0, 1), options);
  ASSERT_TRUE(haptic.start(device, {}, nullptr));
  EXPECT_TRUE(becomes(haptic, [&](const HapticReport& r) { return r.counts.stalls > 0; }));
  EXPECT_TRUE(haptic.report().is_latched);
  haptic.stop();
  EXPECT_GE(haptic.report().counts.overruns, 1u);
  EXPECT_GE(haptic.report().counts.missed_periods, 149u);
  EXPECT_LT(haptic.report().counts.overruns, haptic.report().counts.missed_periods);
}

TEST(HapticThread, StopsWithZeroForceAndADisarmedDevice) {
  PressingDevice device;
  device.z = -0.2;
  HapticThread haptic(twoBalls(), {someBlock()}, at(0, 0, 0.1), test::ordinaryHaptics());
  ASSERT_TRUE(haptic.start(device, {}, nullptr));
  EXPECT_TRUE(becomes(haptic, [&](const HapticReport&) { return device.force > 0.05; }));
  haptic.stop();
  EXPECT_TRUE(device.is_armed && device.is_disarmed);
  EXPECT_GT(device.most_force, 0);
  EXPECT_EQ(device.last_force, 0);
  const std::uint64_t after = device.reads;
  haptic.stop();
  std::this_thread::sleep_for(5ms);
  EXPECT_EQ(device.reads, after);
  EXPECT_FALSE(haptic.start(device, {}, nullptr)) << "one start";
}

TEST(HapticThread, MayBeDestroyedBeforeAndRightAfterItsStart) {
  GuardedDevice device;
  device.sample = test::sampleAt(at(0, 0, 1), 0);
  const auto block = someBlock();
  { const HapticThread haptic(twoBalls(), {block}, at(0, 0, 1), test::ordinaryHaptics()); }
  for (int n = 0; n < 5; ++n) {
    HapticThread haptic(twoBalls(), {block}, at(0, 0, 1), test::ordinaryHaptics());
    ASSERT_TRUE(haptic.start(device, {}, nullptr));
  }
  HapticThread haptic(twoBalls(), {block}, at(0, 0, 1), test::ordinaryHaptics());
  BrickFeed feed;
  BrickFeed* const feeds[] = {&feed, &feed};
  EXPECT_FALSE(haptic.start(device, feeds, nullptr)) << "more feeds than objects";
}

}  // namespace
}  // namespace kerf::haptic_thread_test
