#include "bench/scenes/held_device.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "sim/step/device_sample.h"

namespace kerf::scenes {
namespace {

constexpr int kParts = 20;        // of a tick
constexpr double kTonnes = 1e-3;  // of a kg

// Gives the same numbers on every machine, unlike the distributions of the standard library.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  double unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * unit(); }
  double logUniform(double low, double high) { return low * std::exp(unit() * std::log(high / low)); }
  double oneOf(double a, double b, double c) {
    const double u = unit();
    return u < 1.0 / 3 ? a : u < 2.0 / 3 ? b : c;
  }
  // Shoemake's uniform rotation.
  Eigen::Quaterniond rotation() {
    const double u = unit(), a = uniform(0, 2 * std::numbers::pi), b = uniform(0, 2 * std::numbers::pi);
    return {std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a), std::sqrt(1 - u) * std::cos(a),
            std::sqrt(u) * std::sin(b)};
  }

 private:
  std::mt19937_64 random_;
};

// Damping of a damper beside a spring, as a share of critical damping.
double damper(double share, double stiffness, double mass) { return 2 * share * std::sqrt(stiffness * mass); }

void drawHand(Draw& draw, HeldDeviceNumbers& n) {
  n.delay_s = draw.uniform(0.001, 0.005);
  n.hand_mass = kTonnes * draw.logUniform(0.05, 0.4);
  n.grip = draw.unit() < 0.5 ? draw.uniform(0.3, 2) : draw.uniform(3, 10);
  n.arm = draw.logUniform(0.05, 0.8);
  n.grip_damping = damper(draw.uniform(0.05, 0.3), n.grip, n.mass);
  n.arm_damping = damper(draw.uniform(0.25, 0.7), n.arm, n.hand_mass);
  n.axes = draw.rotation();
}

}  // namespace

DeviceProfile HeldDeviceNumbers::profile() const {
  DeviceProfile p;
  p.delay_s = delay_s;
  p.mass_kg = mass / kTonnes;
  p.friction = friction;
  p.encoder_mm = step;
  return p;
}

DeviceProfile HeldDeviceNumbers::turningProfile() const {
  DeviceProfile p;
  p.delay_s = delay_s;
  p.inertia_kgmm2 = mass / kTonnes;
  p.turn_friction = friction;
  p.encoder_rad = step;
  return p;
}

HeldDeviceNumbers randomDevice(std::uint64_t seed, double least_friction) {
  Draw draw(seed);
  HeldDeviceNumbers n;
  n.mass = kTonnes * draw.logUniform(0.03, 0.3);
  n.damping = draw.logUniform(1e-4, 2e-3);
  n.friction = draw.unit() < 1.0 / 3 ? least_friction : draw.uniform(least_friction, 0.05);
  n.step = draw.oneOf(0.005, 0.03, 0.055);
  drawHand(draw, n);
  return n;
}

HeldDeviceNumbers randomTurningDevice(std::uint64_t seed) {
  Draw draw(seed);
  HeldDeviceNumbers n;
  constexpr double kLever = 50;  // mm from the tip to the grip of the hand
  drawHand(draw, n);
  n.mass = draw.logUniform(2e-5, 2e-4) * 1e6 * kTonnes;
  n.damping = draw.logUniform(1e-4, 2e-3) * kLever * kLever;
  n.friction = draw.uniform(0.1, 0.5);
  n.step = draw.oneOf(0.05e-3, 0.2e-3, 0.5e-3);
  n.hand_mass *= kLever * kLever;
  n.grip *= kLever * kLever;
  n.arm *= kLever * kLever;
  n.grip_damping = damper(draw.uniform(0.05, 0.3), n.grip, n.mass);
  n.arm_damping *= kLever * kLever;
  n.axes = Eigen::Quaterniond::Identity();
  return n;
}

HeldDeviceNumbers idealised(HeldDeviceNumbers numbers) {
  numbers.delay_s = 0;
  numbers.step = 0;
  numbers.friction = 0.05;
  return numbers;
}

HeldDevice::HeldDevice(const HeldDeviceNumbers& numbers, const Vec3d& start)
    : n_(numbers), device_(start), hand_(start), wanted_(start) {}

Vec3d HeldDevice::read() const {
  if (n_.step <= 0) return device_;
  const Vec3d steps = ((n_.axes.conjugate() * device_) / n_.step).array().round();
  return n_.axes * Vec3d(n_.step * steps);
}

void HeldDevice::tick(const Vec3d& force, const Vec3d& wanted) {
  constexpr double dt = kTick / kParts;
  late_.push_back({part_ + std::lround(n_.delay_s / dt), force});
  const Vec3d start = wanted_, wanted_speed = (wanted - wanted_) / kTick;

  for (int n = 0; n < kParts; ++n, ++part_) {
    for (; !late_.empty() && late_.front().at <= part_; late_.pop_front()) force_ = late_.front().force;
    wanted_ = start + (n + 1) * dt * wanted_speed;

    const Vec3d held = n_.grip * (hand_ - device_) + n_.grip_damping * (hand_speed_ - device_speed_);
    const Vec3d pulled = n_.arm * (wanted_ - hand_) + n_.arm_damping * (wanted_speed - hand_speed_);
    hand_speed_ += dt / n_.hand_mass * (pulled - held);
    // Implicit damping. Coulomb friction takes its share without reversing the motion.
    const Vec3d v = (n_.mass * device_speed_ + dt * (force_ + held)) / (n_.mass + dt * n_.damping);
    const double most = dt * n_.friction / n_.mass, moving = v.norm();
    device_speed_ = moving <= most ? Vec3d(Vec3d::Zero()) : Vec3d(v * (1 - most / moving));

    const Vec3d way = dt * device_speed_;
    work_ += force_.dot(way);
    lost_ += n_.damping * device_speed_.squaredNorm() * dt + n_.friction * way.norm();
    hand_ += dt * hand_speed_;
    device_ += way;
  }
  wanted_ = wanted;
}

}  // namespace kerf::scenes
