// From a session to files for the printer: pieces put where they are, written, read back, compared and checked.
//
// Long work without a thread of its own: the workbench calls it in a job.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "geometry/base/error.h"
#include "geometry/base/progress.h"
#include "sim/run/live_run.h"

namespace kerf {

/// What of an object in pieces is exported.
struct ExportChoice {
  bool is_put_back = false;                ///< pieces where they were loaded, wherever they were moved to
  bool is_each = false;                    ///< a file a piece: NAME-PIECE.stl in the place of NAME.stl
  std::optional<std::uint32_t> only = {};  ///< one piece
  std::size_t beside = 0;                  ///< not the object that is worked on: the neighbour of that number
};

/// Writes what a copy of a scene holds.   @param file  its ending is the format.
/// @return  what was written, and whether it can be printed: a sentence for the user.
/// Errors: those of LiveRun::postOperative() and placedPieces(); kNotFound: there is no such piece; kWriteFailed.
Expected<std::string> exportScene(const LiveRun& run, const SceneCopy& scene, const std::filesystem::path& file,
                                  const ExportChoice& choice, const Progress& progress = {});

}  // namespace kerf
