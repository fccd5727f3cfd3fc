// Appearance of a surface: chunks with the colours of their tissues and of the scan, darker where little light comes.
#pragma once

#include <filesystem>
#include <memory>

#include "geometry/base/error.h"
#include "sim/live/remesher.h"
#include "sim/live/scan_colours.h"
#include "sim/object/baked_object.h"

namespace kerf::internal {

/// An object to be displayed.
struct LookedAt {
  std::shared_ptr<const BakedObject> object;
  std::shared_ptr<const ScanColours> scan;     ///< null: the scan has no colours
  std::shared_ptr<const BrickField> original;  ///< of its case, before any cut; unused without a scan
  bool is_beside = false;                      ///< greyer: a neighbour of the case
};

/// For RemesherOptions::finish, of an object and its pieces. Keeps its argument. Error: the table of materials cannot
/// be read.
Expected<decltype(RemesherOptions::finish)> chunkLook(LookedAt of);

/// The colours of a case's solid. Null: none.   Errors: as readCaseSolid().
/// @cost  reads the solid: 0.1 s for a jaw.
Expected<std::shared_ptr<const ScanColours>> scanColoursOf(const std::filesystem::path& case_folder);

}  // namespace kerf::internal
