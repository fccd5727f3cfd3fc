// Cutting a case against resistance without a person: the 1 kHz step in lockstep, held by a virtual hand.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "geometry/base/progress.h"
#include "sim/hand/virtual_hand.h"
#include "sim/run/run_bundle.h"

namespace kerf {

enum class HandKind {
  kFeed,   ///< follows the path in its time, whatever the force
  kForce,  ///< pushes along the path with constant force
  kDevice  ///< a simulated force-feedback device whose hand follows the path
};

struct HapticCutOptions {
  bool overwrite = false;
  HandKind hand = HandKind::kFeed;
  ForceHand::Options force;
  DeviceHand::Options device;
  StepSettings step;        ///< `rendering` is set by the hand: rigid for kFeed (penalty only), coupled for the others
  double spindle = 1;       ///< 0 to 1 of the tool's nominal speed
  double time_limit = 600;  ///< s of simulated time
  bool with_sound = false;  ///< writes sound.wav, too: what the tool is heard to do
  std::string add;          ///< id of a material: the tool adds it where it goes, instead of cutting; empty: it cuts
  /// Further cases, each where its scan stands, in the frame of the case: the tool collides with them, and cuts them.
  std::vector<std::filesystem::path> beside;
};

/// What a session came to; every force in N, volume mm^3. Volumes are the case's, forces of all that the tool met.
struct HapticSummary {
  std::uint64_t ticks = 0;
  double seconds = 0;
  bool is_complete = false;  ///< the hand came to the end of its path
  std::string ended;         ///< why it ended
  double removed_mm3 = 0, remaining_mm3 = 0, initial_mm3 = 0;
  double added_mm3 = 0;
  std::map<std::string, double> removed_by_material;      ///< by id
  std::map<std::string, double> added_by_material;        ///< of a surface that was covered < 0: its edge has a new id
  double mean_contact_force = 0, peak_contact_force = 0;  ///< mean over ticks in contact
  double mean_normal_load = 0, peak_hand_force = 0;
  double seconds_in_contact = 0;
  double work = 0;         ///< of the drive into the tissue, N mm
  double least_speed = 1;  ///< of the nominal while it was on and had come up to speed
  std::uint64_t too_fast = 0, out_of_bricks = 0, clamped = 0, clipped = 0;  ///< ticks with that status
  double hottest_c = 37;                                                    ///< under the tool, C
  double pulp_rise = 0;                                                     ///< most, K
  double bone_limit_s = -1, pulp_limit_s = -1;  ///< when 47 C and +5.5 K were first passed, s; < 0: never
  /// Of what cuts of the tool to pulp, nerve canal and the cases beside ("beside_1"), if it came near; < 0: in it.
  std::map<std::string, double> least_distance_mm;
  struct Neighbour {
    std::string id, case_path, case_id;  ///< "beside_1"; the path from the run
    double initial_mm3 = 0, removed_mm3 = 0;
    std::map<std::string, double> removed_by_material;
    double seconds_touched = 0;  ///< by any part of the tool, neck and shank, too
    double seconds_in = 0;       ///< for so long what cuts was in it, as it was loaded, while something was cut
    double overlap_mm3 = 0;      ///< with the case, as loaded: there the tool meets both. To a layer of half a voxel
  };
  std::vector<Neighbour> beside;
  std::size_t pieces = 0, crumbs = 0;  ///< what the object fell into, parts below 0.1 mm^3 apart
  std::string state_hash;
};

/// summary.json.
std::string toJson(const HapticSummary& summary);

struct HapticCut {
  RunManifest manifest;
  HapticSummary summary;
  bool left_region_unused = false;  ///< the case has a finer region, which this does not use
};

/// Writes the run (docs/reference/file-formats.md): run.toml, run.vdb (grid phi), forces.csv (one row a tick),
/// summary.json, session.kerflog (what kerf replay reads), sound.wav if asked for (48 kHz, 1 MB in 11 s).
/// Same inputs, same bytes (but for the identifier inside run.vdb).
///
/// Errors: as cutCase; kEmpty when nothing of the case was cut; kBadValue for options out of range, and for a case that
/// is given twice; kNotFound for a material of a case that the table of materials no longer has.
Expected<HapticCut> cutCaseByHand(const std::filesystem::path& case_folder, const std::filesystem::path& tool_file,
                                  const std::filesystem::path& path_file, const std::filesystem::path& run_folder,
                                  const HapticCutOptions& options = {}, const Progress& progress = {});

}  // namespace kerf
