// What is imported as one mesh to be drawn: in mm, coloured, with the inside of what is open.
#pragma once

#include "geometry/mesh/mesh.h"
#include "ui/app/import_set.h"

namespace kerf {

/// All parts of the picture in one mesh. Of several each triangle has its colour; what stands beside is paler. An open
/// part has its triangles twice, the second time turned round in the colour of an inside: the renderer draws what
/// faces the viewer.
/// @return  without colours, if there is but one part, it has none, and it is closed.   @cost  copies; for a job.
Mesh meshOf(const ImportPicture& picture);

}  // namespace kerf
