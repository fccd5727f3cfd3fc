// What a person sees of a surface: chunks with the colours of their tissues and of the scan, and darker where light
// hardly comes.
#pragma once

#include <filesystem>
#include <memory>

#include "geometry/base/error.h"
#include "sim/live/remesher.h"
#include "sim/live/scan_colours.h"
#include "sim/object/baked_object.h"

namespace kerf::internal {

/// An object that is looked at.
struct LookedAt {
  std::shared_ptr<const BakedObject> object;
  std::shared_ptr<const ScanColours> scan;     ///< null: the scan has no colours
  std::shared_ptr<const BrickField> original;  ///< of its case, before anything was cut; not asked without a scan
  bool is_beside = false;                      ///< greyer: it is not what is worked on
};

/// For RemesherOptions::finish, of an object and of its pieces. Keeps what it is given.
/// Error: the table of materials cannot be read.
Expected<decltype(RemesherOptions::finish)> chunkLook(LookedAt of);

/// The colours of a case's solid. Null: it has none.   Errors: as readCaseSolid().
/// @cost  that of reading the solid, 0.1 s for a jaw.
Expected<std::shared_ptr<const ScanColours>> scanColoursOf(const std::filesystem::path& case_folder);

}  // namespace kerf::internal
