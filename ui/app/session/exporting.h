// From a session to files for the printer. Places and checks the pieces, writes them, then reads back, compares and
// checks the files.
//
// Long work without a thread of its own: the workbench calls it in a job.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "geometry/case/object_names.h"
#include "geometry/mesh/mesh.h"
#include "geometry/mesh/mesh_check.h"
#include "sim/run/session/live_run.h"

namespace kerf {

/// Selection of an export.
struct ExportChoice {
  bool is_put_back = false;              ///< pieces at their loaded poses, without moves
  bool is_each = false;                  ///< a file per piece: NAME-PIECE.stl instead of NAME.stl
  std::vector<std::uint32_t> only = {};  ///< some pieces, in one file
  std::size_t beside = 0;                ///< number of a neighbour to export; 0: the worked-on object

  /// Contains all pieces of the worked-on object.
  bool isWhole() const { return only.empty() && beside == 0; }

  bool operator==(const ExportChoice&) const = default;
};

/// Content of one file.
struct ExportPart {
  std::string piece{};               ///< its name; empty: all in one
  Mesh mesh{};                       ///< as written
  MeshReport report{};               ///< of checkMesh(), as in `kerf check`
  bool is_met = false;               ///< not ready, though each piece is: they touch, or the moved pieces intersect
  std::size_t touching = 0;          ///< of them: pieces that share a cut face, as countTouching()
  std::vector<NamedPart> objects{};  ///< of pieces; empty: as in PreparedExport::names

  /// A sentence: ready to print or not, and the remedy.
  std::string verdict() const;
};

/// An export before writing.
struct PreparedExport {
  std::vector<ExportPart> parts{};  ///< one per file
  ObjectNames names{};              ///< of the case
  bool is_each = false;             ///< file names contain the piece names
  double removed_mm3 = 0;
  std::size_t vertices_kept = 0;      ///< vertices of the solid kept bit for bit
  std::size_t pieces = 0, moved = 0;  ///< of the object

  bool isReady() const;
  /// Files of the parts.   @param file  the chosen file; its ending is the format.
  std::vector<std::filesystem::path> filesFor(const std::filesystem::path& file) const;
  /// "removed 17.915 mm3, 26954 vertices of the solid kept bit for bit"
  std::string summary() const;
};

struct WrittenExport {
  std::vector<std::filesystem::path> files;
  bool is_ready = false;  ///< as read back
  std::string text;       ///< for the user: files written, and whether they are ready to print
};

/// Makes and checks the meshes of a scene copy.
/// Errors: those of LiveRun::postOperative() and placedPieces(); kNotFound: no such piece.
/// @cost  postOperative(), and checkMesh() for each part.
Expected<PreparedExport> prepareExport(const LiveRun& run, const SceneCopy& scene, const ExportChoice& choice,
                                       const Progress& progress = {});

/// Writes the files, reads them back, compares and checks. It first verifies that all files are writable and that none
/// is a scan.   Error kWriteFailed, kBadValue; the hint lists files already written.
Expected<WrittenExport> writeExport(const PreparedExport& prepared, const LiveRun& run,
                                    const std::filesystem::path& file);

}  // namespace kerf
