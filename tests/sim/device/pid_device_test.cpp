// Force feedback of the class PID: descriptors, reports, and a device that manages its pool itself.
#include "sim/device/pid_device.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "tests/sim/device/force_scene.h"
#include "tests/sim/device/pid_scene.h"

namespace kerf::pid_device_test {
namespace {

using namespace test;

PidReports pidReports() {
  auto layout = parseHidDescriptor(pidDescriptor());
  EXPECT_TRUE(layout) << layout.error().message();
  auto reports = PidReports::of(std::move(*layout));
  EXPECT_TRUE(reports) << reports.error().message();
  return std::move(*reports);
}

TEST(Pid, ReportsAreThoseOfItsDescriptor) {
  const PidReports pid = pidReports();
  EXPECT_EQ(pid.control(PidControl::kReset), (Bytes{0x0C, 8}));
  EXPECT_EQ(pid.control(PidControl::kEnable), (Bytes{0x0C, 1}));
  EXPECT_EQ(*pid.gain(1), (Bytes{0x0D, 255}));
  EXPECT_EQ(pid.create(PidEffect::kConstant), (Bytes{0x11, 1, 0, 0}));
  EXPECT_EQ(pid.create(PidEffect::kDamper), (Bytes{0x11, 3, 0, 0}));
  EXPECT_EQ(pid.askLoad(), (Bytes{0x12, 0, 0, 0, 0}));
  EXPECT_EQ(pid.loadOf(Bytes{0x12, 4, 1, 0, 1}).block, 4);
  EXPECT_EQ(pid.loadOf(Bytes{0x12, 4, 2, 0, 1}).status, PidLoad::Status::kFull);
  EXPECT_EQ(pid.loadOf(Bytes{0x12, 4, 2, 0, 1}).block, 0);
  EXPECT_EQ(pid.constant(4, 0.5), (Bytes{5, 4, 0x00, 0x40}));
  EXPECT_EQ(pid.constant(4, -1), (Bytes{5, 4, 0x01, 0x80}));
  EXPECT_EQ(pid.damper(5, 0.25, 1), (Bytes{3, 5, 1, 0, 0, 0x00, 0x20, 0x00, 0x20, 0xFF, 0x7F, 0xFF, 0x7F, 0, 0}));
  EXPECT_EQ(pid.sine(6, 1, 50), (Bytes{4, 6, 0xFF, 0x7F, 0, 0, 0, 0, 20, 0, 0, 0}));
  EXPECT_EQ(pid.operate(4, PidOperation::kStart), (Bytes{0x0A, 4, 1, 1}));
  EXPECT_EQ(pid.operate(4, PidOperation::kStop), (Bytes{0x0A, 4, 3, 0}));
  EXPECT_EQ(pid.free(4), (Bytes{0x0B, 4}));
  // Of 100 ms. Right: a quarter of a turn clockwise from away, 9000 of 36000.
  EXPECT_TRUE(pid.hasDuration());
  EXPECT_EQ(pid.set(PidEffect::kConstant, 4, 0),
            (Bytes{1, 4, 1, 100, 0, 0, 0, 0, 0, 0, 0, 255, 8, 0x04, 0x28, 0x23, 0, 0}));
}

// Another layout of the same class: other numbers, ranges and lengths, and no delay.
TEST(Pid, ReportsAreThoseOfAnArduinosDescriptor) {
  auto layout = parseHidDescriptor(arduinoDescriptor());
  ASSERT_TRUE(layout) << layout.error().message();
  const auto pid = PidReports::of(std::move(*layout));
  ASSERT_TRUE(pid) << pid.error().message();
  EXPECT_TRUE(pid->has(PidEffect::kConstant) && pid->has(PidEffect::kSine) && pid->has(PidEffect::kDamper));
  EXPECT_EQ(pid->control(PidControl::kReset), (Bytes{0x0C, 8}));
  EXPECT_EQ(*pid->gain(0.5), (Bytes{0x0D, 128}));
  EXPECT_EQ(pid->create(PidEffect::kConstant), (Bytes{5, 1, 0, 0}));
  EXPECT_EQ(pid->create(PidEffect::kSine), (Bytes{5, 4, 0, 0}));
  EXPECT_EQ(pid->create(PidEffect::kDamper), (Bytes{5, 9, 0, 0}));
  EXPECT_EQ(pid->askLoad(), (Bytes{6, 0, 0, 0, 0}));
  EXPECT_EQ(pid->loadOf(Bytes{6, 3, 1, 0, 1}).block, 3);
  EXPECT_EQ(pid->loadOf(Bytes{6, 3, 2, 0, 1}).status, PidLoad::Status::kFull);
  // Shares of 10000.
  EXPECT_EQ(pid->constant(4, 0.5), (Bytes{5, 4, 0x88, 0x13}));
  EXPECT_EQ(pid->constant(4, -1), (Bytes{5, 4, 0xF0, 0xD8}));
  EXPECT_EQ(pid->damper(5, 0.25, 1), (Bytes{3, 5, 1, 0, 0, 0xC4, 0x09, 0xC4, 0x09, 0x10, 0x27, 0x10, 0x27, 0, 0}));
  EXPECT_EQ(pid->sine(6, 1, 50), (Bytes{4, 6, 0x10, 0x27, 0, 0, 0, 0, 20, 0, 0, 0}));
  EXPECT_EQ(pid->operate(4, PidOperation::kStart), (Bytes{0x0A, 4, 1, 1}));
  EXPECT_EQ(pid->free(4), (Bytes{0x0B, 4}));
  // Of 100 ms. Right, a quarter of a turn clockwise from away, in 8 bits; left, three quarters.
  EXPECT_TRUE(pid->hasDuration());
  EXPECT_EQ(pid->set(PidEffect::kConstant, 4, 0), (Bytes{1, 4, 1, 100, 0, 0, 0, 0, 0, 255, 8, 0x04, 64, 0}));
  EXPECT_EQ(pid->set(PidEffect::kConstant, 4, std::numbers::pi)[12], 191);
}

TEST(Pid, ADurationThatDoesNotFitIsTheLongestThatEnds) {
  HidLayout layout = *parseHidDescriptor(pidDescriptor());
  for (HidField& field : layout.fields)
    if (std::find(field.usages.begin(), field.usages.end(), HidUsage{0x0F0050}) != field.usages.end())
      field.logical_max = 50;
  const auto pid = PidReports::of(std::move(layout));
  ASSERT_TRUE(pid) << pid.error().message();
  EXPECT_EQ(pid->set(PidEffect::kConstant, 4, 0)[3], 49) << "the largest one would be endless";
}

TEST(Pid, ADescriptorThatIsNoneIsRefusedWithTheByte) {
  EXPECT_FALSE(parseHidDescriptor(Bytes{0x27, 0xFF}));
  EXPECT_FALSE(parseHidDescriptor(Bytes{0xC0}));
  EXPECT_FALSE(parseHidDescriptor(Bytes{0xA1, 0x01}));
  EXPECT_FALSE(parseHidDescriptor(Bytes{0x75, 0x41}));
  EXPECT_FALSE(parseHidDescriptor(Bytes{0x75, 0x40, 0x96, 0x00, 0x10, 0x81, 0x02}));
  const auto short_of = parseHidDescriptor(Bytes{0x05, 0x01, 0xB4});
  ASSERT_FALSE(short_of);
  EXPECT_NE(short_of.error().message().find("byte 2"), std::string::npos) << short_of.error().message();
  EXPECT_FALSE(PidReports::of(*parseHidDescriptor(Bytes{0x05, 0x01, 0x09, 0x04, 0xA1, 0x01, 0xC0}))) << "a joystick";
}

TEST_F(PidDevices, EffectsAreCreatedLoadedStartedAndFreed) {
  plugIn(3);
  auto device = PidDevice::open(listHid().front());
  ASSERT_TRUE(device) << device.error().message();
  {
    const std::lock_guard lock(mutex_);
    EXPECT_EQ(created_, (std::vector<Bytes>{{0x11, 1, 0, 0}, {0x11, 3, 0, 0}, {0x11, 2, 0, 0}}));
  }
  const std::vector<Bytes> begun = bed_->written(0);
  ASSERT_GE(begun.size(), 4u);
  EXPECT_EQ(begun[0], (Bytes{0x0C, 8}));
  EXPECT_EQ(begun[1], (Bytes{0x0C, 4}));
  EXPECT_EQ(begun[2], (Bytes{0x0C, 1}));
  const auto has = [&](const Bytes& report) {
    const auto all = bed_->written(0);
    return std::find(all.begin(), all.end(), report) != all.end();
  };
  for (const std::uint8_t block : {1, 2, 3}) EXPECT_TRUE(has({0x0A, block, 1, 1})) << "started";

  const auto wish = [&](const PidWish& wanted, const Bytes& expected) {
    return until([&] {
      (*device)->set(wanted);
      return has(expected);
    });
  };
  EXPECT_TRUE(wish({.right = 0.5}, {5, 1, 0x00, 0x40}));
  EXPECT_TRUE(
      wish({.right = 0.5, .damping = 0.25}, {3, 2, 0, 0, 0, 0x00, 0x20, 0x00, 0x20, 0xFF, 0x7F, 0xFF, 0x7F, 0, 0}));
  EXPECT_TRUE(wish({.shake = 1, .shake_hz = 50}, {4, 3, 0xFF, 0x7F, 0, 0, 0, 0, 20, 0, 0, 0}));
  bed_->forgetWritten(0);
  ASSERT_TRUE(until([&] { return has({4, 3, 0, 0, 0, 0, 0, 0, 17, 0, 0, 0}); })) << "nobody repeats the wish";

  // Its effects last 100 ms: they are started again and again while this program lives.
  EXPECT_TRUE((*device)->stopsByItself());
  for (const Bytes& report : begun) {
    const bool sets_effect = report[0] == 1;
    EXPECT_TRUE(!sets_effect || (report[3] == 100 && report[4] == 0)) << "no effect is endless";
  }
  for (const std::uint8_t block : {1, 2, 3}) {
    bed_->forgetWritten(0);
    EXPECT_TRUE(until([&] { return has({0x0A, block, 1, 1}); })) << "started again";
  }

  device->reset();
  const std::vector<Bytes> ended = bed_->written(0);
  ASSERT_GE(ended.size(), 5u);
  EXPECT_EQ(std::vector<Bytes>(ended.end() - 5, ended.end()),
            (std::vector<Bytes>{{0x0C, 4}, {0x0B, 1}, {0x0B, 2}, {0x0B, 3}, {0x0C, 2}}));
}

TEST_F(PidDevices, AForceThatItDidNotTakeIsToldAgain) {
  plugIn(3);
  auto device = PidDevice::open(listHid().front());
  ASSERT_TRUE(device) << device.error().message();
  const Bytes pushes{5, 1, 0x00, 0x40}, rest{5, 1, 0, 0};
  const auto isTold = [&](const PidWish& wish, const Bytes& expected) {
    return until([&] {
      (*device)->set(wish);
      const auto all = bed_->written(0);
      return std::find(all.begin(), all.end(), expected) != all.end();
    });
  };
  ASSERT_TRUE(isTold({.right = 0.5}, pushes));
  bed_->loseWrites(0, [rest, n = 0](const Bytes& report) mutable { return report == rest && n++ == 0; });
  bed_->forgetWritten(0);
  EXPECT_TRUE(isTold({}, rest));
}

TEST_F(PidDevices, AnArduinosEffectsAreCreatedStartedAndFreed) {
  plugIn(3, arduinoDescriptor(), 6);
  auto device = PidDevice::open(listHid().front());
  ASSERT_TRUE(device) << device.error().message();
  {
    const std::lock_guard lock(mutex_);
    EXPECT_EQ(created_, (std::vector<Bytes>{{5, 1, 0, 0}, {5, 9, 0, 0}, {5, 4, 0, 0}}));
  }
  EXPECT_TRUE((*device)->stopsByItself());
  ASSERT_TRUE(until([&] {
    (*device)->set({.right = 0.5});
    const auto all = bed_->written(0);
    return std::find(all.begin(), all.end(), Bytes{5, 1, 0x88, 0x13}) != all.end();
  }));
  device->reset();
  EXPECT_EQ(bed_->written(0).back(), (Bytes{0x0C, 2}));
}

TEST_F(PidDevices, AFullPoolIsSaidAndNothingStaysBehind) {
  plugIn(0);
  const auto device = PidDevice::open(listHid().front());
  ASSERT_FALSE(device);
  EXPECT_NE(device.error().message().find("full pool"), std::string::npos) << device.error().message();
  EXPECT_EQ(bed_->written(0).back(), (Bytes{0x0C, 2})) << "actuators off";
}

}  // namespace
}  // namespace kerf::pid_device_test
