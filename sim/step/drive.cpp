#include "sim/step/drive.h"

#include <algorithm>
#include <cmath>

#include "sim/step/device_sample.h"

namespace kerf {
namespace {

double lineSpeed(const ToolDrive& drive, double speed, double pedal, double load) {
  const double wanted = pedal * drive.speed * std::max(0.0, 1 - load);
  const double follow = drive.time_constant > 0 ? 1 - std::exp(-kTick / drive.time_constant) : 1;
  return speed + follow * (wanted - speed);
}

double turbineSpeed(const ToolDrive& drive, double speed, double pedal, double load) {
  if (!(drive.time_constant > 0)) return lineSpeed(drive, speed, pedal, load);
  double push = (pedal * pedal - load) * drive.speed / drive.time_constant;
  if (pedal == 0 && drive.run_down > 0) push -= drive.speed / drive.run_down;

  // Solves ds/dt = push - rate s exactly.
  const double rate = pedal / drive.time_constant;
  const double x = rate * kTick;
  const double mean = x > 1e-9 ? -std::expm1(-x) / x : 1;
  return std::max(0.0, speed * (1 - x * mean) + push * kTick * mean);
}

// Forwards: neither speed nor result is negative.
double governedSpeed(const ToolDrive& drive, double speed, double pedal, double load) {
  const double wanted = pedal * drive.speed * (1 - drive.droop * std::min(1.0, load));
  if (!(drive.time_constant > 0)) return load < 1 ? std::max(0.0, wanted) : 0;

  constexpr double kLag = 0.1;  // of the time constant
  const double follow = 1 - std::exp(-kTick / (kLag * drive.time_constant));
  const double most = drive.speed * kTick / drive.time_constant;
  return std::max(0.0, speed + std::clamp(follow * (wanted - speed), -most * (1 + load), most * (1 - load)));
}

}  // namespace

double speedAfterTick(const ToolDrive& drive, double speed, double pedal, double load) noexcept {
  const double forwards = std::max(0.0, pedal);
  switch (drive.form) {
    case DriveForm::kTurbine:
      return turbineSpeed(drive, speed, forwards, load);
    case DriveForm::kGoverned: {
      const bool is_backwards = speed < 0 || (speed == 0 && pedal < 0);
      return is_backwards ? -governedSpeed(drive, -speed, -pedal, load) : governedSpeed(drive, speed, pedal, load);
    }
    case DriveForm::kLine:
      break;
  }
  return lineSpeed(drive, speed, forwards, load);
}

}  // namespace kerf
