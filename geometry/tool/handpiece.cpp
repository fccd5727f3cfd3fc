#include "geometry/tool/handpiece.h"

namespace kerf {
namespace {

// Turbines: 41 of them stalled at up to 2.33 N mm (Brockhurst & Shams 1994); a usual one has about 1 N mm at 380 000
// rpm. With a rotor of 8e-9 kg m^2 that is a time constant of 0.32 s, and a bearing of 0.1 N mm takes 3.2 s.
constexpr Handpiece kHandpieces[] = {
    {"turbine", "air turbine, friction grip: stalls under a heavy hand, runs down by itself", DriveForm::kTurbine, true,
     380000, 1.0, 0.32, 3.2, 0},
    {"turbine-brake", "the same with a brake of 0.5 N mm when the air is off", DriveForm::kTurbine, true, 380000, 1.0,
     0.32, 0.53, 0},
    {"electric", "electric motor with a 1:5 contra-angle, friction grip", DriveForm::kGoverned, true, 200000, 4.5, 0.3,
     0, 0.02},
    {"contra-angle", "electric motor, 1:1 contra-angle", DriveForm::kGoverned, false, 40000, 20, 0.3, 0, 0.02},
    {"straight", "electric motor, straight handpiece", DriveForm::kGoverned, false, 20000, 30, 0.3, 0, 0.02},
    {"implant", "implant motor with a reducing contra-angle; 1750 rpm over the diameter in mm", DriveForm::kGoverned,
     false, 0, 500, 0.3, 0, 0.02},
};

}  // namespace

std::span<const Handpiece> handpieces() noexcept { return kHandpieces; }

const Handpiece* findHandpiece(std::string_view name) noexcept {
  for (const Handpiece& row : kHandpieces)
    if (name == row.name) return &row;
  return nullptr;
}

std::string handpieceNames() {
  std::string out;
  for (const Handpiece& row : kHandpieces) out += (out.empty() ? "" : ", ") + std::string(row.name);
  return out;
}

}  // namespace kerf
