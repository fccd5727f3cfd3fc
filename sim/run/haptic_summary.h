// What a cut against resistance came to: summary.json.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/field/material.h"
#include "sim/run/cut_settings.h"
#include "sim/run/path_findings.h"

namespace kerf {

/// Every force in N, volume mm^3. Volumes are the case's, forces of all that the tool met.
struct HapticSummary {
  std::uint64_t ticks = 0;
  double seconds = 0;
  CutSettings settings;        ///< with what it was cut
  bool is_complete = false;    ///< the virtual hand came to the end of its path
  std::string ended;           ///< why it ended
  double short_of_end_mm = 0;  ///< of the path that was not gone, or from the tool to the path's end: the larger
  double coupling = 0;         ///< stiffness between hand and tool, N/mm; 0: the hand holds the tool itself
  std::string coupling_text;   ///< of a device: the same in words, and why it is no stiffer

  double removed_mm3 = 0, remaining_mm3 = 0, initial_mm3 = 0;
  double removed_uncertainty_mm3 = 0;                 ///< least uncertainty of removed_mm3: volumeUncertainty()
  std::map<std::string, double> initial_by_material;  ///< by id
  double added_mm3 = 0;
  /// What the path asks for: the tool swept along it without resistance, on the same voxels. 0 when material is added.
  double planned_mm3 = 0;
  double reached_mm3 = 0;  ///< what of that was removed; removed_mm3 less this lies beside the plan
  std::map<std::string, double> planned_by_material;
  double farthest_off_mm = 0;                         ///< of the tip from its path, most
  Vec3d farthest_off_at = Vec3d::Zero();              ///< where the tip was then, mm
  std::map<std::string, double> removed_by_material;  ///< by id
  /// By id. Of a surface that was covered < 0: its edge has a new id.
  std::map<std::string, double> added_by_material;

  PathFindings findings;
  double began_inside_mm = 0;  ///< how deep the tool was in the case where its path begins; at most the field's band

  double mean_contact_force = 0, peak_contact_force = 0;  ///< mean over ticks in contact
  double peak_contact_force_s = 0;                        ///< when
  double mean_normal_load = 0, peak_hand_force = 0;
  double seconds_in_contact = 0;
  double work = 0;         ///< of the drive into the tissue, N mm
  double least_speed = 1;  ///< of the nominal while it was on and had come up to speed
  double stalled_s = 0;    ///< how long it stood still, or nearly (2 % of the nominal), after it had come up to speed
  std::uint64_t too_fast = 0, out_of_bricks = 0, clamped = 0, clipped = 0;  ///< ticks with that status

  double hottest_c = 37, hottest_s = 0;         ///< under the tool, C, and when
  double pulp_rise = 0, nerve_rise = 0;         ///< most, K
  double bone_limit_s = -1, pulp_limit_s = -1;  ///< when 47 C and +5.5 K were first passed, s; < 0: never
  /// From what cuts of the tool to pulp, nerve canal and the cases beside ("beside_1"), if it came near; < 0: in it.
  std::map<std::string, double> least_distance_mm, least_distance_s;  ///< and when

  /// A further case of the scene.
  struct Neighbour {
    std::string id, case_path, case_id;  ///< "beside_1"; the path from the run
    double initial_mm3 = 0, removed_mm3 = 0;
    std::map<std::string, double> removed_by_material;
    double seconds_touched = 0;  ///< by any part of the tool, neck and shank, too
    double seconds_in = 0;       ///< for so long what cuts was in it, as it was loaded, while something was cut
    double overlap_mm3 = 0;      ///< with the case, as loaded: there the tool meets both. To a layer of half a voxel
  };
  std::vector<Neighbour> beside;

  std::size_t pieces = 0, crumbs = 0;  ///< what the object split into, parts below 0.1 mm^3 apart
  std::string state_hash;
};

/// summary.json.
std::string toJson(const HapticSummary& summary);

namespace internal {

using VolumeByNumber = std::array<double, 256>;  ///< mm^3, by a material's number

double sumOf(const VolumeByNumber& volumes);
/// By id; of a number that the table lacks "material N". Materials without volume are left out.
std::map<std::string, double> byMaterial(const VolumeByNumber& volumes, const MaterialTable& materials);

}  // namespace internal
}  // namespace kerf
