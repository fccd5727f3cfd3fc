#include "ui/app/tool/hindrance.h"

#include <cmath>

namespace kerf {
namespace {

constexpr double kSmooth = 0.3;   // s
constexpr double kLasts = 0.8;    // s until Kerf reports it
constexpr double kFelt = 0.05;    // N
constexpr double kNoRate = 0.01;  // mm3/s: a 1 mm bur at 0.5 N removes at least ten times as much
constexpr double kStandsStill = 0.05;

double removedIn(const HapticReport& report) {
  double out = 0;
  for (std::size_t n = 0; n < report.object_count; ++n) out += report.objects[n].removed_mm3;
  return out;
}

}  // namespace

void Hindrance::update(const HapticReport& report, bool is_cutting, double drive_share) {
  const double removed = removedIn(report);
  if (!is_cutting || report.tick < tick_) *this = {};
  const double seconds = tick_ > 0 ? static_cast<double>(report.tick - tick_) * kTick : 0;
  if (is_cutting && seconds > 0) {
    const double share = 1 - std::exp(-seconds / kSmooth);
    load_ += share * (report.output.normal_load - load_);
    on_cutting_part_ += share * (report.output.cutting_load - on_cutting_part_);
    drive_ += share * (std::abs(drive_share) - drive_);
    rate_ += share * ((removed - removed_mm3_) / seconds - rate_);
    const Kind before = kind_;
    kind_ = now();
    lasts_s_ = kind_ == before ? lasts_s_ + seconds : 0;
  }
  tick_ = report.tick;
  removed_mm3_ = removed;
}

Hindrance::Kind Hindrance::now() const {
  if (load_ < kFelt || rate_ > kNoRate) return Kind::kNone;
  if (on_cutting_part_ < 0.5 * load_) return Kind::kBody;
  return drive_ < kStandsStill ? Kind::kDrive : Kind::kNone;
}

const char* Hindrance::text() const {
  if (lasts_s_ < kLasts || kind_ == Kind::kNone) return "";
  return kind_ == Kind::kBody ? "The neck or shank rests on the tissue and does not cut. Choose another tool, widen "
                                "the opening, or tilt the tool."
                              : "The drive stalled. Push less, or raise the spindle speed.";
}

}  // namespace kerf
