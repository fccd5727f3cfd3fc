#include "ui/app/hand_commands.h"

#include <numbers>

#include "ui/app/command_words.h"

namespace kerf::hand_commands {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

}  // namespace

bool isTilted(const AppContext& c) { return !c.bench.tilt.isUpright(); }

Expected<void> tilt(AppContext& c, AppWords words) {
  constexpr double kUpwards = 90;
  const double before = isTilted(c) ? azimuthInView(c.camera, c.bench.tilt) / kDegree : kUpwards;
  KERF_TRY(angle, numberOf(words, 0, "DEG", 0, Tilt::kMost / kDegree));
  KERF_TRY(azimuth, numberOr(words, 1, before, "AZIMUTH", -360, 360));
  c.bench.tilt = tiltInView(c.camera, angle * kDegree, azimuth * kDegree);
  return {};
}

Expected<void> resetTilt(AppContext& c, AppWords) {
  c.bench.tilt = {};
  return {};
}

}  // namespace kerf::hand_commands
