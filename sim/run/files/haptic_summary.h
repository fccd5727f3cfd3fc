// Results of a cut against resistance: summary.json.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "geometry/base/types.h"
#include "geometry/field/material.h"
#include "sim/run/files/cut_settings.h"
#include "sim/run/files/path_findings.h"

namespace kerf {

/// Forces in N, volumes in mm^3. Volumes are the case's, forces include all objects.
struct HapticSummary {
  std::uint64_t ticks = 0;
  double seconds = 0;
  CutSettings settings;        ///< settings of the cut
  bool is_complete = false;    ///< the virtual hand reached the end of its path
  std::string ended;           ///< why it ended
  double short_of_end_mm = 0;  ///< rest of the path, or distance from the tool to the path's end: the larger
  double coupling = 0;         ///< stiffness between hand and tool, N/mm; 0: the hand holds the tool itself
  std::string coupling_text;   ///< of a device: the same in words, and why it is not stiffer

  double removed_mm3 = 0, remaining_mm3 = 0, initial_mm3 = 0;
  double removed_uncertainty_mm3 = 0;                 ///< least uncertainty of removed_mm3: volumeUncertainty()
  std::map<std::string, double> initial_by_material;  ///< by id
  double added_mm3 = 0;
  /// Planned volume: the tool swept along the path without resistance, on the same voxels. 0 when material is added.
  double planned_mm3 = 0;
  double reached_mm3 = 0;  ///< removed part of the planned volume; the rest of removed_mm3 lies beside the plan
  std::map<std::string, double> planned_by_material;
  double farthest_off_mm = 0;                         ///< largest distance of the tip from its path
  Vec3d farthest_off_at = Vec3d::Zero();              ///< position of the tip then, mm
  std::map<std::string, double> removed_by_material;  ///< by id
  /// By id. Covered surfaces have values < 0: their edge has a new id.
  std::map<std::string, double> added_by_material;

  PathFindings findings;
  double began_inside_mm = 0;  ///< depth of the tool in the case at the start of its path; at most the field's band

  double mean_contact_force = 0, peak_contact_force = 0;  ///< mean over ticks in contact
  double peak_contact_force_s = 0;                        ///< time of the peak
  double mean_normal_load = 0, peak_hand_force = 0;
  double seconds_in_contact = 0;
  double work = 0;         ///< of the drive into the tissue, N mm
  double least_speed = 1;  ///< least fraction of the nominal speed while the drive was on and had come up to speed
  double stalled_s = 0;    ///< time at standstill or nearly (2 % of the nominal), after coming up to speed
  std::uint64_t too_fast = 0, out_of_bricks = 0, clamped = 0, clipped = 0;  ///< ticks with that status

  double hottest_c = 37, hottest_s = 0;         ///< under the tool, C, and its time
  double pulp_rise = 0, nerve_rise = 0;         ///< most, K
  double bone_limit_s = -1, pulp_limit_s = -1;  ///< when 47 C and +5.5 K were first passed, s; < 0: never
  /// From the tool's cutting part to pulp, nerve canal and neighbours ("beside_1"), if it came near; < 0: inside.
  std::map<std::string, double> least_distance_mm, least_distance_s;  ///< time of each

  /// A neighbour of the case.
  struct Neighbour {
    std::string id, case_path, case_id;  ///< "beside_1"; the path from the run
    double initial_mm3 = 0, removed_mm3 = 0;
    std::map<std::string, double> removed_by_material;
    double seconds_touched = 0;  ///< by any part of the tool, including neck and shank
    double seconds_in = 0;       ///< time with the cutting part inside the neighbour, as loaded, during a cut
    double overlap_mm3 = 0;      ///< with the case, as loaded: the tool meets both. To a layer of half a voxel
  };
  std::vector<Neighbour> beside;

  std::size_t pieces = 0, crumbs = 0;  ///< of the object at the end; crumbs: parts below 0.1 mm^3
  std::string state_hash;
};

/// summary.json.
std::string toJson(const HapticSummary& summary);

namespace internal {

using VolumeByNumber = std::array<double, 256>;  ///< mm^3, by a material's number

double sumOf(const VolumeByNumber& volumes);
/// By id; "material N" for a number that the table lacks. Omits materials without volume.
std::map<std::string, double> byMaterial(const VolumeByNumber& volumes, const MaterialTable& materials);

}  // namespace internal
}  // namespace kerf
