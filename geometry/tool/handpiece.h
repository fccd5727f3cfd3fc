// Drives of rotary tools: air turbines and motors. One table: a new handpiece is one row of handpiece.cpp.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace kerf {

/// Response of a drive's speed to load and pedal. Laws: ToolDrive in sim/step/tool_model.h.
enum class DriveForm : int {
  kLine,     ///< free speed falls with the load in proportion; speed follows that. Saws, piezo tips
  kTurbine,  ///< air: torque falls with speed in proportion; without air only the bearing stops it
  kGoverned  ///< electric: holds its speed up to its largest torque, and brakes
};

/// True for motors; an air turbine, a saw and a piezo tip go one way.
constexpr bool turnsBackwards(DriveForm form) noexcept { return form == DriveForm::kGoverned; }

struct Handpiece {
  const char* name;         ///< as in files and after --drive: "turbine"
  const char* description;  ///< one line, for help
  DriveForm form;
  bool is_fast;            ///< for friction grip alone: a disc or a drill would burst
  double rpm;              ///< free speed; 0: 1750 over the diameter in mm, as for implant drills
  double stall_Nmm;        ///< torque at standstill (turbine) or largest torque (governed)
  double time_constant_s;  ///< kTurbine: of the spin-up; kGoverned: from standstill to free speed, and back
  double run_down_s;       ///< kTurbine: from free speed to rest, air off
  double droop;            ///< kGoverned: part of the speed lost at the largest torque
};

std::span<const Handpiece> handpieces() noexcept;
/// By its name; null if none.
const Handpiece* findHandpiece(std::string_view name) noexcept;
/// "turbine, turbine-brake, ...".
std::string handpieceNames();

}  // namespace kerf
