// From a session to files for the printer: pieces put where they are and checked; then written, read back, compared and
// checked again.
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
#include "sim/run/live_run.h"

namespace kerf {

/// What of an object in pieces is exported.
struct ExportChoice {
  bool is_put_back = false;                ///< pieces where they were loaded, wherever they were moved to
  bool is_each = false;                    ///< a file a piece: NAME-PIECE.stl in the place of NAME.stl
  std::optional<std::uint32_t> only = {};  ///< one piece
  std::size_t beside = 0;                  ///< not the object that is worked on: the neighbour of that number

  /// All pieces of what is worked on are in it.
  bool isWhole() const { return !only && beside == 0; }

  bool operator==(const ExportChoice&) const = default;
};

/// What goes into one file.
struct ExportPart {
  std::string piece{};  ///< its name; empty: all in one
  Mesh mesh{};          ///< as it would be written
  MeshReport report{};  ///< of checkMesh(): what `kerf check` says of it
  bool is_met =
      false;  ///< not ready, though each of its pieces is: they reach into each other where they were moved to
  std::vector<NamedPart> objects{};  ///< of pieces; empty: as PreparedExport::names has them

  /// A sentence: whether it can be printed, and what to do about it.
  std::string verdict() const;
};

/// What an export would write, before anything is written.
struct PreparedExport {
  std::vector<ExportPart> parts{};  ///< a file each
  ObjectNames names{};              ///< of the case
  bool is_each = false;             ///< files have the names of their pieces
  double removed_mm3 = 0;
  std::size_t vertices_kept = 0;      ///< of the solid, bit for bit
  std::size_t pieces = 0, moved = 0;  ///< of the object

  bool isReady() const;
  /// Where the parts go.   @param file  as asked for: its ending is the format.
  std::vector<std::filesystem::path> filesFor(const std::filesystem::path& file) const;
  /// "removed 17.915 mm3, 26954 vertices of the solid kept bit for bit"
  std::string summary() const;
};

struct WrittenExport {
  std::vector<std::filesystem::path> files;
  bool is_ready = false;  ///< as read back
  std::string text;       ///< what was written, and whether it can be printed: for the user
};

/// What a copy of a scene holds, checked.
/// Errors: those of LiveRun::postOperative() and placedPieces(); kNotFound: there is no such piece.
/// @cost  of postOperative(), and of checkMesh() for each part.
Expected<PreparedExport> prepareExport(const LiveRun& run, const SceneCopy& scene, const ExportChoice& choice,
                                       const Progress& progress = {});

/// Writes it, reads it back, compares and checks what was read. Nothing is written before all files are known to be
/// writable, and none of them a scan.   Error kWriteFailed, kBadValue; it names what was written before.
Expected<WrittenExport> writeExport(const PreparedExport& prepared, const LiveRun& run,
                                    const std::filesystem::path& file);

}  // namespace kerf
