// Preview mesh of the import: in mm, coloured, with the inside of open parts.
#pragma once

#include "geometry/mesh/mesh.h"
#include "ui/app/import/import_set.h"

namespace kerf {

/// All parts of the picture in one mesh. Several parts have colours per triangle; neighbours are paler. An open part
/// has each triangle a second time, reversed, in the inside colour, because the renderer draws front faces only.
/// @return  without colours if the only part is closed and has none.   @cost  copies; for a job.
Mesh meshOf(const ImportPicture& picture);

}  // namespace kerf
