// Cuts a case against resistance without a person: the 1 kHz step in lockstep, with a virtual hand that holds the tool.
//
// Four phases: load (cut_scene.h), simulate, summarise (haptic_summary.h), write. Observers receive every tick:
// cut_observer.h.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/progress.h"
#include "sim/hand/virtual_hand.h"
#include "sim/run/files/haptic_summary.h"
#include "sim/run/files/run_manifest.h"

namespace kerf {

struct HapticCutOptions {
  bool overwrite = false;
  HandKind hand = HandKind::kFeed;
  ForceHand::Options force;
  DeviceHand::Options device;
  StepSettings step;         ///< the hand sets `rendering`: rigid for kFeed (penalty only), coupled for the others
  std::string drive;         ///< name of a Handpiece instead of the tool's own; empty: its own
  double spindle = 1;        ///< 0 to 1 of the tool's nominal speed
  bool is_reversed = false;  ///< the drive turns backwards, if its motor can
  double irrigation = 1;     ///< 0 to 1 of the cooling spray
  double time_limit = 600;   ///< s of simulated time
  bool with_sound = false;   ///< also writes sound.wav, the sound of the tool
  std::string add;           ///< id of a material that the tool adds instead of cutting; empty: the tool cuts
  /// Further cases, each at its scan's place in the frame of the case: the tool collides with them and cuts them.
  std::vector<std::filesystem::path> beside;
};

struct HapticCut {
  RunManifest manifest;
  HapticSummary summary;
  bool left_region_unused = false;  ///< the case has a finer region; this cut does not use it
};

/// Rejects options that are out of range or contradict each other. The error's place is the option of `kerf cut`, if
/// any.
Expected<void> checkOptions(const HapticCutOptions& options);

/// @param case_folder  or an ended run: the new run continues its cut and contains both.
///   Its pieces are apart from the beginning, where they were put. The path is in the world frame, which is the frame
///   of unmoved pieces. Its neighbours stand there again, in their last state, before `options.beside`. The summary
///   counts from the end of the earlier run. Distances to pulp and nerve canal refer to the largest piece, and
///   `options.add` adds to that piece. Error kUnsupported for an open run.
/// Writes the run (docs/reference/file-formats.md): run.toml, run.vdb (grid phi), forces.csv (one row a tick),
/// summary.json, session.kerflog (for kerf replay), sound.wav on request (48 kHz, 1 MB in 11 s).
/// Same inputs, same bytes (except for the identifier inside run.vdb).
///
/// Errors: as cutCase; kEmpty when nothing of the case was cut; kBadValue for options out of range, for a case given
/// twice, and for a handpiece of a tool that does not turn; kNotFound for a material of a case that the table of
/// materials no longer has.
Expected<HapticCut> cutCaseByHand(const std::filesystem::path& case_folder, const std::filesystem::path& tool_file,
                                  const std::filesystem::path& path_file, const std::filesystem::path& run_folder,
                                  const HapticCutOptions& options = {}, const Progress& progress = {});

}  // namespace kerf
