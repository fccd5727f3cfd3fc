// Cutting a case against resistance without a person: the 1 kHz step in lockstep, with a virtual hand that holds the
// tool.
//
// Four phases: load (cut_scene.h), simulate, summarise (haptic_summary.h), write. Whoever is told of every tick is an
// observer: cut_observer.h.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/base/progress.h"
#include "sim/hand/virtual_hand.h"
#include "sim/run/haptic_summary.h"
#include "sim/run/run_manifest.h"

namespace kerf {

struct HapticCutOptions {
  bool overwrite = false;
  HandKind hand = HandKind::kFeed;
  ForceHand::Options force;
  DeviceHand::Options device;
  StepSettings step;         ///< `rendering` is set by the hand: rigid for kFeed (penalty only), coupled for the others
  std::string drive;         ///< name of a Handpiece in place of the tool's own; empty: its own
  double spindle = 1;        ///< 0 to 1 of the tool's nominal speed
  bool is_reversed = false;  ///< the drive turns backwards: a motor can
  double irrigation = 1;     ///< 0 to 1 of the cooling spray
  double time_limit = 600;   ///< s of simulated time
  bool with_sound = false;   ///< also writes sound.wav, the sound of the tool
  std::string add;           ///< id of a material: the tool adds it where it goes, instead of cutting; empty: it cuts
  /// Further cases, each where its scan stands, in the frame of the case: the tool collides with them, and cuts them.
  std::vector<std::filesystem::path> beside;
};

struct HapticCut {
  RunManifest manifest;
  HapticSummary summary;
  bool left_region_unused = false;  ///< the case has a finer region, which this does not use
};

/// Refuses options that are out of range, or contradict each other; the error's place is the name of the option of
/// `kerf cut`, where it has one.
Expected<void> checkOptions(const HapticCutOptions& options);

/// @param case_folder  or a run that has ended: its case is cut further, and the new run has all that was cut in both.
///   Its pieces are apart from the beginning, and where they were put: the path goes by the world, which is the frame
///   of what was not moved. What stood beside it stands there again, as it was left, before `options.beside`. The
///   summary counts from where the earlier run ended; distances to pulp and nerve canal go by the largest piece, and
///   `options.add` adds to that. Error kUnsupported for one that is open.
/// Writes the run (docs/reference/file-formats.md): run.toml, run.vdb (grid phi), forces.csv (one row a tick),
/// summary.json, session.kerflog (what kerf replay reads), sound.wav if asked for (48 kHz, 1 MB in 11 s).
/// Same inputs, same bytes (but for the identifier inside run.vdb).
///
/// Errors: as cutCase; kEmpty when nothing of the case was cut; kBadValue for options out of range, for a case that
/// is given twice, and for a handpiece of a tool that does not turn; kNotFound for a material of a case that the table
/// of materials no longer has.
Expected<HapticCut> cutCaseByHand(const std::filesystem::path& case_folder, const std::filesystem::path& tool_file,
                                  const std::filesystem::path& path_file, const std::filesystem::path& run_folder,
                                  const HapticCutOptions& options = {}, const Progress& progress = {});

}  // namespace kerf
