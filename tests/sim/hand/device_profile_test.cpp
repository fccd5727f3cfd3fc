#include "sim/hand/device_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bench/scenes/held_device.h"
#include "sim/step/device_sample.h"

namespace kerf::device_profile_test {
namespace {

TEST(DeviceProfile, TheCouplingIsThatOfTheFormula) {
  struct Row {
    double delay_ms, mass_kg, friction, encoder_mm, stiffness;
    CouplingBound bound;
  };
  const Row rows[] = {
      {1, 0.08, 0.05, 0.03, 1, CouplingBound::kNone},
      {2, 0.08, 0.02, 0.03, 0.02 / 0.03 / std::numbers::sqrt2, CouplingBound::kEncoder},
      {2, 0.08, 0.02, 0.055, 0.02 / 0.055 / std::numbers::sqrt2, CouplingBound::kEncoder},
      {4, 0.05, 0.05, 0.03, 0.2 * 0.05e-3 / (0.0045 * 0.0045), CouplingBound::kMass},
      {5, 0.03, 0.05, 0.005, 0.2 * 0.03e-3 / (0.0055 * 0.0055), CouplingBound::kMass},
      {1, 0.08, 0, 0.05, 0.01 / 0.05 / std::numbers::sqrt2,
       CouplingBound::kEncoder},  // the minimum of friction is 0.01 N
      {1, 0.08, 0, 0, 1, CouplingBound::kNone},
  };
  const double gain = 1 - std::exp(-2 * std::numbers::pi * 150 * kTick);
  for (const Row& row : rows) {
    DeviceProfile p;
    p.delay_s = 1e-3 * row.delay_ms;
    p.mass_kg = row.mass_kg;
    p.friction = row.friction;
    p.encoder_mm = row.encoder_mm;
    const DeviceCoupling coupling = couplingFor(p);
    const CouplingSettings& c = coupling.settings;
    const double tau = p.delay_s + kTick / 2, friction = std::max(row.friction, 0.01);
    EXPECT_NEAR(c.stiffness, row.stiffness, 1e-9);
    EXPECT_EQ(coupling.bound, row.bound);
    EXPECT_EQ(c.filter_hz, 150);
    EXPECT_NEAR(c.running_damping, c.stiffness * tau + 0.002, 1e-12);
    EXPECT_GE(c.damping, 0.7 * c.stiffness * tau - 1e-12);
    EXPECT_LE(c.damping, c.running_damping);
    // An encoder step kicks the hand by at most twice its friction, unless the delay demands more.
    if (c.damping > 0.7 * c.stiffness * tau + 1e-12) {
      EXPECT_LE(c.damping * gain * row.encoder_mm / kTick, 2 * friction + 1e-12);
    }
    // Values that do not depend on the profile stay.
    EXPECT_EQ(c.turn_stiffness, CouplingSettings{}.turn_stiffness);
    EXPECT_EQ(c.force_limit, CouplingSettings{}.force_limit);
  }
}

TEST(DeviceProfile, TurningHasItsOwnBounds) {
  DeviceProfile p;
  p.delay_s = 0.001;
  p.inertia_kgmm2 = 50;
  p.turn_friction = 0.2;
  p.encoder_rad = 0.5e-3;
  const DeviceCoupling coupling = couplingFor(p);
  EXPECT_EQ(coupling.turn_bound, CouplingBound::kEncoder);
  EXPECT_NEAR(coupling.settings.turn_stiffness, 0.2 / 0.5e-3 / std::numbers::sqrt2, 1e-9);
  EXPECT_NEAR(coupling.settings.running_turn_damping, 400 / std::numbers::sqrt2 * 0.0015 + 2, 1e-9);
}

TEST(DeviceProfile, ItSaysWhyTheCouplingIsSofter) {
  DeviceProfile p;
  EXPECT_EQ(describeStiffness(couplingFor(p), {}),
            "0.471 N/mm, 1 wanted: the steps of its encoder are coarse for its friction");
  p.friction = 0.1;
  EXPECT_EQ(describeStiffness(couplingFor(p), {}), "1 N/mm");
  p.delay_s = 0.006;
  EXPECT_EQ(describeStiffness(couplingFor(p), {}), "0.379 N/mm, 1 wanted: the device is light for its delay");
}

TEST(HeldDevice, LosesWhatFrictionAndDampingTakeAndGainsWhatMotorsGive) {
  scenes::HeldDeviceNumbers n;
  n.step = 0;
  n.delay_s = 0;
  // Pulled with a constant force from rest: the work of the motors goes to the device's own losses and to hand and
  // grip.
  scenes::HeldDevice device(n, Vec3d::Zero());
  for (int i = 0; i < 3000; ++i) device.tick({0.5, 0, 0}, Vec3d::Zero());
  const double stiffness = n.arm * n.grip / (n.arm + n.grip);
  EXPECT_NEAR(device.position()[0], 0.5 / stiffness, (n.friction + 0.01) / stiffness);
  EXPECT_GT(device.given(), 0);
  EXPECT_LT(device.given(), 0.5 * device.position()[0]);
}

TEST(HeldDevice, ReadsWholeStepsOfTheEncoderAndFeelsForcesLate) {
  scenes::HeldDeviceNumbers n;
  n.step = 0.05;
  n.delay_s = 0.003;
  scenes::HeldDevice device(n, {0.11, 0, 0});
  EXPECT_NEAR(device.read()[0], 0.1, 1e-12);
  for (int i = 0; i < 3; ++i) {
    device.tick({5, 0, 0}, {0.11, 0, 0});
    EXPECT_EQ(device.position()[0], 0.11) << i;
  }
  device.tick({5, 0, 0}, {0.11, 0, 0});
  EXPECT_GT(device.position()[0], 0.11);
}

}  // namespace
}  // namespace kerf::device_profile_test
