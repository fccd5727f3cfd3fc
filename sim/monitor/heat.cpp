#include "sim/monitor/heat.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace kerf {
namespace {

const char* const kLin = "Lin et al. 2010, doi 10.1016/j.infrared.2010.09.004: conductivity, and diffusivity of which";
const ThermalProperties kEnamelHeat{0.81, 0.81 / 0.408, kLin};
const ThermalProperties kDentinHeat{0.48, 0.48 / 0.201, kLin};
const ThermalProperties kCariesHeat{0.48, 0.48 / 0.201, "as dentin"};
const ThermalProperties kCorticalHeat{0.55, 2.5, "0.5-0.6 W/(m K), 1.9 g/cm3 x 1.3 J/(g K): textbook, not looked up"};
const ThermalProperties kCancellousHeat{0.4, 2.9, "between bone and marrow: textbook, not looked up"};
const ThermalProperties kSoftHeat{0.5, 3.8, "soft tissue, near water's 0.6 and 4.2: textbook, not looked up"};
const ThermalProperties kGenericHeat{0.55, 2.5, "as cortical bone"};

constexpr double kLongest = 1e6;  // s: of contact, and without

double boundedHeat(double x, double most = 1e9) noexcept { return std::isfinite(x) ? std::clamp(x, 0.0, most) : 0; }
bool isBone(Material m) noexcept { return m == Material::kCortical || m == Material::kCancellous; }

}  // namespace

const ThermalProperties& thermalProperties(Material material) noexcept {
  switch (material) {
    case Material::kEnamel:
      return kEnamelHeat;
    case Material::kDentin:
      return kDentinHeat;
    case Material::kCaries:
      return kCariesHeat;
    case Material::kCortical:
      return kCorticalHeat;
    case Material::kCancellous:
      return kCancellousHeat;
    case Material::kPulp:
    case Material::kNerveCanal:
    case Material::kGingiva:
    case Material::kPdl:
      return kSoftHeat;
    default:
      return kGenericHeat;
  }
}

HeatSource heatSource(const Tool& tool) {
  constexpr double kDiamond = 0.03, kFastCarbide = 0.018, kCarbide = 0.10, kSteel = 0.15, kPiezo = 0.20;
  HeatSource out;
  if (tool.kind == ToolKind::kBlade) {
    const bool is_disc = motionOf(tool) == ToolMotion::kSpin;
    out.share = is_disc ? kDiamond : tool.motion->name == std::string_view("piezo") ? kPiezo : kSteel;
    out.spray_film = 5;
    out.flank = is_disc ? Vec3d::UnitZ() : Vec3d::UnitY();
    return out;
  }
  if (isDrill(tool)) {
    const double radius = 0.5 * tool.head_diameter_mm;
    out.share = kSteel;
    out.spray_film = 2;
    out.least_area = std::max(out.least_area, std::numbers::pi * radius * radius);
    return out;
  }
  const std::string material = tool.iso ? tool.iso->material : "";
  out.share = material == "806"      ? kDiamond
              : material == "310"    ? kSteel
              : isFrictionGrip(tool) ? kFastCarbide
                                     : kCarbide;
  return out;
}

void HeatProbes::watch(const Vec3d& place, const HeatPulses& pulses, double time) noexcept {
  if (!place.allFinite()) return;
  std::size_t oldest = 0, coolest = 0;
  bool any_old = false;
  for (std::size_t n = 0; n < static_cast<std::size_t>(count_); ++n) {
    const Probe& probe = probes_[n];
    if ((probe.place - place).squaredNorm() < kApart * kApart) return;
    if (probe.since < probes_[oldest].since) oldest = n;
    if (time - probe.since < kYoung) continue;
    if (!any_old || probe.rise < probes_[coolest].rise) coolest = n;
    any_old = true;
  }
  const std::size_t goes = any_old ? coolest : oldest;
  probes_[count_ < kMost ? static_cast<std::size_t>(count_++) : goes] = {place, pulses.riseAt(place, time), time};
}

void HeatProbes::step(const HeatPulses& pulses, double time) noexcept {
  if (count_ == 0) return;
  Probe& probe = probes_[static_cast<std::size_t>(next_)];
  probe.rise = pulses.riseAt(probe.place, time);
  next_ = (next_ + 1) % count_;
}

double HeatProbes::rise() const noexcept {
  if (count_ == 0) return 0;
  double most = probes_[0].rise;
  for (std::size_t n = 1; n < static_cast<std::size_t>(count_); ++n) most = std::max(most, probes_[n].rise);
  return most;
}

Heat::Heat(const HeatSource& source, const HeatSettings& settings) noexcept : source_(source), settings_(settings) {}

void Heat::step(const HeatInput& in, double dt) noexcept {
  if (!(dt > 0 && dt < 1e9)) return;
  time_ += dt;
  if (in.is_touching)
    touch(in, dt);
  else
    leave(dt);

  pulse_age_ += dt;
  if (pulse_age_ >= kPulse - 0.5 * dt) closePulse();
  for (HeatProbes& probes : probes_) probes.step(pulses_, time_);
  alarm(dt);
  ++ticks_;
}

void Heat::touch(const HeatInput& in, double dt) noexcept {
  // New tissue, or the place it left.
  const Vec3d place = in.place.allFinite() ? in.place : place_;
  if (away_ > kMean && (place - place_).norm() > 2 * radius_) contact_ = 0;
  if (away_ > kMean) averaged_ = 0;
  away_ = 0;
  contact_ = std::min(contact_ + dt, kLongest);

  // Means of the inputs.
  averaged_ += dt;
  const double blend = std::min(1.0, dt / std::min(averaged_, kMean));
  const ThermalProperties& tissue = thermalProperties(in.material);
  const auto mean = [blend](double& of, double now) { of += blend * (now - of); };
  mean(power_, boundedHeat(in.power));
  mean(area_, boundedHeat(in.area));
  mean(removal_, boundedHeat(in.removed / dt));
  mean(conductivity_, tissue.conductivity);
  mean(capacity_, tissue.heat_capacity);
  if (in.velocity.allFinite()) velocity_ += blend * (in.velocity - velocity_);

  // Heat losses, each a conductance, mW/K.
  const double wet = boundedHeat(in.irrigation, 1);
  const double area = std::max(area_, std::max(source_.least_area, 1e-6));
  radius_ = std::sqrt(area / std::numbers::pi);
  dwell_ = std::min(contact_, 2 * radius_ / std::max(velocity_.norm(), 1e-9));
  const double effusivity = std::sqrt(conductivity_ * capacity_);
  const double into_tissue =
      area * effusivity * std::sqrt(std::numbers::pi / (4 * dwell_)) + std::numbers::pi * conductivity_ * radius_;
  const double film = (settings_.air_film + wet * (source_.spray_film - settings_.air_film)) * area;
  const double chips = capacity_ * removal_;

  // Temperature.
  const double share = source_.share * (1 - wet * (1 - settings_.spray_share));
  const double coolant = wet * settings_.coolant_rise;
  surface_ = (share * power_ + film * coolant) / (into_tissue + film + chips);
  if (surface_ > settings_.boiling_rise)
    surface_ = settings_.boiling_rise + (1 - wet) * (surface_ - settings_.boiling_rise);

  left_at_ = surface_;
  place_ = place;
  material_ = in.material;
  conduct(in, into_tissue * surface_, dt);
}

void Heat::leave(double dt) noexcept {
  away_ = std::min(away_ + dt, kLongest);
  contact_ = std::max(0.0, contact_ - dt);
  const double share = std::max(0.0, 1 - dt / kMean);
  power_ *= share;
  removal_ *= share;
  if (left_at_ == 0) return;
  const double x = away_ / std::max(dwell_, dt);
  surface_ = left_at_ * (std::sqrt(1 + x) - std::sqrt(x));
}

void Heat::conduct(const HeatInput& in, double flow, double dt) noexcept {
  if (in.is_elsewhere) return;
  pulse_energy_ += flow * dt;
  pulse_s_ += dt;
  pulse_place_ += dt / pulse_s_ * (place_ - pulse_place_);
}

void Heat::closePulse() noexcept {
  if (pulse_s_ > 0) pulses_.add(pulse_energy_, pulse_place_, time_ - 0.5 * pulse_age_, {conductivity_, capacity_, ""});
  pulse_energy_ = pulse_s_ = pulse_age_ = 0;
}

void Heat::watch(Structure structure, const Vec3d& point) noexcept { probes_[structure].watch(point, pulses_, time_); }

void Heat::alarm(double dt) noexcept {
  constexpr unsigned kEvery = 16;  // ticks: half a millimetre away nothing changes sooner
  if (rise(kPulp) >= kPulpLimitRise && alarms_.pulp < 0) alarms_.pulp = time_;
  if (!isBone(material_)) return;

  if (ticks_ % kEvery == 0) beside_ = riseBelow(radius_ + kBoneMargin);
  if (surface_ >= kBoneLimitRise && alarms_.bone_warm < 0) alarms_.bone_warm = time_;
  if (beside_ < kBoneLimitRise) return;
  alarms_.bone_exposure += dt;
  if (alarms_.bone_dead < 0 && alarms_.bone_exposure >= kBoneLimitSeconds - 0.5 * dt) alarms_.bone_dead = time_;
}

double Heat::riseAt(const Vec3d& place) const noexcept { return place.allFinite() ? pulses_.riseAt(place, time_) : 0; }

double Heat::riseBelow(double depth) const noexcept {
  return std::isfinite(depth) ? pulses_.riseAt(place_, time_, depth) : 0;
}

}  // namespace kerf
