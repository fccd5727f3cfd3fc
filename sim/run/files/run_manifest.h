// The manifest of a run bundle: run.toml, with the case, the tools and the results.
//
// A run bundle is a folder that holds one cutting session on a case:
//
//   run.toml     manifest: case, tool, path, result
//   tool.toml    the tool as used, with its mesh if it has one        path.csv | path.toml   the path as used
//   run.vdb      grids phi (the cut field, bricks that changed) and, geometry only, sweep (union of tool sweeps, mm);
//                beside_1, beside_2, ...: phi of the case's neighbours;
//                material: materials of the bricks in which material was added to the case (geometry/field)
//   forces.csv, summary.json, session.kerflog   after a cut against resistance: haptic_cut.h
//   begin.vdb    if it continues a run cut against resistance: run.vdb of that run
//   earlier/     if a geometry-only run continues another such run: the tools and paths of that run
//   tools/       mode session: all tools of the session, in place of tool and path
//
// run_files.h reads the other files of a bundle.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"
#include "sim/object/plane_sides.h"
#include "sim/run/files/path_findings.h"

namespace kerf {

inline constexpr const char* kRunManifest = "run.toml";
inline constexpr const char* kSawPlanFile = "saw-plan.toml";  ///< planes planned in the window, beside the manifest
inline constexpr const char* kModeGeometry = "geometry";      ///< the tool removed its swept volume
inline constexpr const char* kModeHaptic = "haptic";          ///< cut against resistance, by the 1 kHz step
inline constexpr const char* kModeSession = "session";  ///< the same by a person: many strokes, several tools, no path

struct RunManifest {
  int version = 1;
  std::string kerf_version;
  std::string case_path;  ///< relative to the run folder, or absolute
  std::string case_id;    ///< must match the case
  std::string mode = kModeGeometry;
  std::string tool_id, tool_sha256, path_file, path_sha256;
  std::size_t segments = 0;  ///< cutting motions
  double path_length_mm = 0, duration_s = 0;
  double voxel_mm = 0;
  /// 16 hexadecimal digits, hash of the sweep field or of the step's state: the same inputs give the same hash.
  std::string state_hash;
  std::string field_sha256;  ///< of run.vdb: Kerf rejects a damaged file

  /// Hash of summary.json, modes geometry and haptic: with it kerf info detects edits. Empty: an older run.
  std::string summary_sha256;

  /// Hash of begin.vdb, the cut of the earlier run that this one continues. Empty: it began with the case, or in mode
  /// geometry with `earlier`.
  std::string begin_sha256;

  /// Mode geometry: sweeps before the tool and the path above, in order. Files are in the run folder.
  struct EarlierCut {
    std::string tool_id, tool_file, tool_sha256, path_file, path_sha256;
  };
  std::vector<EarlierCut> earlier;
  /// Whether run.vdb has the union of all sweeps: mode geometry, all cut by geometry alone.
  bool hasSweep() const { return mode == kModeGeometry && begin_sha256.empty(); }

  // Mode session only. Tools are in the order of the session; tool_id names those that were in hand.
  struct ToolFile {
    std::string id, file, sha256;  ///< file: in the run folder
  };
  std::vector<ToolFile> tools;
  /// The session has not ended, or its program was killed: the log exists, but neither field nor state. recoverRun()
  /// finishes the run.
  bool is_open = false;
  /// Objects of the case at the end, if there are several or one was moved: in a session, or a cut along a path that
  /// continues such a run. In run.vdb all are where they were loaded.
  struct Piece {
    std::uint32_t id = 0;  ///< CutObject::id
    std::string name;
    std::string colour{};          ///< set by the user: PieceLabel; empty: none
    Vec3d inside = Vec3d::Zero();  ///< a point deep inside the piece, where it was loaded, mm
    double volume_mm3 = 0;         ///< counted from its nodes
    Rigid3 T_case_piece;           ///< from its loaded to its current place
    std::vector<PlaneSide> sides;  ///< plane cuts that made it, in order: export cuts the mesh by these planes
    bool isMoved() const;
  };
  std::vector<Piece> pieces;

  /// A neighbour of the case, in a path cut against resistance or a session. It stands where its scan stands.
  struct Beside {
    std::string case_path, case_id;  ///< as those of the case
    double voxel_mm = 0;
    double removed_mm3 = 0;      ///< removed volume; of an open session: before the session began
    bool has_begin = false;      ///< begin.vdb has its cut from earlier runs
    std::string name{};          ///< the user's name for it; may be empty
    double removed_now_mm3 = 0;  ///< not stored; of a geometry cut: in this run alone
  };
  std::vector<Beside> beside;  ///< the first is "beside_1": neighbourId(1)

  /// Not stored. How far a cut leaves the case's fine region, mm: it was then computed on the object's own voxels. 0:
  /// no region, or the cut stayed inside.
  double beyond_region_mm = 0;
  /// Not stored. Short motions of a geometry cut that were merged into longer sweeps, each point of the tool within the
  /// tolerance of its path; and the number of swept motions.
  std::size_t merged_motions = 0, swept_motions = 0;
  double merge_tolerance_mm = 0;
  /// Not stored. Of a geometry cut.
  PathFindings findings;
  /// Not stored. For a geometry cut between the nodes: approximate volume that the exported mesh lacks, mm^3
  /// (sim/run/sweep/thin_cut.h).
  double thin_mm3 = 0;
  /// Not stored. Pieces of the earlier run that were not found again, and thus are where they were loaded.
  std::vector<std::string> missing_pieces;
  /// Not stored. Pieces of the earlier run that this run removed completely.
  std::vector<std::string> pieces_cut_away;
  /// Not stored. Volume of unlabelled material in the earlier run that the case does not have, such as a filling, mm^3.
  /// An older Kerf cut that run and stored no materials. From here on it counts and cuts as the tissue around it.
  double added_before_mm3 = 0;
  /// Not stored. Voxel size of the earlier run, mm, if finer than this run's: its cut is resampled to the coarser
  /// voxels here. 0: not finer.
  double finer_before_mm = 0;
  /// In summary.json. Removed volume of a geometry cut by material id, counted on the object's own voxels.
  std::map<std::string, double> removed_by_material;
};

/// Whether the folder holds a manifest, valid or not.
bool isRun(const std::filesystem::path& folder);

/// Also reads a session that has not ended. Errors, with file and key: kNotFound without a manifest, kUnsupported for
/// another format or version, and for values that are missing, unknown or out of range.
Expected<RunManifest> readRunManifest(const std::filesystem::path& folder);

/// Writes run.toml; it appears whole or not at all. @param folder  exists.   Error: kWriteFailed.
Expected<void> writeRunManifest(const std::filesystem::path& folder, const RunManifest& manifest);

/// Error kUnsupported: a session that has not ended; it has nothing but its log.
Expected<void> requireEnded(const std::filesystem::path& folder, const RunManifest& manifest);

}  // namespace kerf
