// The motions of blades: one row each, with all data that depends on the motion.
//
// A new motion is one source with its functions and its row, and one word in the list of blade_motion.cpp; see
// CONTRIBUTING.md. Required members are references, so that an incomplete row does not compile.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "geometry/mesh/mesh.h"

namespace kerf {

class TomlTable;
struct DriveNumbers;
struct Tool;

/// Motion of the cutting part relative to the hand. Cutting takes the mean over a cycle.
enum class ToolMotion {
  kSpin,    ///< about the tool's z axis, clockwise seen from the shank
  kStroke,  ///< to and fro along z
  kSwing    ///< to and fro about a pivot on the z axis at the height blade_length_mm, in the plane y = 0
};

/// Keys of a tool file for the speed of its drive and its stall load.
struct DriveKeys {
  const char* speed;       ///< key: "speed_rpm"
  double low, high;        ///< range of the speed, in `unit`
  double per_second;       ///< turns or cycles a second of one unit
  const char* unit;        ///< "rpm"
  const char* stall;       ///< key: "stall_torque_Nmm"
  const char* stall_unit;  ///< "N mm"
};
/// For burs, drills and discs.
inline constexpr DriveKeys kTurns{"speed_rpm", 1, 1e6, 1.0 / 60, "rpm", "stall_torque_Nmm", "N mm"};

struct BladeMotion {
  // --- The tool file ---
  const char* name;                   ///< as in files: "sagittal"
  const char* also_called;            ///< common synonym, corrected by a message; "" if none
  std::span<const char* const> keys;  ///< beside motion, thickness and set_per_side
  const DriveKeys& drive_keys;
  /// Reads the keys and makes cut, body and plunge_direction. Errors stay in `top`.
  /// @pre thickness_mm and set_per_side_mm are read.
  void (&read)(TomlTable& top, Tool& tool);

  // --- Cutting ---
  ToolMotion form;
  /// See plungeVolume(): from the numbers alone, mm^3. @pre depth_mm > 0.
  double (&plunge_volume)(const Tool& tool, double depth_mm, double window_mm);
  /// Axis along which the same edge may be longer than a test block is wide: plunge_volume() then counts its window.
  /// -1: the edge differs along its length and is tested as a whole.
  int edge_axis;

  // --- Words and pictures ---
  std::string (&describe)(const Tool& tool);  ///< one line of describe(), without thickness and kerf
  /// The numbers of `kerf tool info --json` beside those of every blade, by key.
  std::vector<std::pair<const char*, double>> (&numbers)(const Tool& tool);
  Mesh (&mesh)(const Tool& tool, double tolerance_mm);  ///< see toolMesh()
  std::string (&drawing)(const Tool& tool);             ///< see toolDrawing()

  // --- Drive and sound ---
  /// Travel of one cycle, one way: mm (kStroke) or rad (kSwing); a turn for a disc.
  double (&way)(const Tool& tool);
  /// Teeth that pass a place on the bone in one way, or in a turn; 0 if the pitch is unknown.
  double (&teeth)(const Tool& tool);
  /// Training defaults, each with its source; a disc has none and uses the drive of a bur of its size.
  DriveNumbers (&usual_drive)(const Tool& tool);
};

/// All motions, in the order in which messages name them.
std::span<const BladeMotion* const> bladeMotions();
/// By its name in files; null if none.
const BladeMotion* findBladeMotion(const std::string& name);

}  // namespace kerf
