// The manifest of a run bundle: run.toml, which says what was cut, with what, and what came of it.
//
// A run bundle is a folder that holds one cutting session on a case:
//
//   run.toml     manifest: case, tool, path, result
//   tool.toml    the tool as used, with its mesh if it has one        path.csv | path.toml   the path as used
//   run.vdb      grids phi (the cut field, bricks that changed) and, geometry only, sweep (union of tool sweeps, mm);
//                beside_1, beside_2, ...: phi of further cases that stood beside the one that was cut;
//                material: where something was added to the case, what its bricks are of (geometry/field)
//   forces.csv, summary.json, session.kerflog   of a cut against resistance: haptic_cut.h
//   begin.vdb    of one that went on from a run cut against resistance: what that one left, its run.vdb
//   earlier/     of one cut by geometry alone that went on from such a run: the tools and paths of that
//   tools/       mode session: in place of tool and path, all tools of the session
//
// run_files.h reads what lies beside the manifest.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/types.h"
#include "sim/run/path_findings.h"

namespace kerf {

inline constexpr const char* kRunManifest = "run.toml";
inline constexpr const char* kModeGeometry = "geometry";  ///< the tool removed whatever it swept
inline constexpr const char* kModeHaptic = "haptic";      ///< cut against resistance, by the 1 kHz step
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
  /// 16 hexadecimal digits, of the sweep field or of the state of the step: the same inputs give the same hash.
  std::string state_hash;
  std::string field_sha256;  ///< of run.vdb: a damaged file is refused

  /// Of summary.json, modes geometry and haptic: kerf info says when it was edited since. Empty: an older run.
  std::string summary_sha256;

  /// Of begin.vdb: what an earlier run had cut, from which this one went on. Empty: it began with the case, or in mode
  /// geometry with `earlier`.
  std::string begin_sha256;

  /// Mode geometry: what was swept before the tool and the path above, the first first. Files are in the run folder.
  struct EarlierCut {
    std::string tool_id, tool_file, tool_sha256, path_file, path_sha256;
  };
  std::vector<EarlierCut> earlier;
  /// Of mode geometry, the union of all sweeps is in run.vdb: all was cut by geometry alone.
  bool hasSweep() const { return mode == kModeGeometry && begin_sha256.empty(); }

  // Mode session only. Its tools stand in the order of the session's; tool_id names those that were in hand.
  struct ToolFile {
    std::string id, file, sha256;  ///< file: in the run folder
  };
  std::vector<ToolFile> tools;
  /// The session has not ended, or its program has: there is the log, and neither field nor state. recoverRun()
  /// finishes it.
  bool is_open = false;
  /// Objects that the case was in at the end, when there are several or one was moved: of a session, and of a cut along
  /// a path that goes on from a run that had such. In run.vdb all are where they were loaded.
  struct Piece {
    std::uint32_t id = 0;  ///< CutObject::id
    std::string name;
    std::string colour{};          ///< that a person gave it: PieceLabel; empty: none
    Vec3d inside = Vec3d::Zero();  ///< a point deep inside of it, where it was loaded, mm
    double volume_mm3 = 0;         ///< as its nodes count
    Rigid3 T_case_piece;           ///< from where it was loaded to where it is
    bool isMoved() const;
  };
  std::vector<Piece> pieces;

  /// A further case of the same scene, of a path cut against resistance or of a session. It stood where its scan
  /// stands.
  struct Beside {
    std::string case_path, case_id;  ///< as those of the case
    double voxel_mm = 0;
    double removed_mm3 = 0;      ///< what was cut off it; of a session that is open, before that began
    bool has_begin = false;      ///< begin.vdb has what was cut off it before
    std::string name{};          ///< what a person called it; may be empty
    double removed_now_mm3 = 0;  ///< not stored; of a geometry cut: of this run alone
  };
  std::vector<Beside> beside;  ///< the first is "beside_1": neighbourId(1)

  /// Not stored. A cut that left the case's fine region was computed on the object's own voxels: so far, in mm, it
  /// reaches out of the region. 0: there is no region, or the cut stayed inside.
  double beyond_region_mm = 0;
  /// Not stored. Short motions of a geometry cut that were swept as parts of longer ones, each point of the tool within
  /// the tolerance of where the path leads it; and how many motions were swept.
  std::size_t merged_motions = 0, swept_motions = 0;
  double merge_tolerance_mm = 0;
  /// Not stored. Of a geometry cut.
  PathFindings findings;
  /// Not stored. Of a geometry cut that no node counts: about the volume that the exported mesh lacks, mm^3
  /// (sim/run/thin_cut.h).
  double thin_mm3 = 0;
  /// Not stored. Pieces of the run it goes on from that were not found again, and so are where they were loaded.
  std::vector<std::string> missing_pieces;
  /// Not stored. Pieces of that run of which this one left nothing.
  std::vector<std::string> pieces_cut_away;
  /// Not stored. Material that stood there already and that the case does not have, as a filling, of a run of an older
  /// Kerf, which kept where material is and not which, mm^3. From here on it counts and cuts as the tissue around it.
  double added_before_mm3 = 0;
  /// Not stored. Voxels of that run, mm, where they were finer than those of this one, so that its cut, too, is on the
  /// coarser ones here; 0: they were not.
  double finer_before_mm = 0;
  /// In summary.json. What a geometry cut took off, by a material's id, counted on the object's own voxels.
  std::map<std::string, double> removed_by_material;
};

/// Whether the folder holds a manifest; what is in it is not checked.
bool isRun(const std::filesystem::path& folder);

/// Also of a session that has not ended. Errors, naming file and key: kNotFound without a manifest, kUnsupported for
/// another format or version, and values that are missing, unknown or out of range.
Expected<RunManifest> readRunManifest(const std::filesystem::path& folder);

/// Writes run.toml, which appears whole or not at all. @param folder  exists.   Error: kWriteFailed.
Expected<void> writeRunManifest(const std::filesystem::path& folder, const RunManifest& manifest);

/// Error kUnsupported: a session that has not ended, and so has nothing but its log.
Expected<void> requireEnded(const std::filesystem::path& folder, const RunManifest& manifest);

}  // namespace kerf
