#include "sim/monitor/heat.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr double kSlowest = 1e-7;  // 1/s
const double kRatio = std::sqrt(10.0);
constexpr double kFirstCell = 0.02, kGrowth = 1.12;  // mm; 48 cells reach 38 mm, beyond any tissue's warmth in minutes

const char* const kLin = "Lin et al. 2010, doi 10.1016/j.infrared.2010.09.004: conductivity, and diffusivity of which";
const ThermalProperties kEnamelHeat{0.81, 0.81 / 0.408, kLin};
const ThermalProperties kDentinHeat{0.48, 0.48 / 0.201, kLin};
const ThermalProperties kCariesHeat{0.48, 0.48 / 0.201, "as dentin"};
const ThermalProperties kCorticalHeat{0.55, 2.5, "0.5-0.6 W/(m K), 1.9 g/cm3 x 1.3 J/(g K): textbook, not looked up"};
const ThermalProperties kCancellousHeat{0.4, 2.9, "between bone and marrow: textbook, not looked up"};
const ThermalProperties kSoftHeat{0.5, 3.8, "soft tissue, near water's 0.6 and 4.2: textbook, not looked up"};
const ThermalProperties kGenericHeat{0.55, 2.5, "as cortical bone"};

double usable(double x, double most = 1e9) noexcept { return std::isfinite(x) ? std::clamp(x, 0.0, most) : 0; }
bool isBone(Material m) noexcept { return m == Material::kCortical || m == Material::kCancellous; }

}  // namespace

double ThermalProperties::effusivity() const noexcept { return std::sqrt(conductivity * heat_capacity); }

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

Heat::Heat(const HeatSettings& settings) noexcept : settings_(settings) {
  // Trapezoid over u = ln xi, exact to 5e-4 at two points a decade: the integrand is smooth in u. Slower ones than the
  // first would take hours to matter.
  const double du = std::log(kRatio);
  for (std::size_t i = 0; i < kStates; ++i) {
    rate_[i] = kSlowest * std::pow(kRatio, static_cast<double>(i));
    weight_[i] = du * std::sqrt(rate_[i]) / std::numbers::pi;
  }
  // What the endless rest adds at once: a geometric series of weight / rate.
  const double r = 1 / std::sqrt(kRatio);
  instant_ = weight_[kStates - 1] / rate_[kStates - 1] * r / (1 - r);

  double at = 0, width = kFirstCell;
  for (std::size_t i = 0; i < kCells; ++i, width *= kGrowth) {
    width_[i] = width;
    depth_[i] = at + 0.5 * width;
    at += width;
  }
}

void Heat::step(const HeatInput& in, double dt) noexcept {
  if (!(dt > 0 && dt < 1e9)) return;
  if (dt != dt_) setTick(dt);

  // Heat that enters.
  const ThermalProperties& tissue = thermalProperties(in.material);
  const double wet = usable(in.irrigation, 1);
  const double touched = usable(in.area);
  const double area = std::max(touched, std::max(settings_.least_area, 1e-6));
  const double share = settings_.dry_share + wet * (settings_.wet_share - settings_.dry_share);
  const double flux = touched > 0 ? share * usable(in.power) / area : 0;
  if (touched > 0) radius_ = std::sqrt(area / std::numbers::pi);

  // Ways out, each a conductance, mW/(mm^2 K).
  const double film = settings_.air_film + wet * (settings_.spray_film - settings_.air_film);
  const double coolant = wet * settings_.coolant_rise;
  double losses = film;
  if (settings_.spreads_sideways && radius_ > 0) losses += tissue.conductivity / radius_;
  if (touched > 0) losses += tissue.heat_capacity * usable(in.removed) / (area * dt);

  // The surface at the end of the tick, T = past + gain (flux + film coolant - losses T) / e, solved for T: stable
  // whatever the losses. States hold flux / e, so that another tissue changes what comes, not what is there.
  const double inverse = 1 / tissue.effusivity();
  double past = 0;
  for (std::size_t i = 0; i < kStates; ++i) past += weight_[i] * decay_[i] * state_[i];
  surface_ = (past + gain_ * inverse * (flux + film * coolant)) / (1 + gain_ * inverse * losses);
  const double drive = inverse * (flux + film * coolant - losses * surface_);
  for (std::size_t i = 0; i < kStates; ++i) state_[i] = decay_[i] * state_[i] + (1 - decay_[i]) / rate_[i] * drive;
  stepColumn(tissue.diffusivity(), dt);
  time_ += dt;

  // Alarms.
  if (isBone(in.material) && surface_ >= kBoneLimitRise) {
    if (alarms_.bone_warm < 0) alarms_.bone_warm = time_;
    alarms_.bone_exposure += dt;
    if (alarms_.bone_dead < 0 && alarms_.bone_exposure >= kBoneLimitSeconds - 0.5 * dt) alarms_.bone_dead = time_;
  }
  pulp_ = in.pulp_depth >= 0 && std::isfinite(in.pulp_depth) ? riseAt(in.pulp_depth) : 0;
  if (pulp_ >= kPulpLimitRise && alarms_.pulp < 0) alarms_.pulp = time_;
}

void Heat::setTick(double dt) noexcept {
  dt_ = dt;
  gain_ = instant_;
  for (std::size_t i = 0; i < kStates; ++i) {
    decay_[i] = std::exp(-rate_[i] * dt);
    gain_ += weight_[i] * (1 - decay_[i]) / rate_[i];
  }
}

// Backward Euler in finite volumes, the surface given, no flux at the far end; Thomas' elimination.
void Heat::stepColumn(double diffusivity, double dt) noexcept {
  std::array<double, kCells> above;
  double from_before = 2 * diffusivity * dt / width_[0], previous_above = 0, previous = surface_;
  for (std::size_t i = 0; i < kCells; ++i) {
    const double to_next = i + 1 < kCells ? diffusivity * dt / (depth_[i + 1] - depth_[i]) : 0;
    // width T - from_before (T_before - T) - to_next (T_next - T) = width T_old
    const double pivot = width_[i] + from_before * (1 - previous_above) + to_next;
    above[i] = to_next / pivot;
    cell_[i] = (width_[i] * cell_[i] + from_before * previous) / pivot;
    previous = cell_[i];
    previous_above = above[i];
    from_before = to_next;
  }
  for (std::size_t i = kCells - 1; i-- > 0;) cell_[i] += above[i] * cell_[i + 1];
}

double Heat::riseAt(double depth) const noexcept {
  if (!(depth > 0)) return surface_;
  // Below a disc on its axis, settled: q / k (sqrt(z^2 + a^2) - z), of a wide one q a / k.
  const double z = settings_.spreads_sideways && radius_ > 0 ? std::min(depth, 1e6) / radius_ : 0;
  const double narrowing = 1 / (std::sqrt(1 + z * z) + z);
  if (depth >= depth_[kCells - 1]) return narrowing * cell_[kCells - 1];
  std::size_t i = 0;
  while (depth > depth_[i]) ++i;
  const double before = i == 0 ? 0 : depth_[i - 1], low = i == 0 ? surface_ : cell_[i - 1];
  return narrowing * (low + (cell_[i] - low) * (depth - before) / (depth_[i] - before));
}

}  // namespace kerf
